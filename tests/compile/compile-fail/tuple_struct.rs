//! A struct without names.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = dot(theta).powi(2);
}]
pub struct Pendulum(pub f64);

fn main() {}
