//! What jumps where an argument of a declaration changes its sign on a way.
//!
//! What stands on the two sides of the place is compared: at a corner it is the same, what jumps is not, and at a pole it grows without bound. What rests on
//! a surface does so on both sides, as long as its sides allow it: so a jump that lets a resting mass go is seen, and so is one that acts on another
//! coordinate while something rests.

use super::jumps;
use super::switches::Crossing;
use crate::number::point::{AnyPoint, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::resting::{AtPoint, Held};
use crate::regularity::rounding;
use crate::regularity::sides::Piece;
use crate::solve::Vector;
use crate::start::place::{Place, Way};
use crate::start::{self, third};
use crate::tape::declaration::Declaration;

/// So far from a place, as a part of the way, what has a pole there is smaller than beside it.
const ASIDE: f64 = 1e-4;

/// So far from a place it still is, by this factor at least: one over a root.
const NEAR: f64 = 1e-8;
const GROWS: f64 = 10.0;

/// It is so by this factor: one over the distance by a hundred million, one over its root by ten thousand.
const POLE: f64 = 1e3;

/// So far from a place on both sides a value has digits whose own are lost beside it, as that of a root of what touches zero; what has a pole there grows towards it by more
/// than this factor from ten times as far.
const LOST: f64 = 1e-5;
const GROWS_SLOWLY: f64 = 2.0;

/// An acceleration nearly jumps that changes so close to a place, as a part of the way, by this part of itself: what is resolved does so by a quarter at most.
const CLOSE: f64 = 1.0 / 32.0;
const MOST: f64 = 0.5;

/// A place so near to an end of the way, as a part of it, is there.
const AT_NODE: f64 = 1e-9;

/// An acceleration is known to this part of what sides make of it, and other quantities to this part of themselves.
const NOISE: f64 = 1e-9;

/// It is known to this part of the largest of all components.
const ROUNDING: f64 = 1e-12;

/// A way, and what holds on it.
pub(crate) struct OnWay<'a> {
    /// Its places.
    pub(crate) way: &'a Way<'a>,
    /// The step whose rounding velocities have.
    pub(crate) h: f64,
    /// The declaration up to the middle of the way, and from there on.
    pub(crate) declarations: [Declaration<'a>; 2],
    /// Where the arguments of functions that jump with the velocity are when it begins; those between rest. Empty where none does.
    pub(crate) pieces: &'a [Piece],
}

/// The acceleration at a place.
struct Acceleration {
    /// The acceleration; of third order that which the equations without jerks have next to that of the way, then the jerk.
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
        let Place { t, q, v, a } = (self.way)(part);
        let declaration = self.declaration(part);
        if declaration.shape().is_of_third_order() {
            return self.third(&declaration, t, [&q, &v, &a]);
        }
        let of = |a: Vector, reach: &[f64], rates: Vec<f64>| {
            let size = largest(&a);
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
        let rests = self.pieces.contains(&Piece::Between);
        let fastest = rests.then(|| point.fastest(&Vector::zero(q.len()), multipliers));
        // a surface may have another velocity at once, to which nothing comes within the step
        let follows = |g: usize| {
            fastest
                .as_ref()
                .is_some_and(|fastest| arguments[g].abs() <= self.h.abs() * fastest[g])
        };
        let pieces: Vec<Piece> = (0..arguments.len())
            .map(|g| match self.pieces.get(g) {
                Some(Piece::Between) if follows(g) => Piece::Between,
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

    /// The same of third order.
    fn third(&self, declaration: &Declaration<'_>, t: f64, [q, v, a]: [&[f64]; 3]) -> Option<Acceleration> {
        let n = q.len();
        let mut all = third::lower_acceleration(declaration, t, [q, v, a])?;
        let jerk = third::jerk(declaration, t, [q, v, &all], &vec![0.0; n])?;
        all.extend(jerk);
        let sizes = [largest(&all[..n]), largest(&all[n..])];
        let noise = Vector::from_fn(2 * n, |i| {
            let of_acceleration = jumps::rounding(self.h, v[i % n] * self.h);
            let of_own = of_acceleration / if i < n { 1.0 } else { self.h.abs() };
            of_own.max(ROUNDING * sizes[i / n])
        });
        Some(Acceleration {
            a: Vector::of(&all),
            noise,
            rates: Vec::new(),
        })
    }

    /// How far the acceleration at a part of the way is from what its ends lead to expect, relative to itself; 0 if that is less than a quarter: there the step
    /// leads over something that it does not see.
    pub(crate) fn swings_at(&self, part: f64) -> f64 {
        let [Some(first), Some(here), Some(last)] = [0.0, part, 1.0].map(|part| self.acceleration(part))
        else {
            return f64::INFINITY;
        };
        let size = largest(&here.a);
        let ends = first.a.zip(&last.a, |first, last| first + part * (last - first));
        let apart = largest(&here.a.zip(&ends, |here, ends| here - ends));
        if apart > 0.25 * size { apart / size } else { 0.0 }
    }

    /// How much the acceleration jumps at the place where an argument changes its sign, relative to itself: the largest of all components. It is infinite where
    /// the acceleration has no value, or grows without bound, or the velocity has to jump.
    pub(crate) fn jump_at(&self, Crossing { switch, parts }: Crossing) -> f64 {
        let jump = self.jump_between(switch, parts);
        if jump.is_finite() {
            return if jump <= jumps::TOLD {
                self.near_jump(parts)
            } else {
                jump
            };
        }
        let [before, after] = [parts[0] - LOST, parts[1] + LOST];
        if self.is_bounded([before, after]) {
            self.jump_between(switch, [before, after])
        } else {
            jump
        }
    }

    /// How much the acceleration changes close to a place where it does not jump, if most of it does so there: relative to itself, else 0. What rests and what moves are not
    /// compared.
    fn near_jump(&self, [before, after]: [f64; 2]) -> f64 {
        if self.declarations[0].sides() > 0 {
            return 0.0;
        }
        let places = [0.0, before - CLOSE, before, after, after + CLOSE, 1.0];
        let [
            Some(first),
            Some(left),
            Some(here),
            Some(there),
            Some(right),
            Some(last),
        ] = places.map(|part| self.acceleration(part))
        else {
            return 0.0;
        };
        let sizes = [&first, &left, &here, &right, &last].map(|at| largest(&at.a));
        let size = sizes.into_iter().fold(0.0, f64::max);
        // a jump that costs no order
        if largest(&here.a.zip(&there.a, |here, there| there - here)) > jumps::TOLD * size {
            return 0.0;
        }
        let across = left.a.zip(&right.a, |left, right| right - left);
        let middle = left.a.zip(&right.a, |left, right| 0.5 * (left + right));
        let change = largest(&across).max(largest(&here.a.zip(&middle, |here, middle| here - middle)));
        if change > MOST * size { change / size } else { 0.0 }
    }

    /// Whether accelerations at some places on both sides of another one are not much larger than farther away.
    fn is_bounded(&self, [before, after]: [f64; 2]) -> bool {
        let sizes = [before - 9.0 * LOST, before, after, after + 9.0 * LOST].map(|part| {
            let at = self.acceleration(part)?;
            Some(largest(&at.a))
        });
        let [Some(left), Some(before), Some(after), Some(right)] = sizes else {
            return false;
        };
        before <= GROWS_SLOWLY * left && after <= GROWS_SLOWLY * right
    }

    /// The same between two places.
    fn jump_between(&self, switch: usize, parts: [f64; 2]) -> f64 {
        let [before, after] = parts;
        let places = [before - ASIDE, before, after, after + ASIDE];
        if self.has_step(places) {
            return f64::INFINITY;
        }
        let [Some(left), Some(before), Some(after), Some(right)] = places.map(|part| self.acceleration(part))
        else {
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
        let ends = [0.0, 1.0].map(|part| {
            self.acceleration(part)
                .map_or_else(|| before.a.clone(), |at| at.a)
        });
        let all = jump([&before.a, &after.a], [&left.a, &right.a], ends.each_ref(), noise);
        // what is only narrow is as large at some distance
        if all == f64::INFINITY && !self.grows(places, [&before.a, &after.a]) {
            return 1.0;
        }
        // a leg of third order takes the jerk at its middle, so that one which jumps at a node costs no order
        let is_at_node = parts.iter().all(|part| (part - part.round()).abs() < AT_NODE);
        let jump = if all.is_finite() && is_at_node && self.declarations[0].shape().is_of_third_order() {
            let n = ends[0].len() / 2;
            let own = |at: &Vector| Vector::resized(at, n);
            let [left, before, after, right] = [&left.a, &before.a, &after.a, &right.a].map(own);
            let ends = ends.each_ref().map(own);
            jump([&before, &after], [&left, &right], ends.each_ref(), noise)
        } else {
            all
        };
        // with sides the arguments of what rests are zero to rounding, and have any sign
        let has_sides = self.declarations[0].sides() > 0;
        if jump.is_finite() && jump > 0.0 && !has_sides && !self.has_cause(places, &before.a) {
            return 0.0;
        }
        jump
    }

    /// Whether an acceleration without a bound is larger beside a place than at a small distance from it.
    fn grows(&self, [_, before, after, _]: [f64; 4], beside: [&Vector; 2]) -> bool {
        let near = [before - NEAR, after + NEAR].map(|part| self.acceleration(part));
        near.iter().zip(beside).any(|(near, beside)| {
            let beside = largest(beside);
            !beside.is_finite() || near.as_ref().is_none_or(|near| beside > GROWS * largest(&near.a))
        })
    }

    /// Whether the velocity has to jump: the Lagrangian does, with the position or the velocity, or the momentum, or what constraints ask of positions and
    /// velocities.
    fn has_step(&self, places: [f64; 4]) -> bool {
        let begin = (self.way)(places[1]).t;
        let declaration = self.declaration(places[1]);
        let all = places.map(|part| {
            let Place { t, q, v, .. } = (self.way)(part);
            let still = map(&q, Tangent::splat);
            // a Lagrangian that jumps in time alone makes no force
            let lagrangian = declaration.lagrangian::<f64>(begin, &q, &v);
            let momenta = (0..v.len()).map(|j| {
                let moved = moved(&v, j);
                declaration
                    .lagrangian(Tangent::splat(t), &still, &moved)
                    .derivative()
            });
            let mut all: Vec<f64> = momenta.chain([lagrangian]).collect();
            all.extend(declaration.phase::<f64>(t, &q, &v));
            all
        });
        let Place { t, q, v, .. } = (self.way)(places[1]);
        let mut terms = vec![0.0; v.len() + 1];
        terms.extend(rounding::phase_sizes(&declaration, t, &q, &v));
        differ(all, &terms)
    }

    /// What makes the motion: the generalized force `∂L/∂q + f`, the kinematic rows with an acceleration, of third order with a jerk after it, the forms of
    /// the constraint forces, and the mass.
    fn causes(&self, part: f64, motion: &[f64]) -> Vec<f64> {
        let Place { t, q, v, a: own } = (self.way)(part);
        let (a, j) = motion.split_at(q.len());
        // of third order the acceleration is that of the way, which does not jump
        let a = if own.is_empty() { a } else { &own };
        let declaration = self.declaration(part);
        let shape = declaration.shape();
        let still = map(&v, Tangent::splat);
        let of_lagrangian = (0..q.len()).map(|j| {
            let moved = moved(&q, j);
            declaration
                .lagrangian(Tangent::splat(t), &moved, &still)
                .derivative()
        });
        let mut causes = vec![0.0; q.len()];
        declaration.external_forces(t, &q[..], &v[..], &mut causes);
        for (cause, own) in causes.iter_mut().zip(of_lagrangian) {
            *cause += own;
        }
        let point = AnyPoint {
            t,
            q: &q[..],
            v: &v[..],
            a,
        };
        let rows = declaration.continuous_of_third(point, j, &vec![0.0; shape.multipliers()]);
        let lower = shape.holonomic + shape.nonholonomic;
        causes.extend(rows.into_iter().skip(lower).take(shape.kinematic));
        causes.extend(declaration.continuous_forms(point).into_iter().flatten());
        let mass = start::mass_matrix(&declaration, (t, &q, &v));
        causes.extend((0..q.len()).flat_map(|i| mass.row(i).collect::<Vec<_>>()));
        causes
    }

    /// Whether anything that makes the motion jumps at a place, to a part of itself. A corner of a constraint's curvature or of a mass makes the acceleration jump,
    /// and costs no order: the discrete equations balance momenta. A mass that jumps with the velocity, whose momentum does not, costs that of the velocity at the
    /// nodes beside the place, which is the mean of those of two legs.
    fn has_cause(&self, parts: [f64; 4], a: &[f64]) -> bool {
        differ(parts.map(|part| self.causes(part, a)), &[])
    }
}

/// The largest absolute value.
fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0_f64, |largest, a| largest.max(a.abs()))
}

/// Whether any of some quantities jumps between the second and the third of four places: by more than a part of itself or of its terms, and by more than it
/// changes beside them.
fn differ([left, before, after, right]: [Vec<f64>; 4], terms: &[f64]) -> bool {
    (0..before.len()).any(|i| {
        let all = [left[i], before[i], after[i], right[i]];
        let terms = terms.get(i).copied().unwrap_or(0.0);
        let size = all.iter().fold(terms, |size, x| size.max(x.abs()));
        let jump = (after[i] - before[i]).abs().min((right[i] - left[i]).abs());
        let beside = (before[i] - left[i]).abs().max((right[i] - after[i]).abs());
        !jump.is_finite() || jump > (NOISE * size).max(beside)
    })
}

/// How much two accelerations differ, relative to the largest of the way: the most of all components, each of which is known to a rounding error; infinite at
/// a pole, where one is larger by far than both of those at some distance.
fn jump(
    [before, after]: [&Vector; 2],
    [left, right]: [&Vector; 2],
    ends: [&Vector; 2],
    noise: impl Fn(usize) -> f64,
) -> f64 {
    let parts = (0..before.len()).map(|i| {
        let size = before[i].abs().max(after[i].abs());
        if !size.is_finite() {
            return f64::INFINITY;
        }
        let elsewhere = left[i].abs().max(right[i].abs()).max(noise(i));
        // what is divided by zero where it is zero itself has few digits there, and does not jump
        let difference = (after[i] - before[i]).abs().min((right[i] - left[i]).abs());
        if size > POLE * elsewhere && elsewhere > 0.0 {
            f64::INFINITY
        } else if difference <= noise(i) {
            0.0
        } else {
            // a root is steep at its zero, and does not jump; and a small acceleration is none to compare with
            let size = ends
                .iter()
                .fold(size.max(elsewhere), |size, end| size.max(end[i].abs()));
            difference / size
        }
    });
    parts.fold(0.0, f64::max)
}
