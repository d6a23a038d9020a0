//! Vectors of compensated sums, for any number of coordinates.

use crate::number::compensated::{Compensated, add, plus};
use crate::number::point::sized;
use crate::solve::Vector;

/// A vector of compensated sums `hi + lo`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sum {
    /// The rounded values.
    pub hi: Vector,
    /// Their rounding errors.
    pub lo: Vector,
}

impl Sum {
    /// Numbers that are known exactly.
    pub fn exact(hi: Vector) -> Self {
        Self {
            lo: Vector::zero(hi.len()),
            hi,
        }
    }

    /// The exact difference of two vectors, component by component.
    pub fn difference(left: &[f64], right: &[f64]) -> Self {
        let mut sum = Self::exact(Vector::of(left));
        sum.add(&Vector::of(right).map(|x| -x));
        sum
    }

    /// The negated sum.
    #[must_use]
    pub fn negated(&self) -> Self {
        Self {
            hi: self.hi.map(|x| -x),
            lo: self.lo.map(|x| -x),
        }
    }

    /// Adds numbers of plain double precision.
    pub fn add(&mut self, term: &[f64]) {
        for ((hi, lo), &term) in self.hi.iter_mut().zip(self.lo.iter_mut()).zip(term) {
            (*hi, *lo) = add((*hi, *lo), term);
        }
    }

    /// `self + term`, with the low parts of both.
    #[must_use]
    pub fn plus(&self, term: &Self) -> Self {
        let mut result = self.clone();
        let own = result.hi.iter_mut().zip(result.lo.iter_mut());
        for ((hi, lo), (&term_hi, &term_lo)) in own.zip(term.hi.iter().zip(term.lo.iter())) {
            (*hi, *lo) = plus((*hi, *lo), (term_hi, term_lo));
        }
        result
    }
}

impl<const N: usize> From<&Compensated<N>> for Sum {
    fn from(sums: &Compensated<N>) -> Self {
        Self {
            hi: Vector::of(&sums.hi),
            lo: Vector::of(&sums.lo),
        }
    }
}

impl<const N: usize> From<&Sum> for Compensated<N> {
    fn from(sums: &Sum) -> Self {
        Self {
            hi: sized(&sums.hi),
            lo: sized(&sums.lo),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_keeps_what_rounding_would_take() {
        let d = Sum::difference(&[1.0, 1e-20], &[1e-17, -1.0]);
        assert_eq!(d.hi[..], [1.0, 1.0]);
        assert_eq!(d.lo[..], [-1e-17, 1e-20]);
    }
}
