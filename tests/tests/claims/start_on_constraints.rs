//! Starts that constraints bind, and starts where the equations allow several accelerations.

use dsocs_core::{Composition, SetupError, Start, Stepper, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::short_or_long;
use dsocs_tests::text::{ComposedFlow, Flow, System, TaylorFlow};
use proptest::prelude::*;

declared! {
    /// A ball with a prescribed turning rate about an axis.
    struct Driven {
        rate: f64,
    }
    coordinates(x, w);
    lagrangian = (dot(x).powi(2) + dot(w).powi(2) * (1 + x.powi(2))) / 2 - x.powi(2);
    nonholonomic = dot(w) - rate;
}

declared! {
    /// Two beads on crossing wires through the origin, and a third that the first drags along.
    struct Wires {
        slope: f64,
    }
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + 2 * dot(y).powi(2) + 3 * dot(z).powi(2)) / 2;
    holonomic = [y - slope * x, x.sin() + y.powi(2) - z];
}

declared! {
    /// A rod of unit length about a point.
    struct Rod {}
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
    holonomic = x.powi(2) + y.powi(2) - 1;
}

declared! {
    /// A particle whose squared curvature is prescribed.
    struct Unsigned {
        curvature: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let square = dot(x).powi(2) + dot(y).powi(2);
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)).powi(2) / square.powi(3) - curvature.powi(2);
    variational = [(dot(x), dot(y))];
}

/// Zero, or a number of any magnitude down to the smallest of a leg.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        1 => Just(0.0),
        3 => (-40_i32..1, -1.0..1.0_f64).prop_map(|(power, x)| x * 2.0_f64.powi(power)),
    ]
}

