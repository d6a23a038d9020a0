//! Every event of a Taylor flow is found at its time, and the flow stops exactly there.

#![allow(clippy::float_cmp)] // the flow stands exactly where the event was

use dsocs_core::taylor::{Jet, TaylorFlow, Tolerance};
use dsocs_core::{Dual, Event, Events, Node, Occurrence, Real, RunError, Start, Stepper, dsocs, on_event};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum};

const Q0: [f64; 2] = [0.0, 0.0];
const V0: [f64; 2] = [1.0, 1.0];
const START: Start<2> = Start::second_order(Q0, V0);

fn particle() -> CurvedParticle<dsocs_systems::Constant> {
    CurvedParticle::default()
}

#[test]
fn the_particle_crosses_an_axis_where_its_circle_does() {
    let particle = particle();
    let mut flow = TaylorFlow::new(&particle, START, Tolerance::relative(1e-14)).unwrap();
    let mut events = Events::new(vec![Event::function(|point| point.q[0] - 0.1)]);
    let mut found = Vec::new();
    flow.watch(
        20.0,
        &mut events,
        &mut on_event(|event: &Occurrence<_>| found.push(*event)),
    )
    .unwrap();
    // x = cos(√2 t - π/4) - √2/2 = 0.1
    let angle = (0.1 + 0.5_f64.sqrt()).acos();
    let turn = 2.0 * std::f64::consts::PI;
    let mut expected: Vec<f64> = (-1..10)
        .flat_map(|k| [-angle, angle].map(|angle| angle + f64::from(k) * turn))
        .map(|phase| (phase + std::f64::consts::FRAC_PI_4) / 2.0_f64.sqrt())
        .filter(|t| *t > 0.0 && *t < 20.0)
        .collect();
    expected.sort_by(f64::total_cmp);
    assert_eq!(found.len(), expected.len());
    for (event, t) in found.iter().zip(&expected) {
        assert!((event.t - t).abs() < 1e-13 * 20.0, "{} {t}", event.t);
        assert!((event.q[0] - 0.1).abs() < 1e-15, "{event:?}");
        assert_eq!(event.rising, event.v[0] > 0.0);
        let (q, v) = particle.exact(Q0, V0, *t);
        for i in 0..2 {
            assert!((event.q[i] - q[i]).abs() < 1e-12 && (event.v[i] - v[i]).abs() < 1e-12);
        }
    }
}

/// A plain number may be on either side of an operator.
#[test]
fn numbers_stand_on_either_side() {
    let particle = particle();
    let count = |event: Event<'static, 2>| {
        let mut flow = TaylorFlow::new(&particle, START, Tolerance::relative(1e-10)).unwrap();
        let mut found = Vec::new();
        let mut events = Events::new(vec![event]);
        let mut keep = on_event(|event: &Occurrence<2>| found.push(event.t));
        flow.watch(20.0, &mut events, &mut keep).unwrap();
        found
    };
    let pairs: [(Event<'static, 2>, Event<'static, 2>); 5] = [
        (
            Event::function(|p| -0.3 + p.q[1]),
            Event::function(|p| p.q[1] - 0.3),
        ),
        (
            Event::function(|p| 0.3 - p.q[1]),
            Event::function(|p| p.q[1] - 0.3),
        ),
        (
            Event::function(|p| 2.0 * p.q[1] - 0.6),
            Event::function(|p| p.q[1] * 2.0 - 0.6),
        ),
        (
            Event::function(|p| 3.0 / (2.0 + p.v[0]) - 1.2),
            Event::function(|p| Jet::from(3.0) / (p.v[0] + 2.0) - 1.2),
        ),
        (
            Event::function(|p| 7.0 % (3.0 + p.v[0]) - 0.9),
            Event::function(|p| Jet::from(7.0) % (p.v[0] + 3.0) - 0.9),
        ),
    ];
    for (place, (left, right)) in pairs.into_iter().enumerate() {
        let [left, right] = [count(left), count(right)];
        assert!(!left.is_empty() && left == right, "{place}: {left:?}, {right:?}");
    }
    let x = Dual::new(0.5, 1.0);
    assert_eq!((2.0 - 3.0 / x).eps, 12.0);
}

