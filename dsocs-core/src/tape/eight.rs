//! Eight numbers in plain loops, which the compiler vectorises for the machine.
//!
//! The instructions of [`Lanes`] are chosen when the crate is compiled. These loops become the machine's own
//! inside of [`crate::number::dispatch::run_wide`]. Products are never fused with sums, so the results are
//! the same everywhere.

// the optimiser has to see the loops where they are used
#![allow(clippy::inline_always)]

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::number::lanes::{LANES, Lanes};

/// Eight numbers.
#[repr(align(64))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eight(pub [f64; LANES]);

impl Eight {
    /// Their number.
    pub(crate) const COUNT: usize = LANES;

    /// Zeros.
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    /// `value` in all eight lanes.
    #[inline(always)]
    pub(crate) fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// The numbers of a function of the place.
    #[inline(always)]
    pub(crate) fn from_fn(mut function: impl FnMut(usize) -> f64) -> Self {
        let mut numbers = [0.0; LANES];
        for (place, number) in numbers.iter_mut().enumerate() {
            *number = function(place);
        }
        Self(numbers)
    }

    /// A function of each number.
    #[inline(always)]
    pub(crate) fn map(self, function: impl Fn(f64) -> f64) -> Self {
        let mut numbers = self.0;
        for number in &mut numbers {
            *number = function(*number);
        }
        Self(numbers)
    }

    /// A function of each two numbers.
    #[inline(always)]
    pub(crate) fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let mut numbers = self.0;
        for (number, other) in numbers.iter_mut().zip(other.0) {
            *number = function(*number, other);
        }
        Self(numbers)
    }

    /// A function of lanes.
    #[inline(always)]
    pub(crate) fn lanes(self, function: impl FnOnce(Lanes) -> Lanes) -> Self {
        Self(function(Lanes::from(self.0)).into())
    }
}

macro_rules! operators {
    ($($name:ident $method:ident),*) => {
        $(
            impl $name for Eight {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    self.zip(other, $name::$method)
                }
            }
        )*
    };
}

operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Eight {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(Neg::neg)
    }
}
