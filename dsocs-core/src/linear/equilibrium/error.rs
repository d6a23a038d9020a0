//! The errors of a search for equilibria.

use std::borrow::Cow;

use thiserror::Error;

use super::super::error::choice;
use crate::error::SetupError;
use crate::number::message::{Magnitude, Numbers};
use crate::regularity::undefined::Undefined;

/// The reason why no equilibrium was found.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EquilibriumError {
    /// A parameter or the time cannot be used.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// There is no parameter or coordinate of a name.
    #[error("no {what} is called `{name}`; expected {}", choice(.known))]
    Name {
        /// The named items: parameters or coordinates.
        what: &'static str,
        /// The name.
        name: String,
        /// The known names.
        known: Vec<Cow<'static, str>>,
    },
    /// The number of a guess's components differs from that of the coordinates.
    #[error(
        "a guess has {found} component{}, but there are {} coordinates: {}",
        if *.found == 1 { "" } else { "s" }, .coordinates.len(), .coordinates.join(", ")
    )]
    Length {
        /// The number of its components.
        found: usize,
        /// The coordinates.
        coordinates: Vec<Cow<'static, str>>,
    },
    /// A component of a guess is infinite or not a number.
    #[error("component `{coordinate}` of a guess is {value}; it must be finite")]
    Guess {
        /// The coordinate's name.
        coordinate: Cow<'static, str>,
        /// The value.
        value: f64,
    },
    /// The equations have no value at a point of the iteration.
    #[error(
        "no equilibrium is found from the guess {}: at q = {} the equations have no value at rest{}; try another guess",
        Numbers(.guess), Numbers(.q), .undefined.as_ref().map_or_else(String::new, |what| format!(", since {what}"))
    )]
    Undefined {
        /// The guess.
        guess: Vec<f64>,
        /// The position.
        q: Vec<f64>,
        /// The expression without a value, if there is one.
        undefined: Option<Box<Undefined>>,
    },
    /// The iteration does not converge.
    #[error(
        "no equilibrium is found from the guess {}: after {iterations} iterations, at q = {}, the equations of rest are off by {}, \
         in units of a generalized force; try another guess, or let an input be free that holds the system",
        Numbers(.guess), Numbers(.q), Magnitude(*.residual)
    )]
    NotFound {
        /// The guess.
        guess: Vec<f64>,
        /// The last position of the iteration.
        q: Vec<f64>,
        /// The largest residual of a row.
        residual: f64,
        /// The number of iterations.
        iterations: u32,
    },
    /// A constraint does not allow rest.
    #[error(
        "{constraint} {} does not allow rest: with v = 0 it is {value} at q = {}", .index + 1, Numbers(.q)
    )]
    Moving {
        /// The kind of the constraint.
        constraint: &'static str,
        /// Its index among those of its kind, from 0.
        index: usize,
        /// Its value at rest.
        value: f64,
        /// The position.
        q: Vec<f64>,
    },
    /// The equations depend on time.
    #[error(
        "the system is at rest at q = {}, t = {t} for an instant only: its equations depend on time there", Numbers(.q)
    )]
    TimeDependent {
        /// The position.
        q: Vec<f64>,
        /// The time.
        t: f64,
    },
}

crate::debug_is_message!(EquilibriumError);
