//! Equations: vectors and matrices of any size, and Newton's iteration.
//!
//! [`unknown`] says what is looked for, [`predictor`] guesses it from past solutions, [`newton`] iterates until [`convergence`] says that it has
//! arrived, or says why not ([`failure`]). [`elimination`] solves linear rows, many of them by [`sparse`]; [`dense`] decomposes small matrices, and
//! [`eigenvalues`] has theirs.

pub(crate) mod convergence;
pub(crate) mod dense;
pub(crate) mod eigenvalues;
pub(crate) mod elimination;
pub(crate) mod failure;
pub(crate) mod newton;
pub(crate) mod predictor;
pub(crate) mod rotation;
pub(crate) mod sparse;
pub(crate) mod sum;
pub(crate) mod unknown;
pub(crate) mod vector;

pub(crate) use vector::{Numbers, Square, Vector, is_finite};
