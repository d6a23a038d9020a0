//! The discrete flow: step after step, as an iterator, up to a time, or back.

use core::fmt;
use core::iter::FusedIterator;

use crate::clock::Clock;
use crate::compensated::Compensated;
use crate::error::{FailedStep, NewtonFailure, RunError, SetupError, StepError};
use crate::regularity::Regularity;
use crate::start::{self, Beginning, Start};
use crate::step::newton::Stop;
use crate::step::predictor::Predictor;
use crate::step::{Step, StepReport};
use crate::system::{Leg, Point, System};
use crate::trajectory::{Failure, Node, Observer, Trajectory};

/// How often the rows of a step are evaluated from one guess unless [`Flow::max_iterations`] says otherwise,
/// parts of updates apart.
pub(crate) const MAX_ITERATIONS: u32 = 60;

/// The first steps, which have too short a past to tell by it which of two roots continues the motion.
pub(crate) const SHORT_PAST: u64 = 5;

/// A discrete motion in progress.
///
/// The flow is an endless iterator of nodes. Node `k` is handed out once the step with the middle node `k` is
/// solved, since its velocity, acceleration and constraint force need the node after it, too. After a step
/// without a solution the iterator ends.
pub struct Flow<'s, S: System<N>, const N: usize> {
    /// The system.
    system: &'s S,
    /// What is known since the run began.
    constants: S::Constants<f64>,
    /// The step.
    h: f64,
    /// The start.
    beginning: Beginning<N>,
    /// The clock.
    clock: Clock,
    /// The last node.
    q: Compensated<N>,
    /// The increment that led to it.
    d: Compensated<N>,
    /// The number of the last node, which is the next step's middle node.
    middle: u64,
    /// The last step that was solved.
    solved: Option<Solved<N>>,
    /// Whether the node of the start has been handed out or passed.
    started: bool,
    /// The past solutions.
    predictor: Predictor<S::Unknown<f64>>,
    /// How often the rows may be evaluated from one guess.
    max_iterations: u32,
    /// Whether other roots are looked for wherever the rows bend.
    watchful: bool,
    /// Whether the iterator has ended.
    ended: bool,
}

// by hand, as `Clone` is, because a derivation would ask the system for as much
impl<S: System<N>, const N: usize> fmt::Debug for Flow<'_, S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Flow")
            .field("h", &self.h)
            .field("index", &self.middle)
            .field("time", &self.time())
            .field("leg", &self.leg())
            .finish_non_exhaustive()
    }
}

impl<S: System<N>, const N: usize> Clone for Flow<'_, S, N> {
    fn clone(&self) -> Self {
        Self { ..*self }
    }
}

/// A step that was solved.
#[repr(align(16))] // as the sums, see [`crate::compensated`]
#[derive(Clone, Copy, Debug)]
struct Solved<const N: usize> {
    /// The number of its middle node.
    index: u64,
    /// Its first two nodes.
    leg: Leg<f64, N>,
    /// The second difference.
    e: [f64; N],
    /// How it was solved.
    report: StepReport,
}

impl<'s, S: System<N>, const N: usize> Flow<'s, S, N> {
    /// Sets up a run with the step `h`, which is negative to run back in time.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the step, the start or a parameter is not usable, or if the start needs the initial
    /// acceleration and the continuous system has none.
    pub fn new(system: &'s S, h: f64, start: Start<N>) -> Result<Self, SetupError> {
        Self::check(system, h)?;
        let beginning = start.begin(system, h)?;
        Ok(Self {
            system,
            constants: system.constants(h),
            h,
            clock: Clock::new(beginning.t0, h),
            q: beginning.q,
            d: beginning.d,
            beginning,
            middle: 1,
            solved: None,
            started: false,
            predictor: Predictor::new(),
            max_iterations: MAX_ITERATIONS,
            watchful: false,
            ended: false,
        })
    }

    /// Checks the step and the parameters.
    pub(crate) fn check(system: &S, h: f64) -> Result<(), SetupError> {
        if !h.is_finite() || h == 0.0 {
            return Err(SetupError::Step { h });
        }
        if !(h * h).is_normal() {
            return Err(SetupError::StepRange { h });
        }
        let values = (0..).map_while(|index| system.parameter(index));
        for (parameter, value) in S::PARAMETERS.iter().zip(values) {
            if !value.is_finite() {
                return Err(SetupError::Parameter {
                    name: parameter.name,
                    value,
                });
            }
        }
        Ok(())
    }

    /// Sets how often the rows of a step are evaluated from one guess before it is given up (60 unless set; at
    /// least 1 is taken).
    #[must_use]
    pub fn max_iterations(mut self, limit: u32) -> Self {
        self.max_iterations = limit.max(1);
        self
    }

