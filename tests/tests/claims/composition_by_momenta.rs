//! Composed steps whose legs are joined by momenta: systems with a varying mass matrix, and with external
//! forces of any kind.

use std::time::Instant;

use dsocs_core::{Composition, Inputs, RunError, StageFailure, Start, Stepper, Symmetry};
use dsocs_tests::declared;
use dsocs_tests::fit;
use dsocs_tests::text::{ComposedFlow, Flow, System};

use crate::systems::mass::DoublePendulumMidpoint;
use dsocs_tests::dop853;

/// The methods with steps per unit of time for which their errors show the order.
const METHODS: [(Composition, [u32; 5]); 4] = [
    (Composition::SINGLE, [40, 56, 80, 112, 160]),
    (Composition::SUZUKI_4, [16, 20, 24, 32, 40]),
    (Composition::KAHAN_LI_6, [12, 14, 16, 18, 20]),
    (Composition::KAHAN_LI_8, [8, 9, 10, 11, 12]),
];

/// Errors below this are rounding and are left out of the fits.
const PLATEAU: f64 = 1e-11;

/// The accelerations of two links with the torques `t` at their angles: of unit lengths, the lower mass `ratio` times the upper.
fn links(ratio: f64, gravity: f64, [alpha, beta]: [f64; 2], [u, w]: [f64; 2], t: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = (alpha - beta).sin_cos();
    let right = [
        t[0] - ratio * w * w * sin - gravity * (1.0 + ratio) * alpha.sin(),
        t[1] + ratio * u * u * sin - gravity * ratio * beta.sin(),
    ];
    let determinant = (1.0 + ratio) * ratio - ratio * ratio * cos * cos;
    [
        (ratio * right[0] - ratio * cos * right[1]) / determinant,
        ((1.0 + ratio) * right[1] - ratio * cos * right[0]) / determinant,
    ]
}

/// Asserts the order of each method, by the largest distance at some times from the method of Dormand and Prince; for the order 8 with
/// other numbers of steps per unit of time, between steps too large for a power law and rounding.
#[track_caller]
fn assert_orders<S: System<2>>(
    system: &S,
    start: ([f64; 2], [f64; 2]),
    (times, eighth): (&[f64], [u32; 5]),
    rate: impl Fn(f64, [f64; 4]) -> [f64; 4],
) {
    assert_eq!(system.symmetry(), Symmetry::Momenta);
    let ([q0, q1], [v0, v1]) = start;
    let truth = times
        .iter()
        .map(|t| dop853::integrate_from(&rate, (0.0, [q0, q1, v0, v1]), *t, 1e-13));
    let truth: Vec<_> = truth.collect();
    for (method, mut parts) in METHODS {
        if method.order() == 8 {
            parts = eighth;
        }
        let steps = parts.map(|parts| f64::from(parts).recip());
        let errors = steps.map(|h| {
            let start = Start::second_order(start.0, start.1);
            let mut flow = ComposedFlow::new(system, h, method, start).unwrap();
            let mut largest = 0.0_f64;
            for (t, truth) in times.iter().zip(&truth) {
                let node = flow.to(*t).unwrap();
                assert!((node.t - t).abs() < 1e-9, "no node at {t}");
                let [q, v] = [node.q, node.v];
                let apart = [q[0] - truth[0], q[1] - truth[1], v[0] - truth[2], v[1] - truth[3]];
                largest = apart.iter().fold(largest, |sum, x| sum.max(x.abs()));
            }
            largest
        });
        let clear: Vec<_> = steps
            .iter()
            .zip(&errors)
            .filter(|(_, error)| **error > PLATEAU)
            .collect();
        let (steps, errors): (Vec<f64>, Vec<f64>) = clear.into_iter().unzip();
        assert!(steps.len() >= 3, "{method}: {errors:?}");
        let slope = fit::slope(&steps, &errors);
        println!("{method}: slope {slope:.3}, errors {errors:?}");
        let order = f64::from(method.order());
        assert!((slope - order).abs() < 0.05 * order, "{method}: {slope}");
    }
}

