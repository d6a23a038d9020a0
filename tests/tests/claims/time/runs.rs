//! Time outside the declaration: starts, events, ensembles, runs back, compositions, forces and residuals.

use std::num::NonZeroU64;

use dsocs_core::taylor::Tolerance;
use dsocs_core::{
    Composition, Ensemble, Event, Events, Leg, Occurrence, Real, SetupError, Start, Stepper, Trajectory,
    on_event,
};
use dsocs_tests::declared;
use dsocs_tests::fit::slope;
use dsocs_tests::text::{ComposedFlow, Flow, System, TaylorFlow};

use super::{BEAD, Driven, DrivenMidpoint, ON_THE_WIRE, SLALOM, Steered, along_the_wire};
use dsocs_tests::dop853;
use dsocs_tests::motion::{assert_position, discrete, distance};

#[test]
fn a_start_moves_with_what_it_is_bound_to() {
    let (q, v) = ON_THE_WIRE;
    // a velocity along a wire that turns, without its rotation
    let Err(error) = Flow::new(&BEAD, 0.01, Start::second_order(q, [0.2, 0.0])) else {
        panic!("accepted");
    };
    let SetupError::Inconsistent { violations } = &error else {
        panic!("{error:?}");
    };
    let [violation] = violations.as_slice() else {
        panic!("{error}");
    };
    assert_eq!(
        (violation.constraint, violation.index, violation.at),
        ("time derivative of holonomic constraint", 0, "(q0, v0)")
    );
    // g_q v is zero, and g_t is −ω r
    assert!((violation.value + 0.35).abs() < 1e-15, "{error}");
    // by as little as possible: across the wire
    let mended = Start::second_order(q, [0.2, 0.0]).projected();
    let node = Flow::new(&BEAD, 0.01, mended).unwrap().next().unwrap().unwrap();
    assert!(distance(&node.v, &v) < 1e-15, "{node:?}");
    assert!(TaylorFlow::new(&BEAD, mended, Tolerance::relative(1e-9)).is_ok());
    // the wire has another direction at another time
    let Err(error) = Flow::new(&BEAD, 0.01, Start::second_order(q, v).at(1.0)) else {
        panic!("accepted");
    };
    assert!(
        error.to_string().contains("holonomic constraint 1 at q0"),
        "{error}"
    );
    // turned with the wire and with a shifted clock it is the same motion but for the direction of gravity
    let t0 = 1.0;
    let [r, rate] = along_the_wire(t0);
    let (sin, cos) = f64::sin_cos(0.7 * t0);
    let (q, v) = (
        [r * cos, r * sin],
        [rate * cos - 0.7 * r * sin, rate * sin + 0.7 * r * cos],
    );
    let start = Start::second_order(q, v).at(t0);
    let known = [14.336_340_164_937_3, -24.512_941_668_921_09];
    assert_position("bead from t = 1", &BEAD, start, 3.0, &known, 1e-12);
    // an exact start contains its time
    let start = start.exact(&BEAD, 0.01).unwrap();
    assert!(distance(&discrete(&BEAD, 0.01, start, 3.0).q, &known) < 1e-2);
    assert!(matches!(
        Flow::new(&BEAD, 0.01, start.at(0.0)),
        Err(SetupError::StartMoved { .. })
    ));
}

#[test]
fn events_may_ask_for_the_time() {
    let start = Start::second_order([1.0], [0.3]).at(0.25);
    // at a time, and where the drive changes its sign; with the step between nodes, with the series anywhere
    let zeros: Vec<f64> = (0..6)
        .map(|k| (f64::from(k) + 0.5) * std::f64::consts::PI / 1.7)
        .collect();
    let watch = |flow: &mut dyn Stepper<1>| {
        let events = vec![
            Event::function(|point| point.t - 2.345),
            Event::function(|point| Real::cos(point.t * 1.7)),
            Event::observable(0),
        ];
        let mut found = [Vec::new(), Vec::new(), Vec::new()];
        flow.watch(
            10.0,
            &mut Events::new(events),
            &mut on_event(|event: &Occurrence<1>| found[event.event].push(event.t)),
        )
        .unwrap();
        found
    };
    let mut step = Flow::new(&Driven, 0.1, start).unwrap();
    let mut series = TaylorFlow::new(&Driven, start, Tolerance::relative(1e-12)).unwrap();
    for [at, drive, observed] in [watch(&mut step), watch(&mut series)] {
        assert_eq!(at.len(), 1);
        assert!((at[0] - 2.345).abs() < 1e-14, "{at:?}");
        for found in [drive, observed] {
            let until = zeros.iter().filter(|zero| **zero < 10.0).count();
            assert_eq!(found.len(), until, "{found:?}");
            for (found, zero) in found.iter().zip(&zeros) {
                assert!((found - zero).abs() < 1e-13, "{found} {zero}");
            }
        }
    }
}

