//! Expressions of the motion among nodes.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let v = dot(x);
    discrete_lagrangian = v * (x[1] - x[0]) / h + y - leg(ddot(x), 0) + x[2] + dot(y);
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
