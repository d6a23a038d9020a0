//! Constraints of third order: the clothoid and the crane against published numbers and closed forms; their
//! starts, orders, forces, and refusals.

use dsocs_core::geometry::DiscreteFlow;
use dsocs_core::taylor::Tolerance;
use dsocs_core::{Composition, Ensemble, InputError, Inputs, RunError, SetupError, Start, Stepper};
use dsocs_systems::{Clothoid, Crane};
use dsocs_tests::declared;
use dsocs_tests::fit::slope;
use dsocs_tests::text::{ComposedFlow, Flow, System, TaylorFlow};

use dsocs_tests::dop853;

/// The end of the clothoid's arc of length 10 with the curvature 0.2 at its beginning, from the literature's integrals.
const END: [f64; 2] = [1.824_124_444_282_838_6, 1.799_225_670_358_786_1];

const STEPS: [f64; 4] = [0.2, 0.1, 0.05, 0.025];

const CLOTHOID: Clothoid = Clothoid { mass: 1.0, rate: 0.1 };

/// A start with the force of the curvature 0.2 at the speed 1.
fn by_force() -> Start<2> {
    Start::third_order_by_force([0.0, 0.0], [1.0, 0.0], [0.0, 0.2])
}

fn by_acceleration() -> Start<2> {
    Start::third_order([0.0, 0.0], [1.0, 0.0], [0.0, 0.2])
}

fn largest<const N: usize>(x: &[f64; N], y: &[f64; N]) -> f64 {
    (0..N).fold(0.0, |most, i| (x[i] - y[i]).abs().max(most))
}

fn positions<S: System<N>, const N: usize>(system: &S, h: f64, start: Start<N>, until: f64) -> Vec<[f64; N]> {
    let mut flow = Flow::new(system, h, start).unwrap();
    let nodes = flow.until(until).unwrap().nodes;
    nodes.iter().map(|node| node.q).collect()
}

fn last<const N: usize>(positions: &[[f64; N]]) -> [f64; N] {
    *positions.last().unwrap()
}

/// Checks errors against a table of three digits.
fn assert_table(found: &[f64], table: &[f64]) {
    for (found, table) in found.iter().zip(table) {
        let digit = 10_f64.powf(table.log10().floor() - 2.0);
        assert!((found - table).abs() <= 0.501 * digit, "{found:e} {table:e}");
    }
}

#[test]
fn the_clothoid_ends_where_the_table_says() {
    let apart = largest(&CLOTHOID.exact(0.2, 10.0), &END);
    assert!(apart < 1e-14, "{apart:e}");
    let errors: Vec<f64> = STEPS
        .iter()
        .map(|&h| largest(&last(&positions(&CLOTHOID, h, by_force(), 10.0)), &END))
        .collect();
    assert_table(&errors, &[4.10e-2, 1.08e-2, 2.74e-3, 6.86e-4]);
    let order = slope(&STEPS[1..], &errors[1..]);
    println!("order {order:.3}, errors {errors:?}");
    assert!((order - 2.0).abs() < 0.05);
}

declared! {
    /// The clothoid with the field instead of the form of its force.
    struct ByField {
        rate: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let square = dot(x).powi(2) + dot(y).powi(2);
    let cross = dot(x) * dddot(y) - dot(y) * dddot(x);
    let turn = dot(x) * ddot(y) - dot(y) * ddot(x);
    kinematic = cross / square.powf(1.5) - 3 * turn * (dot(x) * ddot(x) + dot(y) * ddot(y)) / square.powf(2.5)
        - rate * square.sqrt();
    variational = [(dot(x), dot(y))];
}

#[test]
fn fields_and_forms_give_the_same_motion() {
    for h in [0.1, 0.05] {
        let by_form = positions(&CLOTHOID, h, by_acceleration(), 10.0);
        let by_field = positions(&ByField { rate: 0.1 }, h, by_acceleration(), 10.0);
        for (form, field) in by_form.iter().zip(&by_field) {
            assert!(largest(form, field) < 1e-12);
        }
    }
}

#[test]
fn the_discrete_path_is_the_closed_form() {
    let (clothoid, h) = (CLOTHOID, 0.05);
    for start in [by_force(), by_acceleration()] {
        let nodes = positions(&clothoid, h, start, 20.0);
        let legs: Vec<[f64; 2]> = nodes
            .windows(2)
            .map(|pair| [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]])
            .collect();
        let length = legs[0][0].hypot(legs[0][1]);
        let turns: Vec<f64> = legs
            .windows(2)
            .map(|pair| {
                let [a, b] = [pair[0], pair[1]];
                (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1])
            })
            .collect();
        assert!(
            legs.iter()
                .all(|leg| (leg[0].hypot(leg[1]) - length).abs() < 1e-14)
        );
        for pair in turns.windows(2) {
            assert!((clothoid.turn_after(pair[0], length) - pair[1]).abs() < 2e-13);
        }
    }
}

