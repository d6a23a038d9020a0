//! Kinematic constraints without variational ones.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    kinematic = dot(x) * ddot(y) - ddot(x) * dot(y);
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
