//! Compensated sums, which carry their rounding errors along.

// parts of every step, also of those that are compiled for the machine's own instructions
#![allow(clippy::inline_always)]

use crate::number::scalar::Scalar;

/// A vector of numbers, each as an unevaluated sum `hi + lo` with `hi` the sum rounded to double precision.
// aligned: a pair of numbers is read and written at once, which is slower across the end of a cache line
#[repr(align(16))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Compensated<const N: usize, T = f64> {
    /// The rounded values.
    pub hi: [T; N],
    /// Their rounding errors.
    pub lo: [T; N],
}

impl<T: Scalar, const N: usize> Compensated<N, T> {
    /// Numbers that are known exactly.
    pub fn exact(hi: [T; N]) -> Self {
        Self {
            hi,
            lo: [T::splat(0.0); N],
        }
    }

    /// Adds numbers of plain double precision.
    #[inline(always)]
    pub fn add(&mut self, term: &[T; N]) {
        for (i, &term) in term.iter().enumerate() {
            (self.hi[i], self.lo[i]) = add((self.hi[i], self.lo[i]), term);
        }
    }

    /// `self + term`, with the low parts of both.
    #[inline(always)]
    #[must_use]
    pub fn plus(&self, term: &Self) -> Self {
        let mut result = *self;
        for i in 0..N {
            (result.hi[i], result.lo[i]) = plus((self.hi[i], self.lo[i]), (term.hi[i], term.lo[i]));
        }
        result
    }

    /// The negative.
    #[must_use]
    pub fn negated(&self) -> Self {
        Self {
            hi: negative(&self.hi),
            lo: negative(&self.lo),
        }
    }
}

/// The negative.
fn negative<T: Scalar, const N: usize>(x: &[T; N]) -> [T; N] {
    let mut negative = *x;
    for x in &mut negative {
        *x = -*x;
    }
    negative
}

/// Adds numbers of plain double precision to compensated sums.
#[inline]
pub(crate) fn add_all(hi: &mut [f64], lo: &mut [f64], term: &[f64]) {
    for ((hi, lo), &term) in hi.iter_mut().zip(lo).zip(term) {
        (*hi, *lo) = add((*hi, *lo), term);
    }
}

/// Adds compensated sums, given by their high and low parts, to others.
#[inline]
pub(crate) fn plus_all([hi, lo]: [&mut [f64]; 2], [term_hi, term_lo]: [&[f64]; 2]) {
    let terms = term_hi.iter().zip(term_lo);
    for ((hi, lo), (&term_hi, &term_lo)) in hi.iter_mut().zip(lo).zip(terms) {
        (*hi, *lo) = plus((*hi, *lo), (term_hi, term_lo));
    }
}

/// Adds a number of plain double precision to a compensated sum.
#[inline(always)]
pub(crate) fn add<T: Scalar>((hi, lo): (T, T), term: T) -> (T, T) {
    let (sum, error) = two_sum(hi, term);
    fast_two_sum(sum, error + lo)
}

/// Adds two compensated sums.
#[inline(always)]
pub(crate) fn plus<T: Scalar>((hi, lo): (T, T), (term_hi, term_lo): (T, T)) -> (T, T) {
    let (sum, error) = two_sum(hi, term_hi);
    fast_two_sum(sum, error + (lo + term_lo))
}

/// The rounded sum and its rounding error, exactly (Knuth's `TwoSum`; no condition on the magnitudes).
#[inline(always)]
fn two_sum<T: Scalar>(a: T, b: T) -> (T, T) {
    let sum = a + b;
    let b_virtual = sum - a;
    let a_virtual = sum - b_virtual;
    (sum, (a - a_virtual) + (b - b_virtual))
}

/// [`two_sum`] if `|a| >= |b|` (Dekker).
#[inline(always)]
fn fast_two_sum<T: Scalar>(a: T, b: T) -> (T, T) {
    let sum = a + b;
    (sum, b - (sum - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_tenths_make_their_exact_sum() {
        let mut sum = Compensated::exact([0.0]);
        for _ in 0..1_000_000 {
            sum.add(&[0.1]);
        }
        // 0.1 is 0.1 + 5.55e-18 in binary
        assert_eq!(sum.hi[0], 100_000.0);
        assert!((sum.lo[0] - 5.551_115_123_125_783e-12).abs() < 1e-22);
    }

    #[test]
    fn adding_and_taking_away_returns() {
        let start = Compensated::exact([3.0, -7.0]);
        let term = Compensated {
            hi: [0.1, 1e-9],
            lo: [1e-18, 3e-26],
        };
        let back = start.plus(&term).plus(&term.negated());
        assert_eq!(back.hi, start.hi);
        assert!(back.lo.iter().all(|lo| lo.abs() < 1e-30));
    }
}
