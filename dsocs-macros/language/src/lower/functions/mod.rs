//! Calls: functions of the language, of the declaration and of the user, and expressions of the parameters.

pub(crate) mod builtin;
mod call;
pub(crate) mod closed;
mod function;
