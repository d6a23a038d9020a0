//! The paper's pendulum with friction: along the motor, in the pivot with compensation, and in the pivot
//! without.

use dsocs_core::{
    DependentRow, Flow, Node, RunError, Start, StepFailure, Stepper, System, TaylorFlow, Tolerance, dsocs,
};
use dsocs_systems::{FrictionPendulum, InertiaWheelPendulum, StalledPendulum};

use super::is_second;
use dsocs_tests::dop853;
use dsocs_tests::motion::{continuous, discrete, distance};
use dsocs_tests::plan::Plan;

const START: Start<2> = Start::second_order([0.5, 0.0], [0.0, 0.5]);

fn nodes<S: System<2>>(system: &S, h: f64, t: f64) -> Vec<Node<2>> {
    Flow::new(system, h, START).unwrap().until(t).unwrap().nodes
}

/// The motor compensates friction along itself: the nodes are the same, and its torque is larger by the
/// friction.
#[test]
fn friction_along_the_motor_changes_the_torque_alone() {
    let free = InertiaWheelPendulum::default();
    let motor = FrictionPendulum {
        pivot: 0.0,
        ..FrictionPendulum::default()
    };
    let h = 0.05;
    for (node, other) in nodes(&free, h, 20.0).iter().zip(&nodes(&motor, h, 20.0)) {
        // ψ is about 150 times as far as θ is, and rounding grows as the motion does
        let apart = [0, 1].map(|i| (node.q[i] - other.q[i]).abs());
        assert!(
            apart[0] < 1e-10 && apart[1] < 2e-8,
            "{apart:?} {node:?} {other:?}"
        );
        let more = other.force[1] - node.force[1] - motor.motor * node.v[1];
        assert!(
            more.abs() < 1e-8 * (1.0 + node.force[1].abs()),
            "{more:e} {node:?}"
        );
        assert!(other.force[0].abs() < 1e-9, "{other:?}");
    }
}

/// A pendulum with friction whose motor follows a plan of torques.
#[dsocs {
    coordinates(theta, psi);
    lagrangian = i / 2 * dot(theta).powi(2) + j / 2 * (dot(theta) + dot(psi)).powi(2) - m * (1 + theta.cos());
    external_forces = (0, plan.at(t) - motor * dot(psi));
}]
struct Driven {
    i: f64,
    j: f64,
    m: f64,
    motor: f64,
    plan: Plan,
}

/// The constraint force no longer contains the friction that is declared: replayed as an open-loop torque beside that friction
/// it makes the same motion, and without the friction another one.
#[test]
fn the_torque_replayed_beside_the_friction_makes_the_same_motion() {
    let FrictionPendulum { i, j, m, motor, .. } = FrictionPendulum::default();
    let closed = FrictionPendulum {
        pivot: 0.0,
        ..FrictionPendulum::default()
    };
    let h = 0.05;
    let nodes = nodes(&closed, h, 10.0 + h);
    let replay = |motor: f64| {
        let samples = nodes.iter().map(|node| node.force[1]).collect();
        let driven = Driven {
            i,
            j,
            m,
            motor,
            plan: Plan { h, samples },
        };
        let mut flow = Flow::new(&driven, h, Start::nodes(nodes[0].q, nodes[1].q)).unwrap();
        let replayed = flow.until(10.0).unwrap().nodes;
        assert!(
            replayed
                .iter()
                .skip(1)
                .all(|node| distance(&node.force, &[0.0; 2]) < 1e-8)
        );
        let apart = nodes
            .iter()
            .zip(&replayed)
            .map(|(one, other)| (one.q[0] - other.q[0]).abs());
        apart.fold(0.0, f64::max)
    };
    let (same, other) = (replay(motor), replay(0.0));
    println!("θ apart by {same:.1e}, without the friction by {other:.1e}");
    assert!(same < 1e-10 && other > 1e-3, "{same:e} {other:e}");
}

