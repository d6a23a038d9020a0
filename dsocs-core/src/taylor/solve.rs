//! Accelerations that are solved for in numbers: one matrix for all orders.
//!
//! The rows of the continuous system have at order `k` the form `J a_k + r_k = 0`, where `J` is their Jacobian at order 0
//! and `r_k` knows lower orders only. So the matrix is inverted once an expansion, and every order is one product with it.

use super::kernel::add_product;
use crate::step::convergence::{LAST_UPDATE, Update};
use crate::step::elimination::inverse;

/// How often the accelerations of order 0 are improved where the rows are not affine in them.
const MAX_ITERATIONS: u32 = 50;

/// How often they are improved where the rows are affine: once to solve, once for rounding.
const AFFINE_ITERATIONS: u32 = 2;

/// Newton's iteration for the accelerations of order 0.
///
/// It is a loop of the caller's: apply [`Accelerations::update`], form the rows, their Jacobian and the accelerations, and
/// hand them to [`Accelerations::improve`] until that says so. (A function that took the rows as a closure would not be
/// compiled for the machine's own instructions.)
#[derive(Clone, Copy, Debug)]
pub struct Accelerations<const M: usize> {
    affine: bool,
    iteration: u32,
    update: [f64; M],
    inverse: [[f64; M]; M],
    ended: bool,
}

impl<const M: usize> Accelerations<M> {
    /// The beginning; the rows may be affine in the accelerations.
    #[inline(always)]
    #[must_use]
    pub fn new(affine: bool) -> Self {
        Self {
            affine,
            iteration: 0,
            update: [0.0; M],
            inverse: [[f64::NAN; M]; M],
            ended: false,
        }
    }

    /// What is to be added to the accelerations; NaN if there is no solution.
    #[inline(always)]
    #[must_use]
    pub fn update(&self) -> [f64; M] {
        self.update
    }

    /// The inverse of the rows' Jacobian, by columns.
    #[inline(always)]
    #[must_use]
    pub fn inverse(&self) -> &[[f64; M]; M] {
        &self.inverse
    }

    /// Takes the rows; `false` if the accelerations are as good as they get.
    #[inline(always)]
    pub fn improve<const FUSED: bool>(
        &mut self,
        rows: &[f64; M],
        jacobian: &[[f64; M]; M],
        a: &[f64; M],
    ) -> bool {
        if self.ended {
            return false;
        }
        // the Jacobian of affine rows is that of the first iteration
        if self.iteration == 0 || !self.affine {
            self.inverse = inverse::<FUSED, M>(jacobian);
        }
        let largest = a.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        let last = Update {
            components: &self.update,
            unknowns: a,
            sizes: &[largest; M],
        };
        // after an update that is small one more has been made good by quadratic convergence
        let small = self.iteration > 0 && last.is_small(LAST_UPDATE);
        let limit = if self.affine {
            AFFINE_ITERATIONS
        } else {
            MAX_ITERATIONS
        };
        if (self.affine && self.iteration == limit) || (!self.affine && small) {
            return false;
        }
        if self.iteration == limit {
            (self.update, self.inverse, self.ended) = ([f64::NAN; M], [[f64::NAN; M]; M], true);
            return true;
        }
        self.update = back::<FUSED, M>(&self.inverse, rows);
        self.iteration += 1;
        true
    }
}

/// The solution of `J x + r = 0`.
#[inline(always)]
#[must_use]
pub fn back<const FUSED: bool, const M: usize>(inverse: &[[f64; M]; M], rows: &[f64; M]) -> [f64; M] {
    // column by column, so that the components stand in lanes
    let mut solution = [0.0; M];
    for (column, &row) in inverse.iter().zip(rows) {
        for i in 0..M {
            solution[i] = add_product::<FUSED>(solution[i], column[i], -row);
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
        let again = back::<false, 3>(&inverse, &right.map(|x| -x));
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
