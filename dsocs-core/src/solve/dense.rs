//! Small dense matrices and their singular values.
//!
//! The matrices have as many rows as a system has equations. They are decomposed at the start of a run or in
//! an analysis, never in a step. One-sided rotations (Hestenes 1958, de Rijk 1989) find small singular values
//! to full relative accuracy and take a page; a library of linear algebra takes longer to compile than all
//! other dependencies of this crate.

use crate::number::inner_product;
use core::ops::{Index, IndexMut};

use crate::solve::elimination::inverse_power_of_two;

/// Two columns are orthogonal if the cosine of their angle is below this.
const ORTHOGONAL: f64 = 2.0 * f64::EPSILON;

/// Largest number of sweeps over all pairs of columns; convergence is quadratic.
const SWEEPS: usize = 60;

/// A singular value below this part of the largest is zero, where rows and columns have entries of about 1.
pub(crate) const ZERO: f64 = 1e-11;

/// Number of passes that scale rows and columns in turn.
const SCALINGS: usize = 4;

/// A matrix, by columns.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Matrix {
    /// The number of rows.
    rows: usize,
    /// The columns.
    columns: Vec<Vec<f64>>,
}

impl Matrix {
    /// The matrix with `entry(i, j)` in row `i` and column `j`.
    pub(crate) fn from_fn(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let column = |j| (0..rows).map(|i| entry(i, j)).collect();
        Self {
            rows,
            columns: (0..columns).map(column).collect(),
        }
    }

    /// A matrix of zeros.
    pub(crate) fn zeros(rows: usize, columns: usize) -> Self {
        Self::from_fn(rows, columns, |_, _| 0.0)
    }

    /// The entries of a row.
    pub(crate) fn row(&self, i: usize) -> impl Iterator<Item = f64> {
        self.columns.iter().map(move |column| column[i])
    }

    /// Divides a row by a number.
    pub(crate) fn divide_row(&mut self, i: usize, by: f64) {
        for column in &mut self.columns {
            column[i] /= by;
        }
    }

    /// Divides every column by its length and returns the lengths.
    pub(crate) fn normalize_columns(&mut self) -> Vec<f64> {
        let lengths: Vec<f64> = self.columns.iter().map(|column| length(column)).collect();
        for (column, length) in self.columns.iter_mut().zip(&lengths) {
            for x in column.iter_mut() {
                *x /= length;
            }
        }
        lengths
    }

