//! Taylor series: their coefficients, the recurrences of user functions, and the pieces of a function.

// steps are compiled for the machine's own instructions, and what they call has to be inlined for that
#![allow(clippy::inline_always)]
// zeros and whole steps are exact
#![allow(clippy::float_cmp)]
// recurrences are read by order, as they stand in the books
#![allow(clippy::needless_range_loop)]

pub(crate) mod coefficient;
pub mod formulas;
pub(crate) mod jet;
pub(crate) mod orders;
mod power;
pub(crate) mod roots;
pub(crate) mod rows;
pub(crate) mod sums;
pub(crate) mod switch;
