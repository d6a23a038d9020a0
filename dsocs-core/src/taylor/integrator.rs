//! The continuous motion, step by step, whatever the system's type.

use core::fmt;
use std::borrow::Cow;

use super::control::{Control, Judged, Sizes, Tolerance, exp2};
use super::order::Order;
use super::projection::{Projection, size};
use super::recurrences::SeriesKernel;
use super::singular::Past;
use super::state::State;
use super::sticking::Sticking;
use super::trial::Trial;
use super::watch::{self, End, Watch};
use super::weights::Weights;
use crate::error::SetupError;
use crate::error::series::{FailedSeries, Jump, SeriesError, SeriesFailure};
use crate::kernel::clock::Clock;
use crate::kernel::report::{Guess, NodeMut, NodeScalars, StepReport};
use crate::number::compensated::Compensated;
use crate::number::larger;
use crate::number::point::{AnyPoint, copy};
use crate::regularity::deficiency::{self, DependentRow};
use crate::regularity::undefined;
use crate::run::{AnyPolynomial, RunError, Search};
use crate::series::rows::Series;
use crate::solve::Vector;
use crate::solve::newton::Stop;
use crate::solve::rotation;
use crate::start::Phase;
use crate::start::place::Place;
use crate::step::singular;
use crate::tape::declaration::Declaration;

/// How many steps a motion may take unless [`super::TaylorFlow::max_steps`] says otherwise.
pub(super) const MAX_STEPS: u64 = 10_000_000;

/// After so many steps each it is asked whether the motion gets on.
const LOOK_EVERY: u64 = 1024;

/// It does not where so many steps lead no further than this part of the way so far.
const STALLED: f64 = 1e-9;

/// A velocity that the constraints move at a switch by more than so many times the tolerance jumps there.
const JUMPS: f64 = 100.0;

/// And by more than this part of it.
const LEAST_JUMP: f64 = 1e-7;

/// How far beside a switch the Lagrangian is compared, as a part of a step, and by which part of its terms it jumps.
const BESIDE: [f64; 2] = [1e-8, 1e-5];

/// So much farther away, what jumps is not much larger: by no more than this part of it, the other way round.
const FARTHER: f64 = 10.0;
const JUMPS_NEAR: f64 = 0.5;

/// A time that is never reached. Terms of a series stay finite there, so that changes of sign are found on the way.
const FAR: f64 = 1e100;

/// Where velocities have weights, they are looked at again if one becomes so many times the largest.
const GROWS: f64 = 2.0;

