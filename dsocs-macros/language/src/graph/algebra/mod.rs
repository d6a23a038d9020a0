//! Rewritings that make expressions shorter, by algebra alone.
//!
//! - [`merge`]: one expression for all that are equal;
//! - [`simplify`]: common factors of sums, squares of roots;
//! - [`horner`]: rows multiplied out and gathered by shared factors;
//! - [`gather`]: products of functions of two coordinates, gathered by coordinates;
//! - [`group`]: inner sums with the same factor, gathered into one.

mod gather;
mod group;
pub(crate) mod horner;
mod merge;
mod simplify;

pub(crate) use gather::{entries as gather_entries, slopes as gathered_slopes};
pub(crate) use group::slope as grouped_slope;
pub(crate) use horner::Horner;
pub(crate) use merge::Merge;
pub(crate) use simplify::{Simplify, factored_sum};
