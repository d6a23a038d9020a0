//! The Taylor flow follows the continuous motion: of the pendulum over 2000 s, of the particle on its circle,
//! and of every declared system; and its tolerance bounds its error.

#![allow(clippy::float_cmp)] // times are kept as they are given

use dsocs_core::geometry::motion;
use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{Node, RunError, SeriesFailure, SetupError, Start, Stepper, System};
use dsocs_systems::{Constant, CurvedParticle, InertiaWheelPendulum, PlanarChain2, PlanarChain8, Wavy};
use dsocs_tests::closed_form::pendulum::START;
use dsocs_tests::data::Table;
use dsocs_tests::fit;
use dsocs_tests::short_or_long;

use crate::systems::{builtin, constrained, maps, mass, opaque};
use dsocs_tests::dop853;

#[test]
fn the_pendulum_meets_the_reference_over_its_whole_time() {
    let table = Table::read("pendulum_continuous.csv");
    let pendulum = InertiaWheelPendulum::default();
    let start = Start::second_order(START.0, START.1);
    let mut flow = TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-16)).unwrap();
    let mut points = Vec::new();
    flow.sample(&table.numbers("t"), &mut |_, point| points.push(*point))
        .unwrap();
    let rows = table.pairs(["theta", "psi"]).into_iter().zip(table.numbers("V"));
    let mut worst = [0.0_f64; 3];
    for (state, (q, v)) in points.iter().zip(rows) {
        let lyapunov = pendulum.lyapunov(state.q, state.v);
        let deviations = [state.q[0] - q[0], state.q[1] - q[1], lyapunov - v];
        for (worst, deviation) in worst.iter_mut().zip(deviations) {
            *worst = worst.max(deviation.abs());
        }
    }
    println!(
        "θ {:.1e}, ψ {:.1e}, V {:.1e}, {} steps",
        worst[0],
        worst[1],
        worst[2],
        flow.steps()
    );
    assert!(
        worst[0] < 1e-11 && worst[1] < 2e-9 && worst[2] < 1e-8,
        "{worst:?}"
    );
    assert_eq!(points.len(), 201);
}

#[test]
fn the_force_is_the_references_multiplier() {
    let table = Table::read("pendulum_continuous.csv");
    let pendulum = InertiaWheelPendulum::default();
    let start = Start::second_order(START.0, START.1);
    let mut flow = TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-14)).unwrap();
    for (t, multiplier) in table
        .numbers("t")
        .into_iter()
        .zip(table.numbers("lambda"))
        .skip(1)
    {
        let node = flow.to(t).unwrap();
        assert_eq!(node.t, t);
        // the paper's multiplier is minus the force; the torque of the motor acts on ψ alone
        let force = node.force;
        let size = 1e-9 * (1.0 + multiplier.abs());
        assert!(
            force[0].abs() < size && (force[1] + multiplier).abs() < size,
            "{t}: {force:?} {multiplier}"
        );
    }
}

/// The largest error of the particle's position and velocity over 500 s, more than a hundred turns of its
/// circle.
fn particle(tolerance: Tolerance) -> f64 {
    let particle = CurvedParticle::default();
    let (q0, v0) = ([0.0, 0.0], [1.0, 1.0]);
    let times: Vec<f64> = (0..=5000).map(|k| f64::from(k) * 0.1).collect();
    let mut flow = TaylorFlow::new(&particle, Start::second_order(q0, v0), tolerance).unwrap();
    let mut worst = 0.0_f64;
    flow.sample(&times, &mut |t, point| {
        let (q, v) = particle.exact(q0, v0, t);
        for i in 0..2 {
            worst = worst
                .max((point.q[i] - q[i]).abs())
                .max((point.v[i] - v[i]).abs());
        }
    })
    .unwrap();
    worst
}

#[test]
fn the_particle_stays_on_its_circle() {
    // long steps turn the phase by sums of large terms of both signs: a lower order rounds less
    let error = particle(Tolerance::relative(1e-16).order(18));
    println!("{error:.1e}");
    assert!(error < 2e-12, "{error:e}");
}

