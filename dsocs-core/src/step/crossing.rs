//! What jumps where an argument of a declaration changes its sign on a way.
//!
//! What stands on the two sides of the place is compared: at a corner it is the same, what jumps is not, and at a pole it grows without bound. What rests on
//! a surface does so on both sides, as long as its sides allow it: so a jump that lets a resting mass go is seen, and so is one that acts on another
//! coordinate while something rests.

use super::jumps;
use super::switches::{Crossing, Way};
use crate::regularity::resting::{AtPoint, Held};
use crate::regularity::sides::Piece;
use crate::solve::Vector;
use crate::start;
use crate::tape::declaration::Declaration;

/// So far from a place, as a part of the way, what has a pole there is smaller than beside it.
const ASIDE: f64 = 1e-4;

/// It is so by this factor: one over the distance by a hundred million, one over its root by ten thousand.
const POLE: f64 = 1e3;

/// A Lagrangian jumps where it changes by more than this part of itself, and by more than it does at some distance.
const JUMPS: f64 = 1e-9;

/// An acceleration is known to this part of what sides make of it.
const NOISE: f64 = 1e-9;

/// It is known to this part of the largest of all components.
const ROUNDING: f64 = 1e-12;

/// A velocity jumps that changes by more than this part of itself without a cause.
const KICK: f64 = 0.1;

/// A way, and what holds on it.
pub(crate) struct OnWay<'a> {
    /// Time, position and velocity.
    pub(crate) way: &'a Way<'a>,
    /// How long it takes.
    pub(crate) duration: f64,
    /// The step whose rounding velocities have.
    pub(crate) h: f64,
    /// The declaration up to the middle of the way, and from there on.
    pub(crate) declarations: [Declaration<'a>; 2],
    /// Where the arguments of functions that jump with the velocity are when it begins; those between rest. Empty where none does.
    pub(crate) pieces: &'a [Piece],
}

/// The acceleration at a place.
struct Acceleration {
    /// The acceleration.
    a: Vector,
    /// How far each component is known.
    noise: Vector,
    /// The rates of the arguments of functions that jump with the velocity.
    rates: Vec<f64>,
}

