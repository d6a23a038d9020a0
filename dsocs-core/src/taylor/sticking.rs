//! Steps in which a body rests on a surface, as by dry friction.
//!
//! There the force of a function that jumps with the velocity is not that of either side but the one that
//! keeps its argument at zero. The recurrences use one side or the other. As long as the same arguments stay
//! zero, the acceleration is a smooth function of time, position and velocity ([`AtPoint::held`]), and the
//! motion is approximated by a polynomial: its acceleration agrees with this function at the Chebyshev points
//! of the step, found by Picard iteration (C. W. Clenshaw, H. J. Norton, *Comput. J.* 6, 1963; X. Bai, J. L.
//! Junkins, *J. Astronaut. Sci.* 58, 2011). The polynomial's last coefficients give the error.
//!
//! The step ends where a side reaches its bound, and the body is released, where another argument arrives at
//! zero, or where a piecewise function changes its piece. Then the inclusion of [`AtPoint::solve`] determines
//! which arguments rest from there on. If none does, the recurrences continue.

use super::held_path::{COUNT, DEGREE, HeldPath, coefficients, place};
use super::integrator::{Integrator, Outcome};
use super::pieces::{Known, Pieces, first};
use super::recurrences::SeriesKernel;
use super::watch::AT_ONCE;
use crate::number::compensated::Compensated;
use crate::number::larger;
use crate::number::point::AnyPoint;
use crate::regularity::resting::{AtPoint, Held};
use crate::regularity::sides::{Piece, resting};
use crate::regularity::sticking as sides;
use crate::series::roots::value;
use crate::solve::rotation;

/// Largest number of iterations.
const ITERATIONS: u32 = 40;

/// An acceleration is accurate to this many roundings of the contribution of the sides.
const ROUNDINGS: f64 = 16.0;

/// If the iteration does not converge to that, up to this many roundings are accepted.
const MOST_ROUNDINGS: f64 = 1e4;

/// Least and largest ratio of the next step to the last, and the safety factor.
const CHANGES: [f64; 2] = [0.1, 4.0];
const CAUTION: f64 = 0.8;

/// Number of equal parts of a step in which events are searched.
const PARTS: u32 = 64;

/// Last coefficients of the sides' polynomials below this may be rounding.
const LEAST_TAIL: f64 = 1e-9;

/// A side closer to its bound than this is computed exactly instead of by its polynomial.
const NEAR: f64 = 0.05;

/// An argument is beyond zero if it exceeds this part of the sides' largest effect on it in the step.
const BESIDE: f64 = 1e-13;

/// Largest deviation of a resting argument from zero at the end of a step, in tolerances of the velocity.
const LEFT: f64 = 10.0;

/// A velocity is corrected by no more than the body moves, and this part, or that of the tolerance, of what the acceleration makes of it.
const UNKNOWN: f64 = 1e-6;

/// An argument that will be zero within this part of the motion's time scale counts as zero.
const ARRIVES: f64 = 1e-9;

/// The place of an argument's zero is known to this many roundings of the time.
const ROUNDINGS_OF_TIME: f64 = 4.0;

/// The arguments that rest, and the sides of those that slide.
#[derive(Clone, Debug)]
pub(super) struct Sticking {
    /// The piece of each argument; those between rest.
    pieces: Vec<Piece>,
    /// The motion at the current point.
    now: Held,
    /// The proposed length of the next step.
    step: f64,
    /// The pieces on the last step.
    last: Vec<Piece>,
    /// Whether each argument was zero on the last step.
    rested: Vec<bool>,
    /// The pieces of all other piecewise functions.
    known: Option<Known>,
}

impl Sticking {
    /// Whether each argument was zero on the last step.
    pub(super) fn rests_on_last(&self) -> &[bool] {
        &self.rested
    }
}

/// The event that ends a step.
#[derive(Clone, Copy, Debug)]
enum Event {
    /// The side of an argument reaches its bound, or the argument arrives at zero.
    Side(usize),
    /// A piecewise function changes its piece.
    Piece,
}

