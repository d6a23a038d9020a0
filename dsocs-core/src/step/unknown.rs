//! The unknowns of a step and the linear equations of one Newton update.

use core::fmt::Debug;

use crate::scalar::Scalar;

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
        U::solve(&self.jacobian, &self.rows.zip(&self.rows, |row, _| -row))
    }

    /// Newton's update without a look at it, and whether it can be trusted if it is finite (see
    /// [`Unknown::solve_quick`]).
    #[inline]
    #[must_use]
    pub(crate) fn quick_update(mut self) -> (U, bool) {
        // the sign changes last, where it becomes part of the sum with the unknowns
        let mut update = self.rows;
        let safe = U::solve_quick(&mut self.jacobian, &mut update);
        (update.zip(&update, |x, _| -x), safe)
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

    /// A function of the components of two vectors, one by one.
    #[must_use]
    fn zip(&self, other: &Self, function: impl Fn(T, T) -> T) -> Self;

    /// Solves `matrix · z = right`.
    ///
    /// Rows may differ in size by hundreds of orders of magnitude. One unknown is a division and two are Cramer's
    /// rule (four products and one division in all); more are Gauss elimination with row-scaled partial pivoting.
    /// Nothing is allocated.
    ///
    /// `None` if in any lane the solution is not finite: the matrix is singular, or something was not finite.
    #[must_use]
    fn solve(matrix: &Self::Square, right: &Self) -> Option<Self>;

    /// Puts the solution of `matrix · z = right` in the place of `right`, but does not look at it: it may be infinite or
    /// NaN. Rows of three and more unknowns are taken as they are, and destroyed. If the solution is finite, `true` says
    /// that neither overflow nor underflow has harmed it.
    #[must_use]
    fn solve_quick(matrix: &mut Self::Square, right: &mut Self) -> bool;

    /// Solves `matrix · z = right` in every lane by itself, with the operations of [`Unknown::solve_quick`].
    ///
    /// In lanes without a solution that is finite and can be trusted some component is infinite or NaN.
    #[must_use]
    fn solve_lanes(matrix: &Self::Square, right: &Self) -> Self;
}

impl<T: Scalar, const M: usize> Unknown<T> for [T; M] {
    type Square = [[T; M]; M];

    #[inline]
    fn zero() -> Self {
        [T::splat(0.0); M]
    }

    #[inline]
    fn zip(&self, other: &Self, function: impl Fn(T, T) -> T) -> Self {
        core::array::from_fn(|i| function(self[i], other[i]))
    }

    #[inline]
    fn solve(matrix: &[[T; M]; M], right: &Self) -> Option<Self> {
        // M is a literal where this is compiled: one branch is left
        let solution = match M {
            1 => {
                let mut solution = *right;
                solution[0] = right[0] / matrix[0][0];
                solution
            }
            2 => cramer(matrix, right).unwrap_or_else(|| eliminate_scaled(matrix, right)),
            _ => eliminate_scaled(matrix, right),
        };
        solution
            .iter()
            .all(|&x| every_lane(x, f64::is_finite))
            .then_some(solution)
    }

    #[inline]
    fn solve_quick(matrix: &mut [[T; M]; M], right: &mut Self) -> bool {
        match M {
            1 => {
                right[0] = right[0] / matrix[0][0];
                true
            }
            2 => {
                let determinant = determinant(matrix);
                *right = quotients(matrix, right, determinant);
                is_safe(determinant)
            }
            _ => {
                let [smallest, largest] = eliminate(matrix, right);
                every_lane(smallest, |x| x > SMALLEST_DETERMINANT)
                    && every_lane(largest, |x| x < LARGEST_DETERMINANT)
            }
        }
    }

