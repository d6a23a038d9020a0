//! The eigenvalues of a real matrix, by the QR algorithm.
//!
//! The matrix is balanced, brought to Hessenberg form by elimination, and deflated by double QR steps with Francis' shifts (J. H. Wilkinson and
//! C. Reinsch, *Handbook for Automatic Computation II, Linear Algebra*, 1971: `balance`, `elmhes`, `hqr`).

/// Largest number of QR steps for one eigenvalue; three are usual.
const MAX_STEPS: u32 = 60;

/// After this many steps without convergence an exceptional shift is used.
const UNUSUAL: u32 = 10;

/// A row and its column are scaled only if this reduces the sum of their norms below this part of it.
const BALANCED: f64 = 0.95;

/// Largest number of balancing passes over all rows and columns.
const MAX_SCALINGS: usize = 100;

/// Real parts that differ by less than this part of the largest eigenvalue are ordered as equal.
const SAME: f64 = 1e-12;

/// The eigenvalues of a square matrix, given by its rows: real and imaginary part of each, from the largest real part to the least, then from the
/// largest imaginary part to the least, the one with the positive sign of a pair first. `None` if an entry is not finite, or the iteration does not converge.
pub(crate) fn eigenvalues(rows: &[Vec<f64>]) -> Option<Vec<[f64; 2]>> {
    let square = rows.iter().all(|row| row.len() == rows.len());
    if !square || rows.iter().flatten().any(|entry| !entry.is_finite()) {
        return None;
    }
    let mut matrix = Hessenberg(rows.to_vec());
    matrix.balance();
    matrix.reduce();
    let mut found = matrix.deflated()?;
    // real parts that differ by rounding alone are the same
    let size = found
        .iter()
        .fold(0.0_f64, |most, [re, im]| most.max(re.hypot(*im)));
    let part = |x: &[f64; 2]| {
        if size > 0.0 {
            (x[0] / size / SAME).round()
        } else {
            0.0
        }
    };
    found.sort_by(|x, y| {
        part(y)
            .total_cmp(&part(x))
            .then(y[1].abs().total_cmp(&x[1].abs()))
            .then(y[1].total_cmp(&x[1]))
    });
    Some(found)
}

/// A matrix on its way to Hessenberg form and to triangular form, by rows.
struct Hessenberg(Vec<Vec<f64>>);

/// The vector that defines a Householder reflection of the double step, and the size by which it was divided.
struct Bulge {
    parts: [f64; 3],
    size: f64,
}

impl Hessenberg {
    fn len(&self) -> usize {
        self.0.len()
    }

    /// Balances: scales each row and its column by powers of two, which do not round, until both have about
    /// the same norm.
    fn balance(&mut self) {
        let n = self.len();
        for _ in 0..MAX_SCALINGS {
            let mut changed = false;
            for i in 0..n {
                let others = || (0..n).filter(move |&j| j != i);
                let row: f64 = others().map(|j| self.0[i][j].abs()).sum();
                let column: f64 = others().map(|j| self.0[j][i].abs()).sum();
                if row == 0.0 || column == 0.0 {
                    continue;
                }
                let scale = (0.5 * (row / column).log2()).round().exp2();
                if !scale.is_normal() || (column * scale + row / scale) >= BALANCED * (column + row) {
                    continue;
                }
                changed = true;
                for j in 0..n {
                    self.0[i][j] /= scale;
                }
                for j in 0..n {
                    self.0[j][i] *= scale;
                }
            }
            if !changed {
                break;
            }
        }
    }

    /// Makes everything zero below the first subdiagonal, by elimination with pivots.
    fn reduce(&mut self) {
        let n = self.len();
        for m in 1..n.saturating_sub(1) {
            let pivot = (m..n).max_by(|&i, &j| self.0[i][m - 1].abs().total_cmp(&self.0[j][m - 1].abs()));
            let pivot = pivot.unwrap_or(m);
            if self.0[pivot][m - 1] == 0.0 {
                continue;
            }
            self.0.swap(pivot, m);
            for row in &mut self.0 {
                row.swap(pivot, m);
            }
            for i in m + 1..n {
                let factor = self.0[i][m - 1] / self.0[m][m - 1];
                if factor == 0.0 {
                    continue;
                }
                let upper = self.0[m].clone();
                for (entry, upper) in self.0[i].iter_mut().zip(&upper) {
                    *entry -= factor * upper;
                }
                self.0[i][m - 1] = 0.0;
                for row in &mut self.0 {
                    row[m] += factor * row[i];
                }
            }
        }
    }

