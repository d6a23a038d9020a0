//! Jets in generated code: the observed expressions of a declaration as functions of time.

use super::Jet;
use crate::number::real::Real;
use crate::number::scalar::Scalar;

/// The functions that both traits have.
macro_rules! forward {
    ($($name:ident),* $(,)?) => {
        $(
            fn $name(self) -> Self {
                Real::$name(self)
            }
        )*
    };
}

/// Comparisons use the coefficients of order 0.
impl Scalar for Jet {
    const LANES: usize = 1;

    fn splat(value: f64) -> Self {
        Self::from(value)
    }

    fn lane(self, _: usize) -> f64 {
        self.value
    }

    /// The user's functions are called with plain numbers here, so their higher orders are unknown.
    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        function(0).map(Self::unseen)
    }

    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left < right { then } else { otherwise }
    }

    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left <= right { then } else { otherwise }
    }

    fn abs(self) -> Self {
        Real::abs(self)
    }

    fn signum(self) -> Self {
        Real::signum(self)
    }

    forward!(
        recip, sqrt, cbrt, exp, exp_m1, ln, ln_1p, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, asinh,
        acosh, atanh,
    );

    fn powf(self, exponent: Self) -> Self {
        Real::powd(self, exponent)
    }

    fn powi(self, exponent: i32) -> Self {
        Real::powi(self, exponent)
    }

    fn atan2(self, x: Self) -> Self {
        Real::atan2(self, x)
    }
}
