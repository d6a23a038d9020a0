//! Derivatives beyond the second.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let acceleration = ddot(x);
    kinematic = dot(ddot(x)) + dot(acceleration * y);
    variational = [(1, 0)];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