#[test]
fn orders_where_the_mass_matrix_varies() {
    let pendulum = DoublePendulumMidpoint {
        ratio: 0.5,
        gravity: 4.0,
    };
    assert_orders(
        &pendulum,
        ([1.0, 0.4], [0.0, 0.5]),
        (&[4.0, 8.0], [18, 20, 22, 24, 26]),
        |_, [a, b, u, w]| {
            let [du, dw] = links(0.5, 4.0, [a, b], [u, w], [0.0; 2]);
            [u, w, du, dw]
        },
    );
}

declared! {
    /// A double pendulum with dry friction at its elbow, and pushed.
    #[derive(Clone)]
    struct Pushed {
        ratio: f64,
        gravity: f64,
        friction: f64,
        push: f64,
    }
    coordinates(alpha, beta);
    let kinetic = (1 + ratio) / 2 * dot(alpha).powi(2) + ratio / 2 * dot(beta).powi(2)
        + ratio * dot(alpha) * dot(beta) * (alpha - beta).cos();
    lagrangian = kinetic + gravity * ((1 + ratio) * alpha.cos() + ratio * beta.cos());
    let between = friction * (dot(beta) - dot(alpha)).tanh();
    external_forces = (between + push * (1.5 * t).sin(), -between);
}

const PUSHED: Pushed = Pushed {
    ratio: 0.5,
    gravity: 1.0,
    friction: 0.4,
    push: 0.6,
};

#[test]
fn orders_beside_forces_that_depend_on_velocity_and_time() {
    assert_orders(
        &PUSHED,
        ([1.0, 0.4], [0.0, 0.5]),
        (&[2.0, 4.0], [4, 5, 6, 7, 8]),
        |t, [a, b, u, w]| {
            let between = 0.4 * (w - u).tanh();
            let torques = [between + 0.6 * (1.5 * t).sin(), -between];
            let [du, dw] = links(0.5, 1.0, [a, b], [u, w], torques);
            [u, w, du, dw]
        },
    );
}

declared! {
    /// Two links whose energy falls, by a torque at the elbow.
    struct Elbow {
        ratio: f64,
        gravity: f64,
    }
    coordinates(alpha, beta);
    let kinetic = (1 + ratio) / 2 * dot(alpha).powi(2) + ratio / 2 * dot(beta).powi(2)
        + ratio * dot(alpha) * dot(beta) * (alpha - beta).cos();
    let potential = -gravity * ((1 + ratio) * alpha.cos() + ratio * beta.cos());
    lagrangian = kinetic - potential;
    /// The rate at which the energy falls [J/s].
    let rate = dot(kinetic + potential) + (dot(alpha) - dot(beta)).powi(2);
    kinematic = rate;
    branch = divide(dot(alpha) - dot(beta));
    constraint_forces = [(1, -1)];
    observe = [rate];
}

/// The power of a torque `τ` at the elbow is `τ (u - w)`, so the constraint requires `τ = -(u - w)`.
#[test]
fn orders_beside_a_constraint_of_second_order() {
    let rate = |_, [a, b, u, w]: [f64; 4]| {
        let [du, dw] = links(0.5, 1.0, [a, b], [u, w], [w - u, u - w]);
        [u, w, du, dw]
    };
    let start = ([1.0, 0.4], [0.3, -0.5]);
    let elbow = Elbow {
        ratio: 0.5,
        gravity: 1.0,
    };
    assert_orders(&elbow, start, (&[2.0, 4.0], [10, 11, 12, 13, 14]), rate);
    // the constraint holds at every node, and the force is that of the continuous system
    let start = Start::second_order(start.0, start.1);
    let mut flow = ComposedFlow::new(&elbow, 0.125, Composition::SUZUKI_4, start).unwrap();
    for node in &flow.until(3.0).unwrap() {
        let torque = node.v[1] - node.v[0];
        assert!((node.force[0] - torque).abs() < 1e-12 && (node.force[1] + torque).abs() < 1e-12);
    }
}

