//! Taylor series: their coefficients, the recurrences of user functions, and the pieces of a function.

pub(crate) mod coefficient;
pub(crate) mod jet;
pub(crate) mod orders;
pub(crate) mod roots;
pub(crate) mod rows;
pub(crate) mod sums;
pub(crate) mod switch;
