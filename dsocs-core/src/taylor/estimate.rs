//! Runs that estimate their errors.

use core::fmt;
use core::ops::ControlFlow;

use super::GlobalError;
use crate::run::{Node, Observer, ObserverResult, RunError};

/// An observer that hands on each node with its distance from the continuous motion, coordinate by coordinate
/// ([`GlobalError::at`]). If the distance can no longer be computed, it ends the run, and [`Estimates::finish`] says why.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::{Estimates, taylor::GlobalError};
///
/// /// An oscillator.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
/// }]
/// struct Oscillator {}
///
/// let (system, start) = (Oscillator {}, Start::second_order([1.0], [0.0]));
/// let mut worst = 0.0_f64;
/// let error = GlobalError::new(&system, start, 10.0)?;
/// let mut estimates = Estimates::new(error, |_: &Node<1>, [x]: &[f64; 1]| worst = worst.max(*x));
/// Flow::new(&system, 0.1, start)?.stream(10.0, &mut estimates)?;
/// let known_to = estimates.finish()?.uncertainty();
/// assert!(worst > 1e-3 && worst < 1e-2 && known_to < 1e-14);
/// # Ok::<(), dsocs_core::RunError>(())
/// ```
pub struct Estimates<'s, F, const N: usize> {
    /// The reference motion.
    error: GlobalError<'s, N>,
    /// Receives the nodes and their errors.
    observer: F,
    /// The error that ended the run.
    failed: Option<RunError>,
}

// by hand, because the derived one would require Debug of the closure
impl<F, const N: usize> fmt::Debug for Estimates<'_, F, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Estimates")
            .field("uncertainty", &self.error.uncertainty())
            .field("failed", &self.failed)
            .finish_non_exhaustive()
    }
}

impl<'s, F, const N: usize> Estimates<'s, F, N> {
    /// Passes nodes and their errors to a closure, which returns nothing or whether to continue.
    pub fn new<R: ObserverResult>(error: GlobalError<'s, N>, observer: F) -> Self
    where
        F: FnMut(&Node<N>, &[f64; N]) -> R,
    {
        Self {
            error,
            observer,
            failed: None,
        }
    }

    /// The continuous motion that the run was compared with; its own error is [`GlobalError::uncertainty`].
    ///
    /// # Errors
    ///
    /// [`RunError`] if the continuous motion could not be computed as far as the run.
    pub fn finish(self) -> Result<GlobalError<'s, N>, RunError> {
        match self.failed {
            None => Ok(self.error),
            Some(error) => Err(error),
        }
    }
}

impl<F, R, const N: usize> Observer<N> for Estimates<'_, F, N>
where
    F: FnMut(&Node<N>, &[f64; N]) -> R,
    R: ObserverResult,
{
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()> {
        match self.error.at(node.t, &node.q) {
            Ok(error) => (self.observer)(node, &error).into_control_flow(),
            Err(error) => {
                self.failed = Some(error);
                ControlFlow::Break(())
            }
        }
    }
}
