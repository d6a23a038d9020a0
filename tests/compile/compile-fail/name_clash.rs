//! Names that have a meaning already.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta, dot);
    let theta = 2;
    let mass = 3;
    lagrangian = dot(theta).powi(2);
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
