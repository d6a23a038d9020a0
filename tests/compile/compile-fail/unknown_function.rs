//! Functions and methods that do not exist.

use dsocs_core::{Real, dsocs};

pub struct Waves;

impl Waves {
    pub fn at<R: Real>(&self, x: R, y: R) -> R {
        x * y
    }
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - hight(x);
    kinematic = ddot(x) + waves.att(x, y);
    constraint_forces = [(1, 0)];
}]
pub struct Slider {
    pub waves: Waves,
}

fn main() {}
