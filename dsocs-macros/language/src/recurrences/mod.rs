//! Taylor series of the continuous motion: the recurrences of a declaration.
//!
//! [`passes::motion`](crate::passes::motion) solves the continuous system for the accelerations, [`lower`] makes
//! sequences of coefficients of them ([`sequence`]), and [`plan`] orders the computation.

mod describe;
mod functions;
mod lower;
mod pairs;
pub(crate) mod plan;
mod running;
pub(crate) mod sequence;
mod switches;

#[cfg(test)]
mod tests;
