//! Equations: vectors and matrices of any size.

pub(crate) mod vector;

pub(crate) use vector::{Square, Vector, is_finite};
