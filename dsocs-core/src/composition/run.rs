//! A run by a composed step, for any number of coordinates.

#![allow(clippy::float_cmp)] // signs and fractions are kept as they are

use std::sync::Arc;

use super::backward;
use super::momenta::{self, Momenta};
use super::stages::{ComposedState, Stage, Stages, State};
use super::unresolved::RecentNodes;
use crate::error::stage::{FailedStage, StageError, StageFailure};
use crate::error::{SetupError, StepError};
use crate::flow::discrete::{check, constants_of};
use crate::kernel::Kernel;
use crate::kernel::clock::Clock;
use crate::kernel::report::{Guess, NodeMut, StepReport};
use crate::kernel::run_state::MAX_ITERATIONS;
use crate::kernel::run_state::past_is_short;
use crate::number::composition::Composition;
use crate::number::point::{AnyLeg, AnyPoint, OwnedLeg, copy};
use crate::regularity::{Regularity, forks, resting};
use crate::run::{AnyNode, NearlySingular, Run, RunError, Unresolved};
use crate::solve::Vector;
use crate::solve::elimination::Determinant;
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::solve::newton::Stop;
use crate::solve::predictor::Predictor;
use crate::solve::sum::Sum;
use crate::start::InitialAcceleration;
use crate::start::place::Place;
use crate::start::{self, Phase, StartData};
use crate::step::limit;
use crate::step::singular::{self, DeterminantChange};
use crate::step::switches;
use crate::step::{FailurePlace, Step};
use crate::tape::Symmetry;
use crate::tape::declaration::Declaration;

/// A run by a composed step.
#[derive(Clone)]
pub(crate) struct Composed<'s> {
    /// The system.
    pub kernel: &'s dyn Kernel,
    /// The values of its parameters.
    pub values: Vec<f64>,
    /// Its smooth stages, compiled for the declared type.
    stages: Option<Arc<dyn Stages + 's>>,
    /// The method.
    pub method: Composition,
    /// The step.
    pub h: f64,
    /// The state that is carried from step to step.
    pub(super) run_state: ComposedState,
    /// The steps so far near a singularity.
    nearly_singular: Option<NearlySingular>,
    /// The state of a method whose legs are joined by momenta.
    joined: Option<Box<MomentumState>>,
    /// Whether the declaration has functions that jump with the velocity.
    may_rest: bool,
    /// Whether each argument of such functions is zero at the current node.
    pub(super) resting: Vec<bool>,
    /// The steps so far that were too long for a jump in them.
    pub(super) unresolved: Option<Unresolved>,
    /// The watch for jumps of the acceleration; `None` if there can be none.
    pub(super) watch: Option<Box<RecentNodes>>,
    /// The constraint force of the last step that was solved with sides, and the index of the node at its
    /// end.
    pub(super) force: Option<(u64, Vector)>,
    /// The arrival at the node where inputs changed last.
    arrived: Option<Box<ArrivalAtChange>>,
    /// Whether the motion from the start is not unique, where a force jumps with the position.
    begins_at_fork: bool,
}

/// The arrival at a node where inputs change. Several changes at one node are one: the velocity jumps from
/// the values before all of them.
#[derive(Clone)]
struct ArrivalAtChange {
    /// The number of the node.
    index: u64,
    /// The values of the parameters before.
    values: Vec<f64>,
    /// The state at the node.
    now: State,
    /// The motion with its momentum, if momenta join the legs.
    joined: Option<momenta::Node>,
}

/// The state of a method whose legs are joined by momenta.
#[derive(Clone, Debug)]
struct MomentumState {
    /// The current node.
    now: momenta::Node,
    /// The legs of each stage in the last steps.
    past: Vec<momenta::LegPredictor>,
    /// The determinant of the equations for the acceleration that was examined last; `None` before.
    examined: Option<ExaminedDeterminant>,
}

/// The node at which a determinant was examined, and when that is due again.
#[derive(Clone, Copy, Debug)]
struct ExaminedDeterminant {
    determinant: Determinant,
    /// The number of its node.
    index: u64,
    /// The number of the node at which it is examined again.
    again: u64,
}

