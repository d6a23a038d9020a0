//! The flow of a composed step.

use core::fmt;
use core::iter::FusedIterator;
use std::sync::Arc;

use super::run::Composed;
use super::stages::CompiledStages;
use crate::error::SetupError;
use crate::flow::discrete::values_of;
use crate::number::composition::Composition;
use crate::number::point::sized;
use crate::run::{Inputs, Node, Run, RunError, Stepper};
use crate::start::Start;
use crate::system::System;

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
/// lengths is added, each rounded once. These rounding errors are as small as those of the solved accelerations, and no larger errors add up.
/// After [`Stepper::reverse`] the flow adds the same products with the opposite sign, so it returns to its start to rounding.
#[derive(Clone)]
pub struct ComposedFlow<'s, const N: usize>(pub(crate) Composed<'s>);

impl<const N: usize> fmt::Debug for ComposedFlow<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ComposedFlow")
            .field("method", &self.method())
            .field("h", &self.h())
            .field("index", &self.index())
            .field("time", &self.time())
            .field("state", &self.0.run_state.now)
            .finish_non_exhaustive()
    }
}

impl<'s, const N: usize> ComposedFlow<'s, N> {
    /// Sets up a run with the step `h`, which is negative to run back in time. The run begins with the position and the velocity of
    /// the start and the acceleration of the continuous system there, so that the start has no error.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the step, the start or a parameter is not usable, if the start gives no velocity or the continuous system
    /// no acceleration there, or if the step of this system cannot be composed ([`SetupError::Composition`]; use [`Flow`](crate::Flow) then).
    pub fn new<S: System<N>>(
        system: &'s S,
        h: f64,
        method: Composition,
        start: Start<N>,
    ) -> Result<Self, SetupError> {
        let kernel = system.kernel();
        let run = Composed::new(
            (kernel, values_of(kernel)),
            Some(Arc::new(CompiledStages(system))),
            h,
            method,
            &start.given(),
        );
        Ok(Self(run?))
    }

    /// The run without its number of coordinates.
    #[must_use]
    pub fn into_run(self) -> Box<dyn Run + 's> {
        Box::new(self.0)
    }

    /// Sets the largest number of evaluations of a stage's rows from one guess (60 unless set; at least 1).
    #[must_use]
    pub fn max_iterations(mut self, limit: u32) -> Self {
        self.0.run_state.max_iterations = limit.max(1);
        self
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> Composition {
        self.0.method
    }

    /// The step, negative when running back in time.
    #[must_use]
    pub fn h(&self) -> f64 {
        self.0.h
    }

    /// The number of the current node.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.0.run_state.clock.index()
    }

    /// The time of the current node.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.0.run_state.clock.time()
    }

    /// The position of the current node.
    #[must_use]
    pub fn position(&self) -> [f64; N] {
        sized(&self.0.run_state.now.q.hi)
    }

    /// The velocity at the current node.
    #[must_use]
    pub fn velocity(&self) -> [f64; N] {
        sized(&self.0.run_state.now.v.hi)
    }

    /// The acceleration at the current node.
    #[must_use]
    pub fn acceleration(&self) -> [f64; N] {
        sized(&self.0.run_state.now.a)
    }
}

impl<const N: usize> Stepper<N> for ComposedFlow<'_, N> {
    #[inline]
    fn run(&self) -> &dyn Run {
        &self.0
    }

    #[inline]
    fn run_mut(&mut self) -> &mut dyn Run {
        &mut self.0
    }
}

impl<const N: usize> Inputs<N> for ComposedFlow<'_, N> {}

impl<const N: usize> Iterator for ComposedFlow<'_, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<const N: usize> FusedIterator for ComposedFlow<'_, N> {}
