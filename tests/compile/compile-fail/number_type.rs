//! A function of the declaration's kind, called with a number that carries no derivatives and is no `f64`.

use dsocs_core::{Real, dsocs};

fn weight<R: Real>(x: R) -> R {
    x * 0.5
}

fn drag<R: Real>(v: R) -> R {
    v * f64::from(weight(1.0_f32))
}

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - drag(x);
}]
pub struct Slider;

fn main() {}
