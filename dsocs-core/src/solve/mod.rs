//! Equations: vectors and matrices of any size.

pub(crate) mod vector;

pub(crate) use vector::{Numbers, Square, Vector, is_finite};
