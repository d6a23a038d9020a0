//! Constraints on positions and velocities that depend on each other.

use super::deficiency::{self, Deficiency, DependentRow};
use crate::number::bounded::Bounded;
use crate::number::inner_product;
use crate::number::point::{AnyPoint, map};
use crate::number::scalar::Scalar as _;
use crate::solve::Vector;
use crate::solve::dense::{Matrix, equilibrate, null_vectors};
use crate::start;
use crate::start::place::Place;
use crate::tape::declaration::Declaration;

/// On a straight path, which is not quite that of the motion, a constraint is dependent if its part that is
/// independent of those before it is below this part of its former value.
pub(crate) const NEARLY_DEPENDENT: f64 = 1e-2;

/// Numbers of a start are known to this many roundings, and what is within this many bounds of its rounding error is zero.
const ROUNDINGS: f64 = 4.0;

/// A combination of rows that is below this part of them may be zero to rounding.
const SMALL: f64 = 1e-6;

/// A row with at most this part of a combination does not take part in it.
const NO_PART: f64 = 1e-13;

/// The constraints that depend on each other at a start to within rounding, that of the start and that of their derivatives by the
/// accelerations. Each component of a combination of rows is compared with its own terms, so that rows and coordinates may have any units.
#[cold]
pub(crate) fn to_rounding(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    a: Option<&[f64]>,
) -> Option<Deficiency> {
    let count = declaration.constraints().into_iter().sum::<usize>();
    let (n, size) = (q.len(), declaration.shape().motion);
    if count < 2 || count > n {
        return None;
    }
    let known = |x: f64| Bounded::known(x, ROUNDINGS * f64::EPSILON * x.abs());
    let at = AnyPoint {
        t: known(t),
        q: &map(q, known),
        v: &map(v, known),
        a: &a.map_or_else(|| vec![Bounded::splat(0.0); n], |a| map(a, Bounded::splat)),
    };
    let rows = declaration.continuous_with_jacobian(at, &[]);
    let entry = |i: usize, j: usize| rows.get(size + i * size + j).copied();
    // an entry that is rounding must not be scaled up
    let value = |i: usize, j: usize| {
        let entry = entry(i, j).filter(|entry| entry.lane(0).abs() > ROUNDINGS * entry.error());
        entry.map_or(0.0, |entry| entry.lane(0))
    };
    let mut matrix = Matrix::from_fn(n, n, |j, i| if i < count { value(i, j) } else { 0.0 });
    if !matrix.is_finite() {
        return None;
    }
    let scales = equilibrate(&mut matrix, n);
    let lengths = |row: &Vec<f64>| inner_product(row, row).sqrt();
    let scaled: Vec<Vec<f64>> = (0..count)
        .map(|i| (0..n).map(|j| matrix[(j, i)]).collect())
        .collect();
    let sizes: Vec<f64> = scaled.iter().map(lengths).collect();
    let parts = independent_parts(scaled);
    if parts.iter().zip(sizes).all(|(part, size)| *part > SMALL * size) {
        return None;
    }
    let columns = Matrix::from_fn(n, count, |j, i| matrix[(j, i)]);
    let mut combinations = null_vectors(&columns, SMALL).into_iter().map(|combination| {
        let parts = combination.into_iter().zip(&scales);
        let parts = parts.map(|(part, scale)| if part.abs() > NO_PART { part * scale } else { 0.0 });
        parts.collect::<Vec<f64>>()
    });
    let vanishes = |combination: &Vec<f64>| {
        (0..n).all(|j| {
            let (mut sum, mut rounding) = (0.0, 0.0);
            for (i, part) in combination.iter().enumerate() {
                let Some(entry) = entry(i, j) else { return false };
                sum += part * entry.lane(0);
                rounding += part.abs() * (entry.error() + f64::EPSILON * entry.lane(0).abs());
            }
            sum.abs() <= ROUNDINGS * rounding
        })
    };
    let found = combinations.find(vanishes)?;
    let rows: Vec<DependentRow> = (0..count)
        .filter(|&i| found[i] != 0.0)
        .map(|i| deficiency::row(declaration, i))
        .collect();
    (rows.len() > 1).then(|| Deficiency {
        coordinates: Vec::new(),
        combined: false,
        massless: false,
        rows,
        at_guess_alone: false,
        unmet: false,
    })
}

