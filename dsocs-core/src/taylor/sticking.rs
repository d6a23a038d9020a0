//! Steps in which something rests on a surface, as by dry friction.
//!
//! There the force of a function that jumps with the velocity is none of its two sides but what keeps its argument at zero. The recurrences know the two
//! sides only. As long as the same arguments stay at zero, the acceleration is a smooth function of the time, the position and the velocity
//! ([`AtPoint::held`]), and the motion is found as a polynomial: its acceleration agrees with this function at Chebyshev's places of the step, to which
//! Picard's iteration leads (C. W. Clenshaw, H. J. Norton, *Comput. J.* 6, 1963; X. Bai, J. L. Junkins, *J. Astronaut. Sci.* 58, 2011). The polynomial's last
//! coefficients tell the error.
//!
//! The step ends where a side reaches its bound, and the mass is torn off, where another argument arrives at zero, or where what is given by pieces changes its piece. Then the inclusion of
//! [`AtPoint::solve`] tells what rests from there on. If nothing does, the recurrences go on.

use super::integrator::{Integrator, Outcome};
use super::recurrences::SeriesKernel;
use super::watch::AT_ONCE;
use crate::number::compensated::Compensated;
use crate::number::larger;
use crate::number::point::AnyPoint;
use crate::regularity::resting::{AtPoint, Held};
use crate::regularity::sides::Piece;
use crate::regularity::sticking as sides;
use crate::solve::Vector;
use crate::solve::rotation::{self, SLOTS};
use crate::start::place::Place;
use crate::tape::declaration::Declaration;

/// The degree of the acceleration.
const DEGREE: usize = 14;

/// The number of its coefficients, and of places.
const COUNT: usize = DEGREE + 1;

/// The number of coefficients of a quaternion: those of a position.
const TURNS: usize = COUNT + 2;

/// How often the iteration goes on.
const ITERATIONS: u32 = 40;

/// An acceleration is known up to so many roundings of what the sides make of it.
const ROUNDINGS: f64 = 16.0;

/// If the iteration does not come so far, rounding is larger, up to so many.
const MOST_ROUNDINGS: f64 = 1e4;

/// By how much the next step is shorter or longer, at most, and how much is left to chance.
const CHANGES: [f64; 2] = [0.1, 4.0];
const CAUTION: f64 = 0.8;

/// In so many equal parts a step is divided in which events are looked for.
const PARTS: u32 = 64;

/// What is left of the sides' polynomials may be rounding below this.
const LEAST_TAIL: f64 = 1e-9;

/// A side that is so near its bound is computed for itself.
const NEAR: f64 = 0.05;

/// An argument is beyond zero by more than this part of what the sides can do to it in the step.
const BESIDE: f64 = 1e-13;

/// An event is found up to this part of the step.
const FOUND: f64 = 4.0 * f64::EPSILON;

/// Arguments that differ by less than this part of themselves are one.
const SAME: f64 = 1e-12;

/// At the end of a step an argument at rest may be so many tolerances of the velocity from zero.
const LEFT: f64 = 10.0;

/// An argument is zero that arrives there in this part of the time in which the motion changes.
const ARRIVES: f64 = 1e-9;

/// What rests, and what slides to which side.
#[derive(Clone, Debug)]
pub(super) struct Sticking {
    /// Of each argument; those between rest.
    pieces: Vec<Piece>,
    /// The motion at the current point.
    now: Held,
    /// How long the next step may be.
    step: f64,
    /// The pieces on the last step.
    last: Vec<Piece>,
    /// The pieces of what else is given by pieces.
    known: Option<Known>,
}

/// The pieces of what is given by pieces.
#[derive(Clone, Debug, PartialEq)]
struct Known {
    /// The arguments of what changes its piece with a sign, where they were other than zero last.
    arguments: Vec<f64>,
    /// Between which samples the argument of each table is.
    samples: Vec<usize>,
}

impl Sticking {
    /// Which arguments were zero on the last step.
    pub(super) fn rests_on_last(&self) -> Vec<bool> {
        self.last.iter().map(|piece| *piece == Piece::Between).collect()
    }
}

/// What ends a step.
#[derive(Clone, Copy, Debug)]
enum Event {
    /// The side of an argument reaches its bound, or the argument arrives at zero.
    Side(usize),
    /// What is given by pieces changes its piece.
    Piece,
}

