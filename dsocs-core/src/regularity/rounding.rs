//! The rounding errors of rows, and the sizes of their terms.

use crate::number::bounded::{Bounded, UNIT, Underflowing};
use crate::number::point::{AnyLeg, AnyPoint, map};
use crate::number::scalar::Scalar as _;
use crate::regularity::multipliers::of_step;
use crate::regularity::stacked::{of_first_pair, stacked};
use crate::tape::declaration::Declaration;

/// The size of the terms of each row of [`Declaration::phase`].
pub(crate) fn phase_sizes(declaration: &Declaration<'_>, t: f64, q: &[f64], v: &[f64]) -> Vec<f64> {
    let rows = declaration.phase(
        Bounded::splat(t),
        &map(q, Bounded::splat),
        &map(v, Bounded::splat),
    );
    rows.iter().map(|row| row.error() / UNIT).collect()
}

/// The size of the terms of each row of [`Declaration::pair`].
pub(crate) fn pair_sizes(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    let rows = declaration.pair(Bounded::splat(h), leg.map(Bounded::splat).any());
    rows.iter().map(|row| row.error() / UNIT).collect()
}

/// Bounds of the rounding errors of all rows of a step, in the order of [`stacked`].
pub(crate) fn stacked_bounds(
    declaration: &Declaration<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    e: &[f64],
) -> Vec<f64> {
    let multipliers = of_step(declaration, h, leg, e);
    let multipliers: Vec<_> = multipliers.iter().map(|&x| Bounded::splat(x)).collect();
    let (leg, e) = (leg.map(Bounded::splat), map(e, Bounded::splat));
    let rows = stacked(declaration, Bounded::splat(h), leg.any(), &e, &multipliers);
    rows.into_iter().map(Bounded::error).collect()
}

/// Bounds of the rounding errors of the constraints' rows on the first pair of nodes.
pub(crate) fn first_pair_bounds(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    let rows = of_first_pair(declaration, Bounded::splat(h), leg.map(Bounded::splat).any());
    rows.into_iter().map(Bounded::error).collect()
}

/// Bounds of the rounding errors of constraint force plus external forces at the second of three nodes, by
/// coordinate.
pub(crate) fn force_bounds(
    declaration: &Declaration<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    e: &[f64],
) -> Vec<f64> {
    let (h, leg, e) = (Bounded::splat(h), leg.map(Bounded::splat), map(e, Bounded::splat));
    let constraint = declaration.force(h, leg.any(), &e);
    let external = declaration.external_force(h, leg.any(), &e);
    let both = constraint.iter().zip(&external);
    both.map(|(constraint, external)| constraint.error() + external.error())
        .collect()
}

/// The loss of each row of [`Declaration::continuous`] by products that fall below the smallest normal
/// number.
pub(crate) fn continuous_underflow(
    declaration: &Declaration<'_>,
    point: AnyPoint<'_, f64>,
    multipliers: &[f64],
) -> Vec<f64> {
    let (t, multipliers) = (
        Underflowing::splat(point.t),
        map(multipliers, Underflowing::splat),
    );
    let [q, v, a] = [point.q, point.v, point.a].map(|x| map(x, Underflowing::splat));
    let (q, v, a) = (&q[..], &v[..], &a[..]);
    let rows = declaration.continuous(AnyPoint { t, q, v, a }, &multipliers);
    rows.into_iter().map(Underflowing::error).collect()
}
