//! Derivatives of a whole run with respect to its start, its parameters and inputs that are held.
//!
//! A [`Path`] is a run of a [`Flow`](crate::Flow) whose steps were kept. The derivatives are those of the discrete motion itself, exact to
//! rounding: the implicit function theorem gives the change of each step's solution. The *forward* method ([`Path::tangents`]) follows, from
//! the start to the end, how every node changes with a few [`Variable`]s. The *backward* method ([`Path::gradient`], the discrete adjoint)
//! goes through the steps from the end to the start, and gives the derivatives of one cost by all variables at once.
//!
//! No code is generated for this. The derivatives of the rows are computed on the system's tape, for eight steps of the path at once.
//!
//! # What has derivatives
//!
//! Only paths of the discrete flow have derivatives; compositions and Taylor series have none. The constraints are of second order at most.
//! The start is [`Start::paper`](crate::Start::paper), [`Start::second_order`](crate::Start::second_order) or
//! [`Start::nodes`](crate::Start::nodes), and it may be [projected](crate::Start::projected) onto constraints of positions and velocities: what moves it
//! and its second node there is differentiated, too. Inputs can be held in systems without kinematic and nonholonomic constraints. Everything else is refused
//! with a [`DerivativeError`].
//!
//! # Rotations
//!
//! A rotation has three directions, the turns about the axes of its body: `δq = ½ q∘(0, ξ)`. Everywhere its four places hold a zero and three numbers, in the
//! frame of the body: of a tangent the turn `ξ`, the changes of angular velocity and angular acceleration; of a gradient the covector of a turn, and that
//! of the angular velocity. A [`Variable`] names the turns by the last three of the four places.

// sums go over components of several arrays, derivatives are *by* something, and closures are written in full for who writes them
#![allow(
    clippy::needless_range_loop,
    clippy::struct_field_names,
    clippy::type_complexity
)]

mod block;
mod bound;
mod changed;
mod error;
mod forward;
mod gradient;
mod kept;
mod motion;
mod path;
mod points;
mod start;
mod turning;

pub use error::DerivativeError;
pub use forward::{AnyTangent, NodeTangent, OwnedTangents, Variable};
pub use gradient::{AnyGradient, Gradient};
pub(crate) use path::parameter;
pub use path::{AnyPath, Path};
