//! Samples that lie closer to each other than the nodes of a run, and samples where a table has a corner.
//!
//! A step evaluates a table of samples at its nodes alone. It misses the samples between them, such as a blow
//! that lasts a third of the step. Their places are known, and so is the one at which the table deviates most
//! from the interpolation through the nodes.

use super::switches::{Crossing, MOST};
use crate::samples::{BENDS, Samples};
use crate::start::place::MotionPath;
use crate::tape::declaration::Declaration;

/// Samples between two nodes matter if they deviate by more than this part of the table's range there from
/// the cubic polynomial through the values at four nodes. Samples of a smooth curve that the nodes resolve do
/// not.
const ASIDE: f64 = 0.2;

/// A single sample between two nodes makes a corner; a pulse that no node sees has at least two.
const FEWEST: usize = 2;

/// Largest number of samples ahead that are examined.
const AHEAD: usize = 256;

/// The places of a path where tables deviate most from their values at the nodes, each with the middles of
/// the two neighbouring pieces: there the step passes over samples.
pub(super) fn hidden(declaration: &Declaration<'_>, path: &MotionPath<'_>) -> Vec<f64> {
    let hidden = arguments(declaration, path).into_iter();
    hidden
        .filter_map(|Table { samples, ends, .. }| {
            let [from, to] = ends;
            let [before, place, after] = inside(samples, ends)?;
            let all = [0.5 * (before + place), place, 0.5 * (place + after)];
            Some(all.map(|place| (place - from) / (to - from)))
        })
        .flatten()
        .collect()
}

/// Number of steps after the given path that pass over no relevant samples; 0 if this or the next one may do
/// so.
pub(super) fn clear(declaration: &Declaration<'_>, path: &MotionPath<'_>) -> f64 {
    let clears = arguments(declaration, path).into_iter().map(|table| {
        let (samples, [from, to]) = (table.samples, table.ends);
        let change = to - from;
        let (mut steps, mut seen) = (0.0, 0);
        // overlapping steps: nodes need not lie where the argument is extrapolated to
        while steps < MOST && seen < AHEAD {
            let next = [from + steps * change, to + (steps + 0.5) * change];
            if inside(samples, next).is_some() || bend(&table, next).is_some() {
                break;
            }
            seen += between(samples, next).len();
            steps += 1.0;
        }
        // the argument may become faster
        if steps > 1.0 { (0.5 * steps).ceil() } else { steps }
    });
    clears.fold(MOST, f64::min)
}

/// The places on a path where a differentiated table has its sharpest corner. There the force of a potential
/// jumps, or the velocity of a driven constraint, or the acceleration of a body at rest on a surface.
pub(super) fn bends(declaration: &Declaration<'_>, path: &MotionPath<'_>) -> Vec<Crossing> {
    let bends = arguments(declaration, path).into_iter().enumerate();
    bends
        .filter_map(|(table, at)| {
            let knot = bend(&at, at.ends)?;
            let [from, to] = at.ends;
            let side = (to - from).signum();
            let left = |part: f64| {
                let tables = path(part).tables(declaration);
                tables
                    .get(table)
                    .map_or(f64::NAN, |at| side * (knot - at.argument))
            };
            Some(Crossing::found(declaration.switches() + table, [0.0, 1.0], left))
        })
        .collect()
}

/// The argument of the sharpest corner of a differentiated table, between two arguments or at the second.
fn bend(table: &Table<'_>, [from, to]: [f64; 2]) -> Option<f64> {
    let samples = table.samples;
    let places = samples.places();
    let within = |place: f64| (from < place && place <= to) || (to <= place && place < from);
    let [least, most] = [from.min(to), from.max(to)];
    let first = places.partition_point(|&place| place < least);
    let last = places.partition_point(|&place| place <= most);
    let bends = (first..last.min(first + AHEAD))
        .filter(|&k| table.is_differentiated && within(places[k]))
        .map(|k| (samples.bend(k), places[k]))
        .filter(|(bend, _)| *bend > BENDS);
    bends.max_by(|x, y| x.0.total_cmp(&y.0)).map(|(_, place)| place)
}

/// A table, with its argument at both ends of a path.
struct Table<'d> {
    samples: &'d Samples,
    is_differentiated: bool,
    ends: [f64; 2],
}

/// The tables of a declaration.
fn arguments<'d>(declaration: &Declaration<'d>, path: &MotionPath<'_>) -> Vec<Table<'d>> {
    if !declaration.has_tables() {
        return Vec::new();
    }
    let [from, to] = [0.0, 1.0].map(|part| path(part).tables(declaration));
    let pairs = from.into_iter().zip(to);
    pairs
        .map(|(from, to)| Table {
            samples: from.samples,
            is_differentiated: from.is_differentiated || declaration.sides() > 0,
            ends: [from.argument, to.argument],
        })
        .collect()
}

/// The arguments of the samples between two arguments.
fn between(samples: &Samples, [from, to]: [f64; 2]) -> &[f64] {
    let places = samples.places();
    let [least, most] = [from.min(to), from.max(to)];
    let first = places.partition_point(|&place| place <= least);
    let last = places.partition_point(|&place| place < most);
    places.get(first..last).unwrap_or(&[])
}

/// The sample between two arguments that deviates most from the cubic through the nodes, between its two
/// neighbours; `None` if it deviates too little to matter.
fn inside(samples: &Samples, [from, to]: [f64; 2]) -> Option<[f64; 3]> {
    let places = between(samples, [from, to]);
    if places.len() < FEWEST {
        return None;
    }
    let nodes = [2.0 * from - to, from, to, 2.0 * to - from];
    let seen = nodes.map(|x| samples.at(x));
    let [mut least, mut most] = [seen[1].min(seen[2]), seen[1].max(seen[2])];
    let mut farthest = (0.0, 0);
    for (k, &place) in places.iter().enumerate() {
        let value = samples.at(place);
        (least, most) = (least.min(value), most.max(value));
        let aside = (value - cubic(seen, (place - from) / (to - from))).abs();
        if aside > farthest.0 {
            farthest = (aside, k);
        }
    }
    let (aside, k) = farthest;
    let [start, end] = [from.min(to), from.max(to)];
    let beside = |k: Option<usize>, end: f64| k.and_then(|k| places.get(k)).copied().unwrap_or(end);
    (aside > ASIDE * (most - least)).then(|| {
        [
            beside(k.checked_sub(1), start),
            places[k],
            beside(k.checked_add(1), end),
        ]
    })
}

/// The cubic polynomial through values at −1, 0, 1 and 2.
fn cubic([a, b, c, d]: [f64; 4], x: f64) -> f64 {
    let second = [c - 2.0 * b + a, d - 2.0 * c + b];
    b + x * (c - b) + x * (x - 1.0) * (second[0] * (2.0 - x) + second[1] * (1.0 + x)) / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own() {
        let p = |x: f64| 3.0 - x + 0.5 * x * x - 2.0 * x * x * x;
        for x in [-0.3, 0.0, 0.4, 1.0, 1.7] {
            assert!(
                (cubic([-1.0, 0.0, 1.0, 2.0].map(p), x) - p(x)).abs() < 1e-13,
                "{x}"
            );
        }
    }
}
