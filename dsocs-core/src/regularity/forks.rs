//! States from which the motion may go on in more than one way, where a function jumps with the velocity or, at the start, with the position.
//!
//! An argument that is zero may stay there, if a side in `[-1, 1]` holds it; or it may leave to a side, if the bound of that side drives it
//! further that way. Dry friction with a given normal force has exactly one such continuation: if a side holds the argument, neither bound
//! drives it away. A force along the velocity has three, since it drives the argument away on both sides. If the normal force grows with the
//! friction itself, a bound may drive the argument away although a side holds it, as with a rod that jams (P. Painlevé, *Comptes Rendus* 121,
//! 1895; F. Génot, B. Brogliato, *Eur. J. Mech. A* 18, 1999); so may a force that is no monotone function of its side. All of these solve the
//! inclusion of [`crate::regularity::sides`], and nothing in it prefers one.

use super::resting::{AtPoint, FAINT};
use crate::number::{larger, largest};
use crate::regularity::sides::{self, Piece, Sided};
use crate::regularity::sticking;
use crate::solve::Vector;
use crate::start;
use crate::tape::declaration::Declaration;

/// An argument leaves zero if its rate is above this part of the sides' largest effect on it: more than the
/// excess of a side over its bounds that the inclusion allows. Motions whose rates differ by less are the
/// same.
const DISTINCT: f64 = 1e-6;

/// Rates of one motion that were found in two ways differ by less than this part of them: an argument without an own force, as
/// of a contact without friction, has no sizes of sides to compare with.
const ROUNDING: f64 = 1e-12;

/// A side that holds is searched in parts of `[-1, 1]` that are halved as often as this, at least and at most,
/// where its rate is not nearly linear: laws need not be linear in it, and may have a pole beside the zero.
const HALVED: [u32; 2] = [3, 12];

/// A rate is nearly linear if it differs from that by less than this part of those at the ends.
const BENT: f64 = 0.01;

/// Number of bisections towards a zero.
const HALVINGS: u32 = 40;

/// A change of sign is a zero if the rate there is below this part of those at the ends, else a pole.
const VANISHES: f64 = 1e-3;

/// An argument that will be zero within this part of the time counts as zero: of arguments that depend on each other, some
/// may be found to rest, and the rounding of the velocity decides about the others.
const ARRIVES: f64 = 1e-9;

/// Roundings of its terms below which an argument is zero.
const ROUNDINGS: f64 = 16.0;

/// The part of a motion's extent by which a position is moved to the side of an argument, at least; and the factor by which it is moved less, to
/// see whether the acceleration there vanishes with the distance.
const ASIDE: f64 = 1e-8;
const NEARER: f64 = 1.0 / 64.0;

/// The part of the time of a step within which an argument has to leave zero.
const WITHIN: f64 = 0.125;

/// Largest number of arguments that are zero at once: all combinations of their sides are examined.
const MOST: usize = 6;

/// Largest number of passes over the arguments in the search for a place on given sides of all of them.
const PASSES: usize = 64;

/// An argument of piecewise functions that is zero at the start of a motion, and stays zero along a straight path.
struct ZeroArgument {
    /// Its number.
    switch: usize,
    /// Its derivative by the position.
    gradient: Vec<f64>,
    /// The size below which it is rounding.
    noise: f64,
}

