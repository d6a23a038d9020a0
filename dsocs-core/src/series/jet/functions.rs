//! The functions of jets, as [`Real`] requires.

use core::cmp::Ordering;

use super::Jet;
use super::pieces;
use crate::number::dual::Part;
use crate::number::real::Real;

impl Part for Jet {
    /// Whether it is zero at all times.
    fn vanishes(&self) -> bool {
        !self.moves && self.value == 0.0
    }
}

impl Jet {
    /// A function of a jet that depends on time, or of a constant.
    #[inline(always)]
    fn unary(self, moving: impl FnOnce(Self) -> Self, number: impl FnOnce(f64) -> f64) -> Self {
        if self.moves {
            moving(self)
        } else {
            Self::from(number(self.value))
        }
    }

    /// A function with `slope w' = scale u'`.
    #[inline(always)]
    fn by_slope(self, slope: impl FnOnce() -> Self, scale: f64, value: impl Fn(f64) -> f64) -> Self {
        if self.moves {
            self.inverse(slope(), scale, value)
        } else {
            Self::from(value(self.value))
        }
    }

    /// Hyperbolic sine and cosine.
    fn sinh_cosh(self) -> (Self, Self) {
        pieces::steep(self);
        if self.moves {
            return self.pair(1.0, |u| (u.sinh(), u.cosh()));
        }
        (Self::from(self.value.sinh()), Self::from(self.value.cosh()))
    }

    /// `1 - self²`.
    #[inline(always)]
    fn conjugate(self) -> Self {
        (-self + 1.0) * (self + 1.0)
    }
}

/// Comparisons, which select pieces of a function.
pub(super) fn compare(left: Jet, right: Jet) -> Option<Ordering> {
    let own = left.value.partial_cmp(&right.value)?;
    let difference = left - right;
    if !difference.moves {
        return Some(own);
    }
    let free = !pieces::is_held();
    let sign = match own {
        Ordering::Less => -1.0,
        // as in `signum`
        Ordering::Equal | Ordering::Greater => 1.0,
    };
    let side = pieces::decide(difference, sign);
    Some(match own {
        own if free => own,
        _ if side < 0.0 => Ordering::Less,
        _ => Ordering::Greater,
    })
}

impl Real for Jet {
    #[inline(always)]
    fn re(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.affine(pieces::decide(self, self.value.signum()), 0.0)
    }

    #[inline(always)]
    fn signum(self) -> Self {
        Self::from(pieces::decide(self, self.value.signum()))
    }

