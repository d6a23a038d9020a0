//! A motion that may go on in more than one way from rest ends there, by steps and by series alike; one that
//! has a single continuation takes it. The continuations of one body are those of a scalar inclusion: the
//! acceleration `a(s)` with the side `s` leads away where `a(1) > 0` or `a(-1) < 0`, and holds where it
//! vanishes within `[-1, 1]`.

use core::fmt::Debug;

use dsocs_core::prelude::{RunError, Start, Stepper, Tolerance};
use dsocs_core::{SeriesFailure, StepFailure};
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::{Flow, System, TaylorFlow};

declared! {
    /// A body on a floor whose normal force depends on its friction, as with a rod that leans.
    #[derive(Debug)]
    struct Jams { push: f64, lean: f64, grows: f64, weight: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - weight * y;
    external_forces = (push, 0);
    holonomic = y;
    let s = dot(x).signum();
    constraint_forces = [(-s, 1 + (lean + grows * t) * s)];
}

declared! {
    /// A body whose friction is not a monotone function of its side.
    #[derive(Debug)]
    struct Bends { push: f64, dry: f64, bend: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    let s = dot(x).signum();
    external_forces = push - dry * s + bend * (1 - s * s);
}

declared! {
    /// The body of `Jams`, and one that friction holds beside it.
    #[derive(Debug)]
    struct Beside { push: f64, lean: f64, dry: f64 };
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - y;
    let s = dot(x).signum();
    let below = dry * dot(z).signum();
    external_forces = (push, 0, -below);
    holonomic = y;
    constraint_forces = [(-s, 1 + lean * s, 0)];
}

/// The continuation from rest: friction holds the body, the body leaves with this acceleration, or there are
/// several continuations.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Outcome {
    Holds,
    Leaves(f64),
    Forks,
}

/// The continuations from rest, with the sides that hold; `None` near the boundary between two cases.
fn outcome(a: &dyn Fn(f64) -> f64, holds: &[f64]) -> Option<Outcome> {
    let bounds = [1.0, -1.0].map(|side| (side, side * a(side)));
    let near = bounds.iter().any(|(_, away)| away.abs() < 1e-2)
        || holds.iter().any(|s: &f64| (s.abs() - 1.0).abs() < 1e-2);
    let mut found: Vec<Outcome> = bounds
        .iter()
        .filter(|(_, away)| *away > 0.0)
        .map(|(side, _)| Outcome::Leaves(a(*side)))
        .collect();
    if holds.iter().any(|s| s.abs() < 1.0) {
        found.push(Outcome::Holds);
    }
    match found[..] {
        _ if near => None,
        [one] => Some(one),
        [] => None,
        _ => Some(Outcome::Forks),
    }
}

/// The first position and velocity at the end of a run, or the time at which it ended since its motion forks.
fn by_steps<S: System<N> + Debug, const N: usize>(
    system: &S,
    h: f64,
    start: Start<N>,
    until: f64,
) -> Result<[f64; 2], f64> {
    let mut flow = Flow::new(system, h, start).unwrap();
    while flow.time() < until - 0.5 * h {
        if let Err(error) = flow.advance() {
            assert_eq!(
                error.step_failure(),
                Some(StepFailure::Forks),
                "{system:?} {start:?} {error}"
            );
            return Err(flow.time());
        }
    }
    let node = flow.node();
    Ok([node.q[0], node.v[0]])
}

fn by_series<S: System<N> + Debug, const N: usize>(
    system: &S,
    tolerance: f64,
    start: Start<N>,
    until: f64,
) -> Result<[f64; 2], f64> {
    let mut flow = TaylorFlow::new(system, start, Tolerance::relative(tolerance)).unwrap();
    match flow.to(until) {
        Ok(node) => Ok([node.q[0], node.v[0]]),
        Err(RunError::Series(error)) => {
            assert!(
                matches!(error.details().cause, SeriesFailure::Forks),
                "{system:?} {start:?} {tolerance} {error}"
            );
            Err(error.details().time)
        }
        Err(error) => panic!("{error}"),
    }
}

/// Counts of forks, rests and departures.
type Counts = [u32; 3];

/// Compares runs by both methods, from a velocity `v` and from rest, with the acceleration `a(s)`.
fn judge<S: System<N> + Debug, const N: usize>(
    system: &S,
    (a, holds): (&dyn Fn(f64) -> f64, &[f64]),
    (v, h, tolerance): (f64, f64, f64),
    counts: &mut Counts,
) {
    let Some(outcome) = outcome(a, holds) else {
        return;
    };
    let start = |v: f64| {
        let mut all = [0.0; N];
        all[0] = v;
        Start::second_order([0.0; N], all)
    };
    counts[match outcome {
        Outcome::Forks => 0,
        Outcome::Holds => 1,
        Outcome::Leaves(_) => 2,
    }] += 1;
    for v in [0.0, v] {
        let slows = a(v.signum());
        // the time at which it would come to rest
        let rests = if v == 0.0 { 0.0 } else { -v / slows };
        let until = 2.0;
        let comes = (0.0..until - 0.1).contains(&rests);
        if v != 0.0 && !comes {
            continue;
        }
        let place = 0.5 * v * rests;
        let left = until - rests;
        let expected = match outcome {
            Outcome::Forks => Err(rests),
            Outcome::Holds => Ok([place, 0.0]),
            Outcome::Leaves(a) => Ok([place + 0.5 * a * left * left, a * left]),
        };
        let steps = by_steps(system, h, start(v), until);
        let series = by_series(system, tolerance, start(v), until);
        let text = format!("{system:?} {outcome:?} v = {v}: {expected:?} {steps:?} {series:?}");
        match expected {
            Err(time) => {
                assert!(
                    steps.is_err_and(|found| (found - time).abs() <= 3.0 * h),
                    "{text}"
                );
                assert!(series.is_err_and(|found| (found - time).abs() <= 1e-2), "{text}");
            }
            Ok(expected) => {
                let (steps, series) = (steps.unwrap_or([f64::NAN; 2]), series.unwrap_or([f64::NAN; 2]));
                for k in 0..2 {
                    let size = 1.0 + slows.abs() + expected[k].abs();
                    assert!((steps[k] - expected[k]).abs() <= 8.0 * h * size, "{text}");
                    assert!(
                        (series[k] - expected[k]).abs() <= 1e3 * tolerance * size,
                        "{text}"
                    );
                }
            }
        }
    }
}

#[test]
fn bodies_that_jam_fork_hold_or_leave() {
    let mut counts = [0; 3];
    for draw in 0..160 {
        let mut random = Random::new(9_100 + draw);
        let lean = if random.between(0.0, 1.0) < 0.5 {
            random.between(0.1, 0.9)
        } else {
            random.between(1.1, 3.0)
        };
        let lean = lean * random.between(-1.0, 1.0).signum();
        let law = Jams {
            push: random.between(-2.0, 2.0),
            weight: random.between(0.5, 2.0),
            lean,
            grows: 0.0,
        };
        let a = |s: f64| law.push - s * law.weight / (1.0 + lean * s);
        // push (1 + lean s) = s weight
        let holds = [law.push / (law.weight - lean * law.push)];
        let v = random.between(0.3, 1.5) * random.between(-1.0, 1.0).signum();
        let h = random.decades(3e-3, 3e-2);
        let tolerance = random.decades(1e-11, 1e-7);
        judge::<_, 2>(&law, (&a, &holds), (v, h, tolerance), &mut counts);
        let law = Beside {
            push: law.push / law.weight,
            lean,
            dry: random.between(0.1, 2.0),
        };
        let a = |s: f64| law.push - s / (1.0 + lean * s);
        judge::<_, 3>(&law, (&a, &holds), (v, h, tolerance), &mut counts);
    }
    println!("forks, holds, leaves: {counts:?}");
    assert!(counts.iter().all(|count| *count > 30), "{counts:?}");
}

#[test]
fn frictions_that_are_not_monotone_fork_hold_or_leave() {
    let mut counts = [0; 3];
    for draw in 0..160 {
        let mut random = Random::new(9_400 + draw);
        let law = Bends {
            push: random.between(-1.5, 1.5),
            dry: random.between(-0.5, 1.0),
            bend: random.between(-2.0, 2.0),
        };
        let Bends { push, dry, bend } = law;
        let a = |s: f64| push - dry * s + bend * (1.0 - s * s);
        let root = (dry * dry + 4.0 * bend * (push + bend)).sqrt();
        let holds: Vec<f64> = [root, -root]
            .into_iter()
            .map(|root| (-dry + root) / (2.0 * bend))
            .filter(|s| s.is_finite())
            .collect();
        let v = random.between(0.3, 1.5) * random.between(-1.0, 1.0).signum();
        let h = random.decades(3e-3, 3e-2);
        let tolerance = random.decades(1e-11, 1e-7);
        judge::<_, 1>(&law, (&a, &holds), (v, h, tolerance), &mut counts);
    }
    println!("forks, holds, leaves: {counts:?}");
    assert!(counts.iter().all(|count| *count > 15), "{counts:?}");
}

/// A run that began at rest before the motion forks, and one that begins there, end alike.
#[test]
fn what_rests_ends_where_its_motion_begins_to_fork() {
    for draw in 0..24 {
        let mut random = Random::new(9_700 + draw);
        let law = Jams {
            push: random.between(-0.3, 0.3),
            weight: 1.0,
            lean: 0.0,
            grows: random.between(0.6, 1.5),
        };
        let at = 1.0 / law.grows;
        let (h, tolerance) = (random.decades(3e-3, 3e-2), random.decades(1e-11, 1e-7));
        let start = Start::second_order([0.0; 2], [0.0; 2]);
        let found = by_steps(&law, h, start, 3.0).unwrap_err();
        assert!(found >= at - h && found <= at + 2.0 * h, "{law:?} {found} {at}");
        let found = by_series(&law, tolerance, start, 3.0).unwrap_err();
        assert!((found - at).abs() < 1e-5, "{law:?} {found} {at}");
        let later = start.at(at + 0.3);
        let found = by_steps(&law, h, later, 3.0).unwrap_err();
        assert!((found - (at + 0.3)).abs() <= 1.001 * h, "{law:?}");
        assert_eq!(by_series(&law, tolerance, later, 3.0), Err(at + 0.3), "{law:?}");
    }
}
