//! Code that the tests share: the reference data, formulations that are independent of the generated code,
//! and comparisons.

pub mod check;
pub mod closed_form;
pub mod data;
pub mod fit;
pub mod independent;
pub mod motion;
pub mod plan;
#[cfg(doctest)]
mod readme;
pub mod rods;
pub mod scenes;
pub mod tape;
pub mod text;
pub mod vectors;

pub use dsocs_scenes::{dop853, short_or_long};
