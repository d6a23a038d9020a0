//! The errors of linear models.

use std::borrow::Cow;

use thiserror::Error;

use crate::error::SetupError;
use crate::geometry::GeometryError;
use crate::number::message::Numbers;
use crate::regularity::undefined::Undefined;

/// The reason why a system could not be linearized.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LinearizationError {
    /// The state, the step or a parameter cannot be used, or the equations determine no acceleration there.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A step at the point cannot be solved.
    #[error(transparent)]
    Step(#[from] GeometryError),
    /// There is no parameter with the name of an input.
    #[error("no parameter is called `{name}`, so it is no input; expected {}", choice(.known))]
    Input {
        /// The name.
        name: String,
        /// The names of the parameters.
        known: Vec<Cow<'static, str>>,
    },
    /// There is no quantity with the name of an output.
    #[error(
        "nothing is called `{name}` that could be an output; expected {}, or `v_…`, `a_…`, `force_…` with a coordinate's name",
        choice(.known)
    )]
    Output {
        /// The name.
        name: String,
        /// The names of coordinates and observed expressions, and `energy`.
        known: Vec<Cow<'static, str>>,
    },
    /// An input or an output is named twice.
    #[error("`{name}` is named twice")]
    Twice {
        /// The name.
        name: String,
    },
    /// The equations jump or have a corner at the point.
    #[error(
        "the equations have no derivative at q = {}, v = {}: a function of {} jumps there, or has a corner; linearize beside it, or declare a \
         smooth function, such as `(v / 0.01).tanh()` in place of `v.signum()`",
        Numbers(.q), Numbers(.v), choice(.depends_on)
    )]
    Corner {
        /// The position.
        q: Vec<f64>,
        /// The velocity.
        v: Vec<f64>,
        /// The quantities on which the vanishing argument depends.
        depends_on: Vec<Cow<'static, str>>,
    },
    /// The equations do not determine a derivative.
    #[error(
        "the equations have no derivative at q = {}, v = {}: {}; linearize beside it",
        Numbers(.q), Numbers(.v), reason(.undefined.as_deref())
    )]
    Singular {
        /// The position.
        q: Vec<f64>,
        /// The velocity.
        v: Vec<f64>,
        /// The expression without a derivative, if there is one.
        undefined: Option<Box<Undefined>>,
    },
    /// The iteration for the eigenvalues does not converge.
    #[error("the eigenvalues of the linear model are not found: the iteration for them does not converge")]
    Eigenvalues,
    /// No leg of the discrete path has the wanted velocity at its end.
    #[error(
        "no step h = {h} is found whose middle node has the velocity v = {} at q = {}; a smaller h makes it easier",
        Numbers(.v), Numbers(.q)
    )]
    Leg {
        /// The step.
        h: f64,
        /// The position.
        q: Vec<f64>,
        /// The velocity.
        v: Vec<f64>,
    },
}

crate::debug_is_message!(LinearizationError);

/// The reason why there is no derivative, in words.
fn reason(undefined: Option<&Undefined>) -> String {
    match undefined {
        Some(undefined) => undefined.to_string(),
        None => "their Jacobian is singular there, or a derivative is infinite".to_owned(),
    }
}

/// The names that are possible, in words.
pub(super) fn choice(names: &[Cow<'static, str>]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        None => "nothing, since there are none".to_owned(),
        Some((only, [])) => only.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
    }
}