/// Whether the motion from a start may go on in more than one way within a `time`, since the acceleration jumps with the position where the
/// motion begins: on both sides of an argument that is zero, or in more than one combination of the sides of several, the motion leads further
/// to that side. Arguments that contain velocities are judged by [`AtPoint::forks`]. What friction holds, or releases, at the start is not judged.
#[cold]
pub(crate) fn at_start(declaration: &Declaration<'_>, (t, q, v): (f64, &[f64], &[f64]), time: f64) -> bool {
    let shape = declaration.shape();
    if declaration.switches() == 0 || shape.is_of_third_order() || !shape.rotations.is_empty() {
        return false;
    }
    let acceleration = |q: &[f64]| {
        let found = start::acceleration(declaration, (t, q, v), None);
        found.ok().map(|(a, _)| a).filter(Vector::is_finite)
    };
    let tau = WITHIN * time;
    let here = acceleration(q).map_or(0.0, |a| largest(&a));
    let extent = largest(q).max(largest(v) * tau.abs()).max(here * tau * tau);
    // a start at the origin, at rest and without a force there, tells no length
    let extent = if extent > 0.0 { extent } else { 1.0 };
    let zero = zero_arguments(declaration, (t, q, v), (extent, tau));
    let has_side = || declaration.sides() > 0 && sticking::zero(declaration, t, q, v).contains(&true);
    if zero.is_empty() || zero.len() > MOST || has_side() {
        return false;
    }
    let none = vec![0.0; q.len()];
    let arguments = |t: f64, q: &[f64]| declaration.switch_arguments(t, q, v, &none);
    let mut continuations: Vec<Vector> = Vec::new();
    for combination in 0..1_u32 << zero.len() {
        let side = |k: usize| if combination >> k & 1 == 0 { 1.0 } else { -1.0 };
        let Some(aside) = aside(&zero, &side, extent) else {
            continue;
        };
        // the acceleration at a part of that distance, if it is on the sides
        let beside = |part: f64| {
            let moved: Vec<f64> = q.iter().zip(&aside).map(|(q, by)| q + part * by).collect();
            let found = arguments(t, &moved);
            let is_there = zero
                .iter()
                .enumerate()
                .all(|(k, at)| side(k) * found[at.switch] > 0.0);
            if is_there { acceleration(&moved) } else { None }
        };
        let (Some(far), Some(near)) = (beside(1.0), beside(NEARER)) else {
            continue;
        };
        let after = |a: &Vector, part: f64| {
            let s = part * tau;
            let moved: Vec<f64> = (0..q.len())
                .map(|i| q[i] + s * v[i] + 0.5 * s * s * a[i])
                .collect();
            arguments(t + s, &moved)
        };
        let [by_far, by_near, half] = [after(&far, 1.0), after(&near, 1.0), after(&near, 0.5)];
        let leaves = zero.iter().enumerate().all(|(k, at)| {
            let [by_far, by_near, half] = [&by_far, &by_near, &half].map(|found| side(k) * found[at.switch]);
            half > at.noise && by_near > at.noise && by_near > 0.5 * by_far
        });
        if !leaves {
            continue;
        }
        let differs = |other: &Vector| {
            let apart = largest(&near.zip(other, |x, y| x - y));
            apart > DISTINCT * largest(&near).max(largest(other))
        };
        if continuations.iter().any(differs) {
            return true;
        }
        continuations.push(near);
    }
    false
}

/// The arguments that depend on positions, not on velocities, and are zero along a straight path from a point. Derivatives are difference
/// quotients, in parts of the `extent` of the motion.
fn zero_arguments(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    (extent, tau): (f64, f64),
) -> Vec<ZeroArgument> {
    let none = vec![0.0; q.len()];
    let arguments = |t: f64, q: &[f64], v: &[f64]| declaration.switch_arguments(t, q, v, &none);
    let changed = |x: &[f64], i: usize, by: f64| {
        let mut changed = x.to_vec();
        changed[i] += by;
        changed
    };
    let step = f64::EPSILON.cbrt();
    let by_position: Vec<[Vec<f64>; 2]> = (0..q.len())
        .map(|i| [-step * extent, step * extent].map(|by| arguments(t, &changed(q, i, by), v)))
        .collect();
    let fast = extent / tau.abs();
    let by_velocity: Vec<Vec<f64>> = (0..q.len())
        .map(|i| arguments(t, q, &changed(v, i, fast)))
        .collect();
    let [back, ahead] = [-tau, tau].map(|s| {
        let moved: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + s * v).collect();
        arguments(t + s, &moved, v)
    });
    let by_time = arguments(t + tau, q, v);
    let here = arguments(t, q, v);
    let found = here.iter().enumerate().filter_map(|(switch, &value)| {
        let slope = |at: &[Vec<f64>; 2]| (at[1][switch] - at[0][switch]) / (2.0 * step * extent);
        let gradient: Vec<f64> = by_position.iter().map(slope).collect();
        let of_time = ((by_time[switch] - value) / tau * t).abs();
        let terms = gradient
            .iter()
            .zip(q)
            .fold(of_time, |sum, (slope, q)| sum + (slope * q).abs());
        let noise = ROUNDINGS * f64::EPSILON * terms;
        let is_zero = value.abs() <= noise
            && (ahead[switch] - back[switch]).abs() <= 2.0 * noise
            && by_velocity.iter().all(|of| (of[switch] - value).abs() <= noise)
            && largest(&gradient) > 0.0
            && gradient.iter().all(|slope| slope.is_finite());
        is_zero.then_some(ZeroArgument {
            switch,
            gradient,
            noise,
        })
    });
    found.collect()
}

