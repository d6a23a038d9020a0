//! A run by Taylor series.

use core::fmt;
use core::iter::FusedIterator;

use super::control::Tolerance;
use super::integrator::Integrator;
use super::recurrences::{Recurrences, SeriesKernel};
use crate::error::SetupError;
use crate::number::compensated::Compensated;
use crate::run::{Node, Polynomial, Run, RunError, Stepper};
use crate::start::{self, Phase, Start, StartData};
use crate::system::System;
use crate::tape::declaration::Declaration;

/// A run of the continuous system to a tolerance.
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
pub struct TaylorFlow<'s, const N: usize> {
    /// The run with any number of coordinates.
    pub(super) any: AnyTaylorFlow<'s>,
}

/// A [`TaylorFlow`] with any number of coordinates.
pub struct AnyTaylorFlow<'s> {
    /// The series of the system, compiled or interpreted.
    pub(super) equations: Box<dyn SeriesKernel + 's>,
    /// The motion.
    pub(super) motion: Integrator,
}

impl fmt::Debug for AnyTaylorFlow<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.motion.fmt(f)
    }
}

impl<const N: usize> fmt::Debug for TaylorFlow<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.any.fmt(f)
    }
}

impl<'s> AnyTaylorFlow<'s> {
    /// The motion of a series kernel, with the current values of its parameters, from a start.
    ///
    /// # Errors
    ///
    /// As [`TaylorFlow::new`].
    pub(crate) fn new(
        mut equations: Box<dyn SeriesKernel + 's>,
        start: &StartData,
        tolerance: &Tolerance,
    ) -> Result<Self, SetupError> {
        let declaration = equations.declaration();
        Self::check_order(&declaration)?;
        tolerance.check()?;
        start::check_parameters(&declaration)?;
        let phase = start.phase(&declaration)?;
        let at = (phase.t0, &phase.q0[..], &phase.v0[..]);
        let motion = match Integrator::new(&mut *equations, &phase, tolerance) {
            Ok(motion) => motion,
            Err(error) => {
                match start::state_acceleration(&equations.declaration(), at, phase.near.as_deref()) {
                    // a deficiency of the equations for the acceleration, or an expression without a value, is more
                    // specific than a series that is not finite
                    Err(
                        acceleration @ (SetupError::Acceleration {
                            deficiency: Some(_), ..
                        }
                        | SetupError::Acceleration {
                            undefined: Some(_), ..
                        }
                        | SetupError::Singular {
                            deficiency: Some(_), ..
                        }),
                    ) => return Err(acceleration),
                    // Newton's iteration of the series begins at zero, where a row may not depend on the acceleration
                    Ok(near) if phase.near.is_none() => {
                        let near = Some(near);
                        let phase = Phase {
                            near,
                            ..phase.clone()
                        };
                        Integrator::new(&mut *equations, &phase, tolerance).map_err(|_| error)?
                    }
                    _ => return Err(error),
                }
            }
        };
        start::check_determined(&equations.declaration(), at, motion.acceleration())?;
        Ok(Self { equations, motion })
    }

    /// Refuses a system of third order.
    pub(super) fn check_order(declaration: &Declaration<'_>) -> Result<(), SetupError> {
        let shape = declaration.shape();
        if shape.is_of_third_order() {
            return Err(SetupError::ThirdOrder {
                method: "the Taylor series (TaylorFlow)",
            });
        }
        Ok(())
    }

    /// Sets the nodes to a grid of times, a distance of `h` apart; see [`TaylorFlow::every`].
    pub(super) fn put_on_grid(&mut self, h: f64) -> Result<(), SetupError> {
        let forward = self.motion.clock.is_forward();
        self.motion.every(h)?;
        if self.motion.watch.is_some() && forward != self.motion.clock.is_forward() {
            // at a switch the motion back belongs to the other piece
            self.motion.begin(&mut *self.equations);
            self.motion.stand_here();
        }
        Ok(())
    }
}

