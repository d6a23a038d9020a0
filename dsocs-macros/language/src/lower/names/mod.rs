//! Names: those of other languages, those without a meaning, and those that nothing uses.

pub(crate) mod foreign_names;
pub(crate) mod look_alike;
mod scope;
pub(crate) mod unknown_names;
pub(crate) mod unused;

pub(crate) use scope::{Binding, Function, Scope};
