//! Elimination of any number of rows on slices, with the operations of arrays in the same order, so the same
//! bits.

use super::many;
use super::{
    Determinant, FEW, LARGEST_DETERMINANT, Pivots, SMALLEST_DETERMINANT, exchange_where,
    inverse_power_of_two, is_safe, sign_of,
};
use crate::number::scalar::Scalar;
use crate::solve::Vector;

/// Puts the solution of `matrix · z = right` in the place of `right`; rows may differ in size by hundreds of
/// orders of magnitude. Not finite where the matrix is singular. Returns the determinant. The matrix is
/// destroyed; `room` has two numbers for each row.
#[inline]
pub(crate) fn solve(matrix: &mut [f64], right: &mut [f64], room: &mut [f64]) -> Determinant {
    match (&mut *matrix, &mut *right) {
        ([a], [x]) => {
            *x /= *a;
            Determinant::of(*a)
        }
        ([a, b, c, d], [x, y]) => {
            let determinant = *a * *d - *b * *c;
            if is_safe(determinant) {
                (*x, *y) = quotients([*a, *b, *c, *d], [*x, *y]);
            } else {
                solve_scaled(matrix, right, room);
            }
            Determinant::of(determinant)
        }
        _ => solve_scaled(matrix, right, room),
    }
}

/// [`solve`] for three and more rows, which are first brought to a common size.
fn solve_scaled(matrix: &mut [f64], right: &mut [f64], room: &mut [f64]) -> Determinant {
    let size = right.len();
    let (inverse, scales) = room.split_at_mut(size);
    scale_rows(matrix, right, scales);
    let pivots = many::eliminate(matrix, right, inverse);
    let diagonal = matrix.iter().step_by(size + 1).zip(scales);
    Determinant::of_pivots(diagonal.map(|(pivot, scale)| *pivot / *scale), pivots.sign < 0.0)
}

/// [`solve`] without scaling of the rows. If the solution is finite, `true` says that neither overflow nor
/// underflow has harmed it. The second result is the determinant. `room` has at least as many numbers as
/// there are rows.
#[inline]
pub(crate) fn solve_quick(matrix: &mut [f64], right: &mut [f64], room: &mut [f64]) -> (bool, Determinant) {
    match (&mut *matrix, &mut *right) {
        ([a], [x]) => {
            *x /= *a;
            (true, Determinant::of(*a))
        }
        ([a, b, c, d], [x, y]) => {
            let determinant = *a * *d - *b * *c;
            (*x, *y) = quotients([*a, *b, *c, *d], [*x, *y]);
            (is_safe(determinant), Determinant::of(determinant))
        }
        _ => {
            let size = right.len();
            let pivots = many::eliminate(matrix, right, room);
            let safe = pivots.smallest > SMALLEST_DETERMINANT && pivots.largest < LARGEST_DETERMINANT;
            (safe, of_diagonal(matrix, size, &pivots))
        }
    }
}

/// Puts the solution of `matrix · z = right` in the place of `right`, in every lane by itself. If
/// `are_scaled`, the rows are first brought to a common size, with the operations of
/// [`Unknown::solve_scaled`](crate::solve::unknown::Unknown::solve_scaled) for three rows and more, otherwise
/// with those of [`Unknown::solve_lanes`](crate::solve::unknown::Unknown::solve_lanes). In lanes without a
/// reliable solution some component is infinite or NaN. Returns the determinants, in the units of `scales`.
/// The matrix is destroyed; `room` has two numbers for each row.
#[inline(always)]
#[allow(clippy::inline_always)] // for the machine's own instructions
pub(crate) fn solve_lanes<T: Scalar>(
    matrix: &mut [T],
    right: &mut [T],
    room: &mut [T],
    scales: &[T; 2],
    are_scaled: bool,
) -> T {
    let size = right.len();
    let (inverse, of_rows) = room.split_at_mut(size);
    if are_scaled {
        let rows = matrix.chunks_exact_mut(size.max(1));
        for ((row, x), of_row) in rows.zip(&mut *right).zip(&mut *of_rows) {
            let mut largest = T::splat(0.0);
            for entry in &*row {
                let entry = entry.abs();
                largest = T::select_lt(largest, entry, entry, largest);
            }
            [*of_row] = T::from_lanes(|lane| [inverse_power_of_two(largest.lane(lane))]);
            for entry in row {
                *entry = *entry * *of_row;
            }
            *x = *x * *of_row;
        }
    }
    let Pivots {
        smallest,
        largest,
        sign,
    } = eliminate_lanes(matrix, right, inverse);
    let mut determinants = sign;
    for (k, (&pivot, &of_row)) in matrix.iter().step_by(size + 1).zip(&*of_rows).enumerate() {
        let pivot = if are_scaled { pivot / of_row } else { pivot };
        determinants = determinants * (pivot * scales[k.min(1)]);
    }
    if !are_scaled {
        let nan = T::splat(f64::NAN);
        for x in right {
            let bounded = T::select_lt(largest, T::splat(LARGEST_DETERMINANT), *x, nan);
            *x = T::select_lt(T::splat(SMALLEST_DETERMINANT), smallest, bounded, nan);
        }
    }
    determinants
}