#[test]
fn the_error_follows_the_tolerance() {
    // the order changes with the tolerance, and the constant with it: over ten decades that is small
    let tolerances: Vec<f64> = (4..=14).map(|k| 10.0_f64.powi(-k)).collect();
    let errors: Vec<f64> = tolerances
        .iter()
        .map(|&tolerance| particle(Tolerance::relative(tolerance)))
        .collect();
    println!("{errors:?}");
    let slope = fit::slope(&tolerances, &errors);
    assert!((slope - 1.0).abs() < 0.1, "{slope}: {errors:?}");
}

#[test]
fn another_solver_agrees() {
    let pendulum = InertiaWheelPendulum::default();
    let [p1, p2] = pendulum.momentum(START.1);
    let end = 50.0;
    let state = [START.0[0], START.0[1], p1, p2];
    let theirs = dop853::integrate(|_, state| pendulum.proper_branch(state), state, end, 1e-14);
    let start = Start::second_order(START.0, START.1);
    let mut flow = TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-15)).unwrap();
    let ours = flow.to(end).unwrap();
    assert!((ours.q[0] - theirs[0]).abs() < 1e-10 && (ours.q[1] - theirs[1]).abs() < 2e-8);
}

/// The largest correction that the system's own equations make to the acceleration of the series within
/// steps, relative to the largest acceleration there.
fn corrections<S: System<N>, const N: usize>(system: &S, q: [f64; N], v: [f64; N], until: f64) -> f64 {
    let mut flow = TaylorFlow::new(system, Start::second_order(q, v), Tolerance::relative(1e-13)).unwrap();
    let mut worst = 0.0_f64;
    let mut steps = 0;
    while flow.time() < until && steps < 200 {
        flow.step(until).unwrap();
        let polynomial = flow.polynomial().unwrap();
        for part in [0.0, 0.3, 0.7, 1.0] {
            let point = polynomial.at(polynomial.start() + part * polynomial.length());
            let asked = motion(system.kernel(), point.t, &point.q, &point.v)
                .unwrap()
                .sized::<N>()
                .a;
            let update: [f64; N] = core::array::from_fn(|i| asked[i] - point.a[i]);
            let size = |x: &[f64]| x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            worst = worst.max(size(&update) / size(&point.a).max(size(&point.v) / polynomial.length()));
        }
        steps += 1;
    }
    assert!(steps > 0);
    worst
}

