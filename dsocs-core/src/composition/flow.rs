//! The flow of a composed step.

#![allow(clippy::float_cmp)] // signs and fractions are kept as they are

use core::fmt;
use core::iter::FusedIterator;

use super::backward;
use super::error::{FailedStage, StageError, StageFailure};
use super::method::Composition;
use super::symmetry::Symmetry;
use crate::clock::Clock;
use crate::compensated::Compensated;
use crate::error::{FailedStep, NewtonFailure, RunError, SetupError, StepError};
use crate::flow::{Flow, MAX_ITERATIONS, SHORT_PAST};
use crate::regularity::Regularity;
use crate::start;
use crate::step::newton::Stop;
use crate::step::predictor::Predictor;
use crate::step::unknown::Unknown;
use crate::step::{Guess, PAST, Step, StepReport};
use crate::system::{Leg, Point, System};
use crate::trajectory::{Failure, Node, Observer, Trajectory};

/// A discrete motion in progress, of order 4, 6 or 8 (or 2).
///
/// It is used like [`Flow`]: an endless iterator of nodes, [`ComposedFlow::until`], [`ComposedFlow::stream`],
/// [`ComposedFlow::advance`]. Nodes lie a whole step `h` apart; the nodes of the stages in between are not handed out. At every node
/// position, velocity and acceleration fulfil the kinematic constraints, and the force is that of the continuous system there.
///
/// ```
/// use dsocs_core::{ComposedFlow, Composition, dsocs};
///
/// /// An oscillator.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
/// }]
/// struct Oscillator {}
///
/// let mut flow = ComposedFlow::new(&Oscillator {}, 0.25, Composition::KAHAN_LI_8, [1.0], [0.0])?;
/// let trajectory = flow.until(10.0)?;
/// assert!((trajectory.nodes[40].q[0] - 10.0_f64.cos()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Rounding
///
/// Position and velocity at the nodes are compensated sums. A stage adds to them products that were rounded once, `h v` and
/// `h a / 2`; these errors are of the size of those of the solved accelerations, and no larger ones add up. Turned round with
/// [`ComposedFlow::reverse`] a flow adds the same products with the opposite sign, and returns to rounding.
pub struct ComposedFlow<'s, S: System<N>, const N: usize> {
    /// The system.
    system: &'s S,
    /// The method.
    method: Composition,
    /// The step.
    h: f64,
    /// Its stages, in order.
    stages: Vec<Stage<S::Constants<f64>, S::Unknown<f64>, N>>,
    /// The clock.
    clock: Clock,
    /// The current node.
    now: State<N>,
    /// Its number.
    index: u64,
    /// The orientation of the longest stage that goes back, as the motion has it.
    orientation: f64,
    /// How the step that led to it was solved.
    report: StepReport,
    /// Whether the current node has been handed out.
    handed: bool,
    /// How often the rows may be evaluated from one guess.
    max_iterations: u32,
    /// Whether other roots are looked for wherever the rows bend.
    watchful: bool,
    /// Whether the iterator has ended.
    ended: bool,
}

/// A node.
#[repr(align(16))] // as the sums, see [`crate::compensated`]
#[derive(Clone, Copy, Debug)]
struct State<const N: usize> {
    /// Position.
    q: Compensated<N>,
    /// Velocity.
    v: Compensated<N>,
    /// Acceleration.
    a: [f64; N],
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
            .field("index", &self.index)
            .field("time", &self.time())
            .field("state", &self.now)
            .finish_non_exhaustive()
    }
}

impl<S: System<N>, const N: usize> Clone for ComposedFlow<'_, S, N> {
    fn clone(&self) -> Self {
        Self {
            stages: self.stages.clone(),
            ..*self
        }
    }
}

impl<'s, S: System<N>, const N: usize> ComposedFlow<'s, S, N> {
    /// Sets up a run from a position and a velocity at the time 0, with the step `h`, which is negative to run back in time.
    /// The acceleration at the start is that of the continuous system, so that the start has no error.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the step, the start or a parameter is not usable, if the continuous system has no acceleration at the
    /// start, or if the step of this system cannot be composed ([`SetupError::Composition`]; any system's can with
    /// [`Composition::SINGLE`] by [`Flow`]).
    pub fn new(
        system: &'s S,
        h: f64,
        method: Composition,
        q0: [f64; N],
        v0: [f64; N],
    ) -> Result<Self, SetupError> {
        if S::SYMMETRY != Symmetry::AnyLegs {
            return Err(SetupError::Composition {
                method,
                reason: S::SYMMETRY,
            });
        }
        for fraction in method.fractions() {
            Flow::check(system, fraction * h)?;
        }
        let a0 = start::state_acceleration(system, &q0, &v0)?;
        let mut flow = Self {
            system,
            method,
            h,
            stages: Vec::new(),
            clock: Clock::new(0.0, h),
            now: State {
                q: Compensated::exact(q0),
                v: Compensated::exact(v0),
                a: a0,
            },
            index: 0,
            orientation: 0.0,
            report: START,
            handed: false,
            max_iterations: MAX_ITERATIONS,
            watchful: false,
            ended: false,
        };
        flow.prepare();
        Ok(flow)
    }