declared! {
    /// The clothoid by prolongation: the curvature is a coordinate, which changes as the constraint says.
    struct Prolonged {
        rate: f64,
    }
    coordinates(x, y, w);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    nonholonomic = dot(w) - rate * speed;
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - w;
    constraint_forces = [(0, 0, 1), (-dot(y), dot(x), 0)];
}

/// The prolonged system is the divergence form, another discretization of the same motion. Its errors are
/// those of the table, and the curvature grows from triple to triple by the rate times the length of a leg.
#[test]
fn the_prolonged_system_is_the_divergence_form() {
    let mut errors = Vec::new();
    for h in STEPS {
        // the first three nodes of the direct form
        let first = positions(&CLOTHOID, h, by_force(), 2.5 * h);
        let legs = [0, 1].map(|k| [first[k + 1][0] - first[k][0], first[k + 1][1] - first[k][1]]);
        let v = [0, 1].map(|i| (legs[0][i] + legs[1][i]) / (2.0 * h));
        let a = [0, 1].map(|i| (legs[1][i] - legs[0][i]) / (h * h));
        let curvature = (v[0] * a[1] - v[1] * a[0]) / v[0].hypot(v[1]).powi(3);
        let length = legs[0][0].hypot(legs[0][1]);
        let start = Start::nodes(
            [0.0, 0.0, curvature - 0.1 * length],
            [first[1][0], first[1][1], curvature],
        )
        .projected();
        let nodes = positions(&Prolonged { rate: 0.1 }, h, start, 10.0);
        for (k, node) in nodes.iter().enumerate() {
            let expected = curvature + (k as f64 - 1.0) * 0.1 * length;
            assert!((node[2] - expected).abs() < 1e-13, "{} {expected}", node[2]);
        }
        let [x, y, _] = last(&nodes);
        errors.push(largest(&[x, y], &END));
    }
    assert_table(&errors, &[2.71e-2, 6.94e-3, 1.75e-3, 4.37e-4]);
}

declared! {
    /// The linearized crane, driven by a jerk that ends.
    struct LinearCrane {
        trolley: f64,
        load: f64,
        length: f64,
        gravity: f64,
        jerk: f64,
        end: f64,
    }
    coordinates(x, theta);
    lagrangian = trolley / 2 * dot(x).powi(2) + load / 2 * (dot(x) + length * dot(theta)).powi(2)
        - load * gravity * length / 2 * theta.powi(2);
    kinematic = dddot(x) - if t < end { jerk } else { 0 };
    constraint_forces = [(1, 0)];
}

const LINEAR: LinearCrane = LinearCrane {
    trolley: 2.0,
    load: 0.7,
    length: 1.5,
    gravity: 9.81,
    jerk: 0.4,
    end: 1e9,
};

#[test]
fn the_linear_crane_swings_as_the_table_says() {
    let angle = |t: f64| {
        let w = (LINEAR.gravity / LINEAR.length).sqrt();
        -LINEAR.jerk / LINEAR.gravity * (t - (w * t).sin() / w)
    };
    assert!((angle(3.0) + 0.106_643_190_042_61).abs() < 1e-14);
    let steps = [0.1, 0.05, 0.025, 0.0125];
    let rest = Start::third_order([0.0; 2], [0.0; 2], [0.0; 2]);
    let errors: Vec<f64> = steps
        .iter()
        .map(|&h| {
            let [x, theta] = last(&positions(&LINEAR, h, rest, 3.0));
            // a cubic is exact
            assert!((x - 1.8).abs() < 1e-14, "{x}");
            (theta - angle(3.0)).abs()
        })
        .collect();
    let order = slope(&steps[1..], &errors[1..]);
    println!("order {order:.3}, errors {errors:?}");
    assert!((order - 2.0).abs() < 0.05);
}

