//! Runs of every method have one interface: the same functions return the same results and find the same
//! events.

#![allow(clippy::float_cmp)] // the same numbers, to the last bit

use std::error::Error;
use std::ops::ControlFlow;

use dsocs_core::prelude::*;
use dsocs_core::taylor::GlobalError;
use dsocs_core::text::Text;
use dsocs_core::{Estimates, Failure, NewtonFailure, Point, Real, SeriesFailure, SetupError, StepError};
use dsocs_tests::scenes::random::Random;
use dsocs_tests::{fit, short_or_long};

/// A pendulum: a nonlinear equation, and a step that can be composed.
#[dsocs {
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + strength * theta.cos();
    let above = 0.9 - theta.cos();
    observe = [above];
}]
struct Pendulum {
    strength: f64,
}

/// A mass on a slope that ends at `x = 1`.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - (1 - x).powf(1.5);
}]
struct Cliff {}

const PENDULUM: Pendulum = Pendulum { strength: 1.0 };
const T0: f64 = 2.5;
const START: Start<1> = Start::second_order([1.0], [0.0]).at(T0);
const H: f64 = 0.125;

/// Tolerances: of a position against the continuous motion, and of a run back against its start.
#[derive(Clone, Copy)]
struct Allowed {
    motion: f64,
    back: f64,
}

/// The reference, far more accurate than any of the runs.
fn reference() -> TaylorFlow<'static, 1> {
    TaylorFlow::new(&PENDULUM, START, Tolerance::relative(1e-16).order(18)).unwrap()
}

/// The position and the velocity of the reference at some times.
fn truth(times: &[f64]) -> Vec<Point<f64, 1>> {
    let mut points = Vec::new();
    reference()
        .sample(times, &mut |_, point| points.push(*point))
        .unwrap();
    points
}

/// Every method's run of the pendulum: by type and as an object.
macro_rules! for_every_method {
    ($check:ident) => {
        macro_rules! method {
            ($name:literal, $motion:literal, $back:literal, $run:expr) => {
                let allowed = Allowed {
                    motion: $motion,
                    back: $back,
                };
                let mut runs = [$run, $run, $run, $run];
                println!("{}", $name);
                $check(runs.each_mut(), allowed);
                let mut runs = [$run, $run, $run, $run];
                $check(
                    runs.each_mut().map(|run| run as &mut dyn Stepper<1>),
                    allowed,
                );
            };
        }
        let composed = |method| ComposedFlow::new(&PENDULUM, H, method, START).unwrap();
        let series = |tolerance| TaylorFlow::new(&PENDULUM, START, Tolerance::relative(tolerance)).unwrap();
        method!("step", 5e-3, 1e-13, Flow::new(&PENDULUM, H, START).unwrap());
        method!("order 4", 1e-5, 1e-13, composed(Composition::SUZUKI_4));
        method!("order 6", 1e-7, 1e-13, composed(Composition::KAHAN_LI_6));
        method!("order 8", 1e-7, 1e-13, composed(Composition::KAHAN_LI_8));
        method!("series", 1e-11, 1e-11, series(1e-12));
        method!("series on a grid", 1e-11, 1e-11, series(1e-12).every(H).unwrap());
    };
}

/// Whether the nodes of a run are a constant step apart.
fn is_even<R: Stepper<1> + ?Sized>(run: &R) -> bool {
    run.clock().step().is_some()
}

