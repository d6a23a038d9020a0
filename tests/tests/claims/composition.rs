//! Compositions of steps: their orders, their symmetry in time, the invariants that they keep, and where they
//! are refused.

#![allow(clippy::float_cmp)] // orders are compared as they are given

use dsocs_core::taylor::Tolerance;
use dsocs_core::{Composition, Kernel, RunError, SetupError, StageFailure, Start, Stepper, Symmetry};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum, PlanarChain8, Wavy};
use dsocs_tests::closed_form::pendulum::START;
use dsocs_tests::short_or_long;
use dsocs_tests::text::{ComposedFlow, Flow, System, TaylorFlow, read};
use dsocs_tests::{declared, fit};

use crate::systems::{maps, mass};
use dsocs_tests::dop853;

const METHODS: [Composition; 4] = [
    Composition::SINGLE,
    Composition::SUZUKI_4,
    Composition::KAHAN_LI_6,
    Composition::KAHAN_LI_8,
];

fn field() -> CurvedParticle<Wavy> {
    CurvedParticle {
        mass: 2.0,
        curvature: Wavy::default(),
    }
}

fn distance(left: [f64; 2], right: [f64; 2]) -> f64 {
    (left[0] - right[0]).hypot(left[1] - right[1])
}

/// The particle's right-hand side, by hand.
fn turning(_: f64, [x, y, u, v]: [f64; 4]) -> [f64; 4] {
    let turn = (1.0 + 0.5 * x.sin() * y.cos()) * u.hypot(v);
    [u, v, -turn * v, turn * u]
}

/// Positions at the times 1, 2, … by the method of Dormand and Prince.
fn independent(seconds: usize) -> Vec<[f64; 2]> {
    let mut state = [0.0, 0.0, 1.0, 1.0];
    let mut positions = Vec::new();
    for _ in 0..seconds {
        state = dop853::integrate(turning, state, 1.0, 1e-15);
        positions.push([state[0], state[1]]);
    }
    positions
}

/// The largest error at the whole seconds.
fn largest_error<S: System<2>>(
    system: &S,
    method: Composition,
    parts: u32,
    start: ([f64; 2], [f64; 2]),
    truth: &[[f64; 2]],
    measure: impl Fn([f64; 2], [f64; 2]) -> f64,
) -> f64 {
    let mut flow = ComposedFlow::new(
        system,
        f64::from(parts).recip(),
        method,
        Start::second_order(start.0, start.1),
    )
    .unwrap();
    let mut largest = 0.0_f64;
    for truth in truth {
        for _ in 0..parts {
            flow.advance().unwrap();
        }
        largest = largest.max(measure(flow.position(), *truth));
    }
    largest
}

/// The slope over the steps whose error is above the plateau of rounding.
fn slope_above(parts: &[u32], errors: &[f64], plateau: f64) -> f64 {
    let points = parts.iter().zip(errors).filter(|&(_, &error)| error > plateau);
    let (steps, errors): (Vec<f64>, Vec<f64>) = points
        .map(|(&parts, &error)| (f64::from(parts).recip(), error))
        .unzip();
    assert!(steps.len() >= 4, "{errors:?}");
    fit::slope(&steps, &errors)
}

#[test]
fn orders_on_the_particle_in_a_field() {
    const SECONDS: usize = 20;
    let times: Vec<f64> = (1..=SECONDS).map(|t| t as f64).collect();
    let start = ([0.0, 0.0], [1.0, 1.0]);
    let tolerance = Tolerance::relative(1e-17).order(18);
    let particle = field();
    let mut flow = TaylorFlow::new(&particle, Start::second_order(start.0, start.1), tolerance).unwrap();
    let mut ours = Vec::with_capacity(SECONDS);
    flow.sample(&times, &mut |_, point| ours.push(point.q)).unwrap();
    let others = independent(SECONDS);
    let apart = ours
        .iter()
        .zip(&others)
        .map(|(ours, other)| distance(*ours, *other));
    let apart = apart.fold(0.0, f64::max);
    println!("the references differ by {apart:.1e}");
    assert!(apart < 2e-13);
    for method in METHODS {
        let parts: &[u32] = match method.order() {
            2 | 4 => &[8, 12, 16, 24, 32, 48, 64],
            6 => &[5, 6, 8, 10, 12, 16, 20, 24, 32],
            _ => &[4, 5, 6, 8, 10, 12, 14, 16],
        };
        for truth in [&ours, &others] {
            let errors: Vec<f64> = parts
                .iter()
                .map(|&parts| largest_error(&particle, method, parts, start, truth, distance))
                .collect();
            let slope = slope_above(parts, &errors, 1e-12);
            println!("{method}: slope {slope:.3}, errors {errors:?}");
            let order = f64::from(method.order());
            assert!((slope - order).abs() < 0.02 * order, "{method}: {slope}");
        }
    }
}

