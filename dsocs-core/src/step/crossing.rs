//! Jumps of the acceleration where an argument of a piecewise expression changes its sign on the path of a
//! step.
//!
//! Accelerations on the two sides of the place are compared: at a corner they agree, at a jump they differ,
//! and at a pole they grow without bound. A body at rest on a surface is taken to rest on both sides, as long
//! as the forces allow it. So a jump that releases a resting mass is noticed, and so is one that acts on
//! another coordinate while a body rests.

use super::jumps;
use super::switches::Crossing;
use crate::number::largest;
use crate::number::point::{AnyPoint, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::resting::{AtPoint, Held};
use crate::regularity::rounding;
use crate::regularity::sides::{self, Piece};
use crate::solve::Vector;
use crate::start::place::{MotionPath, Place};
use crate::start::{self, third};
use crate::tape::declaration::Declaration;

/// Distance from a place, as a part of the path, at which the accelerations for comparison are taken: a pole
/// is smaller there.
const ASIDE: f64 = 1e-4;

/// Distance from a place at which a quantity with a pole is smaller than right beside it, by the factor
/// [`GROWS`] at least: one over a root.
const NEAR: f64 = 1e-8;
const GROWS: f64 = 10.0;

/// The least such factor between a place and [`ASIDE`]: one over the distance grows by a hundred million, one
/// over its root by ten thousand.
const POLE: f64 = 1e3;

/// Distance from a place within which a bounded quantity may lose its digits, as the root of a quantity that touches zero. A quantity has a
/// pole at the place if it is larger here than at ten times this distance by more than the factor [`GROWS_SLOWLY`].
const LOST: f64 = 1e-5;
const GROWS_SLOWLY: f64 = 2.0;

/// An acceleration nearly jumps if it changes within the part [`CLOSE`] of the path by more than the part [`MOST`] of its size; one that the
/// step resolves changes by a quarter at most.
const CLOSE: f64 = 1.0 / 32.0;
const MOST: f64 = 0.5;

/// It also nearly jumps if it changes there by more than this part of its size, and as many times more than it changes over the same length before and after.
const RAMP: f64 = 0.02;
const STEEP: f64 = 8.0;

/// Distances from a place at which the change of an acceleration shows a root: from each of them to the next it grows by a power of the distance
/// below [`ROOT`]. That of a smooth function, and beside a corner, is 1.
const TOWARDS: [f64; 3] = [1e-7, 1e-5, 1e-3];
const ROOT: f64 = 0.95;

/// The rate of a slip that crosses zero changes by less than the rest of this part where the force is a root of the slip.
const CROSSES: f64 = 0.8;

/// A change shows a power if it is as many times its rounding.
const CLEAR: f64 = 8.0;

/// The path is followed at least this far to both sides of such a place: there a force that grows linearly from it is eight times as large.
const BESIDE: f64 = 0.25;

/// A deviation is narrow if it is smaller than this part of itself halfway to the ends of the path: that of two lines is half of it.
const NARROW: f64 = 0.25;

/// Distance from an end of the path, as a part of it, within which the path is followed beyond.
const AT_END: f64 = 1.0 / 8.0;

/// Distance from an extremum of an argument, as a part of the path, at which the acceleration is on the one side of it or the other.
const ABOUT: f64 = 1.0 / 64.0;

/// A place nearer than this to an end of the path, as a part of it, counts as that end.
const AT_NODE: f64 = 1e-9;

/// Relative accuracy of an acceleration with resting bodies, and of other quantities.
const NOISE: f64 = 1e-9;

/// Accuracy of a component of the acceleration, relative to the largest one.
const ROUNDING: f64 = 1e-12;

/// The path of a step with the declarations that hold on it.
pub(crate) struct StepPath<'a> {
    /// The path: time, position, velocity and acceleration as a function of the part 0…1.
    pub(crate) path: &'a MotionPath<'a>,
    /// The length of the step, from which the rounding of its velocities follows.
    pub(crate) h: f64,
    /// The declaration up to the middle of the path, and from there on.
    pub(crate) declarations: [Declaration<'a>; 2],
    /// The pieces of the arguments of functions that jump with the velocity, at the beginning of the path;
    /// those between two pieces rest. Empty without such functions.
    pub(crate) pieces: &'a [Piece],
}

/// The acceleration at a place of the path.
struct Acceleration {
    /// The acceleration. In third order, the acceleration of the equations without jerks next to that of the
    /// path, then the jerk.
    a: Vector,
    /// The accuracy of each component.
    noise: Vector,
    /// The rounding error of its evaluation, in second order without sides: a quotient loses its digits towards a zero of its divisor.
    rounding: Option<Vector>,
    /// The rates of the arguments of functions that jump with the velocity.
    rates: Vec<f64>,
}

impl Acceleration {
    /// The rounding error of a component.
    fn error(&self, i: usize) -> f64 {
        let rounding = self.rounding.as_ref().and_then(|rounding| rounding.get(i));
        rounding.map_or(self.noise[i], |rounding| self.noise[i].max(*rounding))
    }

    /// The largest component of a vector beyond its rounding error.
    fn largest(&self, vector: &Vector) -> f64 {
        let components = vector.iter().enumerate();
        components.fold(0.0, |most, (i, x)| f64::max(most, x.abs() - self.error(i)))
    }
}

/// The change of the acceleration at a place, relative to itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(crate) size: f64,
    /// Whether the acceleration jumps there; else it is continuous, with a rate that is large or has no bound.
    pub(crate) is_jump: bool,
}

