//! A field whose components are a list of fields.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    kinematic = ddot(x);
    variational = (dot(x), dot(y));
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
