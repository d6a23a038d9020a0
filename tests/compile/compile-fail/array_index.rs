//! Indices out of range, that vary with the motion, that are missing, or that are one too many.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, theta: [8]);
    let kinetic = sum(0..8, |i| masses[i] / 2 * dot(theta[i]).powi(2)) + dot(theta).powi(2);
    let springs = sum(0..8, |i| (theta[i + 1] - theta[i]).powi(2));
    lagrangian = kinetic - springs - theta[x] - x[0];
}]
pub struct Chain {
    pub masses: [f64; 7],
}

fn main() {}
