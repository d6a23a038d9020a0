//! A force whose displacements have no basis that could be found: its multiplier is unknown.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y, z);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
    kinematic = ddot(x) + x;
    constraint_forces = [(x, y, z)];
}]
pub struct Particle {
    pub mass: f64,
}