#[test]
fn lanes_may_begin_at_different_times() {
    let starts: Vec<_> = (0..19)
        .map(|k| {
            let k = f64::from(k);
            Start::second_order([1.0 - 0.05 * k], [0.1 * k]).at(0.37 * k)
        })
        .collect();
    let ensemble = Ensemble::new(&Driven, 0.05)
        .unwrap()
        .starts(starts.iter().copied());
    let runs = ensemble.stream(12.0, NonZeroU64::MIN, |_| Trajectory::default());
    for (start, run) in starts.iter().zip(&runs) {
        let alone = Flow::new(&Driven, 0.05, *start).unwrap().until(12.0).unwrap();
        assert_eq!(alone.len(), run.observer.len());
        for (node, other) in alone.iter().zip(&run.observer) {
            assert_eq!((node.t, node.index), (other.t, other.index));
            assert!((node.q[0] - other.q[0]).abs() < 1e-13 && (node.energy - other.energy).abs() < 1e-12);
        }
    }
    // with constraints that depend on time, too
    let starts: Vec<_> = (0..11)
        .map(|k| {
            let t = 0.2 * f64::from(k);
            let ([r, rate], (sin, cos)) = (along_the_wire(t), f64::sin_cos(0.7 * t));
            let v = [rate * cos - 0.7 * r * sin, rate * sin + 0.7 * r * cos];
            Start::second_order([r * cos, r * sin], v).at(t)
        })
        .collect();
    let finals = Ensemble::new(&BEAD, 0.01)
        .unwrap()
        .starts(starts.iter().copied())
        .to(3.0);
    for (start, last) in starts.iter().zip(finals) {
        let alone = Flow::new(&BEAD, 0.01, *start).unwrap().to(3.0).unwrap();
        assert!(distance(&alone.q, &last.unwrap().q) < 1e-12);
    }
}

/// Runs to a time and back; returns the distance from the start.
fn there_and_back<S: System<N>, const N: usize>(mut flow: impl Stepper<N>, system: &S, until: f64) -> f64 {
    let _ = system;
    let first = flow.node();
    flow.to(until).unwrap();
    flow.reverse().unwrap();
    let back = flow.to(first.t).unwrap();
    assert!((back.t - first.t).abs() < 1e-12);
    distance(&back.q, &first.q)
}

#[test]
fn a_run_that_is_turned_round_meets_its_past() {
    let start = Start::second_order([1.0], [0.3]).at(0.4);
    let tolerance = Tolerance::relative(1e-15);
    let bead = Start::second_order(ON_THE_WIRE.0, ON_THE_WIRE.1);
    for (name, apart, bar) in [
        (
            "default",
            there_and_back(Flow::new(&Driven, 0.1, start).unwrap(), &Driven, 10.4),
            1e-13,
        ),
        (
            "midpoint",
            there_and_back(
                Flow::new(&DrivenMidpoint, 0.1, start).unwrap(),
                &DrivenMidpoint,
                10.4,
            ),
            1e-13,
        ),
        (
            "series",
            there_and_back(TaylorFlow::new(&Driven, start, tolerance).unwrap(), &Driven, 10.4),
            1e-13,
        ),
        (
            "composition",
            there_and_back(
                ComposedFlow::new(&Driven, 0.1, Composition::KAHAN_LI_8, start).unwrap(),
                &Driven,
                10.4,
            ),
            1e-13,
        ),
        (
            "bead",
            there_and_back(Flow::new(&BEAD, 0.01, bead).unwrap(), &BEAD, 3.0),
            1e-10,
        ),
    ] {
        println!("{name}: {apart:.1e}");
        assert!(apart < bar, "{name}: {apart:e}");
    }
}

declared! {
    /// A pendulum pushed in time.
    struct Pushed;
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + theta.cos() + 0.5 * (1.3 * t).cos() * theta;
}

declared! {
    /// The pendulum pushed by an external force.
    struct PushedByForce;
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + theta.cos();
    external_forces = (0.5 * (1.3 * t).cos(),);
}

