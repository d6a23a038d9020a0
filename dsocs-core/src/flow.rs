//! The discrete flow: a run by the paper's step.

use core::fmt;
use core::iter::FusedIterator;

use crate::compensated::Compensated;
use crate::compiled::Report;
use crate::declaration::Declaration;
use crate::error::{NewtonFailure, SetupError, StepError};
use crate::held::Held;
use crate::kernel::Kernel;
use crate::regularity::Regularity;
use crate::run::{self, Clock, Node, NodeMut, RunError, Stepper};
use crate::start::{self, Beginning, Start};
use crate::step::newton::Stop;
use crate::step::predictor::Predictor;
use crate::step::{Begins, Failing, Step, StepReport};
use crate::system::{Leg, Point, System};

/// How often the rows of a step are evaluated from one guess unless [`Flow::max_iterations`] says otherwise,
/// parts of updates apart.
pub(crate) const MAX_ITERATIONS: u32 = 60;

/// The first steps, which have too short a past to tell by it which of two roots continues the motion.
pub(crate) const SHORT_PAST: u64 = 5;

/// A run of the discrete system, step by step.
///
/// The functions that drive it are those of [`Stepper`]. The velocity, the acceleration and the constraint force at node `k` also depend on
/// the next node. So node `k` is handed out when the step with the middle node `k` is solved, and [`Flow::position`] is always one node
/// ahead of [`Stepper::node`].
///
/// # Back in time
///
/// [`Stepper::reverse`] changes the step to `-h` and exchanges the last two nodes, together with their compensated sums. The run back
/// is the same discretization with the step `-h`. If the step is symmetric in time, the run back retraces the nodes to rounding. With the
/// paper's maps, and with the default maps, the step is symmetric if the mass matrix is constant. Otherwise the run back is another motion,
/// which differs by the discretization error.
pub struct Flow<'s, S: System<N>, const N: usize> {
    /// The system.
    system: Held<'s, S>,
    /// The values of its parameters.
    values: S::Parameters<f64>,
    /// What is known since the run began.
    constants: S::Constants<f64>,
    /// The step.
    h: f64,
    /// The start.
    beginning: Beginning<N>,
    /// Which node is the current one.
    clock: Clock,
    /// How many nodes further the last position is that is known: one, but for the moment in which the run turns round.
    ahead: u64,
    /// The last position that is known.
    q: Compensated<N>,
    /// The increment that led to it.
    d: Compensated<N>,
    /// What a step of third order knows beside; nothing else looks at it.
    third: Third<N>,
    /// The last step that was solved.
    solved: Option<Solved<N>>,
    /// The past solutions.
    predictor: Predictor<S::Unknown<f64>>,
    /// How often the rows may be evaluated from one guess.
    max_iterations: u32,
    /// The number of the position at which the past begins that steps go on from: that of the start, or of a change of inputs.
    since: u64,
    /// The system as it was on the last leg, where inputs have changed since.
    before: Option<Held<'s, S>>,
    /// What solves the step about such a change: set with the first of them, so that it is not compiled where no inputs are set.
    changes: Option<SolveChanged<'s, S, N>>,
    /// The last node where they did.
    changed: Option<Box<Changed<'s, S, N>>>,
    /// The steps that were too long for the external forces.
    unresolved: Option<Box<Unresolved>>,
    /// Whether the last step was examined for that.
    looked: bool,
    /// The sides of functions that jump, where the last step was solved with them.
    stuck: Option<Box<Stuck>>,
}

// by hand, as `Clone` is, because a derivation would ask the system for as much
impl<S: System<N>, const N: usize> fmt::Debug for Flow<'_, S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Flow")
            .field("h", &self.h)
            .field("index", &self.index())
            .field("time", &self.time())
            .field("leg", &self.leg())
            .finish_non_exhaustive()
    }
}