#[test]
fn directions_count_only_their_own() {
    let particle = particle();
    let count = |event: Event<'static, 2>| {
        let mut flow = TaylorFlow::new(&particle, START, Tolerance::relative(1e-10)).unwrap();
        let mut found = 0;
        flow.watch(
            100.0,
            &mut Events::new(vec![event]),
            &mut on_event(|_: &Occurrence<2>| found += 1),
        )
        .unwrap();
        found
    };
    let event = || Event::function(|point| point.q[1] - 0.3);
    let (both, rising, falling) = (count(event()), count(event().rising()), count(event().falling()));
    assert_eq!(both, rising + falling);
    // y = sin(√2 t - π/4) + √2/2 rises first, and √2 · 100 is 22.5 turns
    assert_eq!((rising, falling), (23, 22));
}

#[test]
fn many_changes_of_sign_within_one_step_are_all_found() {
    // a step of order 30 is a good part of a turn, within which sin(40 x) changes its sign some twenty times
    let particle = particle();
    let mut flow = TaylorFlow::new(&particle, START, Tolerance::relative(1e-10).order(30)).unwrap();
    let mut events = Events::new(vec![Event::function(|point| Real::sin(point.q[0] * 40.0 + 1.0))]);
    let mut found = Vec::new();
    let turn = 2.0 * std::f64::consts::PI / 2.0_f64.sqrt();
    flow.watch(
        turn,
        &mut events,
        &mut on_event(|event: &Occurrence<_>| found.push(*event)),
    )
    .unwrap();
    let steps = flow.steps();
    // each multiple of π between the ends of 40 x + 1 is passed twice a turn
    let ends = [-1.0, 1.0].map(|x: f64| (40.0 * (x - 0.5_f64.sqrt()) + 1.0) / std::f64::consts::PI);
    let expected = 2.0 * (ends[1].floor() - ends[0].ceil() + 1.0);
    println!("{} in {steps} steps", found.len());
    assert_eq!(found.len() as f64, expected);
    assert!(steps < 6);
    for pair in found.windows(2) {
        assert!(pair[0].t < pair[1].t);
    }
    for event in found {
        assert!((40.0 * event.q[0] + 1.0).sin().abs() < 1e-12);
    }
}

#[test]
fn the_run_ends_at_a_terminal_event_and_goes_on_from_there() {
    let particle = particle();
    let mut flow = TaylorFlow::new(&particle, START, Tolerance::relative(1e-13)).unwrap();
    let mut events = Events::new(vec![Event::function(|point| point.v[0]).terminal()]);
    let mut times = Vec::new();
    while let Some(event) = flow.watch(50.0, &mut events, &mut |_: &Node<2>| {}).unwrap() {
        assert_eq!(flow.time(), event.t);
        assert!(flow.velocity()[0].abs() < 1e-15);
        // the node at the event is still to be handed out
        assert_eq!((flow.node().t, flow.node().v), (event.t, event.v));
        times.push(event.t);
    }
    assert_eq!(flow.time(), 50.0);
    // the velocity's angle is π/4 + √2 t
    for (k, t) in times.iter().enumerate() {
        let exact = (std::f64::consts::FRAC_PI_4 + k as f64 * std::f64::consts::PI) / 2.0_f64.sqrt();
        assert!((t - exact).abs() < 1e-11, "{t} {exact}");
    }
    assert_eq!(times.len(), 23);
}

