//! What is written elsewhere for what is written here in another way.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = (x_dot**2 + ydot.powi(2)) / 2 + lenght * dot(x);
    holonomic = x - y = 0;
    forces = [(1, -1)];
}]
pub struct Particle {
    pub n: f64,
    pub length: f64,
}

fn main() {}