#[test]
#[allow(clippy::too_many_lines)] // one system after another
fn every_declared_system_obeys_its_own_equations() {
    let mut found = Vec::new();
    let mut follow = |name: &'static str, correction: f64| found.push((name, correction));
    let particle = |curvature| CurvedParticle { mass: 2.0, curvature };
    follow(
        "circle",
        corrections(&particle(Constant(-0.7)), [0.1, 0.2], [1.0, 0.5], 9.0),
    );
    let field = CurvedParticle {
        mass: 2.0,
        curvature: Wavy::default(),
    };
    follow("field", corrections(&field, [0.1, 0.2], [1.0, 0.5], 9.0));
    follow(
        "pendulum",
        corrections(&InertiaWheelPendulum::default(), START.0, START.1, 1.0),
    );
    follow(
        "chain of 2",
        corrections(&PlanarChain2::default(), [1.0, -0.4], [0.3, 0.2], 2.0),
    );
    let q = core::array::from_fn(|i| 0.7 - 0.2 * i as f64);
    follow(
        "chain of 8",
        corrections(&PlanarChain8::default(), q, [0.1; 8], 0.5),
    );
    follow(
        "everywhere",
        corrections(&builtin::Everywhere { p: 0.6 }, [0.2, -0.3], [0.4, 0.1], 0.5),
    );
    follow(
        "positive",
        corrections(&builtin::Positive { p: 1.4 }, [0.2, 0.3], [0.4, 0.1], 0.01),
    );
    follow(
        "bounded",
        corrections(&builtin::Bounded { p: 0.8 }, [0.2, 0.5], [0.4, 0.7], 0.2),
    );
    follow(
        "branches",
        corrections(&builtin::Branches { edge: 3.0 }, [0.2, 0.5], [0.4, 0.1], 0.2),
    );
    follow(
        "two",
        corrections(
            &constrained::Two { mass: 1.3 },
            [0.2, 0.5, -0.1],
            [0.8, 0.1, 0.3],
            0.5,
        ),
    );
    follow(
        "forces",
        corrections(
            &constrained::Forces { mass: 1.3 },
            [0.2, 0.5, -0.1],
            [0.8, 0.1, 0.3],
            0.5,
        ),
    );
    follow(
        "divided",
        corrections(
            &constrained::Divided { mass: 1.3 },
            [0.2, 0.5, -0.1],
            [0.8, 0.1, 0.3],
            0.5,
        ),
    );
    follow(
        "forward",
        corrections(&maps::Forward { curvature: 0.8 }, [0.2, 0.5], [0.8, 0.1], 0.5),
    );
    let pendulum = mass::DoublePendulum {
        ratio: 0.4,
        gravity: 9.0,
    };
    follow(
        "double pendulum",
        corrections(&pendulum, [0.9, -0.5], [0.8, 0.1], 2.0),
    );
    let constrained = mass::Constrained {
        ratio: 0.4,
        gravity: 9.0,
    };
    follow("elbow", corrections(&constrained, [0.9, -0.5], [0.8, 0.1], 0.3));
    follow(
        "landscape",
        corrections(&opaque::Landscape::default(), [0.2, 0.5], [0.8, 0.4], 0.5),
    );
    follow(
        "metric",
        corrections(&opaque::Metric::default(), [0.2, 0.5], [0.8, 0.4], 0.5),
    );
    follow(
        "speed",
        corrections(&opaque::Speed { gain: 0.3 }, [0.2], [0.8], 1.0),
    );
    for (name, correction) in &found {
        println!("{name}: {correction:.1e}");
    }
    for (name, correction) in found {
        assert!(correction < 1e-10, "{name}: {correction:e}");
    }
}

#[test]
fn back_in_time_leads_back() {
    let pendulum = mass::DoublePendulum {
        ratio: 0.4,
        gravity: 9.0,
    };
    let (q0, v0) = ([0.9, -0.5], [0.8, 0.1]);
    let start = Start::second_order(q0, v0);
    let mut flow = TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-14)).unwrap();
    flow.to(3.0).unwrap();
    flow.reverse().unwrap();
    let back = flow.to(0.0).unwrap();
    for i in 0..2 {
        assert!(
            (back.q[i] - q0[i]).abs() < 1e-10 && (back.v[i] - v0[i]).abs() < 1e-10,
            "{back:?}"
        );
    }
}

#[test]
fn within_a_step_the_series_is_the_motion() {
    let particle = CurvedParticle::default();
    let (q0, v0) = ([0.0, 0.0], [1.0, 1.0]);
    let flow =
        || TaylorFlow::new(&particle, Start::second_order(q0, v0), Tolerance::relative(1e-14)).unwrap();
    let mut steps = flow();
    let mut times = Vec::new();
    for _ in 0..20 {
        steps.step(100.0).unwrap();
        let polynomial = steps.polynomial().unwrap();
        for part in [0.125, 0.375, 0.625, 0.875] {
            let t = polynomial.start() + polynomial.length() * part;
            let (q, v) = particle.exact(q0, v0, t);
            let point = polynomial.at(t);
            for i in 0..2 {
                assert!((point.q[i] - q[i]).abs() < 1e-12 && (point.v[i] - v[i]).abs() < 1e-12);
            }
            times.push(t);
        }
    }
    // several at once, and the accelerations with them
    let mut seen = Vec::new();
    flow()
        .sample(&times, &mut |t, point| {
            let (q, v) = particle.exact(q0, v0, t);
            let rate = particle.curvature.0 * v[0].hypot(v[1]);
            let a = [-rate * v[1], rate * v[0]];
            for i in 0..2 {
                assert!((point.q[i] - q[i]).abs() < 1e-12 && (point.v[i] - v[i]).abs() < 1e-12);
                assert!((point.a[i] - a[i]).abs() < 1e-10, "{point:?} {a:?}");
            }
            seen.push(t);
        })
        .unwrap();
    assert_eq!(seen, times);
}

