//! An acceleration in a constraint of velocities, and one of positions.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    nonholonomic = [ddot(x) - y, x - y];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