/// Without constraints a single leg is the discrete flow of `L_d`, node by node.
#[test]
fn a_single_leg_is_the_discrete_flow() {
    let pendulum = DoublePendulumMidpoint {
        ratio: 0.5,
        gravity: 1.0,
    };
    let start = Start::second_order([1.0, 0.4], [0.0, 0.5]);
    let mut single = ComposedFlow::new(&pendulum, 0.05, Composition::SINGLE, start).unwrap();
    let composed = single.until(20.0).unwrap().nodes;
    let start = Start::nodes(composed[0].q, composed[1].q);
    let discrete = Flow::new(&pendulum, 0.05, start)
        .unwrap()
        .until(20.0)
        .unwrap()
        .nodes;
    assert_eq!(composed.len(), discrete.len());
    for (one, other) in composed.iter().zip(&discrete) {
        let apart = (one.q[0] - other.q[0]).hypot(one.q[1] - other.q[1]);
        assert!(apart < 1e-11, "{apart:e} at {}", one.t);
    }
}

/// A composed run to t = 2 and back returns to its start in position and velocity: to 1e-12 beside external
/// forces, to 1e-10 beside a constraint of second order.
#[test]
fn what_is_done_is_undone() {
    fn there_and_back<S: System<2>>(system: &S, method: Composition) -> f64 {
        let (q, v) = ([1.0, 0.4], [0.3, -0.5]);
        let mut flow = ComposedFlow::new(system, 0.0625, method, Start::second_order(q, v)).unwrap();
        flow.to(2.0).unwrap();
        flow.reverse().unwrap();
        let end = flow.to(0.0).unwrap();
        let apart = [end.q[0] - q[0], end.q[1] - q[1], end.v[0] - v[0], end.v[1] - v[1]];
        apart.iter().fold(0.0_f64, |sum, x| sum.hypot(*x))
    }
    for (method, _) in METHODS {
        let elbow = Elbow {
            ratio: 0.5,
            gravity: 1.0,
        };
        let apart = [there_and_back(&PUSHED, method), there_and_back(&elbow, method)];
        println!("{method}: {apart:?}");
        // where the factor of the constraint that is divided out passes zero, rounding grows
        assert!(apart[0] < 1e-12 && apart[1] < 1e-10, "{method}: {apart:?}");
    }
}

/// The energy of a free motion stays near its first value, the nearer the higher the order, and does not
/// drift.
#[test]
fn energy_does_not_drift() {
    let pendulum = DoublePendulumMidpoint {
        ratio: 0.5,
        gravity: 1.0,
    };
    for (method, h) in [(Composition::SUZUKI_4, 0.125), (Composition::KAHAN_LI_6, 0.125)] {
        let start = Start::second_order([1.0, 0.4], [0.0, 0.5]);
        let mut flow = ComposedFlow::new(&pendulum, h, method, start).unwrap();
        let energy = flow.node().energy;
        let mut wander = |until: f64| {
            let nodes = flow.until(until).unwrap().nodes;
            nodes
                .iter()
                .fold(0.0_f64, |most, node| most.max((node.energy - energy).abs()))
        };
        let [early, late] = [wander(100.0), wander(1000.0)];
        println!("{method}: {early:.1e} up to t = 100, {late:.1e} up to t = 1000");
        assert!(late < 1.5 * early, "{method}: {early:e}, {late:e}");
        assert!(early < 1e-3, "{method}: {early:e}");
    }
}

