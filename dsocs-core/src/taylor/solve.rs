//! Accelerations that are solved for numerically: one matrix for all orders.
//!
//! At order `k` the rows of the continuous system are `J a_k + r_k = 0`, with their Jacobian `J` at order 0
//! and a remainder `r_k` of lower orders only. So the matrix is inverted once an expansion, and every order
//! is one product with it.

use crate::series::coefficient::Coefficient;
use crate::series::sums::add_product;
use crate::solve::convergence::{LAST_UPDATE, Update};
use crate::solve::elimination::slices;

/// Largest number of iterations for the accelerations of order 0, if the rows are not affine in them.
const MAX_ITERATIONS: u32 = 50;

/// Number of iterations if the rows are affine: one to solve, one for rounding.
const AFFINE_ITERATIONS: u32 = 2;

/// Newton's iteration for the accelerations of order 0.
///
/// The loop belongs to the caller: apply [`Accelerations::update`], form the rows, their Jacobian and the
/// accelerations, and pass them to [`Accelerations::improve`] until it returns `false`. (A function that took
/// the rows as a closure would not be compiled for the machine's own instructions.)
#[derive(Clone, Copy, Debug)]
pub struct Accelerations<T, const M: usize> {
    affine: bool,
    iteration: u32,
    update: [T; M],
    inverse: [[T; M]; M],
    sign: T,
    ended: bool,
    /// The motions that have converged, as bits, and the number of iterations for which all have.
    good: u32,
    again: u32,
}

impl<T: Coefficient, const M: usize> Accelerations<T, M> {
    /// The beginning; `affine` if the rows are affine in the accelerations.
    #[inline(always)]
    #[must_use]
    pub fn new(affine: bool) -> Self {
        Self {
            affine,
            iteration: 0,
            update: [T::splat(0.0); M],
            inverse: [[T::splat(f64::NAN); M]; M],
            sign: T::splat(f64::NAN),
            ended: false,
            good: 0,
            again: 0,
        }
    }

    /// The update to be added to the accelerations; NaN if there is no solution.
    #[inline(always)]
    #[must_use]
    pub fn update(&self) -> [T; M] {
        self.update
    }

    /// The inverse of the rows' Jacobian, by columns.
    #[inline(always)]
    #[must_use]
    pub fn inverse(&self) -> &[[T; M]; M] {
        &self.inverse
    }

    /// The sign of the determinant of the rows' Jacobian; it may be NaN if there is no solution.
    #[inline(always)]
    #[must_use]
    pub fn sign(&self) -> T {
        self.sign
    }

    /// Takes the rows; `false` once the accelerations have converged.
    #[inline(always)]
    pub fn improve<const FUSED: bool>(&mut self, rows: &[T; M], jacobian: &[[T; M]; M], a: &[T; M]) -> bool {
        if self.ended {
            return false;
        }
        // the Jacobian of affine rows is that of the first iteration
        if self.iteration == 0 || !self.affine {
            let (inverse, sign) = T::inverse::<FUSED, M>(jacobian);
            let good = self.good;
            [self.sign] = kept(good, &[self.sign], [sign]);
            for (old, new) in self.inverse.iter_mut().zip(inverse) {
                *old = kept(good, old, new);
            }
        }
        let limit = if self.affine {
            AFFINE_ITERATIONS
        } else {
            MAX_ITERATIONS
        };
        if self.affine && self.iteration == limit {
            return false;
        }
        if !self.affine && self.iteration > 0 && self.is_good(a) {
            return false;
        }
        if self.iteration == limit {
            self.ended = true;
            let nan = [T::splat(f64::NAN); M];
            self.update = kept(self.good, &[T::splat(0.0); M], nan);
            for column in &mut self.inverse {
                *column = kept(self.good, column, nan);
            }
            return true;
        }
        self.update = kept(
            self.good,
            &[T::splat(0.0); M],
            back::<FUSED, M, T>(&self.inverse, rows),
        );
        self.iteration += 1;
        true
    }

    /// Whether the accelerations of all motions have converged: after a small update, one more is exact by
    /// quadratic convergence.
    #[inline(always)]
    fn is_good(&mut self, a: &[T; M]) -> bool {
        for track in 0..T::TRACKS {
            let (update, a) = (self.update.map(|x| x.track(track)), a.map(|x| x.track(track)));
            let largest = a.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            let last = Update {
                components: &update,
                unknowns: &a,
                sizes: &[largest; M],
            };
            if last.is_small(LAST_UPDATE) {
                self.good |= 1 << track;
            }
        }
        let all = self.good == (1 << T::TRACKS) - 1;
        if all && self.again < T::AGAIN {
            // derivatives converge after the numbers at which they are taken
            self.again += 1;
            self.good = 0;
            return false;
        }
        all
    }
}

