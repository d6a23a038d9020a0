//! The flow of systems written by hand: accuracy, order of events, and errors.

use crate::solve::newton::Stop;
use std::ops::ControlFlow;

use super::*;
use crate::solve::failure::StepFailure;
use crate::testing::{Cliff, Particle};

const ORIGIN: [f64; 2] = [0.0, 0.0];
const DIAGONAL: [f64; 2] = [1.0, 1.0];

fn distance(left: [f64; 2], right: [f64; 2]) -> f64 {
    (left[0] - right[0]).hypot(left[1] - right[1])
}

/// The largest distance from the exact discrete motion, at some hundred nodes.
fn distance_from_polygon(h: f64, steps: u64) -> f64 {
    let particle = Particle::default();
    let mut flow = Flow::new(&particle, h, Start::paper(ORIGIN, DIAGONAL)).unwrap();
    let d0 = flow.leg().d;
    let mut worst: f64 = 0.0;
    for k in 1..=steps {
        if k % (steps / 100) == 0 {
            worst = worst.max(distance(*flow.position(), particle.polygon(d0, k)));
        }
        flow.advance().unwrap();
    }
    worst
}

#[test]
fn the_particle_walks_its_polygon() {
    for (h, steps, tolerance) in [
        (0.1, 5000, 1e-11),
        (0.01, 50_000, 1e-12),
        (1e-3, 100_000, 1e-12),
        (1e-5, 1_000_000, 1e-13),
    ] {
        let worst = distance_from_polygon(h, steps);
        println!("h = {h:e}: {worst:e}");
        assert!(worst < tolerance, "h = {h:e}: {worst:e}");
    }
}

#[test]
#[ignore = "long: 5e7 steps, for measurements in release"]
fn the_particle_walks_its_polygon_for_long() {
    for (h, steps) in [
        (0.1, 5000),
        (0.01, 50_000),
        (1e-3, 500_000),
        (1e-4, 5_000_000),
        (1e-5, 50_000_000),
    ] {
        let clock = std::time::Instant::now();
        let worst = distance_from_polygon(h, steps);
        let time = clock.elapsed().as_nanos() as f64 / steps as f64;
        println!("h = {h:e}: {worst:.2e} from the polygon, {time:.1} ns per step");
        assert!(worst < 1e-11);
    }
}

#[test]
#[ignore = "a measurement, for release"]
fn the_time_of_a_step() {
    let particle = Particle::default();
    for h in [0.1, 0.01, 0.001] {
        let mut flow = Flow::new(&particle, h, Start::second_order(ORIGIN, DIAGONAL)).unwrap();
        let (mut evaluations, mut time, steps) = (0_u64, f64::INFINITY, 1_000_000_u32);
        for _ in 0..10 {
            evaluations = 0;
            let clock = std::time::Instant::now();
            for _ in 0..steps {
                evaluations += u64::from(flow.advance().unwrap().iterations);
            }
            time = time.min(clock.elapsed().as_nanos() as f64 / f64::from(steps));
        }
        println!(
            "h = {h}: {time:.1} ns per step, {} evaluations",
            evaluations as f64 / f64::from(steps)
        );
    }
}

#[test]
fn forward_and_back_returns() {
    let particle = Particle::default();
    for h in [0.1, -0.01] {
        let mut flow = Flow::new(&particle, h, Start::second_order(ORIGIN, DIAGONAL)).unwrap();
        let q1 = *flow.position();
        for _ in 0..100_000 {
            flow.advance().unwrap();
        }
        // the first step back
        flow.reverse().unwrap();
        for _ in 1..99_999 {
            flow.advance().unwrap();
        }
        // Each second difference is accurate to a unit of rounding ε of itself. So the length of the chords performs a random walk, ε κh √n
        // after n steps, and the phase is off by ε (κh)² n^1.5: 4e-11 and 4e-13 here.
        let tolerance = 1e-8 * h * h;
        println!("h = {h}: {:e}", distance(*flow.position(), q1));
        assert!(distance(*flow.position(), q1) < tolerance);
        flow.advance().unwrap();
        assert!(distance(*flow.position(), ORIGIN) < tolerance);
        assert!(flow.time().abs() < 1e-12 && flow.h() == -h);
    }
}

