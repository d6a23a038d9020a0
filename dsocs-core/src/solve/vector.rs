//! Vectors and square matrices of any size, for code that is compiled once for all systems.
//!
//! Small ones are stored inline: up to [`FEW`] unknowns nothing is allocated.

use core::ops::{Deref, DerefMut};

use smallvec::{SmallVec, smallvec};

use crate::solve::elimination::{Determinant, slices};

/// Up to this many components are stored inline.
const FEW: usize = 8;

/// Up to this many entries are stored inline.
const FEW_ENTRIES: usize = 16;

/// Known values of a run or a step, such as those of its start; up to 32 are stored inline.
pub(crate) type Numbers = SmallVec<[f64; 32]>;

/// A vector.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Vector(SmallVec<[f64; FEW]>);

impl Vector {
    /// Zero.
    pub fn zero(size: usize) -> Self {
        Self(smallvec![0.0; size])
    }

    /// A vector of NaN: unknown values.
    pub fn nan(size: usize) -> Self {
        Self(smallvec![f64::NAN; size])
    }

    /// A copy of numbers.
    pub fn of(numbers: &[f64]) -> Self {
        Self(SmallVec::from_slice(numbers))
    }

    /// The numbers in a vector of the given size: cut off, or filled with zeros.
    pub fn resized(numbers: &[f64], size: usize) -> Self {
        let mut vector = Self::zero(size);
        for (x, number) in vector.iter_mut().zip(numbers) {
            *x = *number;
        }
        vector
    }

    /// The vector with the components `component(i)`.
    pub fn from_fn(size: usize, component: impl FnMut(usize) -> f64) -> Self {
        Self((0..size).map(component).collect())
    }

    /// A function of the components.
    pub fn map(&self, function: impl Fn(f64) -> f64) -> Self {
        self.zip(self, |x, _| function(x))
    }

    /// A function of the components of two vectors, one by one.
    pub fn zip(&self, other: &[f64], function: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = self.clone();
        for (x, y) in result.iter_mut().zip(other) {
            *x = function(*x, *y);
        }
        result
    }

    /// Whether all components are finite.
    pub fn is_finite(&self) -> bool {
        is_finite(self)
    }
}

/// Whether all numbers are finite.
pub(crate) fn is_finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

impl Deref for Vector {
    type Target = [f64];

    #[inline]
    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl DerefMut for Vector {
    #[inline]
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl AsRef<[f64]> for Vector {
    #[inline]
    fn as_ref(&self) -> &[f64] {
        &self.0
    }
}

impl AsMut<[f64]> for Vector {
    #[inline]
    fn as_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl<'a> IntoIterator for &'a Vector {
    type Item = &'a f64;
    type IntoIter = core::slice::Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a> IntoIterator for &'a mut Vector {
    type Item = &'a mut f64;
    type IntoIter = core::slice::IterMut<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl FromIterator<f64> for Vector {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        Self(numbers.into_iter().collect())
    }
}

/// A square matrix.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Square {
    /// The number of rows.
    size: usize,
    /// The entries, row by row.
    entries: SmallVec<[f64; FEW_ENTRIES]>,
}

impl Square {
    /// A matrix of zeros.
    pub fn zero(size: usize) -> Self {
        Self {
            size,
            entries: smallvec![0.0; size * size],
        }
    }

    /// The matrix with the entries `entry(i, j)`.
    pub fn from_fn(size: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let places = (0..size).flat_map(|i| (0..size).map(move |j| (i, j)));
        Self {
            size,
            entries: places.map(|(i, j)| entry(i, j)).collect(),
        }
    }

    /// The number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The rows.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.entries.chunks_exact(self.size.max(1))
    }

    /// The entries, row by row.
    pub fn entries(&self) -> &[f64] {
        &self.entries
    }

    /// The entries, row by row.
    pub fn entries_mut(&mut self) -> &mut [f64] {
        &mut self.entries
    }

    /// The product with a vector.
    pub fn times(&self, x: &[f64]) -> Vector {
        let product = |row: &[f64]| row.iter().zip(x).map(|(entry, x)| entry * x).sum();
        self.rows().map(product).collect()
    }

    /// Solves `matrix · z = right`; `None` if the solution is not finite. Rows may differ in size by hundreds of orders of magnitude.
    pub fn solve(&self, right: &[f64]) -> Option<Vector> {
        let mut solution = Vector::of(right);
        slices::solve(
            &mut self.entries.clone(),
            &mut solution,
            &mut Vector::zero(2 * self.size),
        );
        solution.is_finite().then_some(solution)
    }

    /// Puts the solution of `matrix · z = right` in the place of `right`, unchecked. If it is finite, `true`
    /// says that neither overflow nor underflow has harmed it. The second result is the determinant. The
    /// matrix is destroyed.
    pub fn solve_quick(&mut self, right: &mut [f64]) -> (bool, Determinant) {
        slices::solve_quick(&mut self.entries, right, &mut Vector::zero(right.len()))
    }

    /// The determinant.
    pub fn determinant(&self) -> Determinant {
        slices::determinant(&mut self.entries.clone(), self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::unknown::Unknown;

    /// Checks that slices give the same bits as arrays.
    fn compare<const M: usize>(matrix: &[[f64; M]; M], right: [f64; M]) {
        let square = Square::from_fn(M, |i, j| matrix[i][j]);
        let found = square.solve(&right);
        assert_eq!(
            found.as_deref(),
            <[f64; M]>::solve(matrix, &right).as_ref().map(|x| &x[..])
        );
        let (mut left, mut solution, mut quick) = (*matrix, right, Vector::of(&right));
        let expected = <[f64; M]>::solve_quick(&mut left, &mut solution);
        assert_eq!(square.clone().solve_quick(&mut quick), expected);
        assert_eq!(*quick, solution);
        assert_eq!(square.determinant(), <[f64; M]>::determinant(matrix));
    }

    #[test]
    fn solutions_are_those_of_arrays() {
        let mut seed = 7_u32;
        let mut number = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed) / f64::from(u32::MAX) - 0.5
        };
        for size in [1.0, 1e-70, 1e120] {
            compare(&[[size * number()]], [number()]);
            let mut one = || size * number();
            compare(&[[one(), one()], [one(), one()]], [one(), one()]);
            compare::<3>(
                &core::array::from_fn(|_| core::array::from_fn(|_| one())),
                core::array::from_fn(|_| one()),
            );
            compare::<5>(
                &core::array::from_fn(|_| core::array::from_fn(|_| one())),
                core::array::from_fn(|_| one()),
            );
            compare::<11>(
                &core::array::from_fn(|_| core::array::from_fn(|_| one())),
                core::array::from_fn(|_| one()),
            );
        }
        assert_eq!(Square::from_fn(2, |i, _| i as f64).solve(&[1.0, 1.0]), None);
        assert_eq!(Square::zero(0).solve(&[]), Some(Vector::zero(0)));
    }
}
