//! Trajectories in lanes are as accurate as single ones, whatever runs in the other lanes and however many
//! threads there are.

use std::num::NonZeroU64;

use dsocs_core::{
    Ensemble, Flow, InputError, Inputs, Instructions, Node, RunError, Start, StepFailure, Stepper, System,
    Trajectory, dsocs,
};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum, Wavy};
use dsocs_tests::closed_form::pendulum::START;
use dsocs_tests::data::Table;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::short_or_long;

/// The places of the reference's start among the others: in full blocks, and in the last one, which is not full.
const PLACES: [usize; 4] = [0, 5, 12, 17];

/// Up to a time: the largest deviations of both coordinates, as for single trajectories.
type Tolerance = (f64, [f64; 2]);

/// Compares all nodes of the reference's start, which runs in lanes among other starts, with the reference.
fn compare<S: System<2> + Sync>(
    system: &S,
    h: f64,
    t: f64,
    start: Start<2>,
    others: impl Fn(f64) -> Start<2>,
    (file, columns, tolerances): (&str, [&str; 2], &[Tolerance]),
) {
    let starts = (0_u32..18).map(|k| {
        let is_reference = PLACES.contains(&(k as usize));
        if is_reference { start } else { others(f64::from(k)) }
    });
    let ensemble = Ensemble::new(system, h).unwrap().starts(starts);
    let observed = ensemble.stream(t, NonZeroU64::MIN, |_| Trajectory::default());
    let [first, rest @ ..] = PLACES.map(|place| &observed[place].observer);
    assert!(rest.iter().all(|other| *other == first), "lanes differ");
    let table = Table::read(file);
    for (k, q) in table.indices("k").into_iter().zip(table.pairs(columns)) {
        let node = &first.nodes[usize::try_from(k).unwrap()];
        let (_, tolerance) = tolerances
            .iter()
            .find(|(until, _)| node.t <= until + 1e-9)
            .unwrap();
        for i in 0..2 {
            let deviation = (node.q[i] - q[i]).abs();
            assert!(
                deviation <= tolerance[i],
                "h = {h}, t = {}: coordinate {i} is {deviation:e} off",
                node.t
            );
        }
    }
}

fn pendulum(k: f64) -> Start<2> {
    Start::paper([0.5 - 0.01 * k, 0.1 * k], [0.001 * k, 0.5])
}

#[test]
fn the_pendulum_is_the_references() {
    let cases: [(f64, f64, &str, &[Tolerance]); 3] = [
        (
            0.1,
            2000.0,
            "pendulum_discrete_h0.1.csv",
            &[
                (10.0, [2e-13, 5e-10]),
                (100.0, [3e-11, 5e-9]),
                (2000.0, [5e-11, 1e-8]),
            ],
        ),
        (
            0.05,
            2000.0,
            "pendulum_discrete_h0.05.csv",
            &[(100.0, [1e-10, 3e-8]), (2000.0, [2e-10, 4e-8])],
        ),
        (
            0.0125,
            2000.0,
            "pendulum_discrete_h0.0125.csv",
            &[(100.0, [1e-9, 2e-7]), (2000.0, [1e-9, 2e-7])],
        ),
    ];
    for (h, t, file, tolerances) in cases {
        let start = Start::paper(START.0, START.1);
        let reference = (file, ["theta", "psi"], tolerances);
        compare(&InertiaWheelPendulum::default(), h, t, start, pendulum, reference);
    }
}

#[test]
fn the_particle_is_the_references() {
    let cases = [
        (
            0.1,
            "particle_discrete_h0.1.csv",
            [(1.0, 1e-14), (10.0, 5e-13), (100.0, 5e-11), (500.0, 1e-9)],
        ),
        (
            0.01,
            "particle_discrete_h0.01.csv",
            [(1.0, 1e-12), (10.0, 5e-11), (100.0, 3e-9), (500.0, 4e-8)],
        ),
    ];
    for (h, file, tolerances) in cases {
        let tolerances = tolerances.map(|(until, tolerance)| (until, [tolerance; 2]));
        let start = Start::paper([0.0, 0.0], [1.0, 1.0]);
        let others = |k: f64| Start::paper([k, 1.0], [0.3 * k - 1.0, 1.0]);
        let reference = (file, ["x", "y"], tolerances.as_slice());
        compare(&CurvedParticle::default(), h, 500.0, start, others, reference);
    }
}

