//! Linear equations by elimination with pivots, in numbers of single or twice the precision.

use core::ops::{Div, Mul, Sub};

/// The absolute value, rounded.
fn size(x: impl Into<f64>) -> f64 {
    x.into().abs()
}

/// A matrix as a product of triangular ones, with its rows in another order (L. N. Trefethen, D. Bau, *Numerical Linear Algebra*, lecture 21).
#[derive(Clone, Debug)]
pub struct Decomposed<T> {
    matrix: Vec<Vec<T>>,
    order: Vec<usize>,
}

impl<T> Decomposed<T>
where
    T: Copy + Sub<Output = T> + Mul<Output = T> + Div<Output = T> + From<f64> + Into<f64>,
{
    /// Decomposes a matrix; `None` if it is singular or not finite.
    #[must_use]
    pub fn new(mut matrix: Vec<Vec<T>>) -> Option<Self> {
        let count = matrix.len();
        let scales: Vec<f64> = matrix
            .iter()
            .map(|row| row.iter().fold(0.0_f64, |largest, x| largest.max(size(*x))))
            .collect();
        let mut order: Vec<usize> = (0..count).collect();
        for k in 0..count {
            let part = |row: usize| size(matrix[row][k]) / scales[row];
            let best = (k..count).max_by(|&i, &j| part(order[i]).total_cmp(&part(order[j])))?;
            order.swap(k, best);
            let pivot = matrix[order[k]].clone();
            if !size(pivot[k]).is_finite() || size(pivot[k]) == 0.0 {
                return None;
            }
            for &row in &order[k + 1..] {
                let factor = matrix[row][k] / pivot[k];
                matrix[row][k] = factor;
                if size(factor) == 0.0 {
                    continue;
                }
                for j in k + 1..count {
                    matrix[row][j] = matrix[row][j] - factor * pivot[j];
                }
            }
        }
        Some(Self { matrix, order })
    }

    /// Solves `matrix · x = right`.
    #[must_use]
    pub fn solve(&self, right: &[T]) -> Vec<T> {
        let count = right.len();
        let mut x: Vec<T> = self.order.iter().map(|&row| right[row]).collect();
        for i in 0..count {
            for j in 0..i {
                x[i] = x[i] - self.matrix[self.order[i]][j] * x[j];
            }
        }
        for i in (0..count).rev() {
            for j in i + 1..count {
                x[i] = x[i] - self.matrix[self.order[i]][j] * x[j];
            }
            x[i] = x[i] / self.matrix[self.order[i]][i];
        }
        x
    }

    /// The size of the smallest pivot: tiny where the matrix is nearly singular.
    #[must_use]
    pub fn smallest_pivot(&self) -> f64 {
        let rows = self.order.iter().enumerate();
        rows.map(|(k, &row)| size(self.matrix[row][k]))
            .fold(f64::INFINITY, f64::min)
    }

    /// `|matrix⁻¹| · sizes`: bounds of the errors of each unknown that errors of these sizes in the rows
    /// cause.
    #[must_use]
    pub fn spread(&self, sizes: &[f64]) -> Vec<f64> {
        let mut spread = vec![0.0; sizes.len()];
        for (row, size) in sizes.iter().enumerate() {
            let mut right = vec![T::from(0.0); sizes.len()];
            right[row] = T::from(1.0);
            for (spread, x) in spread.iter_mut().zip(self.solve(&right)) {
                *spread += self::size(x) * size;
            }
        }
        spread
    }
}