#[test]
fn orders_on_the_pendulum_whose_constraint_is_a_decrease() {
    let pendulum = InertiaWheelPendulum::default();
    let tolerance = Tolerance::relative(1e-16);
    let mut flow = TaylorFlow::new(&pendulum, Start::second_order(START.0, START.1), tolerance).unwrap();
    let times: Vec<f64> = (1..=10).map(f64::from).collect();
    let mut truth = Vec::new();
    flow.sample(&times, &mut |_, point| truth.push(point.q)).unwrap();
    for method in METHODS {
        let parts = [10, 14, 20, 28, 40];
        let theta = |left: [f64; 2], right: [f64; 2]| (left[0] - right[0]).abs();
        let errors = parts.map(|parts| largest_error(&pendulum, method, parts, START, &truth, theta));
        let slope = slope_above(&parts, &errors, 1e-13);
        println!("{method}: slope {slope:.3}, errors {errors:?}");
        let order = f64::from(method.order());
        assert!((slope - order).abs() < 0.02 * order, "{method}: {slope}");
    }
}

/// Steps forward and back, and the largest distance from the start in position and velocity.
fn there_and_back<S: System<2>>(
    system: &S,
    method: Composition,
    h: f64,
    start: ([f64; 2], [f64; 2]),
    steps: u32,
) -> f64 {
    let mut flow = ComposedFlow::new(system, h, method, Start::second_order(start.0, start.1)).unwrap();
    for _ in 0..steps {
        flow.advance().unwrap();
    }
    flow.reverse().unwrap();
    assert_eq!(flow.clock().step(), Some(-h));
    for _ in 0..steps {
        flow.advance().unwrap();
    }
    let last = flow.node();
    assert!(last.t.abs() < 1e-12);
    let back = distance(last.q, start.0).max(distance(last.v, start.1));
    println!("{method}: {steps} steps of {h} there and back: {back:.1e}");
    back
}

/// One step back after one forward is the identity to a few roundings; after many, rounding is magnified as the motion
/// magnifies it.
#[test]
fn a_step_back_undoes_a_step() {
    let start = ([0.0, 0.0], [1.0, 1.0]);
    for method in METHODS {
        for h in [0.5, 0.1, 0.01] {
            assert!(there_and_back(&field(), method, h, start, 1) <= 2e-15);
            assert!(there_and_back(&CurvedParticle::default(), method, h, start, 1) <= 2e-15);
        }
        // the velocity of the pendulum's wheel is some hundred rad/s
        assert!(there_and_back(&InertiaWheelPendulum::default(), method, 0.05, START, 1) <= 4e-14);
        assert!(there_and_back(&field(), method, 0.1, start, 1000) <= 1e-11);
    }
}

#[test]
fn with_equal_legs_it_is_the_papers_step() {
    let particle = field();
    let mut flow = Flow::new(&particle, 0.1, Start::second_order([0.0, 0.0], [1.0, 1.0])).unwrap();
    let mut composed = ComposedFlow::new(
        &particle,
        0.1,
        Composition::SINGLE,
        Start::second_order([0.0, 0.0], [1.0, 1.0]),
    )
    .unwrap();
    let (nodes, others) = (flow.until(50.0).unwrap(), composed.until(50.0).unwrap());
    assert_eq!(nodes.len(), others.len());
    for (node, other) in nodes.iter().zip(&others) {
        assert_eq!((node.index, node.t), (other.index, other.t));
        assert!(distance(node.q, other.q) < 1e-12 && distance(node.v, other.v) < 1e-12);
        assert!(distance(node.force, other.force) < 1e-12 && (node.energy - other.energy).abs() < 1e-12);
    }
}

