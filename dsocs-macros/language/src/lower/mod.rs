//! Syntax tree → model: names resolved, expressions as nodes of one graph, their orders checked.

mod builtin;
mod call;
mod choice;
mod closed;
mod constraints;
mod declaration;
mod differentiated;
mod discrete;
mod expr;
mod foreign_names;
mod function;
mod index;
mod look_alike;
mod lowering;
mod map;
mod multiples;
mod reduction;
mod rotations;
mod shape;
mod statements;
mod unknown_names;
mod unused;
mod value;
mod vectors;

pub(crate) use builtin::Builtin;
pub(crate) use closed::circle_constant;
pub(crate) use declaration::model;
pub(crate) use lowering::Lowering;
pub(crate) use value::Value;
