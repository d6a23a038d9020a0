//! Maps of no known name.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    phi_lagrangian = midpiont;
    phi_kinematic = trapezoid;
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