/// A displacement to given sides of some arguments, as far as their rounding and the extent of the motion require; `None` if none is found.
/// The conditions are met one after the other, again and again (S. Agmon, *Canad. J. Math.* 6, 1954).
fn aside(zero: &[ZeroArgument], side: &dyn Fn(usize) -> f64, extent: f64) -> Option<Vec<f64>> {
    let n = zero.first()?.gradient.len();
    let mut by = vec![0.0; n];
    for _ in 0..PASSES {
        let mut is_there = true;
        for (k, at) in zero.iter().enumerate() {
            let square: f64 = at.gradient.iter().map(|slope| slope * slope).sum();
            let distance = (ASIDE * extent * square.sqrt()).max(at.noise / (NEARER * NEARER));
            let reached: f64 = at.gradient.iter().zip(&by).map(|(slope, by)| slope * by).sum();
            let left = distance - side(k) * reached;
            if left > 0.5 * distance {
                is_there = false;
                for (by, slope) in by.iter_mut().zip(&at.gradient) {
                    *by += side(k) * left * slope / square;
                }
            }
        }
        if is_there {
            return Some(by);
        }
    }
    None
}

/// A motion that leaves zero, or stays there.
struct Continuation {
    /// The rate of each argument.
    rates: Vec<f64>,
    /// The sizes below which rates are not distinct.
    faint: Vec<f64>,
}

impl Continuation {
    /// Whether another one is another motion.
    fn differs_from(&self, other: &Self, zero: &[bool]) -> bool {
        (0..zero.len()).filter(|&g| zero[g]).any(|g| {
            let faint = larger(self.faint[g], other.faint[g]);
            let [rate, another] = [self, other].map(|motion| motion.rates[g]);
            (rate - another).abs() > larger(faint, ROUNDING * larger(rate.abs(), another.abs()))
        })
    }
}

