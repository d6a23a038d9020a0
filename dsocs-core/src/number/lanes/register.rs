//! The registers that hold eight numbers, one kind for each set of instructions.
//!
//! The registers for which the crate was compiled are those of [`wide`]. The others are used if the machine
//! turns out to have them when the program runs (see [`crate::number::instructions`]). No kind fuses products
//! with sums, so that all give the same bits.

// this code has to be inlined into functions that are compiled for the machine's own instructions
#![allow(clippy::inline_always)]

use core::fmt::Debug;

use wide::f64x8;

use super::LANES;

/// Eight numbers in registers. Masks are numbers whose bits are all set where something holds, and all clear elsewhere.
pub trait Register: Copy + Debug + Send + Sync + 'static {
    /// `value` in all eight lanes.
    fn splat(value: f64) -> Self;
    /// Eight numbers.
    fn new(numbers: [f64; LANES]) -> Self;
    /// The numbers.
    fn array(self) -> [f64; LANES];
    /// Sums.
    #[must_use]
    fn add(self, other: Self) -> Self;
    /// Differences.
    #[must_use]
    fn sub(self, other: Self) -> Self;
    /// Products.
    #[must_use]
    fn mul(self, other: Self) -> Self;
    /// Quotients.
    #[must_use]
    fn div(self, other: Self) -> Self;
    /// Absolute values.
    #[must_use]
    fn abs(self) -> Self;
    /// Square roots.
    #[must_use]
    fn sqrt(self) -> Self;
    /// The larger numbers; those of `other` where either is NaN.
    #[must_use]
    fn larger(self, other: Self) -> Self;
    /// The smaller numbers; those of `other` where either is NaN.
    #[must_use]
    fn smaller(self, other: Self) -> Self;
    /// The mask of `self < other`.
    #[must_use]
    fn below(self, other: Self) -> Self;
    /// The mask of `self <= other`.
    #[must_use]
    fn at_most(self, other: Self) -> Self;
    /// `then` where the mask holds, `otherwise` elsewhere.
    #[must_use]
    fn select(self, then: Self, otherwise: Self) -> Self;
    /// Bitwise and.
    #[must_use]
    fn and(self, other: Self) -> Self;
    /// Bitwise or.
    #[must_use]
    fn or(self, other: Self) -> Self;
    /// Bitwise exclusive or.
    #[must_use]
    fn xor(self, other: Self) -> Self;
    /// Sums of the bit patterns as integers.
    #[must_use]
    fn add_integers(self, other: Self) -> Self;
    /// Bit patterns shifted left.
    #[must_use]
    fn shift_left<const BY: i32>(self) -> Self;
    /// One bit for each lane of a mask, lane 0 in the lowest.
    fn mask_bits(self) -> u32;
}

/// The registers for which the crate was compiled.
impl Register for f64x8 {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self::splat(value)
    }

    #[inline(always)]
    fn new(numbers: [f64; LANES]) -> Self {
        Self::new(numbers)
    }

    #[inline(always)]
    fn array(self) -> [f64; LANES] {
        self.to_array()
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self / other
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    // the minimum and maximum instructions of this architecture return their second operand if either is NaN
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.fast_max(other)
    }

    #[cfg(not(target_arch = "x86_64"))]
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Register::select(Register::below(other, self), self, other)
    }

    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.fast_min(other)
    }

    #[cfg(not(target_arch = "x86_64"))]
    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Register::select(Register::below(self, other), self, other)
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self {
        self.simd_lt(other)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        self.simd_le(other)
    }

    #[inline(always)]
    fn select(self, then: Self, otherwise: Self) -> Self {
        f64x8::select(self, then, otherwise)
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self & other
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        self ^ other
    }

    #[inline(always)]
    fn add_integers(self, other: Self) -> Self {
        Self::from_bits(self.to_bits() + other.to_bits())
    }

    #[inline(always)]
    fn shift_left<const BY: i32>(self) -> Self {
        Self::from_bits(self.to_bits() << BY.unsigned_abs())
    }

    #[inline(always)]
    fn mask_bits(self) -> u32 {
        self.to_bitmask()
    }
}