impl Integrator {
    /// Whether a body rests at the current point.
    pub(super) fn rests(&self) -> bool {
        self.watch.as_ref().is_some_and(|watch| watch.sticking.is_some())
    }

    /// The resting state of the last step; `None` if nothing rested.
    pub(super) fn rested(&self) -> Option<&Sticking> {
        self.watch.as_ref()?.rested.as_deref()
    }

    /// Sets arguments that are zero to rest, if they do, including those of `zero`; `false` if no resting
    /// motion is found.
    pub(super) fn rest(&mut self, equations: &dyn SeriesKernel, zero: Option<&[bool]>) -> bool {
        self.rest_at(equations, zero, false)
    }

    /// [`Integrator::rest`]; if a surface may have `jumped`, only the given arguments are zero.
    fn rest_at(&mut self, equations: &dyn SeriesKernel, zero: Option<&[bool]>, jumped: bool) -> bool {
        let declaration = equations.declaration();
        if declaration.sides() == 0 || !self.clock.is_forward() {
            return false;
        }
        let (t, a) = (self.t.hi[0], self.acceleration().to_vec());
        let point = AtPoint::new(declaration, (t, self.now.q(), self.now.v()));
        let tau = self.time_scale();
        let multipliers = declaration.shape().multipliers();
        let time = if jumped { 0.0 } else { self.arrival(tau) };
        let mut zero = arrived(&point, (&a, multipliers), time, zero);
        if !jumped {
            // a short way to the zero is known no better than the velocity
            let to_rounding = sides::zero(&declaration, t, self.now.q(), self.now.v());
            zero.iter_mut()
                .zip(to_rounding)
                .for_each(|(zero, rounded)| *zero |= rounded);
        }
        let Some(found) = point.solve(&zero, multipliers, Some(&a)) else {
            return false;
        };
        if !found.pieces.contains(&Piece::Between) {
            return false;
        }
        let guess = Held {
            x: found.x,
            sides: found.sides,
            ..Held::guess(&a, multipliers, declaration.sides())
        };
        let Some(now) = point.held(&found.pieces, &guess).filter(|held| !held.leaves) else {
            return false;
        };
        // an argument whose rate by the velocity vanishes, too, holds nothing
        let largest = |x: &[f64]| x.iter().fold(0.0, |most, x| larger(most, x.abs()));
        let known_to = larger(LEFT * self.control.relative(), UNKNOWN);
        if largest(&now.correction) > 2.0 * largest(self.now.v()) + known_to * tau.abs() * largest(&a) {
            return false;
        }
        let forks = point.forks(&zero, multipliers, tau);
        // the last step may have been short only because the slip was small
        let step = self.scale_of_series().unwrap_or(f64::INFINITY);
        self.now.move_velocity(&now.correction);
        self.next.expect(&now.x[..a.len()]);
        if let Some(watch) = &mut self.watch {
            watch.stuck = None;
            watch.forks = forks;
            watch.sticking = Some(Box::new(Sticking {
                last: found.pieces.clone(),
                rested: resting(&found.pieces),
                pieces: found.pieces,
                now,
                step,
                known: None,
            }));
        }
        true
    }

    /// Tests whether the motion is unique where some arguments are zero: to rounding, or where it has `arrived`
    /// at their zeros, within a part of the time `tau`.
    #[cold]
    pub(super) fn look_for_forks(&mut self, equations: &dyn SeriesKernel, tau: Option<f64>) {
        let declaration = equations.declaration();
        if declaration.sides() == 0 || !self.clock.is_forward() {
            return;
        }
        let (t, q, v) = (self.t.hi[0], self.now.q(), self.now.v());
        let point = AtPoint::new(declaration, (t, q, v));
        let multipliers = declaration.shape().multipliers();
        let mut zero = sides::zero(&declaration, t, q, v);
        if let Some(tau) = tau {
            zero = arrived(
                &point,
                (self.acceleration(), multipliers),
                self.arrival(tau),
                Some(&zero),
            );
        }
        let forks = zero.contains(&true) && point.forks(&zero, multipliers, self.time_scale());
        if let Some(watch) = &mut self.watch {
            watch.forks = forks;
        }
    }