    /// Whether all entries are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.columns.iter().flatten().all(|x| x.is_finite())
    }

    /// The transpose.
    pub(crate) fn transposed(&self) -> Self {
        Self::from_fn(self.columns.len(), self.rows, |i, j| self[(j, i)])
    }

    /// The sum with another matrix of the same size.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self::from_fn(self.rows, self.columns.len(), |i, j| self[(i, j)] + other[(i, j)])
    }

    /// The product with another matrix.
    pub(crate) fn times(&self, other: &Self) -> Self {
        let columns = other.columns.iter().map(|column| self.times_vector(column));
        Self {
            rows: self.rows,
            columns: columns.collect(),
        }
    }

    /// The product with a vector.
    pub(crate) fn times_vector(&self, vector: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.rows];
        for (column, &factor) in self.columns.iter().zip(vector) {
            add(&mut product, factor, column);
        }
        product
    }

    /// The inverse of a square matrix, whose rows may differ in size by hundreds of orders of magnitude; not finite if it is singular.
    pub(crate) fn inverse(&self) -> Self {
        let n = self.rows;
        let mut left = self.clone();
        let mut right = Self::from_fn(n, n, |i, j| if i == j { 1.0 } else { 0.0 });
        for i in 0..n {
            let largest = left.row(i).fold(0.0_f64, |largest, x| largest.max(x.abs()));
            let scale = inverse_power_of_two(largest);
            for matrix in [&mut left, &mut right] {
                matrix.divide_row(i, scale.recip());
            }
        }
        for k in 0..n {
            // the row with the largest entry becomes the next
            let column = &left.columns[k];
            let pivot = (k..n).max_by(|&i, &j| column[i].abs().total_cmp(&column[j].abs()));
            let pivot = pivot.unwrap_or(k);
            for column in left.columns.iter_mut().chain(&mut right.columns) {
                column.swap(k, pivot);
            }
            let entry = left[(k, k)];
            let factors: Vec<f64> = left.columns[k].iter().map(|x| x / entry).collect();
            for column in left.columns.iter_mut().chain(&mut right.columns) {
                let pivot = column[k];
                for (i, (x, factor)) in column.iter_mut().zip(&factors).enumerate() {
                    *x = if i == k {
                        pivot / entry
                    } else {
                        *x - factor * pivot
                    };
                }
            }
        }
        right
    }

    /// Solves square equations of any scaling: rows and columns are divided by their sizes, `right` with its
    /// rows, and the matrix is decomposed. Returns the decomposition and the lengths of the columns, by which
    /// a solution is to be divided. `None` where they are not finite, or a column is zero.
    pub(crate) fn equilibrated(mut self, right: &mut [f64]) -> Option<(Singular, Vec<f64>)> {
        for (i, right) in right.iter_mut().enumerate() {
            let largest = self.row(i).fold(0.0_f64, |largest, x| largest.max(x.abs()));
            if largest > 0.0 {
                self.divide_row(i, largest);
                *right /= largest;
            }
        }
        let lengths = self.normalize_columns();
        let finite = self.is_finite() && right.iter().all(|x| x.is_finite());
        finite.then(|| (self.decomposed(), lengths))
    }

    /// Solves equations with a finite, symmetric, positive semidefinite matrix, such as the Gram matrix of
    /// constraint rows in a metric. Dependent rows are left out. The result does not depend on the rows'
    /// units.
    pub(crate) fn solve_metric(&self, wanted: &[f64]) -> Vec<f64> {
        let unit = |i: usize| {
            let unit = self[(i, i)].sqrt().recip();
            if unit.is_finite() { unit } else { 1.0 }
        };
        let units: Vec<f64> = (0..self.rows).map(unit).collect();
        let scaled = Self::from_fn(self.rows, self.rows, |i, j| units[i] * self[(i, j)] * units[j]);
        let right: Vec<f64> = wanted.iter().zip(&units).map(|(x, unit)| x * unit).collect();
        let mut solution = scaled.decomposed().solve(&right, f64::EPSILON);
        for (x, unit) in solution.iter_mut().zip(&units) {
            *x *= unit;
        }
        solution
    }

    /// The singular values with their vectors. The matrix has to be finite.
    pub(crate) fn decomposed(&self) -> Singular {
        if self.rows < self.columns.len() {
            let Singular { values, left, right } = self.transposed().decomposed();
            return Singular {
                values,
                left: right,
                right: left,
            };
        }
        let largest = self
            .columns
            .iter()
            .flatten()
            .fold(0.0_f64, |most, x| most.max(x.abs()));
        let scale = inverse_power_of_two(largest);
        let mut left = self.columns.clone();
        left.iter_mut().flatten().for_each(|x| *x *= scale);
        let mut right = Self::from_fn(left.len(), left.len(), |i, j| if i == j { 1.0 } else { 0.0 }).columns;
        for _ in 0..SWEEPS {
            let mut rotated = false;
            for q in 1..left.len() {
                for p in 0..q {
                    if let Some(rotation) = rotation(&left[p], &left[q]) {
                        rotate(&mut left, [p, q], rotation);
                        rotate(&mut right, [p, q], rotation);
                        rotated = true;
                    }
                }
            }
            if !rotated {
                break;
            }
        }
        let mut values = Vec::with_capacity(left.len());
        for column in &mut left {
            let value = length(column);
            if value > 0.0 {
                for x in column.iter_mut() {
                    *x /= value;
                }
            }
            values.push(value / scale);
        }
        Singular { values, left, right }
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.columns[j][i]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.columns[j][i]
    }
}