/// The last node of a flow.
fn single<S: System<2>>(system: &S, h: f64, start: Start<2>, t: f64) -> Node<2> {
    let mut last = None;
    let mut flow = Flow::new(system, h, start).unwrap();
    flow.stream(t, &mut |node: &Node<2>| last = Some(*node)).unwrap();
    last.unwrap()
}

#[test]
fn a_curvature_that_the_macro_cannot_see_into_is_the_flows_bit_for_bit() {
    let particle = CurvedParticle {
        mass: 2.0,
        curvature: Wavy::default(),
    };
    let starts: Vec<_> = (0..13)
        .map(|k| Start::second_order([0.4 * f64::from(k), 0.0], [1.0, 0.1 * f64::from(k)]))
        .collect();
    for h in [0.01, 0.1, 0.3] {
        let ended = Ensemble::new(&particle, h)
            .unwrap()
            .starts(starts.clone())
            .to(40.0);
        for (&start, last) in starts.iter().zip(ended) {
            assert_eq!(last, Ok(single(&particle, h, start, 40.0)));
        }
    }
}

/// 37 runs to t = 300 have the same bits on 1, 2 and 4 threads, in the opposite order, and alone.
#[test]
fn neither_threads_nor_company_change_a_bit() {
    let system = InertiaWheelPendulum::default();
    let starts: Vec<_> = (0..37).map(|k| pendulum(f64::from(k))).collect();
    let run = |starts: &[Start<2>], threads| {
        let ensemble = Ensemble::new(&system, 0.1)
            .unwrap()
            .starts(starts.iter().copied());
        ensemble.threads(threads).unwrap().to(300.0)
    };
    let first = run(&starts, 1);
    assert!(first.iter().all(Result::is_ok));
    for threads in [2, 4] {
        assert_eq!(run(&starts, threads), first);
    }
    let backwards: Vec<_> = starts.iter().rev().copied().collect();
    assert!(run(&backwards, 2).iter().rev().eq(&first));
    for (place, &start) in starts.iter().enumerate().step_by(5) {
        assert_eq!(run(&[start], 1)[0], first[place]);
    }
}

#[test]
fn a_particle_at_rest_fails_by_itself() {
    let particle = CurvedParticle::default();
    let start = |k: i32| {
        let speed = if k % 3 == 1 { 0.0 } else { f64::from(k) };
        Start::paper([0.0, f64::from(k)], [speed, 0.0])
    };
    let ended = Ensemble::new(&particle, 0.1)
        .unwrap()
        .starts((0..20).map(|k| start(k + 1)))
        .to(10.0);
    for (k, last) in (1..).zip(ended) {
        if k % 3 == 1 {
            let Err(RunError::Step(error)) = last else {
                panic!("{last:?}");
            };
            assert_eq!(error.details().index, 1);
            assert_eq!(error.details().q1, [0.0, f64::from(k)]);
            assert_eq!(error.details().cause.reason, StepFailure::Degenerate);
        } else {
            assert_eq!(last, Ok(single(&particle, 0.1, start(k), 10.0)));
        }
    }
}

#[test]
fn running_back_is_the_flows_too() {
    let particle = CurvedParticle::default();
    let starts = (0..9).map(|k| Start::second_order([0.0, 0.0], [1.0, f64::from(k)]).at(2.0));
    let ended = Ensemble::new(&particle, -0.05)
        .unwrap()
        .starts(starts.clone())
        .to(-3.0);
    for (start, last) in starts.zip(ended) {
        assert_eq!(last, Ok(single(&particle, -0.05, start, -3.0)));
    }
}

/// An equation with two factors, each an oscillator: every step has two roots.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (ddot(x) + k[0] * x + s[0] * x.powi(3) + f[0]) * (ddot(x) + k[1] * x + s[1] * x.powi(3) + f[1]);
    constraint_forces = [(1,)];
}]
struct Springs {
    k: [f64; 2],
    s: [f64; 2],
    f: [f64; 2],
}

impl Springs {
    fn new(random: &mut Random) -> Self {
        Self {
            k: [(); 2].map(|()| random.between(0.2, 4.0)),
            s: [(); 2].map(|()| random.between(-0.3, 0.3)),
            f: [(); 2].map(|()| random.between(-0.5, 0.5)),
        }
    }

    /// The accelerations of both oscillators.
    fn accelerations(&self, x: f64) -> [f64; 2] {
        [0, 1].map(|i| -(self.k[i] * x + self.s[i] * x.powi(3) + self.f[i]))
    }

