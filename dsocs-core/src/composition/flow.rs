//! The flow of a composed step.

#![allow(clippy::float_cmp)] // signs and fractions are kept as they are

use core::fmt;
use core::iter::FusedIterator;

use super::backward;
use super::error::{FailedStage, StageError, StageFailure};
use super::method::Composition;
use super::momenta::{self, Momenta};
use super::symmetry::Symmetry;
use crate::any::continuous_force;
use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::error::{NewtonFailure, SetupError};
use crate::flow::{Flow, MAX_ITERATIONS, SHORT_PAST};
use crate::held::Held;
use crate::kernel::Kernel;
use crate::regularity::Regularity;
use crate::run::{AnyNode, Clock, Node, NodeMut, Run, RunError, Stepper};
use crate::start::{self, Phase, Start};
use crate::step::newton::Stop;
use crate::step::predictor::Predictor;
use crate::step::unknown::Unknown;
use crate::step::{Begins, Failing, Guess, PAST, Step, StepReport};
use crate::system::{Leg, Point, System};

/// A run by a composed step, of order 4, 6 or 8 (or 2).
///
/// The functions that drive it are those of [`Stepper`]. Nodes lie a whole step `h` apart; the nodes of the stages in between are not handed
/// out. At every node, position, velocity and acceleration obey the kinematic constraints, and the force is that of the continuous system.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::Composition;
///
/// /// An oscillator.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
/// }]
/// struct Oscillator {}
///
/// let start = Start::second_order([1.0], [0.0]);
/// let mut flow = ComposedFlow::new(&Oscillator {}, 0.25, Composition::KAHAN_LI_8, start)?;
/// let trajectory = flow.until(10.0)?;
/// assert!((trajectory.nodes[40].q[0] - 10.0_f64.cos()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Rounding
///
/// Position and velocity at the nodes are compensated sums. A stage adds the product `h v`, and between stages `h a` with half of both
/// lengths is added, each rounded once.
/// These rounding errors are as small as those of the solved accelerations, and no larger errors add up. After [`Stepper::reverse`] the flow
/// adds the same products with the opposite sign, so it returns to its start to rounding.
pub struct ComposedFlow<'s, S: System<N>, const N: usize> {
    /// The system.
    pub(super) system: Held<'s, S>,
    /// The values of its parameters.
    pub(super) values: S::Parameters<f64>,
    /// The method.
    method: Composition,
    /// The step.
    h: f64,
    /// Its stages, in order.
    stages: Vec<Stage<S::Constants<f64>, S::Unknown<f64>, N>>,
    /// Which node is the current one.
    pub(super) clock: Clock,
    /// The number of the node at which the past begins: the start, or a change of inputs.
    pub(super) since: u64,
    /// The current node.
    pub(super) now: State<N>,
    /// The same with its momentum, and the legs of the stages in the last steps, where momenta join the legs.
    pub(super) joined: Option<Box<Joined<N>>>,
    /// The orientation of the longest stage that goes back, as the motion has it.
    orientation: f64,
    /// How the step that led to it was solved.
    report: StepReport,
    /// How often the rows may be evaluated from one guess.
    max_iterations: u32,
}

/// A node.
#[repr(align(16))] // as the sums, see [`crate::compensated`]
#[derive(Clone, Copy, Debug)]
pub(super) struct State<const N: usize> {
    /// Position.
    pub(super) q: Compensated<N>,
    /// Velocity.
    pub(super) v: Compensated<N>,
    /// Acceleration.
    pub(super) a: [f64; N],
}

/// Where momenta join the legs: a node, and the stages.
#[derive(Clone, Debug)]
pub(super) struct Joined<const N: usize> {
    /// The current node.
    pub(super) now: momenta::Node<N>,
    /// The legs of each stage in the last steps.
    past: Vec<momenta::Past<N>>,
}

