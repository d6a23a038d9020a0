//! Solutions and modes of a step without a counterpart in the continuous motion.

use dsocs_core::geometry::{DiscreteFlow, Triple, pair_displacements};

use crate::check::motion::motions::expansion;
use crate::check::{CheckedMotion, Measured, Report, larger};
use crate::stability::Bar;

/// The smallest distance of two distinct solutions, in legs.
const DISTINCT_ROOTS: f64 = 1e-6;

/// Solutions that are farther away, in legs, are ignored.
const FARTHEST_ROOT: f64 = 10.0;

/// Distances of the guesses from the solution along a coordinate, in legs.
const GUESS_DISTANCES: [f64; 4] = [0.03, 0.3, 1.0, 5.0];

/// A coordinate stands still if its leg is shorter than this part of the longest.
const STANDING_STILL: f64 = 1e-3;

/// The largest change of the next second difference, relative to a change of the leg: it decreases with the
/// step, unless a mode of the step has no counterpart.
const LARGEST_MODE: f64 = 0.5;

/// The number of times that the step is divided by 4.
const MOST_QUARTERINGS: i32 = 10;

/// The nearest other root of each step, and modes without a counterpart.
pub fn roots(motion: &CheckedMotion<'_>, report: &mut Report) {
    let distances: Vec<f64> = motion
        .triples
        .iter()
        .filter_map(|triple| nearest_other_root(&motion.flow, triple))
        .collect();
    report.push(
        format!(
            "of {} steps, those with a second root within {FARTHEST_ROOT} legs",
            motion.triples.len()
        ),
        Bar::Reported,
        Ok(distances.len() as f64),
    );
    if let Some(least) = distances.into_iter().reduce(f64::min) {
        report.push(
            "distance of the nearest second root, in legs",
            Bar::AtLeast(DISTINCT_ROOTS),
            Ok(least),
        );
    }
    report.push(
        "parasitic modes: δe over the change of the leg before it, as h → 0",
        Bar::AtMost(LARGEST_MODE),
        parasitic(motion),
    );
}

/// The longer of both legs by coordinate.
fn lengths(triple: &Triple) -> Vec<f64> {
    // the time is not used
    let last = triple.last(0.0);
    let legs = triple.leg.d.iter().zip(&last.d);
    let own: Vec<f64> = legs.map(|(first, last)| first.abs().max(last.abs())).collect();
    let longest = own.iter().fold(0.0_f64, |longest, x| longest.max(*x));
    let length = |own: &f64| {
        if longest > 0.0 {
            own.max(STANDING_STILL * longest)
        } else {
            1.0
        }
    };
    own.iter().map(length).collect()
}

/// The distance of the nearest other solution of a step, in legs, if one is found.
fn nearest_other_root(flow: &DiscreteFlow<'_>, triple: &Triple) -> Option<f64> {
    let lengths = lengths(triple);
    let mut nearest: Option<f64> = None;
    for i in 0..lengths.len() {
        for far in GUESS_DISTANCES.into_iter().flat_map(|far| [far, -far]) {
            let mut guess = triple.e.clone();
            guess[i] += far * lengths[i];
            let Ok(found) = flow.forward_near(triple.leg.any(), &guess) else {
                continue;
            };
            let distance = |e: &[f64]| {
                let parts = (0..lengths.len()).map(|i| (e[i] - triple.e[i]).abs() / lengths[i]);
                parts.fold(0.0, larger)
            };
            let mut apart = distance(&found.e);
            // from far away an iteration ends with fewer digits than from nearby
            if apart > 0.0
                && apart < DISTINCT_ROOTS
                && let Ok(again) = flow.forward_near(triple.leg.any(), &found.e)
            {
                apart = apart.min(distance(&again.e));
            }
            // a smaller distance is rounding
            if apart > DISTINCT_ROOTS * DISTINCT_ROOTS.sqrt() && apart < FARTHEST_ROOT {
                nearest = Some(nearest.map_or(apart, |nearest| nearest.min(apart)));
            }
        }
    }
    nearest
}

/// The effect of a change of the last leg on the second difference, `δe` over `δd`, in the limit of small
/// steps.
///
/// The step is a map of pairs of nodes, which has twice as many modes as there are coordinates, as the continuous motion has. A mode without a
/// counterpart (the leapfrog of a constraint without accelerations that is imposed on three nodes) turns a change of the leg into its
/// negative, `δe = −2 δd`, at any step; in all others `δe` is of the order of `h δd`.
fn parasitic(motion: &CheckedMotion<'_>) -> Measured {
    let mut most = 0.0;
    for state in &motion.states {
        let expansion = expansion(motion.system, state)?;
        let mut found = f64::NAN;
        for quarter in 0..=MOST_QUARTERINGS {
            let h = motion.h.signum() * motion.h.abs().min(expansion.reach) * 0.25_f64.powi(quarter);
            let flow = motion.flow.with_step(h)?;
            let near = expansion.triple(h);
            let triple = flow.forward_near(near.leg.any(), &near.e)?;
            found = effect_on_second_difference(motion, &flow, &triple)?;
            if found <= LARGEST_MODE {
                break;
            }
        }
        most = larger(most, found);
    }
    Ok(most)
}

/// The largest `δe` relative to the change of the first node that causes it, in legs, with the second node
/// fixed.
fn effect_on_second_difference(
    motion: &CheckedMotion<'_>,
    flow: &DiscreteFlow<'_>,
    triple: &Triple,
) -> Measured {
    let tangent = flow.tangent(triple)?;
    let lengths = lengths(triple);
    let allowed = pair_displacements(motion.kernel, flow.h(), triple.leg.any());
    // combinations of the allowed displacements that keep the second node fixed
    let in_legs =
        |part: &[f64]| -> Vec<f64> { part.iter().zip(&lengths).map(|(x, length)| x / length).collect() };
    let mut vectors: Vec<[Vec<f64>; 2]> = allowed
        .iter()
        .map(|u| [in_legs(&u.second), in_legs(&u.first)])
        .collect();
    for i in 0..lengths.len() {
        let size = |vector: &[Vec<f64>; 2]| vector[0][i].abs();
        let Some(pivot) = (0..vectors.len()).max_by(|&k, &l| size(&vectors[k]).total_cmp(&size(&vectors[l])))
        else {
            break;
        };
        let scale = vectors[pivot]
            .iter()
            .flatten()
            .fold(0.0_f64, |x, y| x.max(y.abs()));
        if size(&vectors[pivot]) <= 1e-9 * scale {
            continue;
        }
        let row = vectors.swap_remove(pivot);
        for vector in &mut vectors {
            let factor = vector[0][i] / row[0][i];
            for (x, y) in vector.iter_mut().flatten().zip(row.iter().flatten()) {
                *x -= factor * y;
            }
        }
    }
    let norm = |x: &[f64]| x.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
    let mut most = 0.0;
    for [_, first] in &vectors {
        let mut change = first.clone();
        for (i, change) in change.iter_mut().enumerate() {
            for j in 0..lengths.len() {
                *change += tangent.by_first[i][j] * lengths[j] * first[j] / lengths[i];
            }
        }
        let size = norm(first);
        if size > 0.0 {
            most = larger(most, norm(&change) / size);
        }
    }
    Ok(most)
}
