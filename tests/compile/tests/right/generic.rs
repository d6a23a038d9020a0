//! Generic structs: types with bounds, where clauses, lifetimes and constants.

use std::fmt::Debug;

use dsocs_core::{Real, System, dsocs};

pub trait Curvature {
    fn at<R: Real>(&self, x: R, y: R) -> R;
}

pub struct Waves;

impl Curvature for Waves {
    fn at<R: Real>(&self, x: R, y: R) -> R {
        x.sin() * y.cos() + 1.0
    }
}

/// A particle in a field of curvature.
#[dsocs {
    coordinates(x, y);
    lagrangian = masses[N - 1] * weight / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature.at(x, y);
    variational = [(dot(x), dot(y))];
}]
#[derive(Clone, Debug)]
pub struct Particle<'a, K: Curvature, T, const N: usize>
where
    T: Debug + 'a,
{
    pub masses: [f64; N],
    pub weight: &'a f64,
    pub curvature: K,
    pub label: &'a T,
}

#[test]
fn works() {
    let weight = 2.0;
    let system = Particle {
        masses: [1.0, 3.0],
        weight: &weight,
        curvature: Waves,
        label: &"particle",
    };
    assert_eq!(System::lagrangian(&system, 0.0, &[0.0, 0.0], &[1.0, 0.0]), 3.0);
}
