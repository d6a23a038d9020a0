//! Imports for a program that runs a system: `use dsocs_core::prelude::*;`.
//!
//! The attribute, the methods, the trait that drives a run ([`Stepper`]), and the types of their arguments
//! and results.

pub use crate::composition::ComposedFlow;
pub use crate::ensemble::Ensemble;
pub use crate::flow::Flow;
pub use crate::number::composition::Composition;
pub use crate::run::{
    Event, Events, Inputs, Node, Observer, Occurrence, RunError, Stepper, Trajectory, on_event,
};
pub use crate::start::Start;
pub use crate::taylor::{TaylorFlow, Tolerance};
pub use dsocs_macros::{dsocs, statements};
