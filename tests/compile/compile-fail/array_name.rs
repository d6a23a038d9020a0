//! The coordinates of an array have names.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta: [3]);
    let theta_2 = dot(theta[2]);
    lagrangian = sum(0..3, |i| masses[i] * dot(theta[i]).powi(2)) + theta_2;
}]
pub struct Chain {
    pub masses: [f64; 3],
    pub masses_0: f64,
}

fn main() {}