/// The first constraint on positions or velocities whose part that is independent of those before it is, at
/// `place`, below a part of that at `other`.
pub(crate) fn dependent_row(
    declaration: &Declaration<'_>,
    place: &Place,
    other: &Place,
    dependent: f64,
) -> Option<DependentRow> {
    let sizes = slopes(declaration, other);
    let sizes = sizes.iter().map(|row| inner_product(row, row).sqrt());
    let parts = independent_parts(slopes(declaration, place));
    let found = parts
        .iter()
        .zip(sizes)
        .position(|(part, size)| *part <= dependent * size);
    found.map(|k| deficiency::row(declaration, k))
}

/// The first constraint on positions or velocities that is dependent, or nearly so, on those before it at a
/// place, compared with points beside.
#[cold]
pub(crate) fn dependent_at(declaration: &Declaration<'_>, place: &Place) -> Option<DependentRow> {
    let beside = Place {
        q: Vector::of(&deficiency::beside(&place.q, 1.0)),
        ..place.clone()
    };
    dependent_row(declaration, place, &beside, NEARLY_DEPENDENT)
}

/// The constraint on positions or velocities with the smallest part that is independent of those before it,
/// at a time, a position and a velocity; and that part, from 0 to 1, in the metric of the coordinates'
/// masses. The relative accuracy of a run is no better than the unit round-off divided by that part. `None`
/// for fewer than two such constraints.
#[must_use]
pub fn least_independent(
    declaration: &Declaration<'_>,
    t: f64,
    q: &[f64],
    v: &[f64],
) -> Option<(DependentRow, f64)> {
    if declaration.lower() < 2 {
        return None;
    }
    let place = Place::of_phase(t, Vector::of(q), Vector::of(v));
    let mass = start::mass_matrix(declaration, t, q, v);
    let mut rows = slopes(declaration, &place);
    for row in &mut rows {
        for (i, entry) in row.iter_mut().enumerate() {
            let own = mass[(i, i)].abs();
            if own > 0.0 {
                *entry /= own.sqrt();
            }
        }
    }
    let sizes: Vec<f64> = rows.iter().map(|row| inner_product(row, row).sqrt()).collect();
    let parts = independent_parts(rows).into_iter().zip(sizes);
    let parts = parts.map(|(part, size)| part / size).enumerate();
    let (k, least) = parts
        .filter(|(_, part)| part.is_finite())
        .min_by(|(_, one), (_, other)| one.total_cmp(other))?;
    Some((deficiency::row(declaration, k), least))
}

/// The lengths of the rows' parts that are independent of the rows before them.
fn independent_parts(rows: Vec<Vec<f64>>) -> Vec<f64> {
    let mut independent: Vec<Vec<f64>> = Vec::with_capacity(rows.len());
    let mut parts = Vec::with_capacity(rows.len());
    for mut row in rows {
        for other in &independent {
            let size = inner_product(other, other);
            if size > 0.0 {
                let along = inner_product(&row, other) / size;
                for (entry, other) in row.iter_mut().zip(other) {
                    *entry -= along * other;
                }
            }
        }
        parts.push(inner_product(&row, &row).sqrt());
        independent.push(row);
    }
    parts
}

/// The derivatives of the constraints on positions and velocities by the velocity.
fn slopes(declaration: &Declaration<'_>, Place { t, q, v, .. }: &Place) -> Vec<Vec<f64>> {
    let lower = declaration.lower();
    let mut rows = vec![0.0; lower * (1 + q.len())];
    declaration.phase_slopes(true, *t, q, v, &mut rows);
    let slopes = rows.get(lower..).unwrap_or(&[]).chunks_exact(q.len().max(1));
    slopes.map(<[f64]>::to_vec).collect()
}