/// A matrix as the sum `Σ σ u vᵀ`, in no order, of `min(rows, columns)` terms.
#[derive(Clone, Debug)]
pub(crate) struct Singular {
    /// The singular values `σ`.
    pub(crate) values: Vec<f64>,
    /// The left singular vectors `u`; zero where `σ` is.
    left: Vec<Vec<f64>>,
    /// The right singular vectors `v`. If the matrix has at least as many rows as columns, they are a basis.
    pub(crate) right: Vec<Vec<f64>>,
}

impl Singular {
    /// The smallest and the largest singular value; `[1, 1]` for an empty matrix.
    pub(crate) fn extremes(&self) -> [f64; 2] {
        let fold = |of: fn(f64, f64) -> f64| self.values.iter().copied().reduce(of).unwrap_or(1.0);
        [fold(f64::min), fold(f64::max)]
    }

    /// The least-squares solution of least norm; singular values up to `zero` count as zero.
    pub(crate) fn solve(&self, wanted: &[f64], zero: f64) -> Vec<f64> {
        let mut solution = vec![0.0; self.right.first().map_or(0, Vec::len)];
        for ((&value, left), right) in self.values.iter().zip(&self.left).zip(&self.right) {
            if value > zero {
                add(&mut solution, inner_product(left, wanted) / value, right);
            }
        }
        solution
    }
}

/// The cosine and the sine of the rotation that makes two columns orthogonal; `None` if they are.
fn rotation(p: &[f64], q: &[f64]) -> Option<[f64; 2]> {
    let (pp, qq, pq) = (inner_product(p, p), inner_product(q, q), inner_product(p, q));
    if pq.abs() <= ORTHOGONAL * (pp * qq).sqrt() {
        return None;
    }
    let cotangent = (qq - pp) / (2.0 * pq);
    let tangent = cotangent.signum() / (cotangent.abs() + 1.0_f64.hypot(cotangent));
    let cosine = 1.0_f64.hypot(tangent).recip();
    Some([cosine, cosine * tangent])
}

/// Rotates two columns.
fn rotate(columns: &mut [Vec<f64>], [p, q]: [usize; 2], [cosine, sine]: [f64; 2]) {
    let (before, after) = columns.split_at_mut(q);
    for (x, y) in before[p].iter_mut().zip(&mut after[0]) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
}

/// The length of a vector, without overflow.
pub(crate) fn length(x: &[f64]) -> f64 {
    let largest = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let scale = inverse_power_of_two(largest);
    x.iter().map(|x| (x * scale) * (x * scale)).sum::<f64>().sqrt() / scale
}

/// Adds a multiple of a vector to another.
fn add(sum: &mut [f64], factor: f64, vector: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(vector) {
        *sum += factor * x;
    }
}

/// A basis of the null space of a square matrix; the largest component of each vector is 1.
pub(crate) fn null_directions(mut matrix: Matrix, size: usize) -> Vec<Vec<f64>> {
    let scales = equilibrate(&mut matrix, size);
    let directions = null_vectors(&matrix, ZERO).into_iter().map(|mut vector| {
        let mut largest = 0.0_f64;
        for (x, scale) in vector.iter_mut().zip(&scales) {
            *x *= scale;
            largest = largest.max(x.abs());
        }
        vector.iter().map(|x| x / largest).collect()
    });
    directions.collect()
}

/// Scales rows and columns in turn until their largest entries are about 1, and returns the factors of the
/// columns. Rows and columns of zeros stay zero.
pub(crate) fn equilibrate(matrix: &mut Matrix, size: usize) -> Vec<f64> {
    let mut scales = vec![1.0; size];
    for _ in 0..SCALINGS {
        for i in 0..size {
            let largest = matrix.row(i).fold(0.0_f64, |largest, x| largest.max(x.abs()));
            if largest > 0.0 {
                matrix.divide_row(i, largest);
            }
        }
        for (j, scale) in scales.iter_mut().enumerate() {
            let largest = (0..size).fold(0.0_f64, |largest, i| largest.max(matrix[(i, j)].abs()));
            if largest > 0.0 {
                *scale /= largest;
                for i in 0..size {
                    matrix[(i, j)] /= largest;
                }
            }
        }
    }
    scales
}