/// Where a motion is, and how it goes on. What needs the system is given it.
pub(crate) struct Integrator {
    /// The series of the last step.
    pub(super) series: Box<Series>,
    /// The series at the current point; both change places with every step.
    pub(super) next: Box<Series>,
    /// What the control asks of the series at the current point, where the step there told it.
    pub(super) known: Option<Sizes>,
    /// The control of the steps.
    pub(super) control: Control,
    /// How large velocities are.
    pub(super) weights: Weights,
    /// The choice of the order.
    pub(super) order: Order,
    /// The time where the last step began, and its length.
    pub(super) last: Option<(Compensated<1>, f64)>,
    /// The current time.
    pub(super) t: Compensated<1>,
    /// The current position and velocity.
    pub(super) now: State,
    /// Those at the end of a step that is tried.
    pub(super) tried: State,
    /// The number of steps so far.
    pub(super) steps: u64,
    /// The number of steps that were not good.
    pub(super) rejected: u64,
    /// How many steps are allowed.
    pub(super) max_steps: u64,
    /// The smallest step.
    pub(super) smallest: f64,
    /// Which node is the current one.
    pub(super) clock: Clock,
    /// Times at which steps end, in ascending order: those where the motion has no series.
    pub(super) knots: Vec<f64>,
    /// What brings it back onto constraints of lower order.
    pub(super) projection: Option<Projection>,
    /// What a system with switches needs.
    pub(super) watch: Option<Box<Watch>>,
    /// What makes the velocity jump at the current point, and at which switch.
    pub(super) jump: Option<(Option<Cow<'static, str>>, Jump)>,
    /// Whether the motion begins anew at the current point, so that the last step says nothing of the next.
    pub(super) is_new: bool,
    /// The time where the motion began.
    began: f64,
    /// How many steps there were when it was last asked whether the motion gets on, and the time then.
    looked: (u64, f64),
    /// How often the motion was expanded on the way to it.
    pub(super) expansions: u32,
    /// Position, velocity and acceleration at the current node, where nodes lie on a grid.
    pub(super) on_grid: Option<State>,
    /// The time up to which the motion has been shown; see [`crate::Stepper::trace`].
    pub(super) shown: f64,
    /// How it arrived where inputs changed last.
    pub(super) arrived: Option<Box<Arrived>>,
}

/// How a motion arrives where inputs change. Several changes at one place are one: a velocity jumps from the values before all of them.
#[derive(Clone)]
pub(super) struct Arrived {
    /// The number of steps to there, and the time.
    pub(super) place: (u64, f64),
    /// The values of the parameters before.
    pub(super) values: Vec<f64>,
    /// Position and velocity.
    pub(super) now: State,
}

impl fmt::Debug for Integrator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TaylorFlow")
            .field("time", &self.time())
            .field("position", &self.now.q())
            .field("velocity", &self.now.v())
            .field("order", &self.order())
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

impl Integrator {
    /// A motion from a time, a position and a velocity, with an acceleration near the one that is expected.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the system has no Taylor series there.
    pub(super) fn new(
        equations: &mut dyn SeriesKernel,
        phase: &Phase,
        tolerance: &Tolerance,
    ) -> Result<Self, SetupError> {
        let (t0, q0, v0) = (phase.t0, &phase.q0[..], &phase.v0[..]);
        equations.declaration().prepare();
        let (order, n) = (tolerance.first_order(), q0.len());
        let mut motion = Self {
            series: Box::new(Series::new(n, order)),
            next: Box::new(Series::new(n, order)),
            known: None,
            control: Control::new(tolerance, n),
            weights: Weights::new(n),
            order: Order::new(tolerance),
            last: None,
            t: Compensated::exact([t0]),
            now: State::exact(q0, v0),
            tried: State::exact(q0, v0),
            steps: 0,
            rejected: 0,
            max_steps: MAX_STEPS,
            smallest: 0.0,
            clock: Clock::free(t0),
            knots: Vec::new(),
            projection: Projection::new(&equations.declaration(), (t0, q0, v0)),
            watch: Watch::new(equations, t0),
            jump: None,
            arrived: None,
            is_new: true,
            began: t0,
            looked: (0, t0),
            expansions: 0,
            on_grid: None,
            shown: t0,
        };
        if let Some(a0) = &phase.near {
            motion.next.expect(a0);
        }
        motion.begin(equations);
        let mut coefficients = motion.next.velocities().iter();
        // one whose higher orders leave the range of doubles does without them in its first step
        if coefficients.all(|x| x.is_finite()) || motion.may_begin_roughly() {
            Ok(motion)
        } else {
            let cause = SeriesFailure::NotFinite;
            Err(SetupError::Series(motion.failed(equations, cause)))
        }
    }

    /// Expands the motion at the current point.
    pub(super) fn begin(&mut self, equations: &mut dyn SeriesKernel) {
        let rests = self.rests();
        self.forget_rest();
        let t = self.side(self.t.hi[0], true);
        self.next.begin(t, self.now.q(), self.now.v());
        self.jump = None;
        self.known = None;
        if self.watch.is_some() {
            watch::each(equations, |_, _, switch| {
                switch.set(0.0);
                switch.begins_with(0);
            });
        }
        equations.expand(&mut self.next);
        if self.watch.is_some() && !(rests && self.rest(equations, None)) {
            self.begin_at_switch(equations);
        }
    }

