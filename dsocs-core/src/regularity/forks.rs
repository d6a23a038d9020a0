//! States from which the motion may go on in more than one way, where a function jumps with the velocity.
//!
//! An argument that is zero may stay there, if a side in `[-1, 1]` holds it; or it may leave to a side, if the bound of that side drives it
//! further that way. Dry friction with a given normal force has exactly one such continuation: if a side holds the argument, neither bound
//! drives it away. A force along the velocity has three, since it drives the argument away on both sides. If the normal force grows with the
//! friction itself, a bound may drive the argument away although a side holds it, as with a rod that jams (P. Painlevé, *Comptes Rendus* 121,
//! 1895; F. Génot, B. Brogliato, *Eur. J. Mech. A* 18, 1999); so may a force that is no monotone function of its side. All of these solve the
//! inclusion of [`crate::regularity::sides`], and nothing in it prefers one.

use super::resting::{AtPoint, FAINT};
use crate::number::larger;
use crate::regularity::sides::{self, Piece, Sided};

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
