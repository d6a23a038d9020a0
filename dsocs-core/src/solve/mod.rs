//! Equations: vectors and matrices of any size, and Newton's iteration.
//!
//! [`unknown`] defines the unknowns, [`predictor`] guesses them from past solutions, [`newton`] iterates
//! until [`convergence`] says that the error is small, and [`failure`] lists the reasons why it may not be.
//! [`elimination`] solves linear equations, [`sparse`] those with many zeros; [`dense`] decomposes small
//! matrices, and [`eigenvalues`] finds their eigenvalues.

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
