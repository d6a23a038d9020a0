//! The continuous motion of a system.

use core::fmt;
use core::iter::FusedIterator;

use super::control::Tolerance;
use super::grid::Run;
use super::integrator::Integrator;
use super::jets::{Equations as _, Recurrences};
use crate::any::AnyPoint;
use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::error::SetupError;
use crate::kernel::Kernel;
use crate::run::{self, AnyVisitor, Clock, Node, NodeMut, Polynomial, Room, RunError, Stepper, Traced};
use crate::start::{self, Start};
use crate::step::StepReport;
use crate::system::System;

/// A run of the continuous system, to a tolerance.
///
/// Each step expands the motion in a Taylor series and goes as far as the tolerance allows. The series gives the motion during
/// the step. Position, velocity and time are compensated sums, so rounding errors do not add up over a million steps.
///
/// A step is accepted if, at its end, the acceleration of its series is that of the system. Otherwise the step is made shorter. This happens
/// where the series does not represent the motion. At a jump or a corner of the declared functions a step ends, and the next one begins
/// behind it (see [`crate::taylor`]).
///
/// The functions that drive it are those of [`crate::Stepper`]. Nodes lie at the ends of the steps, and the last node of [`crate::Stepper::until`]
/// lies at the requested time. With [`TaylorFlow::every`] nodes lie on a grid of times and are computed from the series.
/// [`crate::Stepper::sample`] hands out the motion at any times.
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
    /// Sets up a run forward in time; [`crate::Stepper::reverse`] turns it round.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the tolerance, the start or a parameter cannot be used, if the start gives no velocity, or if the system
    /// has no Taylor series there.
    pub fn new(system: &'s S, start: Start<N>, tolerance: Tolerance) -> Result<Self, SetupError> {
        Self::of(Recurrences::new(system), start, tolerance)
    }

    /// The same for recurrences of a system that may be a copy.
    pub(super) fn of(
        mut equations: Recurrences<'s, S, N>,
        start: Start<N>,
        tolerance: Tolerance,
    ) -> Result<Self, SetupError> {
        if const { S::ORDER > 2 } {
            return Err(SetupError::ThirdOrder {
                method: "the Taylor series (TaylorFlow)",
            });
        }
        tolerance.check()?;
        let system = equations.system.clone();
        let system = &*system;
        let declaration = Declaration::of(system);
        start::check_parameters(&declaration)?;
        let phase = start.given().phase(&declaration)?;
        match Integrator::new(&mut equations, &phase, &tolerance) {
            Ok(motion) => Ok(Self { equations, motion }),
            // what the equations for the acceleration leave open, or what in them has no value, says more than a series that is not finite
            Err(error) => {
                let at = (phase.t0, &phase.q0[..], &phase.v0[..]);
                match start::state_acceleration(&declaration, at, phase.near.as_deref()) {
                    Err(
                        acceleration @ (SetupError::Acceleration {
                            deficiency: Some(_), ..
                        }
                        | SetupError::Acceleration {
                            undefined: Some(_), ..
                        }),
                    ) => Err(acceleration),
                    _ => Err(error),
                }
            }
        }
    }

    /// Hands out nodes on a grid of times: at the current time, and at a distance of `h` from each other. A negative `h` goes back in
    /// time. The tolerance still determines the steps.
    ///
    /// # Errors
    ///
    /// [`SetupError::Step`] if `h` is zero, infinite or not a number.
    pub fn every(mut self, h: f64) -> Result<Self, SetupError> {
        let forward = self.motion.clock.is_forward();
        self.motion.every(h)?;
        if self.motion.watch.is_some() && forward != self.motion.clock.is_forward() {
            // at a switch the motion back is that of the other piece
            self.motion.begin(&mut self.equations);
            self.motion.on_grid = Some(self.motion.point());
        }
        Ok(self)
    }

    /// Makes steps end at the given times, in any order, so that no step crosses them. Use this for times at which a function of yours is not
    /// smooth because it branches on the values of its arguments ([`crate::Real::re`]). The series cannot know these times.
    #[must_use]
    pub fn knots(mut self, times: impl IntoIterator<Item = f64>) -> Self {
        self.motion.add_knots(times);
        self
    }

    /// Sets the largest total number of steps (10 million by default).
    #[must_use]
    pub fn max_steps(mut self, limit: u64) -> Self {
        self.motion.max_steps = limit;
        self
    }

    /// Sets the smallest step (by default, the rounding error of the time).
    #[must_use]
    pub fn smallest_step(mut self, smallest: f64) -> Self {
        self.motion.smallest = smallest;
        self
    }

    /// Sets a scale for the velocity of each coordinate: velocities are divided by these scales before their sizes are compared (1 for each
    /// by default).
    #[must_use]
    pub fn scales(mut self, scales: [f64; N]) -> Self {
        self.motion.control.scales(&scales);
        self
    }

    /// The system, with the current values of the inputs.
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

    /// How many steps were rejected and made shorter.
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
        self.motion.polynomial().map(Polynomial::of)
    }

    /// The motion with what is compiled for the system, whatever its type.
    pub(super) fn here(&mut self) -> Run<'_, N> {
        Run {
            motion: &mut self.motion,
            equations: &mut self.equations,
        }
    }
}

// steps run in code that is compiled once for each dimension, not for each system
impl<S: System<N>, const N: usize> run::Run for TaylorFlow<'_, S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.equations.kernel()
    }

    fn values(&self) -> &[f64] {
        self.equations.values()
    }

    fn step(&mut self, end: f64) -> Result<StepReport, RunError> {
        self.here().step(end)
    }

    fn tell(&self, node: NodeMut<'_>) {
        node.write(&self.motion.node(&self.equations).any());
    }

    fn clock(&self) -> &Clock {
        &self.motion.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.motion.clock
    }

    /// Turns round in time. The motion back is computed to the tolerance, too, so it returns to its start to the tolerance, not to
    /// rounding.
    fn reverse(&mut self) -> Result<(), RunError> {
        self.here().reverse()
    }

    fn trace(&mut self, end: f64, room: &mut Room, visit: &mut AnyVisitor<'_>) -> Result<Traced, RunError> {
        self.here().trace(end, room, visit)
    }

    fn sample_at_once(
        &mut self,
        times: &[f64],
        observer: &mut dyn FnMut(f64, AnyPoint<'_, f64>),
    ) -> Result<bool, RunError> {
        self.here().sample_at_once(times, observer)
    }
}

impl<S: System<N>, const N: usize> Stepper<N> for TaylorFlow<'_, S, N> {
    fn run(&self) -> &dyn run::Run {
        self
    }

    fn run_mut(&mut self) -> &mut dyn run::Run {
        self
    }
}

impl<S: System<N>, const N: usize> Iterator for TaylorFlow<'_, S, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<S: System<N>, const N: usize> FusedIterator for TaylorFlow<'_, S, N> {}
