//! Constraints on positions and velocities that depend on each other.

use super::deficiency::{self, DependentRow};
use crate::number::inner_product;
use crate::solve::Vector;
use crate::start;
use crate::start::place::Place;
use crate::tape::declaration::Declaration;

/// On a straight path, which is not quite that of the motion, a constraint is dependent if its part that is
/// independent of those before it is below this part of its former value.
pub(crate) const NEARLY_DEPENDENT: f64 = 1e-2;

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