impl StepPath<'_> {
    /// The declaration that holds at a part of the path.
    fn declaration(&self, part: f64) -> Declaration<'_> {
        self.declarations[usize::from(part >= 0.5)]
    }

    /// The acceleration at a part of the path, with resting bodies where there are any.
    fn acceleration(&self, part: f64) -> Option<Acceleration> {
        let place = (self.path)(part);
        let declaration = self.declaration(part);
        let Place { t, q, v, a } = &place;
        let t = *t;
        if declaration.shape().is_of_third_order() {
            return self.third(&declaration, t, [q, v, a]);
        }
        let of = |a: Vector, reach: &[f64], rates: Vec<f64>| {
            let size = largest(&a);
            let noise = Vector::from_fn(a.len(), |i| {
                let reach = reach.get(i).map_or(0.0, |reach| NOISE * reach);
                jumps::rounding(self.h, v[i] * self.h)
                    .max(ROUNDING * size)
                    .max(reach)
            });
            Acceleration {
                a,
                noise,
                rounding: None,
                rates,
            }
        };
        if declaration.sides() == 0 {
            let (a, multipliers) = start::acceleration(&declaration, (t, q, v), None).ok()?;
            let motion = [&a[..], &multipliers].concat();
            return Some(Acceleration {
                rounding: place.rounding(&declaration, &motion),
                ..of(a, &[], Vec::new())
            });
        }
        let point = AtPoint::new(declaration, (t, q, v));
        let multipliers = declaration.shape().multipliers();
        let arguments = point.arguments();
        let rests = self.pieces.contains(&Piece::Between);
        let fastest = rests.then(|| point.fastest(&Vector::zero(q.len()), multipliers));
        // a surface may change its velocity at once: then nothing comes to rest on it within the step
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
        let held = point.held(&pieces, &guess).filter(|held| !held.leaves);
        let zero = sides::resting(&pieces);
        let (x, reach) = if zero.contains(&true) {
            // a body at rest stays at rest as long as it can
            let Held { x, reach, .. } = held.unwrap_or(guess);
            (point.solve(&zero, multipliers, Some(&x))?.x, reach)
        } else {
            let Held { x, reach, .. } = held?;
            (x, reach)
        };
        let a = Vector::of(x.get(..q.len())?);
        let rates = (0..arguments.len()).map(|g| point.rate(g, &a)).collect();
        Some(of(a, &reach, rates))
    }

    /// The acceleration and the jerk in third order.
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
            rounding: None,
            rates: Vec::new(),
        })
    }

    /// The deviation of the acceleration at a part of the path, or its change close to it, relative to itself; 0 if less than a quarter. There
    /// the step passes over a feature that it does not resolve. Where the force of a norm turns over as the norm vanishes, the acceleration has
    /// no value, or that of either side.
    pub(crate) fn swings_at(&self, part: f64) -> f64 {
        let swing = |part: f64| Some(self.deviation(part)?.max(self.turn(part)));
        match swing(part) {
            None if !self.is_bounded([part - LOST, part + LOST]) => f64::INFINITY,
            Some(size) if size > 0.0 => size,
            _ => [part - ABOUT, part + ABOUT].into_iter().fold(0.0, |most, part| {
                swing(part).map_or(f64::INFINITY, |size| size.max(most))
            }),
        }
    }

    /// The part of the path about a place with which the acceleration there is compared: the whole of it, or beside an end half of one to both
    /// sides, since an end may lie within a feature.
    fn about(part: f64) -> [f64; 2] {
        if (AT_END..1.0 - AT_END).contains(&part) {
            [0.0, 1.0]
        } else {
            [part - 0.5, part + 0.5]
        }
    }

    /// The deviation of the acceleration at a part of the path from the line between its values before and after, relative to the largest of
    /// the three, if it lies beyond both or deviates there alone; else 0. Between two others, or as one of them, it is that of a force that
    /// begins, or that of a body that goes from one contact to the next. `None` if an acceleration has no value.
    pub(crate) fn deviation(&self, part: f64) -> Option<f64> {
        let [from, to] = Self::about(part);
        let [first, here, last] = [
            self.acceleration(from)?,
            self.acceleration(part)?,
            self.acceleration(to)?,
        ];
        let apart = |at: &Acceleration, part: f64| {
            let part = (part - from) / (to - from);
            let line = first.a.zip(&last.a, |first, last| first + part * (last - first));
            at.a.zip(&line, |at, line| at - line)
        };
        let (size, of_ends) = (largest(&here.a), largest(&first.a).max(largest(&last.a)));
        let peak = here.largest(&apart(&here, part));
        let is_beyond = || {
            let beyond = (0..here.a.len()).map(|i| {
                let [before, after] = [&first, &last].map(|end| here.a[i] - end.a[i]);
                let is_extreme = before * after > 0.0;
                if is_extreme {
                    before.abs().min(after.abs())
                } else {
                    0.0
                }
            });
            peak > 0.25 * size.max(of_ends) && beyond.fold(0.0, f64::max) > NARROW * peak
        };
        let is_narrow = || {
            [0.5 * (from + part), 0.5 * (part + to)].iter().all(|&beside| {
                let at = self.acceleration(beside);
                at.is_none_or(|at| largest(&apart(&at, beside)) < NARROW * peak)
            })
        };
        let deviates = is_beyond() || peak > 0.25 * size && is_narrow();
        Some(if deviates { peak / size.max(of_ends) } else { 0.0 })
    }

    /// The change of the acceleration from one side of a part of the path to the other, halved and relative to itself, if most of it is close
    /// to the place and it is no larger elsewhere; else 0.
    fn turn(&self, part: f64) -> f64 {
        let ends = Self::about(part).map(|end| (end, self.acceleration(end)));
        let [(_, Some(first)), (_, Some(last))] = &ends else {
            return 0.0;
        };
        let Some(here) = self.acceleration(part) else {
            return 0.0;
        };
        let (size, of_ends) = (largest(&here.a), largest(&first.a).max(largest(&last.a)));
        let change = |from: &Acceleration| here.largest(&here.a.zip(&from.a, |here, from| here - from));
        let turns = ends.iter().filter_map(|(end, at)| {
            let all = change(at.as_ref()?);
            let halfway = self.acceleration(0.5 * (end + part));
            let is_close = halfway.is_none_or(|halfway| change(&halfway) > (1.0 - NARROW) * all);
            (is_close && all > 0.5 * size).then_some(0.5 * all / size.max(of_ends))
        });
        if size >= (1.0 - NOISE) * of_ends {
            turns.fold(0.0, f64::max)
        } else {
            0.0
        }
    }

    /// The change of the acceleration where an argument changes its sign, relative to itself: the largest of
    /// all components. Infinite if the acceleration has no value, or grows without bound, or the velocity has
    /// to jump.
    pub(crate) fn change_at(&self, Crossing { switch, parts }: Crossing) -> Change {
        let mut size = self.jump_between(switch, parts);
        if size <= jumps::REPORTED {
            return Change {
                size: self.near_jump(parts).max(self.root_at(switch, parts)),
                is_jump: false,
            };
        }
        let [before, after] = [parts[0] - LOST, parts[1] + LOST];
        if size == f64::INFINITY && self.is_bounded([before, after]) {
            size = self.jump_between(switch, [before, after]);
        }
        Change {
            size,
            is_jump: size > jumps::REPORTED,
        }
    }

    /// The relative change of the acceleration close to a place where it does not jump, if most of the change
    /// occurs there, else 0. Always 0 if the declaration has sides, where rest and motion cannot be compared.
    fn near_jump(&self, [before, after]: [f64; 2]) -> f64 {
        if self.declarations[0].sides() > 0 {
            return 0.0;
        }
        // near an end of the path a force that grows from nothing has nothing else there to be compared with
        let ends = [(before - BESIDE).min(0.0), (after + BESIDE).max(1.0)];
        let places = [ends[0], before - CLOSE, before, after, after + CLOSE, ends[1]];
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
        let across = left.a.zip(&right.a, |left, right| right - left);
        // a jump that does not lower the order
        let jump = largest(&here.a.zip(&there.a, |here, there| there - here));
        if jump > jumps::REPORTED * size && jump > MOST * largest(&across) {
            return 0.0;
        }
        let middle = left.a.zip(&right.a, |left, right| 0.5 * (left + right));
        let apart = here.a.zip(&middle, |here, middle| here - middle);
        let change = largest(&across).max(here.largest(&apart));
        if change > MOST * size {
            return change / size;
        }
        // a ramp between two corners, much steeper than the acceleration on both of its sides
        let beside = [
            (&first, &left, before - CLOSE - ends[0]),
            (&right, &last, ends[1] - after - CLOSE),
        ];
        let slopes =
            beside.map(|(from, to, length)| largest(&to.a.zip(&from.a, |to, from| to - from)) / length);
        let expected = 2.0 * CLOSE * slopes[0].max(slopes[1]);
        let is_ramp = across
            .iter()
            .enumerate()
            .any(|(i, by)| by.abs() > left.error(i).max(right.error(i)));
        let change = largest(&across);
        if is_ramp && change > RAMP * size && change > STEEP * expected {
            change / size
        } else {
            0.0
        }
    }

    /// The relative change of the acceleration beside a place where its rate has no bound, as that of a root where it is zero; 0 elsewhere. On all
    /// scales it changes there by a power of the distance below one.
    fn root_at(&self, switch: usize, [before, after]: [f64; 2]) -> f64 {
        if self.pieces.contains(&Piece::Between) {
            return 0.0;
        }
        let root = |from: f64, direction: f64| {
            let at = |distance: f64| self.acceleration(from + direction * distance);
            let (here, beside) = (at(0.0)?, at(BESIDE)?);
            let change = |to: &Acceleration| largest(&to.a.zip(&here.a, |to, here| to - here));
            let [Some(first), Some(second), Some(third)] = TOWARDS.map(at) else {
                return None;
            };
            // a slip that a root itself leads to zero comes to rest there, without a loss of order
            let rates = [&first, &third].map(|at| at.rates.get(switch).copied());
            if let [Some(near), Some(far)] = rates
                && near.abs() < CROSSES * far.abs()
            {
                return None;
            }
            let changes = [&first, &second, &third].map(change);
            let noise =
                (0..here.a.len()).fold(0.0_f64, |most, i| most.max(here.error(i).max(first.error(i))));
            let is_root = changes[0] > CLEAR * noise
                && changes.windows(2).zip(TOWARDS.windows(2)).all(|(change, at)| {
                    let grows = (change[1] / change[0]).ln() / (at[1] / at[0]).ln();
                    (0.0..ROOT).contains(&grows)
                });
            let size = largest(&here.a).max(largest(&beside.a));
            Some(if is_root { change(&beside) / size } else { 0.0 })
        };
        let both = [root(before, -1.0), root(after, 1.0)];
        both.into_iter().flatten().fold(0.0, f64::max)
    }

    /// Whether the accelerations at two places about a third one are not much larger than farther away.
    fn is_bounded(&self, [before, after]: [f64; 2]) -> bool {
        let places = [before - 9.0 * LOST, before, after, after + 9.0 * LOST];
        let [Some(left), Some(before), Some(after), Some(right)] = places.map(|part| self.acceleration(part))
        else {
            return false;
        };
        let is_larger = |at: &Acceleration, than: &Acceleration| {
            // false also for a NaN
            let is_bounded = at.largest(&at.a) <= GROWS_SLOWLY * largest(&than.a);
            !(is_bounded && at.a.is_finite())
        };
        !is_larger(&before, &left) && !is_larger(&after, &right)
    }

    /// The jump of the acceleration between two places.
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
        // both sides drive the argument back to zero: the body comes to rest
        let rates = [&before, &after].map(|at| at.rates.get(switch).copied());
        if let [Some(before), Some(after)] = rates
            && before * after < 0.0
        {
            return 0.0;
        }
        let noise = |i: usize| before.noise[i].max(after.noise[i]);
        let error = |i: usize| before.error(i).max(after.error(i));
        let ends = [0.0, 1.0].map(|part| {
            self.acceleration(part)
                .map_or_else(|| before.a.clone(), |at| at.a)
        });
        let all = jump(
            [&before.a, &after.a],
            [&left.a, &right.a],
            ends.each_ref(),
            (noise, error),
        );
        // a narrow peak, unlike a pole, is as large at some distance
        if all == f64::INFINITY && !self.grows(places, [&before.a, &after.a]) {
            return 1.0;
        }
        // a leg of third order takes the jerk at its middle, so that a jump of the jerk at a node does not
        // lower the order
        let is_at_node = parts.iter().all(|part| (part - part.round()).abs() < AT_NODE);
        let jump = if all.is_finite() && is_at_node && self.declarations[0].shape().is_of_third_order() {
            let n = ends[0].len() / 2;
            let own = |at: &Vector| Vector::resized(at, n);
            let [left, before, after, right] = [&left.a, &before.a, &after.a, &right.a].map(own);
            let ends = ends.each_ref().map(own);
            jump(
                [&before, &after],
                [&left, &right],
                ends.each_ref(),
                (noise, error),
            )
        } else {
            all
        };
        // with sides, the arguments of resting bodies are zero to rounding, with any sign
        let has_sides = self.declarations[0].sides() > 0;
        if jump.is_finite() && jump > 0.0 && !has_sides && !self.has_cause(places, &before.a) {
            return 0.0;
        }
        jump
    }

    /// Whether an unbounded acceleration is larger right beside a place than at the distance [`NEAR`] from
    /// it.
    fn grows(&self, [_, before, after, _]: [f64; 4], beside: [&Vector; 2]) -> bool {
        let near = [before - NEAR, after + NEAR].map(|part| self.acceleration(part));
        near.iter().zip(beside).any(|(near, beside)| {
            let beside = largest(beside);
            !beside.is_finite() || near.as_ref().is_none_or(|near| beside > GROWS * largest(&near.a))
        })
    }

    /// Whether the velocity has to jump: the Lagrangian jumps with position or velocity, or the momentum
    /// does, or the constraints on positions and velocities do.
    fn has_step(&self, places: [f64; 4]) -> bool {
        let begin = (self.path)(places[1]).t;
        let declaration = self.declaration(places[1]);
        let all = places.map(|part| {
            let Place { t, q, v, .. } = (self.path)(part);
            let still = map(&q, Tangent::splat);
            // a Lagrangian that jumps in time alone exerts no force
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
        let Place { t, q, v, .. } = (self.path)(places[1]);
        let mut terms = vec![0.0; v.len() + 1];
        terms.extend(rounding::phase_sizes(&declaration, t, &q, &v));
        differ(all, &terms)
    }

    /// The quantities that determine the motion: the generalized force `∂L/∂q + f`, the kinematic rows at an
    /// acceleration (in third order with a jerk after it), the constraint forms, and the mass matrix.
    fn causes(&self, part: f64, motion: &[f64]) -> Vec<f64> {
        let Place { t, q, v, a: own } = (self.path)(part);
        let (a, j) = motion.split_at(q.len());
        // in third order the acceleration is that of the path, which does not jump
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
        let mass = start::mass_matrix(&declaration, t, &q, &v);
        causes.extend((0..q.len()).flat_map(|i| mass.row(i).collect::<Vec<_>>()));
        causes
    }

    /// Whether one of the [`causes`](Self::causes) jumps at a place. Otherwise the acceleration jumps because
    /// of a corner in a constraint or a mass, which does not lower the order: the discrete equations balance
    /// momenta. A mass that jumps with the velocity, without a jump of the momentum, lowers only the order of
    /// the velocity at the nodes beside the place, which is the mean over two legs.
    fn has_cause(&self, parts: [f64; 4], a: &[f64]) -> bool {
        differ(parts.map(|part| self.causes(part, a)), &[])
    }
}

/// Whether a quantity jumps between the second and the third of four places: by more than a part of itself or
/// of its terms, and by more than it changes beside them.
fn differ([left, before, after, right]: [Vec<f64>; 4], terms: &[f64]) -> bool {
    (0..before.len()).any(|i| {
        let all = [left[i], before[i], after[i], right[i]];
        // a derivative may be a quotient that has no value right beside the place, as that of acos at 1
        if !(before[i].is_finite() && after[i].is_finite()) {
            let size = left[i].abs().max(right[i].abs());
            return !size.is_finite() || (right[i] - left[i]).abs() > jumps::REPORTED * size;
        }
        let terms = terms.get(i).copied().unwrap_or(0.0);
        let size = all.iter().fold(terms, |size, x| size.max(x.abs()));
        let jump = (after[i] - before[i]).abs().min((right[i] - left[i]).abs());
        let beside = (before[i] - left[i]).abs().max((right[i] - after[i]).abs());
        !jump.is_finite() || jump > (NOISE * size).max(beside)
    })
}

/// The largest difference of the components of two accelerations beyond their rounding errors, `error`, relative to the
/// largest on the path; those below `noise` are nothing. Infinite at a pole, where one is far larger than both of those at some distance.
fn jump(
    [before, after]: [&Vector; 2],
    [left, right]: [&Vector; 2],
    ends: [&Vector; 2],
    (noise, error): (impl Fn(usize) -> f64, impl Fn(usize) -> f64),
) -> f64 {
    let parts = (0..before.len()).map(|i| {
        let size = before[i].abs().max(after[i].abs());
        if !size.is_finite() {
            return f64::INFINITY;
        }
        let elsewhere = left[i].abs().max(right[i].abs()).max(noise(i));
        // a quotient `0/0` has few digits at its zero, and does not jump
        let difference = (after[i] - before[i]).abs().min((right[i] - left[i]).abs());
        if size > POLE * elsewhere && elsewhere > 0.0 {
            f64::INFINITY
        } else if difference <= error(i) {
            0.0
        } else {
            // a root is steep at its zero, and does not jump; a small acceleration is no measure for it
            let size = ends
                .iter()
                .fold(size.max(elsewhere), |size, end| size.max(end[i].abs()));
            difference / size
        }
    });
    parts.fold(0.0, f64::max)
}
