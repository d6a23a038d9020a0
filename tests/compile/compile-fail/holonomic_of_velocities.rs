//! A velocity in a constraint of positions.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    holonomic = x.powi(2) + dot(y).powi(2) - 1;
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
