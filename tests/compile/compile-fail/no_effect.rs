//! A definition without effect gives a warning at its name.
#![deny(warnings)]

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y, z);
    let speed = dot(x) + dot(y);
    let _meant_so = dot(x);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x * z;
}]
pub struct Particle;

fn main() {}
