//! Methods that numbers do not have, with names like those that they have; a user's own is found first. What a method is called elsewhere is
//! in `elsewhere.rs`.

use dsocs_core::{Real, dsocs};

trait Wave {
    fn cube(self) -> Self;
    fn sqr(&self) -> Self;
}

impl<R: Real> Wave for R {
    fn cube(self) -> Self {
        self * self * self
    }
    fn sqr(&self) -> Self {
        *self * *self
    }
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.cube() - y.sqr() - x.sinn();
}]
pub struct Slider;

fn main() {}
