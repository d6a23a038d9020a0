//! A `let` below its use.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = kinetic + mass * theta.cos();
    let kinetic = mass / 2 * dot(theta).powi(2);
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