    /// Looks for a second solution wherever the rows bend on the way to the first, not only where it would be close.
    ///
    /// Where two solutions are near each other the flow follows the one whose Jacobian continues those of the steps before,
    /// or refuses the step ([`crate::StepFailure::AmbiguousRoot`]). It looks for the other one if the first updates say
    /// that it is about as near as the unknown is large. A motion with kinks can come near to a solution that is farther
    /// away than that; a watchful flow looks for those, too, and is slower where a step takes three evaluations or more.
    /// Systems that name a factor (`branch = divide(factor)`) are not watched.
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

    /// The step, negative when running back in time.
    #[must_use]
    pub fn h(&self) -> f64 {
        self.h
    }

    /// The number of the last node that is known, the middle node of the next step.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.middle
    }

    /// The time of the last node that is known.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.time(self.middle)
    }

    /// The last node that is known: the second node of the start, then the one that [`Flow::advance`] found.
    #[must_use]
    pub fn position(&self) -> &[f64; N] {
        &self.q.hi
    }

    /// The leg that the next step begins with: the last node and the increment that led to it.
    #[must_use]
    pub fn leg(&self) -> Leg<f64, N> {
        Leg {
            q: self.q.hi,
            d: self.d.hi,
        }
    }

    /// Solves one step and no more: neither velocity, force nor energy is computed. Nothing is allocated.
    ///
    /// # Errors
    ///
    /// [`StepError`] if the step has no solution that is found. The flow stays where it was.
    #[inline]
    pub fn advance(&mut self) -> Result<StepReport, StepError> {
        self.solve()
    }

    /// The node in the middle of the last step that was solved, with velocity, acceleration, force and energy;
    /// `None` before the first step.
    #[must_use]
    pub fn node(&self) -> Option<Node<N>> {
        self.solved.map(|solved| self.node_of(solved))
    }

    /// The observed expressions of the declaration at a node, in the order of [`System::OBSERVABLES`].
    ///
    /// Expressions beyond the end of `out` are left out.
    pub fn observe(&self, node: &Node<N>, out: &mut [f64]) {
        observe(self.system, node, out);
    }

    /// Turns round: the step becomes `-h`, the two last nodes change places with the sums carried along, and
    /// time runs back from where it was.
    ///
    /// The last node that is known becomes number 0. It is not handed out again; the first node that is, is
    /// number 1, the one that was handed out last.
    pub fn reverse(&mut self) {
        self.clock.turn(self.middle);
        self.h = -self.h;
        self.constants = self.system.constants(self.h);
        self.d = self.d.negated();
        self.q = self.q.plus(&self.d);
        self.predictor.turn();
        (self.middle, self.started, self.solved, self.ended) = (1, true, None, false);
    }

    /// Runs up to the last node at or before `t` (at or after, for a negative step) and collects the nodes,
    /// from the one after the last handed out.
    ///
    /// A node whose time is `t` to within rounding counts as at `t`: 500 with the step 0.1 gives node 5000.
    ///
    /// # Errors
    ///
    /// [`Failure`] with the nodes so far if a step fails, or if `t` lies behind, is infinite or is not a
    /// number.
    pub fn until(&mut self, t: f64) -> Result<Trajectory<N>, Failure<N>> {
        let mut trajectory = Trajectory::default();
        let result = match self.last_index(t) {
            Ok(_) if t.is_infinite() => Err(RunError::Until { until: t }),
            Ok(last) => self.run(last, &mut trajectory),
            Err(error) => Err(error),
        };
        match result {
            Ok(()) => Ok(trajectory),
            Err(error) => Err(Failure { error, trajectory }),
        }
    }

    /// Runs like [`Flow::until`], but hands each node to an observer and keeps none. An infinite `t` is
    /// allowed: the observer ends the run.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a step fails, or if `t` lies behind or is not a number.
    pub fn stream<O: Observer<N> + ?Sized>(&mut self, t: f64, observer: &mut O) -> Result<(), RunError> {
        let last = self.last_index(t)?;
        self.run(last, observer)
    }

    /// Solves the next step and moves on.
    #[inline]
    fn solve(&mut self) -> Result<StepReport, StepError> {
        let leg = self.leg();
        let mut step = Step::new(self.system, &self.constants, leg, self.h);
        // without a past nothing else tells two roots apart
        step.watchful = self.watchful || self.middle <= SHORT_PAST;
        let (z, report) = match step.solve(&mut self.predictor, self.max_iterations) {
            Ok(solution) => solution,
            Err(cause) => return Err(self.failed(cause)),
        };
        let e = step.second_difference(&z);
        let mut d = self.d;
        d.add(&e);
        let q = self.q.plus(&d);
        if !q.hi.iter().all(|q| q.is_finite()) {
            return Err(self.failed(step.not_finite(&z)));
        }
        self.predictor.push(&z);
        self.solved = Some(Solved {
            index: self.middle,
            leg,
            e,
            report,
        });
        (self.q, self.d, self.started) = (q, d, true);
        self.middle += 1;
        Ok(report)
    }

    /// The middle node of a step.
    fn node_of(
        &self,
        Solved {
            index,
            leg,
            e,
            report,
        }: Solved<N>,
    ) -> Node<N> {
        let known = self.system.known(&self.constants, &leg);
        let Point { q, v, a } = self.system.point(&self.constants, &known, &leg, &e);
        Node {
            index,
            t: self.clock.time(index),
            q: leg.q,
            v,
            a,
            force: self.system.force(&self.constants, &known, &leg, &e),
            energy: self.system.energy(&q, &v),
            iterations: report.iterations,
            stop: report.stop,
        }
    }

    /// Hands the nodes up to number `last` to an observer.
    fn run<O: Observer<N> + ?Sized>(&mut self, last: u64, observer: &mut O) -> Result<(), RunError> {
        while self.upcoming() <= last {
            let node = self.step()?;
            if observer.node(&node).is_break() {
                break;
            }
        }
        Ok(())
    }

    /// The number of the last node at or before `t`.
    fn last_index(&self, t: f64) -> Result<u64, RunError> {
        if t.is_nan() {
            return Err(RunError::Until { until: t });
        }
        // what has been handed out cannot be taken back
        let current = self.upcoming().saturating_sub(1);
        match self.clock.last_index(t) {
            Some(last) if last >= current => Ok(last),
            _ => Err(RunError::Behind {
                until: t,
                time: self.clock.time(current),
                h: self.h,
            }),
        }
    }

    /// The number of the node that the iterator hands out next.
    fn upcoming(&self) -> u64 {
        if self.started { self.middle } else { 0 }
    }

    /// The next node of the iterator.
    fn step(&mut self) -> Result<Node<N>, StepError> {
        if self.upcoming() == 0 {
            self.started = true;
            return Ok(self.first_node());
        }
        self.solve()?;
        Ok(self.node().unwrap_or_else(|| self.first_node()))
    }

    /// The node of the start.
    fn first_node(&self) -> Node<N> {
        let Beginning { q0, v0, a0, t0, .. } = self.beginning;
        let a = a0
            .or_else(|| Some(start::acceleration(self.system, &q0, &v0).ok()?.0))
            .unwrap_or([f64::NAN; N]);
        Node {
            index: 0,
            t: t0,
            q: q0,
            v: v0,
            a,
            force: self.system.continuous_force(&Point { q: q0, v: v0, a }),
            energy: self.system.energy(&q0, &v0),
            iterations: 0,
            stop: Stop::Start,
        }
    }

    /// The error of the step that begins with the current leg.
    #[cold]
    fn failed(&self, cause: NewtonFailure) -> StepError {
        let leg = self.leg();
        let step = Step::new(self.system, &self.constants, leg, self.h);
        let unknowns = |values: &[f64]| {
            let mut z = self.system.unknown(&[0.0; N], &[]);
            for (z, &value) in z.as_mut().iter_mut().zip(values) {
                *z = value;
            }
            z
        };
        let e = step.second_difference(&unknowns(&cause.unknowns));
        let other = step.second_difference(&unknowns(&cause.other));
        let next = |e: [f64; N]| (0..N).map(|i| leg.q[i] + (leg.d[i] + e[i])).collect();
        StepError::new(FailedStep {
            index: self.middle,
            time: self.time(),
            h: self.h,
            q0: self.q.plus(&self.d.negated()).hi.to_vec(),
            q1: leg.q.to_vec(),
            q2: next(e),
            other: if cause.other.is_empty() {
                Vec::new()
            } else {
                next(other)
            },
            regularity: Regularity::of(self.system, self.h, &leg, &e),
            coordinates: S::COORDINATES.map(|coordinate| coordinate.name).to_vec(),
            cause,
        })
    }
}

/// The observed expressions at a node, as many as there is room for.
pub(crate) fn observe<S: System<N>, const N: usize>(system: &S, node: &Node<N>, out: &mut [f64]) {
    let count = S::OBSERVABLES.len();
    if out.len() >= count {
        system.observe(&node.point(), &mut out[..count]);
    } else {
        let mut all = vec![0.0; count];
        system.observe(&node.point(), &mut all);
        out.copy_from_slice(&all[..out.len()]);
    }
}

impl<S: System<N>, const N: usize> Iterator for Flow<'_, S, N> {
    type Item = Result<Node<N>, StepError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let node = self.step();
        self.ended = node.is_err();
        Some(node)
    }
}

impl<S: System<N>, const N: usize> FusedIterator for Flow<'_, S, N> {}

mod certify;
mod choose;
mod exchange;
mod forces;
pub use choose::Roots;
pub(crate) use exchange::State;
pub use forces::multipliers;
#[cfg(test)]
mod tests;
