//! The reasons why a run did not reach its end.

use std::borrow::Cow;

use dsocs_core::{RunError, SetupError};
use thiserror::Error;

/// A run did not reach its end.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RunFailure {
    /// It did not begin.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The number of components of a vector is not the number of coordinates.
    #[error(
        "{vector} has {found} component{}, but there are {} {}: {}{of_rotations}",
        if *.found == 1 { "" } else { "s" }, .coordinates.len(),
        if .of_rotations.is_empty() { "coordinates" } else { "numbers" }, .coordinates.join(", ")
    )]
    Length {
        /// The vector.
        vector: &'static str,
        /// The number of its components.
        found: usize,
        /// The coordinates.
        coordinates: Vec<Cow<'static, str>>,
        /// A remark on the components of rotations, if there are some.
        of_rotations: &'static str,
    },
    /// It ended early.
    #[error(transparent)]
    Run(#[from] RunError),
    /// There is no continuous motion from which errors could be computed.
    #[error("the error cannot be estimated: {0}")]
    Estimate(#[source] RunError),
}

dsocs_core::debug_is_message!(RunFailure);
