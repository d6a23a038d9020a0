//! Factors that cannot be divided out.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y, z);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    kinematic = [ddot(x) * dot(x), ddot(y) * dot(y), ddot(x)];
    variational = [];
    branch = [divide(ddot(x)), divde(dot(y)), dot(x)];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