    /// The eigenvalues of the matrix in Hessenberg form, split off at its end one by one or in pairs.
    fn deflated(&mut self) -> Option<Vec<[f64; 2]>> {
        let norm: f64 = self.0.iter().flatten().map(|entry| entry.abs()).sum();
        let mut found = Vec::with_capacity(self.len());
        let (mut count, mut steps, mut shifted) = (self.len(), 0, 0.0);
        while let Some(last) = count.checked_sub(1) {
            let first = self.split(last, norm);
            let [x, y, w] = self.corner(last);
            if first == last {
                found.push([x + shifted, 0.0]);
                (count, steps) = (count - 1, 0);
                continue;
            }
            if first + 1 == last {
                found.extend(pair(x, y, w).map(|[re, im]| [re + shifted, im]));
                (count, steps) = (count - 2, 0);
                continue;
            }
            if steps == MAX_STEPS {
                return None;
            }
            let mut shift = [x, y, w];
            if steps > 0 && steps % UNUSUAL == 0 {
                shifted += x;
                for i in 0..=last {
                    self.0[i][i] -= x;
                }
                let size = self.0[last][last - 1].abs() + self.0[last - 1][last - 2].abs();
                shift = [0.75 * size, 0.75 * size, -0.4375 * size * size];
            }
            steps += 1;
            self.double_step(first, last, shift);
        }
        Some(found)
    }

    /// First row of the unreduced block that ends at row `last`. The subdiagonal entry above it is zero to
    /// rounding, and is set to zero.
    fn split(&mut self, last: usize, norm: f64) -> usize {
        for l in (1..=last).rev() {
            let beside = self.0[l - 1][l - 1].abs() + self.0[l][l].abs();
            let beside = if beside == 0.0 { norm } else { beside };
            if self.0[l][l - 1].abs() <= f64::EPSILON * beside {
                self.0[l][l - 1] = 0.0;
                return l;
            }
        }
        0
    }

    /// The last two diagonal entries of a block, the last first, and the product of the two off-diagonal
    /// ones.
    fn corner(&self, last: usize) -> [f64; 3] {
        let a = &self.0;
        match last.checked_sub(1) {
            None => [a[last][last], 0.0, 0.0],
            Some(above) => [a[last][last], a[above][above], a[last][above] * a[above][last]],
        }
    }

    /// First row of a double step in the block `first..=last`, and its first reflection: two consecutive
    /// subdiagonal entries are small there.
    fn begin(&self, first: usize, last: usize, [x, y, w]: [f64; 3]) -> (usize, Bulge) {
        let a = &self.0;
        let mut m = last - 2;
        loop {
            let z = a[m][m];
            let (r, s) = (x - z, y - z);
            let mut parts = [
                (r * s - w) / a[m + 1][m] + a[m][m + 1],
                a[m + 1][m + 1] - z - r - s,
                a[m + 2][m + 1],
            ];
            let size: f64 = parts.iter().map(|part| part.abs()).sum();
            parts = parts.map(|part| part / size);
            let small = m > first && {
                let beside = a[m - 1][m - 1].abs() + z.abs() + a[m + 1][m + 1].abs();
                a[m][m - 1].abs() * (parts[1].abs() + parts[2].abs())
                    <= f64::EPSILON * parts[0].abs() * beside
            };
            if m == first || small {
                return (m, Bulge { parts, size: 1.0 });
            }
            m -= 1;
        }
    }

    /// A double QR step on the block between two places.
    fn double_step(&mut self, first: usize, last: usize, shift: [f64; 3]) {
        let (begin, mut bulge) = self.begin(first, last, shift);
        for i in begin + 2..=last {
            self.0[i][i - 2] = 0.0;
            if i > begin + 2 {
                self.0[i][i - 3] = 0.0;
            }
        }
        for k in begin..last {
            let three = k + 1 < last;
            if k > begin {
                let third = if three { self.0[k + 2][k - 1] } else { 0.0 };
                let parts = [self.0[k][k - 1], self.0[k + 1][k - 1], third];
                let size: f64 = parts.iter().map(|part| part.abs()).sum();
                let by = if size == 0.0 { 1.0 } else { size };
                bulge = Bulge {
                    parts: parts.map(|part| part / by),
                    size,
                };
            }
            let [p, q, r] = bulge.parts;
            let length = (p * p + q * q + r * r).sqrt();
            let length = if p < 0.0 { -length } else { length };
            if length == 0.0 {
                continue;
            }
            if k > begin {
                self.0[k][k - 1] = -length * bulge.size;
            } else if begin > first {
                self.0[k][k - 1] = -self.0[k][k - 1];
            }
            let p = p + length;
            let [x, y, z] = [p / length, q / length, r / length];
            let [q, r] = [q / p, r / p];
            for j in k..=last {
                let third = if three { r * self.0[k + 2][j] } else { 0.0 };
                let sum = self.0[k][j] + q * self.0[k + 1][j] + third;
                self.0[k][j] -= sum * x;
                self.0[k + 1][j] -= sum * y;
                if three {
                    self.0[k + 2][j] -= sum * z;
                }
            }
            for row in &mut self.0[first..=last.min(k + 3)] {
                let third = if three { z * row[k + 2] } else { 0.0 };
                let sum = x * row[k] + y * row[k + 1] + third;
                row[k] -= sum;
                row[k + 1] -= sum * q;
                if three {
                    row[k + 2] -= sum * r;
                }
            }
        }
    }
}

