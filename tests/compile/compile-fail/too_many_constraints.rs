//! More constraints than coordinates.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    holonomic = x - y;
    nonholonomic = [dot(x) - y, dot(y) - x];
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