    /// Makes the stages for the current step.
    fn prepare(&mut self) {
        let leg = Leg {
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
                constants: self.system.constants(h),
                predictor: Predictor::new(),
                past: [leg; PAST],
                found: S::Unknown::zero(),
                leg,
            }
        }));
    }

    /// Sets the time of the start, which is 0 unless set.
    ///
    /// # Errors
    ///
    /// [`SetupError::StartTime`] if it is not finite.
    pub fn at(mut self, t0: f64) -> Result<Self, SetupError> {
        if !t0.is_finite() {
            return Err(SetupError::StartTime { t0 });
        }
        self.clock = Clock::new(t0, self.h);
        Ok(self)
    }

    /// Sets how often the rows of a stage are evaluated from one guess before it is given up (60 unless set; at least 1 is
    /// taken).
    #[must_use]
    pub fn max_iterations(mut self, limit: u32) -> Self {
        self.max_iterations = limit.max(1);
        self
    }

    /// Looks for a second solution wherever the rows bend on the way to the first; see [`Flow::watchful`].
    #[must_use]
    pub fn watchful(mut self) -> Self {
        self.watchful = true;
        self
    }

    /// The system.
    #[must_use]
    pub fn system(&self) -> &'s S {
        self.system
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
        self.index
    }

    /// The time of the current node.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.time(self.index)
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

    /// The current node, with force and energy.
    #[must_use]
    pub fn node(&self) -> Node<N> {
        let (q, v, a) = (self.now.q.hi, self.now.v.hi, self.now.a);
        Node {
            index: self.index,
            t: self.time(),
            q,
            v,
            a,
            force: self.system.continuous_force(&Point { q, v, a }),
            energy: self.system.energy(&q, &v),
            iterations: self.report.iterations,
            stop: self.report.stop,
        }
    }

    /// The observed expressions of the declaration at a node; see [`Flow::observe`].
    pub fn observe(&self, node: &Node<N>, out: &mut [f64]) {
        crate::flow::observe(self.system, node, out);
    }

    /// Makes one step, of all stages. Nothing is allocated. The report counts the evaluations of all stages and tells the stop
    /// and the guess of the first that is not the usual one.
    ///
    /// # Errors
    ///
    /// [`StageError`] if a stage has no solution that is found, or one that cannot belong to the motion. The flow stays where
    /// it was.
    #[inline]
    pub fn advance(&mut self) -> Result<StepReport, StageError> {
        let mut state = self.now;
        let mut total = StepReport {
            iterations: 0,
            ..USUAL
        };
        // without a past nothing else tells two roots apart
        let watchful = self.watchful || self.index <= SHORT_PAST;
        for place in 0..self.stages.len() {
            let stage = &mut self.stages[place];
            let half = 0.5 * stage.h;
            let from = Point {
                q: state.q.hi,
                v: state.v.hi,
                a: state.a,
            };
            state.v.add(&state.a.map(|a| half * a));
            let d = Compensated {
                hi: state.v.hi.map(|v| stage.h * v),
                lo: state.v.lo.map(|v| stage.h * v),
            };
            state.q = state.q.plus(&d);
            stage.leg = Leg {
                q: state.q.hi,
                d: d.hi,
            };
            let mut step = Step::new(self.system, &stage.constants, stage.leg, stage.h);
            step.watchful = watchful;
            step.past = Some(&stage.past);
            let (z, report) = match step.solve(&mut stage.predictor, self.max_iterations) {
                Ok(solution) => solution,
                Err(cause) => return Err(self.failed(place, &state, cause)),
            };
            let per_square = stage.per_square;
            let a = step.second_difference(&z).map(|e| e * per_square);
            if stage.backward
                && backward::in_question(report)
                && !backward::continues(self.system, stage.h, &from, &a)
            {
                let h = stage.h;
                let time = self.time_of_stage(place);
                return Err(self.refused(place, StageFailure::Jump { time, h }));
            }
            state.a = a;
            state.v.add(&state.a.map(|a| half * a));
            if !state.v.hi.iter().all(|v| v.is_finite()) {
                let cause = step.not_finite(&z);
                return Err(self.failed(place, &state, cause));
            }
            let turned = stage.longest && backward::orientation(&step, &z) != self.orientation;
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
                self.orientation = self.reoriented(place, &state)?;
            }
        }
        for stage in &mut self.stages {
            stage.predictor.push(&stage.found);
            stage.past.rotate_right(1);
            stage.past[0] = stage.leg;
        }
        (self.now, self.report, self.handed) = (state, total, false);
        self.index += 1;
        Ok(total)
    }

    /// Turns round: the step becomes `-h`, and time runs back from where it was. The current node becomes number 0 and is not
    /// handed out again, if it was.
    pub fn reverse(&mut self) {
        self.clock.turn(self.index);
        self.h = -self.h;
        self.prepare();
        (self.index, self.report, self.ended) = (0, START, false);
    }

    /// Runs up to the last node at or before `t` (at or after, for a negative step) and collects the nodes, from the one after
    /// the last handed out; see [`Flow::until`].
    ///
    /// # Errors
    ///
    /// [`Failure`] with the nodes so far if a step fails, or if `t` lies behind, is infinite or is not a number.
    pub fn until(&mut self, t: f64) -> Result<Trajectory<N>, Failure<N>> {
        let mut trajectory = Trajectory::default();
        let result = if t.is_infinite() {
            Err(RunError::Until { until: t })
        } else {
            self.stream(t, &mut trajectory)
        };
        match result {
            Ok(()) => Ok(trajectory),
            Err(error) => Err(Failure { error, trajectory }),
        }
    }

    /// Runs like [`ComposedFlow::until`], but hands each node to an observer and keeps none. An infinite `t` is allowed: the
    /// observer ends the run.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a step fails, or if `t` lies behind or is not a number.
    pub fn stream<O: Observer<N> + ?Sized>(&mut self, t: f64, observer: &mut O) -> Result<(), RunError> {
        if t.is_nan() {
            return Err(RunError::Until { until: t });
        }
        let last = match self.clock.last_index(t) {
            Some(last) if last >= self.index => last,
            _ => {
                return Err(RunError::Behind {
                    until: t,
                    time: self.time(),
                    h: self.h,
                });
            }
        };
        while self.upcoming() <= last {
            if observer.node(&self.step()?).is_break() {
                break;
            }
        }
        Ok(())
    }

    /// The number of the node that is handed out next.
    fn upcoming(&self) -> u64 {
        self.index + u64::from(self.handed)
    }

    /// The next node of the iterator.
    fn step(&mut self) -> Result<Node<N>, StageError> {
        if self.handed {
            self.advance()?;
        }
        self.handed = true;
        Ok(self.node())
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
        let (q, v, a) = (&state.q.hi, &state.v.hi, &state.a);
        let short = backward::short_orientation(self.system, stage.h, q, v, a);
        let step = Step::new(self.system, &stage.constants, stage.leg, stage.h);
        let same = backward::orientation(&step, &stage.found) == short;
        if same && !(self.index == 0 && backward::passes_singularity(self.system, stage.h, q, v, a)) {
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
            stage: place + 1,
            backward: true,
            cause,
        })
    }

    /// The error of a stage that could not be made.
    #[cold]
    fn failed(&self, place: usize, state: &State<N>, cause: NewtonFailure) -> StageError {
        let stage = &self.stages[place];
        let step = Step::new(self.system, &stage.constants, stage.leg, stage.h);
        let unknowns = |values: &[f64]| {
            let mut z = self.system.unknown(&[0.0; N], &[]);
            for (z, &value) in z.as_mut().iter_mut().zip(values) {
                *z = value;
            }
            z
        };
        let next = |e: [f64; N]| (0..N).map(|i| stage.leg.q[i] + (stage.leg.d[i] + e[i])).collect();
        let e = step.second_difference(&unknowns(&cause.unknowns));
        let other = if cause.other.is_empty() {
            Vec::new()
        } else {
            next(step.second_difference(&unknowns(&cause.other)))
        };
        let q0 = (0..N).map(|i| state.q.hi[i] - stage.leg.d[i]).collect();
        StageError::new(FailedStage {
            method: self.method,
            stage: place + 1,
            backward: stage.backward,
            cause: StageFailure::Step(StepError::new(FailedStep {
                index: self.index,
                time: self.time_of_stage(place),
                h: stage.h,
                q0,
                q1: stage.leg.q.to_vec(),
                q2: next(e),
                other,
                regularity: Regularity::of(self.system, stage.h, &stage.leg, &e),
                coordinates: S::COORDINATES.map(|coordinate| coordinate.name).to_vec(),
                cause,
            })),
        })
    }
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

impl<S: System<N>, const N: usize> Iterator for ComposedFlow<'_, S, N> {
    type Item = Result<Node<N>, StageError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let node = self.step();
        self.ended = node.is_err();
        Some(node)
    }
}

impl<S: System<N>, const N: usize> FusedIterator for ComposedFlow<'_, S, N> {}
