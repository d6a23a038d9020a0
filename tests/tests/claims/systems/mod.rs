//! Systems written twice: declared, and by hand.

pub mod builtin;
pub mod constrained;
pub mod maps;
pub mod mass;
pub mod opaque;
pub mod orders;
pub mod paper;
