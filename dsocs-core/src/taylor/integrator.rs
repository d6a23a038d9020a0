//! The integrator of the continuous motion, for systems of any type.

use core::fmt;
use std::borrow::Cow;

use super::control::{Assessment, Control, NOTHING, Sizes, Tolerance};
use super::corner;
use super::failed::BACK_AND_FORTH;
use super::order::Order;
use super::projection::Projection;
use super::recurrences::SeriesKernel;
use super::singular::Past;
use super::state::State;
use super::sticking::Sticking;
use super::trial::Trial;
use super::watch::{self, End, Watch};
use super::weights::Weights;
use crate::error::SetupError;
use crate::error::series::{Jump, SeriesFailure};
use crate::kernel::clock::Clock;
use crate::kernel::report::{Guess, NodeMut, NodeScalars, StepReport};
use crate::number::compensated::Compensated;
use crate::number::point::{AnyPoint, copy};
use crate::regularity::deficiency::DependentRow;
use crate::regularity::forks;
use crate::run::{AnyPolynomial, RunError, Search};
use crate::series::rows::Series;
use crate::solve::newton::Stop;
use crate::solve::rotation;
use crate::start::Phase;

/// Largest number of steps of a motion, unless set by [`super::TaylorFlow::max_steps`].
pub(super) const MAX_STEPS: u64 = 10_000_000;

/// Number of steps after which it is checked whether the motion advances.
pub(super) const LOOK_EVERY: u64 = 1024;

/// A time that is never reached. Terms of a series stay finite there, so that changes of sign are found on
/// the way.
const FAR: f64 = 1e100;

/// Weights of velocities are computed again if one becomes this many times the largest.
const GROWS: f64 = 2.0;

