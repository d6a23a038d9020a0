//! The unknowns of a step and the linear equations of one Newton update.

// code for lanes is compiled for the machine's own instructions
#![allow(clippy::inline_always)]

use core::fmt::Debug;

use super::elimination::{
    Determinant, LARGEST_DETERMINANT, Pivots, SMALLEST_DETERMINANT, cramer, determinant, determinant_of,
    eliminate, eliminate_here, eliminate_scaled, eliminate_scaled_here, every_lane, is_safe, quotients,
};
use crate::number::scalar::Scalar;

/// Rows of equations and their Jacobian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearization<T: Scalar, U: Unknown<T>> {
    /// The rows' values.
    pub rows: U,
    /// `jacobian[i][j] = ∂rows[i]/∂z[j]`.
    pub jacobian: U::Square,
}

impl<T: Scalar, U: Unknown<T>> Linearization<T, U> {
    /// Newton's update `δ`, which solves `jacobian · δ = -rows`; `None` as for [`Unknown::solve`].
    #[inline]
    #[must_use]
    pub fn update(&self) -> Option<U> {
        self.update_and_determinant().0
    }

    /// Newton's update, and the determinant of the Jacobian.
    #[inline]
    #[must_use]
    pub(crate) fn update_and_determinant(&self) -> (Option<U>, Determinant) {
        U::solve_with_determinant(&self.jacobian, &self.rows.zip(&self.rows, |row, _| -row))
    }

    /// Newton's update unchecked, whether it can be trusted if it is finite, and the determinant (see
    /// [`Unknown::solve_quick`]). The Jacobian is destroyed.
    #[inline]
    #[must_use]
    pub(crate) fn quick_update(&mut self) -> (U, bool, Determinant) {
        // the sign changes last, where it becomes part of the sum with the unknowns
        let mut update = self.rows;
        let (safe, determinant) = U::solve_quick(&mut self.jacobian, &mut update);
        (update.zip(&update, |x, _| -x), safe, determinant)
    }
}

/// The unknowns of one step: `[T; M]`.
///
/// The trait keeps their number `M` out of every signature that does not need it.
pub trait Unknown<T: Scalar>: Copy + Debug + AsRef<[T]> + AsMut<[T]> {
    /// A square matrix of this size, row by row.
    type Square: Copy + Debug + AsRef<[Self]> + AsMut<[Self]>;

    /// Zero.
    #[must_use]
    fn zero() -> Self;

    /// A matrix of zeros.
    #[must_use]
    fn zeros() -> Self::Square;

    /// A function of the components of two vectors, one by one.
    #[must_use]
    fn zip(&self, other: &Self, function: impl Fn(T, T) -> T) -> Self;

    /// Solves `matrix · z = right`.
    ///
    /// Rows may differ in size by hundreds of orders of magnitude. One unknown is a division and two are Cramer's
    /// rule (four products and one division in all); more are Gauss elimination with row-scaled partial pivoting.
    /// Nothing is allocated.
    ///
    /// `None` if in any lane the solution is not finite: the matrix is singular, or an entry is not finite.
    #[inline]
    #[must_use]
    fn solve(matrix: &Self::Square, right: &Self) -> Option<Self> {
        Self::solve_with_determinant(matrix, right).0
    }

    /// The solution of [`Unknown::solve`], and the determinant of the first lane.
    #[must_use]
    fn solve_with_determinant(matrix: &Self::Square, right: &Self) -> (Option<Self>, Determinant);

    /// Puts the solution of `matrix · z = right` in the place of `right`, unchecked: it may be infinite or
    /// NaN. Three and more rows are taken unscaled, and destroyed. If the solution is finite, `true` says
    /// that neither overflow nor underflow has harmed it. The second result is the determinant, of the first
    /// lane.
    #[must_use]
    fn solve_quick(matrix: &mut Self::Square, right: &mut Self) -> (bool, Determinant);

    /// The matrix's determinant, of the first lane.
    #[must_use]
    fn determinant(matrix: &Self::Square) -> Determinant;

    /// Solves `matrix · z = right` in every lane by itself, with the operations of [`Unknown::solve`]. In
    /// lanes without a solution some component is infinite or NaN. The second result is the determinant, as
    /// for [`Unknown::solve_lanes`].
    #[must_use]
    fn solve_scaled(matrix: &Self::Square, right: &Self, scales: &[T; 2]) -> (Self, T);

    /// Solves `matrix · z = right` in every lane by itself, with the operations of [`Unknown::solve_quick`].
    ///
    /// In lanes without a finite, reliable solution some component is infinite or NaN. The second result is
    /// the determinant, lane by lane; that of three and more rows is multiplied by the first of `scales` and,
    /// for every row after the first, by the second.
    #[must_use]
    fn solve_lanes(matrix: &Self::Square, right: &Self, scales: &[T; 2]) -> (Self, T);
}