impl OnWay<'_> {
    /// The declaration at a part of the way.
    fn declaration(&self, part: f64) -> Declaration<'_> {
        self.declarations[usize::from(part >= 0.5)]
    }

    /// The acceleration at a part of the way.
    fn acceleration(&self, part: f64) -> Option<Acceleration> {
        let (t, q, v) = (self.way)(part);
        let declaration = self.declaration(part);
        let of = |a: Vector, reach: &[f64], rates: Vec<f64>| {
            let size = a.iter().fold(0.0_f64, |size, a| size.max(a.abs()));
            let noise = Vector::from_fn(a.len(), |i| {
                let reach = reach.get(i).map_or(0.0, |reach| NOISE * reach);
                jumps::rounding(self.h, v[i] * self.h)
                    .max(ROUNDING * size)
                    .max(reach)
            });
            Acceleration { a, noise, rates }
        };
        if declaration.sides() == 0 {
            let (a, _) = start::acceleration(&declaration, (t, &q, &v), None).ok()?;
            return Some(of(a, &[], Vec::new()));
        }
        let point = AtPoint::new(declaration, (t, &q, &v));
        let multipliers = declaration.shape().multipliers();
        let arguments = point.arguments();
        let pieces: Vec<Piece> = (0..arguments.len())
            .map(|g| match self.pieces.get(g) {
                Some(Piece::Between) => Piece::Between,
                _ => Piece::of(arguments[g]),
            })
            .collect();
        let guess = Held::guess(&Vector::zero(q.len()), multipliers, pieces.len());
        let held = point.held(&pieces, &guess)?;
        let zero: Vec<bool> = pieces.iter().map(|piece| *piece == Piece::Between).collect();
        let a = if zero.contains(&true) {
            // what rests does so as long as it can
            Vector::of(point.solve(&zero, multipliers, Some(&held.x))?.x.get(..q.len())?)
        } else {
            Vector::of(held.x.get(..q.len())?)
        };
        let rates = (0..arguments.len()).map(|g| point.rate(g, &a)).collect();
        Some(of(a, &held.reach, rates))
    }

    /// How much the acceleration jumps at the place where an argument changes its sign, relative to itself: the largest of all components. It is infinite where
    /// the acceleration has no value, or grows without bound, or the velocity has to jump.
    pub(crate) fn jump_at(&self, Crossing { switch, parts }: Crossing) -> f64 {
        if self.has_step(parts) {
            return f64::INFINITY;
        }
        let [before, after] = parts;
        let at = [before, after, before - ASIDE, after + ASIDE].map(|part| self.acceleration(part));
        let [Some(before), Some(after), Some(left), Some(right)] = at else {
            return f64::INFINITY;
        };
        // what is led back from either side comes to rest
        let rates = [&before, &after].map(|at| at.rates.get(switch).copied());
        if let [Some(before), Some(after)] = rates
            && before * after < 0.0
        {
            return 0.0;
        }
        let noise = |i: usize| before.noise[i].max(after.noise[i]);
        jump([&before.a, &after.a], [&left.a, &right.a], noise)
    }

    /// Whether the Lagrangian jumps with the position or the velocity between two parts of the way that are close together: then the velocity has to jump.
    fn has_step(&self, [before, after]: [f64; 2]) -> bool {
        let declaration = self.declaration(before);
        let (t, ..) = (self.way)(before);
        let [left, before, after, right] = [before - ASIDE, before, after, after + ASIDE].map(|part| {
            let (_, q, v) = (self.way)(part);
            declaration.lagrangian::<f64>(t, &q, &v)
        });
        let smooth = (before - left).abs() + (right - after).abs();
        (after - before).abs() > (JUMPS * left.abs().max(right.abs())).max(smooth)
    }

    /// How much of the velocity changes on the way although no acceleration explains it, as at a corner of a constraint: the largest of all components.
    pub(crate) fn kick(&self, found: &[Crossing]) -> f64 {
        let places = found
            .iter()
            .flat_map(|crossing| crossing.parts)
            .chain([0.0, 0.5, 1.0]);
        let accelerations: Vec<Vector> = places
            .filter_map(|part| self.acceleration(part))
            .map(|at| at.a)
            .collect();
        let [(.., first), (.., last)] = [0.0, 1.0].map(self.way);
        let parts = (0..first.len()).map(|i| {
            let change = last[i] - first[i];
            let [least, most] = jumps::range(accelerations.iter().map(|a| a[i] * self.duration));
            (change - change.max(least).min(most)).abs() / first[i].abs().max(last[i].abs())
        });
        parts.fold(0.0, |most, part| if part > KICK { most.max(part) } else { most })
    }
}

/// How much the larger of two accelerations differs from the other, relative to itself: the largest of all components, each of which is known to a rounding
/// error; infinite at a pole, where one is larger by far than both of those at some distance.
fn jump(sides: [&Vector; 2], aside: [&Vector; 2], noise: impl Fn(usize) -> f64) -> f64 {
    let [before, after] = sides;
    let parts = (0..before.len()).map(|i| {
        let size = before[i].abs().max(after[i].abs());
        if !size.is_finite() {
            return f64::INFINITY;
        }
        let elsewhere = aside
            .iter()
            .fold(noise(i), |largest, end| largest.max(end[i].abs()));
        let difference = (after[i] - before[i]).abs();
        if size > POLE * elsewhere && elsewhere > 0.0 {
            f64::INFINITY
        } else if difference <= noise(i) {
            0.0
        } else {
            // a root is steep at its zero, and does not jump
            difference / size.max(elsewhere)
        }
    });
    parts.fold(0.0, f64::max)
}