/// A basis of the null space of a matrix with at least as many rows as columns.
pub(crate) fn null_vectors(matrix: &Matrix, zero: f64) -> Vec<Vec<f64>> {
    let singular = matrix.decomposed();
    let [_, largest] = singular.extremes();
    let terms = singular.values.iter().zip(singular.right);
    let null = terms.filter(|(value, _)| **value <= zero * largest);
    null.map(|(_, vector)| vector).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The entries of Hilbert's matrix.
    fn hilbert(i: usize, j: usize) -> f64 {
        1.0 / (i + j + 1) as f64
    }

    /// The largest difference of two matrices' entries.
    fn apart(x: &Matrix, y: &Matrix) -> f64 {
        let pairs = x.columns.iter().flatten().zip(y.columns.iter().flatten());
        pairs.fold(0.0, |most, (x, y)| most.max((x - y).abs()))
    }

    #[test]
    fn the_terms_sum_to_the_matrix() {
        for (rows, columns) in [(5, 3), (3, 5), (4, 4), (1, 6), (6, 1)] {
            let matrix = Matrix::from_fn(rows, columns, |i, j| hilbert(i, j) - 0.2 * (3 * i + j) as f64);
            let Singular { values, left, right } = matrix.decomposed();
            assert_eq!(values.len(), rows.min(columns));
            let sum = Matrix::from_fn(rows, columns, |i, j| {
                (0..values.len())
                    .map(|k| values[k] * left[k][i] * right[k][j])
                    .sum()
            });
            assert!(apart(&sum, &matrix) < 1e-14, "{rows} × {columns}");
        }
    }

    #[test]
    fn the_smallest_value_of_hilberts_matrix() {
        // by 40 digits
        let [smallest, largest] = Matrix::from_fn(8, 8, hilbert).decomposed().extremes();
        assert!((largest - 1.695_938_996_921_949).abs() < 1e-14, "{largest}");
        assert!(
            (smallest - 1.111_538_966_372_442e-10).abs() < 1e-16,
            "{smallest:e}"
        );
    }

    #[test]
    fn the_inverse_is_the_inverse() {
        let entries = [[3e150, 1e150, 0.0], [1e-140, -2e-140, 5e-141], [0.0, 4.0, 1.0]];
        let matrix = Matrix::from_fn(3, 3, |i, j| entries[i][j]);
        let inverse = matrix.inverse();
        for (i, j) in (0..9).map(|place| (place / 3, place % 3)) {
            let terms = || matrix.row(i).zip(&inverse.columns[j]).map(|(a, b)| a * b);
            let product: f64 = terms().sum();
            let size: f64 = terms().map(f64::abs).sum();
            let identity = if i == j { 1.0 } else { 0.0 };
            assert!((product - identity).abs() < 1e-15 * size.max(1.0), "{product}");
        }
        let singular = Matrix::from_fn(2, 2, |i, j| ((i + 1) * (j + 1)) as f64);
        assert!(!singular.inverse().is_finite());
        assert!(!Matrix::zeros(2, 2).inverse().is_finite());
    }

    #[test]
    fn units_do_not_matter() {
        for unit in [1e-200, 1.0, 1e200] {
            let matrix = Matrix::from_fn(3, 2, |i, j| unit * [[3.0, 0.0], [0.0, 4.0], [0.0, 0.0]][i][j]);
            let [smallest, largest] = matrix.decomposed().extremes();
            assert!((smallest / unit - 3.0).abs() < 1e-15 && (largest / unit - 4.0).abs() < 1e-15);
            assert!((length(&[3.0 * unit, -4.0 * unit]) / unit - 5.0).abs() < 1e-15);
        }
    }

    #[test]
    fn the_shortest_of_many_solutions() {
        // x + y = 2 twice, one of them with an error of 2
        let matrix = Matrix::from_fn(2, 2, |_, _| 1.0);
        let solution = matrix.decomposed().solve(&[1.0, 3.0], f64::EPSILON);
        assert!(solution.iter().all(|x| (x - 1.0).abs() < 1e-15), "{solution:?}");
        assert_eq!(Matrix::zeros(2, 2).decomposed().values, [0.0, 0.0]);
    }
}
