//! A statement that is misspelt.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangean = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