impl<T: Scalar, const M: usize> Unknown<T> for [T; M] {
    type Square = [[T; M]; M];

    #[inline]
    fn zero() -> Self {
        [T::splat(0.0); M]
    }

    #[inline]
    fn zeros() -> [[T; M]; M] {
        [[T::splat(0.0); M]; M]
    }

    #[inline(always)]
    fn zip(&self, other: &Self, function: impl Fn(T, T) -> T) -> Self {
        // a loop, not `array::from_fn`: each of the hundreds of instances would add a dozen of the library's
        // functions
        let mut result = *self;
        for (x, y) in result.iter_mut().zip(other) {
            *x = function(*x, *y);
        }
        result
    }

    #[inline]
    fn solve_with_determinant(matrix: &[[T; M]; M], right: &Self) -> (Option<Self>, Determinant) {
        // M is a literal in each instance: one branch is left
        let (solution, determinant) = match M {
            1 => {
                let mut solution = *right;
                solution[0] = right[0] / matrix[0][0];
                (solution, Determinant::of(matrix[0][0].lane(0)))
            }
            2 => {
                let determinant = determinant(matrix);
                let solution = cramer(matrix, right).unwrap_or_else(|| eliminate_scaled(matrix, right).0);
                (solution, Determinant::of(determinant.lane(0)))
            }
            _ => {
                let (solution, scaled) = eliminate_scaled(matrix, right);
                (solution, scaled.determinant())
            }
        };
        let finite = solution.iter().all(|&x| every_lane(x, f64::is_finite));
        (finite.then_some(solution), determinant)
    }

    #[inline]
    fn solve_quick(matrix: &mut [[T; M]; M], right: &mut Self) -> (bool, Determinant) {
        match M {
            1 => {
                right[0] = right[0] / matrix[0][0];
                (true, Determinant::of(matrix[0][0].lane(0)))
            }
            2 => {
                let determinant = determinant(matrix);
                *right = quotients(matrix, right, determinant);
                (is_safe(determinant), Determinant::of(determinant.lane(0)))
            }
            _ => {
                let pivots = eliminate(matrix, right);
                let safe = every_lane(pivots.smallest, |x| x > SMALLEST_DETERMINANT)
                    && every_lane(pivots.largest, |x| x < LARGEST_DETERMINANT);
                let diagonal = (0..M).map(|k| matrix[k][k].lane(0));
                (safe, Determinant::of_pivots(diagonal, pivots.sign.lane(0) < 0.0))
            }
        }
    }

    fn determinant(matrix: &[[T; M]; M]) -> Determinant {
        let mut first = [[0.0; M]; M];
        for (row, entries) in first.iter_mut().zip(matrix) {
            for (first, entry) in row.iter_mut().zip(entries) {
                *first = entry.lane(0);
            }
        }
        let matrix = first;
        match M {
            1 => Determinant::of(matrix[0][0]),
            2 => Determinant::of(determinant(&matrix)),
            _ => determinant_of(&matrix),
        }
    }

    #[inline(always)]
    fn solve_scaled(matrix: &[[T; M]; M], right: &Self, scales: &[T; 2]) -> (Self, T) {
        match M {
            1 => {
                let mut solution = *right;
                solution[0] = right[0] / matrix[0][0];
                (solution, matrix[0][0])
            }
            2 => {
                let determinant = determinant(matrix);
                let quick = quotients(matrix, right, determinant);
                if is_safe(determinant) {
                    return (quick, determinant);
                }
                let size = determinant.abs();
                let (slow, _) = eliminate_scaled_here(matrix, right);
                let mut solution = quick;
                for ((solution, quick), slow) in solution.iter_mut().zip(quick).zip(slow) {
                    let bounded = T::select_lt(size, T::splat(LARGEST_DETERMINANT), quick, slow);
                    *solution = T::select_lt(T::splat(SMALLEST_DETERMINANT), size, bounded, slow);
                }
                (solution, determinant)
            }
            _ => {
                let (solution, scaled) = eliminate_scaled_here(matrix, right);
                let mut determinant = scaled.sign;
                for (k, pivot) in scaled.pivots.iter().enumerate() {
                    determinant = determinant * (*pivot * scales[k.min(1)]);
                }
                (solution, determinant)
            }
        }
    }

