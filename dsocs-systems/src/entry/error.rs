//! Errors of an entry, and of a check of its system.

use dsocs_core::geometry::GeometryError;
use dsocs_core::{RunError, SetupError};
use thiserror::Error;

use super::{RunFailure, UnknownName};

/// An entry contradicts the declaration of its system.
#[derive(Clone, PartialEq, Error)]
#[error("the entry `{name}`: {cause}")]
pub struct EntryError {
    /// The entry.
    pub name: String,
    /// The mistake.
    pub cause: Mistake,
}

dsocs_core::debug_is_message!(EntryError);

/// A mistake of an entry.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Mistake {
    /// The number of components of a vector is not the number of coordinates.
    #[error(
        "{what} has {found} component{}, but there {} {} coordinate{}: {}",
        if *.found == 1 { "" } else { "s" },
        if .coordinates.len() == 1 { "is" } else { "are" }, .coordinates.len(),
        if .coordinates.len() == 1 { "" } else { "s" }, .coordinates.join(", ")
    )]
    Length {
        /// The vector.
        what: String,
        /// The number of its components.
        found: usize,
        /// The coordinates.
        coordinates: Vec<String>,
    },
    /// The name cannot be written on a command line.
    #[error("a name is not empty, does not begin with `-` and has no blanks")]
    Name,
    /// Its drawing asks for a parameter that does not exist.
    #[error("its drawing: {0}")]
    Parameter(UnknownName),
    /// Another entry has the same name.
    #[error("there are two of this name; `Entry::named` gives one of them another")]
    Twice,
}

dsocs_core::debug_is_message!(Mistake);

/// A system could not be checked.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CheckFailure {
    /// The start does not fit the system.
    #[error(transparent)]
    Start(#[from] RunFailure),
    /// The motion that was to be checked does not begin.
    #[error("the motion to check does not begin: {0}")]
    Setup(#[from] SetupError),
    /// It ends early.
    #[error("the motion to check ends early: {0}")]
    Run(#[from] RunError),
    /// A step of it has no solution by itself.
    #[error("the motion to check: {0}")]
    Geometry(#[from] GeometryError),
    /// The orders of the parts are not measured for this kind of system.
    #[error("the orders of the parts are not measured here: {reason}")]
    Orders {
        /// The reason.
        reason: &'static str,
    },
}

dsocs_core::debug_is_message!(CheckFailure);
