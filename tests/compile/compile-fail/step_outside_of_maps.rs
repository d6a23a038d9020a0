//! The step in the continuous system.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = mass * dot(theta).powi(2) / h;
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
