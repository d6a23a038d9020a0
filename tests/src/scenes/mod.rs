//! Random planar scenes: trees of bodies on rods, with springs, rods and wheels as constraints, and motors that obey
//! constraints of second order; and a second formulation of their steps that shares nothing with the attribute or the solver.
//!
//! [`scene`] is a scene as data with its mechanics in Cartesian terms, [`discrete`] its steps in double the precision, [`random`]
//! draws scenes and states, and [`hold`] holds a declared system against its scene.

pub mod discrete;
pub mod double;
pub mod hold;
pub mod number;
pub mod random;
pub mod scene;
pub mod text;
