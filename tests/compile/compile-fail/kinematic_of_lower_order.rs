//! Constraints of positions and of velocities among those of accelerations.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y, z);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
    kinematic = [x.powi(2) + y.powi(2) - 1, dot(x) + x, ddot(z) - ddot(z) + dot(z)];
    variational = [];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