    #[inline(always)]
    fn solve_lanes(matrix: &[[T; M]; M], right: &Self, scales: &[T; 2]) -> (Self, T) {
        match M {
            1 => {
                let mut solution = *right;
                solution[0] = right[0] / matrix[0][0];
                (solution, matrix[0][0])
            }
            2 => {
                let determinant = determinant(matrix);
                let (size, nan) = (determinant.abs(), T::splat(f64::NAN));
                let bounded = T::select_lt(size, T::splat(LARGEST_DETERMINANT), determinant, nan);
                let safe = T::select_lt(T::splat(SMALLEST_DETERMINANT), size, bounded, nan);
                (quotients(matrix, right, safe), determinant)
            }
            _ => {
                let (mut matrix, mut solution) = (*matrix, *right);
                let Pivots {
                    smallest,
                    largest,
                    sign,
                } = eliminate_here(&mut matrix, &mut solution);
                let nan = T::splat(f64::NAN);
                let solution = solution.map(|x| {
                    let bounded = T::select_lt(largest, T::splat(LARGEST_DETERMINANT), x, nan);
                    T::select_lt(T::splat(SMALLEST_DETERMINANT), smallest, bounded, nan)
                });
                let mut determinant = sign;
                for (k, row) in matrix.iter().enumerate() {
                    determinant = determinant * (row[k] * scales[k.min(1)]);
                }
                (solution, determinant)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const M: usize>(matrix: [[f64; M]; M], solution: [f64; M], tolerance: f64) {
        let right = matrix.map(|row| row.iter().zip(&solution).map(|(a, x)| a * x).sum());
        let found = <[f64; M]>::solve(&matrix, &right).expect("a regular matrix");
        for (found, x) in found.iter().zip(&solution) {
            assert!((found - x).abs() <= tolerance * x.abs(), "{found} {x}");
        }
    }

    #[test]
    fn small_systems_are_solved() {
        check([[4.0]], [0.25], 0.0);
        check([[0.0, 2.0], [3.0, 1.0]], [5.0, -7.0], 1e-15);
        check(
            [[0.0, 2.0, 1.0], [3.0, 1.0, 0.0], [1.0, 1.0, 1.0]],
            [5.0, -7.0, 2.0],
            1e-14,
        );
        check(
            [
                [0.0, 0.0, 0.0, 1.0],
                [0.0, 0.0, 2.0, 1.0],
                [0.0, 3.0, 1.0, 1.0],
                [4.0, 1.0, 1.0, 1.0],
            ],
            [1.0, 2.0, 3.0, 4.0],
            1e-14,
        );
        let hilbert: [[f64; 7]; 7] =
            core::array::from_fn(|i| core::array::from_fn(|j| 1.0 / (1 + i + j) as f64));
        check(hilbert, [1.0, -2.0, 3.0, -4.0, 5.0, -6.0, 7.0], 1e-6);
    }

    #[test]
    fn the_size_of_a_row_is_of_no_account() {
        for (first, second) in [
            (1e180, 1e-180),
            (1e-180, 1e-180),
            (1e180, 1e180),
            (1e-300, 1e300),
            (1.0, 1e-200),
        ] {
            let matrix = [[first, 2.0 * first], [-3.0 * second, second]];
            check(matrix, [0.5, -0.125], 1e-15);
            let matrix = [
                [first, 2.0 * first, first],
                [-3.0 * second, second, 0.0],
                [1.0, 1.0, -1.0],
            ];
            check(matrix, [0.5, -0.125, 3.0], 1e-14);
        }
    }

    #[test]
    fn a_singular_or_infinite_system_has_no_solution() {
        assert_eq!(<[f64; 1]>::solve(&[[0.0]], &[0.0]), None);
        assert_eq!(<[f64; 2]>::solve(&[[1.0, 2.0], [2.0, 4.0]], &[1.0, 2.0]), None);
        assert_eq!(<[f64; 2]>::solve(&[[0.0, 0.0], [0.0, 0.0]], &[0.0, 0.0]), None);
        assert_eq!(
            <[f64; 2]>::solve(&[[f64::NAN, 1.0], [0.0, 1.0]], &[1.0, 2.0]),
            None
        );
        assert_eq!(
            <[f64; 2]>::solve(&[[f64::INFINITY, 1.0], [0.0, 1.0]], &[1.0, 2.0]),
            None
        );
        assert_eq!(
            <[f64; 3]>::solve(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]], &[1.0; 3]),
            None
        );
    }

    #[test]
    fn an_update_is_minus_the_quotient() {
        let line = Linearization {
            rows: [3.0, 4.0],
            jacobian: [[2.0, 0.0], [0.0, -2.0]],
        };
        assert_eq!(
            line.update_and_determinant(),
            (Some([-1.5, 2.0]), Determinant::of(-4.0))
        );
    }
}
