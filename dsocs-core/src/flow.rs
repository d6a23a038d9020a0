//! The discrete flow: a run by the paper's step.

use core::fmt;
use core::iter::FusedIterator;

use crate::error::SetupError;
use crate::kernel::Kernel;
use crate::number::point::Leg;
use crate::number::point::sized;
use crate::run::{Inputs, Node, Run, RunError, Stepper};
use crate::start::{AnyStart, Start};
use crate::system::System;

/// A run of the discrete system, step by step.
///
/// The functions that drive it are those of [`Stepper`]. The velocity, the acceleration and the constraint
/// force at node `k` also depend on the next node. So node `k` is available once the step with the middle
/// node `k` is solved, and [`Flow::position`] is always one node ahead of [`Stepper::node`].
///
/// # Back in time
///
/// [`Stepper::reverse`] changes the step to `-h` and exchanges the last two nodes, together with their compensated sums. The run back
/// is the same discretization with the step `-h`. If the step is symmetric in time, the run back retraces the nodes to rounding. With the
/// paper's maps, and with the default maps, the step is symmetric if the mass matrix is constant. Otherwise the run back is another motion,
/// which differs by the discretization error.
#[derive(Clone)]
pub struct Flow<'s, const N: usize>(pub(crate) Discrete<'s>);

impl<const N: usize> fmt::Debug for Flow<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Flow")
            .field("h", &self.h())
            .field("index", &self.index())
            .field("time", &self.time())
            .field("leg", &self.leg())
            .finish_non_exhaustive()
    }
}

impl<'s, const N: usize> Flow<'s, N> {
    /// Sets up a run with the step `h`, which is negative to run back in time.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the step, the start or a parameter is not usable, or if the start needs the initial
    /// acceleration and the continuous system has none.
    pub fn new<S: System<N>>(system: &'s S, h: f64, start: Start<N>) -> Result<Self, SetupError> {
        let kernel = system.kernel();
        Ok(Self(Discrete::new(kernel, values_of(kernel), h, &start.given())?))
    }

    /// The run of a system without its type, such as one that was read from a text.
    ///
    /// # Errors
    ///
    /// The errors of [`Flow::new`], and [`SetupError::StartLength`] if the system has another number of coordinates than the start.
    pub fn of(system: &'s dyn Kernel, h: f64, start: Start<N>) -> Result<Self, SetupError> {
        let start = AnyStart::from(start);
        let start = start.fitted(system.shape())?;
        Ok(Self(Discrete::new(system, values_of(system), h, &start)?))
    }

    /// The run without its number of coordinates.
    #[must_use]
    pub fn into_run(self) -> Box<dyn Run + 's> {
        Box::new(self.0)
    }

    /// Sets the maximum number of Newton iterations from one guess (60 by default; at least 1 is used).
    #[must_use]
    pub fn max_iterations(mut self, limit: u32) -> Self {
        self.0.run_state.max_iterations = limit.max(1);
        self
    }

    /// The step, negative when running back in time.
    #[must_use]
    pub fn h(&self) -> f64 {
        self.0.run_state.h
    }

    /// The index of the last known position, the middle node of the next step: one more than that of
    /// [`Stepper::node`].
    #[must_use]
    pub fn index(&self) -> u64 {
        self.0.run_state.index()
    }

    /// The time of the last known position.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.0.run_state.time()
    }

    /// The last known position: the second node of the start, then the node that [`Stepper::advance`] found.
    #[must_use]
    pub fn position(&self) -> &[f64; N] {
        self.0
            .run_state
            .vectors
            .position()
            .first_chunk()
            .unwrap_or(&[f64::NAN; N])
    }

    /// The leg at the beginning of the next step: the last node and the increment that led to it.
    #[must_use]
    pub fn leg(&self) -> Leg<f64, N> {
        Leg {
            t: self.time(),
            q: *self.position(),
            d: sized(self.0.run_state.vectors.increment()),
        }
    }
}

impl<const N: usize> Stepper<N> for Flow<'_, N> {
    #[inline]
    fn run(&self) -> &dyn Run {
        &self.0
    }

    #[inline]
    fn run_mut(&mut self) -> &mut dyn Run {
        &mut self.0
    }
}

impl<const N: usize> Inputs<N> for Flow<'_, N> {}

impl<const N: usize> Iterator for Flow<'_, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<const N: usize> FusedIterator for Flow<'_, N> {}

mod any;
mod choose;
mod corner;
pub(crate) mod discrete;
mod forces;
mod inputs;
mod jumps;
mod singular;
mod stick;
mod unresolved;
pub use any::AnyFlow;
pub use choose::Roots;
use discrete::{Discrete, values_of};
pub use forces::multipliers;
pub(crate) use inputs::works;
#[cfg(test)]
mod tests;
