//! Syntax tree → model: names resolved, expressions as nodes of one graph, their orders checked.

mod declaration;
mod expr;
mod functions;
mod lowering;
mod names;
mod statements;
mod values;

pub(crate) use declaration::model;
pub(crate) use functions::builtin::Builtin;
pub(crate) use functions::closed::circle_constant;
pub(crate) use lowering::Lowering;
pub(crate) use values::Value;