/// The state of a motion. Functions that need the system receive it as an argument.
pub(crate) struct Integrator {
    /// The series of the last step.
    pub(super) series: Box<Series>,
    /// The series at the current point; the two are swapped with every step.
    pub(super) next: Box<Series>,
    /// The sizes in the series at the current point, if the last step has computed them.
    pub(super) known: Option<Sizes>,
    /// The control of the steps.
    pub(super) control: Control,
    /// The sizes of velocities.
    pub(super) weights: Weights,
    /// The choice of the order.
    pub(super) order: Order,
    /// The time where the last step began, and its length.
    pub(super) last: Option<(Compensated<1>, f64)>,
    /// Whether the last step begins, and whether it ends, at a switch or a knot.
    pub(super) at_switch: [bool; 2],
    /// With constraints of lower order, the size of the velocity lately: half of it is forgotten with each step.
    /// A body that comes to rest is corrected by the rounding of the velocity that it had.
    pub(super) lately: f64,
    /// The current time.
    pub(super) t: Compensated<1>,
    /// The current position and velocity.
    pub(super) now: State,
    /// Position and velocity at the end of the trial step.
    pub(super) tried: State,
    /// The number of steps so far.
    pub(super) steps: u64,
    /// The number of rejected steps.
    pub(super) rejected: u64,
    /// The largest number of steps.
    pub(super) max_steps: u64,
    /// The smallest step.
    pub(super) smallest: f64,
    /// The number and the time of the current node.
    pub(super) clock: Clock,
    /// Times at which steps end, in ascending order, because the motion has no series there.
    pub(super) knots: Vec<f64>,
    /// The projection onto constraints of lower order.
    pub(super) projection: Option<Projection>,
    /// The state of a system with switches.
    pub(super) watch: Option<Box<Watch>>,
    /// The cause of a jump of the velocity at the current point, and its switch.
    pub(super) jump: Option<(Option<Cow<'static, str>>, Jump)>,
    /// Whether the motion begins anew at the current point, so that the last step is no guide for the next.
    pub(super) is_new: bool,
    /// The length of the step that led to the corner of a root, as long as no step has gone beyond.
    pub(super) corner: Option<f64>,
    /// The time where the motion began.
    pub(super) began: f64,
    /// The number of steps at the last check whether the motion advances, and the time then.
    pub(super) looked: (u64, f64),
    /// The number of trial steps that have met a jump of the acceleration, minus the number of steps accepted at once since, and the time of
    /// the first of them.
    pub(super) torn: (u32, f64),
    /// The number of expansions since the last node.
    pub(super) expansions: u32,
    /// Position, velocity and acceleration at the current node, where nodes lie on a grid.
    pub(super) on_grid: Option<State>,
    /// The time up to which the motion has been shown; see [`crate::Stepper::trace`].
    pub(super) shown: f64,
    /// The arrival at the node where inputs changed last.
    pub(super) arrived: Option<Box<Arrived>>,
}

/// The arrival at a change of inputs. Several changes at one place are one: the velocity jumps from the
/// values before all of them.
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
    /// A motion from a time, a position and a velocity, with an acceleration near the expected one.
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
            at_switch: [false; 2],
            lately: 0.0,
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
            corner: None,
            began: t0,
            looked: (0, t0),
            torn: (0, t0),
            expansions: 0,
            on_grid: None,
            shown: t0,
        };
        // a start may lie on a switch
        motion.at_switch[1] = motion.watch.is_some();
        if let Some(a0) = &phase.near {
            motion.next.expect(a0);
        }
        motion.begin(equations);
        let mut coefficients = motion.next.velocities().iter();
        // if its higher orders overflow or underflow, its first step does without them
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
        self.corner = None;
        self.torn.0 = 0;
        if self.watch.is_some() {
            watch::each(equations, |_, _, switch| {
                switch.set(0.0);
                switch.begins_with(0);
            });
        }
        equations.expand(&mut self.next);
        if self.watch.is_some() && !(rests && self.rest(equations, None)) {
            self.begin_at_switch(equations);
            self.look_for_forks(equations, None);
            if self.steps == 0 {
                let time = self.scale_of_series().unwrap_or(1.0);
                let start = (self.t.hi[0], self.now.q(), self.now.v());
                let forks = forks::at_start(&equations.declaration(), start, time);
                if let Some(watch) = &mut self.watch {
                    watch.forks |= forks;
                }
            }
        }
    }

    /// The order of the velocity's series.
    pub(super) fn order(&self) -> usize {
        self.order.current()
    }

    /// The time up to which the motion is known.
    pub(super) fn time(&self) -> f64 {
        self.t.hi[0]
    }

    /// Position, velocity and acceleration at that time.
    pub(super) fn point(&self) -> AnyPoint<'_, f64> {
        AnyPoint {
            t: self.time(),
            q: self.now.q(),
            v: self.now.v(),
            a: self.acceleration(),
        }
    }

    /// The acceleration at that time.
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
            resting: [self.rested().map_or(&[], Sticking::rests_on_last); 2],
        })
    }

    /// The report of a step.
    pub(super) fn report(&self) -> StepReport {
        StepReport {
            iterations: self.expansions,
            stop: self.stop(),
            guess: Guess::Given,
        }
    }

    /// Whether a body came to rest in the last step.
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
        for (room, x) in [(room_q, q), (room_v, v), (&mut *room_a, a)] {
            copy(room, x);
        }
        let point = AnyPoint { t, q, v, a };
        if let Some(sided) = self.force_at_rest(equations, point) {
            copy(force, &sided);
        } else if let Some((a, sided)) = self.at_jump(&declaration, point) {
            copy(room_a, &a);
            copy(force, &sided);
        } else {
            declaration.continuous_force_into(point, force);
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
        self.at_switch[1] = false;
        // the resting arguments are the same throughout a step
        let rested = self.rested().map(|sticking| sticking.rests_on_last().to_vec());
        if !rested.is_some_and(|rests| self.rest(equations, Some(&rests))) {
            self.begin(equations);
        }
    }

    /// Makes one step towards a time, as long as the tolerance allows, but not beyond it. An infinite time
    /// stands for one in the direction of the run that is never reached.
    pub(super) fn go(&mut self, equations: &mut dyn SeriesKernel, until: f64) -> Result<(), RunError> {
        let until = self.before_knot(until);
        let smallest = self.smallest_step(until);
        let until = if until.is_infinite() {
            FAR.max(2.0 * self.t.hi[0].abs()).copysign(until)
        } else {
            until
        };
        let left = (until - self.t.hi[0]) - self.t.lo[0];
        if (self.steps >= self.looks_at()
            || self.watch.is_some()
            || self.jump.is_some()
            || self.torn.0 >= BACK_AND_FORTH)
            && let Some(cause) = self.halts(equations)
        {
            return Err(self.failed_at_switch(equations, cause, smallest).into());
        }
        if self.steps >= self.weights.next || self.have_fallen() {
            self.weigh(equations);
        }
        let rejected = self.rejected;
        // a motion is restarted beyond a corner
        let outcome = if self.is_new
            && let Some(last) = self.corner.take()
        {
            self.step_from_corner(equations, (until, left), last)
        } else if self.rests() {
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
            Outcome::NotUnique(time, divisor) => {
                let cause = SeriesFailure::NotUnique { time, divisor };
                Err(self.failed(equations, cause).into())
            }
            Outcome::Dependent(time, row) => Err(self
                .failed(equations, SeriesFailure::Dependent { time, row })
                .into()),
            Outcome::TooSmall(step) => {
                let cause = SeriesFailure::StepTooSmall { step, smallest };
                Err(self.failed_at_switch(equations, cause, smallest).into())
            }
        }
    }

    /// The number of steps at which it is checked whether the motion advances and may continue.
    pub(super) fn looks_at(&self) -> u64 {
        self.max_steps.min(self.looked.0 + LOOK_EVERY)
    }

    /// Makes one step to a time, or as far as the tolerance allows. `left` is the distance to it.
    fn advance(
        &mut self,
        equations: &mut dyn SeriesKernel,
        (until, left): (f64, f64),
        smallest: f64,
    ) -> Outcome {
        core::mem::swap(&mut self.series, &mut self.next);
        let mut sizes = self.sizes();
        if !sizes.is_in_range && sizes.velocity.max(sizes.acceleration) > NOTHING {
            self.cut_to_range();
            sizes = self.sizes();
        }
        let mut wanted = self.length(equations, &sizes);
        let mut is_rough = false;
        let is_short = |wanted: f64| wanted.is_nan() || wanted < smallest;
        if self.may_be_rough(equations, is_short(wanted), smallest)
            && let Some(length) = self.begin_roughly(equations, wanted, smallest)
        {
            (wanted, is_rough) = (length, true);
        }
        self.next.set_order(self.order.next());
        if is_short(wanted) {
            return self.back(if wanted > 0.0 {
                Outcome::TooSmall(wanted)
            } else {
                Outcome::NotFinite
            });
        }
        let way = left.abs();
        let mut trial = Trial::of(if wanted < way { wanted } else { way }, is_rough);
        let has_pieces = self.watch.as_ref().is_some_and(|watch| watch.has_pieces);
        if self.watch.is_some() {
            self.foresee_trial(equations, &mut trial, left);
        }
        loop {
            let End {
                size,
                at_switch,
                at_corner,
                ..
            } = trial.end;
            let (h, whole) = (size.copysign(left), size == left.abs());
            let h = if whole { h } else { self.representable(h) };
            // at a corner the equations cannot be evaluated
            let judged_at = if at_corner { corner::JUDGED_AT * h } else { h };
            let t = if whole && !at_corner {
                until
            } else {
                self.t.hi[0] + judged_at
            };
            let Assessment {
                sizes: mut known,
                mut end,
            } = self.arrive(equations, judged_at, t);
            if self.weights.are_used && known.velocity.max(end[0] * size) > GROWS * self.weights.largest {
                let (begins, judged) = self.weigh_at_end(equations, judged_at);
                (sizes, known, end) = (begins, judged.sizes, judged.end);
            }
            if has_pieces && !at_switch && Self::is_beyond(equations, judged_at.abs()) {
                trial.end = self.locate(equations, left.signum(), [0.0, judged_at.abs()]);
                continue;
            }
            let is_knot = self.is_knot(t);
            // a jump of the velocity without a known switch
            let jumps = !at_switch && !is_knot && self.moved(judged_at).is_some();
            let good = if jumps {
                false
            } else if self.control.good(&sizes, end, size, trial.is_rough) {
                !trial.is_rough || at_corner || self.is_good_within(equations, &sizes, h, t)
            } else {
                self.is_rounding(equations, (end[1], size), trial.tries)
            };
            // a jump of the acceleration is passed in a step shorter than the rounding of the time
            if good || (size <= smallest && self.next.is_finite()) {
                let h = self.beyond(equations, &trial, h);
                match self.past(
                    equations,
                    (if at_corner { judged_at } else { h }, smallest),
                    (t, (!at_switch && !is_knot).then_some(end)),
                ) {
                    None => {}
                    Some(Past::Unseen(ahead)) => {
                        self.rejected += 1;
                        trial = Trial::of(0.5 * ahead, trial.is_rough);
                        continue;
                    }
                    Some(Past::End(outcome)) => return self.back(outcome),
                }
                if (trial.tries > 0 || self.torn.0 > 0) && !trial.is_foreseen {
                    self.count_torn(equations, (end, size), trial.tries);
                }
                let tau = if wanted < 1e100 { wanted } else { size };
                let made = Made {
                    h,
                    until: whole.then_some(until),
                    end: trial.end,
                    is_knot,
                    known,
                    tau: tau.copysign(left),
                    is_short: size <= smallest,
                };
                self.make(equations, &made);
                return Outcome::Good;
            }
            self.rejected += 1;
            if !self.try_again(&mut trial, !end[1].is_nan(), smallest) {
                return self.back(Outcome::NotFinite);
            }
        }
    }

    /// Commits the trial step.
    fn make(&mut self, equations: &mut dyn SeriesKernel, made: &Made) {
        let Made { h, ref end, .. } = *made;
        let may_jump = end.at_switch || made.is_knot || made.is_short;
        if let Some(projection) = &mut self.projection {
            projection.keep_directions();
        }
        if end.at_corner {
            self.arrive_at_corner(equations, h);
        }
        self.last = Some((self.t, h));
        // a step that ends where it was asked to may end at a switch, too
        self.keep(h, may_jump || (made.until.is_some() && self.watch.is_some()));
        match made.until {
            Some(until) => self.t = Compensated::exact([until]),
            None => self.t.add(&[h]),
        }
        core::mem::swap(&mut self.now, &mut self.tried);
        self.known = (!end.at_corner).then_some(made.known);
        let jump = if may_jump {
            self.jump_after(equations, h)
        } else {
            None
        };
        if end.at_switch {
            self.go_over(equations, made.tau, (made.is_short, true));
        } else if end.at_corner {
            self.is_new = true;
        } else if self.is_new || self.watch.as_ref().is_some_and(|watch| watch.has_pieces) {
            self.go_on(equations);
        }
        // beyond a knot the system may have changed
        if made.is_knot {
            self.begin(equations);
        }
        self.jump = jump;
    }

    /// Undoes a trial step that is not committed.
    #[cold]
    fn back(&mut self, outcome: Outcome) -> Outcome {
        core::mem::swap(&mut self.series, &mut self.next);
        outcome
    }
}

/// An accepted trial step.
struct Made {
    /// Its length.
    h: f64,
    /// The time of its end, if that is where the run was to go.
    until: Option<f64>,
    end: End,
    /// Whether it ends at a knot.
    is_knot: bool,
    /// The sizes in the series at its end, for the step control.
    known: Sizes,
    /// A time scale of the motion.
    tau: f64,
    /// Whether it is shorter than the rounding of the time.
    is_short: bool,
}

/// The end of a step.
pub(super) enum Outcome {
    Good,
    NotFinite,
    TooSmall(f64),
    Unbounded(f64),
    Dependent(f64, DependentRow),
    /// The time of the place, and the divisor that is zero there.
    NotUnique(f64, Option<String>),
}
