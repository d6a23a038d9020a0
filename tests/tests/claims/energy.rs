//! The discrete Lagrangian of the particle, which is its energy, is constant to rounding.
//!
//! The variational equation says that all legs have one length. In exact arithmetic `L_d` is one number; with rounding,
//! each step leaves a relative error of a few units of `ε = 2.2e-16` in `e`, and so of `ε |e|/|d|` in the leg's length.
//! Legs are carried with compensated sums, so these errors are all there is: with random signs they add up to
//! `√steps · ε |e|/|d|`, and if they all had one sign to `steps · ε |e|/|d|`.

use dsocs_core::geometry::discrete_lagrangian;
use dsocs_core::{Flow, Start, Stepper, System};
use dsocs_systems::{Curvature as _, CurvedParticle, Wavy};

const STEPS: u32 = 5000;

/// The largest relative change of `L_d` over the run.
fn drift<S: System<2>>(system: &S, h: f64) -> f64 {
    let mut flow = Flow::new(system, h, Start::second_order([0.0, 0.0], [1.0, 1.0])).unwrap();
    let first = discrete_lagrangian(system.kernel(), h, flow.leg().any());
    let mut largest = 0.0_f64;
    for _ in 0..STEPS {
        flow.advance().unwrap();
        let value = discrete_lagrangian(system.kernel(), h, flow.leg().any());
        largest = largest.max((value / first - 1.0).abs());
    }
    println!("h = {h}: L_d changes by {largest:e} relative to {first}");
    largest
}

/// Rounding alone, with random signs and some luck: `√5000 ε |e|/|d| ≈ 70 · 2.2e-16 · 0.14 = 2e-15` at `h = 0.1`, to which
/// evaluating `L_d` from the rounded leg adds three roundings.
const BOUND: f64 = 5e-15;

#[test]
fn with_constant_curvature() {
    for h in [0.1, 0.01] {
        assert!(drift(&CurvedParticle::default(), h) <= BOUND);
    }
}

#[test]
fn with_a_curvature_that_varies() {
    let particle = CurvedParticle {
        mass: 2.5,
        curvature: Wavy::default(),
    };
    for h in [0.1, 0.01] {
        assert!(drift(&particle, h) <= BOUND);
    }
}

#[test]
fn and_the_force_does_no_work() {
    let particle = CurvedParticle {
        mass: 2.5,
        curvature: Wavy::default(),
    };
    let mut flow = Flow::new(&particle, 0.1, Start::second_order([0.0, 0.0], [1.0, 1.0])).unwrap();
    // without a step there is no force yet
    for node in flow.until(500.0).unwrap().nodes.iter().skip(1) {
        let work = node.force[0] * node.v[0] + node.force[1] * node.v[1];
        let size = node.force[0].hypot(node.force[1]) * node.v[0].hypot(node.v[1]);
        assert!(
            work.abs() <= 1e-14 * size,
            "node {}: power {work:e} of {size}",
            node.index
        );
        // m κ |v|² holds the particle on its path, to the side to which this turns
        let speed = node.v[0].hypot(node.v[1]);
        let pull = (node.v[0] * node.force[1] - node.v[1] * node.force[0]) / speed;
        let expected = particle.mass * particle.curvature.at(node.q[0], node.q[1]) * speed * speed;
        assert!(
            (pull - expected).abs() <= 1e-12 * particle.mass * speed * speed,
            "node {}: {pull:e}, not {expected:e}",
            node.index
        );
    }
}
