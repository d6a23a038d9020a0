//! Taylor series: their coefficients, the recurrences of the user's functions, and the pieces of a function.

// steps are compiled for the machine's own instructions: their callees have to be inlined
#![allow(clippy::inline_always)]
// zeros and whole steps are exact
#![allow(clippy::float_cmp)]
// recurrences are indexed by order, as in textbooks
#![allow(clippy::needless_range_loop)]

pub(crate) mod blocks;
pub(crate) mod coefficient;
pub(crate) mod convolutions;
pub mod formulas;
pub(crate) mod jet;
pub(crate) mod orders;
mod power;
pub(crate) mod roots;
pub(crate) mod rows;
pub(crate) mod sums;
pub(crate) mod switch;
pub(crate) mod whole;