#[test]
fn collection_stream_iterator_and_steps_are_one() {
    fn check<R: Stepper<1> + ?Sized>([collecting, streaming, iterating, stepping]: [&mut R; 4], _: Allowed) {
        let end = T0 + 10.0;
        let collected = collecting.until(end).unwrap();
        let first = &collected.nodes[0];
        assert_eq!((first.index, first.t, first.q, first.v), (0, T0, [1.0], [0.0]));
        assert_eq!(collected.last().unwrap().t, end);
        for (k, node) in collected.iter().enumerate() {
            assert_eq!(node.index, k as u64);
        }
        if is_even(collecting) {
            assert_eq!(collected.len(), 81);
        }
        assert_eq!(collecting.node(), *collected.last().unwrap());

        let mut streamed = Vec::new();
        streaming
            .stream(end, &mut |node: &Node<1>| streamed.push(*node))
            .unwrap();
        assert_eq!(streamed, collected.nodes);

        // without an end, the last step of a method with variable steps is not shortened
        let same = collected.len() - usize::from(!is_even(collecting));
        let iterated: Vec<Node<1>> = iterating.take(same).map(Result::unwrap).collect();
        assert_eq!(iterated, collected.nodes[..same]);

        assert_eq!(stepping.node(), collected.nodes[0]);
        for node in &collected.nodes[1..same] {
            stepping.advance().unwrap();
            assert_eq!(stepping.node(), *node);
        }
        assert_eq!(stepping.to(end).unwrap(), *collected.last().unwrap());

        // an observer may end the run, which can be continued
        let mut count = 0;
        collecting
            .stream(f64::INFINITY, &mut |node: &Node<1>| {
                count += 1;
                if node.t > end + 1.0 {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
            .unwrap();
        assert_eq!(collecting.node().index, (collected.len() - 1 + count) as u64);
        let next = collecting.next().unwrap().unwrap();
        assert_eq!(next.index, (collected.len() + count) as u64);

        let mut above = [0.0];
        collecting.observe(&next, &mut above);
        assert_eq!(above[0], 0.9 - next.q[0].cos());
        let coordinates = &collecting.run().kernel().shape().coordinates;
        assert_eq!((coordinates.len(), &*coordinates[0].name), (1, "theta"));
    }
    for_every_method!(check);
}

#[test]
fn a_run_that_turns_round_comes_back() {
    fn check<R: Stepper<1> + ?Sized>([run, other, ..]: [&mut R; 4], allowed: Allowed) {
        let there = run.until(T0 + 5.0).unwrap();
        run.reverse().unwrap();
        assert_eq!((run.node().index, run.node().t), (0, T0 + 5.0));
        assert!(matches!(run.to(T0 + 6.0), Err(RunError::TimeBehind(_))));
        let back = run.until(T0).unwrap();
        // the node of the reversal is not handed out again
        assert_eq!(back.nodes[0].index, 1);
        assert!(back.nodes[0].t < T0 + 5.0);
        let last = back.last().unwrap();
        assert_eq!(last.t, T0);
        assert!((last.q[0] - 1.0).abs() < allowed.back, "{last:?}");
        if is_even(run) {
            assert_eq!(back.len() + 1, there.len());
            for (back, there) in back.iter().zip(there.iter().rev().skip(1)) {
                assert_eq!(back.t, there.t);
                assert!((back.q[0] - there.q[0]).abs() < allowed.back);
                assert!(there.index == 0 || (back.v[0] - there.v[0]).abs() < 10.0 * allowed.back);
            }
        }
        run.reverse().unwrap();
        let again = run.to(T0 + 5.0).unwrap();
        let node = there.last().unwrap();
        assert_eq!(again.t, node.t);
        assert!((again.q[0] - node.q[0]).abs() < allowed.back);
        // also at the start, before any step
        other.reverse().unwrap();
        let mirrored = other.to(T0 - 1.0).unwrap();
        let exact = truth(&[T0 + 1.0])[0].q[0];
        assert!(
            (mirrored.q[0] - exact).abs() < allowed.motion,
            "{mirrored:?} {exact}"
        );
    }
    for_every_method!(check);
}

/// The events that the tests look for, as functions of the motion.
fn events<'e>() -> Events<'e, 1> {
    Events::new(vec![
        Event::function(|point| point.q[0] - 0.3),
        Event::function(|point| point.v[0] - 0.2).rising(),
        Event::observable(0),
        Event::function(|point| Real::sin(point.q[0] * 8.0)).falling(),
    ])
}

/// All events up to a time.
fn happened<R: Stepper<1> + ?Sized>(run: &mut R, end: f64, events: &mut Events<'_, 1>) -> Vec<Occurrence<1>> {
    let mut found = Vec::new();
    let ended = run
        .watch(
            end,
            events,
            &mut on_event(|event: &Occurrence<1>| found.push(*event)),
        )
        .unwrap();
    assert_eq!(ended, None);
    found
}

/// Checks that nodes and events come in the order of time.
struct InOrder(f64);
impl Observer<1> for InOrder {
    fn node(&mut self, node: &Node<1>) -> ControlFlow<()> {
        assert!(node.t >= self.0);
        self.0 = node.t;
        ControlFlow::Continue(())
    }
    fn event(&mut self, event: &Occurrence<1>) -> ControlFlow<()> {
        assert!(event.t >= self.0);
        self.0 = event.t;
        ControlFlow::Continue(())
    }
}

#[test]
fn every_method_finds_the_same_events() {
    fn check<R: Stepper<1> + ?Sized>([run, other, third, _]: [&mut R; 4], allowed: Allowed) {
        let end = T0 + 20.0;
        let exact = happened(&mut reference(), end, &mut events());
        let found = happened(run, end, &mut events());
        assert_eq!(found.len(), exact.len());
        assert!(found.len() > 30);
        for (event, exact) in found.iter().zip(&exact) {
            assert_eq!((event.event, event.rising), (exact.event, exact.rising));
            // motions separate in time, and some events cross their zero slowly
            assert!(
                (event.t - exact.t).abs() < 10.0 * allowed.motion,
                "{event:?} {exact:?}"
            );
            // where the event is, its function vanishes
            let [q, v] = [event.q[0], event.v[0]];
            let value = match event.event {
                0 => q - 0.3,
                1 => v - 0.2,
                2 => 0.9 - q.cos(),
                _ => (8.0 * q).sin(),
            };
            assert!(value.abs() < 1e-12, "{event:?}");
        }

        // nodes and events come in the order of time
        let (mut trajectory, mut times) = (Trajectory::default(), Vec::new());
        let times_of_events = on_event(|event: &Occurrence<1>| times.push(event.t));
        let mut both = (trajectory.clone(), times_of_events);
        other.watch(end, &mut events(), &mut both).unwrap();
        (trajectory, _) = both;
        assert_eq!(trajectory, third.until(end).unwrap());
        assert_eq!(times.len(), found.len());

        third.watch(end + 10.0, &mut events(), &mut InOrder(end)).unwrap();
    }
    for_every_method!(check);
}

#[test]
fn a_terminal_event_ends_the_run_and_nothing_is_lost_when_it_goes_on() {
    fn check<R: Stepper<1> + ?Sized>([run, other, third, _]: [&mut R; 4], _: Allowed) {
        let end = T0 + 20.0;
        let all = happened(run, end, &mut events());
        let nodes = other.until(end).unwrap();
        let mut terminal = Events::new(vec![
            Event::function(|point| point.q[0] - 0.3).terminal(),
            Event::function(|point| point.v[0] - 0.2).rising().terminal(),
            Event::observable(0).terminal(),
            // of two events in one step, the second is reported after the first has ended the run
            Event::function(|point| Real::sin(point.q[0] * 8.0))
                .falling()
                .terminal(),
        ]);
        let (mut seen, mut ended) = (Trajectory::default(), Vec::new());
        while let Some(event) = third.watch(end, &mut terminal, &mut seen).unwrap() {
            let node = third.node();
            // the run stands at the event, or at one of the nodes beside it
            assert!((node.t - event.t).abs() <= H, "{node:?} {event:?}");
            ended.push(event);
        }
        assert_eq!(ended.len(), all.len());
        for (event, other) in ended.iter().zip(&all) {
            assert_eq!((event.event, event.rising), (other.event, other.rising));
            assert!((event.t - other.t).abs() < 1e-11, "{event:?} {other:?}");
        }
        assert_eq!(seen.last().unwrap().t, end);
        if is_even(third) {
            assert_eq!(seen.len(), nodes.len());
        }
        for pair in seen.nodes.windows(2) {
            assert_eq!(pair[0].index + 1, pair[1].index, "every node is handed out once");
            assert!(pair[0].t < pair[1].t);
        }
    }
    for_every_method!(check);
}

#[test]
fn in_between_the_motion_is_a_polynomial() {
    fn check<R: Stepper<1> + ?Sized>([run, other, third, _]: [&mut R; 4], allowed: Allowed) {
        let times: Vec<f64> = (0..=150).map(|k| T0 + 0.0625 * f64::from(k)).collect();
        let exact = truth(&times);
        let mut points = Vec::new();
        run.sample(&times, &mut |t, point| points.push((t, *point)))
            .unwrap();
        assert_eq!(points.len(), times.len());
        for (((t, point), wanted), exact) in points.iter().zip(&times).zip(&exact) {
            assert_eq!(t, wanted);
            assert!((point.q[0] - exact.q[0]).abs() < allowed.motion);
            // velocities may have errors 1e2 times as large, accelerations 1e3 times
            assert!((point.v[0] - exact.v[0]).abs() < 1e2 * allowed.motion);
            assert!((point.a[0] - exact.a[0]).abs() < 1e3 * allowed.motion);
        }
        // from the stored nodes, too; for discrete methods these are all that is known of the motion
        let trajectory = other.until(T0 + 10.0).unwrap();
        if is_even(other) {
            for ((t, _), exact) in points.iter().zip(&exact) {
                let found = trajectory.at(*t).unwrap();
                assert!((found.q[0] - exact.q[0]).abs() < allowed.motion.max(1e-7));
            }
        }
        let last = trajectory.last().unwrap();
        assert_eq!(trajectory.at(last.t), Some(last.point()));
        assert_eq!(trajectory.at(last.t + 1e-9), None);
        assert_eq!(trajectory.at(T0 - 1e-9), None);
        for wrong in [&[T0 + 1.0, T0 + 0.5][..], &[T0 - 1.0]] {
            assert!(matches!(
                third.sample(wrong, &mut |_, _| {}),
                Err(RunError::TimeBehind(_))
            ));
        }
        assert!(matches!(
            third.sample(&[f64::NAN], &mut |_, _| {}),
            Err(RunError::Until { .. })
        ));
    }
    for_every_method!(check);
}

#[test]
fn times_that_cannot_be_reached_are_told() {
    fn check<R: Stepper<1> + ?Sized>([run, ..]: [&mut R; 4], _: Allowed) {
        let failure = run.until(T0 - 1.0).unwrap_err();
        assert!(failure.trajectory.is_empty());
        assert!(
            matches!(&failure.error, RunError::TimeBehind(behind) if behind.until == T0 - 1.0 && behind.time == T0),
            "{failure}"
        );
        for wrong in [f64::NAN, f64::INFINITY] {
            assert!(matches!(
                run.until(wrong).unwrap_err().error,
                RunError::Until { .. }
            ));
            assert!(matches!(run.to(wrong), Err(RunError::Until { .. })));
        }
        assert!(matches!(
            run.stream(f64::NAN, &mut |_: &Node<1>| {}),
            Err(RunError::Until { .. })
        ));
        assert_eq!(
            run.until(T0 + 1.0).unwrap().nodes[0].index,
            0,
            "the run is as it was"
        );
        assert!(matches!(run.to(T0 + 0.5), Err(RunError::TimeBehind(_))));
    }
    for_every_method!(check);
}

/// The errors along the chain of sources, from the run's on.
fn chain(failure: &Failure<1>) -> Vec<&(dyn Error + 'static)> {
    let mut errors = Vec::new();
    let mut next = failure.source();
    while let Some(error) = next {
        errors.push(error);
        next = error.source();
    }
    errors
}

#[test]
fn a_failing_run_keeps_what_it_had_and_says_why() {
    fn check<R: Stepper<1> + ?Sized>(run: &mut R) -> Failure<1> {
        let failure = run.until(100.0).unwrap_err();
        let nodes = &failure.trajectory;
        assert!(nodes.len() > 3, "{failure}");
        assert!(nodes.iter().all(|node| node.q[0] < 1.0));
        // it fails soon after the last node
        let (last, time) = (nodes.last().unwrap().t, failure.error.time().unwrap());
        assert!((0.0..=0.3).contains(&(time - last)), "{time} {last}");
        assert!(chain(&failure)[0].is::<RunError>());
        assert_eq!(chain(&failure)[0].to_string(), failure.to_string());
        // the iterator of a run that fails ends there; Taylor series may come nearer to the edge without an end in sight
        assert!(run.take(10_000).any(|node| node.is_err()));
        assert!(run.next().is_none());
        failure
    }
    let start = Start::second_order([0.0], [0.5]);
    let (h, tolerance) = (0.1, Tolerance::relative(1e-10));
    let step = check(&mut Flow::new(&Cliff {}, h, start).unwrap());
    assert!(chain(&step)[1].is::<NewtonFailure>());
    let method = Composition::SUZUKI_4;
    let composed = check(&mut ComposedFlow::new(&Cliff {}, h, method, start).unwrap());
    assert!(chain(&composed)[1].is::<StepError>() && chain(&composed)[2].is::<NewtonFailure>());
    for failure in [&step, &composed] {
        let failed = failure.error.failed_step().unwrap();
        assert_eq!(Some(failed.cause.reason), failure.error.step_failure());
        assert_eq!(failed.coordinates, ["x"]);
        assert!(failure.to_string().contains("(x): q0 = "), "{failure}");
    }
    let series = check(&mut TaylorFlow::new(&Cliff {}, start, tolerance).unwrap());
    assert!(chain(&series)[1].is::<SeriesFailure>(), "{series}");
    let on_grid = TaylorFlow::new(&Cliff {}, start, tolerance).unwrap().every(h);
    check(&mut on_grid.unwrap() as &mut dyn Stepper<1>);

    // and so do runs of ensembles
    let ended = Ensemble::new(&Cliff {}, h)
        .unwrap()
        .starts([start; 3])
        .until(100.0);
    for failure in ended {
        let nodes = failure.unwrap_err().trajectory;
        assert_eq!(nodes.len(), step.trajectory.len());
    }
}

#[test]
fn every_method_takes_the_same_start() {
    let nodes = Start::nodes([1.0], [0.99]);
    assert!(Flow::new(&PENDULUM, H, nodes).is_ok());
    let composed = ComposedFlow::new(&PENDULUM, H, Composition::SUZUKI_4, nodes).unwrap_err();
    let series = TaylorFlow::new(&PENDULUM, nodes, Tolerance::relative(1e-9)).unwrap_err();
    assert_eq!(
        (&composed, &series),
        (&SetupError::Velocity, &SetupError::Velocity)
    );
    assert!(composed.to_string().contains("Start::second_order"), "{composed}");
    for start in [
        Start::paper([1.0], [0.25]),
        Start::second_order([1.0], [0.25]).exact(&PENDULUM, H).unwrap(),
    ] {
        let first = ComposedFlow::new(&PENDULUM, H, Composition::SUZUKI_4, start)
            .unwrap()
            .node();
        let other = TaylorFlow::new(&PENDULUM, start, Tolerance::relative(1e-9))
            .unwrap()
            .node();
        assert_eq!((first.q, first.v), ([1.0], [0.25]));
        assert_eq!((first.q, first.v, first.t), (other.q, other.v, other.t));
        assert!((first.a[0] - other.a[0]).abs() < 1e-15);
    }
    for start in [
        START.at(f64::NAN),
        Start::second_order([f64::NAN], [0.0]),
        Start::paper([0.0], [f64::INFINITY]),
    ] {
        assert!(Flow::new(&PENDULUM, H, start).is_err());
        assert!(ComposedFlow::new(&PENDULUM, H, Composition::SUZUKI_4, start).is_err());
        assert!(matches!(
            TaylorFlow::new(&PENDULUM, start, Tolerance::relative(1e-9)),
            Err(SetupError::Start { .. } | SetupError::StartTime { .. })
        ));
    }
    let unknown = Pendulum { strength: f64::NAN };
    assert!(matches!(
        TaylorFlow::new(&unknown, START, Tolerance::relative(1e-9)),
        Err(SetupError::Parameter { name, .. }) if name == "strength"
    ));
    for h in [0.0, f64::NAN] {
        assert!(matches!(reference().every(h), Err(SetupError::Step { .. })));
    }
}

#[test]
fn errors_are_estimated_whatever_the_method() {
    let end = T0 + 10.0;
    let method = Composition::KAHAN_LI_6;
    let runs: [&mut dyn Stepper<1>; 3] = [
        &mut Flow::new(&PENDULUM, H, START).unwrap(),
        &mut ComposedFlow::new(&PENDULUM, H, method, START).unwrap(),
        &mut TaylorFlow::new(&PENDULUM, START, Tolerance::relative(1e-6)).unwrap(),
    ];
    for run in runs {
        let mut errors = Vec::new();
        let error = GlobalError::new(&PENDULUM, START, end).unwrap();
        let mut estimates = Estimates::new(error, |node: &Node<1>, [error]: &[f64; 1]| {
            errors.push((node.t, node.q[0], *error));
        });
        run.stream(end, &mut estimates).unwrap();
        assert!(estimates.finish().unwrap().uncertainty() < 1e-13);
        let times: Vec<f64> = errors.iter().map(|(t, ..)| *t).collect();
        for ((_, q, error), exact) in errors.iter().zip(truth(&times)) {
            assert!(((q - exact.q[0]).abs() - error).abs() < 1e-13);
        }
        assert_eq!(times.last(), Some(&end));
    }
    // beyond the end of the reference motion, T0 + 1, the estimates end with an error
    let error = GlobalError::new(&PENDULUM, START, T0 + 1.0).unwrap();
    let mut count = 0;
    let mut estimates = Estimates::new(error, |_: &Node<1>, _: &[f64; 1]| count += 1);
    let mut flow = Flow::new(&PENDULUM, H, START).unwrap();
    flow.stream(end, &mut estimates).unwrap();
    assert!(matches!(estimates.finish(), Err(RunError::Until { .. })));
    assert_eq!(count, 9);
}

/// The largest error of the times of some events, with the step `h`.
fn error_of_events(
    method: Option<Composition>,
    h: f64,
    exact: &[Occurrence<1>],
    functions: &mut Events<'_, 1>,
) -> f64 {
    let end = T0 + 20.0;
    let found = match method {
        None => happened(&mut Flow::new(&PENDULUM, h, START).unwrap(), end, functions),
        Some(method) => {
            let mut flow = ComposedFlow::new(&PENDULUM, h, method, START).unwrap();
            happened(&mut flow, end, functions)
        }
    };
    assert_eq!(found.len(), exact.len());
    let errors = found
        .iter()
        .zip(exact)
        .map(|(found, exact)| (found.t - exact.t).abs());
    errors.fold(0.0, f64::max)
}

/// Events of positions are as exact as the nodes, up to the sixth order of the polynomial between them.
#[test]
fn the_order_of_events() {
    let functions = || {
        let levels = [-0.8, -0.55, -0.3, -0.05, 0.2, 0.45, 0.7];
        let level = |level: f64| Event::function(move |point: &Point<_, 1>| point.q[0] - level);
        Events::new(levels.into_iter().map(level).collect())
    };
    let exact = happened(&mut reference(), T0 + 20.0, &mut functions());
    for (method, order, steps) in [
        (None, 2.0, [0.1, 0.08, 0.0625, 0.05, 0.04, 0.03125]),
        (
            Some(Composition::SUZUKI_4),
            4.0,
            [0.25, 0.2, 0.16, 0.125, 0.1, 0.08],
        ),
        (
            Some(Composition::KAHAN_LI_6),
            6.0,
            [0.4, 0.32, 0.25, 0.2, 0.16, 0.125],
        ),
        (
            Some(Composition::KAHAN_LI_8),
            6.0,
            [0.32, 0.25, 0.2, 0.16, 0.125, 0.1],
        ),
    ] {
        let errors = steps.map(|h| error_of_events(method, h, &exact, &mut functions()));
        let slope = fit::slope(&steps, &errors);
        println!("{method:?}: slope {slope:.2}, errors {errors:?}");
        assert!(
            (slope - order).abs() < 0.05 * order,
            "{method:?}: {slope}, {errors:?}"
        );
    }
}

/// The acceleration of an oscillator `x'' = -rate² x`, by steps of order 2 and of the third order. Between the nodes it is continuous and of
/// second order, as at the nodes, and it has one event where it vanishes.
#[test]
fn the_acceleration_between_nodes_is_that_of_the_nodes() {
    let mut random = Random::new(43);
    for _ in 0..short_or_long(10, 300) {
        let [rate, phase, size] = [
            random.between(0.5, 3.0),
            random.between(0.1, 3.0),
            random.between(0.1, 2.0),
        ];
        // x = size cos(rate t + phase)
        let state = [0, 1, 2].map(|order| {
            let turned = phase + std::f64::consts::FRAC_PI_2 * f64::from(order);
            [size * rate.powi(order) * turned.cos()]
        });
        let by_force = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - {:?} * x.powi(2) / 2;",
            rate * rate
        );
        let by_jerk = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; kinematic = dddot(x) + {:?} * dot(x); constraint_forces = [(1)];",
            rate * rate
        );
        let starts = [
            Start::second_order(state[0], state[1]),
            Start::third_order(state[0], state[1], state[2]),
        ];
        for (text, start) in [by_force, by_jerk].iter().zip(starts) {
            let text = Text::parse("oscillator", text).unwrap();
            let until = 12.0;
            let mut errors = Vec::new();
            for h in [0.02, 0.01] {
                let flow = || Flow::<1>::of(&text.system, h, start).unwrap();
                let found = happened(
                    &mut flow(),
                    until,
                    &mut Events::new(vec![Event::function(|point| point.a[0])]),
                );
                let exact: Vec<f64> = (0..20)
                    .map(|turn| (std::f64::consts::PI * (f64::from(turn) + 0.5) - phase) / rate)
                    .filter(|t| *t > 0.0 && *t < until - h)
                    .collect();
                let found: Vec<f64> = found
                    .iter()
                    .map(|event| event.t)
                    .filter(|t| *t < until - h)
                    .collect();
                assert_eq!(found.len(), exact.len(), "{h}: {found:?} {exact:?} of {text:?}");
                for (t, exact) in found.iter().zip(&exact) {
                    assert!(
                        (t - exact).abs() < 20.0 * (rate * h).powi(2) * (1.0 + exact),
                        "{h}: {found:?} {exact:?}"
                    );
                }
                // the first step begins with the velocity of the start, which is no difference
                let times: Vec<f64> = (50..5000).map(|i| f64::from(i) * 0.000_413).collect();
                let mut largest = 0.0_f64;
                let mut compare = |t: f64, point: &Point<f64, 1>| {
                    let exact = -size * rate * rate * (rate * t + phase).cos();
                    largest = largest.max((point.a[0] - exact).abs());
                };
                flow().sample(&times, &mut compare).unwrap();
                // the trajectory has the same motion
                let trajectory = flow().until(3.0).unwrap();
                for t in times.iter().step_by(97) {
                    compare(*t, &trajectory.at(*t).unwrap());
                }
                errors.push(largest);
            }
            assert!(errors[1] < errors[0] / 3.0, "{errors:?} of {text:?}");
        }
    }
}
