//! A constraint of positions alone.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    kinematic = x.powi(2) + y.powi(2) - 1;
    variational = [(-y, x)];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