    /// Whether all nodes belong to the oscillator to which the first step belongs.
    fn is_one_motion(&self, h: f64, nodes: &[Node<1>]) -> bool {
        let mut apart = [0.0_f64; 2];
        let mut first = None;
        for leg in nodes.windows(3) {
            let [before, here, after] = [leg[0].q[0], leg[1].q[0], leg[2].q[0]];
            let a = (after - 2.0 * here + before) / (h * h);
            let both = self.accelerations(here);
            for (apart, own) in apart.iter_mut().zip(both) {
                *apart = apart.max((a - own).abs());
            }
            if first.is_none() {
                first = Some(usize::from((a - both[1]).abs() < (a - both[0]).abs()));
            }
        }
        // second differences of nodes over h² have about this rounding
        first.is_none_or(|first| apart[first] < 1e-8)
    }
}

/// Such an oscillator, coupled to two other bodies: three unknowns.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 + (y - x).cos() + (z - y).cos() + 1e-3 * x.cos();
    kinematic = (ddot(x) + k[0] * x + f[0] + (y - x).sin() / 8) * (ddot(x) + k[1] * x + f[1] + (z - x).sin() / 8);
    constraint_forces = [(1, 0, 0)];
    phi_lagrangian = midpoint;
}]
struct Tied {
    k: [f64; 2],
    f: [f64; 2],
}

#[test]
fn a_lane_takes_no_root_that_a_flow_would_not() {
    let mut random = Random::new(3);
    let (mut held, mut refused) = (0, 0);
    let count = short_or_long(9, 30);
    for _ in 0..count {
        let springs = Springs::new(&mut random);
        let starts: Vec<_> = (0..16)
            .map(|_| Start::second_order([random.between(-1.0, 1.0)], [random.between(-1.0, 1.0)]))
            .collect();
        for h in [0.1, 0.05] {
            let ensemble = Ensemble::new(&springs, h).unwrap().starts(starts.clone());
            let observed = ensemble.stream(20.0, NonZeroU64::MIN, |_| Trajectory::default());
            for (&start, lane) in starts.iter().zip(observed) {
                let nodes = &lane.observer.nodes;
                assert!(
                    springs.is_one_motion(h, nodes),
                    "a lane went over to the other root"
                );
                let single = Flow::new(&springs, h, start).map(|mut flow| flow.to(20.0));
                match (lane.last, single) {
                    (Ok(lane), Ok(Ok(single))) => {
                        assert_eq!(lane, single);
                        held += 1;
                    }
                    (Err(lane), Ok(Err(single))) => {
                        assert_eq!(lane.to_string(), single.to_string());
                        refused += 1;
                    }
                    (lane, single) => panic!("a lane {lane:?}, a flow {single:?}"),
                }
            }
        }
    }
    println!("{held} held, {refused} refused");
    assert!(held > 20 * count / 3 && refused > 20 * count / 3);
}

/// With three unknowns determinants are products of pivots, in units of their own.
#[test]
fn nor_does_one_with_several_unknowns() {
    let mut random = Random::new(4);
    let (mut held, mut refused, mut steps) = (0, 0, 0);
    let count = short_or_long(6, 24);
    for _ in 0..count {
        let tied = Tied {
            k: [(); 2].map(|()| random.between(0.2, 4.0)),
            f: [(); 2].map(|()| random.between(-0.5, 0.5)),
        };
        let mut vector = |size: f64| [(); 3].map(|()| random.between(-size, size));
        let starts: Vec<_> = (0..16)
            .map(|_| Start::second_order(vector(1.0), vector(1.0)))
            .collect();
        let ended = Ensemble::new(&tied, 0.05)
            .unwrap()
            .starts(starts.clone())
            .to(10.0);
        for (&start, lane) in starts.iter().zip(ended) {
            let single = Flow::new(&tied, 0.05, start).map(|mut flow| flow.to(10.0));
            match (lane, single) {
                (Ok(lane), Ok(Ok(single))) => {
                    for (lane, single) in lane.q.iter().zip(single.q) {
                        assert!((lane - single).abs() < 1e-9, "{lane} {single}");
                    }
                    held += 1;
                }
                (Err(RunError::Step(lane)), Ok(Err(RunError::Step(single)))) => {
                    let [lane, single] = [lane.details(), single.details()];
                    assert_eq!(
                        (lane.index, lane.cause.reason),
                        (single.index, single.cause.reason)
                    );
                    refused += 1;
                    steps += lane.index;
                }
                (lane, single) => panic!("a lane {lane:?}, a flow {single:?}"),
            }
        }
    }
    println!("{held} held, {refused} refused after {steps} steps");
    assert!(held > 5 * count / 6 && refused > count / 4 && steps > 5 * refused);
}

