//! Two forces in the same direction.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y, z);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
    kinematic = [ddot(x) + x, ddot(y) + y];
    constraint_forces = [(1, 0, -1), (-2, 0, 2)];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
