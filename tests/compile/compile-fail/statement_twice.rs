//! A statement that stands twice.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
    lagrangian = mass * dot(theta).powi(2);
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