/// With equal legs `L_d` is kept from leg to leg, whatever the curvature. With unequal ones the speeds of neighbouring legs
/// differ by the square of their lengths, `|v_r|² = |v|² + h²|a|²/4`, so that `L_d` is not kept. Where the curvature is
/// constant, the energy at the nodes is kept, and with it `L_d` of each stage from step to step. Where the curvature varies
/// the energy at the nodes stays within an error of the method's order, without a drift.
#[test]
fn what_unequal_legs_keep() {
    let steps = short_or_long(8000, 40_000);
    let start = ([0.0, 0.0], [1.0, 1.0]);
    let circle = CurvedParticle::default();
    let particle = field();
    for method in METHODS {
        let mut flow =
            ComposedFlow::new(&circle, 0.1, method, Start::second_order(start.0, start.1)).unwrap();
        for _ in 0..steps / 4 {
            flow.advance().unwrap();
        }
        let drift = (flow.node().energy - 1.0).abs();
        println!("{method}: energy on the circle, {} steps: {drift:.1e}", steps / 4);
        assert!(drift < 1e-13);

        let wander = |h: f64, steps: u32| {
            let mut flow =
                ComposedFlow::new(&particle, h, method, Start::second_order(start.0, start.1)).unwrap();
            let (mut first, mut last) = (0.0_f64, 0.0_f64);
            for k in 0..steps {
                flow.advance().unwrap();
                let error = (flow.node().energy / 2.0 - 1.0).abs();
                if k < steps / 10 {
                    first = first.max(error);
                } else if k >= steps - steps / 10 {
                    last = last.max(error);
                }
            }
            [first, last]
        };
        let [first, last] = wander(0.25, steps);
        let [finer, _] = wander(0.125, steps / 5);
        let order = (first / finer).log2();
        println!("{method}: energy in the field: {first:.1e}, at the end {last:.1e}, order {order:.2}");
        assert!(last < 1.2 * first);
        assert!((order - f64::from(method.order())).abs() < 0.5);
    }
}

