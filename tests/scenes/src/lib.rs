//! Random planar scenes: trees of bodies on rods, with springs, rods and wheels as constraints, and motors that obey
//! constraints of second order; and a second formulation of their steps that shares nothing with the attribute or the solver.
//!
//! [`scene`] is a scene as data with its mechanics in Cartesian terms, [`discrete`] its steps in twice the
//! precision, [`random`] draws scenes and states, and [`exact`] follows a motion with the effect of rounding
//! on it. [`text`] writes scenes as declarations, and [`table`] some of them for the table of hard cases.
//!
//! It is a crate of its own so that its arithmetic, on which tests spend their time, is optimized, while the
//! tests are not.

pub mod discrete;
pub mod double;
pub mod exact;
pub mod number;
pub mod random;
pub mod scene;
pub mod table;
pub mod text;
