//! Coordinates and derivatives in a map.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let speed = dot(x);
    phi_lagrangian = |q0, q1| (q0, (x, y));
    phi_kinematic = |q0, q1, q2| (q1, dot(q1), (speed, 0));
}]
pub struct Particle {
    pub mass: f64,
}

fn main() {}
