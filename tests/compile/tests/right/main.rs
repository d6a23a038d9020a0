//! Declarations of every kind: they compile, and their values are those of the expressions.

// written as users write
#![allow(missing_docs, dead_code, clippy::all, clippy::pedantic)]

mod arrays;
mod constraints;
mod elsewhere;
mod expressions;
mod forces;
mod functions;
mod generic;
mod macro_rules;
mod maps;
mod multipliers;
mod names;
mod one_coordinate;
mod parameters;
mod shared;
