//! Running error analysis: a number with a bound of its rounding error, to first order.
//!
//! Because the generated code is generic over its scalar, the residual can be evaluated with these numbers,
//! which gives a bound of its rounding error. Newton's iteration needs the bound when its updates stop
//! shrinking: a residual within its own rounding error is zero to double precision. (N. J. Higham, *Accuracy
//! and Stability of Numerical Algorithms*, 2nd ed., section 3.3.)

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::number::scalar::Scalar;

/// The unit round-off of double precision, `2⁻⁵³`.
pub(crate) const UNIT: f64 = f64::EPSILON / 2.0;

/// The spacing of numbers below the smallest normal one, which have fewer digits: the error of a product that
/// falls there is at most half of it.
pub(crate) const QUANTUM: f64 = f64::from_bits(1);

/// A value and a bound of its error: of the whole rounding error if `ROUNDS`, else of the digits that are
/// lost only because products fall below the smallest normal number.
#[derive(Clone, Copy, Debug)]
pub struct Bound<const ROUNDS: bool> {
    value: f64,
    error: f64,
}

/// A value and a bound of its rounding error.
pub type Bounded = Bound<true>;

/// A value and a bound of its loss by products that fall below the smallest normal number.
pub(crate) type Underflowing = Bound<false>;

impl<const ROUNDS: bool> Bound<ROUNDS> {
    /// A value that is known to within an error.
    pub(crate) fn known(value: f64, error: f64) -> Self {
        Self { value, error }
    }

    /// The bound of the error.
    pub(crate) fn error(self) -> f64 {
        self.error
    }

    /// A result whose operation rounds to within `units` unit round-offs, with the `inherited` error of its
    /// operands.
    fn rounded(value: f64, inherited: f64, units: f64) -> Self {
        let own = if ROUNDS { units * UNIT * value.abs() } else { 0.0 };
        Self {
            value,
            error: inherited + own,
        }
    }

    /// [`Bound::rounded`] for an operation whose result may fall below the smallest normal number; `is_exact`
    /// if a result of zero is exact.
    fn scaled(value: f64, inherited: f64, units: f64, is_exact: bool) -> Self {
        let lost = if value.abs() < f64::MIN_POSITIVE && !is_exact {
            QUANTUM
        } else {
            0.0
        };
        Self::rounded(value, inherited + lost, units)
    }

    /// A function of one variable with slope at most `slope` at the value.
    fn function(self, value: f64, slope: f64) -> Self {
        // library functions are right to within one unit in the last place, two units of round-off; an exact
        // argument passes on no error, also where the slope is infinite
        let inherited = if self.error == 0.0 {
            0.0
        } else {
            slope.abs() * self.error
        };
        Self::rounded(value, inherited, 2.0)
    }
}

impl<const ROUNDS: bool> Add for Bound<ROUNDS> {
    type Output = Self;

    #[inline(never)] // as in [`crate::number::tangent`]
    fn add(self, other: Self) -> Self {
        Self::rounded(self.value + other.value, self.error + other.error, 1.0)
    }
}

impl<const ROUNDS: bool> Sub for Bound<ROUNDS> {
    type Output = Self;

    #[inline(never)] // as in [`crate::number::tangent`]
    fn sub(self, other: Self) -> Self {
        Self::rounded(self.value - other.value, self.error + other.error, 1.0)
    }
}

impl<const ROUNDS: bool> Mul for Bound<ROUNDS> {
    type Output = Self;

    #[inline(never)] // as in [`crate::number::tangent`]
    fn mul(self, other: Self) -> Self {
        let inherited = self.value.abs() * other.error + other.value.abs() * self.error;
        let is_exact = self.value == 0.0 || other.value == 0.0;
        Self::scaled(self.value * other.value, inherited, 1.0, is_exact)
    }
}

impl<const ROUNDS: bool> Div for Bound<ROUNDS> {
    type Output = Self;

    #[inline(never)] // as in [`crate::number::tangent`]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let inherited = (self.error + value.abs() * other.error) / other.value.abs();
        Self::scaled(value, inherited, 1.0, self.value == 0.0)
    }
}

impl<const ROUNDS: bool> Neg for Bound<ROUNDS> {
    type Output = Self;

