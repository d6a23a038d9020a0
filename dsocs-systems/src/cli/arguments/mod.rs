//! The arguments that several commands have in common.

pub mod accuracy;
pub mod expression;
pub mod file;
pub mod input;
pub mod start;