/// A stage of the step.
#[derive(Clone, Copy, Debug)]
struct Stage<C, U, const N: usize> {
    /// The length of its leg.
    h: f64,
    /// Whether it goes against the direction of the run.
    backward: bool,
    /// Whether it is the longest of these, and the first of its length.
    longest: bool,
    /// `1/h²`.
    per_square: f64,
    /// What is known since the run began.
    constants: C,
    /// The solutions of this stage in the last steps, which lie as far apart as the steps do.
    predictor: Predictor<U>,
    /// Their legs, the last first.
    past: [Leg<f64, N>; PAST],
    /// The solution of the step that is being made.
    found: U,
    /// Its leg.
    leg: Leg<f64, N>,
}

impl<S: System<N>, const N: usize> fmt::Debug for ComposedFlow<'_, S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ComposedFlow")
            .field("method", &self.method)
            .field("h", &self.h)
            .field("index", &self.index())
            .field("time", &self.time())
            .field("state", &self.now)
            .finish_non_exhaustive()
    }
}

impl<S: System<N>, const N: usize> Clone for ComposedFlow<'_, S, N> {
    fn clone(&self) -> Self {
        Self {
            system: self.system.clone(),
            stages: self.stages.clone(),
            joined: self.joined.clone(),
            ..*self
        }
    }
}

impl<const N: usize> State<N> {
    /// A node without its momentum.
    pub(super) fn of(node: &momenta::Node<N>) -> Self {
        Self {
            q: node.q,
            v: Compensated::exact(node.v),
            a: node.a,
        }
    }
}

impl<'s, S: System<N>, const N: usize> ComposedFlow<'s, S, N> {
    /// Whether momenta join the legs.
    pub(super) const BY_MOMENTA: bool = matches!(S::SYMMETRY, Symmetry::Momenta);

    /// Sets up a run with the step `h`, which is negative to run back in time. The run begins with the position and the velocity of
    /// the start and the acceleration of the continuous system there, so that the start has no error.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the step, the start or a parameter is not usable, if the start gives no velocity or the continuous system
    /// no acceleration there, or if the step of this system cannot be composed ([`SetupError::Composition`]; use [`Flow`] then).
    pub fn new(system: &'s S, h: f64, method: Composition, start: Start<N>) -> Result<Self, SetupError> {
        if !matches!(S::SYMMETRY, Symmetry::AnyLegs | Symmetry::Momenta) {
            return Err(SetupError::Composition {
                method,
                reason: S::SYMMETRY,
            });
        }
        for fraction in method.fractions() {
            Flow::check(system, fraction * h)?;
        }
        Declaration::of(system).prepare();
        let Phase { t0, q0, v0, near } = start.phase(system)?;
        let (now, joined);
        if Self::BY_MOMENTA {
            let node = Momenta::of(system).start(t0, (Compensated::exact(q0), v0), near.as_ref())?;
            now = State::of(&node);
            joined = Some(Box::new(Joined {
                now: node,
                past: Vec::new(),
            }));
        } else {
            now = State {
                q: Compensated::exact(q0),
                v: Compensated::exact(v0),
                a: start::state_acceleration(system, (t0, &q0, &v0), near.as_ref())?,
            };
            joined = None;
        }
        let mut flow = Self {
            system: Held::new(system),
            values: system.parameters(),
            method,
            h,
            stages: Vec::new(),
            clock: Clock::even(t0, h),
            since: 0,
            now,
            joined,
            orientation: 0.0,
            report: START,
            max_iterations: MAX_ITERATIONS,
        };
        flow.prepare();
        Ok(flow)
    }

    /// Makes the stages for the current step.
    pub(super) fn prepare(&mut self) {
        if let Some(joined) = &mut self.joined {
            joined.past.clear();
            joined.past.resize(self.method.stages(), momenta::Past::new());
            return;
        }
        let leg = Leg {
            t: self.clock.time(),
            q: self.now.q.hi,
            d: [0.0; N],
        };
        self.orientation = 0.0;
        self.stages.clear();
        let longest = self.method.fractions().fold(0.0, f64::min);
        let mut first = true;
        self.stages.extend(self.method.fractions().map(|fraction| {
            let h = fraction * self.h;
            let longest = fraction < 0.0 && fraction == longest && core::mem::take(&mut first);
            Stage {
                h,
                backward: fraction < 0.0,
                longest,
                per_square: (h * h).recip(),
                constants: self.system.constants(&self.system.parameters(), h),
                predictor: Predictor::new(),
                past: [leg; PAST],
                found: S::Unknown::zero(),
                leg,
            }
        }));
    }

