//! Eight numbers side by side, and masks of them.

// as in `register`
#![allow(clippy::inline_always)]

use core::fmt;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use wide::f64x8;

use crate::number::scalar::Scalar;

mod functions;
mod register;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
pub(crate) mod x86;

pub use register::Register;

/// The number of lanes.
pub(crate) const LANES: usize = 8;

/// Eight real numbers, one for each of eight trajectories that the generated code steps at once.
///
/// Arithmetic, roots and comparisons are those of `f64`, bit for bit. So are the functions that are not
/// listed here; they go through `f64`'s, lane by lane. The following have vector code of their own. Where an
/// argument is outside of the range, that lane goes through `f64`'s function.
///
/// | function | range of the vector code | error, in units in the last place |
/// |---|---|---|
/// | `sin`, `cos` | `\|x\| ≤ 10⁶` | below 1 |
/// | `exp` | `\|x\| ≤ 708` | below 1 |
/// | `exp_m1` | `\|x\| ≤ 708` | below 2 |
/// | `tanh` | all | below 2.5 |
///
/// A lane's result never depends on what the other lanes hold.
///
/// ```
/// use dsocs_core::__private::{Lanes, Scalar};
///
/// let x: Lanes = Lanes::from([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, f64::INFINITY]);
/// let y = x.tanh() + Lanes::splat(1.0);
/// assert_eq!(y.lane(0), 1.0);
/// assert_eq!(y.lane(7), 2.0);
/// ```
#[derive(Clone, Copy)]
pub struct Lanes<R = f64x8>(R);

impl<R: Register> From<[f64; LANES]> for Lanes<R> {
    #[inline(always)]
    fn from(lanes: [f64; LANES]) -> Self {
        Self(R::new(lanes))
    }
}

impl<R: Register> From<Lanes<R>> for [f64; LANES] {
    #[inline(always)]
    fn from(lanes: Lanes<R>) -> Self {
        lanes.0.array()
    }
}

impl<R: Register> PartialEq for Lanes<R> {
    fn eq(&self, other: &Self) -> bool {
        self.0.array() == other.0.array()
    }
}

impl<R: Register> fmt::Debug for Lanes<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Lanes").field(&self.0.array()).finish()
    }
}

/// A truth value for each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask<R = f64x8>(R);

impl<R: Register> Mask<R> {
    /// The same truth value in every lane.
    #[inline(always)]
    pub fn splat(holds: bool) -> Self {
        Self(R::splat(f64::from_bits(if holds { u64::MAX } else { 0 })))
    }

    /// The lanes whose bits are set, lane 0 in the lowest.
    #[inline(always)]
    pub fn from_bits(bits: u32) -> Self {
        let mut lanes = [0.0; LANES];
        for (lane, mask) in lanes.iter_mut().enumerate() {
            *mask = f64::from_bits(if bits >> lane & 1 == 1 { u64::MAX } else { 0 });
        }
        Self(R::new(lanes))
    }

    /// One bit a lane, lane 0 in the lowest.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0.mask_bits()
    }

    /// `then` in the lanes where the mask holds, `otherwise` in the others.
    #[inline(always)]
    pub fn select(self, then: Lanes<R>, otherwise: Lanes<R>) -> Lanes<R> {
        Lanes(self.0.select(then.0, otherwise.0))
    }
}

impl<R: Register> BitAnd for Mask<R> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0.and(other.0))
    }
}

impl<R: Register> BitOr for Mask<R> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0.or(other.0))
    }
}

impl<R: Register> Not for Mask<R> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.xor(Self::splat(true).0))
    }
}

impl<R: Register> Lanes<R> {
    /// The lanes where `self < other`; false where either is NaN.
    #[inline(always)]
    pub(crate) fn below(self, other: Self) -> Mask<R> {
        Mask(self.0.below(other.0))
    }

    /// The lanes where `self <= other`; false where either is NaN.
    #[inline(always)]
    pub(crate) fn at_most(self, other: Self) -> Mask<R> {
        Mask(self.0.at_most(other.0))
    }