#[test]
fn one_evaluation_a_step_is_the_rule() {
    let particle = Particle::default();
    let mut flow = Flow::new(&particle, 0.01, Start::second_order(ORIGIN, DIAGONAL)).unwrap();
    let evaluations: u32 = (0..10_000).map(|_| flow.advance().unwrap().iterations).sum();
    assert!(evaluations < 10_100, "{evaluations}");
    let mut flow = Flow::new(&particle, 0.1, Start::second_order(ORIGIN, DIAGONAL)).unwrap();
    let evaluations: u32 = (0..10_000).map(|_| flow.advance().unwrap().iterations).sum();
    assert!(evaluations < 20_100, "{evaluations}");
}

#[test]
fn nodes_carry_velocity_force_and_energy() {
    let particle = Particle {
        mass: 3.0,
        curvature: 0.5,
    };
    let mut flow = Flow::new(&particle, 0.01, Start::second_order(ORIGIN, DIAGONAL).at(1.0)).unwrap();
    let nodes = flow.until(2.0).unwrap().nodes;
    assert_eq!(nodes.len(), 101);
    for (k, node) in nodes.iter().enumerate() {
        assert_eq!(node.index, k as u64);
        assert!((node.t - (1.0 + k as f64 * 0.01)).abs() < 1e-15);
        // Q = m κ |v|² to the left of the velocity; the first node has the continuous system's
        let speed = node.v[0].hypot(node.v[1]);
        let force = 3.0 * 0.5 * speed * speed;
        let expected = [-node.v[1] / speed * force, node.v[0] / speed * force];
        assert!(distance(node.force, expected) < 1e-9, "{node:?}");
        assert!((node.energy - 1.5 * speed * speed).abs() < 1e-12);
        let mut observed = [0.0];
        flow.observe(node, &mut observed);
        assert!((observed[0] - speed).abs() < 1e-14);
    }
    assert_eq!((nodes[0].stop, nodes[0].iterations), (Stop::Start, 0));
}

#[test]
fn until_counts_times_to_within_rounding() {
    let particle = Particle::default();
    for (h, t, count) in [
        (0.1, 500.0, 5001),
        (0.1, 0.3, 4),
        (0.01, 4.999, 500),
        (-0.1, -0.7, 8),
        (0.1, 0.0, 1),
    ] {
        let mut flow = Flow::new(&particle, h, Start::paper(ORIGIN, DIAGONAL)).unwrap();
        assert_eq!(flow.until(t).unwrap().len(), count, "{h} {t}");
    }
}

#[test]
fn a_run_goes_on_where_it_stopped_and_back() {
    let particle = Particle::default();
    let mut flow = Flow::new(&particle, 0.1, Start::paper(ORIGIN, DIAGONAL).at(-0.5)).unwrap();
    let first = flow.until(1.0).unwrap();
    assert!(flow.until(1.0).unwrap().is_empty());
    let second = flow.until(2.0).unwrap();
    assert_eq!((first.len(), second.len()), (16, 10));
    assert_eq!(second.nodes[0].index, 16);
    assert!(matches!(
        flow.until(1.5).unwrap_err().error,
        RunError::TimeBehind(behind) if behind.time == 2.0
    ));
    assert!(matches!(
        flow.until(f64::NAN).unwrap_err().error,
        RunError::Until { .. }
    ));
    assert!(matches!(
        flow.until(f64::INFINITY).unwrap_err().error,
        RunError::Until { .. }
    ));
    flow.reverse().unwrap();
    assert!(matches!(
        flow.until(3.0).unwrap_err().error,
        RunError::TimeBehind { .. }
    ));
    let back = flow.until(-0.5).unwrap();
    let forward: Vec<_> = first.iter().chain(&second).collect();
    // the node where the run was reversed is not handed out again
    assert_eq!(back.len() + 1, forward.len());
    for (node, other) in back.iter().zip(forward.into_iter().rev().skip(1)) {
        assert_eq!(node.t, other.t);
        assert!(distance(node.q, other.q) < 1e-14);
        // the first node carries the initial velocity, not the central difference
        assert!(other.index == 0 || distance(node.v, other.v) < 1e-12);
    }
}