    /// Puts the nodes on a grid of times.
    ///
    /// # Errors
    ///
    /// [`SetupError::Step`] if `h` is zero, infinite or not a number.
    pub(super) fn every(&mut self, h: f64) -> Result<(), SetupError> {
        if !h.is_finite() || h == 0.0 {
            return Err(SetupError::Step { h });
        }
        let handed = self.clock.is_handed_out();
        self.stand_here();
        self.shown = self.time();
        self.clock = Clock::even(self.time(), h);
        self.clock.hand_out(handed);
        Ok(())
    }

    /// The order of the velocity's series.
    pub(super) fn order(&self) -> usize {
        self.order.current()
    }

    /// The time up to which the motion is known.
    pub(super) fn time(&self) -> f64 {
        self.t.hi[0]
    }

    /// Position, velocity and acceleration there.
    pub(super) fn point(&self) -> AnyPoint<'_, f64> {
        AnyPoint {
            t: self.time(),
            q: self.now.q(),
            v: self.now.v(),
            a: self.acceleration(),
        }
    }

    /// Puts the current node of a grid there.
    pub(super) fn stand_here(&mut self) {
        let mut state = self.on_grid.take().unwrap_or_else(|| self.now.clone());
        state.copy(&self.now);
        state.parts().a.copy_from_slice(self.acceleration());
        self.on_grid = Some(state);
    }

    /// The acceleration there.
    pub(super) fn acceleration(&self) -> &[f64] {
        self.next.velocity_of(1)
    }

