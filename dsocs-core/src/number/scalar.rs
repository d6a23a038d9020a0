//! The number type of the generated step.

use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or several in lanes, that the generated code computes with.
///
/// Generated code is generic over its scalar, so that one declaration serves a single trajectory (`f64`) and
/// several trajectories side by side. A comparison never branches: it goes through [`Scalar::select_lt`].
#[allow(clippy::return_self_not_must_use)] // results of arithmetic are rarely ignored by mistake
pub trait Scalar:
    Copy
    + Send
    + Sync
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// The number of lanes, one for each trajectory.
    const LANES: usize;

    /// `value` in every lane.
    fn splat(value: f64) -> Self;

    /// The number in one lane, `lane < LANES`.
    fn lane(self, lane: usize) -> f64;

    /// Calls a function of one lane for every lane; its `P` results become `P` scalars.
    ///
    /// The user's functions, which compute with dual numbers over `f64`, enter the generated code here.
    fn from_lanes<const P: usize>(function: impl FnMut(usize) -> [f64; P]) -> [Self; P];

    /// The numbers as doubles, if this type is `f64`.
    fn doubles(numbers: &mut [Self]) -> Option<&mut [f64]> {
        let _ = numbers;
        None
    }

    /// `then` in the lanes where `left < right`, `otherwise` in the others (also where either is NaN).
    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self;

    /// `then` in the lanes where `left <= right`, `otherwise` in the others (also where either is NaN).
    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self;

    /// The larger of two numbers; `other` where either is NaN.
    fn larger(self, other: Self) -> Self {
        Self::select_lt(other, self, self, other)
    }

    /// The smaller of two numbers; `other` where either is NaN.
    fn smaller(self, other: Self) -> Self {
        Self::select_lt(self, other, self, other)
    }

    /// The absolute value.
    fn abs(self) -> Self;
    /// The sign, ±1, as [`f64::signum`].
    fn signum(self) -> Self;
    /// The reciprocal.
    fn recip(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The cube root.
    fn cbrt(self) -> Self;
    /// The exponential.
    fn exp(self) -> Self;
    /// `exp(x) - 1`, accurate near 0.
    fn exp_m1(self) -> Self;
    /// The natural logarithm.
    fn ln(self) -> Self;
    /// `ln(1 + x)`, accurate near 0.
    fn ln_1p(self) -> Self;
    /// The sine, of radians.
    fn sin(self) -> Self;
    /// The cosine, of radians.
    fn cos(self) -> Self;
    /// The tangent, of radians.
    fn tan(self) -> Self;
    /// The arc sine, in radians.
    fn asin(self) -> Self;
    /// The arc cosine, in radians.
    fn acos(self) -> Self;
    /// The arc tangent, in radians.
    fn atan(self) -> Self;
    /// The hyperbolic sine.
    fn sinh(self) -> Self;
    /// The hyperbolic cosine.
    fn cosh(self) -> Self;
    /// The hyperbolic tangent.
    fn tanh(self) -> Self;
    /// The inverse hyperbolic sine.
    fn asinh(self) -> Self;
    /// The inverse hyperbolic cosine.
    fn acosh(self) -> Self;
    /// The inverse hyperbolic tangent.
    fn atanh(self) -> Self;
    /// A real power.
    fn powf(self, exponent: Self) -> Self;
    /// An integer power.
    fn powi(self, exponent: i32) -> Self;
    /// The polar angle of the point `(x, self)`, in radians.
    fn atan2(self, x: Self) -> Self;
}

macro_rules! forward {
    ($($name:ident),* $(,)?) => {
        $(
            #[inline(always)]
            fn $name(self) -> Self {
                f64::$name(self)
            }
        )*
    };
}

#[allow(clippy::inline_always)] // one instruction each; the optimiser must see through them in any profile
impl Scalar for f64 {
    const LANES: usize = 1;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        function(0)
    }

    #[inline(always)]
    fn doubles(numbers: &mut [Self]) -> Option<&mut [f64]> {
        Some(numbers)
    }

    #[inline(always)]
    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left < right { then } else { otherwise }
    }

    #[inline(always)]
    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left <= right { then } else { otherwise }
    }

    forward!(
        abs, signum, recip, sqrt, cbrt, exp, exp_m1, ln, ln_1p, sin, cos, tan, asin, acos, atan, sinh, cosh,
        tanh, asinh, acosh, atanh,
    );

    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        f64::powf(self, exponent)
    }

    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        f64::powi(self, exponent)
    }

    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        f64::atan2(self, x)
    }
}
