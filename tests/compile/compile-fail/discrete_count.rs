//! A discrete constraint too many, and one that binds no last node.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    kinematic = ddot(x);
    constraint_forces = [(1, 0)];
    discrete_kinematic = [x[1] - x[0], x[2]];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
