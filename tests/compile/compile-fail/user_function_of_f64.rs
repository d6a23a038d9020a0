//! A function of the user's that knows `f64` only cannot be differentiated.

use dsocs_core::dsocs;

fn friction(v: f64) -> f64 {
    v.abs()
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = ddot(x) + friction(dot(x));
    constraint_forces = [(1, 0)];
}]
pub struct Slider;

fn main() {}
