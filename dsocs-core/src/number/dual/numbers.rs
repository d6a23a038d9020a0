//! Arithmetic, comparison and conversion of dual numbers, as [`Real`] requires.

use core::cmp::Ordering;
use core::fmt;
use core::iter::{Product, Sum};
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

use super::{Dual, Part, part};
use crate::number::real::Real;

impl<D: Part> Neg for Dual<D> {
    type Output = Self;

    fn neg(self) -> Self {
        Self::new(-self.re, -self.eps)
    }
}

impl<D: Part> Add for Dual<D> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.eps + other.eps)
    }
}

impl<D: Part> Sub for Dual<D> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::new(self.re - other.re, self.eps - other.eps)
    }
}

impl<D: Part> Mul for Dual<D> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self::new(
            self.re * other.re,
            part(self.eps, || other.re) + part(other.eps, || self.re),
        )
    }
}

impl<D: Part> Div for Dual<D> {
    type Output = Self;

    // by the quotient itself: squares of the divisor would overflow
    fn div(self, other: Self) -> Self {
        let re = self.re / other.re;
        let change = self.eps - part(other.eps, || re);
        let eps = if change.vanishes() {
            D::zero()
        } else {
            change / other.re
        };
        Self { re, eps }
    }
}

impl<D: Part> Rem for Dual<D> {
    type Output = Self;

    /// The remainder. Its derivative is that of `self − n other` with the integer quotient `n` held constant.
    fn rem(self, other: Self) -> Self {
        let times = (self.re() / other.re()).trunc();
        Self {
            re: self.re % other.re,
            eps: self.eps - part(other.eps, || D::from(times)),
        }
    }
}

/// The operations with a plain number on the left.
macro_rules! with_number_on_the_left {
    ($($trait:ident $method:ident),* $(,)?) => {
        $(
            impl<D: Part> $trait<Dual<D>> for f64 {
                type Output = Dual<D>;

                fn $method(self, other: Dual<D>) -> Dual<D> {
                    $trait::$method(Dual::from(self), other)
                }
            }
        )*
    };
}

with_number_on_the_left!(Add add, Sub sub, Mul mul, Div div, Rem rem);

impl<D: Part> Add<f64> for Dual<D> {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        Self::new(self.re + other, self.eps)
    }
}

impl<D: Part> Sub<f64> for Dual<D> {
    type Output = Self;

    fn sub(self, other: f64) -> Self {
        Self::new(self.re - other, self.eps)
    }
}

impl<D: Part> Mul<f64> for Dual<D> {
    type Output = Self;

    fn mul(self, other: f64) -> Self {
        Self::new(self.re * other, part(self.eps, || D::from(other)))
    }
}

impl<D: Part> Div<f64> for Dual<D> {
    type Output = Self;

    fn div(self, other: f64) -> Self {
        self / Self::from(other)
    }
}

impl<D: Part> Rem<f64> for Dual<D> {
    type Output = Self;

    fn rem(self, other: f64) -> Self {
        Self::new(self.re % other, self.eps)
    }
}

macro_rules! derived_operators {
    ($($name:ident :: $method:ident, $assign:ident :: $assign_method:ident;)*) => {
        $(
            impl<D: Part> $assign for Dual<D> {
                fn $assign_method(&mut self, other: Self) {
                    *self = $name::$method(*self, other);
                }
            }

            impl<D: Part> $assign<f64> for Dual<D> {
                fn $assign_method(&mut self, other: f64) {
                    *self = $name::$method(*self, other);
                }
            }
        )*
    };
}

derived_operators! {
    Add::add, AddAssign::add_assign;
    Sub::sub, SubAssign::sub_assign;
    Mul::mul, MulAssign::mul_assign;
    Div::div, DivAssign::div_assign;
    Rem::rem, RemAssign::rem_assign;
}

impl<D: Part> Sum for Dual<D> {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::zero(), |sum, term| sum + term)
    }
}

impl<D: Part> Product for Dual<D> {
    fn product<I: Iterator<Item = Self>>(factors: I) -> Self {
        factors.fold(Self::one(), |product, factor| product * factor)
    }
}

// comparisons use the value alone, so that a function takes the same branches as with real numbers

impl<D: Part> PartialEq for Dual<D> {
    fn eq(&self, other: &Self) -> bool {
        self.re == other.re
    }
}

impl<D: Part> PartialEq<f64> for Dual<D> {
    fn eq(&self, other: &f64) -> bool {
        self.re == *other
    }
}

impl<D: Part> PartialOrd for Dual<D> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.re.partial_cmp(&other.re)
    }
}

impl<D: Part> PartialOrd<f64> for Dual<D> {
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.re.partial_cmp(other)
    }
}

impl<D: Part> From<f64> for Dual<D> {
    fn from(value: f64) -> Self {
        Self::constant(D::from(value))
    }
}

impl<D: fmt::Display> fmt::Display for Dual<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} + {}ε", self.re, self.eps)
    }
}
