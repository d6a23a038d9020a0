//! A user's function of `f64` alone cannot be differentiated; in an observed expression it need not be.

use dsocs_core::{Real, dsocs};

fn friction(v: f64) -> f64 {
    v.abs()
}

fn absolute<R: Real>(v: R) -> f64 {
    v.abs().re()
}

struct Field;

impl Field {
    fn at(&self, x: f64, y: f64) -> f64 {
        x * y
    }
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - field.at(x, y) - absolute(x);
    kinematic = ddot(x) + friction(dot(x)) + dot(friction(y));
    constraint_forces = [(1, 0)];
    let loss = friction(dot(x) * dot(y));
    observe = [loss];
}]
pub struct Slider {
    field: Field,
}

fn main() {}
