//! The errors of derivatives.

use std::borrow::Cow;

use thiserror::Error;

use crate::run::RunError;

/// The reason why a path could not be run, or not be differentiated.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DerivativeError {
    /// The path could not be run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// There is no parameter with that name.
    #[error("no parameter is called `{name}`; expected one of {}", .known.join(", "))]
    Parameter {
        /// The name.
        name: String,
        /// The names of the parameters.
        known: Vec<Cow<'static, str>>,
    },
    /// The parameter is not an input of the plan.
    #[error("`{name}` is no input of this path; its inputs are [{}] (see `Path::plan`)", .inputs.join(", "))]
    Input {
        /// The name.
        name: String,
        /// The inputs.
        inputs: Vec<Cow<'static, str>>,
    },
    /// There is no such coordinate or leg.
    #[error("there is no {what} {index}: there are {count}")]
    Index {
        /// The numbered items: coordinates or legs.
        what: &'static str,
        /// The number.
        index: usize,
        /// The number of items.
        count: usize,
    },
    /// A rotation has no derivative by the scalar of its quaternion.
    #[error(
        "{index} is the place of the scalar in the quaternion of `{rotation}`; the derivatives by its turns about the axes of its body are those by {}, {} and {}",
        .index + 1, .index + 2, .index + 3
    )]
    Scalar {
        /// The rotation.
        rotation: String,
        /// The requested place.
        index: usize,
    },
    /// The caller stopped the run.
    #[error("stopped at t = {time}")]
    Stopped {
        /// The time of the last node.
        time: f64,
    },
    /// A plan holds no values.
    #[error("a plan needs the values of its inputs on one leg at least")]
    NoLegs,
    /// The path has no steps: its end is less than a step from its start.
    #[error("the path ends at its start: its end has to lie a step h = {h} away at least")]
    NoSteps {
        /// The step.
        h: f64,
    },
    /// The start has no such variable.
    #[error("a start by {start} has no {variable}")]
    Variable {
        /// The quantities that the start gives.
        start: &'static str,
        /// The variable that was requested.
        variable: &'static str,
    },
    /// The start cannot be differentiated.
    #[error(
        "{reason}; give the first two nodes, `Start::nodes(q0, q1)`: those of a flow are `flow.node().q` and `flow.position()`"
    )]
    Start {
        /// The reason.
        reason: &'static str,
    },
    /// Inputs cannot be held.
    #[error(
        "inputs of a system with {constraints} constraints have no derivatives: only those of systems with second-order equations of \
         motion and holonomic constraints do"
    )]
    Constraints {
        /// The kind of constraints.
        constraints: &'static str,
    },
    /// The continuous motion cannot be differentiated.
    #[error("the continuous motion has no derivatives here: {reason}")]
    Continuous {
        /// The reason.
        reason: &'static str,
    },
    /// A step of the path has no root: its equations change their sign in a jump ([`Stop::Jump`](crate::Stop::Jump)).
    #[error(
        "the step about node {index} (t = {time}) has no derivative: its equations pass zero in a jump, such as that of `signum`; a smooth \
         function, such as `(v / 0.01).tanh()`, has one"
    )]
    Jump {
        /// The number of the step's middle node.
        index: usize,
        /// Its time.
        time: f64,
    },
    /// The acceleration jumps in a step of the path, at a place that the variables move. The derivative of the motion jumps there, too, by the
    /// change of the place times the jump (the saltation matrix: Leine and Nijmeijer 2004); that of the discrete equations does not, at any step.
    #[error(
        "the acceleration jumps where `{argument}` is zero, in the step about node {index} (t = {time}): there the derivative of the steps does not \
         converge to that of the motion, however short they are; a steep smooth function that the steps resolve, such as `(x / 0.01).tanh()` for \
         `x.signum()`, has a derivative, and so have runs to a tolerance, by central differences{others}"
    )]
    MovingJump {
        /// The expression that is zero at the jump.
        argument: String,
        /// The number of the step's middle node.
        index: usize,
        /// Its time.
        time: f64,
        /// Which derivatives the path has nevertheless; empty if none.
        others: &'static str,
    },
    /// The Jacobian of a step is singular.
    #[error(
        "the step about node {index} (t = {time}) has no derivative: its Jacobian is singular or not finite there; a smaller step may \
         avoid the place"
    )]
    Singular {
        /// The number of the step's middle node.
        index: usize,
        /// Its time.
        time: f64,
    },
}

crate::debug_is_message!(DerivativeError);
