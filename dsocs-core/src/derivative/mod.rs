//! Derivatives of a whole run, by its start, its parameters and inputs that are held.
//!
//! A [`Path`] is a run of a [`Flow`](crate::Flow) that was kept. What it is differentiated as is the discrete motion itself, exact to
//! rounding: every step has been solved, and the implicit function theorem says how its solution changes. *Forward*
//! ([`Path::tangents`]) the change of every node by a few [`Variable`]s goes along with the motion; *backward*
//! ([`Path::gradient`]) the derivative of one cost by everything at once goes back through the steps (the discrete adjoint).
//!
//! Nothing of this is compiled for a system: the rows' derivatives come from its tape, eight steps of the path side by side.
//!
//! # What has derivatives
//!
//! Paths of the discrete flow, from a start that is [`Start::paper`](crate::Start::paper),
//! [`Start::second_order`](crate::Start::second_order) or [`Start::nodes`](crate::Start::nodes). Where holonomic or
//! nonholonomic constraints bind the start it has to be `nodes`, since its second node is not free. Inputs can be held by systems
//! without kinematic and nonholonomic constraints. All else is refused with a [`DerivativeError`]. Compositions and Taylor
//! series have no derivatives.

// sums go over components of several arrays, derivatives are *by* something, and closures are written in full for who writes them
#![allow(
    clippy::needless_range_loop,
    clippy::struct_field_names,
    clippy::type_complexity
)]

mod block;
mod changed;
mod error;
mod forward;
mod gradient;
mod path;
mod start;

pub use error::DerivativeError;
pub use forward::{NodeTangent, Variable};
pub use gradient::Gradient;
pub use path::Path;
