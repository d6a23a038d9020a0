//! A factor for one of two rows.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    kinematic = [ddot(x) * dot(x), ddot(y) * dot(y)];
    variational = [];
    branch = divide(dot(x));
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