/// A particle with a curvature, on a slope with friction: its rows contain roots and powers only.
#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - slope * y;
    external_forces = (-friction * dot(x).powi(3), -friction * dot(y).powi(3));
}]
#[derive(Clone)]
struct Sliding {
    mass: f64,
    slope: f64,
    friction: f64,
}

#[test]
fn parameters_vary_from_lane_to_lane() {
    let base = Sliding {
        mass: 1.0,
        slope: 0.5,
        friction: 0.1,
    };
    let values = |k: u32| [1.0 + 0.1 * f64::from(k), 0.3 * f64::from(k) - 1.0];
    let start = |k: u32| Start::second_order([0.0, 0.1 * f64::from(k)], [1.0, 0.2]);
    // run 11 cannot begin, which ends no other
    let mass = |k: u32| if k == 11 { f64::NAN } else { values(k)[0] };
    let ensemble = Ensemble::new(&base, 0.05)
        .unwrap()
        .starts((0..21).map(start))
        .varied("mass", (0..21).map(mass))
        .unwrap()
        .varied("slope", (0..21).map(|k| values(k)[1]))
        .unwrap();
    let runs = ensemble.until(10.0);
    assert_eq!(runs.len(), 21);
    for (k, run) in (0..).zip(&runs) {
        if k == 11 {
            let failure = run.as_ref().unwrap_err();
            assert!(matches!(failure.error, RunError::Setup(_)), "{failure}");
            assert!(failure.trajectory.is_empty());
            continue;
        }
        let [mass, slope] = values(k);
        let own = Sliding { mass, slope, ..base };
        let alone = Flow::new(&own, 0.05, start(k)).unwrap().until(10.0).unwrap();
        // all but the number of evaluations
        let bits = |node: &Node<2>| [node.q, node.v, node.force].map(|x| x.map(f64::to_bits));
        let run = run.as_ref().unwrap();
        assert_eq!(run.len(), alone.len());
        assert!(run.iter().zip(&alone).all(|(x, y)| bits(x) == bits(y)), "{k}");
    }
    let ensemble = |starts: u32| Ensemble::new(&base, 0.05).unwrap().starts((0..starts).map(start));
    let refused = |result: Result<Ensemble<'_, 2>, RunError>| match result {
        Err(RunError::Input(error)) => *error,
        other => panic!("{other:?}"),
    };
    let error = refused(ensemble(3).varied("weight", [1.0; 3]));
    assert!(matches!(error, InputError::Unknown { .. }));
    let error = refused(ensemble(3).varied("mass", [1.0; 2]));
    assert!(matches!(
        error,
        InputError::Count {
            values: 2,
            starts: 3,
            ..
        }
    ));
}