#[test]
fn friction_in_the_pivot_that_is_made_up_for_leaves_the_motors_law() {
    let pendulum = FrictionPendulum {
        pivot: 5.0,
        ..FrictionPendulum::default()
    };
    let p2 = pendulum.j * 0.5;
    let state = [0.5, 0.0, p2, p2];
    let [theta, ..] = dop853::integrate(|_, state| pendulum.proper_branch(state), state, 10.0, 1e-13);
    let apart = (continuous(&pendulum, START, 10.0).q[0] - theta).abs();
    println!("apart by {apart:.1e}");
    assert!(apart < 1e-10, "{apart:e}");
    is_second("θ", [0.1, 0.05, 0.025, 0.0125], |h| {
        (discrete(&pendulum, h, START, 10.0).q[0] - theta).abs()
    });
    // the friction matters: 5 N m s turn the pendulum by more than any error
    let free = continuous(&InertiaWheelPendulum::default(), START, 10.0).q[0];
    assert!((theta - free).abs() > 1e-2, "{theta} {free}");
}

/// `w` at a node.
fn w(pendulum: &StalledPendulum, node: &Node<2>) -> f64 {
    let mut observed = [0.0; 4];
    pendulum.observe(&node.point(), &mut observed);
    observed[3]
}

#[test]
fn friction_that_is_not_made_up_for_ends_the_motion() {
    let pendulum = StalledPendulum {
        pivot: 0.01,
        ..StalledPendulum::default()
    };
    // the continuous motion ends at the first zero of w
    let mut series = TaylorFlow::new(&pendulum, START, Tolerance::relative(1e-12)).unwrap();
    let end = series.until(100.0).unwrap_err();
    let last = end.trajectory.nodes.last().unwrap();
    let (ends, least) = (last.t, w(&pendulum, last).abs());
    println!("the continuous motion ends at t = {ends} with w = {least:.1e}");
    assert!(ends > 20.0 && ends < 30.0 && least < 1e-3, "{ends} {least:e}");
    // so do the discrete ones, with an error that names the constraint
    for h in [0.1, 0.05, 0.01, 0.001] {
        let failed = Flow::new(&pendulum, h, START).unwrap().until(100.0).unwrap_err();
        let RunError::Step(error) = &failed.error else {
            panic!("{}", failed.error);
        };
        let (details, text) = (error.details(), error.to_string());
        assert!((details.time - ends).abs() < 1.5 * h, "{} {ends}", details.time);
        assert_eq!(details.cause.reason, StepFailure::NoSolution, "{text}");
        let &[(ref row, left)] = &details.unmet[..] else {
            panic!("{:?}", details.unmet);
        };
        assert_eq!(*row, DependentRow::Kinematic(0));
        assert!(text.contains("cannot be met"), "{text}");
        assert!(
            text.contains("the smallest value of kinematic constraint 1 that is reached is"),
            "{text}"
        );
        assert!(
            !text.contains("does not converge") && !text.contains("divide("),
            "{text}"
        );
        // no candidate is nearer: along those that fulfil the variational row, where the motor is free
        let two = |x: &[f64]| [x[0], x[1]];
        let (q0, q1, q2) = (two(&details.q0), two(&details.q1), two(&details.q2));
        let row_at = |q2: [f64; 2]| pendulum.residual(details.time, h, &[q0, q1, q2]);
        let by_psi = row_at([q2[0], q2[1] + 1.0])[1] - row_at(q2)[1];
        let by_theta = row_at([q2[0] + 1.0, q2[1]])[1] - row_at(q2)[1];
        let length = q2[0] - q1[0];
        let least = (-2000..=2000)
            .map(|k| {
                let theta = f64::from(k) * 1e-5 * length;
                row_at([q2[0] + theta, q2[1] - theta * by_theta / by_psi])[0]
            })
            .fold(f64::INFINITY, f64::min);
        println!(
            "h = {h}: t = {}, left {left:.6e}, least by hand {least:.6e}",
            details.time
        );
        assert!(left > 0.0 && (least / left - 1.0).abs() < 1e-2, "{left} {least}");
    }
    // the command line's own time ends earlier
    assert!(
        Flow::new(&StalledPendulum::default(), 0.05, START)
            .unwrap()
            .until(20.0)
            .is_ok()
    );
}
