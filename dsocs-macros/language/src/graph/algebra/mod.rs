//! Rewritings that make expressions shorter, by algebra alone.
//!
//! - [`merge`]: one representative for all equal expressions;
//! - [`simplify`]: common factors of sums, squares of roots;
//! - [`polynomial`]: expressions multiplied out;
//! - [`horner`]: rows multiplied out and gathered by shared factors;
//! - [`gather`]: products of functions of two coordinates, gathered by coordinates;
//! - [`group`]: inner sums with the same factor, gathered into one.

mod gather;
mod group;
mod horner;
mod merge;
pub(crate) mod polynomial;
mod simplify;

pub(crate) use gather::{entries as gather_entries, slopes as gathered_slopes};
pub(crate) use group::slope as grouped_slope;
pub(crate) use merge::Merge;
pub(crate) use polynomial::Expansion;
pub(crate) use simplify::{Simplify, factored_sum};