/// A determinant that changes by less than this part of itself in a step is not near zero. It is examined again before it can have changed by
/// as much.
const STEADY: f64 = 0.1;

impl State {
    /// A node without its momentum.
    fn of(node: &momenta::Node) -> Self {
        Self {
            q: node.q.clone(),
            v: Sum::exact(node.v.clone()),
            a: node.a.clone(),
        }
    }

    /// The point of the state at a time.
    fn point(&self, t: f64) -> AnyPoint<'_, f64> {
        AnyPoint {
            t,
            q: &self.q.hi,
            v: &self.v.hi,
            a: &self.a,
        }
    }

    /// The velocity after a kick by the acceleration.
    fn kicked(&self, h: f64) -> Vector {
        self.v.hi.zip(&self.a, |v, a| v + h * a)
    }
}

/// The report at the start, where nothing was solved.
const START: StepReport = StepReport {
    iterations: 0,
    stop: Stop::Start,
    guess: Guess::Given,
};

/// The report of a smooth stage.
const USUAL: StepReport = StepReport {
    iterations: 1,
    stop: Stop::Update,
    guess: Guess::Predicted,
};

impl<'s> Composed<'s> {
    /// Sets up a run with the step `h` and the given values of the parameters. Without `stages`, all stages
    /// are solved on slices.
    pub fn new(
        (kernel, values): (&'s dyn Kernel, Vec<f64>),
        stages: Option<Arc<dyn Stages + 's>>,
        h: f64,
        method: Composition,
        start: &StartData,
    ) -> Result<Self, SetupError> {
        let symmetry = kernel.shape().symmetry;
        if !matches!(symmetry, Symmetry::AnyLegs | Symmetry::Momenta) {
            return Err(SetupError::Composition {
                method,
                reason: symmetry,
            });
        }
        let declaration = Declaration::of(kernel).with(&values);
        for fraction in method.fractions() {
            check(&declaration, fraction * h)?;
        }
        declaration.prepare();
        let Phase { t0, q0, v0, near } = start.phase(&declaration)?;
        start::check_underflow(&declaration, (t0, &q0, &v0), Some(h))?;
        let (now, joined);
        if symmetry == Symmetry::Momenta {
            let node = Momenta::of(declaration).start(t0, (Sum::exact(q0), v0), near.as_deref())?;
            now = State::of(&node);
            joined = Some(Box::new(MomentumState {
                now: node,
                past: Vec::new(),
                examined: None,
            }));
        } else {
            now = State {
                a: start::state_acceleration(&declaration, (t0, &q0, &v0), near.as_deref())?,
                q: Sum::exact(q0),
                v: Sum::exact(v0),
            };
            joined = None;
        }
        let may_rest = kernel.shape().jumps && declaration.sides() > 0;
        let begins_at_fork = forks::at_start(&declaration, (t0, &now.q.hi, &now.v.hi), h);
        let force = may_rest
            .then(|| resting::force(&declaration, now.point(t0)))
            .flatten()
            .map(|force| (0, Vector::of(&force)));
        let mut run = Self {
            kernel,
            values,
            stages,
            method,
            h,
            run_state: ComposedState {
                stages: Vec::new(),
                clock: Clock::even(t0, h),
                since: 0,
                now,
                orientation: 0.0,
                report: START,
                max_iterations: MAX_ITERATIONS,
            },
            nearly_singular: None,
            joined,
            may_rest,
            resting: Vec::new(),
            unresolved: None,
            watch: None,
            force,
            arrived: None,
            begins_at_fork,
        };
        run.prepare();
        Ok(run)
    }

    /// The declaration, with the current values of the parameters.
    pub fn declaration(&self) -> Declaration<'_> {
        Declaration::of(self.kernel).with(&self.values)
    }