declared! {
    /// A particle on a line, damped.
    struct Damped {
        damping: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + damping * dot(x) + x;
    constraint_forces = [(1,)];
}

declared! {
    /// A particle on a line whose energy falls by friction: a switch of the width `small`.
    struct Friction {
        friction: f64,
        small: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    let energy = (dot(x).powi(2) + x.powi(2)) / 2;
    kinematic = dot(energy) + friction * dot(x) * (dot(x) / small).tanh();
    constraint_forces = [(1,)];
    branch = divide(dot(x));
}

declared! {
    /// A potential that depends on the velocity: a charge in a magnetic field, with a gauge that depends on the position.
    struct Charge {
        field: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + field / 2 * (x * dot(y) - y * dot(x));
    phi_lagrangian = paper;
}

declared! {
    /// A spring with the midpoint rule.
    struct Midpoint {
        stiffness: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - stiffness / 2 * x.powi(2);
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
}

declared! {
    /// The paper's maps, written out.
    struct Written {
        stiffness: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - stiffness / 2 * x.powi(2);
    kinematic = ddot(x) + x.sin() * dot(x);
    constraint_forces = [(1,)];
    phi_lagrangian = |q0, q1| (q0, (q1 - q0) / h);
    phi_kinematic = |q0, q1, q2| (q1, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2));
}

declared! {
    /// A velocity from one side.
    struct OneSided {}
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + dot(x);
    constraint_forces = [(1,)];
    phi_kinematic = |q0, q1, q2| (q1, (q1 - q0) / h, (q2 - 2 * q1 + q0) / h.powi(2));
}

#[test]
fn the_attribute_finds_out_what_can_be_composed() {
    let of = |system: &dyn Kernel| system.shape().symmetry;
    let (ratio, gravity, curvature) = (1.0, 9.81, 1.0);
    let double = mass::DoublePendulum { ratio, gravity };
    let constrained = mass::Constrained { ratio, gravity };
    for (found, expected) in [
        (of(&field()), Symmetry::AnyLegs),
        (of(&InertiaWheelPendulum::default()), Symmetry::AnyLegs),
        (of(read(&Damped { damping: 1.0 })), Symmetry::AnyLegs),
        (of(read(&Written { stiffness: 1.0 })), Symmetry::AnyLegs),
        (of(&PlanarChain8::default()), Symmetry::Momenta),
        (of(read(&Midpoint { stiffness: 1.0 })), Symmetry::Momenta),
        (of(&double), Symmetry::Momenta),
        (of(&constrained), Symmetry::Momenta),
        (of(read(&Charge { field: 1.0 })), Symmetry::Momenta),
        (of(read(&OneSided {})), Symmetry::KinematicMap),
        (of(&maps::Weighted { weight: 0.25 }), Symmetry::LagrangianMap),
        (of(&maps::Forward { curvature }), Symmetry::KinematicMap),
        (of(&maps::Mixed { curvature }), Symmetry::VariationalMap),
    ] {
        assert_eq!(found, expected);
    }
    let weighted = maps::Weighted { weight: 0.25 };
    let start = Start::second_order([0.5; 2], [0.0; 2]);
    let error = ComposedFlow::new(&weighted, 0.01, Composition::SUZUKI_4, start).unwrap_err();
    assert!(matches!(
        error,
        SetupError::Composition {
            reason: Symmetry::LagrangianMap,
            ..
        }
    ));
    let text = error.to_string();
    for part in [
        "Suzuki's composition of order 4",
        "phi_lagrangian",
        "order 2",
        "tolerance",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

/// The last position of a run, or the failure of its last stage.
fn run(system: &impl System<1>, method: Composition, h: f64, until: f64) -> Result<f64, StageFailure> {
    let mut flow = ComposedFlow::new(system, h, method, Start::second_order([1.0], [1.0])).unwrap();
    match flow.until(until) {
        Ok(trajectory) => Ok(trajectory.last().unwrap().q[0]),
        Err(failure) => {
            let RunError::Stage(error) = &failure.error else {
                panic!("{failure}")
            };
            assert_eq!(flow.clock().index() + 1, failure.trajectory.len() as u64);
            let text = error.to_string();
            assert!(
                text.contains("back in time") && text.contains("order 2"),
                "{text}"
            );
            Err(error.details().cause.clone())
        }
    }
}

/// A leg of the length `-|γ| h` with the damping `k` has a solution that the motion leads to while `|γ| h k < 2`.
#[test]
fn a_leg_back_beyond_its_singularity_is_refused() {
    let damped = Damped { damping: 40.0 };
    for method in &METHODS[1..] {
        let longest = -method.fractions().fold(0.0, f64::min);
        let limit = 2.0 / (40.0 * longest);
        assert!(matches!(
            run(&damped, *method, 1.02 * limit, 3.0),
            Err(StageFailure::Singularity { .. })
        ));
        assert!(run(&damped, *method, 0.98 * limit, 3.0).is_ok());
        // the step of order 2 has no such limit
        assert!(run(&damped, Composition::SINGLE, 4.0 * limit, 3.0).is_ok());
    }
}

/// At rest within the switch, with the damping 500: back in time the motion leaves the switch at once.
#[test]
fn a_switch_that_is_run_back_is_refused() {
    let system = Friction {
        friction: 0.5,
        small: 1e-3,
    };
    let truth = run(&system, Composition::KAHAN_LI_8, 1e-4, 10.0).unwrap();
    for method in [Composition::KAHAN_LI_6, Composition::KAHAN_LI_8] {
        assert!(matches!(
            run(&system, method, 0.01, 10.0),
            Err(StageFailure::Jump { .. })
        ));
        assert!((run(&system, method, 0.003, 10.0).unwrap() - truth).abs() < 2e-6);
    }
    assert!((run(&system, Composition::SINGLE, 0.01, 10.0).unwrap() - truth).abs() < 1e-4);
}

/// The pendulum's switch has the damping 10: steps up to 0.2 can be composed, 0.4 and more cannot.
#[test]
fn the_pendulum_is_composed_with_steps_that_its_switch_allows() {
    let pendulum = InertiaWheelPendulum::default();
    for method in METHODS {
        let mut flow =
            ComposedFlow::new(&pendulum, 0.2, method, Start::second_order(START.0, START.1)).unwrap();
        assert!(flow.until(500.0).is_ok());
        let mut flow =
            ComposedFlow::new(&pendulum, 0.4, method, Start::second_order(START.0, START.1)).unwrap();
        let long = flow.until(500.0);
        assert_eq!(long.is_ok(), method.order() == 2, "{method}");
        if let Err(failure) = long {
            assert!(failure.to_string().contains("back in time"), "{failure}");
        }
    }
}

#[test]
fn a_run_is_used_like_any_other() {
    let particle = CurvedParticle::default();
    let method = Composition::SUZUKI_4;
    let flow = || {
        let start = Start::second_order([0.0; 2], [1.0; 2]).at(2.0);
        ComposedFlow::new(&particle, 0.1, method, start).unwrap()
    };
    let mut run = flow();
    let first = run.until(3.0).unwrap();
    let second = run.until(4.0).unwrap();
    assert_eq!((first.len(), second.len()), (11, 10));
    assert_eq!((first.nodes[0].t, second.nodes[9].t), (2.0, 4.0));
    let taken: Vec<_> = flow().take(21).map(Result::unwrap).collect();
    assert!(
        first
            .iter()
            .chain(&second)
            .zip(&taken)
            .all(|(one, other)| one == other)
    );
    assert!(matches!(
        run.until(3.0).unwrap_err().error,
        RunError::TimeBehind { .. }
    ));
    assert!(matches!(
        run.until(f64::INFINITY).unwrap_err().error,
        RunError::Until { .. }
    ));
    run.reverse().unwrap();
    let back = run.until(2.0).unwrap();
    assert_eq!(back.len(), 20);
    assert!(distance(back.last().unwrap().q, [0.0; 2]) < 1e-14);
    for (h, v0) in [(0.0, 1.0), (f64::NAN, 1.0), (0.1, f64::NAN), (1e-160, 1.0)] {
        assert!(ComposedFlow::new(&particle, h, method, Start::second_order([0.0; 2], [v0; 2])).is_err());
    }
}