/// Gauss elimination with partial pivoting in every lane by itself, in place. The pivots stay on the diagonal; `inverse` has room for their reciprocals.
#[inline(always)]
#[allow(clippy::inline_always)] // for the machine's own instructions
fn eliminate_lanes<T: Scalar>(matrix: &mut [T], right: &mut [T], inverse: &mut [T]) -> Pivots<T> {
    let size = right.len();
    let mut sign = T::splat(1.0);
    for k in 0..size {
        let (_, rest) = matrix.split_at_mut(k * size);
        let (row, below) = rest.split_at_mut(size);
        let (_, rest) = right.split_at_mut(k);
        let Some((x, x_below)) = rest.split_first_mut() else {
            continue;
        };
        // lanes may differ in their pivots: rows are exchanged by selection
        let (mut pivot, mut largest) = (T::splat(k as f64), row[k].abs());
        for (i, lower) in (k + 1..).zip(below.chunks_exact(size)) {
            let entry = lower[k].abs();
            pivot = T::select_lt(largest, entry, T::splat(i as f64), pivot);
            largest = T::select_lt(largest, entry, entry, largest);
        }
        for ((i, lower), x_lower) in (k + 1..).zip(below.chunks_exact_mut(size)).zip(&mut *x_below) {
            for (upper, lower) in row[k..].iter_mut().zip(&mut lower[k..]) {
                exchange_where(i, pivot, upper, lower);
            }
            exchange_where(i, pivot, x, x_lower);
        }
        sign = T::select_le(pivot, T::splat(k as f64), sign, -sign);
        inverse[k] = row[k].recip();
        for (lower, x_lower) in below.chunks_exact_mut(size).zip(x_below) {
            let factor = lower[k] * inverse[k];
            for (entry, &upper) in lower[k + 1..].iter_mut().zip(&row[k + 1..]) {
                *entry = *entry - factor * upper;
            }
            *x_lower = *x_lower - factor * *x;
        }
    }
    let (mut smallest, mut largest) = (T::splat(f64::INFINITY), T::splat(0.0));
    for k in (0..size).rev() {
        let value = right[k] * inverse[k];
        right[k] = value;
        for (x, &entry) in right[..k].iter_mut().zip(matrix[k..].iter().step_by(size)) {
            *x = *x - entry * value;
        }
        let pivot = matrix[k * size + k].abs();
        smallest = T::select_lt(pivot, smallest, pivot, smallest);
        largest = T::select_lt(largest, pivot, pivot, largest);
    }
    Pivots {
        smallest,
        largest,
        sign,
    }
}

/// The determinant of a matrix of `size` rows, which is destroyed; rows may differ in size by hundreds of
/// orders of magnitude.
pub(crate) fn determinant(matrix: &mut [f64], size: usize) -> Determinant {
    match matrix {
        [a] => Determinant::of(*a),
        [a, b, c, d] => Determinant::of(*a * *d - *b * *c),
        _ => {
            let (mut right, mut inverse) = (Vector::zero(size), Vector::zero(size));
            let pivots = many::eliminate(matrix, &mut right, &mut inverse);
            of_diagonal(matrix, size, &pivots)
        }
    }
}