    /// Makes the stages for the current step.
    pub(super) fn prepare(&mut self) {
        self.watch_anew();
        let shape = self.kernel.shape();
        if let Some(joined) = &mut self.joined {
            joined.examined = None;
            joined.past.clear();
            joined
                .past
                .resize(self.method.stages(), momenta::LegPredictor::new(shape.increments));
            return;
        }
        let run_state = &mut self.run_state;
        let leg = OwnedLeg {
            t: run_state.clock.time(),
            q: run_state.now.q.hi.to_vec(),
            d: vec![0.0; shape.increments],
        };
        run_state.orientation = 0.0;
        let longest = self.method.fractions().fold(0.0, f64::min);
        let mut first = true;
        let stages = self.method.fractions().map(|fraction| {
            let h = fraction * self.h;
            let longest = fraction < 0.0 && fraction == longest && core::mem::take(&mut first);
            Stage {
                h,
                backward: fraction < 0.0,
                longest,
                per_square: (h * h).recip(),
                constants: constants_of(self.kernel, &self.values, h),
                predictor: Predictor::new(shape.unknowns),
                past: core::array::from_fn(|_| leg.clone()),
                last: 0,
                found: Vector::zero(shape.unknowns),
                leg: leg.clone(),
            }
        });
        run_state.stages = stages.collect();
    }

    /// Makes one step; near rest, or if an argument changes its sign in it, by short steps of order 2 with sides.
    #[cold]
    fn make_with_sides(&mut self) -> Result<StepReport, RunError> {
        if self.is_near_rest() {
            return self.step_slowly();
        }
        let (run_state, joined) = (self.run_state.clone(), self.joined.clone());
        let made = self.make();
        if made.is_ok() && !self.has_crossed(&run_state) {
            self.watch();
            return Ok(made?);
        }
        (self.run_state, self.joined) = (run_state, joined);
        self.step_slowly()
    }

    /// Computes the momentum of the current node, if momenta join the legs.
    pub(super) fn join_again(&mut self, t: f64) -> Result<(), RunError> {
        if self.joined.is_none() {
            return Ok(());
        }
        let State { q, v, a } = &self.run_state.now;
        let node = Momenta::of(self.declaration()).start(t, (q.clone(), v.hi.clone()), Some(a))?;
        if let Some(joined) = &mut self.joined {
            joined.now = node;
        }
        Ok(())
    }

    /// Makes one step, of all stages.
    fn make(&mut self) -> Result<StepReport, StageError> {
        if self.joined.is_some() {
            return self.solve_by_momenta();
        }
        if let Some(stages) = &self.stages
            && stages.step(&mut self.run_state).is_ok()
        {
            return Ok(self.run_state.report);
        }
        self.solve()
    }

    /// The equations of a stage.
    fn step_of<'a>(&'a self, stage: &'a Stage) -> Step<'a> {
        Step::new(
            (self.kernel, &self.values),
            &stage.constants,
            stage.leg.any(),
            stage.h,
        )
    }