    #[inline]
    fn solve_lanes(matrix: &[[T; M]; M], right: &Self) -> Self {
        match M {
            1 => {
                let mut solution = *right;
                solution[0] = right[0] / matrix[0][0];
                solution
            }
            2 => {
                let determinant = determinant(matrix);
                let (size, nan) = (determinant.abs(), T::splat(f64::NAN));
                let bounded = T::select_lt(size, T::splat(LARGEST_DETERMINANT), determinant, nan);
                let safe = T::select_lt(T::splat(SMALLEST_DETERMINANT), size, bounded, nan);
                quotients(matrix, right, safe)
            }
            _ => {
                let (mut matrix, mut solution) = (*matrix, *right);
                let [smallest, largest] = eliminate(&mut matrix, &mut solution);
                let nan = T::splat(f64::NAN);
                solution.map(|x| {
                    let bounded = T::select_lt(largest, T::splat(LARGEST_DETERMINANT), x, nan);
                    T::select_lt(T::splat(SMALLEST_DETERMINANT), smallest, bounded, nan)
                })
            }
        }
    }
}

/// Determinants must be larger than this for Cramer's rule, and pivots of rows as they are.
const SMALLEST_DETERMINANT: f64 = 1e-100;

/// Determinants must be smaller than this for Cramer's rule, and pivots of rows as they are.
const LARGEST_DETERMINANT: f64 = 1e100;

/// Whether a number is as wanted in every lane.
#[inline]
fn every_lane<T: Scalar>(x: T, wanted: impl Fn(f64) -> bool) -> bool {
    (0..T::LANES).all(|lane| wanted(x.lane(lane)))
}

/// Cramer's rule for two equations, where neither overflow nor underflow can harm it.
#[inline]
fn cramer<T: Scalar, const M: usize>(matrix: &[[T; M]; M], right: &[T; M]) -> Option<[T; M]> {
    let determinant = determinant(matrix);
    is_safe(determinant).then(|| quotients(matrix, right, determinant))
}

/// Whether neither overflow nor underflow has harmed Cramer's rule with this determinant.
#[inline]
fn is_safe<T: Scalar>(determinant: T) -> bool {
    every_lane(determinant, |x| {
        x.abs() > SMALLEST_DETERMINANT && x.abs() < LARGEST_DETERMINANT
    })
}

/// The determinant of two rows.
#[inline]
fn determinant<T: Scalar, const M: usize>(matrix: &[[T; M]; M]) -> T {
    matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0]
}

/// The quotients of Cramer's rule.
#[inline]
fn quotients<T: Scalar, const M: usize>(matrix: &[[T; M]; M], right: &[T; M], determinant: T) -> [T; M] {
    let ([a, b], [c, d]) = ([matrix[0][0], matrix[0][1]], [matrix[1][0], matrix[1][1]]);
    let scale = determinant.recip();
    let mut solution = *right;
    solution[0] = (right[0] * d - b * right[1]) * scale;
    solution[1] = (a * right[1] - c * right[0]) * scale;
    solution
}

/// Gauss elimination of rows that are first brought to a common size.
fn eliminate_scaled<T: Scalar, const M: usize>(matrix: &[[T; M]; M], right: &[T; M]) -> [T; M] {
    let mut a = *matrix;
    let mut x = *right;
    for (row, x) in a.iter_mut().zip(&mut x) {
        let size = row.iter().fold(T::splat(0.0), |size, entry| {
            T::select_lt(size, entry.abs(), entry.abs(), size)
        });
        let [scale] = T::from_lanes(|lane| [inverse_power_of_two(size.lane(lane))]);
        *row = row.map(|entry| entry * scale);
        *x = *x * scale;
    }
    eliminate(&mut a, &mut x);
    x
}

