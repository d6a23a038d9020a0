//! The number type of functions that a declaration calls.

mod bessel;
pub(crate) mod generic;

use core::fmt::{Debug, Display};
use core::iter::{Product, Sum};
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

/// The numbers with which the Rust functions of a declaration compute: `f64`, or numbers that carry derivatives.
///
/// Functions and methods that a declaration calls have to be generic over this trait, so that the same code gives values and derivatives. The
/// methods have the names that they have for `f64`. The right operand of arithmetic is a number of the same type or an `f64`. Comparisons, and
/// so branches, depend on the value alone.
///
/// ```
/// use dsocs_core::Real;
///
/// fn curvature<R: Real>(x: R, y: R) -> R {
///     if x > 0.0 { x.sin() * y.cos() * 0.5 + 1.0 } else { R::from(1.0) }
/// }
///
/// assert_eq!(curvature(0.0, 0.0), 1.0);
/// ```
///
/// With the feature `num-dual` the numbers of the crate `num-dual` over `f64` implement this trait, too.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no number that functions of a declaration compute with",
    label = "expected `f64`, or a number that carries derivatives",
    note = "a function that a declaration calls has to be generic over its number: \
            `fn f<R: dsocs_core::Real>(x: R) -> R`"
)]
#[allow(clippy::return_self_not_must_use)] // results of arithmetic are rarely ignored by mistake
pub trait Real:
    Copy
    + Debug
    + Display
    + From<f64>
    + PartialOrd
    + PartialOrd<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Rem<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + Rem<f64, Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + RemAssign
    + AddAssign<f64>
    + SubAssign<f64>
    + MulAssign<f64>
    + DivAssign<f64>
    + RemAssign<f64>
    + Sum
    + Product
    + 'static
{
    /// The value, without derivatives.
    fn re(self) -> f64;

    /// The number 0.
    #[must_use]
    fn zero() -> Self {
        Self::from(0.0)
    }
    /// The number 1.
    #[must_use]
    fn one() -> Self {
        Self::from(1.0)
    }

    /// The absolute value.
    fn abs(self) -> Self;
    /// The sign, ±1, as [`f64::signum`].
    fn signum(self) -> Self;
    /// The smaller of two numbers, as `min` in a declaration: `other` if one of them is NaN.
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    /// The larger of two numbers, as `max` in a declaration: `self` if one of them is NaN.
    fn max(self, other: Self) -> Self {
        if self < other { other } else { self }
    }

    /// The number of `places`, which are in ascending order, that are less than or equal to `self`.
    ///
    /// A function that is given by pieces should use this to choose a piece. Then a Taylor series knows where the next piece begins.
    fn piece(self, places: &[f64]) -> usize {
        places.partition_point(|&place| place <= self.re())
    }

    /// The reciprocal.
    fn recip(self) -> Self;
    /// `self · factor + term`.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// An integer power.
    fn powi(self, exponent: i32) -> Self;
    /// A power with a fixed exponent.
    fn powf(self, exponent: f64) -> Self;
    /// A power with an exponent that may vary.
    fn powd(self, exponent: Self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The cube root.
    fn cbrt(self) -> Self;
    /// `√(x² + y²)`.
    fn hypot(self, other: Self) -> Self {
        (self * self + other * other).sqrt()
    }

    /// The exponential.
    fn exp(self) -> Self;
    /// The power of 2.
    fn exp2(self) -> Self;
    /// `exp(x) - 1`, accurate near 0.
    fn exp_m1(self) -> Self;
    /// The natural logarithm.
    fn ln(self) -> Self;
    /// The logarithm to a fixed base.
    fn log(self, base: f64) -> Self;
    /// The logarithm to the base 2.
    fn log2(self) -> Self;
    /// The logarithm to the base 10.
    fn log10(self) -> Self;
    /// `ln(1 + x)`, accurate near 0.
    fn ln_1p(self) -> Self;

    /// The sine, of radians.
    fn sin(self) -> Self;
    /// The cosine, of radians.
    fn cos(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// The tangent, of radians.
    fn tan(self) -> Self;
    /// The arc sine, in radians.
    fn asin(self) -> Self;
    /// The arc cosine, in radians.
    fn acos(self) -> Self;
    /// The arc tangent, in radians.
    fn atan(self) -> Self;
    /// The polar angle of the point `(x, self)`, in radians.
    fn atan2(self, x: Self) -> Self;
    /// Degrees in radians.
    fn to_radians(self) -> Self {
        self * (core::f64::consts::PI / 180.0)
    }
    /// Radians in degrees.
    fn to_degrees(self) -> Self {
        self * (180.0 / core::f64::consts::PI)
    }

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

    /// The spherical Bessel function of order 0, `sin x / x`.
    fn sph_j0(self) -> Self {
        bessel::j0(self)
    }
    /// The spherical Bessel function of order 1.
    fn sph_j1(self) -> Self {
        bessel::j1(self)
    }
    /// The spherical Bessel function of order 2.
    fn sph_j2(self) -> Self {
        bessel::j2(self)
    }
}

#[cfg(not(feature = "num-dual"))]
macro_rules! forward {
    ($($name:ident),* $(,)?) => {
        $(
            #[inline]
            fn $name(self) -> Self {
                f64::$name(self)
            }
        )*
    };
}

#[cfg(not(feature = "num-dual"))]
impl Real for f64 {
    #[inline]
    fn re(self) -> f64 {
        self
    }

    #[inline]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline]
    fn signum(self) -> Self {
        f64::signum(self)
    }

    #[inline]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        f64::mul_add(self, factor, term)
    }

    #[inline]
    fn powi(self, exponent: i32) -> Self {
        f64::powi(self, exponent)
    }

    #[inline]
    fn powf(self, exponent: f64) -> Self {
        f64::powf(self, exponent)
    }

    #[inline]
    fn powd(self, exponent: Self) -> Self {
        f64::powf(self, exponent)
    }

    #[inline]
    fn log(self, base: f64) -> Self {
        f64::log(self, base)
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        f64::atan2(self, x)
    }

    forward!(
        recip, sqrt, cbrt, exp, exp2, exp_m1, ln, log2, log10, ln_1p, sin, cos, tan, asin, acos, atan, sinh,
        cosh, tanh, asinh, acosh, atanh
    );
}

#[cfg(feature = "num-dual")]
macro_rules! forward {
    ($($name:ident),* $(,)?) => {
        $(
            #[inline]
            fn $name(self) -> Self {
                num_dual::DualNum::$name(&self)
            }
        )*
    };
}

/// The numbers of `num-dual` over `f64`, `f64` itself among them. Functions are named in full throughout: the
/// plain name would call the method that is being defined.
#[cfg(feature = "num-dual")]
impl<R: num_dual::DualNum<Primitive = f64> + Copy> Real for R {
    #[inline]
    fn re(self) -> f64 {
        num_dual::DualStruct::re(&self)
    }

    #[inline]
    fn abs(self) -> Self {
        num_traits::Signed::abs(&self)
    }

    #[inline]
    fn signum(self) -> Self {
        num_traits::Signed::signum(&self)
    }

    #[inline]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        num_dual::DualNum::mul_add(&self, factor, term)
    }

    #[inline]
    fn powi(self, exponent: i32) -> Self {
        num_dual::DualNum::powi(&self, exponent)
    }

    #[inline]
    fn powf(self, exponent: f64) -> Self {
        num_dual::DualNum::powf(&self, exponent)
    }

    #[inline]
    fn powd(self, exponent: Self) -> Self {
        num_dual::DualNum::powd(&self, exponent)
    }

    #[inline]
    fn log(self, base: f64) -> Self {
        num_dual::DualNum::log(&self, base)
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        num_dual::DualNum::sin_cos(&self)
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        num_dual::DualNum::atan2(&self, x)
    }

    fn sph_j0(self) -> Self {
        if R::NDERIV == 0 {
            bessel::j0(self)
        } else {
            num_dual::DualNum::sph_j0(&self)
        }
    }

    fn sph_j1(self) -> Self {
        if R::NDERIV == 0 {
            bessel::j1(self)
        } else {
            num_dual::DualNum::sph_j1(&self)
        }
    }

    fn sph_j2(self) -> Self {
        if R::NDERIV == 0 {
            bessel::j2(self)
        } else {
            num_dual::DualNum::sph_j2(&self)
        }
    }

    forward!(
        recip, sqrt, cbrt, exp, exp2, exp_m1, ln, log2, log10, ln_1p, sin, cos, tan, asin, acos, atan, sinh,
        cosh, tanh, asinh, acosh, atanh
    );
}