    /// The last step as a polynomial; `None` before the first.
    pub(super) fn polynomial(&self) -> Option<AnyPolynomial<'_>> {
        self.last.map(|(t, h)| AnyPolynomial {
            series: &self.series,
            t,
            from: 0.0,
            to: h,
            search: Search::SERIES,
        })
    }

    /// What is told of a number of expansions.
    pub(super) fn report(&self) -> StepReport {
        StepReport {
            iterations: self.expansions,
            stop: self.stop(),
            guess: Guess::Given,
        }
    }

    /// Whether something rested on the last step.
    fn stop(&self) -> Stop {
        if self.rested().is_some() {
            Stop::Sticks
        } else {
            Stop::Start
        }
    }

    /// Writes the current node.
    pub(super) fn tell(&self, equations: &dyn SeriesKernel, mut node: NodeMut<'_>) {
        let declaration = equations.declaration();
        let t = self.clock.time();
        let (q, v, a) = match &self.on_grid {
            Some(state) => (state.q(), state.v(), state.a()),
            None => (self.now.q(), self.now.v(), self.acceleration()),
        };
        let [room_q, room_v, room_a, force] = node.split();
        for (room, x) in [(room_q, q), (room_v, v), (room_a, a)] {
            copy(room, x);
        }
        let point = AnyPoint { t, q, v, a };
        match self.force_at_rest(equations, point) {
            Some(sided) => copy(force, &sided),
            None => declaration.continuous_force_into(point, force),
        }
        *node.scalars = NodeScalars {
            index: self.clock.index(),
            t,
            energy: declaration.energy(t, q, v),
            iterations: self.expansions,
            stop: self.stop(),
        };
    }

    /// Goes back to a point of the last step, a time `s` after its start.
    pub(super) fn stop_at(&mut self, equations: &mut dyn SeriesKernel, s: f64) {
        let Some((t, _)) = self.last else {
            return;
        };
        let n = self.series.dimension();
        let mut moves = vec![0.0; 3 * n];
        let (dq, rest) = moves.split_at_mut(n);
        let (dv, a) = rest.split_at_mut(n);
        self.series.increments(s, [&mut *dq, &mut *dv, &mut *a]);
        self.t = t;
        self.t.add(&[s]);
        let (q, v) = self.series.start();
        self.now.set_position(q);
        self.now.set_velocity(v);
        self.now.move_position(dq);
        self.now.move_velocity(dv);
        rotation::keep_norm(&equations.declaration().shape().rotations, self.now.parts().q);
        if let Some(projection) = &mut self.projection {
            projection.apply(equations, self.t.hi[0], &mut self.now);
        }
        self.next.begin(self.t.hi[0], self.now.q(), self.now.v());
        self.next.expect(a);
        self.last = Some((t, s));
        // within a step nothing changes
        let rested = self.rested().map(Sticking::rests_on_last);
        if !rested.is_some_and(|rests| self.rest(equations, Some(&rests))) {
            self.begin(equations);
        }
    }

    /// Makes one step towards a time, as long as the tolerance allows, but not beyond it. An infinite time is one that lies
    /// in the direction of the run, and never reached.
    pub(super) fn go(&mut self, equations: &mut dyn SeriesKernel, until: f64) -> Result<(), RunError> {
        let until = self.before_knot(until);
        let smallest = self.smallest_step(until);
        let until = if until.is_infinite() {
            FAR.max(2.0 * self.t.hi[0].abs()).copysign(until)
        } else {
            until
        };
        let left = (until - self.t.hi[0]) - self.t.lo[0];
        if self.steps >= self.looks_at()
            && let Some(cause) = self.has_stalled()
        {
            return Err(self.failed(equations, cause).into());
        }
        if let Some(switch) = self.watch.as_ref().and_then(|watch| watch.stuck.clone())
            && !self.rest(equations, None)
        {
            let is_declared = equations.declaration().shape().piecewise;
            let cause = SeriesFailure::Sticks { switch, is_declared };
            return Err(self.failed(equations, cause).into());
        }
        if let Some((switch, by)) = self.jump.clone() {
            return Err(self.failed(equations, SeriesFailure::Jumps { switch, by }).into());
        }
        if self.steps >= self.weights.next {
            self.weigh(equations);
        }
        let rejected = self.rejected;
        let outcome = if self.rests() {
            self.step_at_rest(equations, (until, left), smallest)
        } else {
            if let Some(watch) = &mut self.watch {
                watch.rested = None;
            }
            self.advance(equations, (until, left), smallest)
        };
        match outcome {
            Outcome::Good => {
                self.steps += 1;
                self.expansions += 1 + u32::try_from(self.rejected - rejected).unwrap_or(u32::MAX - 1);
                Ok(())
            }
            Outcome::NotFinite if self.goes_over_here(equations) => self.go(equations, until),
            Outcome::NotFinite => Err(self.failed(equations, SeriesFailure::NotFinite).into()),
            Outcome::Unbounded(time) => Err(self.failed(equations, SeriesFailure::Unbounded { time }).into()),
            Outcome::Dependent(time, row) => Err(self
                .failed(equations, SeriesFailure::Dependent { time, row })
                .into()),
            Outcome::TooSmall(step) => Err(self
                .failed(equations, SeriesFailure::StepTooSmall { step, smallest })
                .into()),
        }
    }

    /// After how many steps it is asked whether the motion gets on, and is allowed to.
    pub(super) fn looks_at(&self) -> u64 {
        self.max_steps.min(self.looked.0 + LOOK_EVERY)
    }

    /// Why the motion is not to go on, where it makes steps and gets no further, or has made as many as it may.
    #[cold]
    fn has_stalled(&mut self) -> Option<SeriesFailure> {
        let (steps, now) = (self.steps, self.t.hi[0]);
        let span = (now - self.began).abs();
        let (before, then) = self.looked;
        let led = (now - then).abs();
        if steps - before >= LOOK_EVERY {
            self.looked = (steps, now);
            if led < STALLED * span {
                return Some(SeriesFailure::Stalls {
                    steps: steps - before,
                    led,
                });
            }
        }
        (steps >= self.max_steps).then(|| SeriesFailure::TooManySteps {
            steps,
            last: self.last.map_or(0.0, |(_, h)| h.abs()),
            mean: span / steps.max(1) as f64,
        })
    }

    /// Does without the orders whose coefficients leave the range of doubles: in a unit of time that is long for the motion, as a second is for an
    /// electron in a magnetic field, or short.
    #[cold]
    #[inline(never)]
    fn cut_to_range(&mut self) {
        let known = self.series.in_range_to();
        if known < self.series.order() && self.order.limit(known) {
            self.series.set_order(known);
        }
    }

    /// The length of the step that the tolerance allows, by the series of its beginning.
    #[inline]
    pub(super) fn wanted(&mut self, sizes: &Sizes) -> f64 {
        let Self {
            control,
            order,
            series,
            ..
        } = self;
        match self.last {
            Some((_, last)) if !self.is_new => {
                let (log_size, before) = (control.log_size(sizes, last), order.current());
                order.learn(control, series, log_size);
                let p = order.current();
                exp2(if p == before {
                    control.log_step(sizes.last, p, log_size)
                } else {
                    control.log_step_by(series, p, log_size)
                })
            }
            _ => control.first_step(series, order.current()),
        }
    }

    /// The length of the next step, as far as the tolerance and rotations allow it.
    #[inline]
    fn length(&mut self, equations: &dyn SeriesKernel, sizes: &Sizes) -> f64 {
        let mut wanted = self.wanted(sizes);
        if wanted.is_nan() {
            // also where nothing moves, and nothing makes it do so
            wanted = self.control.first_step(&self.series, self.order.current());
        }
        self.limited(equations, wanted)
    }

    /// The length of a step that the tolerance allows, if rotations allow it.
    #[inline]
    pub(super) fn limited(&self, equations: &dyn SeriesKernel, wanted: f64) -> f64 {
        let rotations = &equations.kernel().shape().rotations;
        if rotations.is_empty() {
            return wanted;
        }
        let turns = self.turns(rotations);
        if wanted > turns { turns } else { wanted }
    }

    /// The length of a step that the quaternions of rotations allow: where a body spins evenly its angular velocity says nothing of it.
    #[cold]
    #[inline(never)]
    fn turns(&self, rotations: &[usize]) -> f64 {
        let (n, p) = (self.series.dimension(), self.order.current());
        let tolerance = self.control.relative().max(f64::EPSILON);
        let of_order = |k: usize| {
            let row = self.series.positions().get(k * n..(k + 1) * n).unwrap_or(&[]);
            let slots = rotations
                .iter()
                .filter_map(|&first| row.get(first..first + rotation::SLOTS));
            let largest = slots
                .flatten()
                .fold(0.0_f64, |largest, c| larger(largest, c.abs()));
            (tolerance / largest).powf(1.0 / k as f64)
        };
        of_order(p - 1).min(of_order(p))
    }

    /// What the control of the step asks of the series of its beginning, which has just become the last one.
    #[inline]
    pub(super) fn sizes(&mut self) -> Sizes {
        match self.known.take() {
            Some(sizes) => sizes,
            None => Sizes::of(&self.series, self.control.weights(), self.order.current()),
        }
    }

    /// Sets in what units the components compare.
    pub(super) fn scales(&mut self, scales: &[f64]) {
        let weights: Vec<f64> = scales.iter().map(|scale| scale.recip()).collect();
        self.control.weigh(&weights);
        self.weights.stop();
        self.known = None;
    }

    /// The smallest step on the way to a time.
    pub(super) fn smallest_step(&self, until: f64) -> f64 {
        let now = self.t.hi[0].abs();
        let scale = if until.is_infinite() {
            now
        } else {
            now.max(until.abs())
        };
        self.smallest.max(f64::EPSILON / 4.0 * scale)
    }

    /// The velocity at the end of a step of the length `h` that has been tried, if the constraints of lower order move it by more than the tolerance explains.
    #[inline(always)]
    pub(super) fn moved(&self, h: f64) -> Option<&[f64]> {
        let projection = self.projection.as_ref()?;
        projection.moved(self.least_jump(), self.pace(h))
    }

    /// How fast the motion is in a step of the length `h`.
    #[inline(always)]
    fn pace(&self, h: f64) -> f64 {
        let [v, a] = [0, 1].map(|k| size(self.series.velocity_of(k)));
        v.max(a * h.abs())
    }

    /// The least part of a velocity or of a position that is a jump, where constraints move it.
    #[inline(always)]
    fn least_jump(&self) -> f64 {
        (JUMPS * self.control.relative()).clamp(LEAST_JUMP, 0.1)
    }

    /// What makes the position or the velocity jump at the end of a step of the length `h`, where something is switched.
    #[cold]
    #[inline(never)]
    fn jump_after(
        &mut self,
        equations: &mut dyn SeriesKernel,
        h: f64,
    ) -> Option<(Option<Cow<'static, str>>, Jump)> {
        let way = self.pace(h) * h.abs();
        let shifted = self
            .projection
            .as_ref()
            .and_then(|projection| projection.shifted(self.least_jump(), way))
            .map(<[f64]>::to_vec);
        let by = if let Some(before) = &shifted {
            // and at the place where it is
            self.now.set_position(before);
            Jump::Position
        } else if let Some(before) = self.moved(h).map(<[f64]>::to_vec) {
            // the motion ends with the velocity that it has
            self.now.set_velocity(&before);
            Jump::Constraint
        } else if self.jumps_in_action(&equations.declaration(), h) {
            Jump::Lagrangian
        } else {
            return None;
        };
        let mut switch = None;
        watch::each(equations, |group, place, at| {
            if switch.is_none() && at.touches() {
                switch = Some((group, place));
            }
        });
        Some((switch.map(|(group, place)| equations.switch(group, place)), by))
    }

    /// Whether the Lagrangian jumps with the position or the velocity, or the momentum does, at the end of a step of the length `h`. One that
    /// jumps in time alone, as a force that is switched on does, changes no velocity.
    fn jumps_in_action(&self, declaration: &Declaration<'_>, h: f64) -> bool {
        let [part, least] = BESIDE;
        let beside = part * h;
        let n = self.series.dimension();
        let (mut a, mut rest) = (vec![0.0; n], vec![0.0; 2 * n]);
        let (q, v) = rest.split_at_mut(n);
        self.series.increments(h, [q, v, &mut a]);
        let at = |s: f64| {
            let [q, v] = [self.now.q(), self.now.v()];
            let after: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + s * a).collect();
            let way: Vec<f64> = v.iter().map(|v| s * v).collect();
            (rotation::moved(&declaration.shape().rotations, q, &way), after)
        };
        // the Lagrangian, and the power of the momentum
        let values = |t: f64, (q, v): &(Vec<f64>, Vec<f64>)| {
            let [l, e] = [declaration.lagrangian(t, q, v), declaration.energy(t, q, v)];
            [l, l + e, l.abs().max(e.abs())]
        };
        let jumps = |beside: f64| {
            let [before, beyond] = [-beside, beside].map(|s| (self.time() + s, at(s)));
            let first = values(before.0, &before.1);
            let [moved, last] = [before.0, beyond.0].map(|t| values(t, &beyond.1));
            [
                (moved[0] - first[0]).abs(),
                (last[1] - first[1]).abs(),
                first[2].max(last[2]),
            ]
        };
        let (near, far) = (jumps(beside), jumps(FARTHER * beside));
        // what is smooth grows with the distance
        (0..2).any(|k| near[k] > least * near[2] && near[k] > JUMPS_NEAR * far[k])
    }

    /// The next knot in the direction of the run, if it comes before a time; else that time.
    fn before_knot(&self, until: f64) -> f64 {
        if self.knots.is_empty() {
            return until;
        }
        let now = self.t.hi[0];
        if self.clock.is_forward() {
            let next = self.knots.partition_point(|&knot| knot <= now);
            self.knots.get(next).map_or(until, |knot| knot.min(until))
        } else {
            let next = self.knots.partition_point(|&knot| knot < now);
            let knot = next.checked_sub(1).and_then(|next| self.knots.get(next));
            knot.map_or(until, |knot| knot.max(until))
        }
    }

    /// A time as it is seen from ahead of it or from behind, in the direction of the run: what is known by pieces belongs to the
    /// right one at a knot.
    pub(super) fn side(&self, t: f64, ahead: bool) -> f64 {
        let is_knot =
            !self.knots.is_empty() && self.knots.binary_search_by(|knot| knot.total_cmp(&t)).is_ok();
        if is_knot && ahead != self.clock.is_forward() {
            t.next_down()
        } else {
            t
        }
    }

    /// Puts knots among those that there are.
    pub(super) fn add_knots(&mut self, knots: impl IntoIterator<Item = f64>) {
        self.knots
            .extend(knots.into_iter().filter(|knot| knot.is_finite()));
        self.knots.sort_by(f64::total_cmp);
    }

    #[cold]
    pub(super) fn failed(&self, equations: &dyn SeriesKernel, cause: SeriesFailure) -> SeriesError {
        let cause = self.because_of_dependence(equations, &cause).unwrap_or(cause);
        let undefined = || {
            let (t, q, v) = (self.t.hi[0], self.now.q(), self.now.v());
            let a = &vec![0.0; q.len()];
            undefined::of_point(&equations.declaration(), AnyPoint { t, q, v, a })
        };
        let open = || {
            let (t, q, v) = (self.t.hi[0], self.now.q(), self.now.v());
            let a = self.series.velocity_of(1);
            let zero = vec![0.0; q.len()];
            let a = if a.iter().all(|a| a.is_finite()) { a } else { &zero };
            deficiency::near_point(&equations.declaration(), AnyPoint { t, q, v, a })
        };
        SeriesError::new(FailedSeries {
            step: self.steps,
            time: self.t.hi[0],
            q: self.now.q().to_vec(),
            v: self.now.v().to_vec(),
            coordinates: equations
                .kernel()
                .shape()
                .coordinates
                .iter()
                .map(|coordinate| coordinate.name.clone())
                .collect(),
            undefined: (cause == SeriesFailure::NotFinite).then(undefined).flatten(),
            deficiency: matches!(
                cause,
                SeriesFailure::Stalls { .. }
                    | SeriesFailure::StepTooSmall { .. }
                    | SeriesFailure::Unbounded { .. }
            )
            .then(open)
            .flatten(),
            may_divide: equations.declaration().constraints()[2] > 0,
            tolerance: self.control.relative(),
            cause,
        })
    }

    /// The failure where constraints depend on each other, if that may be why a run comes to its end here without a switch.
    #[cold]
    fn because_of_dependence(
        &self,
        equations: &dyn SeriesKernel,
        cause: &SeriesFailure,
    ) -> Option<SeriesFailure> {
        let may_be = matches!(
            cause,
            SeriesFailure::Jumps { switch: None, .. }
                | SeriesFailure::NotFinite
                | SeriesFailure::StepTooSmall { .. }
                | SeriesFailure::Stalls { .. }
        );
        if self.projection.is_none() || !may_be {
            return None;
        }
        let time = self.t.hi[0];
        let place = Place::of_phase(time, Vector::of(self.now.q()), Vector::of(self.now.v()));
        let row = singular::dependent_at(&equations.declaration(), &place)?;
        Some(SeriesFailure::Dependent { time, row })
    }

    /// The length of a step that has been tried with the length `h`; it ends beyond a switch where the next piece has a value.
    fn beyond(&mut self, equations: &mut dyn SeriesKernel, trial: &Trial, h: f64) -> f64 {
        let Some(beyond) = trial.beyond.filter(|_| trial.end.at_switch) else {
            return h;
        };
        let h = beyond.copysign(h);
        self.arrive(equations, h, self.t.hi[0] + h);
        h
    }

    /// Makes one step to a time, or as far as the tolerance allows. `left` is the way there.
    fn advance(
        &mut self,
        equations: &mut dyn SeriesKernel,
        (until, left): (f64, f64),
        smallest: f64,
    ) -> Outcome {
        core::mem::swap(&mut self.series, &mut self.next);
        let mut sizes = self.sizes();
        if !sizes.is_in_range {
            self.cut_to_range();
            sizes = self.sizes();
        }
        let mut wanted = self.length(equations, &sizes);
        let mut is_rough = false;
        if (self.is_new || (wanted < smallest && Self::is_at_switch(equations, smallest)))
            && let Some(length) = self.begin_roughly(wanted, smallest)
        {
            (wanted, is_rough) = (length, true);
        }
        self.next.set_order(self.order.next());
        if wanted.is_nan() || wanted < smallest {
            core::mem::swap(&mut self.series, &mut self.next);
            return if wanted > 0.0 {
                Outcome::TooSmall(wanted)
            } else {
                Outcome::NotFinite
            };
        }
        let mut trial = Trial::of(wanted.min(left.abs()), is_rough);
        let mut has_pieces = false;
        if let Some(watch) = &self.watch {
            has_pieces = watch.has_pieces;
            self.foresee_trial(equations, &mut trial, left);
        }
        loop {
            let End { size, at_switch, .. } = trial.end;
            let whole = size == left.abs();
            let h = if whole { left } else { size.copysign(left) };
            let t = if whole { until } else { self.t.hi[0] + h };
            let Judged {
                sizes: mut known,
                mut end,
            } = self.arrive(equations, h, t);
            if self.weights.are_used && known.velocity.max(end[0] * size) > GROWS * self.weights.largest {
                let (begins, judged) = self.weigh_at_end(equations, h);
                (sizes, known, end) = (begins, judged.sizes, judged.end);
            }
            if has_pieces && !at_switch && Self::is_beyond(equations, size) {
                trial.end = self.locate(equations, left.signum(), [0.0, size]);
                continue;
            }
            let is_knot = self.side(t, true) != self.side(t, false);
            // a velocity that jumps where no expansion shows a switch
            let jumps = !at_switch && !is_knot && self.moved(h).is_some();
            let good = !jumps
                && (self.control.good(&sizes, end, size, trial.is_rough)
                    || self.is_rounding(equations, end[1], size));
            // a jump of the acceleration is passed in a step that no clock would see
            if good || (size <= smallest && self.next.is_finite()) {
                let h = self.beyond(equations, &trial, h);
                match self.past(equations, (h, smallest), !at_switch && !is_knot) {
                    None => {}
                    Some(Past::Unseen(ahead)) => {
                        self.rejected += 1;
                        trial = Trial::of(0.5 * ahead, trial.is_rough);
                        continue;
                    }
                    Some(Past::End(outcome)) => {
                        core::mem::swap(&mut self.series, &mut self.next);
                        return outcome;
                    }
                }
                if let Some(projection) = &mut self.projection {
                    projection.keep_directions();
                }
                self.last = Some((self.t, h));
                if whole {
                    self.t = Compensated::exact([until]);
                } else {
                    self.t.add(&[h]);
                }
                core::mem::swap(&mut self.now, &mut self.tried);
                self.known = Some(known);
                let jump = if at_switch || is_knot || size <= smallest {
                    self.jump_after(equations, h)
                } else {
                    None
                };
                if at_switch {
                    let tau = if wanted < 1e100 { wanted } else { size };
                    self.go_over(equations, tau.copysign(left), (size <= smallest, true));
                } else if self.is_new || has_pieces {
                    self.go_on(equations);
                }
                // beyond a knot the system may be another
                if is_knot {
                    self.begin(equations);
                }
                self.jump = jump;
                return Outcome::Good;
            }
            self.rejected += 1;
            if !self.try_again(&mut trial, !end[1].is_nan(), smallest) {
                // back to where it was
                core::mem::swap(&mut self.series, &mut self.next);
                return Outcome::NotFinite;
            }
        }
    }
}

/// How a step ended.
pub(super) enum Outcome {
    Good,
    NotFinite,
    TooSmall(f64),
    Unbounded(f64),
    Dependent(f64, DependentRow),
}