declared! {
    /// A damped spring whose forces are taken at the middle of the leg.
    struct Damped {
        damping: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    kinematic = ddot(x) + damping * dot(x) + x;
    constraint_forces = [(1,)];
    phi_lagrangian = midpoint;
}

/// A leg of the length `-|γ| h` with the damping `k` has a solution that the motion leads to while `|γ| h k <
/// 2`, as with legs that are joined by parabolas.
#[test]
fn a_leg_back_beyond_its_singularity_is_refused() {
    let damped = Damped { damping: 40.0 };
    assert_eq!(System::<1>::symmetry(&damped), Symmetry::Momenta);
    let run = |method: Composition, h: f64| {
        let mut flow = ComposedFlow::new(&damped, h, method, Start::second_order([1.0], [1.0])).unwrap();
        flow.until(3.0).map_err(|failure| failure.error)
    };
    for (method, _) in &METHODS[1..] {
        let longest = -method.fractions().fold(0.0, f64::min);
        let limit = 2.0 / (40.0 * longest);
        let error = run(*method, 1.02 * limit).unwrap_err();
        let RunError::Stage(stage) = &error else {
            panic!("{error}")
        };
        assert!(
            matches!(stage.details().cause, StageFailure::Singularity { .. }),
            "{error}"
        );
        assert!(error.to_string().contains("smaller h"), "{error}");
        assert!(run(*method, 0.98 * limit).is_ok());
        assert!(run(Composition::SINGLE, 4.0 * limit).is_ok());
    }
}

/// Where an input changes at a node the momentum is continuous, and the motion is that of a run that begins
/// there.
#[test]
fn inputs_change_at_nodes() {
    let start = Start::second_order([1.0, 0.4], [0.3, -0.5]);
    let mut flow = ComposedFlow::new(&PUSHED, 0.125, Composition::KAHAN_LI_6, start).unwrap();
    let middle = flow.to(1.0).unwrap();
    flow.set_input("friction", 2.0).unwrap();
    let end = flow.to(2.0).unwrap();
    let other = Pushed {
        friction: 2.0,
        ..PUSHED
    };
    let again = Start::second_order(middle.q, middle.v).at(1.0);
    let anew = ComposedFlow::new(&other, 0.125, Composition::KAHAN_LI_6, again)
        .unwrap()
        .to(2.0)
        .unwrap();
    assert!((end.q[0] - anew.q[0]).hypot(end.q[1] - anew.q[1]) < 1e-13);
    let unchanged = ComposedFlow::new(&PUSHED, 0.125, Composition::KAHAN_LI_6, start)
        .unwrap()
        .to(2.0)
        .unwrap();
    assert!((end.q[0] - unchanged.q[0]).abs() > 1e-3);
}

/// The error of a leg without a solution contains its time and its reason.
#[test]
fn a_leg_without_solution_is_told() {
    let start = Start::second_order([1.0, 0.4], [300.0, -500.0]);
    let mut flow = ComposedFlow::new(&PUSHED, 1.0, Composition::SUZUKI_4, start).unwrap();
    let failure = flow.until(1000.0).unwrap_err();
    let text = failure.error.to_string();
    println!("{text}");
    assert!(text.contains("stage") && text.contains("smaller h"), "{text}");
}

/// The time of a stage of order 6, over that of a generated step.
fn cost_of<S: System<2>>(name: &str, system: &S) {
    const STEPS: u32 = 500;
    let start = Start::second_order([0.5, 0.2], [0.0, 0.5]);
    let mut all = [Vec::new(), Vec::new()];
    for _ in 0..7 {
        let mut step = Flow::new(system, 0.01, start).unwrap();
        let begun = Instant::now();
        for _ in 0..10 * STEPS {
            step.advance().unwrap();
        }
        all[0].push(begun.elapsed().as_secs_f64() / f64::from(10 * STEPS));
        let method = Composition::KAHAN_LI_6;
        let mut composed = ComposedFlow::new(system, 0.01, method, start).unwrap();
        let begun = Instant::now();
        for _ in 0..STEPS {
            composed.advance().unwrap();
        }
        let stages = f64::from(STEPS) * method.stages() as f64;
        all[1].push(begun.elapsed().as_secs_f64() / stages);
    }
    let [step, stage] = all.map(|mut times| {
        times.sort_unstable_by(f64::total_cmp);
        1e6 * times[times.len() / 2]
    });
    println!(
        "{name}: a step {step:.2} µs, a leg {stage:.1} µs, ratio {:.0}",
        stage / step
    );
}

/// `cargo test --release -p dsocs-tests --test claims composition_by_momenta::what_a_leg_costs -- --ignored --nocapture`
#[test]
#[ignore = "a measurement"]
fn what_a_leg_costs() {
    let (ratio, gravity) = (0.5, 1.0);
    cost_of("double pendulum", &DoublePendulumMidpoint { ratio, gravity });
    cost_of(
        "the same with a torque by a constraint",
        &Servo { ratio, gravity },
    );
}

declared! {
    /// Two links, the upper of which is held back by a servo.
    struct Servo {
        ratio: f64,
        gravity: f64,
    }
    coordinates(alpha, beta);
    lagrangian = (1 + ratio) / 2 * dot(alpha).powi(2) + ratio / 2 * dot(beta).powi(2)
        + ratio * dot(alpha) * dot(beta) * (alpha - beta).cos()
        + gravity * ((1 + ratio) * alpha.cos() + ratio * beta.cos());
    kinematic = ddot(alpha) + dot(alpha) + alpha;
    constraint_forces = [(1, 0)];
}
