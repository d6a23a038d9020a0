//! Values: numbers, vectors, matrices and rotations, their elements, and choices between them.

mod choice;
pub(crate) mod index;
pub(crate) mod rotations;
mod shape;
mod value;
pub(crate) mod vectors;

pub(crate) use value::{Value, Valued};
