//! The same thing from both sides.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    kinematic = ddot(x);
    variational = [(0, 1)];
    constraint_forces = [(1, 0)];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