fn accepted<S: System<N>, const N: usize>(system: &S, h: f64, start: Start<N>) {
    if let Err(error) = Flow::new(system, h, start) {
        panic!("{start:?}, h = {h}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: short_or_long(200, 800), failure_persistence: None, ..ProptestConfig::default() })]

    /// At the origin and near it, the residual has no scale but the leg itself.
    #[test]
    fn consistent_starts_are_accepted_also_at_the_origin(
        x in coordinate(), w in coordinate(), v in -2.0..2.0_f64, rate in -2.0..2.0_f64, power in -12_i32..0,
    ) {
        let h = 2.0_f64.powi(power) / 1.1;
        let driven = Driven { rate };
        let (wires, y) = (Wires { slope: 0.5 }, 0.5 * x);
        let (beads, velocity) = ([x, y, x.sin() + y * y], [v, 0.5 * v, x.cos() * v + 2.0 * y * 0.5 * v]);
        for start in [Start::second_order([x, w], [v, rate]), Start::paper([x, w], [v, rate])] {
            accepted(&driven, h, start);
            accepted(&driven, h, start.projected());
        }
        for start in [Start::second_order(beads, velocity), Start::paper(beads, velocity)] {
            accepted(&wires, h, start);
        }
    }

    /// Any angle, so that the rod may lie along an axis.
    #[test]
    fn a_rod_may_start_anywhere(turn in 0_u32..8, more in coordinate(), v in -2.0..2.0_f64, power in -12_i32..0) {
        let angle = f64::from(turn) * std::f64::consts::FRAC_PI_4 + more;
        let (sin, cos) = angle.sin_cos();
        let h = 2.0_f64.powi(power) / 1.1;
        accepted(&Rod {}, h, Start::second_order([sin, -cos], [v * cos, v * sin]));
    }
}

/// The error of an inconsistent start lists every violated constraint and every violated time derivative,
/// each with its index, its place and its value.
#[test]
fn all_that_is_violated_is_told() {
    let wires = Wires { slope: 0.5 };
    let Err(error) = Flow::new(&wires, 0.1, Start::second_order([1.0, 0.6, 2.0], [1.0, 0.5, 9.0])) else {
        panic!("accepted");
    };
    let SetupError::Inconsistent { violations } = &error else {
        panic!("{error:?}");
    };
    let reported: Vec<_> = violations
        .iter()
        .map(|violation| (violation.constraint, violation.index, violation.at))
        .collect();
    assert_eq!(
        reported,
        [
            ("holonomic constraint", 0, "q0"),
            ("holonomic constraint", 1, "q0"),
            ("time derivative of holonomic constraint", 1, "(q0, v0)"),
        ]
    );
    assert!((violations[0].value - 0.1).abs() < 1e-15, "{error}");
    let Err(error) = Flow::new(&Driven { rate: 1.0 }, 0.1, Start::nodes([0.0, 0.0], [0.0, 0.2])) else {
        panic!("accepted");
    };
    assert!(
        error
            .to_string()
            .contains("nonholonomic constraint 1 at φ⁻¹(q0, q1) of the map of L by 1,"),
        "{error}"
    );
}

#[test]
fn an_acceleration_can_be_named_where_there_are_several() {
    let system = Unsigned { curvature: 0.5 };
    let start = Start::second_order([0.0, 0.0], [1.0, 0.0]);
    let Err(error) = Flow::new(&system, 0.01, start) else {
        panic!("one of two was taken in silence");
    };
    assert!(error.to_string().contains("Start::near_acceleration"), "{error}");
    for side in [1.0, -1.0] {
        // a circle of radius 2 to either side; a rough guess suffices
        let start = start.near_acceleration([0.0, 0.3 * side]);
        let exact = |t: f64| [2.0 * (t / 2.0).sin(), side * (2.0 - 2.0 * (t / 2.0).cos())];
        let away = |q: &[f64; 2], t: f64| (q[0] - exact(t)[0]).hypot(q[1] - exact(t)[1]);
        let flow = Flow::new(&system, 0.01, start).unwrap().to(10.0).unwrap();
        assert!(away(&flow.q, 10.0) < 1e-3, "{:?}", flow.q);
        let composed = ComposedFlow::new(&system, 0.01, Composition::KAHAN_LI_6, start).unwrap();
        let composed = { composed }.to(10.0).unwrap();
        assert!(away(&composed.q, 10.0) < 1e-10, "{:?}", composed.q);
        let taylor = TaylorFlow::new(&system, start, Tolerance::relative(1e-12))
            .unwrap()
            .to(10.0)
            .unwrap();
        assert!(away(&taylor.q, 10.0) < 1e-9, "{:?}", taylor.q);
    }
}

declared! {
    /// Rows whose terms vanish where they hold.
    struct Vanishing {}
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2;
    nonholonomic = [dot(y), dot(z) + y.sin() * dot(x) - dot(y)];
}

/// The residual of a projection is rounding of the velocities, also where the terms of a row are zero
/// themselves.
#[test]
fn a_projection_is_not_measured_by_terms_that_vanish() {
    for v0 in [
        [0.7, 0.3, 0.2],
        [1.0, 1.0, 0.0],
        [-0.3, 1e-9, 5.0],
        [1e6, -3.0, 1e-6],
        // velocities that the projection makes zero
        [0.0, 1.0, 0.0],
        [0.0, 0.7, -0.3],
    ] {
        let start = Start::second_order([0.0; 3], v0).projected();
        let node = Flow::new(&Vanishing {}, 0.01, start).unwrap().to(0.1).unwrap();
        let size = v0[0].abs().max(1e-3 * v0[1].abs());
        assert!((node.v[0] - v0[0]).abs() <= 1e-12 * size, "{node:?}");
    }
    // a residual above rounding is refused all the same
    let wrong = Start::second_order([0.0; 3], [1.0, 1e-12, 0.0]);
    assert!(Flow::new(&Vanishing {}, 0.01, wrong).is_err());
}

declared! {
    /// A slider that a Lyapunov function brings to rest on an incline.
    struct Regulator {
        mass: f64,
        pull: f64,
        stiffness: f64,
        gain: f64,
    }
    coordinates(x);
    let kinetic = mass / 2 * dot(x).powi(2);
    lagrangian = kinetic - pull * x;
    let lyapunov = kinetic + stiffness / 2 * x.powi(2);
    kinematic = dot(lyapunov) + gain * dot(x).powi(2);
    constraint_forces = [(1)];
    branch = divide(dot(x));
}

/// The factor of a constraint is divided out of the continuous row too, which has a value where the factor is
/// zero.
#[test]
fn a_regulator_starts_at_rest() {
    let system = Regulator {
        mass: 2.0,
        pull: 0.7,
        stiffness: 3.0,
        gain: 0.5,
    };
    let mut flow = Flow::new(&system, 0.01, Start::second_order([1.0], [0.0])).unwrap();
    // m a = -k x at rest, by the force m a + pull
    let first = flow.node();
    assert!(
        (first.a[0] + 1.5).abs() < 1e-15 && (first.force[0] + 2.3).abs() < 1e-14,
        "{first:?}"
    );
    let exact = |t: f64| {
        let (decay, turn) = (0.125_f64, (1.5_f64 - 0.125 * 0.125).sqrt());
        (-decay * t).exp() * ((turn * t).cos() + decay / turn * (turn * t).sin())
    };
    assert!((flow.to(5.0).unwrap().q[0] - exact(5.0)).abs() < 1e-4);
}