    /// The lanes where the number is neither infinite nor NaN.
    #[inline(always)]
    pub(crate) fn finite(self) -> Mask<R> {
        self.abs().below(Self::splat(f64::INFINITY))
    }

    /// The numbers in registers of another kind.
    #[inline(always)]
    pub(crate) fn moved<Q: Register>(self) -> Lanes<Q> {
        Lanes(Q::new(self.0.array()))
    }

    /// Puts a number into one lane.
    #[inline]
    pub(crate) fn set_lane(&mut self, lane: usize, value: f64) {
        let mut lanes = self.0.array();
        lanes[lane] = value;
        *self = Self(R::new(lanes));
    }

    /// The same bit pattern in every lane.
    #[inline(always)]
    fn pattern(bits: u64) -> Self {
        Self(R::splat(f64::from_bits(bits)))
    }

    /// A function of `f64`, lane by lane.
    #[inline]
    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        Self(R::new(self.0.array().map(function)))
    }

    /// A function of `f64` with two arguments, lane by lane.
    #[inline]
    fn each_pair(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let (left, right) = (self.0.array(), other.0.array());
        Self(R::new(core::array::from_fn(|i| function(left[i], right[i]))))
    }
}

macro_rules! operator {
    ($($operator:ident $method:ident),* $(,)?) => {
        $(
            impl<R: Register> $operator for Lanes<R> {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self(Register::$method(self.0, other.0))
                }
            }
        )*
    };
}

operator!(Add add, Sub sub, Mul mul, Div div);

impl<R: Register> Neg for Lanes<R> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.xor(R::splat(-0.0)))
    }
}

macro_rules! lane_by_lane {
    ($($name:ident),* $(,)?) => {
        $(
            fn $name(self) -> Self {
                self.each(f64::$name)
            }
        )*
    };
}

impl<R: Register> Scalar for Lanes<R> {
    const LANES: usize = LANES;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(R::splat(value))
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0.array()[lane]
    }

    #[inline(always)]
    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        let mut lanes = [[0.0; LANES]; P];
        for lane in 0..LANES {
            for (numbers, value) in lanes.iter_mut().zip(function(lane)) {
                numbers[lane] = value;
            }
        }
        let mut results = [Self::splat(0.0); P];
        for (result, numbers) in results.iter_mut().zip(lanes) {
            *result = Self::from(numbers);
        }
        results
    }

    #[inline(always)]
    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        left.below(right).select(then, otherwise)
    }

    #[inline(always)]
    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        left.at_most(right).select(then, otherwise)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(self.0.larger(other.0))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Self(self.0.smaller(other.0))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline(always)]
    fn signum(self) -> Self {
        self.each(f64::signum)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        Self::splat(1.0) / self
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn exp(self) -> Self {
        functions::exp(self)
    }

    #[inline(always)]
    fn exp_m1(self) -> Self {
        functions::exp_m1(self)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        functions::sin(self)
    }

    #[inline(always)]
    fn cos(self) -> Self {
        functions::cos(self)
    }

    #[inline(always)]
    fn tanh(self) -> Self {
        functions::tanh(self)
    }

    lane_by_lane!(
        cbrt, ln, ln_1p, tan, asin, acos, atan, sinh, cosh, asinh, acosh, atanh
    );

    fn powf(self, exponent: Self) -> Self {
        self.each_pair(exponent, f64::powf)
    }

    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        // by repeated squares, as in `f64::powi`
        let (mut result, mut square, mut left) = (Self::splat(1.0), self, exponent.unsigned_abs());
        loop {
            if left & 1 == 1 {
                result = result * square;
            }
            left >>= 1;
            if left == 0 {
                break;
            }
            square = square * square;
        }
        if exponent < 0 { result.recip() } else { result }
    }

    fn atan2(self, x: Self) -> Self {
        self.each_pair(x, f64::atan2)
    }
}
