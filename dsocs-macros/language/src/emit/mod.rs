//! From a checked declaration to its code. Nothing here can fail.
//!
//! [`crate::mechanics`] forms the equations and [`crate::passes`] make them fast; here they are only written.
//! [`program`] turns expressions into operations, and [`stages`] decides when those of a step are computed.
//! They are written twice: [`hot`] writes those that a run evaluates often as straight-line code, which
//! [`kernel`] puts behind slices, and [`cold`] writes all of them as a tape. [`jets`] writes the recurrences
//! of Taylor series, as code or as data, and [`phase`] the projection of a motion onto constraints of lower
//! order. All of them call the user's functions through [`functions`]. [`system`] puts everything together.

mod cold;
mod data;
mod facts;
mod functions;
mod hot;
pub(crate) mod jets;
pub(crate) mod kernel;
mod phase;
pub(crate) mod pieces;
mod program;
mod stages;
mod system;

pub use data::{Call, Data, Quantity};
pub use jets::Series;
pub(crate) use jets::series;
pub(crate) use system::{data, expand};

#[cfg(test)]
mod tests;
