//! From a checked declaration to its code, as Rust ([`rust`]) or as a tape ([`tape`]). Nothing here can fail, and
//! nothing is derived: [`crate::mechanics`] forms the equations, [`crate::passes`] make them fast,
//! [`crate::program`] turns them into operations and [`crate::recurrences`] into those of Taylor series.
//!
//! Rust is written for the functions that a run evaluates often, the tape for all.

mod assemble;
mod data;
mod facts;
pub(crate) mod rust;
mod tape;

pub(crate) use assemble::data;
pub use data::{Call, Data, Quantity};
pub(crate) use rust::expand;
pub use tape::Series;
pub(crate) use tape::series;

#[cfg(test)]
mod tests;