/// The first place between two at which something is true that is true at the second, up to rounding.
fn first([mut low, mut high]: [f64; 2], is_beyond: &dyn Fn(f64) -> bool) -> f64 {
    while high - low > FOUND * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if is_beyond(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// The pieces of what is given by pieces, along a way.
struct Pieces<'a> {
    declaration: Declaration<'a>,
    /// Which arguments are those of sides, and looked at as such.
    of_sides: Vec<bool>,
    /// The time at which the way begins, and its length.
    times: (f64, f64),
    /// Position and velocity at a part of it.
    way: &'a dyn Fn(f64) -> (Vector, Vector),
    /// Those so far.
    known: Known,
}

impl<'a> Pieces<'a> {
    /// Those of a way, from what is known of them before; `None` if nothing is given by pieces.
    fn new(
        declaration: Declaration<'a>,
        known: Option<&Known>,
        times: (f64, f64),
        way: &'a dyn Fn(f64) -> (Vector, Vector),
    ) -> Option<Self> {
        if declaration.switches() == 0 && !declaration.has_tables() {
            return None;
        }
        let mut pieces = Self {
            declaration,
            of_sides: of_sides(&declaration, times.0, way(0.0)),
            times,
            way,
            known: Known {
                arguments: vec![0.0; declaration.switches()],
                samples: Vec::new(),
            },
        };
        if let Some(known) = known {
            pieces.known.clone_from(known);
        } else {
            let now = pieces.at(0.0);
            pieces.take(now);
        }
        Some(pieces)
    }

    /// Those at a part of the way.
    fn at(&self, x: f64) -> Known {
        let (q, v) = (self.way)(x);
        let place = Place::of_phase(self.times.0 + x * self.times.1, q, v);
        let tables = place.tables(&self.declaration);
        let samples = tables.iter().map(|at| {
            let places = at.samples.places();
            places.partition_point(|place| *place <= at.argument)
        });
        Known {
            arguments: place
                .arguments(&self.declaration)
                .into_iter()
                .zip(&self.of_sides)
                .map(|(argument, is_of_side)| if *is_of_side { 0.0 } else { argument })
                .collect(),
            samples: samples.collect(),
        }
    }

    /// Remembers them, and the signs of arguments that are not zero.
    fn take(&mut self, now: Known) {
        for (known, argument) in self.known.arguments.iter_mut().zip(now.arguments) {
            if argument != 0.0 {
                *known = argument;
            }
        }
        self.known.samples = now.samples;
    }

    /// The first change between two parts of the way.
    fn change(&mut self, ends: [f64; 2]) -> Option<f64> {
        let differs = |now: &Known| {
            let mut signs = self.known.arguments.iter().zip(&now.arguments);
            now.samples != self.known.samples || signs.any(|(known, now)| known * now < 0.0)
        };
        let now = self.at(ends[1]);
        if differs(&now) {
            return Some(first(ends, &|x| differs(&self.at(x))));
        }
        self.take(now);
        None
    }
}

/// Which arguments of what is given by pieces are those of sides: at another velocity, where none is zero, they are equal.
fn of_sides(declaration: &Declaration<'_>, t: f64, (q, mut v): (Vector, Vector)) -> Vec<bool> {
    for (i, v) in v.iter_mut().enumerate() {
        *v += (1.0 + v.abs()) * (0.37 + 0.11 * i as f64);
    }
    let sides = declaration.side_arguments(t, &q[..], &v[..]);
    let arguments = Place::of_phase(t, q, v).arguments(declaration);
    let is_one = |argument: f64| {
        let mut sides = sides.iter();
        sides.any(|side| (side - argument).abs() <= SAME * argument.abs())
    };
    arguments.into_iter().map(is_one).collect()
}

/// A polynomial motion from the current point on. The attitude of a body is a polynomial, too, as far as the series of its quaternion goes: it follows from
/// that of the angular velocity by `q' = ½ q∘(0, ω)`.
struct Way {
    /// Its length.
    h: f64,
    /// The coefficients of the acceleration of each coordinate, in parts of the length.
    accelerations: Vec<[f64; COUNT]>,
    /// Those of the quaternions of rotations, each with the first place of the rotation.
    quaternions: Vec<(usize, [[f64; SLOTS]; TURNS])>,
    /// Those of each side.
    sides: Vec<[f64; COUNT]>,
    /// The error, in units of what is allowed.
    error: f64,
    /// The motion at the end.
    end: Held,
}

/// Chebyshev's places from 0 to 1.
fn place(j: usize) -> f64 {
    let angle = core::f64::consts::PI * j as f64 / DEGREE as f64;
    // as a square, which is right to the last digit near both ends
    let half = (0.5 * angle).sin();
    half * half
}

/// The coefficients of the polynomial with values at Chebyshev's places: by powers of the place, and the last two by Chebyshev's polynomials.
fn coefficients(values: &[f64; COUNT]) -> ([f64; COUNT], f64) {
    let mut powers = [0.0; COUNT];
    // Chebyshev's polynomials of 2x - 1 by powers of x, one after the other
    let (mut before, mut polynomial) = ([0.0; COUNT], [0.0; COUNT]);
    polynomial[0] = 1.0;
    let mut tail = 0.0;
    for k in 0..COUNT {
        let end = |j: usize| if j == 0 || j == DEGREE { 0.5 } else { 1.0 };
        let terms = values.iter().enumerate().map(|(j, value)| {
            let turns = (k * (DEGREE - j)) % (2 * DEGREE);
            end(j) * value * (core::f64::consts::PI * turns as f64 / DEGREE as f64).cos()
        });
        let c = end(k) * 2.0 / DEGREE as f64 * terms.sum::<f64>();
        if k + 2 > DEGREE {
            tail += c.abs();
        }
        for (power, p) in powers.iter_mut().zip(&polynomial) {
            *power += c * p;
        }
        let mut next = [0.0; COUNT];
        for i in 0..COUNT {
            let shifted = if i > 0 { polynomial[i - 1] } else { 0.0 };
            next[i] = if k == 0 {
                2.0 * shifted - polynomial[i]
            } else {
                4.0 * shifted - 2.0 * polynomial[i] - before[i]
            };
        }
        (before, polynomial) = (polynomial, next);
    }
    (powers, tail)
}

/// The value of a polynomial.
fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

impl Way {
    /// The coefficients of a velocity in parts of the length.
    fn velocity(&self, i: usize, v: f64) -> [f64; COUNT + 1] {
        let mut velocity = [v; COUNT + 1];
        for (k, (to, a)) in velocity
            .iter_mut()
            .skip(1)
            .zip(&self.accelerations[i])
            .enumerate()
        {
            *to = self.h * a / (k as f64 + 1.0);
        }
        velocity
    }

    /// Follows the attitudes from a position and a velocity.
    fn turn(&mut self, rotations: &[usize], q: &[f64], v: &[f64]) {
        self.quaternions.clear();
        for &first in rotations {
            let spin: [[f64; COUNT + 1]; SLOTS] =
                core::array::from_fn(|k| self.velocity(first + k, v[first + k]));
            let mut quaternion = [[0.0; SLOTS]; TURNS];
            quaternion[0] = core::array::from_fn(|k| q[first + k]);
            for k in 1..TURNS {
                let known = quaternion;
                let scale = self.h / k as f64;
                quaternion[k] =
                    rotation::coefficient(k - 1, scale, |j| known[j], |j| spin.map(|component| component[j]));
            }
            self.quaternions.push((first, quaternion));
        }
    }

    /// What the series of quaternions leave out, as a part of their norm.
    fn truncated(&self) -> f64 {
        let last = self
            .quaternions
            .iter()
            .flat_map(|(_, series)| &series[TURNS - 2..]);
        last.flatten().fold(0.0, |most, c| larger(most, c.abs()))
    }

    /// The quaternion to which a place belongs, as a series, and which of its components it has.
    fn quaternion(&self, i: usize) -> Option<(&[[f64; SLOTS]; TURNS], usize)> {
        let mut all = self.quaternions.iter();
        all.find_map(|(first, series)| {
            let k = i.checked_sub(*first)?;
            (k < SLOTS).then_some((series, k))
        })
    }

    /// How far position and velocity move in a part `x` of the way from the velocity `v`, in one coordinate.
    fn moves(&self, i: usize, v: f64, x: f64) -> [f64; 2] {
        let (mut q, mut dv) = (0.0, 0.0);
        for (k, a) in self.accelerations[i].iter().enumerate().rev() {
            let k = k as f64;
            q = q * x + a / ((k + 1.0) * (k + 2.0));
            dv = dv * x + a / (k + 1.0);
        }
        let s = x * self.h;
        if let Some((series, k)) = self.quaternion(i) {
            let turned = series[1..].iter().rev().fold(0.0, |sum, c| (sum + c[k]) * x);
            return [turned, s * dv];
        }
        [s * (v + s * q), s * dv]
    }

    /// Position and velocity in a part `x` of the way.
    fn at(&self, (q, v): (&[f64], &[f64]), x: f64) -> (Vector, Vector) {
        let moves: Vec<[f64; 2]> = (0..q.len()).map(|i| self.moves(i, v[i], x)).collect();
        (
            Vector::from_fn(q.len(), |i| q[i] + moves[i][0]),
            Vector::from_fn(q.len(), |i| v[i] + moves[i][1]),
        )
    }
}

impl Integrator {
    /// Whether something rests at the current point.
    pub(super) fn rests(&self) -> bool {
        self.watch.as_ref().is_some_and(|watch| watch.sticking.is_some())
    }

    /// What rested on the last step; `None` if nothing did.
    pub(super) fn rested(&self) -> Option<&Sticking> {
        self.watch.as_ref()?.rested.as_deref()
    }

    /// Lets what is at zero rest, if it does, with arguments that are taken to be zero; `false` if nothing is found that rests.
    pub(super) fn rest(&mut self, equations: &dyn SeriesKernel, zero: Option<&[bool]>) -> bool {
        self.rest_at(equations, zero, false)
    }

    /// The same, where a surface may have `jumped`: then nothing is at zero but what is given.
    fn rest_at(&mut self, equations: &dyn SeriesKernel, zero: Option<&[bool]>, jumped: bool) -> bool {
        let declaration = equations.declaration();
        if declaration.sides() == 0 || !self.clock.is_forward() {
            return false;
        }
        let (t, a) = (self.t.hi[0], self.acceleration().to_vec());
        let point = AtPoint::new(declaration, (t, self.now.q(), self.now.v()));
        let arguments = point.arguments();
        let tau = self.time_scale();
        let multipliers = declaration.shape().multipliers();
        let fastest = point.fastest(&a, multipliers);
        // what moves evenly tells no time, and where a surface jumps nothing else arrives
        let arrives =
            |g: usize| arguments[g] == 0.0 || !jumped && arguments[g].abs() <= ARRIVES * tau * fastest[g];
        let zero: Vec<bool> = (0..arguments.len())
            .map(|g| zero.is_some_and(|zero| zero[g]) || arrives(g))
            .collect();
        let Some(found) = point.solve(&zero, multipliers, Some(&a)) else {
            return false;
        };
        if !found.pieces.contains(&Piece::Between) {
            return false;
        }
        let guess = Held {
            x: found.x,
            sides: found.sides,
            ..Held::guess(&a, multipliers, arguments.len())
        };
        let Some(now) = point.held(&found.pieces, &guess) else {
            return false;
        };
        self.now.move_velocity(&now.correction);
        self.next.expect(&now.x[..a.len()]);
        if let Some(watch) = &mut self.watch {
            watch.stuck = None;
            watch.sticking = Some(Box::new(Sticking {
                last: found.pieces.clone(),
                pieces: found.pieces,
                now,
                step: tau,
                known: None,
            }));
        }
        true
    }

    /// A time in which the motion changes.
    fn time_scale(&self) -> f64 {
        let order = self.order().min(self.next.order());
        let step = self.control.first_step(&self.next, order);
        match self.last {
            _ if step > 0.0 && step < 1e100 => step,
            Some((_, h)) if h != 0.0 => h.abs(),
            _ => 1.0,
        }
    }

    /// The motion on a way of the length `h`; `None` where it is not found.
    fn way(&self, equations: &dyn SeriesKernel, sticking: &Sticking, h: f64) -> Option<Way> {
        let (declaration, t) = (equations.declaration(), self.t.hi[0]);
        let (q, v) = (self.now.q(), self.now.v());
        let n = q.len();
        let mut way = Way {
            h,
            accelerations: (0..n)
                .map(|i| {
                    let mut constant = [0.0; COUNT];
                    constant[0] = sticking.now.x[i];
                    constant
                })
                .collect(),
            quaternions: Vec::new(),
            sides: vec![[0.0; COUNT]; sticking.pieces.len()],
            error: f64::INFINITY,
            end: sticking.now.clone(),
        };
        let rotations = &declaration.shape().rotations;
        way.turn(rotations, q, v);
        let mut values = vec![[0.0; COUNT]; n];
        let mut sides = way.sides.clone();
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let mut change = 0.0_f64;
            let mut held = sticking.now.clone();
            for j in 0..COUNT {
                let x = place(j);
                let (q, v) = way.at((q, v), x);
                let t = match j {
                    0 => self.side(t, true),
                    DEGREE => self.side(t + h, false),
                    _ => t + x * h,
                };
                let point = AtPoint::new(declaration, (t, &q[..], &v[..]));
                held = point.held(&sticking.pieces, &held)?;
                for (i, values) in values.iter_mut().enumerate() {
                    let rounding = f64::EPSILON * (held.reach[i] + held.x[i].abs());
                    let by = (held.x[i] - values[j]).abs() / rounding.max(f64::MIN_POSITIVE);
                    change = larger(change, by);
                    values[j] = held.x[i];
                }
                for (sides, side) in sides.iter_mut().zip(&held.sides) {
                    sides[j] = *side;
                }
            }
            let mut tails = vec![0.0; n];
            for ((tail, accelerations), values) in tails.iter_mut().zip(&mut way.accelerations).zip(&values) {
                (*accelerations, *tail) = coefficients(values);
            }
            way.turn(rotations, q, v);
            if change <= ROUNDINGS || (change >= 0.5 * last && change <= MOST_ROUNDINGS) {
                // a jump of what holds shows in its side alone
                let mut unsteady = 0.0_f64;
                for (coefficient, values) in way.sides.iter_mut().zip(&sides) {
                    let tail;
                    (*coefficient, tail) = coefficients(values);
                    unsteady = larger(unsteady, tail);
                }
                for (i, tail) in tails.iter_mut().enumerate() {
                    let rounding = ROUNDINGS * f64::EPSILON * (held.reach[i] + held.x[i].abs());
                    *tail = (*tail - rounding).max(0.0);
                }
                let error = self.control.excess(v, &held.x[..n], &tails, h);
                let error = larger(error, unsteady / self.control.relative().max(LEAST_TAIL));
                way.error = larger(error, way.truncated() / self.control.relative().max(f64::EPSILON));
                way.end = held;
                return Some(way);
            }
            if change.is_nan() {
                return None;
            }
            last = change;
        }
        None
    }

    /// The first event on a way, as a part of it.
    fn first_event(
        &self,
        equations: &dyn SeriesKernel,
        sticking: &mut Sticking,
        way: &Way,
    ) -> Option<(f64, Event)> {
        let (declaration, t) = (equations.declaration(), self.t.hi[0]);
        let (q, v) = (self.now.q(), self.now.v());
        let reach = way.end.reach.iter().take(q.len());
        let rounding = BESIDE * way.h * reach.fold(0.0_f64, |most, reach| most.max(*reach));
        // how far each argument is from its event; negative beyond
        let margins = |x: f64| -> Vec<f64> {
            let (q, v) = way.at((q, v), x);
            let at = (t + x * way.h, &q[..], &v[..]);
            let arguments = declaration.side_arguments(at.0, at.1, at.2);
            let both = sticking.pieces.iter().zip(arguments).zip(&way.sides);
            let mut margins: Vec<f64> = both
                .map(|((piece, argument), side)| match piece {
                    Piece::Between => 1.0 - value(side, x).abs(),
                    // what others hold at zero is there to rounding
                    piece => piece.side() * argument + rounding,
                })
                .collect();
            // the polynomials of the sides are known to the tolerance, and what is torn off goes on from where they are at their bounds
            let near = |g: usize| sticking.pieces[g] == Piece::Between && margins[g] < NEAR;
            let near: Vec<usize> = (0..margins.len()).filter(|&g| near(g)).collect();
            if !near.is_empty()
                && let Some(held) = AtPoint::new(declaration, at).held(&sticking.pieces, &way.end)
            {
                for g in near {
                    margins[g] = 1.0 - held.sides[g].abs();
                }
            }
            margins
        };
        let places = |x: f64| way.at((q, v), x);
        let mut pieces = Pieces::new(declaration, sticking.known.as_ref(), (t, way.h), &places);
        let mut before = margins(0.0);
        let mut from = 0.0;
        for part in 1..=PARTS {
            let to = f64::from(part) / f64::from(PARTS);
            let after = margins(to);
            let piece = pieces.as_mut().and_then(|pieces| pieces.change([from, to]));
            let beyond: Vec<usize> = (0..after.len())
                .filter(|&g| after[g] < 0.0 && (before[g] >= 0.0 || sticking.pieces[g] == Piece::Between))
                .collect();
            let event = beyond
                .into_iter()
                .map(|g| (first([from, to], &|x| margins(x)[g] < 0.0), Event::Side(g)));
            let event = event.chain(piece.map(|place| (place, Event::Piece)));
            if let Some(event) = event.min_by(|one, other| one.0.total_cmp(&other.0)) {
                return Some(event);
            }
            (before, from) = (after, to);
        }
        sticking.known = pieces.map(|pieces| pieces.known);
        None
    }

    /// Makes one step in which something rests.
    #[cold]
    pub(super) fn step_at_rest(
        &mut self,
        equations: &mut dyn SeriesKernel,
        (until, left): (f64, f64),
        smallest: f64,
    ) -> Outcome {
        let Some(mut sticking) = self.watch.as_mut().and_then(|watch| watch.sticking.take()) else {
            return Outcome::NotFinite;
        };
        // where all but nothing moves at first, the series' own steps may be as good as none
        let mut size = sticking.step.max(smallest).min(left);
        let way = loop {
            match self.way(equations, &sticking, size) {
                Some(way) if way.error <= 1.0 || size <= smallest => break way,
                _ if size <= smallest => return Outcome::TooSmall(size),
                Some(way) => {
                    let part = CAUTION * way.error.powf(-1.0 / DEGREE as f64);
                    size = (size * part.clamp(CHANGES[0], 0.9)).max(smallest);
                }
                None => size = (size * CHANGES[0]).max(smallest),
            }
            self.rejected += 1;
        };
        let longer = CAUTION * way.error.max(1e-30).powf(-1.0 / DEGREE as f64);
        sticking.step = size * longer.clamp(CHANGES[0], CHANGES[1]);
        let event = self.first_event(equations, &mut sticking, &way);
        let part = event.map_or(1.0, |(part, _)| part);
        let whole = size == left && event.is_none();
        self.take(equations, &way, part);
        if whole {
            self.t = Compensated::exact([until]);
        } else {
            self.t.add(&[part * size]);
        }
        let mut short = 0;
        if let Some(watch) = &mut self.watch {
            watch.short = if part * size <= smallest {
                watch.short + 1
            } else {
                0
            };
            short = watch.short;
        }
        sticking.last.clone_from(&sticking.pieces);
        let (t, q, v) = (self.t.hi[0], self.now.q(), self.now.v());
        let point = AtPoint::new(equations.declaration(), (t, q, v));
        let (mut arrived, mut changes) = (None, false);
        match event {
            Some((_, Event::Side(g))) if sticking.pieces[g] == Piece::Between => {
                // torn off: all is as it was but for this side
                sticking.pieces[g] = Piece::of(value(&way.sides[g], part));
            }
            Some((_, Event::Side(g))) => arrived = Some(g),
            // a surface may have another velocity at once
            Some((_, Event::Piece)) => changes = true,
            None => {}
        }
        let rests = sticking.pieces.contains(&Piece::Between);
        // what rests is at zero, or its surface has another velocity at once
        let multipliers = equations.declaration().shape().multipliers();
        let fastest = point.fastest(&way.end.x[..self.next.dimension()], multipliers);
        let span = sticking.step.max(size);
        // what the tolerance leaves of it
        let fastest_part = v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let left = LEFT * self.control.relative() * fastest_part;
        let still: Vec<bool> = sides::zero(&equations.declaration(), t, q, v)
            .into_iter()
            .zip(point.arguments().iter().zip(&fastest))
            .zip(&sticking.pieces)
            .map(|((is_zero, (argument, fastest)), piece)| {
                *piece == Piece::Between && (is_zero || argument.abs() <= left.max(ARRIVES * span * fastest))
            })
            .collect();
        let mut rest = sticking.pieces.iter().zip(&still);
        let changes = changes || rest.any(|(piece, still)| *piece == Piece::Between && !still);
        let zero: Vec<bool> = (0..sticking.pieces.len())
            .map(|g| sticking.pieces[g] == Piece::Between || arrived == Some(g))
            .collect();
        let goes_on = rests && arrived.is_none() && !changes && short <= AT_ONCE;
        let held = goes_on.then(|| point.held(&sticking.pieces, &way.end)).flatten();
        let last = sticking.clone();
        if let Some(held) = held {
            self.now.move_velocity(&held.correction);
            self.next.expect(&held.x[..self.next.dimension()]);
            sticking.now = held;
            if let Some(watch) = &mut self.watch {
                watch.sticking = Some(sticking);
            }
        } else if short > AT_ONCE
            || (arrived.is_none() && !changes)
            || !self.rest_at(equations, Some(if changes { &still } else { &zero }), changes)
        {
            self.begin_after_rest(equations);
        }
        if let Some(watch) = &mut self.watch {
            watch.rested = Some(last);
        }
        Outcome::Good
    }

    /// Goes a part of a way, which becomes the last step.
    fn take(&mut self, equations: &mut dyn SeriesKernel, way: &Way, part: f64) {
        let (t, h, n) = (self.t.hi[0], part * way.h, self.next.dimension());
        let (q, v) = (self.now.q().to_vec(), self.now.v().to_vec());
        self.series.set_order(COUNT);
        self.series.begin(t, &q, &v);
        for i in 0..n {
            let mut position = vec![q[i], v[i]];
            let mut unit = 1.0;
            for (k, a) in way.accelerations[i].iter().enumerate() {
                let k = k as f64;
                position.push(a * unit / ((k + 1.0) * (k + 2.0)));
                unit /= way.h;
            }
            let Some((quaternion, component)) = way.quaternion(i) else {
                self.series.fill(i, &position);
                continue;
            };
            let (mut turned, mut spin, mut unit) = (Vec::new(), Vec::new(), 1.0);
            for (q, w) in quaternion
                .iter()
                .zip(way.velocity(i, v[i]).into_iter().chain([0.0]))
            {
                turned.push(q[component] * unit);
                spin.push(w * unit);
                unit /= way.h;
            }
            self.series.fill(i, &turned);
            self.series.fill_velocity(i, &spin);
        }
        for i in 0..n {
            let [dq, dv] = way.moves(i, v[i], part);
            let mut moves = [vec![0.0; n], vec![0.0; n]];
            (moves[0][i], moves[1][i]) = (dq, dv);
            self.now.move_position(&moves[0]);
            self.now.move_velocity(&moves[1]);
        }
        let rotations = &equations.declaration().shape().rotations;
        rotation::keep_norm(rotations, self.now.parts().q);
        self.last = Some((self.t, h));
        if let Some(projection) = &mut self.projection {
            projection.apply(equations, t + h, &mut self.now);
        }
        let a: Vec<f64> = way.accelerations.iter().map(|a| value(a, part)).collect();
        self.next.begin(t + h, self.now.q(), self.now.v());
        self.next.expect(&a);
        self.known = None;
        self.is_new = true;
    }

    /// The recurrences go on where nothing rests any more.
    fn begin_after_rest(&mut self, equations: &mut dyn SeriesKernel) {
        if let Some(watch) = &mut self.watch {
            watch.sticking = None;
            watch.leaves = true;
        }
        self.begin(equations);
        if let Some(watch) = &mut self.watch {
            watch.leaves = false;
        }
    }

    /// The constraint force at a node of the last step in which something rested.
    pub(super) fn force_at_rest(
        &self,
        equations: &dyn SeriesKernel,
        point: AnyPoint<'_, f64>,
    ) -> Option<Vec<f64>> {
        let sticking = self.rested()?;
        let declaration = equations.declaration();
        let at = AtPoint::new(declaration, (point.t, point.q, point.v));
        let held = at.held(&sticking.last, &sticking.now)?;
        Some(declaration.sided_continuous_force(point, &held.sides))
    }

    /// Forgets that something rests.
    pub(super) fn forget_rest(&mut self) {
        if let Some(watch) = &mut self.watch {
            (watch.sticking, watch.rested) = (None, None);
        }
    }
}
