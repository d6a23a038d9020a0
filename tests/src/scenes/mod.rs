//! Random planar scenes with a second formulation of their steps ([`dsocs_scenes`]), and [`compare`], which
//! compares a declared system with its scene.

pub use dsocs_scenes::{discrete, double, elimination, exact, number, random, scene, table, text};

pub mod compare;