/// The new numbers, except for the motions of `bits`, which keep the old ones.
#[inline(always)]
fn kept<T: Coefficient, const M: usize>(bits: u32, old: &[T; M], new: [T; M]) -> [T; M] {
    if T::TRACKS == 1 || bits == 0 {
        return new;
    }
    core::array::from_fn(|i| {
        T::of_tracks(|track| {
            let from = if bits >> track & 1 == 1 { old[i] } else { new[i] };
            from.track(track)
        })
    })
}

/// [`Accelerations`] of one motion with any number of rows, with the same operations in the same order. Its
/// memory is allocated once.
#[derive(Clone, Debug)]
pub(super) struct AnyAccelerations {
    affine: bool,
    iteration: u32,
    ended: bool,
    /// The update to be added to the accelerations; NaN if there is no solution.
    pub update: Vec<f64>,
    /// The inverse of the rows' Jacobian, by columns.
    pub inverse: Vec<f64>,
    /// The sign of the determinant of the rows' Jacobian.
    pub sign: f64,
    pivots: Vec<f64>,
    right: Vec<f64>,
    sizes: Vec<f64>,
}

impl AnyAccelerations {
    /// The iteration for `rows` rows, which may be affine in the accelerations.
    pub fn new(affine: bool, rows: usize) -> Self {
        let vector = || vec![0.0; rows];
        let matrix = || vec![0.0; rows * rows];
        Self {
            affine,
            iteration: 0,
            ended: false,
            update: vector(),
            inverse: matrix(),
            sign: f64::NAN,
            pivots: vector(),
            right: matrix(),
            sizes: vector(),
        }
    }

    /// Begins an iteration.
    pub fn begin(&mut self) {
        (self.iteration, self.ended) = (0, false);
        self.update.fill(0.0);
        self.inverse.fill(f64::NAN);
        self.sign = f64::NAN;
    }

    /// Takes the rows, and their Jacobian row by row, which is destroyed; `false` once the accelerations have
    /// converged.
    #[inline(always)]
    pub fn improve<const FUSED: bool>(&mut self, rows: &[f64], jacobian: &mut [f64], a: &[f64]) -> bool {
        if self.ended {
            return false;
        }
        if self.iteration == 0 || !self.affine {
            self.sign =
                slices::inverse::<FUSED>(jacobian, &mut self.right, &mut self.pivots, &mut self.inverse);
        }
        let limit = if self.affine {
            AFFINE_ITERATIONS
        } else {
            MAX_ITERATIONS
        };
        if self.affine && self.iteration == limit || !self.affine && self.iteration > 0 && self.is_good(a) {
            return false;
        }
        if self.iteration == limit {
            self.ended = true;
            self.update.fill(f64::NAN);
            self.inverse.fill(f64::NAN);
            return true;
        }
        back_into::<FUSED>(&self.inverse, rows, &mut self.update);
        self.iteration += 1;
        true
    }

    /// See [`Accelerations::is_good`].
    fn is_good(&mut self, a: &[f64]) -> bool {
        let largest = a.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        self.sizes.fill(largest);
        let last = Update {
            components: &&self.update[..],
            unknowns: &a,
            sizes: &&self.sizes[..],
        };
        last.is_small(LAST_UPDATE)
    }
}

/// The solution of `J x + r = 0`, for any number of rows.
#[inline(always)]
pub(super) fn back_into<const FUSED: bool>(inverse: &[f64], rows: &[f64], solution: &mut [f64]) {
    solution.fill(0.0);
    for (column, &row) in inverse.chunks_exact(rows.len().max(1)).zip(rows) {
        for (x, &entry) in solution.iter_mut().zip(column) {
            *x = add_product::<FUSED, f64>(*x, entry, -row);
        }
    }
}

