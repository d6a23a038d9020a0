//! Forces for neither the kinematic constraints nor all.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y, z);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
    holonomic = x.powi(2) + y.powi(2) - 1;
    nonholonomic = dot(z) - y * dot(x);
    constraint_forces = [(1, 0, 0)];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
