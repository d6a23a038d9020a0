//! Random planar scenes: trees of bodies on rods, with springs, rods and wheels as constraints, and motors that obey
//! constraints of second order; and a second formulation of their steps that shares nothing with the attribute or the solver.
//!
//! [`scene`] is a scene as data with its mechanics in Cartesian terms, [`discrete`] its steps in double the precision, [`random`]
//! draws scenes and states, [`exact`] follows a motion with what rounding does to it, and [`hold`] holds a declared system against its
//! scene. [`text`] writes scenes out as declarations, and [`table`] some of them for the table of hard cases.

pub mod discrete;
pub mod double;
pub mod exact;
pub mod hold;
pub mod number;
pub mod random;
pub mod scene;
pub mod table;
pub mod text;