/// The solution of `J x + r = 0`.
#[inline(always)]
#[must_use]
pub fn back<const FUSED: bool, const M: usize, T: Coefficient>(
    inverse: &[[T; M]; M],
    rows: &[T; M],
) -> [T; M] {
    // column by column, so that the components are vectorised
    let mut solution = [T::splat(0.0); M];
    for (column, &row) in inverse.iter().zip(rows) {
        for i in 0..M {
            solution[i] = add_product::<FUSED, T>(solution[i], column[i], -row);
        }
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Follows the iteration for some rows.
    fn solve<const M: usize>(
        affine: bool,
        mut a: [f64; M],
        rows: impl Fn(&[f64; M]) -> ([f64; M], [[f64; M]; M]),
    ) -> ([f64; M], [[f64; M]; M]) {
        let mut accelerations = Accelerations::new(affine);
        loop {
            for (a, update) in a.iter_mut().zip(accelerations.update()) {
                *a += update;
            }
            let (residual, jacobian) = rows(&a);
            if !accelerations.improve::<false>(&residual, &jacobian, &a) {
                return (a, *accelerations.inverse());
            }
        }
    }

    /// Follows the iteration on slices.
    fn solve_any<const M: usize>(
        affine: bool,
        mut a: [f64; M],
        rows: impl Fn(&[f64; M]) -> ([f64; M], [[f64; M]; M]),
    ) -> ([f64; M], Vec<f64>) {
        let mut accelerations = AnyAccelerations::new(affine, M);
        accelerations.begin();
        loop {
            for (a, update) in a.iter_mut().zip(&accelerations.update) {
                *a += update;
            }
            let (residual, mut jacobian) = rows(&a);
            if !accelerations.improve::<false>(&residual, jacobian.as_flattened_mut(), &a) {
                return (a, accelerations.inverse.clone());
            }
        }
    }

    #[test]
    fn slices_take_the_steps_of_arrays() {
        let of_bits = |x: &[f64]| -> Vec<u64> { x.iter().map(|x| x.to_bits()).collect() };
        for affine in [true, false] {
            let rows = |a: &[f64; 2]| {
                let third = if affine { 0.0 } else { 0.1 };
                let row = [
                    3.0 * a[0] + a[1] + third * a[0].powi(3) - 1.0,
                    a[0] - 2.0 * a[1] - 0.3,
                ];
                (row, [[3.0 + 3.0 * third * a[0].powi(2), 1.0], [1.0, -2.0]])
            };
            let (one, inverse) = solve(affine, [0.5, 0.1], rows);
            let (other, columns) = solve_any(affine, [0.5, 0.1], rows);
            assert_eq!(of_bits(&one), of_bits(&other));
            assert_eq!(of_bits(inverse.as_flattened()), of_bits(&columns));
        }
        let none = |a: &[f64; 1]| ([a[0] * a[0] + 2.0], [[2.0 * a[0]]]);
        assert!(solve_any(false, [1.0], none).0[0].is_nan());
    }

    #[test]
    fn affine_rows_of_any_size_are_solved() {
        let matrix = [[3e150, 1e150, 0.0], [1e-140, -2e-140, 5e-141], [0.0, 4.0, 1.0]];
        let solution = [0.5, -2.0, 7.0];
        let right = matrix.map(|row| row.iter().zip(solution).map(|(m, x)| m * x).sum::<f64>());
        let (a, inverse) = solve(true, [0.0; 3], |a| {
            let rows = core::array::from_fn(|i| (0..3).map(|j| matrix[i][j] * a[j]).sum::<f64>() - right[i]);
            (rows, matrix)
        });
        for (a, x) in a.iter().zip(solution) {
            assert!((a - x).abs() < 1e-15 * x.abs(), "{a} {x}");
        }
        let again = back::<false, 3, f64>(&inverse, &right.map(|x| -x));
        for (a, x) in again.iter().zip(solution) {
            assert!((a - x).abs() < 1e-14 * x.abs(), "{a} {x}");
        }
    }

    #[test]
    fn rows_that_are_not_affine_take_newton() {
        let (a, inverse) = solve(false, [1.0], |a| ([a[0] * a[0] - 2.0], [[2.0 * a[0]]]));
        assert!((a[0] - 2.0_f64.sqrt()).abs() < 1e-15);
        assert!((inverse[0][0] - 0.5 / 2.0_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn no_solution_is_not_a_number() {
        let (_, inverse) = solve(true, [0.0; 2], |_| ([1.0, 2.0], [[1.0, 2.0], [2.0, 4.0]]));
        assert!(inverse.as_flattened().iter().all(|x| x.is_nan()));
        let (a, _) = solve(false, [1.0], |a| ([a[0] * a[0] + 2.0], [[2.0 * a[0]]]));
        assert!(a[0].is_nan());
    }
}
