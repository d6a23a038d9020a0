//! Wrong numbers of arguments.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    let a = theta.sin(2) + theta.powi(mass) + theta.atan2() + dot(theta, theta);
    lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
