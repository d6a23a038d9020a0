//! States of rest, and the linear model of a system at a state.

pub mod equilibrium;
pub mod linearize;
