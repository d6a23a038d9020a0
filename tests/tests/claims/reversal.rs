//! The step is symmetric in time: a motion that is run back returns to its start.

use dsocs_core::{Flow, Start, Stepper};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum, Wavy};
use dsocs_tests::closed_form::pendulum::START;

/// Runs forward and back, and returns the largest distance of the first two nodes from their first positions.
fn there_and_back<S: dsocs_core::System<2>>(system: &S, h: f64, start: Start<2>, steps: u32) -> f64 {
    let mut flow = Flow::new(system, h, start).unwrap();
    let (second, leg) = (*flow.position(), flow.leg());
    let first = [second[0] - leg.d[0], second[1] - leg.d[1]];
    for _ in 0..steps {
        flow.advance().unwrap();
    }
    // the first step back
    flow.reverse().unwrap();
    assert!((flow.h() + h).abs() == 0.0);
    let mut before = *flow.position();
    for _ in 1..steps {
        before = *flow.position();
        flow.advance().unwrap();
    }
    let after = *flow.position();
    assert!(flow.time().abs() < 1e-9, "back at t = {}", flow.time());
    let distance = |x: [f64; 2], y: [f64; 2]| (x[0] - y[0]).abs().max((x[1] - y[1]).abs());
    let largest = distance(after, first).max(distance(before, second));
    println!("{steps} steps of {h} there and back: {largest:e}");
    largest
}

/// Each step leaves an error of about `ε |e|/|d|` in the length of a leg (see `energy.rs`), and the turning angle is
/// proportional to the length. So the turning angle makes a random walk, and the phase is its sum: after `N` steps it
/// is off by `N^1.5 α ε |e|/|d|`. With 10⁵ steps and `α = |e|/|d| = 0.14` this is 1e-10.
#[test]
fn the_particle_returns_after_a_hundred_thousand_steps() {
    let start = Start::second_order([0.0, 0.0], [1.0, 1.0]);
    assert!(there_and_back(&CurvedParticle::default(), 0.1, start, 100_000) <= 1e-10);
    let wavy = CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    };
    // where the curvature varies, rounding is magnified on the way
    assert!(there_and_back(&wavy, 0.1, start, 1000) <= 1e-11);
}

/// The pendulum is damped, so that its backward flow is unstable: `w` shrinks forward like `exp(−kρ t)` within the switch
/// (`|w| < 1`, `kρ ≈ 10` per second), and backward it grows by `(1 + kρh/2)/(1 − kρh/2)` a step. While `|w| > 20` the
/// switch is saturated, `tanh w = ±1` exactly, and nothing is damped: that is the case for the first seconds.
#[test]
fn the_pendulum_returns_while_its_switch_is_saturated() {
    let system = InertiaWheelPendulum::default();
    assert!(there_and_back(&system, 0.1, Start::second_order(START.0, START.1), 300) <= 1e-9);
    assert!(there_and_back(&system, 0.01, Start::second_order(START.0, START.1), 3000) <= 1e-9);
}
