//! Functions that are methods, and methods without derivative.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    let a = sin(theta) + theta.floor() + f64::sine(theta) + theta(2);
    lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
