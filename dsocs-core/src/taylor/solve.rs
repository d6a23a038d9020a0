//! Accelerations that are solved for in numbers: one matrix for all orders.
//!
//! The rows of the continuous system have at order `k` the form `J a_k + r_k = 0`, where `J` is their Jacobian at order 0
//! and `r_k` knows lower orders only. So the matrix is inverted once an expansion, and every order is one product with it.

use nalgebra::SMatrix;

use super::kernel::add_product;

/// How often the accelerations of order 0 are improved where the rows are not affine in them.
const MAX_ITERATIONS: u32 = 50;

/// How often they are improved where the rows are affine: once to solve, once for rounding.
const AFFINE_ITERATIONS: u32 = 2;

/// An update of this size, relative to the accelerations, is the last that matters.
const SMALL: f64 = 1e-9;

/// Solves for the accelerations of order 0 by Newton's iteration; returns the inverse of the rows' Jacobian there, NaN if
/// there is no solution.
///
/// `rows` takes an update, applies it, and gives the rows, their Jacobian, and the accelerations.
#[inline(always)]
pub fn accelerate<const M: usize>(
    affine: bool,
    rows: &mut impl FnMut([f64; M]) -> ([f64; M], [[f64; M]; M], [f64; M]),
) -> [[f64; M]; M] {
    let mut update = [0.0; M];
    let mut inverse = [[f64::NAN; M]; M];
    let limit = if affine { AFFINE_ITERATIONS } else { MAX_ITERATIONS };
    for iteration in 0..=limit {
        let (residual, jacobian, a) = rows(update);
        let size = |x: &[f64; M]| x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        // the Jacobian of affine rows is that of the first iteration
        if iteration == 0 || !affine {
            inverse = invert(&jacobian);
        }
        if affine && iteration == limit {
            return inverse;
        }
        // one more after an update that is small, for quadratic convergence
        if !affine && iteration > 0 && size(&update) <= SMALL * size(&a) {
            return inverse;
        }
        update = back::<false, M>(&inverse, &residual);
    }
    rows([f64::NAN; M]);
    [[f64::NAN; M]; M]
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

/// The inverse, by columns; rows may differ in size by hundreds of orders of magnitude. NaN if it is singular.
fn invert<const M: usize>(matrix: &[[f64; M]; M]) -> [[f64; M]; M] {
    let scales = matrix.map(|row| {
        let size = row.iter().fold(0.0_f64, |size, entry| size.max(entry.abs()));
        if size > 0.0 && size.is_finite() {
            1.0 / size
        } else {
            f64::NAN
        }
    });
    let scaled = SMatrix::<f64, M, M>::from_fn(|i, j| matrix[i][j] * scales[i]);
    match scaled.try_inverse() {
        Some(inverse) => core::array::from_fn(|j| core::array::from_fn(|i| inverse[(i, j)] * scales[j])),
        None => [[f64::NAN; M]; M],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn affine_rows_of_any_size_are_solved() {
        let matrix = [[3e150, 1e150, 0.0], [1e-140, -2e-140, 5e-141], [0.0, 4.0, 1.0]];
        let solution = [0.5, -2.0, 7.0];
        let right = matrix.map(|row| row.iter().zip(solution).map(|(m, x)| m * x).sum::<f64>());
        let mut a = [0.0; 3];
        let inverse = accelerate(true, &mut |update: [f64; 3]| {
            for i in 0..3 {
                a[i] += update[i];
            }
            let rows = core::array::from_fn(|i| (0..3).map(|j| matrix[i][j] * a[j]).sum::<f64>() - right[i]);
            (rows, matrix, a)
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
        let mut a = [1.0];
        let inverse = accelerate(false, &mut |update: [f64; 1]| {
            a[0] += update[0];
            ([a[0] * a[0] - 2.0], [[2.0 * a[0]]], a)
        });
        assert!((a[0] - 2.0_f64.sqrt()).abs() < 1e-15);
        assert!((inverse[0][0] - 0.5 / 2.0_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn no_solution_is_not_a_number() {
        let inverse = accelerate(true, &mut |_: [f64; 2]| {
            ([1.0, 2.0], [[1.0, 2.0], [2.0, 4.0]], [0.0; 2])
        });
        assert!(inverse.as_flattened().iter().all(|x| x.is_nan()));
        let mut a = [1.0];
        accelerate(false, &mut |update: [f64; 1]| {
            a[0] += update[0];
            ([a[0] * a[0] + 2.0], [[2.0 * a[0]]], a)
        });
        assert!(a[0].is_nan());
    }
}