    /// An argument that will be zero within this time counts as zero, for a motion with the time scale `tau`:
    /// late times are known no better than to their rounding, and arguments of moving surfaces with them. No step is shorter than the
    /// smallest: at the end of a run to a node of inputs a velocity may be a rounding of zero that no step takes away.
    fn arrival(&self, tau: f64) -> f64 {
        ARRIVES * tau.abs() + ROUNDINGS_OF_TIME * self.rounding_of_time() + self.smallest_step(self.time())
    }

    /// The time scale that the series tells; `None` if the motion is uniform, or uniformly accelerated.
    pub(super) fn scale_of_series(&self) -> Option<f64> {
        let order = self.order().min(self.next.order());
        let step = self.control.first_step(&self.next, order);
        (step > 0.0 && step < 1e100).then_some(step)
    }

    /// A time scale of the motion.
    fn time_scale(&self) -> f64 {
        let last = self.last.map(|(_, h)| h.abs()).filter(|h| *h != 0.0);
        self.scale_of_series().or(last).unwrap_or(1.0)
    }

    /// The motion over a time `h` at rest; `None` if the iteration does not converge.
    fn way(&self, equations: &dyn SeriesKernel, sticking: &Sticking, h: f64) -> Option<HeldPath> {
        let (declaration, t) = (equations.declaration(), self.t.hi[0]);
        let (q, v) = (self.now.q(), self.now.v());
        let n = q.len();
        let mut way = HeldPath {
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
                // a value at a place is that of the rounded time there
                let late = |values: &[f64; COUNT]| {
                    let moves = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
                    self.rounding_of_time() / h * moves.sum::<f64>()
                };
                // a jump of a resting body's law shows in its side alone
                let mut tails_of_sides = Vec::with_capacity(sides.len());
                for (coefficient, values) in way.sides.iter_mut().zip(&sides) {
                    let tail;
                    (*coefficient, tail) = coefficients(values);
                    tails_of_sides.push(tail - tail.min(late(values)));
                }
                let known_to = self.control.relative().max(LEAST_TAIL);
                // noise does not become smaller with the step: what would shorten the next one must be more
                let shortens = known_to * CAUTION.powf(DEGREE as f64);
                if tails_of_sides.iter().any(|tail| *tail > shortens) {
                    let noise = self.noise_of_sides(equations, sticking, &way);
                    for (tail, noise) in tails_of_sides.iter_mut().zip(noise) {
                        *tail -= tail.min(COUNT as f64 * noise);
                    }
                }
                let unsteady = tails_of_sides.into_iter().fold(0.0, larger);
                for (i, tail) in tails.iter_mut().enumerate() {
                    let rounding = ROUNDINGS * f64::EPSILON * (held.reach[i] + held.x[i].abs());
                    *tail = (*tail - rounding - late(&values[i])).max(0.0);
                }
                let error = self.control.excess(v, &held.x[..n], &tails, h);
                let error = larger(error, unsteady / known_to);
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

    /// The changes of the sides by one rounding of time, positions and velocities, at the ends of a path: of a force that is the difference of large
    /// ones, or at late times, a side is known no better.
    #[cold]
    fn noise_of_sides(&self, equations: &dyn SeriesKernel, sticking: &Sticking, way: &HeldPath) -> Vec<f64> {
        let declaration = equations.declaration();
        let mut noise = vec![0.0_f64; sticking.pieces.len()];
        for x in [0.0, 1.0] {
            let (t, (q, v)) = (self.t.hi[0] + x * way.h, way.at((self.now.q(), self.now.v()), x));
            let sides = |t: f64, q: &[f64], v: &[f64]| {
                let held = AtPoint::new(declaration, (t, q, v)).held(&sticking.pieces, &way.end);
                held.map(|held| held.sides)
            };
            let Some(own) = sides(t, &q, &v) else {
                continue;
            };
            let mut sum = vec![0.0; noise.len()];
            let mut add = |beside: Option<Vec<f64>>| {
                let both = beside.iter().flatten().zip(&own);
                for (sum, (beside, own)) in sum.iter_mut().zip(both) {
                    *sum += (beside - own).abs();
                }
            };
            add(sides(t + self.rounding_of_time(), &q, &v));
            let rounded = |x: &[f64], i: usize| {
                let mut rounded = x.to_vec();
                rounded[i] *= 1.0 + f64::EPSILON;
                rounded
            };
            for i in 0..q.len() {
                add(sides(t, &rounded(&q, i), &v));
                add(sides(t, &q, &rounded(&v, i)));
            }
            for (noise, sum) in noise.iter_mut().zip(sum) {
                *noise = noise.max(sum);
            }
        }
        noise
    }

    /// The first event on a path, as a part of it.
    fn first_event(
        &self,
        equations: &dyn SeriesKernel,
        sticking: &mut Sticking,
        way: &HeldPath,
    ) -> Option<(f64, Event)> {
        let (declaration, t) = (equations.declaration(), self.t.hi[0]);
        let (q, v) = (self.now.q(), self.now.v());
        let reach = way.end.reach.iter().take(q.len());
        let rounding = BESIDE * way.h * reach.fold(0.0_f64, |most, reach| most.max(*reach));
        // the distance of each argument from its event; negative beyond
        let margins = |x: f64| -> Vec<f64> {
            let (q, v) = way.at((q, v), x);
            let at = (t + x * way.h, &q[..], &v[..]);
            let arguments = declaration.side_arguments(at.0, at.1, at.2);
            let both = sticking.pieces.iter().zip(arguments).zip(&way.sides);
            let mut margins: Vec<f64> = both
                .map(|((piece, argument), side)| match piece {
                    Piece::Between => 1.0 - value(side, x).abs(),
                    // an argument that others hold at zero is so to rounding
                    piece => piece.side() * argument + rounding,
                })
                .collect();
            // the polynomials of the sides are accurate to the tolerance, but a release needs the exact place
            // where they reach their bounds
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
            let rounding = 2.0 * self.rounding_of_time() / way.h;
            let piece = pieces
                .as_mut()
                .and_then(|pieces| pieces.change([from, to], rounding));
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

    /// The first part of a path, up to a given one, behind which a resting body may go to either side.
    fn first_fork(
        &self,
        equations: &dyn SeriesKernel,
        sticking: &Sticking,
        way: &HeldPath,
        until: f64,
    ) -> Option<f64> {
        let declaration = equations.declaration();
        let multipliers = declaration.shape().multipliers();
        let zero = resting(&sticking.pieces);
        let (t, q, v) = (self.t.hi[0], self.now.q(), self.now.v());
        let forks = |x: f64| {
            let (q, v) = way.at((q, v), x);
            let point = AtPoint::new(declaration, (t + x * way.h, &q, &v));
            point.forks(&zero, multipliers, way.h)
        };
        forks(until).then(|| first([0.0, until], &forks))
    }

    /// The length of a step that ends at a representable time. A release before its time would not be one: the side would hold the body again.
    fn ended(&self, (length, left): (f64, f64), is_release: bool) -> f64 {
        let later = length + self.rounding_of_time();
        self.representable(if is_release && later < left { later } else { length })
    }

    /// Makes one step with a body at rest.
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
        // if everything else hardly moves at first, the series' own steps may be too short to be useful
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
        let fork = self.first_fork(equations, &sticking, &way, part);
        let whole = size == left && event.is_none() && fork.is_none();
        let (event, mut part) = fork.map_or((event, part), |part| (None, part));
        if !whole {
            let is_release =
                matches!(event, Some((_, Event::Side(g))) if sticking.pieces[g] == Piece::Between);
            part = self.ended((part * size, left), is_release) / size;
        }
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
        sticking.rested = resting(&sticking.last);
        let (t, q, v) = (self.t.hi[0], self.now.q(), self.now.v());
        let point = AtPoint::new(equations.declaration(), (t, q, v));
        let (mut arrived, mut changes) = (None, false);
        match event {
            Some((_, Event::Side(g))) if sticking.pieces[g] == Piece::Between => {
                // released: everything is unchanged except this side
                sticking.pieces[g] = Piece::of(value(&way.sides[g], part));
            }
            Some((_, Event::Side(g))) => arrived = Some(g),
            // the velocity of a surface may jump
            Some((_, Event::Piece)) => changes = true,
            None => {}
        }
        let rests = sticking.pieces.contains(&Piece::Between);
        // a resting argument is zero, unless the velocity of its surface has jumped
        let multipliers = equations.declaration().shape().multipliers();
        let fastest = point.fastest(&way.end.x[..self.next.dimension()], multipliers);
        let span = sticking.step.max(size);
        // the deviation that the tolerance allows
        let fastest_part = v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let left = LEFT * self.control.relative() * fastest_part;
        let still: Vec<bool> = sides::zero(&equations.declaration(), t, q, v)
            .into_iter()
            .zip(point.arguments().iter().zip(&fastest))
            .zip(&sticking.pieces)
            .map(|((is_zero, (argument, fastest)), piece)| {
                *piece == Piece::Between
                    && (is_zero || argument.abs() <= left.max(self.arrival(span) * fastest))
            })
            .collect();
        let mut rest = sticking.pieces.iter().zip(&still);
        let changes = changes || rest.any(|(piece, still)| *piece == Piece::Between && !still);
        let zero: Vec<bool> = (0..sticking.pieces.len())
            .map(|g| sticking.pieces[g] == Piece::Between || arrived == Some(g))
            .collect();
        let goes_on = rests && arrived.is_none() && !changes && short <= AT_ONCE;
        let held = goes_on.then(|| point.held(&sticking.pieces, &way.end)).flatten();
        let held = held.filter(|held| !held.leaves);
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
            watch.forks |= fork.is_some();
        }
        Outcome::Good
    }

    /// Commits a part of a path, which becomes the last step.
    fn take(&mut self, equations: &mut dyn SeriesKernel, way: &HeldPath, part: f64) {
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
        self.keep(h, true);
        if let Some(projection) = &mut self.projection {
            projection.apply(equations, t + h, &mut self.now);
        }
        let a: Vec<f64> = way.accelerations.iter().map(|a| value(a, part)).collect();
        self.next.begin(t + h, self.now.q(), self.now.v());
        self.next.expect(&a);
        self.known = None;
        self.is_new = true;
    }

    /// Continues with the recurrences where nothing rests any more.
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

    /// The constraint force at a node of the last step with a body at rest.
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

    /// Forgets the resting state.
    pub(super) fn forget_rest(&mut self) {
        if let Some(watch) = &mut self.watch {
            (watch.sticking, watch.rested) = (None, None);
        }
    }
}

/// The arguments that are zero: the given ones, and those that arrive there within the `time`, with the given
/// acceleration.
fn arrived(
    point: &AtPoint<'_>,
    (a, multipliers): (&[f64], usize),
    time: f64,
    zero: Option<&[bool]>,
) -> Vec<bool> {
    let fastest = point.fastest(a, multipliers);
    let arguments = point.arguments().into_iter().zip(fastest).enumerate();
    arguments
        .map(|(g, (argument, fastest))| zero.is_some_and(|zero| zero[g]) || argument.abs() <= time * fastest)
        .collect()
}
