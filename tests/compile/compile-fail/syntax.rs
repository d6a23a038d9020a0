//! Syntax errors in two statements.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta);
    let kinetic = mass * ;
    let potential = mass theta.cos();
    lagrangian = kinetic - potential;
}]
pub struct Pendulum {
    pub mass: f64,
    pub length: f64,
}

fn main() {}
