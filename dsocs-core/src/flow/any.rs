//! The discrete flow of a system without its type.

use core::fmt;

use super::discrete::{Discrete, values_of};
use crate::error::{SetupError, StepError};
use crate::kernel::Kernel;
use crate::kernel::report::StepReport;
use crate::number::point::AnyLeg;
use crate::run::Run;
use crate::start::AnyStart;

/// A [`Flow`](crate::Flow) with any number of coordinates, of a system without its type.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::{AnyFlow, AnyStart, Kernel};
///
/// /// A pendulum.
/// #[dsocs {
///     coordinates(theta);
///     lagrangian = dot(theta).powi(2) / 2 + theta.cos();
/// }]
/// struct Pendulum;
///
/// let system: &dyn Kernel = &Pendulum;
/// let mut flow = AnyFlow::new(system, 0.1, &AnyStart::second_order(&[1.0], &[0.0]))?;
/// flow.run_mut().to(10.0)?;
/// assert_eq!(flow.run().clock().index(), 100);
/// assert!(flow.leg().q[0].abs() < 1.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct AnyFlow<'s>(Discrete<'s>);

impl fmt::Debug for AnyFlow<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AnyFlow")
            .field("index", &self.index())
            .field("time", &self.time())
            .field("leg", &self.leg())
            .finish_non_exhaustive()
    }
}

impl<'s> AnyFlow<'s> {
    /// Sets up a run with the step `h`, which is negative to run back in time.
    ///
    /// # Errors
    ///
    /// The errors of [`Flow::new`](crate::Flow::new), and [`SetupError::StartLength`] if the start has another number of coordinates.
    pub fn new(system: &'s dyn Kernel, h: f64, start: &AnyStart) -> Result<Self, SetupError> {
        let start = start.fitted(system.shape())?;
        Ok(Self(Discrete::new(system, values_of(system), h, &start)?))
    }

    /// The number of the last known position: one more than that of the current node.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.0.run_state.index()
    }

    /// The time of the last known position.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.0.run_state.time()
    }

    /// The first leg of the next step: the last known position and the increment that led to it.
    #[must_use]
    pub fn leg(&self) -> AnyLeg<'_, f64> {
        AnyLeg {
            t: self.time(),
            q: self.0.run_state.vectors.position(),
            d: self.0.run_state.vectors.increment(),
        }
    }

    /// Whether a function that jumps with the velocity changed its side in the last step, or has a value
    /// between its sides: dry friction that changes its direction, or stops, holds or releases a body.
    #[must_use]
    pub fn meets_jump(&self) -> bool {
        self.0.meets_jump()
    }

    /// The nodes that solve the next step: the one that Newton's iteration finds, and another one if deflation finds it; see
    /// [`Flow::roots`](crate::Flow::roots).
    ///
    /// ```
    /// use dsocs_core::prelude::*;
    /// use dsocs_core::{AnyFlow, AnyStart};
    ///
    /// /// An oscillator, or a uniform motion.
    /// #[dsocs {
    ///     coordinates(x);
    ///     lagrangian = dot(x).powi(2) / 2;
    ///     kinematic = (dot(x) - drift) * (ddot(x) + x);
    ///     constraint_forces = [(1,)];
    /// }]
    /// struct Either {
    ///     drift: f64,
    /// }
    ///
    /// let either = Either { drift: 0.3 };
    /// let mut flow = AnyFlow::new(&either, 0.1, &AnyStart::second_order(&[1.0], &[0.0]))?;
    /// let (found, other) = flow.roots()?;
    /// let other = other.expect("two roots");
    /// assert!((found[0] - other[0]).abs() > 1e-3);
    /// flow.advance_to(&other)?;
    /// assert!((flow.leg().q[0] - other[0]).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`StepError`] if no solution is found.
    pub fn roots(&self) -> Result<(Vec<f64>, Option<Vec<f64>>), StepError> {
        let (found, other) = self.0.roots()?;
        Ok((found.to_vec(), other.map(|other| other.to_vec())))
    }

    /// Solves one step for the solution nearest to a node, even if there are others; see [`Flow::advance_to`](crate::Flow::advance_to).
    ///
    /// # Errors
    ///
    /// The errors of [`Flow::advance_to`](crate::Flow::advance_to).
    pub fn advance_to(&mut self, q2: &[f64]) -> Result<StepReport, StepError> {
        self.0.advance_to(q2)
    }

    /// The run.
    #[must_use]
    pub fn run(&self) -> &(dyn Run + 's) {
        &self.0
    }

    /// The run, to make steps.
    #[must_use]
    pub fn run_mut(&mut self) -> &mut (dyn Run + 's) {
        &mut self.0
    }

    /// The flow as a run of any method.
    #[must_use]
    pub fn into_run(self) -> Box<dyn Run + 's> {
        Box::new(self.0)
    }
}