#[test]
fn an_edge_of_the_equations_is_passed() {
    // the force is -2 x below the edge and -2 edge beyond: the second derivative of the acceleration jumps
    let branches = builtin::Branches { edge: 0.5 };
    let start = Start::second_order([0.2, 0.5], [0.9, 0.1]);
    let run = |tolerance| {
        let mut flow = TaylorFlow::new(&branches, start, Tolerance::relative(tolerance)).unwrap();
        let trajectory = flow.until(1.0).unwrap();
        // one step ends at the edge, and none is rejected
        let edge = |node: &Node<2>| (node.q[0] - branches.edge).abs() < 1e-15;
        assert_eq!(flow.rejected(), 0);
        assert!(trajectory.iter().any(edge), "the edge was never met");
        *trajectory.last().unwrap()
    };
    let (fine, coarse) = (run(1e-13), run(1e-8));
    for i in 0..2 {
        assert!((fine.q[i] - coarse.q[i]).abs() < 1e-8, "{fine:?} {coarse:?}");
    }
}

/// A start at rest without a direction, too many or too small steps, and wrong times and tolerances give
/// errors with their cause; a failed run keeps its nodes and the samples before the failure.
#[test]
fn what_cannot_go_on_says_why_and_keeps_what_it_has() {
    let particle = CurvedParticle::default();
    let at = |q, v| TaylorFlow::new(&particle, Start::second_order(q, v), Tolerance::relative(1e-10));
    // at rest the direction of the velocity is not defined
    let error = at([0.0; 2], [0.0; 2]).unwrap_err();
    let SetupError::Acceleration {
        undefined: Some(undefined),
        ..
    } = &error
    else {
        panic!("{error:?}");
    };
    assert!(undefined.contains_velocity() && undefined.value == 0.0, "{error}");
    let cause = |error: &RunError| match error {
        RunError::Series(error) => error.details().cause.clone(),
        other => panic!("{other}"),
    };
    let few = || at([0.0; 2], [1.0, 0.0]).unwrap().max_steps(5);
    let mut seen = 0;
    let error = few().sample(&[0.1, 0.2, 1e6], &mut |_, _| seen += 1).unwrap_err();
    assert_eq!(seen, 2);
    assert!(matches!(
        cause(&error),
        SeriesFailure::TooManySteps { steps: 5, .. }
    ));
    // the start and the ends of five steps, or on a grid its points up to there
    let failure = few().until(1e6).unwrap_err();
    assert_eq!(failure.trajectory.len(), 6);
    assert!(matches!(
        cause(&failure.error),
        SeriesFailure::TooManySteps { steps: 5, .. }
    ));
    let reached = failure.trajectory.last().unwrap().t;
    let failure = few().every(0.125).unwrap().until(1e6).unwrap_err();
    assert_eq!(failure.trajectory.len() as f64, (reached / 0.125).floor() + 1.0);
    let mut flow = at([0.0; 2], [1.0, 0.0]).unwrap().smallest_step(10.0);
    let error = flow.to(100.0).unwrap_err();
    assert!(
        matches!(cause(&error), SeriesFailure::StepTooSmall { .. }),
        "{error}"
    );
    assert!(matches!(flow.to(f64::NAN), Err(RunError::Until { .. })));
    assert!(matches!(
        flow.sample(&[1.0, 0.5, 2.0], &mut |_, _| {}),
        Err(RunError::TimeBehind { .. })
    ));
    let tolerance = TaylorFlow::new(
        &particle,
        Start::second_order([0.0; 2], [1.0, 0.0]),
        Tolerance::relative(0.0),
    );
    assert!(matches!(tolerance, Err(SetupError::Tolerance { .. })));
}

