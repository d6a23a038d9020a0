//! A declaration without coordinates.

use dsocs_core::dsocs;

#[dsocs {
    lagrangian = mass * dot(theta).powi(2);
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
