//! What a declaration is evaluated with: doubles, lanes, derivatives, bounds of rounding, sums that carry their rounding.

pub(crate) mod array;
pub(crate) mod bounded;
pub(crate) mod compensated;
pub(crate) mod composition;
pub(crate) mod dispatch;
pub(crate) mod double;
pub(crate) mod dual;
pub(crate) mod instructions;
pub(crate) mod lanes;
pub(crate) mod message;
pub(crate) mod point;
pub(crate) mod real;
pub(crate) mod scalar;
pub(crate) mod tangent;