#[test]
fn the_pendulum_with_other_parameters_in_every_lane() {
    let base = InertiaWheelPendulum::default();
    let rho = |k: u32| 1.0 + 0.25 * f64::from(k);
    let start = Start::second_order([0.5, 0.0], [0.0, 0.5]);
    let ends = Ensemble::new(&base, 0.05)
        .unwrap()
        .starts((0..10).map(|_| start))
        .varied("rho", (0..10).map(rho))
        .unwrap()
        .to(20.0);
    for (k, end) in (0..).zip(ends) {
        let own = InertiaWheelPendulum { rho: rho(k), ..base };
        let alone = Flow::new(&own, 0.05, start).unwrap().to(20.0).unwrap();
        let end = end.unwrap();
        for i in 0..2 {
            assert!(
                (end.q[i] - alone.q[i]).abs() < 1e-9,
                "{k}: {} {}",
                end.q[i],
                alone.q[i]
            );
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a debug build has one set of instructions")]
fn all_instructions_give_the_same_bits() {
    let pendulum_starts: Vec<_> = (0..11).map(|k| pendulum(f64::from(k))).collect();
    let ends = |widest| {
        let ensemble = Ensemble::new(&InertiaWheelPendulum::default(), 0.1)
            .unwrap()
            .starts(pendulum_starts.iter().copied())
            .instructions(widest)
            .to(60.0);
        let mut random = Random::new(5);
        let tied = Tied {
            k: [0.7, 2.0],
            f: [0.1, -0.2],
        };
        let starts = (0..9).map(|_| {
            let mut vector = || [(); 3].map(|()| random.between(-1.0, 1.0));
            Start::second_order(vector(), vector())
        });
        let three = Ensemble::new(&tied, 0.05)
            .unwrap()
            .starts(starts)
            .instructions(widest)
            .to(5.0);
        // the shortest decimals distinguish all numbers
        format!("{ensemble:?} {three:?}")
    };
    let narrow = ends(Instructions::Compiled);
    for widest in Instructions::ALL {
        assert!(ends(widest) == narrow, "{widest}");
    }
}

/// The last node of a flow under held inputs.
fn node_under_inputs(
    own: &Sliding,
    h: f64,
    start: Start<2>,
    t: f64,
    plan: &[[f64; 2]],
) -> Result<Node<2>, RunError> {
    let at = |time: f64| {
        // backward in time a value is left at the time from which on it holds
        let holds = |from: f64| {
            if h < 0.0 {
                from < time + 1e-6 * h
            } else {
                from <= time + 1e-6 * h
            }
        };
        let held = plan.iter().rfind(|[from, _]| holds(*from));
        held.map_or(own.friction, |[_, value]| *value)
    };
    let begun = Sliding {
        friction: at(start.time()),
        ..own.clone()
    };
    let mut flow = Flow::new(&begun, h, start)?;
    let mut last = flow.node();
    flow.drive(t, &mut |node, run| {
        last = *node;
        let next = run.clock().time_of(node.index + 1);
        run.set_input("friction", at(next))
    })?;
    Ok(last)
}

#[test]
fn inputs_are_held_from_lane_to_lane() {
    let base = Sliding {
        mass: 1.0,
        slope: 0.5,
        friction: 0.1,
    };
    let start = |k: u32| Start::second_order([0.0, 0.1 * f64::from(k)], [1.0, 0.2]);
    // changes often, at once, between nodes, or never; one value is refused
    let plan = |k: u32| -> Vec<[f64; 2]> {
        let changes = (0..3 * k).map(|i| [0.3 * f64::from(i), 0.05 * f64::from((i * k) % 7)]);
        match k {
            7 => vec![[1.0, 0.3], [2.0, f64::NAN], [3.0, 0.1]],
            8 => vec![[0.02, 0.4], [0.05, 0.2], [0.051, 0.7]],
            _ => changes.collect(),
        }
    };
    let mut ended = 0;
    for h in [0.05_f64, -0.05] {
        let t = 6.0 * h.signum();
        let shifted = |k| if h < 0.0 { start(k).at(6.0) } else { start(k) };
        let end = if h < 0.0 { 0.0 } else { t };
        let ensemble = Ensemble::new(&base, h)
            .unwrap()
            .starts((0..19).map(shifted))
            .varied("mass", (0..19).map(|k| 1.0 + 0.1 * f64::from(k)))
            .unwrap()
            .held("friction", (0..19).map(plan))
            .unwrap();
        let every = ensemble.stream(end, NonZeroU64::MIN, |_| Trajectory::default());
        for (k, (last, seen)) in (0..).zip(ensemble.to(end).into_iter().zip(every)) {
            let own = Sliding {
                mass: 1.0 + 0.1 * f64::from(k),
                ..base.clone()
            };
            let alone = node_under_inputs(&own, h, shifted(k), end, &plan(k));
            match (&last, &alone) {
                (Ok(lane), Ok(alone)) => {
                    let bits = |node: &Node<2>| [node.q, node.v, node.force].map(|x| x.map(f64::to_bits));
                    assert_eq!(bits(lane), bits(alone), "{k}, {h}");
                }
                (Err(lane), Err(alone)) => assert_eq!(lane.to_string(), alone.to_string()),
                other => panic!("{k}: {other:?}"),
            }
            assert_eq!(format!("{:?}", seen.last), format!("{last:?}"), "{k}");
            assert!(last.is_err() || k != 7);
            ended += u32::from(last.is_ok());
        }
    }
    assert!(ended > 30, "{ended}");
    let refused = Ensemble::new(&base, 0.1)
        .unwrap()
        .starts([start(0)])
        .held("friction", [Vec::new(), Vec::new()]);
    assert!(matches!(refused, Err(RunError::Input(error)) if matches!(*error, InputError::Count { .. })));
}
