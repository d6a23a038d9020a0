//! Inputs of systems with rotations that change at nodes: held torques, and a variable inertia.

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::Text;
use dsocs_core::{AnyComposedFlow, AnyFlow, AnyStart, Composition, OwnedNode, Run, Tolerance};

use crate::rotations::{joined, part};
use dsocs_tests::dop853;
use dsocs_tests::vectors::{Vector, cross, matrix, plus, rate, times, unit};

/// The values of the inputs from 0, 0.4, 0.8 … on: a torque in the frame of the body, and the moment of inertia about its third axis.
const INPUTS: [([f64; 3], f64); 4] = [
    ([0.5, 0.0, -0.2], 1.0),
    ([-0.8, 0.3, 0.4], 1.0),
    ([-0.8, 0.3, 0.4], 1.8),
    ([0.0, -0.6, 0.0], 0.7),
];

/// The time for which each is held.
const HELD: f64 = 0.4;

const ARM: Vector = [0.2, 0.1, 1.0];

fn start() -> ([f64; 4], Vector) {
    (unit([1.0, 0.3, -0.4, 0.2]), [0.6, -0.3, 3.0])
}

/// The motion of a heavy top with drag, by DOP853: its momentum is continuous where its inertia changes. If
/// bound, it does not turn about its second axis.
fn motion(bound: bool) -> [f64; 7] {
    let (q, mut w) = start();
    if bound {
        w[1] = 0.0;
    }
    let mut y: [f64; 7] = joined(&[&q, &w]);
    let mut third = INPUTS[0].1;
    for (torque, inertia) in INPUTS {
        y[6] *= third / inertia;
        third = inertia;
        let inertia = [2.0, 1.5, inertia];
        let hand = |y: &[f64; 7]| {
            let (q, w): ([f64; 4], Vector) = (part(y, 0), part(y, 4));
            let momentum = [0, 1, 2].map(|i| inertia[i] * w[i]);
            let weight = cross(matrix(q)[2], ARM);
            let all = plus(plus(cross(momentum, w), weight), plus(times(-0.2, w), torque));
            let mut a = [0, 1, 2].map(|i| all[i] / inertia[i]);
            if bound {
                a[1] = 0.0;
            }
            joined(&[&rate(q, w), &a])
        };
        y = dop853::integrate_from(|_, y| hand(&y), (0.0, y), HELD, 1e-13);
    }
    y
}

/// Runs to the end with the inputs set at their times. A run whose known position is `ahead` of its node
/// needs them earlier by that.
fn run(flow: &mut dyn Run, ahead: f64) -> Vec<f64> {
    for (k, (torque, inertia)) in INPUTS.into_iter().enumerate() {
        for (place, value) in torque.into_iter().chain([inertia]).enumerate() {
            if k > 0 {
                flow.set_value(place, value).unwrap();
            }
        }
        let last = k + 1 == INPUTS.len();
        flow.to(HELD * (k + 1) as f64 - if last { 0.0 } else { ahead })
            .unwrap();
    }
    let mut node = OwnedNode::new(4);
    node.take(flow);
    let node = node.any();
    [node.q, &node.v[1..]].concat()
}

fn text(rows: &str) -> Text {
    let text = format!(
        "parameters {{ torque = [0.5, 0.0, -0.2], third = 1.0, arm = {ARM:?} }}
         coordinates(r: rotation);
         let w = r.angular_velocity();
         lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + third / 2 * w[2].powi(2) - (r * arm)[2];
         external_forces = torque - 0.2 * w;
         {rows}"
    );
    Text::parse("top", &text).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_step_is_of_second_order_whatever_changes_at_its_nodes() {
    for (rows, bound) in [
        ("", false),
        ("phi_lagrangian = trapezoid;", false),
        ("phi_lagrangian = midpoint;", false),
        ("kinematic = dot(w)[1]; constraint_forces = [[0, 1, 0]];", true),
        ("nonholonomic = w[1];", true),
    ] {
        let known = motion(bound);
        let text = text(rows);
        let (q0, mut w) = start();
        if bound {
            w[1] = 0.0;
        }
        let start = AnyStart::second_order(&q0, &[0.0, w[0], w[1], w[2]]);
        let errors = [40.0, 80.0, 160.0].map(|steps| {
            let h = HELD / steps;
            let mut flow = AnyFlow::new(&text.system, h, &start).unwrap();
            let found = run(flow.run_mut(), h);
            let apart = found[..4]
                .iter()
                .zip(&known)
                .map(|(found, known)| (found - known).abs());
            apart.fold(0.0, f64::max)
        });
        println!("{rows}: {errors:?}");
        for pair in errors.windows(2) {
            assert!(
                ((pair[0] / pair[1]).log2() - 2.0).abs() < 0.1,
                "{rows}: {errors:?}"
            );
        }
        assert!(errors[2] < 1e-4, "{rows}: {errors:?}");
        let mut taylor = AnyTaylorFlow::of_tape(&text.system, &start, Tolerance::relative(1e-15)).unwrap();
        let found = run(&mut taylor, 0.0);
        for (found, known) in found.iter().zip(&known) {
            assert!((found - known).abs() < 1e-11, "{rows}: {found} {known}");
        }
        if rows.contains("nonholonomic") {
            continue;
        }
        let errors = [4.0, 8.0, 16.0].map(|steps| {
            let mut flow =
                AnyComposedFlow::new(&text.system, HELD / steps, Composition::SUZUKI_4, &start).unwrap();
            let found = run(flow.run_mut(), 0.0);
            let apart = found
                .iter()
                .zip(&known)
                .map(|(found, known)| (found - known).abs());
            apart.fold(0.0, f64::max)
        });
        println!("{rows}, composed: {errors:?}");
        for pair in errors.windows(2) {
            assert!(
                ((pair[0] / pair[1]).log2() - 4.0).abs() < 0.2,
                "{rows}: {errors:?}"
            );
        }
    }
}
