//! A component of a node that is no coordinate.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    phi_lagrangian = |q0, q1| (q0, ((q1.x - q0.x) / h, (q1.z - q0.2) / h));
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
