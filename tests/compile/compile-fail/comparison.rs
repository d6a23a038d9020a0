//! Comparisons and choices that have no value.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    let a = theta < 1;
    let b = if theta < 1 { 2 };
    let c = if theta == 1 { 2 } else { 3 };
    lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
