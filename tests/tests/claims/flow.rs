//! A run as an iterator, as a collection and as a stream: the same nodes.

#![allow(clippy::float_cmp)] // the same numbers, to the last bit

use std::ops::ControlFlow;

use dsocs_core::{Flow, Node, RunError, Start, Stepper, Stop, System, TimeBehind, Trajectory};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum};
use dsocs_tests::closed_form::Polygon;
use dsocs_tests::closed_form::pendulum::START;

const START_OF_PARTICLE: Start<2> = Start::paper([0.0, 0.0], [1.0, 1.0]);

#[test]
fn five_hundred_in_steps_of_a_tenth_are_five_thousand_and_one_nodes() {
    let particle = CurvedParticle::default();
    for (h, until, count) in [
        (0.1, 500.0, 5001),
        (0.1, 0.3, 4),
        (0.1, 0.35, 4),
        (0.1, 0.0, 1),
        (0.1, 0.09, 1),
        (0.7, 7.0, 11),
    ] {
        let trajectory = Flow::new(&particle, h, START_OF_PARTICLE)
            .unwrap()
            .until(until)
            .unwrap();
        assert_eq!(trajectory.len(), count, "h = {h}, t = {until}");
        for (k, node) in trajectory.iter().enumerate() {
            assert_eq!(node.index, k as u64);
            assert!((node.t - k as f64 * h).abs() <= 1e-15 * node.t.abs());
        }
    }
}

#[test]
fn iterator_collection_and_stream_are_one() {
    let pendulum = InertiaWheelPendulum::default();
    let start = Start::second_order(START.0, START.1);
    let collected = Flow::new(&pendulum, 0.1, start).unwrap().until(20.0).unwrap();
    assert_eq!(collected.len(), 201);

    let mut streamed = Trajectory::default();
    Flow::new(&pendulum, 0.1, start)
        .unwrap()
        .stream(20.0, &mut streamed)
        .unwrap();
    assert_eq!(collected, streamed);

    let iterated: Result<Vec<_>, _> = Flow::new(&pendulum, 0.1, start).unwrap().take(201).collect();
    assert_eq!(collected.nodes, iterated.unwrap());

    let mut closure = Vec::new();
    Flow::new(&pendulum, 0.1, start)
        .unwrap()
        .stream(20.0, &mut |node: &Node<2>| closure.push(*node))
        .unwrap();
    assert_eq!(collected.nodes, closure);

    // in two parts, and step by step
    let mut flow = Flow::new(&pendulum, 0.1, start).unwrap();
    let mut parts = flow.until(7.05).unwrap().nodes;
    parts.extend(flow.until(20.0).unwrap());
    assert_eq!(collected.nodes, parts);
    let mut flow = Flow::new(&pendulum, 0.1, start).unwrap();
    for node in &collected.nodes[1..] {
        assert_eq!(*flow.position(), node.q);
        flow.advance().unwrap();
        assert_eq!(flow.node(), *node);
    }
}

#[test]
fn node_0_is_the_start() {
    let pendulum = InertiaWheelPendulum::default();
    let (q0, v0) = START;
    for start in [Start::paper(q0, v0), Start::second_order(q0, v0)] {
        let node = Flow::new(&pendulum, 0.1, start).unwrap().next().unwrap().unwrap();
        assert_eq!((node.index, node.iterations, node.stop), (0, 0, Stop::Start));
        assert_eq!((node.t, node.q, node.v), (0.0, q0, v0));
        assert_eq!(node.energy, pendulum.energy(0.0, &q0, &v0));
        // the multiplier λ = −Q of the reference at t = 0
        assert!(
            (node.force[1] - 1_102.606_955_643_461).abs() < 1e-9,
            "{:?}",
            node.force
        );
        assert!(node.force[0].abs() < 1e-9);
    }
    let node = Flow::new(&pendulum, 0.1, Start::nodes([0.5, 0.0], [0.5, 0.05]))
        .unwrap()
        .next()
        .unwrap()
        .unwrap();
    assert_eq!((node.q, node.v), ([0.5, 0.0], [0.0, 0.5]));
}

#[test]
fn a_node_says_what_the_maps_say() {
    let particle = CurvedParticle {
        mass: 2.0,
        ..CurvedParticle::default()
    };
    let h = 0.1;
    let nodes = Flow::new(&particle, h, START_OF_PARTICLE)
        .unwrap()
        .until(10.0)
        .unwrap()
        .nodes;
    for triple in nodes.windows(3) {
        let [before, node, after] = triple else {
            unreachable!()
        };
        for i in 0..2 {
            assert!((node.v[i] - (after.q[i] - before.q[i]) / (2.0 * h)).abs() < 1e-14);
            assert!((node.a[i] - (after.q[i] - 2.0 * node.q[i] + before.q[i]) / (h * h)).abs() < 1e-12);
            assert!((node.force[i] - 2.0 * node.a[i]).abs() < 1e-13);
        }
        assert!((node.energy - (node.v[0].powi(2) + node.v[1].powi(2))).abs() < 1e-14);
    }
}

