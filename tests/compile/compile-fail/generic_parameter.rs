//! A parameter of a generic type as a number.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    lagrangian = dot(theta).powi(2) - potential;
}]
pub struct Pendulum<P> {
    pub potential: P,
}

fn main() {}
