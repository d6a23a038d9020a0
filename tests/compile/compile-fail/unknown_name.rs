//! A name that is nearly that of a coordinate, and one that is nearly that of a parameter.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = mas * length.powi(2) / 2 * dot(theta).powi(2) + mass * thetta.cos();
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
