//! A scalar of the generated code that carries a derivative along.

use core::ops::{Add, Div, Mul, Neg, Sub};

use num_dual::DualNum as _;
use num_traits::Signed as _;

use crate::dual::Dual;
use crate::scalar::Scalar;

/// How far arguments of the user's functions are moved along the derivative. Derivatives are those by coordinates in units
/// of a leg, so this is a thousandth of a leg.
const SHIFT: f64 = 1e-3;

/// A number and its derivative.
///
/// Functions of the user's are called with plain numbers; they are differentiated by calling them at four places beside
/// the one asked for. Where no argument moves, all five agree, and the derivative is exactly zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moving(Dual<f64>);

impl Moving {
    /// A number with its derivative.
    pub fn new(value: f64, slope: f64) -> Self {
        Self(Dual::new(value, slope))
    }

    /// The number.
    pub fn value(self) -> f64 {
        self.0.re
    }

    /// The derivative.
    pub fn slope(self) -> f64 {
        self.0.eps
    }
}

macro_rules! operators {
    ($($name:ident :: $method:ident),* $(,)?) => {
        $(
            impl $name for Moving {
                type Output = Self;

                fn $method(self, other: Self) -> Self {
                    Self($name::$method(self.0, other.0))
                }
            }
        )*
    };
}

operators!(Add::add, Sub::sub, Mul::mul, Div::div);

impl Neg for Moving {
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

impl Scalar for Moving {
    const LANES: usize = 1;

    fn splat(value: f64) -> Self {
        Self::new(value, 0.0)
    }

    /// The number itself in lane 0, moved along its derivative in the others.
    fn lane(self, lane: usize) -> f64 {
        let shift = [0.0, SHIFT, -SHIFT, 0.5 * SHIFT, -0.5 * SHIFT];
        match shift.get(lane) {
            Some(shift) if *shift != 0.0 && self.0.eps != 0.0 => self.0.re + shift * self.0.eps,
            _ => self.0.re,
        }
    }

    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        let values = function(0);
        let [right, left, near_right, near_left] = [1, 2, 3, 4].map(function);
        core::array::from_fn(|p| {
            let far = (right[p] - left[p]) / (2.0 * SHIFT);
            let near = (near_right[p] - near_left[p]) / SHIFT;
            Self::new(values[p], (4.0 * near - far) / 3.0)
        })
    }

    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.0.re < right.0.re { then } else { otherwise }
    }

    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.0.re <= right.0.re { then } else { otherwise }
    }

    functions!(
        abs, signum, recip, sqrt, cbrt, exp, exp_m1, ln, ln_1p, sin, cos, tan, asin, acos, atan, sinh, cosh,
        tanh, asinh, acosh, atanh,
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