/// After a jerk for one period of the load, the load rests but for the error of the step.
#[test]
fn a_jerk_of_one_period_leaves_no_sway() {
    let period = std::f64::consts::TAU * (LINEAR.length / LINEAR.gravity).sqrt();
    assert!((period - 2.456_919_878_869_91).abs() < 1e-14);
    let crane = LinearCrane {
        end: period,
        ..LINEAR
    };
    let parts = [40_u32, 80, 160];
    let sways: Vec<f64> = parts
        .iter()
        .map(|part| {
            let start = Start::third_order([0.0; 2], [0.0; 2], [0.0; 2]);
            let nodes = positions(&crane, period / f64::from(*part), start, 2.5 * period);
            let hanging = -LINEAR.jerk * period / LINEAR.gravity;
            let after = nodes.iter().skip(*part as usize + 1);
            after.fold(0.0_f64, |most, [_, theta]| most.max((theta - hanging).abs()))
        })
        .collect();
    let order = slope(&parts.map(|part| f64::from(part).recip()), &sways);
    println!("order {order:.3}, sways {sways:?}");
    assert!((order - 2.0).abs() < 0.1 && sways[2] < 1e-4);
}

/// The page's crane against Dormand and Prince's method of order 8 on the pendulum's equation, with the trolley's path in closed form; and
/// the force of its drive.
#[test]
fn the_crane_is_a_pendulum_under_a_moving_pivot() {
    let crane = Crane::default();
    let (l, g) = (crane.length, crane.gravity);
    let swing = |t: f64, [theta, _]: [f64; 2]| -(g * theta.sin() + crane.trolley(t)[2] * theta.cos()) / l;
    let mut state = [0.0; 2];
    // phase by phase, since the third derivative jumps
    for phase in 0..6 {
        let t0 = f64::from(phase) * crane.phase;
        let equations = |t: f64, state: [f64; 2]| [state[1], swing(t, state)];
        state = dop853::integrate_from(equations, (t0, state), t0 + crane.phase, 1e-14);
    }
    let end = 6.0 * crane.phase;
    let [x, _, a] = crane.trolley(end);
    let force = {
        let sway = swing(end, state);
        (crane.trolley + crane.load) * a
            + crane.load * l * (sway * state[0].cos() - state[1] * state[1] * state[0].sin())
    };
    let parts = [60.0, 120.0, 240.0, 480.0];
    let mut errors = [const { Vec::new() }; 3];
    for part in parts {
        let start = Start::third_order([0.0; 2], [0.0; 2], [0.0; 2]);
        let mut flow = Flow::new(&crane, crane.phase / part, start).unwrap();
        let nodes = flow.until(end).unwrap().nodes;
        let node = nodes.last().unwrap();
        errors[2].push((node.q[0] - x).abs());
        assert!((node.t - end).abs() < 1e-9);
        errors[0].push((node.q[1] - state[0]).abs());
        errors[1].push((node.force[0] - force).abs());
    }
    for errors in &errors {
        let order = slope(&parts.map(f64::recip), errors);
        println!("order {order:.3}, errors {errors:?}");
        assert!((order - 2.0).abs() < 0.15);
    }
}

declared! {
    /// A crane in the plane: the load has coordinates of its own, and the rope is a holonomic constraint.
    struct Roped {
        trolley: f64,
        load: f64,
        length: f64,
        gravity: f64,
        jerk: f64,
    }
    coordinates(x, u, w);
    lagrangian = trolley / 2 * dot(x).powi(2) + load / 2 * (dot(u).powi(2) + dot(w).powi(2)) - load * gravity * w;
    holonomic = (u - x).powi(2) + w.powi(2) - length.powi(2);
    kinematic = dddot(x) - jerk * t.cos();
    constraint_forces = [(1, 0, 0)];
}

declared! {
    /// The crane with the angle as a coordinate.
    struct Angled {
        trolley: f64,
        load: f64,
        length: f64,
        gravity: f64,
        jerk: f64,
    }
    coordinates(x, theta);
    let across = dot(x) + length * dot(theta) * theta.cos();
    let up = length * dot(theta) * theta.sin();
    lagrangian = trolley / 2 * dot(x).powi(2) + load / 2 * (across.powi(2) + up.powi(2)) + load * gravity * length * theta.cos();
    kinematic = dddot(x) - jerk * t.cos();
    variational = [(0, 1)];
}