/// Brings the row with the largest entry in column `k`, from row `k` down, to the place `k`, in each lane by itself.
fn exchange<T: Scalar, const M: usize>(a: &mut [[T; M]; M], x: &mut [T; M], k: usize) {
    let place = |i: usize| T::splat(i as f64);
    let (mut pivot, mut largest) = (place(k), a[k][k].abs());
    for (i, row) in a.iter().enumerate().skip(k + 1) {
        let size = row[k].abs();
        pivot = T::select_lt(largest, size, place(i), pivot);
        largest = T::select_lt(largest, size, size, largest);
    }
    for i in k + 1..M {
        let change = |upper: &mut T, lower: &mut T| {
            let (u, l) = (*upper, *lower);
            let here = |then: T, otherwise: T| {
                let not_before = T::select_le(place(i), pivot, then, otherwise);
                T::select_le(pivot, place(i), not_before, otherwise)
            };
            (*upper, *lower) = (here(l, u), here(u, l));
        };
        let (head, tail) = a.split_at_mut(i);
        for j in k..M {
            change(&mut head[k][j], &mut tail[0][j]);
        }
        let (head, tail) = x.split_at_mut(i);
        change(&mut head[k], &mut tail[0]);
    }
}

/// Takes column `k` out of the rows below `k`, the one with its largest entry first.
#[inline(always)]
#[allow(clippy::inline_always, clippy::needless_range_loop)] // with a literal `k` no loop and no index is left of it
fn take_out<T: Scalar, const M: usize>(a: &mut [[T; M]; M], x: &mut [T; M], inverse: &mut [T; M], k: usize) {
    if T::LANES == 1 {
        let (mut pivot, mut largest) = (k, a[k][k].abs().lane(0));
        for i in k + 1..M {
            let size = a[i][k].abs().lane(0);
            if largest < size {
                (pivot, largest) = (i, size);
            }
        }
        if pivot != k {
            a.swap(k, pivot);
            x.swap(k, pivot);
        }
    } else {
        exchange(a, x, k);
    }
    inverse[k] = a[k][k].recip();
    for i in k + 1..M {
        let factor = a[i][k] * inverse[k];
        for j in k + 1..M {
            a[i][j] = a[i][j] - factor * a[k][j];
        }
        x[i] = x[i] - factor * x[k];
    }
}

/// Gauss elimination with partial pivoting, in place. The result is the absolute value of the smallest and that of the
/// largest pivot.
///
/// Several lanes exchange rows by selection instead of branches, because they may differ in their pivots.
fn eliminate<T: Scalar, const M: usize>(a: &mut [[T; M]; M], x: &mut [T; M]) -> [T; 2] {
    /// Up to so many columns stand one after the other, each with loops of lengths that are known.
    const UNROLLED: usize = 8;
    let mut inverse = *x; // of the pivots
    if M <= UNROLLED {
        macro_rules! columns {
            ($($k:literal)*) => {
                $(if $k < M { take_out(a, x, &mut inverse, $k); })*
            };
        }
        columns!(0 1 2 3 4 5 6 7);
    } else {
        for k in 0..M {
            take_out(a, x, &mut inverse, k);
        }
    }
    let (mut smallest, mut largest) = (T::splat(f64::INFINITY), T::splat(0.0));
    for k in (0..M).rev() {
        let value = x[k] * inverse[k];
        x[k] = value;
        for i in 0..k {
            x[i] = x[i] - a[i][k] * value;
        }
        let size = a[k][k].abs();
        smallest = T::select_lt(size, smallest, size, smallest);
        largest = T::select_lt(largest, size, size, largest);
    }
    [smallest, largest]
}

/// The power of two that brings a positive number into `[1, 2)`, as far as a normal number can; 1 for zero, NaN for
/// infinity.
fn inverse_power_of_two(size: f64) -> f64 {
    if size == 0.0 {
        return 1.0;
    }
    if size == f64::INFINITY {
        return f64::NAN;
    }
    let exponent = (size.to_bits() >> 52) & 0x7ff;
    f64::from_bits(2046_u64.saturating_sub(exponent).clamp(1, 2045) << 52)
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
        assert_eq!(line.update(), Some([-1.5, 2.0]));
    }
}
