//! From a checked declaration to its code; nothing here can fail.
//!
//! [`crate::mechanics`] says what has to vanish, [`crate::passes`] make it fast; here code is written, and nothing else.
//! [`program`] turns expressions into operations, [`stages`] says when those of a step are computed. They are written twice:
//! [`hot`], what a run evaluates often, as straight-line code, which [`kernel`] puts behind slices, and [`cold`], all of them, as a tape. [`jets`] writes the
//! recurrences of Taylor series, as code or as data, and [`phase`] how a motion is brought back onto constraints. [`functions`] is where all of them call the user's functions.
//! [`system`] puts everything together.

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
