//! Compositions of the step for systems with rotations: the errors and orders at nodes, against equations written by hand.
//!
//! The errors expected here are those of an independent implementation, in Python with derivatives by JAX.

use dsocs_core::text::Text;
use dsocs_core::{AnyComposedFlow, AnyStart, Composition, Inputs as _, OwnedNode, Run, RunError, StageFailure, Symmetry};

use crate::rotations::{Motion, cross, joined, matrix, of_satellite, part, plus, rate, satellite, times, unit};

/// Systems with their methods: the errors of a step and its halves.
type Errors<'a> = &'a [(Composition, &'a [f64])];

/// Where a composed step of a text leads: position and velocity.
fn last(text: &Text, motion: &Motion, h: f64, method: Composition) -> Vec<f64> {
    let v0 = [&[0.0], motion.v0.as_slice()].concat();
    let start = AnyStart::second_order(&motion.q0, &v0);
    let mut flow = AnyComposedFlow::new(&text.system, h, method, &start).unwrap();
    flow.run_mut().to(motion.until).unwrap();
    let mut node = OwnedNode::new(motion.q0.len());
    node.take(flow.run());
    let node = node.any();
    let norm = node.q[..4].iter().map(|q| q * q).sum::<f64>().sqrt();
    assert!((norm - 1.0).abs() <= 2.0 * f64::EPSILON, "{norm}");
    [node.q, &node.v[1..]].concat()
}

/// Holds compositions to their errors, where these are above rounding.
#[track_caller]
fn holds(text: &str, motion: &Motion, h: f64, all: Errors<'_>) {
    let text = Text::parse("body", text).unwrap_or_else(|error| panic!("{error}"));
    let kernel: &dyn dsocs_core::Kernel = &text.system;
    assert_eq!(kernel.shape().symmetry, Symmetry::Momenta);
    let known = [motion.q.as_slice(), &motion.v].concat();
    for (method, expected) in all {
        let errors: Vec<f64> = (0..expected.len())
            .map(|halvings| {
                let found = last(&text, motion, h * 0.5_f64.powi(halvings as i32), *method);
                let apart = found.iter().zip(&known).map(|(found, known)| (found - known).abs());
                apart.fold(0.0, f64::max)
            })
            .collect();
        println!("{method}: {errors:?}");
        for (error, expected) in errors.iter().zip(*expected) {
            assert!((error / expected - 1.0).abs() < 0.05, "{method}: {errors:?} for {expected:e}");
        }
    }
}

#[test]
fn a_heavy_top() {
    let (inertia, arm) = ([2.0, 1.5, 1.0], [0.2, 0.1, 1.0]);
    let hand = |y: &[f64; 7]| {
        let (q, w) = (part(y, 0), part(y, 4));
        let momentum = [0, 1, 2].map(|i| inertia[i] * w[i]);
        let torque = plus(cross(momentum, w), cross(matrix(q)[2], arm));
        joined(&[&rate(q, w), &[0, 1, 2].map(|i| torque[i] / inertia[i])])
    };
    let motion = Motion::by_hand(hand, (&unit([1.0, 0.3, -0.4, 0.2]), &[0.6, -0.3, 3.0]), 2.0);
    let text = |maps: &str| {
        format!(
            "parameters {{ inertia = [[2.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 1.0]], arm = [0.2, 0.1, 1.0] }}
             coordinates(r: rotation);
             let w = r.angular_velocity();
             lagrangian = w.inner(inertia * w) / 2 - (r * arm)[2];
             {maps}"
        )
    };
    // of the paper's map the trapezoid's legs are taken
    for maps in ["", "phi_lagrangian = trapezoid;"] {
        holds(
            &text(maps),
            &motion,
            0.2,
            &[
                (Composition::SINGLE, &[8.92e-3, 2.23e-3, 5.59e-4, 1.40e-4]),
                (Composition::SUZUKI_4, &[2.34e-5, 1.46e-6, 9.15e-8, 5.72e-9]),
                (Composition::KAHAN_LI_6, &[1.60e-7, 2.50e-9, 3.89e-11]),
            ],
        );
    }
}