    /// Sets how often the rows of a stage are evaluated from one guess before it is given up (60 unless set; at least 1 is
    /// taken).
    #[must_use]
    pub fn max_iterations(mut self, limit: u32) -> Self {
        self.max_iterations = limit.max(1);
        self
    }

    /// The system, with the current values of the inputs.
    #[must_use]
    pub fn system(&self) -> &S {
        &self.system
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> Composition {
        self.method
    }

    /// The step, negative when running back in time.
    #[must_use]
    pub fn h(&self) -> f64 {
        self.h
    }

    /// The number of the current node.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.clock.index()
    }

    /// The time of the current node.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// The position of the current node.
    #[must_use]
    pub fn position(&self) -> &[f64; N] {
        &self.now.q.hi
    }

    /// The velocity at the current node.
    #[must_use]
    pub fn velocity(&self) -> &[f64; N] {
        &self.now.v.hi
    }

    /// The acceleration at the current node.
    #[must_use]
    pub fn acceleration(&self) -> &[f64; N] {
        &self.now.a
    }

    /// Makes one step, of all stages.
    #[inline]
    fn solve(&mut self) -> Result<StepReport, StageError> {
        let mut state = self.now;
        let mut total = StepReport {
            iterations: 0,
            ..USUAL
        };
        // without a past nothing else tells two roots apart
        let past_is_short = self.clock.index() - self.since <= SHORT_PAST;
        let now = self.clock.time();
        let mut done = 0.0;
        // between two stages the velocity takes the halves of both at once: a sum that is waited for costs as much as a part of a stage
        let mut left = 0.0;
        for place in 0..self.stages.len() {
            let stage = &mut self.stages[place];
            let half = 0.5 * stage.h;
            let (before, a_before) = (state.q.hi, state.a);
            state.v.add(&scaled(left + half, &state.a));
            let d = Compensated {
                hi: scaled(stage.h, &state.v.hi),
                lo: scaled(stage.h, &state.v.lo),
            };
            state.q = state.q.plus(&d);
            let begun = done;
            // as the whole step, the stages begin at an exact time
            done += stage.h;
            stage.leg = Leg {
                t: now + done,
                q: state.q.hi,
                d: d.hi,
            };
            let mut step = Step::new(&*self.system, &stage.constants, stage.leg, stage.h);
            step.past_is_short = past_is_short;
            if self.clock.index() == self.since {
                step.begins = Some(Begins::Said(state.a));
            }
            step.past = Some(&stage.past);
            let (z, report) = match step.solve(&mut stage.predictor, self.max_iterations) {
                Ok(solution) => solution,
                Err(cause) => return Err(self.failed(place, &state, cause)),
            };
            let per_square = stage.per_square;
            state.a = scaled(per_square, &step.second_difference(&z));
            if stage.backward && backward::in_question(report) {
                let from = Point {
                    t: now + begun,
                    q: before,
                    v: kicked(&state.v.hi, -half, &a_before),
                    a: a_before,
                };
                if !backward::continues(&*self.system, stage.h, &from, &state.a) {
                    let h = stage.h;
                    let time = self.time_of_stage(place);
                    return Err(self.refused(place, StageFailure::Jump { time, h }));
                }
            }
            left = half;
            if !kicked(&state.v.hi, half, &state.a).iter().all(|v| v.is_finite()) {
                let cause = step.any().not_finite(&z);
                return Err(self.failed(place, &state, cause));
            }
            let turned = stage.longest && step.any().orientation(&z) != self.orientation;
            stage.found = z;
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
                let mut there = state;
                there.v.hi = kicked(&state.v.hi, half, &state.a);
                self.orientation = self.reoriented(place, &there)?;
            }
        }
        state.v.add(&scaled(left, &state.a));
        for stage in &mut self.stages {
            stage.predictor.push(&stage.found);
            stage.past.rotate_right(1);
            stage.past[0] = stage.leg;
        }
        (self.now, self.report) = (state, total);
        self.clock.tick();
        Ok(total)
    }

    /// The same where momenta join the legs.
    fn solve_by_momenta(&mut self) -> Result<StepReport, StageError> {
        let Some(joined) = &self.joined else {
            return Ok(START); // there is one where this is called
        };
        let mut node = joined.now.clone();
        let (mut iterations, mut done) = (0, 0.0);
        let mut increments = Vec::with_capacity(joined.past.len());
        let legs = Momenta::of(&*self.system);
        for (place, (fraction, past)) in self.method.fractions().zip(&joined.past).enumerate() {
            let h = fraction * self.h;
            done += h;
            // the last stage ends where the step does
            let last = place + 1 == self.method.stages();
            let t = if last {
                self.clock.time_of(self.clock.index() + 1)
            } else {
                self.clock.time() + done
            };
            let leg = legs.leg(&node, (h, t), past);
            let (next, d, count) = leg.map_err(|failure| self.unjoined(place, failure))?;
            increments.push(d);
            iterations += count;
            node = next;
        }
        let complete = legs.complete(&mut node);
        complete
            .map_err(|cause| self.unjoined(self.method.stages() - 1, momenta::Failure::NotSolved(cause)))?;
        self.now = State::of(&node);
        if let Some(joined) = &mut self.joined {
            for (past, d) in joined.past.iter_mut().zip(&increments) {
                past.push(d);
            }
            joined.now = node;
        }
        self.report = StepReport { iterations, ..USUAL };
        self.clock.tick();
        Ok(self.report)
    }

    /// The error of a stage where momenta join the legs.
    #[cold]
    fn unjoined(&self, place: usize, failure: momenta::Failure) -> StageError {
        let fraction = self.method.fractions().nth(place).unwrap_or(f64::NAN);
        let (time, h) = (self.time_of_stage(place), fraction * self.h);
        StageError::new(FailedStage {
            method: self.method,
            index: self.clock.index(),
            stage: place + 1,
            backward: fraction < 0.0,
            cause: match failure {
                momenta::Failure::NotSolved(cause) => StageFailure::Leg { time, h, cause },
                momenta::Failure::Singularity => StageFailure::Singularity { time, h },
                momenta::Failure::Jump => StageFailure::Jump { time, h },
            },
        })
    }

    /// The time at the end of a stage.
    fn time_of_stage(&self, place: usize) -> f64 {
        let done: f64 = self.method.fractions().take(place + 1).sum();
        self.time() + done * self.h
    }

    /// The orientation of the motion at the end of a stage, if the stage has the same: at the first step of a run, and
    /// where the continuous system itself passes a singularity.
    #[cold]
    fn reoriented(&self, place: usize, state: &State<N>) -> Result<f64, StageError> {
        let stage = &self.stages[place];
        let node = Point {
            t: self.time_of_stage(place),
            q: state.q.hi,
            v: state.v.hi,
            a: state.a,
        };
        let short = backward::short_orientation(&*self.system, stage.h, &node);
        let step = Step::new(&*self.system, &stage.constants, stage.leg, stage.h);
        let same = step.any().orientation(&stage.found) == short;
        if same
            && !(self.clock.index() == self.since
                && backward::passes_singularity(&*self.system, stage.h, &node))
        {
            return Ok(short);
        }
        let (time, h) = (self.time_of_stage(place), stage.h);
        Err(self.refused(place, StageFailure::Singularity { time, h }))
    }

    /// The error of a stage whose solution cannot belong to the motion.
    #[cold]
    fn refused(&self, place: usize, cause: StageFailure) -> StageError {
        StageError::new(FailedStage {
            method: self.method,
            index: self.clock.index(),
            stage: place + 1,
            backward: true,
            cause,
        })
    }

    /// The error of a stage that could not be made.
    #[cold]
    fn failed(&self, place: usize, state: &State<N>, cause: NewtonFailure) -> StageError {
        let stage = &self.stages[place];
        let step = Step::new(&*self.system, &stage.constants, stage.leg, stage.h);
        let mut q0 = state.q.hi;
        for (q, d) in q0.iter_mut().zip(&stage.leg.d) {
            *q -= d;
        }
        let failing = Failing {
            index: self.clock.index(),
            time: self.time_of_stage(place),
            q0,
        };
        StageError::new(FailedStage {
            method: self.method,
            index: self.clock.index(),
            stage: place + 1,
            backward: stage.backward,
            cause: StageFailure::Step(step.any().error(&failing, cause)),
        })
    }
}