impl<S: System<N>, const N: usize> Clone for Flow<'_, S, N> {
    fn clone(&self) -> Self {
        Self {
            system: self.system.clone(),
            before: self.before.clone(),
            changed: self.changed.clone(),
            unresolved: self.unresolved.clone(),
            stuck: self.stuck.clone(),
            ..*self
        }
    }
}

/// A step that was solved.
#[repr(align(16))] // as the sums, see [`crate::compensated`]
#[derive(Clone, Copy, Debug)]
struct Solved<const N: usize> {
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
        Self::holding(Held::new(system), h, start)
    }

    /// The same of a system that may have other values of its parameters than the caller's.
    pub(crate) fn holding(system: Held<'s, S>, h: f64, start: Start<N>) -> Result<Self, SetupError> {
        Self::check(&system, h)?;
        Declaration::of(&*system).prepare();
        let beginning = start.begin(&*system, h)?;
        let stuck = if S::JUMPS {
            Self::stuck_at_start(&system, h, &beginning)
        } else {
            None
        };
        Ok(Self {
            stuck,
            constants: system.constants(&system.parameters(), h),
            third: Third::new(beginning.e),
            values: system.parameters(),
            system,
            h,
            clock: Clock::even(beginning.t0, h),
            q: beginning.q,
            d: beginning.d,
            beginning,
            ahead: 1,
            solved: None,
            predictor: Predictor::new(),
            max_iterations: MAX_ITERATIONS,
            since: 0,
            before: None,
            changes: None,
            changed: None,
            unresolved: None,
            looked: true,
        })
    }

    /// Checks the step and the parameters.
    pub(crate) fn check(system: &S, h: f64) -> Result<(), SetupError> {
        if !h.is_finite() || h == 0.0 {
            return Err(SetupError::Step { h });
        }
        let smallest = if const { S::ORDER > 2 } { h * h * h } else { h * h };
        if !smallest.is_normal() {
            return Err(SetupError::StepRange { h });
        }
        start::check_parameters(system)
    }

    /// Sets how often the rows of a step are evaluated from one guess before it is given up (60 unless set; at
    /// least 1 is taken).
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

    /// The step, negative when running back in time.
    #[must_use]
    pub fn h(&self) -> f64 {
        self.h
    }

    /// The number of the last position that is known, the middle node of the next step: one more than [`Stepper::node`]'s.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.clock.index() + self.ahead
    }

    /// The time of that position.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.time_of(self.index())
    }

    /// The last position that is known: the second node of the start, then the one that [`Stepper::advance`] found.
    #[must_use]
    pub fn position(&self) -> &[f64; N] {
        &self.q.hi
    }

    /// The start, worked out.
    pub(crate) fn beginning(&self) -> &Beginning<N> {
        &self.beginning
    }

    /// The last step that was solved: its first two nodes, the second difference and the unknowns.
    #[allow(clippy::type_complexity)] // used once
    pub(crate) fn last_step(&self) -> Option<(Leg<f64, N>, [f64; N], S::Unknown<f64>)> {
        let solved = self.solved?;
        Some((solved.leg, solved.e, self.predictor.last()?))
    }

    /// The leg that the next step begins with: the last node and the increment that led to it.
    #[must_use]
    pub fn leg(&self) -> Leg<f64, N> {
        Leg {
            t: self.time(),
            q: self.q.hi,
            d: self.d.hi,
        }
    }

    /// The same for the step, with the time only where the system asks for it.
    #[inline]
    fn next_leg(&self) -> Leg<f64, N> {
        Leg {
            t: if S::DEPENDS_ON_TIME { self.time() } else { 0.0 },
            q: self.q.hi,
            d: self.d.hi,
        }
    }

    /// Solves the next step and goes to the position that it leads to; the clock is left as it is.
    #[inline]
    fn solve(&mut self) -> Result<StepReport, StepError> {
        if S::JUMPS
            && self.is_stuck()
            && let Some(report) = self.solve_stuck()
        {
            return report;
        }
        if self.before.is_some()
            && let Some(report) = self.solve_change()
        {
            return report;
        }
        if const { S::ORDER > 2 } {
            return self.solve_third();
        }
        let (past_is_short, begins) = self.near_the_start();
        let leg = self.next_leg();
        let step = Step {
            past_is_short,
            begins,
            ..Step::new(&*self.system, &self.constants, leg, self.h)
        };
        let (z, report) = match step.solve(&mut self.predictor, self.max_iterations) {
            Ok(solution) => solution,
            Err(cause) => {
                if S::JUMPS
                    && let Some(report) = self.solve_jump(None)
                {
                    return report;
                }
                return Err(self.failed(cause));
            }
        };
        let e = step.second_difference(&z);
        let mut d = self.d;
        d.add(&e);
        let q = self.q.plus(&d);
        if !q.hi.iter().all(|q| q.is_finite()) {
            return Err(self.failed(step.any().not_finite(&z)));
        }
        let leg = step.leg;
        let foreseen =
            (!Self::MAY_SWITCH || self.foresees(&z, &e)) && !(S::JUMPS && report.stop == Stop::Jump);
        if S::JUMPS
            && !foreseen
            && let Some(report) = self.solve_jump(Some((&e, report.stop)))
        {
            return report;
        }
        self.predictor.push(&z);
        if !foreseen {
            self.look_between(&leg, &e, report.stop);
        }
        if Self::MAY_SWITCH || S::JUMPS {
            self.looked = !foreseen;
        }
        self.solved = Some(Solved { leg, e, report });
        (self.q, self.d) = (q, d);
        Ok(report)
    }

    /// Solves the step at whose middle node an input changes.
    #[cold]
    fn solve_change(&mut self) -> Option<Result<StepReport, StepError>> {
        let (before, solve_changed) = (self.before.take()?, self.changes?);
        Some(solve_changed(self, before))
    }

    /// The middle node of a step.
    fn node_of(&self, Solved { leg, e, report }: Solved<N>) -> Node<N> {
        if const { S::ORDER > 2 } {
            let mut constants = self.constants;
            S::remember(&mut constants, &self.third.before);
            return self.node_with(&constants, Solved { leg, e, report });
        }
        self.node_with(&self.constants, Solved { leg, e, report })
    }

    /// The same with what is known of the run.
    #[inline]
    fn node_with(&self, constants: &S::Constants<f64>, Solved { leg, e, report }: Solved<N>) -> Node<N> {
        let known = self.system.known(constants, &leg);
        let Report { point, force, energy } = self.system.report(constants, &known, &leg, &e);
        let mut node = Node {
            index: self.clock.index(),
            t: self.clock.time(),
            q: leg.q,
            v: point.v,
            a: point.a,
            force,
            energy,
            iterations: report.iterations,
            stop: report.stop,
        };
        if S::JUMPS && self.stuck.is_some() {
            self.tell_sides(&Solved { leg, e, report }, &mut node);
        }
        if let Some(changed) = &self.changed
            && changed.index == self.clock.index()
        {
            node.force = changed.force;
        }
        node
    }

    /// The node of the start.
    fn first_node(&self) -> Node<N> {
        let Beginning { q0, v0, a0, t0, .. } = self.beginning;
        let a = a0
            .or_else(|| Some(start::acceleration(&*self.system, (t0, &q0, &v0), None).ok()?.0))
            .unwrap_or([f64::NAN; N]);
        Node {
            index: self.clock.index(),
            t: self.clock.time(),
            q: q0,
            v: v0,
            a,
            force: self.first_force(&Point {
                t: t0,
                q: q0,
                v: v0,
                a,
            }),
            energy: self.system.energy(t0, &q0, &v0),
            iterations: 0,
            stop: Stop::Start,
        }
    }

    /// The equations of the next step.
    #[inline]
    fn next_step(&self) -> Step<'_, S, N> {
        let (past_is_short, begins) = self.near_the_start();
        Step {
            past_is_short,
            begins,
            ..Step::new(&*self.system, &self.constants, self.leg(), self.h)
        }
    }

    /// Whether the past is too short to tell two roots apart by it, and the acceleration of the start where the next step is the
    /// first.
    #[inline]
    fn near_the_start(&self) -> (bool, Option<Begins<N>>) {
        let index = self.index();
        let begins = if index == 1 { self.beginning.begins() } else { None };
        (index - self.since <= SHORT_PAST, begins)
    }

    /// The error of the next step.
    #[cold]
    fn failed(&self, cause: NewtonFailure) -> StepError {
        let failing = Failing {
            index: self.index(),
            time: self.time(),
            q0: self.q.plus(&self.d.negated()).hi,
        };
        self.next_step().any().error(&failing, cause)
    }
}

