//! A scalar of the generated code that carries a derivative along.
//!
//! The generated code is generic over its scalar. Evaluated with these numbers it differentiates itself, which the
//! Jacobian that it writes down must agree with.

use core::ops::{Add, Div, Mul, Neg, Sub};

use dsocs_core::Scalar;
use num_dual::{Dual64, DualNum as _};

/// A number and its derivative. Functions of the user's ([`Scalar::from_lanes`]) count as constant.
#[derive(Clone, Copy, Debug)]
pub struct Tangent(pub Dual64);

impl Tangent {
    /// A number with its derivative.
    #[must_use]
    pub fn new(value: f64, derivative: f64) -> Self {
        Self(Dual64::new(value, derivative))
    }
}

macro_rules! operators {
    ($($name:ident :: $method:ident),* $(,)?) => {
        $(
            impl $name for Tangent {
                type Output = Self;

                fn $method(self, other: Self) -> Self {
                    Self($name::$method(self.0, other.0))
                }
            }
        )*
    };
}

operators!(Add::add, Sub::sub, Mul::mul, Div::div);

impl Neg for Tangent {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! functions {
    ($($name:ident),* $(,)?) => {
        $(
            fn $name(self) -> Self {
                Self(self.0.$name())
            }
        )*
    };
}

impl Scalar for Tangent {
    const LANES: usize = 1;

    fn splat(value: f64) -> Self {
        Self::new(value, 0.0)
    }

    fn lane(self, _: usize) -> f64 {
        self.0.re
    }

    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        function(0).map(Self::splat)
    }

    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.0.re < right.0.re { then } else { otherwise }
    }

    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.0.re <= right.0.re { then } else { otherwise }
    }

    fn abs(self) -> Self {
        if self.0.re < 0.0 { -self } else { self }
    }

    fn signum(self) -> Self {
        Self::splat(self.0.re.signum())
    }

    // not by hyperbolic sine and cosine, which overflow
    fn tanh(self) -> Self {
        let value = self.0.re.tanh();
        Self::new(value, (1.0 - value * value) * self.0.eps)
    }

    functions!(
        recip, sqrt, cbrt, exp, exp_m1, ln, ln_1p, sin, cos, tan, asin, acos, atan, sinh, cosh, asinh, acosh,
        atanh,
    );

    fn powf(self, exponent: Self) -> Self {
        Self(self.0.powd(exponent.0))
    }

    fn powi(self, exponent: i32) -> Self {
        Self(self.0.powi(exponent))
    }

    fn atan2(self, x: Self) -> Self {
        Self(self.0.atan2(x.0))
    }
}
