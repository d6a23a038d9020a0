//! Maps with a wrong number of nodes, vectors and components.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    phi_lagrangian = |q0, q1, q2| (q1, (q2 - q0) / h);
    phi_kinematic = |q0, q1, q2| (q1, (q2 - q0) / h);
    phi_variational = |q0, q1, q2| (q1, (q2 - q0) / h, (0, 0, 0));
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
