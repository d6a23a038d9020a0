//! Accelerations in the Lagrangian.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    let jerky = 2 * ddot(theta);
    lagrangian = dot(theta).powi(2) + jerky;
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
