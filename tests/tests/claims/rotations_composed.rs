//! Compositions of the step for systems with rotations: errors and orders at nodes, against equations by
//! hand.
//!
//! The expected errors are those of an independent implementation, in Python with derivatives by JAX.

use dsocs_core::text::Text;
use dsocs_core::{AnyComposedFlow, AnyStart, Composition, OwnedNode, Symmetry};

use crate::rotations::{
    DAMPING, Motion, fluid, heavy_top, joined, lyapunov, of_heavy_top, of_satellite, part, satellite,
};
use dsocs_tests::vectors::{cross, matrix, plus, rate, times, unit};

/// Methods, with the errors of a step and its halves.
type Errors<'a> = &'a [(Composition, &'a [f64])];

/// Position and velocity at the end of a composed run.
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

/// Checks the errors of compositions, where these are above rounding.
#[track_caller]
fn assert_errors(text: &str, motion: &Motion, h: f64, all: Errors<'_>) {
    let text = Text::parse("body", text).unwrap_or_else(|error| panic!("{error}"));
    let kernel: &dyn dsocs_core::Kernel = &text.system;
    assert_eq!(kernel.shape().symmetry, Symmetry::Momenta);
    let known = [motion.q.as_slice(), &motion.v].concat();
    for (method, expected) in all {
        let steps = [1.0, 0.5, 0.25, 0.125].map(|part| part * h);
        let errors: Vec<f64> = steps[..expected.len()]
            .iter()
            .map(|h| {
                let found = last(&text, motion, *h, *method);
                let apart = found
                    .iter()
                    .zip(&known)
                    .map(|(found, known)| (found - known).abs());
                apart.fold(0.0, f64::max)
            })
            .collect();
        println!("{method}: {errors:?}");
        for (error, expected) in errors.iter().zip(*expected) {
            assert!(
                (error / expected - 1.0).abs() < 0.05,
                "{method}: {errors:?} for {expected:e}"
            );
        }
    }
}

#[test]
fn a_heavy_top() {
    let motion = heavy_top(2.0);
    // with the paper's map the legs of the trapezoid are taken
    for maps in ["", "phi_lagrangian = trapezoid;"] {
        assert_errors(
            &of_heavy_top(maps),
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

#[test]
fn a_satellite() {
    let motion = satellite(
        |error, w, momentum| {
            let damped = [0, 1, 2].map(|i| DAMPING[i] * w[i]);
            plus(plus(error, damped), times(-1.0, cross(w, momentum)))
        },
        4.0,
    );
    let text = of_satellite(
        "kinematic = inertia * dot(w) + e + damping * w;
         constraint_forces = each(0..3, |i| (0, |j| if i == j { 1 } else { 0 }));
         phi_lagrangian = trapezoid;",
    );
    assert_errors(
        &text,
        &motion,
        0.4,
        &[
            (Composition::SINGLE, &[4.69e-1, 1.17e-1, 2.92e-2, 7.29e-3]),
            (Composition::SUZUKI_4, &[1.44e-3, 9.19e-5, 5.78e-6, 3.62e-7]),
            (Composition::KAHAN_LI_6, &[4.97e-5, 7.86e-7, 1.23e-8, 1.92e-10]),
        ],
    );
}

#[test]
fn a_satellite_under_a_lyapunov_row() {
    let (motion, text) = lyapunov(0.5);
    assert_errors(
        &text,
        &motion,
        0.1,
        &[
            (Composition::SINGLE, &[8.34e-3, 2.09e-3, 5.21e-4, 1.30e-4]),
            (Composition::SUZUKI_4, &[6.41e-6, 4.07e-7, 2.55e-8, 1.60e-9]),
            (Composition::KAHAN_LI_6, &[1.13e-8, 1.84e-10, 2.69e-12]),
        ],
    );
}

/// Checks that the errors at the end of a motion have the order of the method, over several numbers of steps.
#[track_caller]
fn has_order(text: &str, motion: &Motion, methods: &[(Composition, [u32; 3])]) {
    let text = Text::parse("body", text).unwrap_or_else(|error| panic!("{error}"));
    let known = [motion.q.as_slice(), &motion.v].concat();
    for &(method, counts) in methods {
        let errors = counts.map(|count| {
            let found = last(&text, motion, motion.until / f64::from(count), method);
            let apart = found
                .iter()
                .zip(&known)
                .map(|(found, known)| (found - known).abs());
            apart.fold(0.0, f64::max)
        });
        println!("{method}: {errors:?}");
        for i in 0..2 {
            let ratio = f64::from(counts[i + 1]) / f64::from(counts[i]);
            let order = (errors[i] / errors[i + 1]).ln() / ratio.ln();
            assert!(
                (order / f64::from(method.order()) - 1.0).abs() < 0.05,
                "{method}: {order} {errors:?}"
            );
        }
    }
}

#[test]
fn a_body_in_a_fluid_whose_mass_varies_with_its_attitude() {
    let (motion, text) = fluid();
    for maps in ["", "phi_lagrangian = trapezoid;"] {
        has_order(
            &format!("{text} {maps}"),
            &motion,
            &[
                (Composition::SUZUKI_4, [40, 80, 160]),
                (Composition::KAHAN_LI_6, [20, 40, 80]),
                (Composition::KAHAN_LI_8, [16, 18, 20]),
            ],
        );
    }
}

#[test]
fn a_torque_from_outside_and_a_clock() {
    let hand = |y: &[f64; 8]| {
        let (q, w, t) = (part(y, 0), part(y, 5), y[4]);
        let momentum = [0, 1, 2].map(|i| [2.0, 1.5, 1.0][i] * w[i]);
        let torque = plus(
            cross(momentum, w),
            plus(times(-0.3, w), times((2.0 * t).sin(), matrix(q)[2])),
        );
        joined(&[
            &rate(q, w),
            &[1.0],
            &[0, 1, 2].map(|i| torque[i] / [2.0, 1.5, 1.0][i]),
        ])
    };
    let q0: [f64; 5] = joined(&[&unit([1.0, 0.3, -0.4, 0.2]), &[0.0]]);
    let mut motion = Motion::by_hand(hand, (&q0, &[0.6, -0.3, 2.0]), 4.0);
    motion.q0.pop();
    motion.q.pop();
    for maps in ["", "phi_lagrangian = midpoint;"] {
        let text = format!(
            "coordinates(r: rotation);
             let w = r.angular_velocity();
             lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2;
             external_forces = -0.3 * w + r.inverse() * [0, 0, (2 * t).sin()];
             {maps}"
        );
        has_order(
            &text,
            &motion,
            &[
                (Composition::SUZUKI_4, [40, 80, 160]),
                (Composition::KAHAN_LI_6, [20, 40, 80]),
            ],
        );
    }
}

#[test]
fn a_step_back_leads_back() {
    let (motion, text) = lyapunov(0.5);
    let text = Text::parse("satellite", &text).unwrap();
    let v0 = [&[0.0], motion.v0.as_slice()].concat();
    let start = AnyStart::second_order(&motion.q0, &v0);
    let mut flow = AnyComposedFlow::new(&text.system, 0.05, Composition::KAHAN_LI_6, &start).unwrap();
    flow.run_mut().to(motion.until).unwrap();
    flow.run_mut().reverse().unwrap();
    flow.run_mut().to(0.0).unwrap();
    let mut node = OwnedNode::new(motion.q0.len());
    node.take(flow.run());
    let node = node.any();
    let apart = node.q.iter().zip(&motion.q0).chain(node.v.iter().zip(&v0));
    let apart = apart
        .map(|(found, known)| (found - known).abs())
        .fold(0.0, f64::max);
    assert!(apart < 1e-12, "{apart:e}");
}

/// A wheel about one axis in space, by an angle and by a rotation.
fn wheels(of_angle: &str, of_rotation: &str) -> [Text; 2] {
    let angle = format!("coordinates(phi); let spin = dot(phi); lagrangian = spin.powi(2) / 2; {of_angle}");
    let rotation = format!(
        "coordinates(r: rotation); let w = r.angular_velocity(); let spin = w[2]; let e = r * [1, 0, 0];
         lagrangian = w.norm_squared() / 2; {of_rotation}"
    );
    [angle, rotation].map(|text| Text::parse("wheel", &text).unwrap_or_else(|error| panic!("{error}")))
}

const SPIN: f64 = 1.3;

/// The two runs of wheels from an attitude, with the step 0.05.
fn runs(wheels: &[Text; 2], angle: f64, method: Composition) -> [AnyComposedFlow<'_>; 2] {
    let (sine, cosine) = (0.5 * angle).sin_cos();
    let starts = [
        AnyStart::second_order(&[angle], &[SPIN]),
        AnyStart::second_order(&[cosine, 0.0, 0.0, sine], &[0.0, 0.0, 0.0, SPIN]),
    ];
    [0, 1].map(|i| AnyComposedFlow::new(&wheels[i].system, 0.05, method, &starts[i]).unwrap())
}

/// The angle and the spin of a run of either kind.
fn angle(flow: &AnyComposedFlow<'_>) -> [f64; 2] {
    let mut node = OwnedNode::new(1);
    node.take(flow.run());
    let node = node.any();
    match (node.q, node.v) {
        (&[phi], &[spin]) => [phi, spin],
        (q, v) => [2.0 * q[3].atan2(q[0]), v[3]],
    }
}

#[test]
fn dry_friction_brings_a_wheel_to_rest() {
    let wheels = wheels(
        "external_forces = -0.3 * spin.signum();",
        "external_forces = [0, 0, -0.3 * spin.signum()];",
    );
    let [mut number, mut rotation] = runs(&wheels, 0.2, Composition::SUZUKI_4);
    for flow in [&mut number, &mut rotation] {
        let rest = SPIN / 0.3;
        for t in [2.0, 4.0, 6.0] {
            flow.run_mut().to(t).unwrap();
            let s = f64::min(t, rest);
            let [phi, spin] = angle(flow);
            assert!((phi - (0.2 + SPIN * s - 0.15 * s * s)).abs() < 1e-5, "{t}: {phi}");
            assert!((spin - (SPIN - 0.3 * s)).abs() < 1e-5, "{t}: {spin}");
        }
    }
    assert_eq!(
        number.run().unresolved().is_some(),
        rotation.run().unresolved().is_some()
    );
}

#[test]
fn a_force_that_jumps_with_the_attitude_is_told() {
    let wheels = wheels(
        "external_forces = if phi.cos() > 0.3 { -0.4 } else { 0.2 };",
        "external_forces = [0, 0, if e[0] > 0.3 { -0.4 } else { 0.2 }];",
    );
    let [mut number, mut rotation] = runs(&wheels, 0.2, Composition::SUZUKI_4);
    let counts = [&mut number, &mut rotation].map(|flow| {
        flow.run_mut().to(4.0).unwrap();
        flow.run().unresolved()
    });
    let [Some(number), Some(rotation)] = counts else {
        panic!("{counts:?}");
    };
    assert_eq!(number.steps, rotation.steps);
    assert!((number.first - rotation.first).abs() < 1e-12);
    // a force that is smooth there gives no such report
    let smooth = self::wheels(
        "external_forces = -0.4 * phi.cos();",
        "external_forces = [0, 0, -0.4 * e[0]];",
    );
    for mut flow in runs(&smooth, 0.2, Composition::SUZUKI_4) {
        flow.run_mut().to(4.0).unwrap();
        assert!(flow.run().unresolved().is_none());
    }
}

#[test]
fn a_motion_ends_at_a_singularity() {
    let wheels = wheels(
        "kinematic = phi.cos() * ddot(phi) + 0.5; constraint_forces = [1];",
        "kinematic = e[0] * dot(w)[2] + 0.5; constraint_forces = [[0, 0, 1]]; ",
    );
    for mut flow in runs(&wheels, 0.2, Composition::SUZUKI_4) {
        let error = flow.run_mut().to(10.0).unwrap_err();
        // the angle -π/2 is reached at 3.762
        assert!((flow.run().clock().time() - 3.75).abs() < 1e-12, "{error}");
        assert!(error.to_string().contains("singular"), "{error}");
    }
}

#[test]
fn an_input_changes_at_a_node() {
    let texts = [
        "parameters { push = 0.5 } coordinates(phi); lagrangian = dot(phi).powi(2) / 2; external_forces = push;",
        "parameters { push = 0.5 } coordinates(r: rotation); lagrangian = r.angular_velocity().norm_squared() / 2; external_forces = [0, 0, push];",
    ];
    let texts = texts.map(|text| Text::parse("wheel", text).unwrap());
    for mut flow in runs(&texts, 0.2, Composition::SUZUKI_4) {
        flow.run_mut().to(1.0).unwrap();
        flow.run_mut().set_value(0, -0.7).unwrap();
        flow.run_mut().to(2.0).unwrap();
        let [phi, spin] = angle(&flow);
        assert!((spin - (SPIN + 0.5 - 0.7)).abs() < 1e-13, "{spin}");
        assert!(
            (phi - (0.2 + 2.0 * SPIN + 0.25 + 0.5 - 0.35)).abs() < 1e-8,
            "{phi}"
        );
    }
}

#[test]
fn a_leg_that_turns_by_half_a_turn_is_refused() {
    let texts = wheels("", "");
    let (q0, v0) = ([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 40.0]);
    let start = AnyStart::second_order(&q0, &v0);
    let mut flow = AnyComposedFlow::new(&texts[1].system, 0.2, Composition::SUZUKI_4, &start).unwrap();
    let error = flow.run_mut().to(1.0).unwrap_err();
    assert!(error.to_string().contains("half a turn or more"), "{error}");
}