impl<S: System<N>, const N: usize> run::Run for Flow<'_, S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.system.kernel()
    }

    fn values(&self) -> &[f64] {
        self.values.as_ref()
    }

    #[inline]
    fn step(&mut self, _: f64) -> Result<StepReport, RunError> {
        let report = self.solve()?;
        self.clock.tick();
        Ok(report)
    }

    #[inline]
    fn tell(&self, node: NodeMut<'_>) {
        let now = match self.solved {
            Some(solved) => self.node_of(solved),
            None => self.first_node(),
        };
        node.write(&now.any());
    }

    fn clock(&self) -> &Clock {
        &self.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.clock
    }

    /// Turns round in time; see [`Flow`], "Back in time". The step back about the current node is solved at once. The node then has
    /// the velocity and the force of this step, and [`Flow::position`] is the node before it.
    fn reverse(&mut self) -> Result<(), RunError> {
        let mut turned = self.clone();
        turned.h = -self.h;
        // a node where inputs have changed lies between the same two values on the way back
        let changed = self
            .changed
            .as_ref()
            .filter(|changed| changed.index == self.clock.index());
        if let Some(changed) = changed {
            turned.before = Some(turned.system);
            turned.system = changed.before.clone();
            turned.values = turned.system.parameters();
        }
        turned.constants = turned.system.constants(&turned.system.parameters(), turned.h);
        turned.d = self.d.negated();
        turned.q = self.q.plus(&turned.d);
        turned.predictor.turn();
        if const { S::ORDER > 2 } {
            turned.turn_third(self.solved.is_some());
        }
        turned.clock.turn();
        turned.ahead = 0;
        turned.since = 0;
        turned.rest_as(self);
        turned.solve()?;
        turned.ahead = 1;
        *self = turned;
        Ok(())
    }

    fn unresolved(&self) -> Option<Unresolved> {
        self.unresolved.as_deref().copied()
    }

    fn regularity(&self) -> Option<Regularity> {
        let solved = self.solved?;
        if const { S::ORDER > 2 } {
            return self.regularity_of_third(&solved);
        }
        Some(Regularity::of(
            self.system.kernel(),
            self.h,
            solved.leg.any(),
            &solved.e,
        ))
    }
}

impl<S: System<N>, const N: usize> Stepper<N> for Flow<'_, S, N> {
    #[inline]
    fn run(&self) -> &dyn run::Run {
        self
    }

    #[inline]
    fn run_mut(&mut self) -> &mut dyn run::Run {
        self
    }
}

impl<S: System<N>, const N: usize> Iterator for Flow<'_, S, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<S: System<N>, const N: usize> FusedIterator for Flow<'_, S, N> {}

mod choose;
mod exchange;
mod forces;
mod inputs;
mod stick;
mod third;
mod unresolved;
pub use choose::Roots;
pub(crate) use exchange::State;
pub use forces::multipliers;
pub(crate) use inputs::works;
use inputs::{Changed, SolveChanged};
use stick::Stuck;
use third::Third;
pub(crate) use unresolved::FORESEEN;
pub use unresolved::Unresolved;
#[cfg(test)]
mod tests;