/// The determinant from the pivots on the diagonal.
fn of_diagonal(matrix: &[f64], size: usize, pivots: &Pivots<f64>) -> Determinant {
    let diagonal = matrix.iter().step_by(size + 1).copied();
    Determinant::of_pivots(diagonal, pivots.sign < 0.0)
}

/// Cramer's rule.
#[inline]
fn quotients([a, b, c, d]: [f64; 4], [x, y]: [f64; 2]) -> (f64, f64) {
    let scale = (a * d - b * c).recip();
    ((x * d - b * y) * scale, (a * y - c * x) * scale)
}

/// The inverse of a square matrix, by columns; rows may differ in size by hundreds of orders of magnitude.
/// NaN if it is singular. Products and sums are rounded once if `FUSED`. The matrix is destroyed; `right` and
/// `inverse` are as large, and `pivots` has as many numbers as there are rows. Returns the sign of the
/// determinant.
#[inline(always)]
#[allow(clippy::inline_always)] // for the machine's own instructions
pub(crate) fn inverse<const FUSED: bool>(
    matrix: &mut [f64],
    right: &mut [f64],
    pivots: &mut [f64],
    inverse: &mut [f64],
) -> f64 {
    let mut sign = 1.0;
    let minus = |lower: f64, factor: f64, upper: f64| {
        if FUSED {
            (-factor).mul_add(upper, lower)
        } else {
            lower - factor * upper
        }
    };
    let size = pivots.len();
    let width = size.max(1);
    right.fill(0.0);
    for (i, (row, right)) in matrix
        .chunks_exact_mut(width)
        .zip(right.chunks_exact_mut(width))
        .enumerate()
    {
        right[i] = scale_row(row);
    }
    for k in 0..size {
        let (mut pivot, mut largest) = (k, matrix[k * size + k].abs());
        for i in k + 1..size {
            let entry = matrix[i * size + k].abs();
            if largest < entry {
                (pivot, largest) = (i, entry);
            }
        }
        if pivot != k {
            sign = -sign;
            for rows in [&mut *matrix, &mut *right] {
                let (upper, lower) = rows.split_at_mut(pivot * size);
                upper[k * size..(k + 1) * size].swap_with_slice(&mut lower[..size]);
            }
        }
        pivots[k] = matrix[k * size + k].recip();
        let (above, rest) = matrix.split_at_mut(k * size);
        let (row, below) = rest.split_at_mut(size);
        let (right_above, rest) = right.split_at_mut(k * size);
        let (right_row, right_below) = rest.split_at_mut(size);
        let others = above
            .chunks_exact_mut(width)
            .zip(right_above.chunks_exact_mut(width));
        let others = others.chain(
            below
                .chunks_exact_mut(width)
                .zip(right_below.chunks_exact_mut(width)),
        );
        for (other, right) in others {
            if size > FEW && other[k] == 0.0 {
                continue;
            }
            let factor = other[k] * pivots[k];
            for (lower, upper) in other[k + 1..].iter_mut().zip(&row[k + 1..]) {
                *lower = minus(*lower, factor, *upper);
            }
            for (lower, upper) in right.iter_mut().zip(&*right_row) {
                *lower = minus(*lower, factor, *upper);
            }
        }
    }
    if !pivots.iter().all(|pivot| pivot.is_finite()) {
        inverse.fill(f64::NAN);
        return f64::NAN;
    }
    for (j, column) in inverse.chunks_exact_mut(width).enumerate() {
        for (i, entry) in column.iter_mut().enumerate() {
            *entry = right[i * size + j] * pivots[i];
        }
    }
    sign_of(sign, pivots)
}

/// Scales a row by a power of two, so that all rows have a common size, and returns the factor.
fn scale_row(row: &mut [f64]) -> f64 {
    let size = row.iter().fold(
        0.0,
        |size, entry| {
            if size < entry.abs() { entry.abs() } else { size }
        },
    );
    let scale = inverse_power_of_two(size);
    for entry in row {
        *entry *= scale;
    }
    scale
}

/// Brings the rows to a common size by powers of two, and returns the factors in `scales`.
fn scale_rows(matrix: &mut [f64], right: &mut [f64], scales: &mut [f64]) {
    let rows = matrix.chunks_exact_mut(right.len().max(1));
    for ((row, x), scale) in rows.zip(right).zip(scales) {
        *scale = scale_row(row);
        *x *= *scale;
    }
}
