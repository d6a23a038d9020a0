//! Lengths of the coordinates' increments in a step, which make coordinates of different units comparable.

use crate::number::bounded::UNIT;
use crate::number::point::{AnyLeg, map};
use crate::number::tangent::Tangent2;
use crate::regularity::rounding;
use crate::solve::rotation;
use crate::tape::declaration::Declaration;

/// A coordinate with legs shorter than this part of the longest is at rest.
const STILL: f64 = 1e-3;

/// Legs shorter than this part of the displacement `h² f/m` by a single force term are rounding errors of balanced forces, or hardly longer:
/// they are no measure of the equations.
const BALANCED: f64 = 1e6 * f64::EPSILON;

/// Masses at three nodes are the same if they differ by less than this part.
const CONSTANT: f64 = 1e-3;

/// The longer of both legs by coordinate, at least a part of the longest of all; `None` for a coordinate
/// without such a length.
///
/// Coordinates may have different units. The mass of each makes their lengths comparable: `√(∂²L/∂vᵢ²) δqᵢ`
/// has the same unit for all.
///
/// If forces balance and the motion is only their rounding, the legs are no measure of the equations, since
/// the masses are constant along them. Then the measure is the displacement in a step by a single force term.
pub(crate) fn measured(
    declaration: &Declaration<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    e: &[f64],
) -> Vec<Option<f64>> {
    let moved: Vec<f64> = leg
        .d
        .iter()
        .zip(e)
        .map(|(d, e)| d.abs().max((d + e).abs()))
        .collect();
    let weights = weights(declaration, h, leg);
    let weighted = moved.iter().zip(&weights);
    let longest = weighted.fold(0.0_f64, |longest, (moved, weight)| longest.max(weight * moved));
    let forced = forced(declaration, h, leg, e, &weights);
    if longest > 0.0 && longest < BALANCED * forced && has_constant_masses(declaration, h, leg, e, &weights) {
        let lengths = moved.iter().zip(&weights);
        return lengths
            .map(|(&moved, weight)| {
                let length = if *weight > 0.0 { forced / weight } else { moved };
                (length > 0.0 && length.is_finite()).then_some(length)
            })
            .collect();
    }
    let length = |i: usize| {
        let least = if weights[i] > 0.0 {
            STILL * longest / weights[i]
        } else {
            0.0
        };
        let length = moved[i].max(least);
        (length > 0.0 && length.is_finite()).then_some(length)
    };
    (0..moved.len()).map(length).collect()
}

/// The change of each coordinate's second difference by the rounding of forces and momenta; zero without a
/// mass.
pub(crate) fn roundings(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> Vec<f64> {
    let weights = weights(declaration, h, leg);
    let forced = f64::EPSILON * forced(declaration, h, leg, e, &weights);
    let roundings = weights.iter();
    roundings
        .map(|&weight| if weight > 0.0 { forced / weight } else { 0.0 })
        .collect()
}

/// The largest displacement in a step by a single term of the forces at the middle node, times the square
/// root of the coordinate's mass.
fn forced(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64], weights: &[f64]) -> f64 {
    let bounds = rounding::force_bounds(declaration, h, leg, e);
    let ways = bounds.iter().zip(weights).map(|(bound, &weight)| {
        let way = bound / UNIT * h * h / weight;
        if way.is_finite() { way } else { 0.0 }
    });
    ways.fold(0.0, f64::max)
}

/// Whether the masses are the same at all three nodes.
fn has_constant_masses(
    declaration: &Declaration<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    e: &[f64],
    weights: &[f64],
) -> bool {
    let rotations = &declaration.shape().rotations;
    let back = map(leg.d, |d| -d);
    let on: Vec<f64> = leg.d.iter().zip(e).map(|(d, e)| d + e).collect();
    [(-h, back), (h, on)].into_iter().all(|(after, by)| {
        let q = rotation::moved(rotations, leg.q, &by);
        let there = AnyLeg {
            t: leg.t + after,
            q: &q,
            d: leg.d,
        };
        let there = self::weights(declaration, h, there);
        let mut pairs = there.iter().zip(weights);
        pairs.all(|(there, here)| (there - here).abs() <= CONSTANT * here)
    })
}

/// The square root of each coordinate's mass; zero if it has none.
pub(crate) fn weights(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    let v = map(leg.d, |d| d / h);
    let weight = |i: usize| {
        let along = |x: &[f64], part: f64| -> Vec<Tangent2> {
            let numbers = x.iter().enumerate();
            numbers
                .map(|(j, &x)| {
                    let part = if i == j { part } else { 0.0 };
                    Tangent2::second(x, [part; 2])
                })
                .collect()
        };
        // by a part of the velocity: only the differences of users' functions depend on it
        let unit = if v[i] == 0.0 { 1.0 } else { v[i].abs() };
        let mass = declaration
            .lagrangian(
                Tangent2::second(leg.t, [0.0; 2]),
                &along(leg.q, 0.0),
                &along(&v, unit),
            )
            .mixed();
        let weight = mass.abs().sqrt() / unit;
        if weight.is_finite() { weight } else { 0.0 }
    };
    (0..v.len()).map(weight).collect()
}

/// A length for every coordinate. One that is at rest while others move has the length given by its mass, or
/// 1 without mass.
pub(crate) fn lengths(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> Vec<f64> {
    let weights = weights(declaration, h, leg);
    let measured = measured(declaration, h, leg, e);
    let lengths = measured.iter().zip(&weights).map(|(measured, weight)| {
        let by_mass = 1.0 / weight;
        measured.unwrap_or(if by_mass.is_finite() { by_mass } else { 1.0 })
    });
    lengths.collect()
}
