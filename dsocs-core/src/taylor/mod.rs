//! The continuous motion to any tolerance, by Taylor series.
mod control;
mod dispatch;
mod error;
mod events;
mod flow;
mod jet;
mod kernel;
mod polynomial;
mod roots;
mod series;
mod solve;

pub use control::Tolerance;
pub use error::{TaylorError, TaylorFailure};
pub use events::{Event, Events, Occurrence};
pub use flow::{State, TaylorFlow};
pub use jet::{Jet, Tape};
pub use kernel::{LANES, MAX_ORDER, Products, RECIPROCALS, Squares, Table, add_product};
pub use polynomial::Polynomial;
pub use series::Series;
pub use solve::{accelerate, back};

use crate::system::System;

/// A system whose motion has Taylor series, as `#[dsocs]` generates it.
pub trait Jets<const N: usize>: System<N> {
    /// Expressions of the parameters, an array of a literal size.
    type Fixed: Copy;
    /// What the recurrences keep of the orders before.
    type Table: Default;

    /// What the parameters alone decide.
    fn fixed(&self) -> Self::Fixed;

    /// The Taylor coefficients of the motion from the point where the series begins.
    fn expand<const FUSED: bool>(
        &self,
        constants: &Self::Fixed,
        series: &mut Series<N>,
        table: &mut Self::Table,
    );
}
