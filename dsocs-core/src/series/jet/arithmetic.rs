//! The arithmetic of jets, with the operators that [`Real`](crate::Real) requires.

use core::cmp::Ordering;
use core::fmt;
use core::iter::{Product, Sum};
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

use super::Jet;
use super::functions::compare;
use super::pieces;

impl Add for Jet {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let value = self.value + other.value;
        match (self.moves, other.moves) {
            (true, true) => Self::moving(value, self.now + other.now),
            (true, false) => Self::moving(value, self.now),
            (false, true) => Self::moving(value, other.now),
            (false, false) => Self::from(value),
        }
    }
}

impl Sub for Jet {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let value = self.value - other.value;
        match (self.moves, other.moves) {
            (true, true) => Self::moving(value, self.now - other.now),
            (true, false) => Self::moving(value, self.now),
            (false, true) => Self::moving(value, -other.now),
            (false, false) => Self::from(value),
        }
    }
}

impl Mul for Jet {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        match (self.moves, other.moves) {
            (true, true) => self.product(other),
            (true, false) => self.affine(other.value, 0.0),
            (false, true) => other.affine(self.value, 0.0),
            (false, false) => Self::from(self.value * other.value),
        }
    }
}

impl Div for Jet {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        match (self.moves, other.moves) {
            (true, true) => self.quotient(other),
            (true, false) => Self::moving(self.value / other.value, self.now * (1.0 / other.value)),
            (false, true) if self.value != 0.0 => other.reciprocal(self.value),
            _ => Self::from(self.value / other.value),
        }
    }
}

/// `self - other trunc(self / other)`.
impl Rem for Jet {
    type Output = Self;

    fn rem(self, other: Self) -> Self {
        let ratio = self / other;
        let own = ratio.value.trunc();
        // larger numbers have no fraction
        if own.is_nan() || own.abs() >= 1e15 {
            return self - other * Self::from(own);
        }
        #[allow(clippy::cast_possible_truncation)] // a small whole number
        let whole = pieces::choose(ratio, own as i64, |whole| {
            let ends = match whole {
                0 => [-1, 1],
                1.. => [whole, whole + 1],
                _ => [whole - 1, whole],
            };
            ends.map(|end| Some(end as f64))
        });
        self - other * Self::from(whole as f64)
    }
}

impl Neg for Jet {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.affine(-1.0, 0.0)
    }
}

/// The operations with a plain number on either side, and in place.
macro_rules! others {
    ($($trait:ident $method:ident $assign:ident $in_place:ident),* $(,)?) => {
        $(
            impl $trait<f64> for Jet {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: f64) -> Self {
                    $trait::$method(self, Self::from(other))
                }
            }

            impl $trait<Jet> for f64 {
                type Output = Jet;

                #[inline(always)]
                fn $method(self, other: Jet) -> Jet {
                    $trait::$method(Jet::from(self), other)
                }
            }

            impl $assign for Jet {
                #[inline(always)]
                fn $in_place(&mut self, other: Self) {
                    *self = $trait::$method(*self, other);
                }
            }

            impl $assign<f64> for Jet {
                #[inline(always)]
                fn $in_place(&mut self, other: f64) {
                    *self = $trait::$method(*self, Self::from(other));
                }
            }
        )*
    };
}

others!(
    Add add AddAssign add_assign,
    Sub sub SubAssign sub_assign,
    Mul mul MulAssign mul_assign,
    Div div DivAssign div_assign,
    Rem rem RemAssign rem_assign,
);

impl Sum for Jet {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::from(0.0), Add::add)
    }
}

impl<'a> Sum<&'a Self> for Jet {
    fn sum<I: Iterator<Item = &'a Self>>(terms: I) -> Self {
        terms.copied().sum()
    }
}

impl Product for Jet {
    fn product<I: Iterator<Item = Self>>(factors: I) -> Self {
        factors.fold(Self::from(1.0), Mul::mul)
    }
}

impl<'a> Product<&'a Self> for Jet {
    fn product<I: Iterator<Item = &'a Self>>(factors: I) -> Self {
        factors.copied().product()
    }
}

impl PartialEq for Jet {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl PartialOrd for Jet {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        compare(*self, *other)
    }
}

impl PartialEq<f64> for Jet {
    fn eq(&self, other: &f64) -> bool {
        self.value == *other
    }
}

impl PartialOrd<f64> for Jet {
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        compare(*self, Self::from(*other))
    }
}

impl fmt::Display for Jet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.value, f)
    }
}