impl<'s, const N: usize> TaylorFlow<'s, N> {
    /// Sets up a run forward in time; [`crate::Stepper::reverse`] reverses it.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the tolerance, the start or a parameter cannot be used, if the start gives no velocity, or if the system
    /// has no Taylor series there.
    pub fn new<S: System<N>>(
        system: &'s S,
        start: Start<N>,
        tolerance: Tolerance,
    ) -> Result<Self, SetupError> {
        let equations = Box::new(Recurrences::new(system, false));
        let any = AnyTaylorFlow::new(equations, &start.given(), &tolerance)?;
        Ok(Self { any })
    }

    /// Hands out nodes on a grid of times: at the current time, and at a distance of `h` from each other. A negative `h` goes back in
    /// time. The tolerance still determines the steps.
    ///
    /// # Errors
    ///
    /// [`SetupError::Step`] if `h` is zero, infinite or not a number.
    pub fn every(mut self, h: f64) -> Result<Self, SetupError> {
        self.any.put_on_grid(h)?;
        Ok(self)
    }

    /// Makes steps end at the given times, in any order, so that no step crosses them. Use this for times at which a function of yours is not
    /// smooth because it branches on the values of its arguments ([`crate::Real::re`]). The series cannot know these times.
    #[must_use]
    pub fn knots(mut self, times: impl IntoIterator<Item = f64>) -> Self {
        self.any.motion.add_knots(times);
        self
    }

    /// Sets the largest total number of steps (10 million by default).
    #[must_use]
    pub fn max_steps(mut self, limit: u64) -> Self {
        self.any.motion.max_steps = limit;
        self
    }

    /// Sets the smallest step (by default, the rounding error of the time).
    #[must_use]
    pub fn smallest_step(mut self, smallest: f64) -> Self {
        self.any.motion.smallest = smallest;
        self
    }

    /// Sets a scale for the velocity of each coordinate: velocities are divided by these scales before their
    /// sizes are compared. By default they are compared as numbers, but one below a thousandth of the largest
    /// counts as a thousandth.
    #[must_use]
    pub fn scales(mut self, scales: [f64; N]) -> Self {
        self.any.motion.scales(&scales);
        self
    }

    /// The run without its number of coordinates.
    #[must_use]
    pub fn into_run(self) -> Box<dyn Run + 's> {
        Box::new(self.any)
    }

    /// The order of the velocity's series; the position's is one more.
    #[must_use]
    pub fn order(&self) -> usize {
        self.any.motion.order()
    }

    /// The number of steps that were made.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.any.motion.steps
    }

    /// The number of steps that were rejected and made shorter.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.any.motion.rejected
    }

    /// The time up to which the motion is known.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.any.motion.time()
    }

    /// The position at that time.
    #[must_use]
    pub fn position(&self) -> &[f64; N] {
        first(self.any.motion.now.q())
    }

    /// The velocity at that time.
    #[must_use]
    pub fn velocity(&self) -> &[f64; N] {
        first(self.any.motion.now.v())
    }

    /// The acceleration at that time.
    #[must_use]
    pub fn acceleration(&self) -> &[f64; N] {
        first(self.any.motion.acceleration())
    }

    /// The position as a compensated sum.
    pub(crate) fn exact_position(&self) -> Compensated<N> {
        let unknown = || [Compensated::exact([f64::NAN; N]); 2];
        self.any.motion.now.sized().unwrap_or_else(unknown)[0]
    }

    /// The last step as a polynomial, [`Polynomial::start`] to [`TaylorFlow::time`]; `None` before the first.
    #[must_use]
    pub fn polynomial(&self) -> Option<Polynomial<'_, N>> {
        self.any.motion.polynomial().map(Polynomial::of)
    }
}

/// The first numbers of a slice as an array.
fn first<const N: usize>(numbers: &[f64]) -> &[f64; N] {
    numbers.first_chunk().unwrap_or(&[f64::NAN; N])
}

impl<const N: usize> Stepper<N> for TaylorFlow<'_, N> {
    fn run(&self) -> &dyn Run {
        &self.any
    }

    fn run_mut(&mut self) -> &mut dyn Run {
        &mut self.any
    }
}

impl<const N: usize> Iterator for TaylorFlow<'_, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<const N: usize> FusedIterator for TaylorFlow<'_, N> {}
