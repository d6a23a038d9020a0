//! The systems of the library with constraints of positions and velocities: each against an exact solution, an invariant or an
//! independent formulation, and its order by a fit.

mod contact_oscillator;
mod exact_decrease;
mod knife_edge;
mod nonholonomic_particle;
mod planar_pendulum;
mod rod_and_wheel;
mod rolling_disk;
mod sleigh;
mod snakeboard;
mod sphere;

use dsocs_core::{Start, System};
use dsocs_systems::systems;
use dsocs_tests::fit::slope;
use dsocs_tests::motion::{self, discrete};

use dsocs_tests::dop853;

/// Errors below this are left out of a fit: rounding may be a part of them.
const PLATEAU: f64 = 1e-11;

/// The start that a system's entry gives.
fn start<const N: usize>(name: &str) -> ([f64; N], [f64; N]) {
    let mut entries = systems::all().into_iter();
    let entry = entries.find(|entry| entry.name() == name).unwrap();
    let [q0, v0] = entry.default_start().unwrap().clone();
    (q0.try_into().unwrap(), v0.try_into().unwrap())
}

/// The continuous motion of the declaration.
fn continuous<S: System<N>, const N: usize>(
    system: &S,
    (q, v): ([f64; N], [f64; N]),
    t: f64,
) -> ([f64; N], [f64; N]) {
    let node = motion::continuous(system, Start::second_order(q, v), t);
    (node.q, node.v)
}

/// The order with which the discrete motion converges to an exact position, by a fit over the errors above the plateau.
fn order<S: System<N>, const N: usize>(
    system: &S,
    (q, v): ([f64; N], [f64; N]),
    t: f64,
    steps: &[f64],
    error: impl Fn(&[f64; N]) -> f64,
) -> f64 {
    fitted(steps, |h| {
        error(&discrete(system, h, Start::second_order(q, v), t).q)
    })
}

/// The slope of the errors above the plateau.
fn fitted(steps: &[f64], error: impl Fn(f64) -> f64) -> f64 {
    let all: Vec<f64> = steps.iter().map(|&h| error(h)).collect();
    let kept = steps.iter().zip(&all).filter(|(_, error)| **error > PLATEAU);
    let (steps, errors): (Vec<f64>, Vec<f64>) = kept.unzip();
    assert!(errors.len() >= 3, "too few errors above rounding: {all:?}");
    let order = slope(&steps, &errors);
    println!("errors {all:?}, order {order:.4}");
    order
}

/// The bar of an order of two.
fn is_second(order: f64) {
    assert!((order - 2.0).abs() < 0.05, "{order}");
}

/// The state after a time, by a published Runge–Kutta method of order 8(5,3).
fn integrate<const N: usize>(state: [f64; N], t: f64, rate: impl Fn([f64; N]) -> [f64; N]) -> [f64; N] {
    dop853::integrate(|_, state| rate(state), state, t, 1e-14)
}