    #[inline(never)]
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            error: self.error,
        }
    }
}

impl<const ROUNDS: bool> Scalar for Bound<ROUNDS> {
    const LANES: usize = 1;

    fn splat(value: f64) -> Self {
        Self { value, error: 0.0 }
    }

    fn lane(self, _: usize) -> f64 {
        self.value
    }

    /// Errors of the arguments are not propagated through a user's function; its result counts as correctly
    /// rounded.
    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        function(0).map(|value| Self::rounded(value, 0.0, 2.0))
    }

    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.value < right.value { then } else { otherwise }
    }

    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.value <= right.value {
            then
        } else {
            otherwise
        }
    }

    fn abs(self) -> Self {
        Self {
            value: self.value.abs(),
            error: self.error,
        }
    }

    fn signum(self) -> Self {
        Self {
            value: self.value.signum(),
            error: 0.0,
        }
    }

    fn recip(self) -> Self {
        Self::splat(1.0) / self
    }

    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        self.function(value, 0.5 / value)
    }

    fn cbrt(self) -> Self {
        let value = self.value.cbrt();
        self.function(value, 1.0 / (3.0 * value * value))
    }

    fn exp(self) -> Self {
        let value = self.value.exp();
        self.function(value, value)
    }

    fn exp_m1(self) -> Self {
        self.function(self.value.exp_m1(), self.value.exp())
    }

    fn ln(self) -> Self {
        self.function(self.value.ln(), 1.0 / self.value)
    }

    fn ln_1p(self) -> Self {
        self.function(self.value.ln_1p(), 1.0 / (1.0 + self.value))
    }

    fn sin(self) -> Self {
        self.function(self.value.sin(), 1.0)
    }

    fn cos(self) -> Self {
        self.function(self.value.cos(), 1.0)
    }

    fn tan(self) -> Self {
        let value = self.value.tan();
        self.function(value, 1.0 + value * value)
    }

    fn asin(self) -> Self {
        self.function(
            self.value.asin(),
            1.0 / ((1.0 - self.value) * (1.0 + self.value)).sqrt(),
        )
    }

    fn acos(self) -> Self {
        self.function(
            self.value.acos(),
            1.0 / ((1.0 - self.value) * (1.0 + self.value)).sqrt(),
        )
    }

    fn atan(self) -> Self {
        self.function(self.value.atan(), 1.0 / (1.0 + self.value * self.value))
    }

    fn sinh(self) -> Self {
        self.function(self.value.sinh(), self.value.cosh())
    }

    fn cosh(self) -> Self {
        self.function(self.value.cosh(), self.value.sinh())
    }

    fn tanh(self) -> Self {
        self.function(self.value.tanh(), 1.0)
    }

    fn asinh(self) -> Self {
        self.function(self.value.asinh(), 1.0 / self.value.hypot(1.0))
    }

    fn acosh(self) -> Self {
        self.function(
            self.value.acosh(),
            1.0 / ((self.value - 1.0) * (self.value + 1.0)).sqrt(),
        )
    }

    fn atanh(self) -> Self {
        self.function(
            self.value.atanh(),
            1.0 / ((1.0 - self.value) * (1.0 + self.value)),
        )
    }

    fn powf(self, exponent: Self) -> Self {
        let value = self.value.powf(exponent.value);
        let base = if self.error == 0.0 {
            0.0
        } else {
            (value * exponent.value / self.value).abs() * self.error
        };
        let power = if exponent.error == 0.0 {
            0.0
        } else {
            (value * self.value.ln()).abs() * exponent.error
        };
        Self::scaled(value, base + power, 2.0, self.value == 0.0)
    }

    fn powi(self, exponent: i32) -> Self {
        let value = self.value.powi(exponent);
        let slope = if self.error == 0.0 {
            0.0
        } else {
            value * f64::from(exponent) / self.value
        };
        let units = f64::from(exponent.unsigned_abs());
        Self::scaled(value, slope.abs() * self.error, units, self.value == 0.0)
    }

    fn atan2(self, x: Self) -> Self {
        let radius = self.value.hypot(x.value);
        Self::rounded(self.value.atan2(x.value), (self.error + x.error) / radius, 2.0)
    }
}