#[test]
fn a_negative_step_runs_back_in_time() {
    let particle = CurvedParticle::default();
    let start = Start::second_order([0.0, 0.0], [1.0, 1.0]);
    let back = Flow::new(&particle, -0.1, start).unwrap().until(-50.0).unwrap();
    assert_eq!(back.len(), 501);
    assert!((back.last().unwrap().t + 50.0).abs() < 1e-12);
    // the mirror image in the line x = y of the path forward, run the other way
    let there = Flow::new(&particle, 0.1, start).unwrap().until(50.0).unwrap();
    for (back, there) in back.iter().zip(&there) {
        assert!((back.q[0] + there.q[1]).abs() < 1e-12 && (back.q[1] + there.q[0]).abs() < 1e-12);
        assert!((back.t + there.t).abs() < 1e-12);
        assert!(
            (back.v[0] - there.v[1]).abs() < 1e-12,
            "velocities are velocities in time"
        );
    }
}

#[test]
fn turning_round_retraces_the_nodes() {
    let particle = CurvedParticle::default();
    let mut flow = Flow::new(&particle, 0.1, START_OF_PARTICLE).unwrap();
    let there = flow.until(10.0).unwrap();
    flow.reverse().unwrap();
    let back = flow.until(0.1).unwrap();
    for node in &back {
        let before = there
            .iter()
            .find(|before| (before.t - node.t).abs() < 1e-9)
            .unwrap();
        for i in 0..2 {
            assert!((node.q[i] - before.q[i]).abs() < 1e-13);
            assert!(
                (node.v[i] - before.v[i]).abs() < 1e-12,
                "a velocity is one in time, whichever way the run goes"
            );
        }
    }
    // from 9.9 to 0.1: the node at 10 is where it turned round
    assert_eq!(back.len(), 99);
}

#[test]
fn an_observer_can_end_the_run() {
    let particle = CurvedParticle::default();
    let mut flow = Flow::new(&particle, 0.1, START_OF_PARTICLE).unwrap();
    let mut count = 0_u64;
    let mut observer = |node: &Node<2>| {
        count += 1;
        if node.q[0] < 0.0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    flow.stream(f64::INFINITY, &mut observer).unwrap();
    let polygon = Polygon::paper(0.1);
    let crossing = (1..100).find(|&k| polygon.node(k)[0] < 0.0).unwrap();
    assert_eq!(count, crossing + 1, "the node that ends the run is the last");
}

#[test]
fn a_time_on_the_wrong_side_is_an_error() {
    let particle = CurvedParticle::default();
    let mut flow = Flow::new(&particle, 0.1, START_OF_PARTICLE).unwrap();
    let error = flow.until(-1.0).unwrap_err();
    assert!(error.trajectory.is_empty());
    assert!(
        matches!(
            error.error,
            RunError::TimeBehind(ref behind)
                if **behind
                    == TimeBehind {
                        until: -1.0,
                        time: 0.0,
                        h: Some(0.1)
                    }
        ),
        "{error:?}"
    );
    assert!(error.to_string().contains("t = -1"), "{error}");
    assert!(matches!(
        flow.until(f64::NAN).unwrap_err().error,
        RunError::Until { .. }
    ));
    assert!(matches!(
        flow.until(f64::INFINITY).unwrap_err().error,
        RunError::Until { .. }
    ));
    assert_eq!(flow.until(1.0).unwrap().len(), 11, "the flow is as it was");
    assert!(matches!(
        flow.until(0.5).unwrap_err().error,
        RunError::TimeBehind { .. }
    ));
}

#[test]
fn observed_expressions_are_those_of_the_declaration() {
    let pendulum = InertiaWheelPendulum::default();
    let mut flow = Flow::new(&pendulum, 0.1, Start::paper(START.0, START.1)).unwrap();
    let names: Vec<_> = <InertiaWheelPendulum as System<2>>::OBSERVABLES
        .iter()
        .map(|observed| observed.name.clone())
        .collect();
    assert_eq!(names[..2], ["lyapunov", "dissipation"]);
    let node = flow.nth(7).unwrap().unwrap();
    let mut observed = vec![f64::NAN; names.len()];
    flow.observe(&node, &mut observed);
    assert_eq!(observed[0], pendulum.lyapunov(node.q, node.v));
    assert_eq!(observed[1], pendulum.dissipation(node.q, node.v));
}
