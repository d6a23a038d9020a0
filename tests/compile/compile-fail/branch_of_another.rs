//! A `branch` that is no factor of its constraint.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = dot(x) * ddot(y) - x;
    constraint_forces = [(0, 1)];
    branch = divide(dot(x));
}]
pub struct Particle;

fn main() {}
