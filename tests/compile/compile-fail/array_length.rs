//! Arrays of coordinates whose length is no literal, or in another place.

use dsocs_core::dsocs;

const LINKS: usize = 8;

#[dsocs {
    coordinates(theta: [LINKS], phi: [f64; 3], psi[2]);
    lagrangian = sum(0..8, |i| dot(theta[i]).powi(2));
}]
pub struct Chain;

fn main() {}
