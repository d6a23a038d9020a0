//! The front end of `#[dsocs]`: from the declaration of a system to its model and to the code of its
//! integrator.
//!
//! The data goes one way, from module to module:
//!
//! - `syntax::shared`: `use name;` → the statements that several declarations share;
//! - `parse`: tokens → the syntax tree (`syntax::ast`), on which `check` finds what needs no expression;
//! - `lower`: the syntax tree → the `model`, whose expressions share one `graph`;
//! - `mechanics`: the model → the paper's equations, as expressions that have to vanish;
//! - `passes`: the equations, made fast by one rewriting of the graph after another;
//! - `program`: expressions → operations, each with the stage at which it can be computed;
//! - `recurrences`: the motion → the recurrences of its Taylor series;
//! - `emit`: operations and recurrences → Rust, or data for an engine that runs them without a compiler.
//!
//! Mistakes are collected in `mistakes` and reported at the user's own tokens. The attribute itself is in
//! `dsocs-macros` and only calls [`fn@expand`]; users depend on `dsocs-core`, which re-exports it.

mod check;
mod emit;
mod expand;
mod graph;
mod hash;
mod lower;
mod mechanics;
mod mistakes;
mod model;
mod parse;
mod passes;
mod program;
mod recurrences;
mod syntax;
#[cfg(test)]
mod tests;
mod text;

pub use emit::{Call, Data, Quantity, Series};
pub use expand::expand;
pub use expand::source::{Source, analyze};
pub use mechanics::Symmetry;
pub use mistakes::limits::within_limits;
pub use mistakes::{Mistake, Place};
pub use model::Model;
pub use syntax::shared::statements;
pub use text::{Curve, MOST_BYTES, Run, Table, Text, read};
