//! A function.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = dot(theta).powi(2);
}]
pub fn pendulum() {}

fn main() {}
