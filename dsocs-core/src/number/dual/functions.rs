//! Functions of dual numbers.
//!
//! A value is the function of the value part, in the end that of `f64`. A derivative is written so that no
//! intermediate result overflows before it does itself, and in dual numbers again where these are nested.

use super::{Dual, Part, part};
use crate::number::real::Real;

/// `1/(1 + x²)`, also where `x²` overflows.
fn lorentz<D: Part>(x: D) -> D {
    if x.re().abs() <= 1.0 {
        (x * x + 1.0).recip()
    } else {
        let r = x.recip();
        r * r / (r * r + 1.0)
    }
}

/// `1 − x²`, without cancellation in it or its derivative.
fn below_one<D: Part>(x: D) -> D {
    if x.re().abs() <= 0.5 {
        -(x * x) + 1.0
    } else {
        (-x + 1.0) * (x + 1.0)
    }
}

impl<D: Part> Dual<D> {
    /// The derivative of `atan2`, written in the quotient of the smaller argument by the larger.
    fn angle(y: Self, x: Self) -> D {
        if x.re().abs() >= y.re().abs() {
            let slope = y.re / x.re;
            (y.eps - part(x.eps, || slope)) / (x.re * (slope * slope + 1.0))
        } else {
            let slope = x.re / y.re;
            (part(y.eps, || slope) - x.eps) / (y.re * (slope * slope + 1.0))
        }
    }
}

impl<D: Part> Real for Dual<D> {
    fn re(self) -> f64 {
        self.re.re()
    }

    fn abs(self) -> Self {
        // a jet records that the sign decides
        if self.re.signum().re() < 0.0 { -self } else { self }
    }

    fn piece(self, places: &[f64]) -> usize {
        self.re.piece(places)
    }

    fn signum(self) -> Self {
        Self::constant(self.re.signum())
    }

    fn recip(self) -> Self {
        let value = self.re.recip();
        self.chain(value, || -(value * value))
    }

    fn powi(self, exponent: i32) -> Self {
        match exponent {
            0 => Self::one(),
            1 => self,
            n => self.chain(self.re.powi(n), || {
                self.re.powi(n.saturating_sub(1)) * f64::from(n)
            }),
        }
    }

    #[allow(clippy::float_cmp)] // these very exponents
    fn powf(self, exponent: f64) -> Self {
        if exponent == 0.0 {
            Self::one()
        } else if exponent == 1.0 {
            self
        } else {
            self.chain(self.re.powf(exponent), || self.re.powf(exponent - 1.0) * exponent)
        }
    }

    fn powd(self, exponent: Self) -> Self {
        if exponent.eps.vanishes() && (exponent.re - exponent.re()).vanishes() {
            return self.powf(exponent.re());
        }
        let value = self.re.powd(exponent.re);
        let by_base = part(self.eps, || self.re.powd(exponent.re - 1.0) * exponent.re);
        let by_exponent = part(exponent.eps, || {
            if self.re() == 0.0 && exponent.re() > 0.0 {
                D::zero() // xᵖ ln x tends to 0
            } else {
                value * self.re.ln()
            }
        });
        Self::new(value, by_base + by_exponent)
    }

    fn sqrt(self) -> Self {
        let value = self.re.sqrt();
        self.chain(value, || value.recip() * 0.5)
    }

    fn cbrt(self) -> Self {
        let value = self.re.cbrt();
        self.chain(value, || (value * value * 3.0).recip())
    }

    fn exp(self) -> Self {
        let value = self.re.exp();
        self.chain(value, || value)
    }

    fn exp2(self) -> Self {
        let value = self.re.exp2();
        self.chain(value, || value * core::f64::consts::LN_2)
    }

    fn exp_m1(self) -> Self {
        self.chain(self.re.exp_m1(), || self.re.exp())
    }

    fn ln(self) -> Self {
        self.chain(self.re.ln(), || self.re.recip())
    }

    fn log(self, base: f64) -> Self {
        self.chain(self.re.log(base), || self.re.recip() / base.ln())
    }

    fn log2(self) -> Self {
        self.chain(self.re.log2(), || self.re.recip() / core::f64::consts::LN_2)
    }

    fn log10(self) -> Self {
        self.chain(self.re.log10(), || self.re.recip() / core::f64::consts::LN_10)
    }

    fn ln_1p(self) -> Self {
        self.chain(self.re.ln_1p(), || (self.re + 1.0).recip())
    }

    fn sin(self) -> Self {
        self.chain(self.re.sin(), || self.re.cos())
    }

    fn cos(self) -> Self {
        self.chain(self.re.cos(), || -self.re.sin())
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        (self.chain(sin, || cos), self.chain(cos, || -sin))
    }

    fn tan(self) -> Self {
        let value = self.re.tan();
        self.chain(value, || value * value + 1.0)
    }

    fn asin(self) -> Self {
        self.chain(self.re.asin(), || below_one(self.re).sqrt().recip())
    }

    fn acos(self) -> Self {
        self.chain(self.re.acos(), || -below_one(self.re).sqrt().recip())
    }

    fn atan(self) -> Self {
        self.chain(self.re.atan(), || lorentz(self.re))
    }

    fn atan2(self, x: Self) -> Self {
        let eps = if self.eps.vanishes() && x.eps.vanishes() {
            D::zero()
        } else {
            Self::angle(self, x)
        };
        Self::new(self.re.atan2(x.re), eps)
    }

    fn sinh(self) -> Self {
        self.chain(self.re.sinh(), || self.re.cosh())
    }

    fn cosh(self) -> Self {
        self.chain(self.re.cosh(), || self.re.sinh())
    }

    fn tanh(self) -> Self {
        let value = self.re.tanh();
        self.chain(value, || {
            if self.re.re().abs() <= 0.5 {
                return below_one(value);
            }
            // 1/cosh² without overflow; it is even, so either sign of the exponent gives all its derivatives
            let decay = (self.re * (-2.0_f64).copysign(-self.re.re())).exp();
            decay * 4.0 / ((decay + 1.0) * (decay + 1.0))
        })
    }

    fn asinh(self) -> Self {
        self.chain(self.re.asinh(), || {
            if self.re.re().abs() <= 1.0 {
                (self.re * self.re + 1.0).sqrt().recip()
            } else {
                let r = self.re.abs().recip();
                r / (r * r + 1.0).sqrt()
            }
        })
    }

    fn acosh(self) -> Self {
        self.chain(self.re.acosh(), || {
            if self.re.re() <= 2.0 {
                ((self.re - 1.0) * (self.re + 1.0)).sqrt().recip()
            } else {
                let r = self.re.recip();
                r / below_one(r).sqrt()
            }
        })
    }

    fn atanh(self) -> Self {
        self.chain(self.re.atanh(), || below_one(self.re).recip())
    }

    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self::new(
            self.re.mul_add(factor.re, term.re),
            part(self.eps, || factor.re) + part(factor.eps, || self.re) + term.eps,
        )
    }
}