#[test]
fn a_motion_into_a_singularity_ends_there() {
    // x'' = -1/x², from rest at 1: it falls into 0 at t = π/√8
    let fall = Fall { strength: 1.0 };
    let mut flow = TaylorFlow::new(
        &fall,
        Start::second_order([1.0], [0.0]),
        Tolerance::relative(1e-12),
    )
    .unwrap();
    let error = flow.to(2.0).unwrap_err();
    let reached = flow.time();
    let exact = core::f64::consts::PI / 8.0_f64.sqrt();
    assert!((reached - exact).abs() < 1e-9, "{reached} {exact} {error}");
    assert!(matches!(error, RunError::Series(_)), "{error}");
    assert_eq!(error.time(), Some(reached));
}

/// A mass that falls towards a centre.
#[dsocs_core::dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 + strength / x;
}]
struct Fall {
    strength: f64,
}

#[test]
fn a_polynomial_motion_takes_one_step() {
    let thrown = Thrown { gravity: 9.81 };
    let mut flow = TaylorFlow::new(
        &thrown,
        Start::second_order([1.0], [3.0]),
        Tolerance::relative(1e-10),
    )
    .unwrap();
    let state = flow.to(1000.0).unwrap();
    assert_eq!(flow.steps(), 1);
    let exact = 1.0 + 3000.0 - 9.81 / 2.0 * 1e6;
    assert!((state.q[0] - exact).abs() < 1e-15 * exact.abs());
}

/// A mass that is thrown.
#[dsocs_core::dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - gravity * x;
}]
struct Thrown {
    gravity: f64,
}

/// Holonomic and nonholonomic constraints hold at every node to rounding, at any tolerance and however long the motion is.
#[test]
fn constraints_do_not_drift() {
    on_the_sphere(short_or_long(1000.0, 10_000.0));
    on_a_grid();
}

/// Checks that a motion stays on the sphere for this number of turns.
fn on_the_sphere(all: f64) {
    let sphere = dsocs_systems::Sphere::default();
    let l = sphere.length;
    let start = Start::second_order([l, 0.0, 0.0], [0.0, 3.0, 0.4]);
    for tolerance in [1e-2, 1e-4, 1e-6, 1e-9, 1e-12, 1e-15] {
        let mut flow = TaylorFlow::new(&sphere, start, Tolerance::relative(tolerance)).unwrap();
        let (mut turns, mut worst, mut last) = (0.0, [0.0_f64; 2], 0.0_f64);
        while turns < all {
            flow.advance().unwrap();
            let node = flow.node();
            let ([x, y, z], [u, v, w]) = (node.q, node.v);
            let turned = (y.atan2(x) - last).rem_euclid(core::f64::consts::TAU);
            (turns, last) = (turns + turned / core::f64::consts::TAU, y.atan2(x));
            let speed = (u * u + v * v + w * w).sqrt();
            worst[0] = worst[0].max((x * x + y * y + z * z - l * l).abs() / (l * l));
            worst[1] = worst[1].max((x * u + y * v + z * w).abs() / (l * speed));
        }
        println!("{tolerance:e}: {worst:?} after {} steps", flow.steps());
        assert!(
            worst.iter().all(|worst| *worst < 1e-13),
            "{tolerance:e}: {worst:?}"
        );
    }
}

/// The nonholonomic row of a knife edge on a grid of times, which lie within steps.
fn on_a_grid() {
    let edge = dsocs_systems::KnifeEdge::default();
    let start = Start::second_order([0.0; 3], [1.0, 0.0, 0.5]).projected();
    for tolerance in [1e-3, 1e-9] {
        let nodes = TaylorFlow::new(&edge, start, Tolerance::relative(tolerance))
            .unwrap()
            .every(0.1)
            .unwrap()
            .until(500.0)
            .unwrap()
            .nodes;
        for node in &nodes {
            let (sin, cos) = node.q[2].sin_cos();
            let row = node.v[0] * sin - node.v[1] * cos;
            assert!(
                row.abs() < 1e-13 * (node.v[0].abs() + node.v[1].abs()),
                "{tolerance:e}: {node:?}"
            );
        }
    }
}
