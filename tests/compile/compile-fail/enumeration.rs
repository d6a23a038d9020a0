//! An enumeration.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = dot(theta).powi(2);
}]
pub enum Pendulum {
    Swinging,
}

fn main() {}