/// Positions at the times `t0 + 1`, `t0 + 2`, … by the method of Dormand and Prince.
fn whole_seconds<const M: usize>(
    rate: impl Fn(f64, [f64; M]) -> [f64; M],
    t0: f64,
    mut state: [f64; M],
    count: u32,
) -> Vec<[f64; M]> {
    (0..count)
        .map(|k| {
            let from = t0 + f64::from(k);
            state = dop853::integrate_from(&rate, (from, state), from + 1.0, 1e-15);
            state
        })
        .collect()
}

/// Fits the orders of compositions against positions at whole seconds.
fn orders_of_compositions<S: System<N>, const N: usize, const M: usize>(
    system: &S,
    start: Start<N>,
    truth: &[[f64; M]],
) {
    let methods = [
        (Composition::SINGLE, [16, 24, 32, 48, 64]),
        (Composition::SUZUKI_4, [12, 16, 24, 32, 48]),
        (Composition::KAHAN_LI_6, [6, 8, 10, 12, 16]),
        (Composition::KAHAN_LI_8, [3, 4, 5, 6, 8]),
    ];
    for (method, parts) in methods {
        let errors = parts.map(|parts| {
            let h = f64::from(parts).recip();
            let mut flow = ComposedFlow::new(system, h, method, start).unwrap();
            let mut largest = 0.0_f64;
            for truth in truth {
                for _ in 0..parts {
                    flow.advance().unwrap();
                }
                for (x, truth) in flow.position().iter().zip(truth) {
                    largest = largest.max((x - truth).abs());
                }
            }
            largest
        });
        let steps = parts.map(|parts| f64::from(parts).recip());
        let kept: Vec<_> = (0..5).filter(|&k| errors[k] > 2e-12).collect();
        assert!(kept.len() >= 3, "{method}: {errors:?}");
        let (steps, above): (Vec<f64>, Vec<f64>) = kept.iter().map(|&k| (steps[k], errors[k])).unzip();
        let found = slope(&steps, &above);
        println!("{method}: {found:.3}, {errors:?}");
        let order = f64::from(method.order());
        assert!((found - order).abs() < 0.05 * order, "{method}: {found}");
    }
}

#[test]
fn orders_of_compositions_of_driven_systems() {
    let start = Start::second_order([1.2], [0.3]).at(0.4);
    let rate = |t: f64, [theta, v]: [f64; 2]| [v, -theta.sin() + 0.5 * (1.3 * t).cos()];
    let truth = whole_seconds(rate, 0.4, [1.2, 0.3], 12);
    orders_of_compositions(&Pushed, start, &truth);
    orders_of_compositions(&PushedByForce, start, &truth);
    let rate = |t: f64, [_, _, u, v]: [f64; 4]| {
        let turn = u.hypot(v) * SLALOM.at(t);
        [u, v, -turn * v, turn * u]
    };
    let truth = whole_seconds(rate, 0.4, [0.0, 0.0, 1.0, 1.0], 8);
    let steered = Steered { curvature: SLALOM };
    orders_of_compositions(&steered, Start::second_order([0.0; 2], [1.0; 2]).at(0.4), &truth);
}

/// Methods with a time as an argument agree with the runs.
#[test]
fn residuals_and_forces_are_told_at_a_time() {
    let h = 0.01;
    let nodes = Flow::new(&BEAD, h, Start::second_order(ON_THE_WIRE.0, ON_THE_WIRE.1))
        .unwrap()
        .until(1.0)
        .unwrap()
        .nodes;
    let triple = [nodes[49].q, nodes[50].q, nodes[51].q];
    let at = |t: f64| dsocs_core::System::residual(&BEAD, t, h, &triple);
    assert!(at(0.5).iter().all(|row| row.abs() < 1e-10), "{:?}", at(0.5));
    assert!(at(0.6).iter().any(|row| row.abs() > 1e-2), "{:?}", at(0.6));
    let force = dsocs_core::System::force(&BEAD, 0.5, h, &triple);
    assert!(distance(&force, &nodes[50].force) < 1e-8, "{force:?}");
    // so do legs of the geometry
    let leg = |t: f64| Leg {
        t,
        q: [1.0],
        d: [0.1],
    };
    let momentum = |t: f64| dsocs_core::geometry::legendre_minus(&Driven, 0.1, leg(t).any())[0];
    let drive = |t: f64| 0.6 * (1.7 * t).cos();
    assert!((momentum(2.1) - momentum(1.1) + drive(2.0) - drive(1.0)).abs() < 1e-14);
}
