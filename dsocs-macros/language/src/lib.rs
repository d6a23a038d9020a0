//! The front end of `#[dsocs]`: from the declaration of a system to its model, and to the code of its integrator.
//!
//! The data goes one way, from room to room:
//!
//! - `shared`: `use name;` → the statements that several declarations share;
//! - `parse`: tokens → what the user wrote (`ast`), `check`ed for what can be seen there;
//! - `lower`: that → a `model` whose expressions share one `graph`;
//! - `mechanics`: the model → what has to vanish, the paper's equations;
//! - `passes`: the equations made fast, one rewriting of the graph after another;
//! - `emit`: the graph → Rust, or data for an engine that runs it without a compiler.
//!
//! Every mistake on the way is collected in `errors` and told at the user's own tokens. The attribute itself is in
//! `dsocs-macros` and does no more than to call [`expand`]; users depend on `dsocs-core`, which re-exports it.

mod ast;
mod check;
mod core_path;
mod emit;
mod errors;
mod expand;
mod graph;
mod hash;
mod input;
mod layout;
mod limits;
mod lower;
mod mechanics;
mod mistake;
mod model;
mod names;
mod nearest;
mod parse;
mod passes;
mod shared;
mod source;
mod stub;
mod syntax;
#[cfg(test)]
mod tests;
mod text;

pub use emit::{Call, Data, Quantity, Series};
pub use expand::expand;
pub use limits::within_limits;
pub use mechanics::Symmetry;
pub use mistake::{Mistake, Place};
pub use model::Model;
pub use shared::statements;
pub use source::{Source, analyze};
pub use text::{Curve, MOST_BYTES, Run, Table, Text, read};
