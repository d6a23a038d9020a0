//! A macro, which cannot be seen into.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = mass * square!(dot(theta));
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