    /// Makes one step whose stages are solved on slices.
    #[cold]
    fn solve(&mut self) -> Result<StepReport, StageError> {
        let mut state = self.run_state.now.clone();
        let mut total = StepReport {
            iterations: 0,
            ..USUAL
        };
        let (index, since) = (self.run_state.clock.index(), self.run_state.since);
        let now = self.run_state.clock.time();
        let mut done = 0.0;
        // between two stages the velocity is updated once, by the halves of both, as in smooth stages
        let mut left = 0.0;
        for place in 0..self.run_state.stages.len() {
            let begun = done;
            let (before, a_before) = (state.q.hi.clone(), state.a.clone());
            let stage = &mut self.run_state.stages[place];
            let (h, half) = (stage.h, 0.5 * stage.h);
            state.v.add(&state.a.map(|a| (left + half) * a));
            let d = Sum {
                hi: state.v.hi.map(|v| h * v),
                lo: state.v.lo.map(|v| h * v),
            };
            state.q = state.q.plus(&d);
            done += h;
            stage.leg.t = now + done;
            copy(&mut stage.leg.q, &state.q.hi);
            copy(&mut stage.leg.d, &d.hi);
            // taken out, since the equations borrow the rest of the stage
            let mut predictor = core::mem::replace(&mut stage.predictor, Predictor::new(0));
            let stage = &self.run_state.stages[place];
            let mut step = self.step_of(stage);
            step.past_is_short = past_is_short(index, since);
            if index == since {
                step.initial_acceleration = Some(InitialAcceleration::Given(state.a.clone()));
            }
            step.past = Some(stage.past());
            let solution = step.solve_or_limit(&mut predictor, self.run_state.max_iterations);
            self.run_state.stages[place].predictor = predictor;
            let (e, z, report) = match solution {
                Ok(solution) => solution,
                Err(cause) => return Err(self.failed(place, &state, cause)),
            };
            let stage = &self.run_state.stages[place];
            let per_square = stage.per_square;
            state.a = e.map(|e| per_square * e);
            if stage.backward && backward::is_doubtful(report) {
                let from = AnyPoint {
                    t: now + begun,
                    q: &before,
                    v: &state.v.hi.zip(&a_before, |v, a| v + -half * a),
                    a: &a_before,
                };
                if !backward::continues((self.kernel, &self.values), h, from, &state.a) {
                    let time = self.time_of_stage(place);
                    return Err(self.refused(place, StageFailure::Jump { time, h }));
                }
            }
            left = half;
            if !state.kicked(half).is_finite() {
                let cause = self.step_of(stage).not_finite(&z);
                return Err(self.failed(place, &state, cause));
            }
            let v = state.v.hi.zip(&a_before, |v, a| v + -half * a);
            let from = Place::of_phase(now + begun, before, v);
            let is_resolved = singular::is_resolved(&a_before, &state.a);
            self.look_for_singularity(place, (from, &state), (&z, report.guess), is_resolved)?;
            let stage = &self.run_state.stages[place];
            let orientation = self.step_of(stage).orientation(&z);
            let turned = stage.longest && orientation != self.run_state.orientation;
            self.run_state.stages[place].found = z;
            total = StepReport {
                iterations: total.iterations + report.iterations,
                stop: if total.stop == USUAL.stop {
                    report.stop
                } else {
                    total.stop
                },
                guess: if total.guess == USUAL.guess {
                    report.guess
                } else {
                    total.guess
                },
            };
            if turned {
                self.run_state.orientation = if is_resolved && index != since {
                    orientation
                } else {
                    self.reoriented(place, &state, half)?
                };
            }
        }
        state.v.add(&state.a.map(|a| left * a));
        self.run_state.commit(state, total);
        Ok(total)
    }

    /// Makes one step whose legs are joined by momenta.
    fn solve_by_momenta(&mut self) -> Result<StepReport, StageError> {
        let Some(joined) = &self.joined else {
            return Ok(START); // never: called only with joined legs
        };
        let clock = &self.run_state.clock;
        let mut node = joined.now.clone();
        let (mut iterations, mut done) = (0, 0.0);
        let mut increments = Vec::with_capacity(joined.past.len());
        let legs = Momenta::of(self.declaration());
        for (place, (fraction, past)) in self.method.fractions().zip(&joined.past).enumerate() {
            let h = fraction * self.h;
            done += h;
            // the last stage ends at the node, without rounding of the sum
            let last = place + 1 == self.method.stages();
            let t = if last {
                clock.time_of(clock.index() + 1)
            } else {
                clock.time() + done
            };
            let leg = legs.leg(&node, (h, t), past);
            let (next, d, count) = leg.map_err(|failure| self.unjoined(place, failure))?;
            increments.push(d);
            iterations += count;
            node = next;
        }
        let complete = legs.complete(&mut node);
        complete.map_err(|cause| {
            self.unjoined(self.method.stages() - 1, momenta::LegFailure::NotSolved(cause))
        })?;
        let next = State::of(&node);
        self.look_along(&next)?;
        self.run_state.now = next;
        if let Some(joined) = &mut self.joined {
            for (past, d) in joined.past.iter_mut().zip(&increments) {
                past.push(d);
            }
            joined.now = node;
        }
        self.run_state.report = StepReport { iterations, ..USUAL };
        self.run_state.clock.tick();
        Ok(self.run_state.report)
    }