#[test]
fn the_pendulums_switch_is_an_observable() {
    // as many as there are sign changes of w on a grid of a millisecond
    let pendulum = InertiaWheelPendulum::default();
    let start = Start::second_order([0.5, 0.0], [0.0, 0.5]);
    let mut flow = TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-12)).unwrap();
    let w = 2; // lyapunov, dissipation, w
    let mut events = Events::new(vec![Event::observable(w)]);
    let mut found = Vec::new();
    flow.watch(
        2000.0,
        &mut events,
        &mut on_event(|event: &Occurrence<_>| found.push(*event)),
    )
    .unwrap();
    let mut flow = TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-12)).unwrap();
    let times: Vec<f64> = (0..=2_000_000).map(|k| f64::from(k) * 1e-3).collect();
    let mut signs = 0;
    let mut last = 0.0;
    flow.sample(&times, &mut |_, point| {
        let sign = pendulum.factor(point.q, point.v).signum();
        if sign * last < 0.0 {
            signs += 1;
        }
        last = sign;
    })
    .unwrap();
    println!("{} events, {signs} changes between milliseconds", found.len());
    assert_eq!(found.len(), signs);
    for event in &found {
        // |w| is 325 at first and its rate some hundreds: 1e-13 of the time is this of w
        let w = pendulum.factor(event.q, event.v);
        assert!(w.abs() < 1e-10, "{w:e} at {}", event.t);
    }
    for pair in found.windows(2) {
        assert_ne!(pair[0].rising, pair[1].rising);
    }
}

#[test]
fn back_in_time_the_events_are_the_same() {
    let particle = particle();
    let run = |from: f64, to: f64| {
        let (q, v) = particle.exact(Q0, V0, from);
        let mut flow = TaylorFlow::new(
            &particle,
            Start::second_order(q, v).at(from),
            Tolerance::relative(1e-14),
        )
        .unwrap();
        if to < from {
            flow.reverse().unwrap();
        }
        let mut events = Events::new(vec![Event::function(|point| point.q[1] - 1.0)]);
        let mut found = Vec::new();
        flow.watch(
            to,
            &mut events,
            &mut on_event(|event: &Occurrence<_>| found.push(*event)),
        )
        .unwrap();
        found
    };
    let (forward, mut back) = (run(0.0, 10.0), run(10.0, 0.0));
    back.reverse();
    assert_eq!(forward.len(), back.len());
    assert!(forward.len() > 3);
    for (there, here) in forward.iter().zip(&back) {
        assert!((there.t - here.t).abs() < 1e-12);
        assert_eq!(there.rising, !here.rising);
    }
}

/// A potential behind a function.
fn well<R: Real>(x: R) -> R {
    x * x * 0.5
}

/// A mass in a well, which is observed through a function of the user's.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - stiffness * x.powi(2) / 2;
    let height = well(x) - 0.1;
    observe = [height];
}]
struct Spring {
    stiffness: f64,
}

/// An event of an observed expression that calls a user's function ends the run with an error of this event;
/// as a function of jets the event is found.
#[test]
fn what_an_event_cannot_see_is_told() {
    let spring = Spring { stiffness: 1.0 };
    let mut flow = TaylorFlow::new(
        &spring,
        Start::second_order([1.0], [0.0]),
        Tolerance::relative(1e-10),
    )
    .unwrap();
    let mut events = Events::new(vec![Event::observable(0)]);
    let error = flow.watch(1.0, &mut events, &mut |_: &Node<1>| {}).unwrap_err();
    assert!(
        matches!(&error, RunError::Event(failed) if failed.event == 0 && failed.time == 0.0),
        "{error}"
    );
    // as a function of jets it is found
    let mut flow = TaylorFlow::new(
        &spring,
        Start::second_order([1.0], [0.0]),
        Tolerance::relative(1e-14),
    )
    .unwrap();
    let height = |x: Jet| well(x) - 0.1;
    let mut events = Events::new(vec![Event::function(|point| height(point.q[0])).terminal()]);
    let event = flow
        .watch(3.0, &mut events, &mut |_: &Node<1>| {})
        .unwrap()
        .unwrap();
    assert!((event.t - 0.2_f64.sqrt().acos()).abs() < 1e-13);
}
