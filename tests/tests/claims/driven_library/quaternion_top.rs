//! The heavy top against steady precession, Euler's equations in the body, and its integrals.

use dsocs_core::geometry::{DiscreteFlow, momentum_map};
use dsocs_core::{Flow, Start, Stepper, System};
use dsocs_systems::QuaternionTop;

use super::is_second;
use dsocs_tests::dop853;
use dsocs_tests::motion::{continuous, discrete, distance};

#[test]
fn it_precesses_steadily_at_the_known_rate() {
    let top = QuaternionTop::default();
    for (theta, precession) in [(0.5, 3.0), (1.2, -2.0), (2.0, 5.0)] {
        let spin = top.spin_of_precession(theta, precession);
        let axial = spin + precession * f64::cos(theta);
        let balance = top.inertia_1 * theta.cos() * precession.powi(2) - top.inertia_3 * axial * precession;
        assert!((balance + top.weight * top.lever).abs() < 1e-13);
        let at = |t: f64| QuaternionTop::state([theta, precession * t, spin * t], [0.0, precession, spin]);
        let (q, v) = at(0.0);
        let node = continuous(&top, Start::second_order(q, v), 2.0);
        let (known, velocity) = at(2.0);
        let apart = [distance(&node.q, &known), distance(&node.v, &velocity)];
        println!("θ = {theta}, spin {spin:.2}: apart by {apart:?}");
        assert!(apart[0] < 1e-11 && apart[1] < 5e-10, "{apart:?}");
        is_second("precession", [0.001, 0.0005, 0.00025, 0.000_125], |h| {
            distance(&discrete(&top, h, Start::second_order(q, v), 1.0).q, &at(1.0).0)
        });
    }
}

/// The angular velocity and the vertical in the body, of a quaternion and its rate; products of quaternions.
fn in_the_body([w, x, y, z]: [f64; 4], [dw, dx, dy, dz]: [f64; 4]) -> [f64; 6] {
    [
        2.0 * (w * dx - x * dw - y * dz + z * dy),
        2.0 * (w * dy - y * dw - z * dx + x * dz),
        2.0 * (w * dz - z * dw - x * dy + y * dx),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        w * w - x * x - y * y + z * z,
    ]
}

#[test]
fn it_obeys_eulers_equations() {
    let top = QuaternionTop::default();
    let (q, v) = QuaternionTop::state([0.6, 0.2, -0.4], [0.5, 1.0, 25.0]);
    let rate = |[a, b, c, p, q, r]: [f64; 6]| {
        let (i1, i3, m) = (top.inertia_1, top.inertia_3, top.weight * top.lever);
        [
            ((i1 - i3) * b * c + m * q) / i1,
            ((i3 - i1) * c * a - m * p) / i1,
            0.0,
            q * c - r * b,
            r * a - p * c,
            p * b - q * a,
        ]
    };
    let known = dop853::integrate(|_, state| rate(state), in_the_body(q, v), 3.0, 1e-14);
    let node = continuous(&top, Start::second_order(q, v), 3.0);
    let apart = distance(&in_the_body(node.q, node.v), &known);
    println!("apart by {apart:.1e}");
    assert!(apart < 1e-10, "{apart:e}");
    let known = continuous(&top, Start::second_order(q, v), 1.0).q;
    is_second("attitude", [0.001, 0.0005, 0.00025, 0.000_125], |h| {
        distance(&discrete(&top, h, Start::second_order(q, v), 1.0).q, &known)
    });
}

#[test]
fn the_momenta_are_kept_and_the_energy_does_not_drift() {
    let top = QuaternionTop::default();
    let (q, v) = QuaternionTop::state([0.6, 0.2, -0.4], [0.5, 1.0, 25.0]);
    let run = |h: f64| {
        let map = DiscreteFlow::new(&top, h).unwrap();
        let mut flow = Flow::new(&top, h, Start::second_order(q, v)).unwrap();
        let momenta = |flow: &Flow<'_, 4>| {
            let leg = flow.leg();
            [
                momentum_map(&map, leg.any(), &|q| {
                    vec![-q[3] / 2.0, -q[2] / 2.0, q[1] / 2.0, q[0] / 2.0]
                }),
                momentum_map(&map, leg.any(), &|q| {
                    vec![-q[3] / 2.0, q[2] / 2.0, -q[1] / 2.0, q[0] / 2.0]
                }),
            ]
        };
        let (first, energy) = (momenta(&flow), top.energy(0.0, &q, &v));
        let (mut worst, mut early, mut late) = ([0.0_f64; 2], 0.0_f64, 0.0_f64);
        while flow.time() < 40.0 {
            flow.advance().unwrap();
            let now = momenta(&flow);
            worst[0] = worst[0].max(distance(&now, &first));
            let length: f64 = flow.position().iter().map(|x| x * x).sum();
            worst[1] = worst[1].max((length - 1.0).abs());
            let change = (flow.node().energy - energy).abs();
            if flow.time() < 20.0 {
                early = early.max(change);
            } else {
                late = late.max(change);
            }
        }
        println!(
            "h = {h}: momenta {:.1e}, length {:.1e}, energy {early:.2e}, {late:.2e}",
            worst[0], worst[1]
        );
        assert!(worst[0] < 1e-13 && worst[1] < 1e-14, "{worst:?}");
        assert!(late < 1.05 * early, "{early:e} {late:e}");
        early
    };
    let (coarse, fine) = (run(0.002), run(0.001));
    assert!((coarse / fine / 4.0 - 1.0).abs() < 0.05, "{coarse:e} {fine:e}");
    // the discrete momenta are those of the motion, to second order
    let mut observed = [0.0; 3];
    top.observe(
        &continuous(&top, Start::second_order(q, v), 1.0).point(),
        &mut observed,
    );
    let map = DiscreteFlow::new(&top, 0.001).unwrap();
    let flow = Flow::new(&top, 0.001, Start::second_order(q, v)).unwrap();
    let axial = momentum_map(&map, flow.leg().any(), &|q| {
        vec![-q[3] / 2.0, q[2] / 2.0, -q[1] / 2.0, q[0] / 2.0]
    });
    assert!((axial / observed[2] - 1.0).abs() < 1e-3, "{axial} {observed:?}");
}