    /// Searches for a singularity on the path of a step whose legs are joined by momenta: their own equations give no determinant.
    fn look_along(&mut self, next: &State) -> Result<(), StageError> {
        if self.kernel.shape().kinematic == 0 && self.is_steady(next) {
            return Ok(());
        }
        let clock = &self.run_state.clock;
        let place = |t: f64, state: &State| Place::of_phase(t, state.q.hi.clone(), state.v.hi.clone());
        let end = clock.time_of(clock.index() + 1);
        let [from, to] = [place(clock.time(), &self.run_state.now), place(end, next)];
        let begins = clock.index() == self.run_state.since;
        let declaration = self.declaration();
        match singular::change(&declaration, [&from, &to], 1.0, &next.a) {
            DeterminantChange::Falls if singular::on_path(&declaration, &[from, to], &next.a).is_some() => {
                Err(self.unjoined(self.method.stages() - 1, momenta::LegFailure::Singularity))
            }
            DeterminantChange::Rises if !begins => Ok(()),
            DeterminantChange::Little => Ok(()),
            DeterminantChange::Falls | DeterminantChange::Rises => {
                NearlySingular::count(&mut self.nearly_singular, end, false);
                Ok(())
            }
        }
    }

    /// Whether the determinant of the equations for the acceleration hardly changes from step to step, or did
    /// not when it was examined.
    fn is_steady(&mut self, next: &State) -> bool {
        let index = self.run_state.clock.index() + 1;
        let before = self.joined.as_ref().and_then(|joined| joined.examined);
        if before.is_some_and(|before| index < before.again) {
            return true;
        }
        let t = self.run_state.clock.time_of(index);
        let multipliers = vec![0.0; self.kernel.shape().multipliers()];
        let determinant = start::determinant_at(&self.declaration(), next.point(t), &multipliers);
        let change = before.map_or(f64::INFINITY, |before| {
            let [before, steps] = [
                before.determinant.in_units_of(determinant.exponent),
                index.saturating_sub(before.index).max(1) as f64,
            ];
            (determinant.value / before - 1.0).abs() / steps
        });
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 1 and 32"
        )]
        let steps = (STEADY / change).clamp(1.0, switches::MOST) as u64;
        if let Some(joined) = &mut self.joined {
            joined.examined = Some(ExaminedDeterminant {
                determinant,
                index,
                again: index + steps,
            });
        }
        change < STEADY
    }

    /// The error of a stage whose legs are joined by momenta.
    #[cold]
    fn unjoined(&self, place: usize, failure: momenta::LegFailure) -> StageError {
        let fraction = self.method.fractions().nth(place).unwrap_or(f64::NAN);
        let (time, h) = (self.time_of_stage(place), fraction * self.h);
        StageError::new(FailedStage {
            method: self.method,
            index: self.run_state.clock.index(),
            stage: place + 1,
            backward: fraction < 0.0,
            constrained: self.kernel.shape().kinematic > 0,
            piecewise: self.kernel.shape().piecewise,
            cause: match failure {
                momenta::LegFailure::NotSolved(cause) => StageFailure::Leg { time, h, cause },
                momenta::LegFailure::Singularity => StageFailure::Singularity { time, h },
                momenta::LegFailure::Jump => StageFailure::Jump { time, h },
            },
        })
    }

    /// The time at the end of a stage.
    fn time_of_stage(&self, place: usize) -> f64 {
        let done: f64 = self.method.fractions().take(place + 1).sum();
        self.run_state.clock.time() + done * self.h
    }

    /// The sign of the determinant of a stage, at the first step of a run and where the continuous system itself passes a singularity: that
    /// of a short leg at the end of the stage. An error if the stage has the other sign: then a singularity lies on its leg.
    #[cold]
    fn reoriented(&self, place: usize, state: &State, half: f64) -> Result<f64, StageError> {
        let stage = &self.run_state.stages[place];
        let node = AnyPoint {
            t: self.time_of_stage(place),
            q: &state.q.hi,
            v: &state.kicked(half),
            a: &state.a,
        };
        let system = (self.kernel, &self.values[..]);
        let short = backward::short_orientation(system, stage.h, node);
        let same = self.step_of(stage).orientation(&stage.found) == short;
        if same
            && !(self.run_state.clock.index() == self.run_state.since
                && backward::passes_singularity(system, stage.h, node))
        {
            return Ok(short);
        }
        let (time, h) = (self.time_of_stage(place), stage.h);
        Err(self.refused(place, StageFailure::Singularity { time, h }))
    }

    /// Examines a stage whose determinant comes near to zero or has passed it, or that was not solved from its prediction. A motion that ends
    /// at a singularity must not be continued beyond it.
    #[cold]
    fn look_for_singularity(
        &mut self,
        place: usize,
        (from, state): (Place, &State),
        (z, guess): (&[f64], Guess),
        is_resolved: bool,
    ) -> Result<(), StageError> {
        let stage = &mut self.run_state.stages[place];
        let determinants = &mut stage.predictor.determinants;
        let part = determinants.part();
        let fallen = determinants.look();
        let is_led = guess == Guess::Predicted || stage.predictor.last().is_none();
        let begins = place == 0 && self.run_state.clock.index() == self.run_state.since;
        if is_led && !fallen && !begins {
            return Ok(());
        }
        let stage = &self.run_state.stages[place];
        let to = Place::of_phase(stage.leg.t, state.q.hi.clone(), state.kicked(0.5 * stage.h));
        let declaration = self.declaration();
        let places = if stage.backward {
            [&to, &from]
        } else {
            [&from, &to]
        };
        let steps = (stage.h / self.h).abs();
        let change = || singular::change(&declaration, places, steps, &state.a);
        if begins {
            if change() != DeterminantChange::Little {
                NearlySingular::count(&mut self.nearly_singular, stage.leg.t, false);
            }
            return Ok(());
        }
        if let Some(singularity) = singular::on_path(&declaration, &[from.clone(), to.clone()], &state.a) {
            let cause = self.step_of(stage).refused(StepFailure::PassesSingularity, z);
            return Err(self.failed_at(place, state, |error| error.at(singularity), cause));
        }
        let change = change();
        if part < 0.0 || change == DeterminantChange::Falls {
            let of_step = change == DeterminantChange::Little;
            if !(of_step && is_resolved) {
                NearlySingular::count(&mut self.nearly_singular, stage.leg.t, of_step);
            }
        }
        if change == DeterminantChange::Falls {
            // each of the stages may pass the singularity
            for stage in &mut self.run_state.stages {
                stage.predictor.determinants.look_again();
            }
        }
        Ok(())
    }

    /// The error of a stage whose solution cannot belong to the motion.
    #[cold]
    fn refused(&self, place: usize, cause: StageFailure) -> StageError {
        StageError::new(FailedStage {
            method: self.method,
            index: self.run_state.clock.index(),
            stage: place + 1,
            backward: true,
            constrained: self.kernel.shape().kinematic > 0,
            piecewise: self.kernel.shape().piecewise,
            cause,
        })
    }

    /// The error of a run whose motion may go on in more than one way from the start.
    #[cold]
    fn forked(&self) -> StepError {
        let State { q, a, .. } = &self.run_state.now;
        let none = Vector::zero(a.len());
        let constants = constants_of(self.kernel, &self.values, self.h);
        let (index, time) = (self.run_state.clock.index(), self.run_state.clock.time());
        let leg = AnyLeg {
            t: time,
            q: &q.hi,
            d: &none,
        };
        let step = Step::new((self.kernel, &self.values), &constants, leg, self.h);
        let z = step.unknown(&none, &vec![0.0; self.kernel.shape().multipliers()]);
        let failing = FailurePlace {
            index,
            time,
            q0: &q.hi,
        };
        step.error(&failing, step.refused(StepFailure::Forks, &z))
    }

    /// The error of a stage that could not be made.
    #[cold]
    fn failed(&self, place: usize, state: &State, cause: NewtonFailure) -> StageError {
        self.failed_at(place, state, |error| error, cause)
    }

    /// [`Composed::failed`] with the time and the length of the leg.
    fn failed_at(
        &self,
        place: usize,
        state: &State,
        known: impl FnOnce(StepError) -> StepError,
        cause: NewtonFailure,
    ) -> StageError {
        let stage = &self.run_state.stages[place];
        let failing = FailurePlace {
            index: self.run_state.clock.index(),
            time: self.time_of_stage(place),
            q0: &state.q.hi.zip(&stage.leg.d, |q, d| q - d),
        };
        StageError::new(FailedStage {
            method: self.method,
            index: self.run_state.clock.index(),
            stage: place + 1,
            backward: stage.backward,
            constrained: self.kernel.shape().kinematic > 0,
            piecewise: self.kernel.shape().piecewise,
            cause: StageFailure::Step(known(self.step_of(stage).error(&failing, cause))),
        })
    }

    /// The certificate of the last step's equations, for the stage where they are least regular. `None` if
    /// momenta join the legs, because none is computed then.
    fn regularity_of_last(&self) -> Option<Regularity> {
        if self.run_state.report.stop == Stop::Start || self.joined.is_some() {
            return None;
        }
        let declaration = self.declaration();
        let of_stage = |stage: &Stage| {
            let e = self.step_of(stage).second_difference(&stage.found);
            Regularity::of_declaration(&declaration, stage.h, stage.leg.any(), &e)
        };
        // a NaN counts as least regular
        let condition =
            |at: &Regularity| (at.forward / at.largest_forward).min(at.backward / at.largest_backward);
        let order = |at: &Regularity| {
            let known = at.forward.is_finite() && at.backward.is_finite();
            if known { condition(at) } else { -1.0 }
        };
        self.run_state
            .stages
            .iter()
            .map(of_stage)
            .min_by(|left, right| order(left).total_cmp(&order(right)))
    }

    /// The motion after a change of inputs at a node, with its momentum if momenta join the legs.
    fn changed(
        &self,
        arrived: &ArrivalAtChange,
        values: &[f64],
    ) -> Result<(State, Option<momenta::Node>), RunError> {
        let State { q, v, a } = &arrived.now;
        let t = self.run_state.clock.time();
        let [old, new] =
            [&arrived.values[..], values].map(|values| Declaration::of(self.kernel).with(values));
        let after = start::velocity_after(&[old, new], (t, &q.hi, &v.hi))?;
        let after = Vector::of(&after);
        if let Some(joined) = &arrived.joined {
            // the momentum is conserved, except for the impulses of kinematic constraints
            let momentum = if self.kernel.shape().kinematic > 0 {
                Vector::of(&start::momentum(&new, (t, &q.hi, &after)))
            } else {
                joined.p.clone()
            };
            let now = (joined.q.clone(), momentum, after);
            let node = Momenta::of(new).node(t, now, Some(a))?;
            return Ok((State::of(&node), Some(node)));
        }
        let a = start::state_acceleration(&new, (t, &q.hi, &after), Some(a))?;
        let v = if after == v.hi {
            v.clone()
        } else {
            Sum::exact(after)
        };
        Ok((State { q: q.clone(), v, a }, None))
    }

    /// Sets a parameter from the current node on: the run begins anew there, with its position and momentum.
    fn change(&mut self, place: usize, value: f64) -> Result<(), RunError> {
        let mut values = self.values.clone();
        if let Some(parameter) = values.get_mut(place) {
            *parameter = value;
        }
        let index = self.run_state.clock.index();
        let known = self.arrived.take().filter(|known| known.index == index);
        let arrived = known.unwrap_or_else(|| {
            Box::new(ArrivalAtChange {
                index,
                values: self.values.clone(),
                now: self.run_state.now.clone(),
                joined: self.joined.as_ref().map(|joined| joined.now.clone()),
            })
        });
        let changed = self.changed(&arrived, &values);
        self.arrived = Some(arrived);
        let (now, node) = changed?;
        self.run_state.now = now;
        if let (Some(joined), Some(node)) = (&mut self.joined, node) {
            joined.now = node;
        }
        self.values = values;
        self.run_state.since = self.run_state.clock.index();
        self.prepare();
        Ok(())
    }

    /// The limits of the constraint force and the energy at the current node, where the declaration has no values.
    #[cold]
    fn limit_at_node(&self) -> Option<(Vector, f64)> {
        let State { q, v, a } = &self.run_state.now;
        let (t, h, declaration) = (self.run_state.clock.time(), self.h, self.declaration());
        let d = v.hi.map(|v| h * v);
        let leg = AnyLeg { t, q: &q.hi, d: &d };
        let data = |leg: AnyLeg<'_, f64>| {
            let point = AnyPoint {
                t: leg.t,
                q: leg.q,
                v: &v.hi[..],
                a: &a[..],
            };
            let mut force = Vector::nan(a.len());
            declaration.continuous_force_into(point, &mut force);
            let energy = declaration.energy(leg.t, leg.q, &v.hi[..]);
            Some(force.iter().copied().chain([energy]).collect())
        };
        let limit = limit::of_vector(&self.kernel.shape().rotations, (h, leg), data)?;
        let (energy, force) = limit.split_last()?;
        Some((Vector::of(force), *energy))
    }
}

