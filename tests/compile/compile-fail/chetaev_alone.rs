//! Chetaev's rule without a kinematic constraint.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    holonomic = x - y;
    variational = chetaev;
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
