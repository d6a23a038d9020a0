//! Things that are no numbers.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = mass * "1" + 1f32 * dot(theta) ^ 2 + (theta, mass) + teeth * dot(theta);
}]
pub struct Pendulum {
    pub mass: f64,
    pub teeth: usize,
}

fn main() {}
