//! A Taylor flow resolves small unknowns in any unit: beside larger ones, at rest without a force, and where
//! two slow masses pass each other.

use dsocs_core::{Start, Stepper, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::text::System;

declared! {
    /// A stiffening spring with deflections of order `size`, and an uncoupled rotor.
    #[derive(Clone, Debug)]
    struct WithRotor { size: f64 }
    coordinates(x, angle);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 - (x / size).powi(2) * x.powi(2) / 4 + dot(angle).powi(2) / 2;
}

#[test]
fn a_small_unknown_is_as_right_as_it_is_alone() {
    // x'' = -x - x³ from 1 at rest, by the Runge–Kutta method of order 4
    let alone = {
        let (mut x, mut v, steps) = (1.0_f64, 0.0_f64, 400_000);
        let h = 20.0 / f64::from(steps);
        let a = |x: f64| -x - x.powi(3);
        for _ in 0..steps {
            let [k1, l1] = [v, a(x)];
            let [k2, l2] = [v + 0.5 * h * l1, a(x + 0.5 * h * k1)];
            let [k3, l3] = [v + 0.5 * h * l2, a(x + 0.5 * h * k2)];
            let [k4, l4] = [v + h * l3, a(x + h * k3)];
            x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        }
        x
    };
    for size in [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-30] {
        for tolerance in [1e-7, 1e-9, 1e-11] {
            let system = WithRotor { size };
            let start = Start::second_order([size, 0.0], [0.0, 1.0]);
            let mut flow = system.series(start, Tolerance::relative(tolerance)).unwrap();
            flow.to(20.0).unwrap();
            let found = flow.node().q[0] / size;
            // a thousand times the tolerance, over some thirty steps
            assert!(
                (found - alone).abs() < 3e4 * tolerance,
                "{size} {tolerance}: {found} {alone}"
            );
        }
    }
}

declared! {
    /// A mass that moves in one direction, and in the other rests but for rounding: this must not shorten the
    /// steps.
    struct Symmetric;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - (x + y).powi(4) / 4;
}

/// A combination of coordinates that is zero up to rounding does not shorten the steps: less than 200 of them
/// to t = 20.
#[test]
fn what_is_only_rounding_makes_no_short_steps() {
    // x + y moves alone; x - y is zero but for rounding
    let start = Start::second_order([0.1 + 0.2, 0.3], [1.0 / 3.0, 1.0 - 2.0 / 3.0]);
    let mut flow = Symmetric.series(start, Tolerance::relative(1e-12)).unwrap();
    let mut steps = 0;
    while flow.node().t < 20.0 {
        flow.advance().unwrap();
        steps += 1;
    }
    assert!(steps < 200, "{steps}");
}

declared! {
    /// A mass at rest until a pulse.
    struct RestingMass;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = if (4 * t).sin() > 0.9 { 20 } else { 0 };
}

#[test]
fn a_mass_at_rest_without_a_force_waits_for_a_pulse() {
    let (begin, end) = (
        0.9_f64.asin() / 4.0,
        (core::f64::consts::PI - 0.9_f64.asin()) / 4.0,
    );
    let right = 10.0 * ((1.0 - begin).powi(2) - (1.0 - end).powi(2));
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let start = Start::second_order([0.0], [0.0]);
        let mut flow = RestingMass.series(start, Tolerance::relative(tolerance)).unwrap();
        flow.to(1.0).unwrap();
        let found = flow.node().q[0];
        assert!(
            (found - right).abs() < 1e3 * tolerance,
            "{tolerance}: {found} {right}"
        );
    }
}

declared! {
    /// Two blocks with friction between them.
    struct Blocks;
    coordinates(x, y);
    lagrangian = 0.73 * dot(x).powi(2) / 2 + 1.25 * dot(y).powi(2) / 2 - 3.89 * x.powi(2) / 2 - 1.98 * y.powi(2) / 2 - 1.3 * (x - y).powi(2) / 2;
    let dry = 0.45 * (dot(x) - dot(y)).signum();
    external_forces = (-0.1 * dot(x) - dry, 1.18 * (0.84 * t).sin() + dry);
}

/// The positions of two blocks that stop and start sliding on each other are those of scipy's DOP853 with
/// events, to 1e-8 and 100 tolerances.
#[test]
fn two_slow_blocks_may_stop_sliding() {
    // by scipy's DOP853 with events at the stops and the releases
    let right = [-0.180_147_03, -0.124_502_52];
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let start = Start::second_order([-0.17, -0.55], [-0.48, -0.58]);
        let mut flow = Blocks.series(start, Tolerance::relative(tolerance)).unwrap();
        flow.to(4.0).unwrap();
        let found = flow.node().q;
        for (found, right) in found.iter().zip(right) {
            assert!(
                (found - right).abs() < 1e-8 + 100.0 * tolerance,
                "{tolerance}: {found} {right}"
            );
        }
    }
}