    fn piece(self, places: &[f64]) -> usize {
        let own = places.partition_point(|&place| place <= self.value);
        // more numbers than places
        let number = |index: usize| i64::try_from(index).unwrap_or(i64::MAX);
        let index = |number: i64| usize::try_from(number).ok();
        let piece = pieces::choose(self, number(own), |piece| {
            [piece - 1, piece].map(|end| index(end).and_then(|end| places.get(end).copied()))
        });
        index(piece).unwrap_or(0)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    #[inline(always)]
    fn recip(self) -> Self {
        self.unary(|u| u.reciprocal(1.0), f64::recip)
    }

    #[inline(always)]
    fn powi(self, n: i32) -> Self {
        // by products: the logarithm of zero does not exist
        let mut result: Option<Self> = None;
        let (mut square, mut rest) = (self, n.unsigned_abs());
        while rest > 0 {
            if rest & 1 == 1 {
                result = Some(result.map_or(square, |product| product * square));
            }
            rest >>= 1;
            if rest > 0 {
                square = square * square;
            }
        }
        match result {
            None => Self::from(1.0),
            Some(power) if n < 0 => Real::recip(power),
            Some(power) => power,
        }
    }

    #[inline(always)]
    fn powf(self, n: f64) -> Self {
        #[allow(clippy::cast_possible_truncation)] // a small integer
        if n.fract() == 0.0 && n.abs() <= 64.0 {
            return Real::powi(self, n as i32);
        }
        self.unary(|u| u.power(n, |u| u.powf(n)), |u| u.powf(n))
    }

    fn powd(self, exp: Self) -> Self {
        if !exp.moves {
            return Real::powf(self, exp.value);
        }
        Real::exp(Real::ln(self) * exp)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.unary(Self::root, f64::sqrt)
    }

    fn cbrt(self) -> Self {
        self.unary(|u| u.power(1.0 / 3.0, f64::cbrt), f64::cbrt)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        pieces::steep(self);
        self.unary(|u| u.exponential(0.0, f64::exp), f64::exp)
    }

    fn exp2(self) -> Self {
        Real::exp(self.affine(core::f64::consts::LN_2, 0.0))
    }

    fn exp_m1(self) -> Self {
        pieces::steep(self);
        self.unary(|u| u.exponential(1.0, f64::exp_m1), f64::exp_m1)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.unary(|u| u.logarithm(0.0, f64::ln), f64::ln)
    }

    fn log(self, base: f64) -> Self {
        Real::ln(self).affine(1.0 / base.ln(), 0.0)
    }

    fn log2(self) -> Self {
        Real::ln(self).affine(core::f64::consts::LOG2_E, 0.0)
    }

    fn log10(self) -> Self {
        Real::ln(self).affine(core::f64::consts::LOG10_E, 0.0)
    }

    fn ln_1p(self) -> Self {
        self.unary(|u| u.logarithm(1.0, f64::ln_1p), f64::ln_1p)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        Real::sin_cos(self).0
    }

    #[inline(always)]
    fn cos(self) -> Self {
        Real::sin_cos(self).1
    }

    fn tan(self) -> Self {
        let values = |u: f64| {
            let tangent = u.tan();
            [tangent, 1.0 + tangent * tangent]
        };
        self.unary(|u| u.tangent(1.0, values), f64::tan)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        if self.moves {
            return self.pair(-1.0, f64::sin_cos);
        }
        let (sine, cosine) = self.value.sin_cos();
        (Self::from(sine), Self::from(cosine))
    }

    fn asin(self) -> Self {
        self.by_slope(|| Real::sqrt(self.conjugate()), 1.0, f64::asin)
    }

    fn acos(self) -> Self {
        self.by_slope(|| Real::sqrt(self.conjugate()), -1.0, f64::acos)
    }

    fn atan(self) -> Self {
        self.by_slope(|| self * self + 1.0, 1.0, f64::atan)
    }

    fn atan2(self, other: Self) -> Self {
        let value = self.value.atan2(other.value);
        match (self.moves, other.moves) {
            (false, false) => Self::from(value),
            (true, true) => self.angle(other, self * self + other * other),
            // atan2(y, x) = atan(y/x) + const = const - atan(x/y)
            (true, false) if other.value != 0.0 => {
                let angle = Real::atan(self / other);
                angle.affine(1.0, value - angle.value)
            }
            _ => {
                let angle = Real::atan(other / self);
                angle.affine(-1.0, value + angle.value)
            }
        }
    }

    fn sinh(self) -> Self {
        self.sinh_cosh().0
    }

    fn cosh(self) -> Self {
        self.sinh_cosh().1
    }

    fn tanh(self) -> Self {
        pieces::steep(self);
        let values = |u: f64| {
            let tangent = u.tanh();
            [tangent, (1.0 - tangent) * (1.0 + tangent)]
        };
        self.unary(|u| u.tangent(-1.0, values), f64::tanh)
    }

    fn asinh(self) -> Self {
        self.by_slope(|| Real::sqrt(self * self + 1.0), 1.0, f64::asinh)
    }

    fn acosh(self) -> Self {
        self.by_slope(|| Real::sqrt(-self.conjugate()), 1.0, f64::acosh)
    }

    fn atanh(self) -> Self {
        self.by_slope(|| self.conjugate(), 1.0, f64::atanh)
    }
}