/// A vector times a number.
#[inline]
fn scaled<const N: usize>(factor: f64, x: &[f64; N]) -> [f64; N] {
    let mut product = *x;
    for x in &mut product {
        *x *= factor;
    }
    product
}

/// A velocity, and an acceleration for some time.
#[inline]
fn kicked<const N: usize>(v: &[f64; N], h: f64, a: &[f64; N]) -> [f64; N] {
    let mut after = *v;
    for (v, a) in after.iter_mut().zip(a) {
        *v += h * a;
    }
    after
}

/// The report of the start.
const START: StepReport = StepReport {
    iterations: 0,
    stop: Stop::Start,
    guess: Guess::Given,
};

/// How a stage is solved as a rule.
const USUAL: StepReport = StepReport {
    iterations: 1,
    stop: Stop::Update,
    guess: Guess::Predicted,
};

impl<S: System<N>, const N: usize> Run for ComposedFlow<'_, S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.system.kernel()
    }

    fn values(&self) -> &[f64] {
        self.values.as_ref()
    }

    /// Makes one step, of all stages. The report has the number of evaluations of all stages, and the stop and the guess of the
    /// first stage in which they were not the usual ones.
    ///
    /// # Errors
    ///
    /// [`RunError::Stage`] if no solution of a stage is found, or one that cannot belong to the motion. The flow stays
    /// where it was.
    #[inline]
    fn step(&mut self, _: f64) -> Result<StepReport, RunError> {
        if Self::BY_MOMENTA {
            Ok(self.solve_by_momenta()?)
        } else {
            Ok(self.solve()?)
        }
    }

    #[inline]
    fn tell(&self, node: NodeMut<'_>) {
        let (t, q, v, a) = (self.clock.time(), self.now.q.hi, self.now.v.hi, self.now.a);
        node.write(&AnyNode {
            index: self.clock.index(),
            t,
            q: &q,
            v: &v,
            a: &a,
            force: &continuous_force(&Declaration::of(&*self.system), &Point { t, q, v, a }),
            energy: self.system.energy(t, &q, &v),
            iterations: self.report.iterations,
            stop: self.report.stop,
        });
    }

    fn clock(&self) -> &Clock {
        &self.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.clock
    }

    /// Turns round in time: the step becomes `-h`. The step is symmetric in time, so the run retraces its nodes to rounding.
    fn reverse(&mut self) -> Result<(), RunError> {
        self.clock.turn();
        self.since = 0;
        self.h = -self.h;
        self.prepare();
        self.report = START;
        Ok(())
    }

    /// The regularity of the equations of the last step, in the stage where they are least regular. `None` if momenta join the legs,
    /// because no regularity is computed then.
    fn regularity(&self) -> Option<Regularity> {
        if self.report.stop == Stop::Start || Self::BY_MOMENTA {
            return None;
        }
        let of_stage = |stage: &Stage<_, _, N>| {
            let step = Step::new(&*self.system, &stage.constants, stage.leg, stage.h);
            Regularity::of(
                self.system.kernel(),
                stage.h,
                stage.leg.any(),
                &step.second_difference(&stage.found),
            )
        };
        // not a number counts as the least
        let condition =
            |at: &Regularity| (at.forward / at.largest_forward).min(at.backward / at.largest_backward);
        let order = |at: &Regularity| {
            let known = at.forward.is_finite() && at.backward.is_finite();
            if known { condition(at) } else { -1.0 }
        };
        self.stages
            .iter()
            .map(of_stage)
            .min_by(|left, right| order(left).total_cmp(&order(right)))
    }
}

impl<S: System<N>, const N: usize> Stepper<N> for ComposedFlow<'_, S, N> {
    #[inline]
    fn run(&self) -> &dyn Run {
        self
    }

    #[inline]
    fn run_mut(&mut self) -> &mut dyn Run {
        self
    }
}

impl<S: System<N>, const N: usize> Iterator for ComposedFlow<'_, S, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<S: System<N>, const N: usize> FusedIterator for ComposedFlow<'_, S, N> {}