/// Together with a constraint on positions: nodes are on it, the order is 2, and the motion is that in other
/// coordinates. The jerk depends on time.
#[test]
fn holonomic_constraints_stand_beside_those_of_third_order() {
    let (trolley, load, length, gravity, jerk) = (2.0, 0.7, 1.5, 9.81, 0.8);
    let roped = Roped {
        trolley,
        load,
        length,
        gravity,
        jerk,
    };
    let angled = Angled {
        trolley,
        load,
        length,
        gravity,
        jerk,
    };
    let swing =
        |t: f64, [theta, _]: [f64; 2]| -(gravity * theta.sin() + jerk * t.sin() * theta.cos()) / length;
    let exact = dop853::integrate_from(
        |t, state| [state[1], swing(t, state)],
        (0.0, [0.0; 2]),
        6.0,
        1e-14,
    );
    // ẍ = J sin t, from rest
    let x = jerk * (6.0 - 6.0_f64.sin());
    let steps = [0.1, 0.05, 0.025, 0.0125];
    let mut errors = [Vec::new(), Vec::new()];
    for h in steps {
        let start = Start::third_order([0.0, 0.0, -length], [0.0; 3], [0.0; 3]);
        let nodes = positions(&roped, h, start, 6.0);
        for [x, u, w] in &nodes {
            let missed = (u - x).powi(2) + w.powi(2) - length.powi(2);
            assert!(missed.abs() < 1e-13, "{missed:e}");
        }
        let [found, u, _] = last(&nodes);
        errors[0].push((found - x).abs().max((u - found - length * exact[0].sin()).abs()));
        let nodes = positions(&angled, h, Start::third_order([0.0; 2], [0.0; 2], [0.0; 2]), 6.0);
        errors[1].push(largest(&last(&nodes), &[x, exact[0]]));
    }
    for errors in &errors {
        let order = slope(&steps[1..], &errors[1..]);
        println!("order {order:.3}, errors {errors:?}");
        assert!((order - 2.0).abs() < 0.1);
    }
}

declared! {
    /// A clothoid in the plane, free in the third direction: the forms vary and no fields are known, so that
    /// multipliers are unknown.
    struct Rising {
        rate: f64,
        gravity: f64,
    }
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - gravity * z;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = dot((dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3)) - rate * speed;
    constraint_forces = [(-dot(y), dot(x), 0)];
}

#[test]
fn multipliers_that_are_unknown_give_the_same_motion() {
    let rising = Rising {
        rate: 0.1,
        gravity: 0.5,
    };
    // the nearest second difference of the start is found along other ways
    for (tolerance, flat, start) in [
        (
            1e-11,
            by_acceleration(),
            Start::third_order([0.0; 3], [1.0, 0.0, 0.3], [0.0, 0.2, -0.5]),
        ),
        (
            1e-12,
            by_force(),
            Start::third_order_by_force([0.0; 3], [1.0, 0.0, 0.3], [0.0, 0.2, 0.0]),
        ),
    ] {
        let nodes = positions(&rising, 0.1, start, 10.0);
        let known = positions(&CLOTHOID, 0.1, flat, 10.0);
        for (k, ([x, y, z], known)) in nodes.iter().zip(&known).enumerate() {
            let t = 0.1 * k as f64;
            let apart = largest(&[*x, *y], known);
            assert!(apart < tolerance, "node {k}: {apart:e}");
            assert!((z - (0.3 * t - 0.25 * t * t)).abs() < 1e-12);
        }
    }
    // the nearest acceleration that the free fall allows
    let start = Start::third_order([0.0; 3], [1.0, 0.0, 0.3], [0.0, 0.2, 0.0]);
    assert!(matches!(
        Flow::new(&rising, 0.1, start),
        Err(SetupError::Inconsistent { .. })
    ));
    let [_, _, z] = last(&positions(&rising, 0.1, start.projected(), 1.0));
    assert!((z - 0.05).abs() < 1e-13, "{z}");
}

/// The previous nodes are carried with their rounding errors: a cubic stays one over many small steps.
#[test]
fn digits_are_kept_over_many_steps() {
    let h = 1.0 / 65_536.0;
    let rest = Start::third_order([0.0; 2], [0.0; 2], [0.0; 2]);
    let [x, _] = last(&positions(&LINEAR, h, rest, 1.0));
    assert!((x - 0.4 / 6.0).abs() < 1e-15, "{:e}", x - 0.4 / 6.0);
}

