//! Features of smooth functions that are narrower than the step.
//!
//! `exp(u)`, `tanh(u)` and their kin vary where `u` has a zero or an extremum, and may be flat to rounding
//! elsewhere, as a Gaussian is. So do quotients and high powers, where `u` is their logarithm. If `u` runs
//! through many units in a step, no node sees the feature. Its place is that of the zero or the extremum, and
//! its width is that in which `u` changes by about one.

use super::switches::{self, Crossing, MOST, PLACES};
use crate::number::largest;
use crate::start::place::MotionPath;
use crate::tape::declaration::{Declaration, Steep};

/// If `u` changes by less than this on both sides of the place, over the length of the path, the nodes see the feature.
const SEEN: f64 = 0.25;

/// Least slope of `u` at one end of the path or the other, in units of its length.
const SLOPE: f64 = 0.25;

/// A place this far behind the end of the path, as a part of it, may be that of the next path, whose first slope is taken on its way there.
const OVERLAP: f64 = 1.0 / 256.0;

/// Distance over which the slope at an end is taken.
const BESIDE: f64 = OVERLAP / 4.0;

/// The end up to which a path is looked at.
const END: f64 = 1.0 + OVERLAP;

/// Change of `u`, from the place, at which the feature is looked at as well: the force of a Gaussian hill is zero at its top, and
/// largest where the exponent is about a third lower.
const ASIDE: f64 = 0.35;

/// A periodic function whose argument changes by less than this on a path is one that the nodes see.
const TURNS: f64 = 2.0;

/// The places at which such a function is looked at: in half a period it may be nearly linear.
const WITHIN: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// Number of sections of the path in the search of an extremum.
const SHORTENINGS: u32 = 60;

/// The places of a path at which functions may have a feature that is narrower than the step.
pub(super) fn places(declaration: &Declaration<'_>, path: &MotionPath<'_>) -> Vec<f64> {
    if !declaration.has_steep() {
        return Vec::new();
    }
    let logarithms = |part: f64| {
        let steep = path(part).steep(declaration).into_iter();
        steep.map(Steep::logarithm).collect::<Vec<_>>()
    };
    let [first, second, before, last] = [0.0, BESIDE, END - BESIDE, END].map(logarithms);
    let periodic = path(0.0).steep(declaration).into_iter().map(Steep::is_periodic);
    let mut places = Vec::new();
    for (g, is_periodic) in periodic.enumerate() {
        if is_periodic {
            // its phase may be the same at all nodes
            let turns = (last[g] - first[g]).abs() > TURNS;
            places.extend(turns.then_some(WITHIN).into_iter().flatten());
            continue;
        }
        let slopes = [second[g] - first[g], last[g] - before[g]];
        if largest(&slopes) < SLOPE * BESIDE {
            continue;
        }
        let value = |part: f64| logarithms(part).get(g).copied().unwrap_or(f64::NAN);
        let ends = [(0.0, first[g]), (END, last[g])];
        let turns = slopes[0] * slopes[1] < 0.0;
        let extremum = turns.then(|| {
            let place = extremum(slopes[0].signum(), &value);
            (place, value(place))
        });
        let known: Vec<_> = [ends[0]].into_iter().chain(extremum).chain([ends[1]]).collect();
        let zeros = known.windows(2).filter_map(|known| {
            let [(from, before), (to, after)] = [known[0], known[1]];
            (before * after < 0.0).then(|| (change([from, to], |part| before.signum() * value(part)), 0.0))
        });
        for (place, height) in zeros.chain(extremum) {
            let goes = |part: f64| (value(part) - height).abs();
            let ends = [place - 1.0, place + 1.0].map(|end| (end, goes(end)));
            if ends.iter().any(|(_, far)| *far > SEEN) {
                places.push(place);
            }
            let far = ends.iter().filter(|(_, far)| *far > ASIDE);
            places.extend(far.map(|&(end, _)| change([place, end], |part| ASIDE - goes(part))));
        }
    }
    places
}

/// Number of steps after a path until a function may have such a feature; 0 if it may in the next.
pub(super) fn clear(declaration: &Declaration<'_>, path: &MotionPath<'_>) -> f64 {
    if !declaration.has_steep() {
        return MOST;
    }
    // the extremum of the base of a power is that of its logarithm, and nearer to that of a parabola
    let at = PLACES.map(|part| path(part).steep(declaration));
    let clears = (0..at[0].len()).map(|g| {
        let [first, middle, last] = [at[0][g], at[1][g], at[2][g]].map(|steep| steep.argument);
        let turn = 4.0 * (first - 2.0 * middle + last);
        let slope = last - first + 0.5 * turn;
        if at[0][g].is_periodic() {
            let left = TURNS - slope.abs();
            return if left > 0.0 { left / turn.abs() } else { 0.0 };
        }
        // as long as an exponential function changes little in a step, the nodes see all of it
        let is_power = at[0][g].exponent != 0.0;
        if !is_power && slope.abs() + MOST * turn.abs() < SLOPE {
            return MOST;
        }
        if !slope.is_finite() || (middle - first) * (last - middle) < 0.0 {
            return 0.0;
        }
        let to_extremum = switches::clear(1.0, slope.abs(), -turn.abs(), 0.0);
        if is_power {
            return to_extremum;
        }
        if first * last < 0.0 {
            return 0.0;
        }
        to_extremum.min(switches::clear(last.signum(), last.abs(), slope, turn))
    });
    clears.fold(MOST, f64::min)
}

/// The extremum of a function on the path, up to which it changes as `side` says, and from which on it returns.
fn extremum(side: f64, value: &dyn Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut from, mut to) = (0.0, END);
    for _ in 0..SHORTENINGS {
        let [left, right] = [to - golden * (to - from), from + golden * (to - from)];
        if side * value(left) > side * value(right) {
            to = right;
        } else {
            from = left;
        }
    }
    0.5 * (from + to)
}

/// The place between two where a positive value becomes negative.
fn change([from, to]: [f64; 2], value: impl Fn(f64) -> f64) -> f64 {
    let along = |part: f64| from + part * (to - from);
    let Crossing { parts, .. } = Crossing::found(0, [0.0, 1.0], |part| value(along(part)));
    along(parts[0])
}
