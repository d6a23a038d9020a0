//! The figures of a run.

pub mod label;
pub mod moments;
pub mod picture;
pub mod plot;
