//! Observed names that are no `let`.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
    let energy = dot(theta).powi(2);
    observe = [enery, theta, 2 * energy];
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
