//! A function like those that a declaration calls, asked for the weight of an integer.

use dsocs_core::{Real, dsocs};

fn weight<R: Real>(x: R) -> R {
    x * 0.5
}

fn drag<R: Real>(v: R) -> R {
    let _ = weight(2);
    v
}

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - drag(x);
}]
pub struct Slider;

fn main() {}
