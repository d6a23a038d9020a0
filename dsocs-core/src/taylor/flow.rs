//! The continuous motion of a system.

use core::fmt;
use core::iter::FusedIterator;

use super::control::Tolerance;
use super::grid::Run;
use super::integrator::Integrator;
use super::jets::{Equations as _, Recurrences};
use crate::compensated::Compensated;
use crate::error::SetupError;
use crate::run::{Clock, Node, Polynomial, RunError, Stepper, Traced, View, Visitor};
use crate::start::{self, Start};
use crate::step::StepReport;
use crate::system::{Point, System};

/// The motion of the continuous system, to a tolerance, in progress.
///
/// Each step expands the motion in a Taylor series and goes as far as the tolerance lets it; the series is the motion in
/// between. The position, the velocity and the time are carried with compensated sums, so that over a million steps rounding
/// does not add up.
///
/// A step is good if, where it ends, the acceleration of its series is that of the system: where the series could not know
/// what comes (a switch that was far away, the edge of an `if`), the step is made shorter.
///
/// The verbs are those of [`crate::Stepper`]. Nodes lie where the steps end, the last one of [`crate::Stepper::until`] at the time asked for; or at
/// the times of a grid ([`TaylorFlow::every`]), read off the series. [`crate::Stepper::sample`] hands the motion at any times on, several at once.
pub struct TaylorFlow<'s, S: System<N>, const N: usize> {
    /// What is compiled for the system.
    pub(super) equations: Recurrences<'s, S, N>,
    /// The motion.
    pub(super) motion: Integrator<N>,
}

impl<S: System<N>, const N: usize> fmt::Debug for TaylorFlow<'_, S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.motion.fmt(f)
    }
}

impl<'s, S: System<N>, const N: usize> TaylorFlow<'s, S, N> {
    /// Sets up a motion, forward in time unless it is turned round ([`crate::Stepper::reverse`]).
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the tolerance, the start or a parameter cannot be used, if the start gives no velocity, or if the system
    /// has no Taylor series there.
    pub fn new(system: &'s S, start: Start<N>, tolerance: Tolerance) -> Result<Self, SetupError> {
        if S::ORDER > 2 {
            return Err(SetupError::ThirdOrder {
                method: "the Taylor series (TaylorFlow)",
            });
        }
        tolerance.check()?;
        start::check_parameters(system)?;
        let phase = start.phase(system)?;
        let mut equations = Recurrences::new(system);
        match Integrator::new(&mut equations, phase, &tolerance) {
            Ok(motion) => Ok(Self { equations, motion }),
            // what the equations for the acceleration leave open says more than a series that is not finite
            Err(error) => {
                match start::state_acceleration(system, (phase.t0, &phase.q0, &phase.v0), phase.near.as_ref())
                {
                    Err(
                        acceleration @ SetupError::Acceleration {
                            deficiency: Some(_), ..
                        },
                    ) => Err(acceleration),
                    _ => Err(error),
                }
            }
        }
    }

    /// Hands out nodes at a grid of times, the current one and those `h` apart, back in time for a negative `h`. The steps
    /// stay those of the tolerance.
    ///
    /// # Errors
    ///
    /// [`SetupError::Step`] if `h` is zero, infinite or not a number.
    pub fn every(mut self, h: f64) -> Result<Self, SetupError> {
        self.motion.every(h)?;
        Ok(self)
    }

    /// Lets steps end at some times, in any order: those where the system is another before and after, such as the places of
    /// [`Samples`](crate::Samples) that a force is read from. Each step then lies on one side.
    #[must_use]
    pub fn knots(mut self, times: impl IntoIterator<Item = f64>) -> Self {
        self.motion.add_knots(times);
        self
    }

    /// Sets how many steps the motion may take in all (10 million unless set).
    #[must_use]
    pub fn max_steps(mut self, limit: u64) -> Self {
        self.motion.max_steps = limit;
        self
    }

    /// Sets the smallest step (unless set, what rounding leaves of the time).
    #[must_use]
    pub fn smallest_step(mut self, smallest: f64) -> Self {
        self.motion.smallest = smallest;
        self
    }

    /// Sets in what units the coordinates' velocities compare: of which numbers of each are of one size (1 for each unless
    /// set).
    #[must_use]
    pub fn scales(mut self, scales: [f64; N]) -> Self {
        self.motion.control.scales(&scales);
        self
    }

    /// The system, with the inputs as they hold now.
    #[must_use]
    pub fn system(&self) -> &S {
        &self.equations.system
    }

    /// The order of the velocity's series; the position's is one more.
    #[must_use]
    pub fn order(&self) -> usize {
        self.motion.order()
    }

    /// How many steps were made.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.motion.steps
    }

    /// How many steps were tried and made shorter.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.motion.rejected
    }

    /// The time up to which the motion is known.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.motion.time()
    }

    /// The position there.
    #[must_use]
    pub fn position(&self) -> &[f64; N] {
        &self.motion.q.hi
    }

    /// The velocity there.
    #[must_use]
    pub fn velocity(&self) -> &[f64; N] {
        &self.motion.v.hi
    }

    /// The acceleration there.
    #[must_use]
    pub fn acceleration(&self) -> &[f64; N] {
        self.motion.acceleration()
    }

    /// The position with what rounding took from it.
    pub(crate) fn exact_position(&self) -> Compensated<N> {
        self.motion.q
    }

    /// The last step as a polynomial, [`Polynomial::start`] to [`TaylorFlow::time`]; `None` before the first.
    #[must_use]
    pub fn polynomial(&self) -> Option<Polynomial<'_, N>> {
        self.motion.polynomial()
    }

    /// The motion with what is compiled for the system, whatever its type.
    pub(super) fn run(&mut self) -> Run<'_, N> {
        Run {
            motion: &mut self.motion,
            equations: &mut self.equations,
        }
    }
}

// steps run in code that is compiled once for each dimension, not for each system
impl<S: System<N>, const N: usize> Stepper<N> for TaylorFlow<'_, S, N> {
    fn step(&mut self, end: f64) -> Result<StepReport, RunError> {
        self.run().step(end)
    }

    fn node(&self) -> Node<N> {
        self.motion.node(&self.equations)
    }

    fn clock(&self) -> &Clock {
        &self.motion.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.motion.clock
    }

    fn view(&self) -> &dyn View<N> {
        self.equations.view()
    }

    /// Turns round. The motion back is that of the tolerance, too: it returns to within the tolerance, not to rounding.
    fn reverse(&mut self) -> Result<(), RunError> {
        self.run().reverse()
    }

    fn trace(&mut self, end: f64, visit: &mut Visitor<'_, N>) -> Result<Traced, RunError> {
        self.run().trace(end, visit)
    }

    fn sample(
        &mut self,
        times: &[f64],
        observer: &mut dyn FnMut(f64, &Point<f64, N>),
    ) -> Result<(), RunError> {
        self.run().sample(times, observer)
    }
}

impl<S: System<N>, const N: usize> Iterator for TaylorFlow<'_, S, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<S: System<N>, const N: usize> FusedIterator for TaylorFlow<'_, S, N> {}
