//! Derivatives of a whole run with respect to its start, its parameters and held inputs.
//!
//! A [`Path`] is a run of a [`Flow`](crate::Flow) whose steps were stored. The derivatives are those of the
//! discrete motion itself, exact to rounding: the implicit function theorem gives the change of each step's
//! solution. The *forward* method ([`Path::tangents`]) propagates the changes of the nodes with a few
//! [`Variable`]s from the start to the end. The *backward* method ([`Path::gradient`], the discrete adjoint)
//! goes through the steps from the end to the start, and gives the derivatives of one cost by all variables
//! at once.
//!
//! No code is generated for this. The rows are differentiated on the system's tape, for eight steps of the
//! path at once.
//!
//! # Limits
//!
//! Only paths of the discrete flow have derivatives; compositions and Taylor series have none. The
//! constraints are of second order at most. The start is [`Start::paper`](crate::Start::paper),
//! [`Start::second_order`](crate::Start::second_order) or [`Start::nodes`](crate::Start::nodes), and it may
//! be [projected](crate::Start::projected) onto constraints of positions and velocities: the projection of
//! the start and of its second node is differentiated, too. Inputs can be held in systems without kinematic
//! and nonholonomic constraints. Everything else is refused with a [`DerivativeError`].
//!
//! # Rotations
//!
//! A rotation has three directions, the turns about the axes of its body: `δq = ½ q∘(0, ξ)`. Its four places
//! always hold a zero and three numbers in the frame of the body: in a tangent the turn `ξ`, or the changes
//! of angular velocity and angular acceleration; in a gradient the covector of a turn, or of the angular
//! velocity. A [`Variable`] names the turns by the last three of the four places.

// sums go over components of several arrays, derivatives are *by* something, and closure types are written in
// full for users
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
mod memory;
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
