//! Derivatives and differences of expressions.

pub(crate) mod derivative;
pub(crate) mod difference;
pub(crate) mod rotation;
