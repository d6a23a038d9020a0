//! The functions that drive a run of any method, and the types of their results.
//!
//! A method provides one step, the node at its end and a [`Clock`]. [`Run`] makes a run of these, on slices,
//! and [`Stepper`] is its form with the number of coordinates. A run hands out [`Node`]s to an iterator, a
//! [`Trajectory`] or an [`Observer`]. Between the nodes the motion is a [`Polynomial`], on which [`Events`]
//! are found. A failed run ends with a [`RunError`].

// times are reached exactly, and zeros are exact
#![allow(clippy::float_cmp)]
// schemes on coefficients are indexed, as in textbooks
#![allow(clippy::needless_range_loop)]

mod any;
mod csv;
mod error;
mod events;
pub(crate) mod inputs;
mod last_leg;
mod node;
mod observer;
mod polynomial;
mod singular;
mod stepper;
mod still;
mod trajectory;
mod unresolved;
mod until;
mod verbs;

pub use crate::kernel::clock::{Clock, End};
pub use any::{AnyVisitor, Run, SampleObserver, StepEnd, Workspace};
pub use csv::CsvWriter;
pub use error::{FailedEvent, InputError, NotReversible, RunError, TimeBehind};
pub use events::{AnyEvent, AnyEvents, AnyOccurrence, Event, Events, Occurrence};
pub use inputs::{Inputs, held_value};
pub use last_leg::LastLeg;
pub use node::{AnyNode, Node, OwnedNode};
pub use observer::{AnyObserver, Observer, ObserverResult, OnEvent, on_event};
pub(crate) use polynomial::Search;
pub use polynomial::{AnyPolynomial, Polynomial};
pub use singular::NearlySingular;
pub use stepper::{Stepper, Visitor};
pub use trajectory::{Failure, Trajectory};
pub use unresolved::Unresolved;

#[cfg(test)]
mod tests {
    #[test]
    fn runs_go_from_thread_to_thread() {
        fn sent<T: Send>() {}
        sent::<crate::AnyFlow<'_>>();
        sent::<crate::AnyComposedFlow<'_>>();
        sent::<crate::taylor::AnyTaylorFlow<'_>>();
        sent::<crate::AnyPath<'_>>();
    }
}