impl Run for Composed<'_> {
    fn kernel(&self) -> &dyn Kernel {
        self.kernel
    }

    fn values(&self) -> &[f64] {
        &self.values
    }

    fn resting(&self) -> Vec<bool> {
        self.resting.clone()
    }

    /// Makes one step, of all stages. The report has the number of evaluations of all stages, and the stop
    /// and the guess of the first unusual stage.
    fn step(&mut self, _: f64) -> Result<StepReport, RunError> {
        if self.begins_at_fork && self.run_state.clock.index() == 0 {
            return Err(self.forked().into());
        }
        if self.may_rest {
            return self.make_with_sides();
        }
        let report = self.make()?;
        self.watch();
        Ok(report)
    }

    fn write_node(&self, node: NodeMut<'_>) {
        let State { q, v, a } = &self.run_state.now;
        let t = self.run_state.clock.time();
        let declaration = self.declaration();
        let point = self.run_state.now.point(t);
        let mut force = Vector::nan(a.len());
        match &self.force {
            Some((index, sided)) if *index == self.run_state.clock.index() => force.clone_from(sided),
            _ => declaration.continuous_force_into(point, &mut force),
        }
        let mut energy = declaration.energy(t, &q.hi[..], &v.hi[..]);
        let has_values = || force.is_finite() && energy.is_finite();
        if self.run_state.report.guess == Guess::Limit
            && !has_values()
            && let Some((limit, of_energy)) = self.limit_at_node()
        {
            (force, energy) = (limit, of_energy);
        }
        node.write(&AnyNode {
            index: self.run_state.clock.index(),
            t,
            q: &q.hi,
            v: &v.hi,
            a,
            force: &force,
            energy,
            iterations: self.run_state.report.iterations,
            stop: self.run_state.report.stop,
        });
    }

    fn clock(&self) -> &Clock {
        &self.run_state.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.run_state.clock
    }

    fn reverse(&mut self) -> Result<(), RunError> {
        self.run_state.clock.turn();
        self.run_state.since = 0;
        // nodes are numbered anew
        self.arrived = None;
        self.h = -self.h;
        self.prepare();
        self.run_state.report = START;
        Ok(())
    }

    fn regularity(&self) -> Option<Regularity> {
        self.regularity_of_last()
    }

    fn nearly_singular(&self) -> Option<NearlySingular> {
        self.nearly_singular
    }

    fn unresolved(&self) -> Option<Unresolved> {
        self.unresolved
    }

    fn set_value(&mut self, place: usize, value: f64) -> Result<(), RunError> {
        self.change(place, value)
    }
}
