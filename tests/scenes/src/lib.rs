//! Random planar scenes: trees of bodies on rods, with springs, rods and wheels as constraints, and motors that obey
//! constraints of second order; and a second formulation of their steps that shares nothing with the attribute or the solver.
//!
//! [`scene`] is a scene as data with its mechanics in Cartesian terms, [`discrete`] its steps in double the precision, [`random`]
//! draws scenes and states, and [`exact`] follows a motion with what rounding does to it. [`text`] writes scenes out as declarations, and [`table`]
//! some of them for the table of hard cases.
//!
//! It is a crate of its own because tests wait for its arithmetic, which is optimized therefore, and not for their own.

pub mod discrete;
pub mod double;
pub mod exact;
pub mod number;
pub mod random;
pub mod scene;
pub mod table;
pub mod text;