#[test]
fn observers_see_every_node_and_may_end_the_run() {
    let particle = Particle::default();
    let mut flow = Flow::new(&particle, 0.1, Start::paper(ORIGIN, DIAGONAL)).unwrap();
    let mut count = 0;
    flow.stream(10.0, &mut |_: &Node<2>| count += 1).unwrap();
    assert_eq!(count, 101);
    let mut seen = 0;
    let mut observer = |node: &Node<2>| {
        seen += 1;
        if node.t > 11.95 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    flow.stream(f64::INFINITY, &mut observer).unwrap();
    assert_eq!(seen, 20);
    assert_eq!(flow.next().unwrap().unwrap().index, 121);
}

#[test]
fn a_failed_run_gives_what_it_has() {
    let mut flow = Flow::new(&Cliff, 0.5, Start::nodes([0.0], [0.25])).unwrap();
    let failure = flow.until(100.0).unwrap_err();
    let RunError::Step(error) = &failure.error else {
        panic!("{failure}")
    };
    let step = error.details();
    assert_eq!(step.cause.reason, StepFailure::NotFinite);
    assert!(step.q1[0] > 1.0 && step.q0[0] <= 1.0);
    assert_eq!(failure.trajectory.len() as u64, step.index);
    assert_eq!(step.coordinates, ["x"]);
    assert!(
        failure
            .to_string()
            .contains("`(1 - x).sqrt()` has no value there"),
        "{failure}"
    );
    let mut flow = Flow::new(&Cliff, 0.5, Start::nodes([0.0], [0.25])).unwrap();
    assert!((&mut flow).take(1000).last().unwrap().is_err());
    assert!(flow.next().is_none());
}

#[test]
fn rest_is_reported_where_curvature_is_undefined() {
    let particle = Particle::default();
    let error = Flow::new(&particle, 0.1, Start::second_order(ORIGIN, ORIGIN)).unwrap_err();
    assert!(matches!(error, SetupError::Acceleration { .. }));
    assert!(error.to_string().contains("at rest"), "{error}");
    let mut flow = Flow::new(&particle, 0.1, Start::paper(ORIGIN, ORIGIN)).unwrap();
    assert!(flow.next().unwrap().unwrap().a[0].is_nan());
    let error = flow.next().unwrap().unwrap_err();
    assert!(error.to_string().contains("at rest"), "{error}");
}

#[test]
fn bad_input_is_told_before_the_run() {
    let good = Start::paper(ORIGIN, DIAGONAL);
    let particle = Particle::default();
    let error = |h, start| Flow::new(&particle, h, start).unwrap_err();
    for h in [0.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(error(h, good), SetupError::Step { .. }));
    }
    assert!(matches!(error(1e-170, good), SetupError::StepRange { .. }));
    assert!(matches!(
        error(0.1, good.at(f64::NAN)),
        SetupError::StartTime { .. }
    ));
    let start = Start::nodes(ORIGIN, [0.0, f64::NAN]);
    assert!(matches!(
           error(0.1, start),
           SetupError::Start {
               vector: "q1",
               coordinate,
    ..
    } if coordinate == "y"
       ));
    let start = Start::paper([f64::INFINITY, 0.0], DIAGONAL);
    assert!(matches!(
           error(0.1, start),
           SetupError::Start {
               vector: "q0",
               coordinate,
    ..
    } if coordinate == "x"
       ));
    let start = Start::second_order(ORIGIN, [0.0, f64::NAN]);
    assert!(matches!(
           error(0.1, start),
           SetupError::Start {
               vector: "v0",
               coordinate,
    ..
    } if coordinate == "y"
       ));
    let particle = Particle {
        mass: 1.0,
        curvature: f64::NAN,
    };
    let error = Flow::new(&particle, 0.1, good).unwrap_err();
    assert!(matches!(
           error,
           SetupError::Parameter {
               name,
    ..
    } if name == "curvature"
       ));
}

#[test]
fn a_start_by_nodes_keeps_their_difference() {
    let particle = Particle::default();
    let flow = Flow::new(
        &particle,
        0.1,
        Start::nodes([1e8, 1e8], [1e8 + 0.125, 1e8 - 0.25]),
    )
    .unwrap();
    assert_eq!(flow.leg().d, [0.125, -0.25]);
}
