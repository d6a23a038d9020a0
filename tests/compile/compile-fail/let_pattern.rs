//! A `let` that is more than a name.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    let (a, b) = (1, 2);
    let c: f64 = 3;
    lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