/// The eigenvalues of a 2×2 block, from its diagonal, the last entry first, and the product of the
/// off-diagonal entries.
fn pair(x: f64, y: f64, w: f64) -> [[f64; 2]; 2] {
    let p = 0.5 * (y - x);
    let square = p * p + w;
    let root = square.abs().sqrt();
    if square < 0.0 {
        return [[x + p, root], [x + p, -root]];
    }
    let z = p + if p < 0.0 { -root } else { root };
    let other = if z == 0.0 { x } else { x - w / z };
    [[x + z, 0.0], [other, 0.0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The companion matrix of a polynomial with the leading coefficient 1, given by the others from the constant on.
    fn companion(coefficients: &[f64]) -> Vec<Vec<f64>> {
        let n = coefficients.len();
        let entry = |i: usize, j: usize| match (i + 1 == n, j == i + 1) {
            (true, _) => -coefficients[j],
            (false, true) => 1.0,
            (false, false) => 0.0,
        };
        (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
    }

    /// The product of two polynomials, given by their coefficients from the constant on.
    fn product(x: &[f64], y: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; x.len() + y.len() - 1];
        for (i, x) in x.iter().enumerate() {
            for (j, y) in y.iter().enumerate() {
                product[i + j] += x * y;
            }
        }
        product
    }

    #[test]
    fn roots_of_polynomials() {
        // (x − 1)(x − 2)(x + 3)(x² + 2x + 5)
        let polynomial = product(
            &product(&[-1.0, 1.0], &[-2.0, 1.0]),
            &product(&[3.0, 1.0], &[5.0, 2.0, 1.0]),
        );
        let found = eigenvalues(&companion(&polynomial[..5])).unwrap_or_default();
        let expected = [[2.0, 0.0], [1.0, 0.0], [-1.0, 2.0], [-1.0, -2.0], [-3.0, 0.0]];
        for (found, expected) in found.iter().zip(expected) {
            let apart = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(apart < 1e-13, "{found:?} {expected:?}");
        }
        assert_eq!(found.len(), 5);
    }

    #[test]
    fn trace_and_determinant_of_random_matrices() {
        let mut seed = 11_u32;
        let mut number = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed) / f64::from(u32::MAX) - 0.5
        };
        for n in [1, 2, 3, 5, 8, 13, 20] {
            for units in [1.0, 1e6] {
                // every other row and column in another unit: the eigenvalues stay the same
                let unit = |i: usize| if i.is_multiple_of(2) { 1.0 } else { units };
                let rows: Vec<Vec<f64>> = (0..n)
                    .map(|i| (0..n).map(|j| number() * unit(i) / unit(j)).collect())
                    .collect();
                let found = eigenvalues(&rows).unwrap_or_default();
                assert_eq!(found.len(), n);
                let trace: f64 = (0..n).map(|i| rows[i][i]).sum();
                let squares: f64 = (0..n)
                    .map(|i| (0..n).map(|j| rows[i][j] * rows[j][i]).sum::<f64>())
                    .sum();
                let sum: f64 = found.iter().map(|x| x[0]).sum();
                let sum_of_squares: f64 = found.iter().map(|x| x[0] * x[0] - x[1] * x[1]).sum();
                let imaginary: f64 = found.iter().map(|x| x[1]).sum();
                assert!((sum - trace).abs() < 1e-13 * n as f64, "{sum} {trace}");
                assert!((sum_of_squares - squares).abs() < 1e-12 * n as f64);
                assert!(imaginary.abs() < 1e-14 * n as f64);
            }
        }
    }

    #[test]
    fn cyclic_rows_and_what_is_no_matrix() {
        // without an exceptional shift, the QR step is periodic here
        let cyclic = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vec::from);
        let found = eigenvalues(&cyclic).unwrap_or_default();
        for (found, expected) in
            found
                .iter()
                .zip([[1.0, 0.0], [-0.5, 0.75_f64.sqrt()], [-0.5, -(0.75_f64.sqrt())]])
        {
            assert!(
                (found[0] - expected[0]).hypot(found[1] - expected[1]) < 1e-14,
                "{found:?}"
            );
        }
        assert_eq!(found.len(), 3);
        assert_eq!(eigenvalues(&[]), Some(Vec::new()));
        assert_eq!(eigenvalues(&[vec![f64::NAN]]), None);
        assert_eq!(eigenvalues(&[vec![1.0, 2.0]]), None);
    }
}
