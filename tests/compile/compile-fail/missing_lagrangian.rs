//! A declaration without a Lagrangian.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