#[test]
fn a_motion_runs_back() {
    for turn in [0.0, 7.3] {
        let mut flow = Flow::new(&CLOTHOID, 0.1, by_force()).unwrap();
        let there = flow.until(turn).unwrap().nodes;
        flow.reverse().unwrap();
        let back = flow.until(0.0).unwrap().nodes;
        for (node, other) in there
            .iter()
            .rev()
            .zip(std::iter::once(there.last().unwrap()).chain(&back))
        {
            assert!(largest(&node.q, &other.q) < 1e-13, "{node:?} {other:?}");
        }
        // and there again
        flow.reverse().unwrap();
        let end = flow.until(turn).unwrap().nodes;
        if let Some(last) = end.last() {
            assert!(largest(&last.q, &there.last().unwrap().q) < 1e-13);
        }
    }
    // reversed at the start, the motion continues on the clothoid's other half
    let mut flow = Flow::new(&CLOTHOID, 0.01, by_acceleration()).unwrap();
    flow.reverse().unwrap();
    let nodes = flow.until(-5.0).unwrap().nodes;
    let expected = CLOTHOID.exact(0.2, -5.0);
    assert!(largest(&nodes.last().unwrap().q, &expected) < 1e-4);
}

#[test]
fn steps_are_regular_both_ways() {
    let mut flow = Flow::new(&CLOTHOID, 0.1, by_force()).unwrap();
    flow.until(3.0).unwrap();
    let regularity = flow.regularity().unwrap();
    assert!(regularity.grants_flow(), "{regularity:?}");
}

declared! {
    /// A constraint whose third derivative no force changes.
    struct Blind {}
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = dddot(y) - 1;
    constraint_forces = [(1, 0)];
}

declared! {
    /// A constraint of second order.
    struct Second {}
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = ddot(x) - 1;
    constraint_forces = [(1, 0)];
}

#[test]
fn starts_say_what_is_missing() {
    let message = |error: SetupError| error.to_string();
    let [q, v] = [[0.0, 0.0], [1.0, 0.0]];
    let error = Flow::new(&CLOTHOID, 0.1, Start::second_order(q, v)).unwrap_err();
    assert_eq!(error, SetupError::FreeAcceleration);
    assert!(message(error).contains("`Start::third_order(q0, v0, a0)`"));
    let error = Flow::new(&Second {}, 0.1, by_acceleration()).unwrap_err();
    assert_eq!(error, SetupError::DeterminedAcceleration);
    assert!(message(error).contains("`Start::second_order(q0, v0)`"));
    let error = Flow::new(&Blind {}, 0.1, by_force()).unwrap_err();
    assert!(matches!(error, SetupError::Inconsistent { .. }), "{error}");
    let error = Flow::new(&Blind {}, 0.1, Start::third_order(q, v, [1.0, 0.0])).unwrap_err();
    assert!(matches!(error, SetupError::Jerk { .. }));
    assert!(
        message(error).contains("the rate of the constraint force must change the constraint of third order")
    );
    // a force along the path is none of the constraint's
    let along = Start::third_order_by_force(q, v, [0.1, 0.2]);
    let error = Flow::new(&CLOTHOID, 0.1, along).unwrap_err();
    assert!(message(error).contains("at (q0, v0, a0)"));
    let error = Flow::new(&CLOTHOID, 0.1, Start::third_order(q, v, [0.0, f64::NAN])).unwrap_err();
    assert!(matches!(error, SetupError::Start { vector: "a0", .. }));
    assert!(matches!(
        Flow::new(&CLOTHOID, 1e-110, by_force()),
        Err(SetupError::StepRange { .. })
    ));
}

/// Taylor flows, compositions, ensembles, discrete maps and inputs refuse a constraint of third order, with
/// an error that names the order.
#[test]
fn what_knows_no_third_order_says_so() {
    let clothoid = CLOTHOID;
    let third = |error: &SetupError| matches!(error, SetupError::ThirdOrder { .. });
    let error = TaylorFlow::new(&clothoid, by_force(), Tolerance::relative(1e-10))
        .err()
        .unwrap();
    assert!(third(&error) && error.to_string().contains("take the discrete flow (Flow)"));
    let error = ComposedFlow::new(&clothoid, 0.1, Composition::SUZUKI_4, by_force())
        .err()
        .unwrap();
    assert!(
        error.to_string().contains("a constraint is of third order"),
        "{error}"
    );
    assert!(third(&Ensemble::new(&clothoid, 0.1).err().unwrap()));
    assert!(
        DiscreteFlow::new(&clothoid, 0.1)
            .unwrap_err()
            .to_string()
            .contains("third")
    );
    let mut flow = Flow::new(&clothoid, 0.1, by_force()).unwrap();
    let error = flow.set_input("rate", 0.2).unwrap_err();
    assert!(matches!(error, RunError::Input(error) if matches!(*error, InputError::ThirdOrder { .. })));
}