impl AtPoint<'_> {
    /// Whether the motion may go on from here in more than one way, if some arguments are `zero`. Forward in
    /// time, and judged by the change within `time`, so that rounding of the velocity is not taken for a
    /// force.
    #[cold]
    pub(crate) fn forks(&self, zero: &[bool], multipliers: usize, time: f64) -> bool {
        let velocities = self.sizes();
        let fastest = self.fastest(&vec![0.0; self.q.len()], multipliers);
        let zero: Vec<bool> = (0..zero.len())
            .map(|g| zero[g] || self.drift[g].value().abs() <= ARRIVES * time * fastest[g])
            .collect();
        let zero = &zero[..];
        let mut leaves: Vec<(usize, Continuation)> = Vec::new();
        for g in (0..zero.len()).filter(|&g| zero[g]) {
            // arguments that are multiples of each other leave together: one of them is examined
            if (0..g).any(|k| zero[k] && self.ratio(g, k) != 0.0) {
                continue;
            }
            for side in [1.0, -1.0] {
                let Some(away) = self.with_side((g, side), zero, multipliers) else {
                    continue;
                };
                let rate = side * away.rates[g];
                if rate > away.faint[g] && rate * time > FAINT * velocities[g] {
                    if leaves.iter().any(|(_, other)| other.differs_from(&away, zero)) {
                        return true;
                    }
                    leaves.push((g, away));
                }
            }
        }
        // all motions that leave are one motion so far; one that stays is a second one
        leaves
            .first()
            .is_some_and(|&(g, _)| self.holds(g, zero, multipliers))
    }

    /// Whether some side of an argument keeps it at zero, while the other arguments are solved for.
    fn holds(&self, g: usize, zero: &[bool], multipliers: usize) -> bool {
        let rate = |side: f64| {
            self.with_side((g, side), zero, multipliers)
                .map(|found| found.rates[g])
        };
        let ends = [-1.0, 1.0].map(|side| (side, rate(side).unwrap_or(f64::NAN)));
        vanishes_between(&rate, ends, 0)
    }

    /// The ratio of two arguments that vanish together at all velocities; 0 if they do not.
    fn ratio(&self, g: usize, k: usize) -> f64 {
        let n = self.q.len();
        let products =
            |g: usize, k: usize| -> f64 { (0..n).map(|j| self.slope(g, j) * self.slope(k, j)).sum() };
        let ratio = products(g, k) / products(k, k);
        let size: f64 = (0..n).map(|j| self.slope(g, j).abs()).sum();
        let differs = |j: usize| (self.slope(g, j) - ratio * self.slope(k, j)).abs() > DISTINCT * size;
        if ratio.is_finite() && !(0..n).any(differs) {
            ratio
        } else {
            0.0
        }
    }

    /// The motion with a given side of an argument, and of those that vanish with it; the others follow.
    fn with_side(
        &self,
        (own, side): (usize, f64),
        zero: &[bool],
        multipliers: usize,
    ) -> Option<Continuation> {
        let given = |k: usize| match self.ratio(k, own) {
            _ if !zero[k] => None,
            _ if k == own => Some(side),
            0.0 => None,
            ratio => Some(side * ratio.signum()),
        };
        let given: Vec<Option<f64>> = (0..zero.len()).map(given).collect();
        let free: Vec<bool> = (0..zero.len()).map(|k| zero[k] && given[k].is_none()).collect();
        let with_given = |sides: &[f64]| -> Vec<f64> {
            let both = sides.iter().zip(&given);
            both.map(|(side, given)| given.unwrap_or(*side)).collect()
        };
        let linearize = |x: &[f64], sides: &[f64]| {
            let mut at = self.linearize(x, &with_given(sides), &free);
            // a known side counts as one at its bound: the argument 1 keeps it there
            for (argument, given) in at.arguments.iter_mut().zip(&given) {
                if given.is_some() {
                    *argument = 1.0;
                }
            }
            at
        };
        let begin = |k: usize| match given[k] {
            Some(_) => Piece::Plus,
            None if zero[k] => Piece::Between,
            None => Piece::of(self.drift[k].value()),
        };
        let pieces: Vec<Piece> = (0..zero.len()).map(begin).collect();
        let sides: Vec<f64> = pieces.iter().map(|piece| piece.side()).collect();
        let x = self.unknowns(&with_given(&sides), zero, multipliers)?;
        let least = vec![0.0; x.len()];
        let found = sides::solve(&linearize, &Sided::guess(x, pieces), &least, 1.0)?;
        self.continuation(&found.x, &with_given(&found.sides), zero)
    }

    /// A solution, with the rates of its arguments.
    fn continuation(&self, x: &[f64], sides: &[f64], zero: &[bool]) -> Option<Continuation> {
        let at = self.linearize(x, sides, zero);
        let b = at
            .slopes
            .times(&sides::inverse(at.by_unknowns)?.times(&at.by_sides));
        let a = x.get(..self.q.len())?;
        let faint = |g: usize| DISTINCT * b.row(g).map(f64::abs).sum::<f64>();
        Some(Continuation {
            rates: (0..zero.len()).map(|g| self.rate(g, a)).collect(),
            faint: (0..zero.len()).map(faint).collect(),
        })
    }
}

/// Whether a function that may have poles vanishes between two places; halved so often before.
fn vanishes_between(function: &dyn Fn(f64) -> Option<f64>, ends: [(f64, f64); 2], halved: u32) -> bool {
    let [from, to] = ends;
    let place = 0.5 * (from.0 + to.0);
    let Some(value) = function(place) else {
        return false;
    };
    let bent = (value - 0.5 * (from.1 + to.1)).abs();
    let is_straight = bent <= BENT * from.1.abs().max(to.1.abs());
    if halved < HALVED[0] || (halved < HALVED[1] && !is_straight) {
        let middle = (place, value);
        return [[from, middle], [middle, to]]
            .into_iter()
            .any(|ends| vanishes_between(function, ends, halved + 1));
    }
    if from.1 * to.1 > 0.0 {
        return false;
    }
    let [mut from, mut to] = ends;
    let least = from.1.abs().min(to.1.abs());
    for _ in 0..HALVINGS {
        let place = 0.5 * (from.0 + to.0);
        let Some(value) = function(place) else {
            return false;
        };
        if value * to.1 > 0.0 {
            to = (place, value);
        } else {
            from = (place, value);
        }
    }
    from.1.abs().min(to.1.abs()) <= VANISHES * least
}
