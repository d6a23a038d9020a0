//! The errors of the discrete flow as a map.

use thiserror::Error;

use crate::error::SetupError;
use crate::solve::failure::NewtonFailure;

/// A step could not be solved, or its solution could not be differentiated.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// The step or a parameter cannot be used.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The number of a vector's components differs from that of the coordinates.
    #[error("a leg or a second difference has {found} components, but there are {coordinates} coordinates")]
    Length {
        /// The number of its components.
        found: usize,
        /// The number of coordinates.
        coordinates: usize,
    },
    /// No solution of the step was found.
    #[error("the step from q0 = {q0:?}, q1 = {q1:?} has no solution: {cause}")]
    Step {
        /// The first node.
        q0: Vec<f64>,
        /// The second node.
        q1: Vec<f64>,
        /// The failure of the iteration.
        cause: Box<NewtonFailure>,
    },
    /// The continuous system gives no acceleration.
    #[error("the acceleration at q = {q:?}, v = {v:?} cannot be solved for: {cause}")]
    Acceleration {
        /// The position.
        q: Vec<f64>,
        /// The velocity.
        v: Vec<f64>,
        /// The failure of the iteration.
        cause: Box<NewtonFailure>,
    },
    /// No first node for the other two was found.
    #[error(
        "no node before q1 = {q1:?}, q2 = {q2:?} is found{}; a smaller h makes it easier",
        last_update(*.update)
    )]
    Inverse {
        /// The second node.
        q1: Vec<f64>,
        /// The third node.
        q2: Vec<f64>,
        /// The last update, relative to the leg; infinite if none could be computed.
        update: f64,
    },
    /// The triple does not solve the equations.
    #[error("q0 = {q0:?}, q1 = {q1:?}, q2 = {q2:?} are no trajectory: the step leads to {found:?}")]
    NoTrajectory {
        /// The first node.
        q0: Vec<f64>,
        /// The second node.
        q1: Vec<f64>,
        /// The third node.
        q2: Vec<f64>,
        /// The node that solves the step.
        found: Vec<f64>,
    },
    /// The equations do not determine a derivative: their Jacobian is singular or not finite.
    #[error("the equations are singular at q0 = {q0:?}, q1 = {q1:?}: the step has no derivative there")]
    Singular {
        /// The first node.
        q0: Vec<f64>,
        /// The second node.
        q1: Vec<f64>,
    },
}

crate::debug_is_message!(GeometryError);

/// The last update of the search for a first node, in words.
fn last_update(update: f64) -> String {
    if update.is_finite() {
        format!(": the last update was {update:.1e} of a leg")
    } else {
        ", since the equations do not determine one there".to_owned()
    }
}
