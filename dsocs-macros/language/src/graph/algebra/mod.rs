//! Expressions made shorter, whatever they stand for.
//!
//! - [`merge`]: one expression for all that are equal;
//! - [`simplify`]: common factors of sums, squares of roots;
//! - [`horner`]: what is multiplied out, and gathered again;
//! - [`gather`]: products of functions of two coordinates, by coordinates;
//! - [`group`]: sums beside one factor, as one sum.

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
