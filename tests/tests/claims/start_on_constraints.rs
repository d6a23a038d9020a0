//! Starts that constraints bind, and starts where the equations allow several accelerations.

use dsocs_core::{Composition, SetupError, Start, Stepper, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
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

declared! {
    /// A platform on three equal bars, which stay parallel: the third says what the others say.
    struct Platform { bars: [f64; 3], factors: [f64; 3] };
    coordinates(x, y, th);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 0.1 * dot(th).powi(2) - 9.81 * y;
    let px = |s| x + s * th.cos();
    let py = |s| y + s * th.sin();
    let bar = |s| (px(s) - s).powi(2) + py(s).powi(2) - 1;
    holonomic = [factors[0] * bar(bars[0]), factors[1] * bar(bars[1]), factors[2] * bar(bars[2])];
}

declared! {
    /// A platform on two bars and a third that is independent of them by a pivot that is off, or by another coordinate.
    struct Leaning { off: f64, square: f64, weight: f64, factors: [f64; 3] };
    coordinates(x, y, th, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 + 0.1 * dot(th).powi(2) - 9.81 * y;
    let px = |s| x + s * th.cos();
    let py = |s| y + s * th.sin();
    holonomic = [
        factors[0] * ((px(-1) + 1).powi(2) + py(-1).powi(2) - 1),
        factors[1] * ((px(1) - 1).powi(2) + py(1).powi(2) - 1),
        factors[2] * ((px(0) - off).powi(2) + py(0).powi(2) - square + weight * z),
    ];
}

declared! {
    /// Three velocity constraints, which may depend on each other.
    struct Summed { slopes: [f64; 2], third: [f64; 4] };
    coordinates(x, y, z, w);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) + dot(w).powi(2)) / 2 - 9.81 * y;
    let turned = (1 + x * x) * dot(y);
    nonholonomic = [dot(x) - slopes[0] * dot(w), dot(z) + slopes[1] * turned, third[0] * dot(x) + third[1] * dot(z) + third[2] * dot(w) + third[3] * turned];
}

declared! {
    /// A double pendulum of two rods.
    struct TwoRods { masses: [f64; 2], factors: [f64; 2] };
    coordinates(a: [2], b: [2]);
    lagrangian = masses[0] * dot(a).norm_squared() / 2 + masses[1] * dot(b).norm_squared() / 2 - 9.81 * (masses[0] * a[1] + masses[1] * b[1]);
    holonomic = [factors[0] * (a.norm() - 1), factors[1] * ((a - b).norm() - 1)];
}

/// The errors of a start, by steps and with a tolerance.
fn errors<S: System<N>, const N: usize>(system: &S, start: Start<N>) -> [Option<String>; 2] {
    [
        Flow::new(system, 0.005, start)
            .err()
            .map(|error| error.to_string()),
        TaylorFlow::new(system, start, Tolerance::relative(1e-9))
            .err()
            .map(|error| error.to_string()),
    ]
}

#[test]
fn rows_that_repeat_each_other_are_refused_whatever_their_rounding() {
    let mut random = Random::new(5);
    for draw in 0..400 {
        let bars = [0.0; 3].map(|_| {
            let s = random.between(-1.5, 1.5);
            // with few digits as with many
            if draw % 2 == 0 {
                (100.0 * s).round() / 100.0
            } else {
                s
            }
        });
        let distance = |i: usize, j: usize| (bars[i] - bars[j]).abs();
        if distance(0, 1).min(distance(1, 2)).min(distance(0, 2)) < 0.005 {
            continue;
        }
        let factors = [0.0; 3].map(|_| {
            if draw % 3 == 0 {
                random.decades(1e-6, 1e6)
            } else {
                1.0
            }
        });
        let (sin, cos) = random.between(-3.0, 3.0).sin_cos();
        let start = Start::second_order([cos, sin, 0.0], [0.0; 3]);
        for error in errors(&Platform { bars, factors }, start) {
            let error = error.unwrap_or_else(|| panic!("{draw}: {bars:?} {factors:?} at {cos:?}, {sin:?}"));
            let names = "holonomic constraints 1, 2 and 3 depend on each other";
            assert!(
                error.contains(names) && error.contains("leave out"),
                "{draw}: {bars:?}: {error}"
            );
        }
        let [slopes, parts] = [0, 1].map(|_| [0.0; 2].map(|_| random.between(0.1, 2.0)));
        let third = [parts[0], parts[1], -parts[0] * slopes[0], parts[1] * slopes[1]];
        let start = Start::second_order([random.between(-2.0, 2.0), 0.3, 0.2, 0.1], [0.0; 4]);
        for error in errors(&Summed { slopes, third }, start) {
            let error = error.unwrap_or_else(|| panic!("{draw}: {slopes:?} {third:?}"));
            assert!(
                error.contains("nonholonomic constraints 1, 2 and 3 depend on each other"),
                "{error}"
            );
        }
    }
}

#[test]
fn rows_that_nearly_repeat_each_other_are_taken() {
    let mut random = Random::new(6);
    for draw in 0..100 {
        let factors = [0.0; 3].map(|_| random.decades(1e-6, 1e6));
        let (sin, cos) = random.between(-3.0, 3.0).sin_cos();
        let (off, weight) = if draw % 2 == 0 {
            (0.0, random.decades(1e-9, 1.0))
        } else {
            (random.decades(1e-10, 1e-1), 0.0)
        };
        let square = (cos - off).powi(2) + sin * sin;
        let start = Start::second_order([cos, sin, 0.0, 0.0], [0.0; 4]);
        let found = errors(
            &Leaning {
                off,
                square,
                weight,
                factors,
            },
            start,
        );
        assert_eq!(found, [None, None], "{draw}: {off} {factors:?}");
        let masses = [random.decades(1e-9, 1e9), random.decades(1e-9, 1e9)];
        let [a, b] = [0.0; 2].map(|_| random.between(-3.0, 3.0).sin_cos());
        let place = [a.1, a.0, a.1 + b.1, a.0 + b.0];
        let rods = TwoRods {
            masses,
            factors: [factors[0], factors[1]],
        };
        let found = errors(&rods, Start::second_order(place, [0.0; 4]));
        assert_eq!(found, [None, None], "{draw}: {masses:?} {factors:?} {place:?}");
    }
}
