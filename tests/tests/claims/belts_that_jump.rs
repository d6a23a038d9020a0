//! A block at rest on a belt slips where the velocity of the belt jumps, in time or in space: against the
//! closed form.

use dsocs_core::prelude::*;
use dsocs_tests::declared;
use dsocs_tests::text::{Flow, System, TaylorFlow};

declared! {
    /// A block on a belt that reverses at a time.
    struct ByTime { dry: f64, at: f64, first: f64, then: f64 };
    coordinates(x);
    let belt = if t < at { first } else { then };
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -dry * (dot(x) - belt).signum();
}

declared! {
    /// The belt of `ByTime`, with the other comparison.
    struct After { dry: f64, at: f64, first: f64, then: f64 };
    coordinates(x);
    let belt = if t > at { then } else { first };
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -dry * (dot(x) - belt).signum();
}

declared! {
    /// A block that passes from one belt to the next.
    struct ByPlace { dry: f64, at: f64, first: f64, then: f64 };
    coordinates(x);
    let belt = if x < at { first } else { then };
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -dry * (dot(x) - belt).signum();
}

const DRY: f64 = 0.8;

/// Position and velocity at the time `until` of a block that rests on the first belt up to the time and place
/// `(at, place)` and then slips at a constant rate to the velocity of the second. Valid while it does not
/// return.
fn expected(until: f64, (at, place): (f64, f64), [first, then]: [f64; 2]) -> [f64; 2] {
    let slips = ((then - first).abs() / DRY).min((until - at).max(0.0));
    let end = first + DRY * slips * (then - first).signum();
    let rests = (until - at).max(0.0) - slips;
    [
        place + first * (until - at).min(0.0) + 0.5 * (first + end) * slips + end * rests,
        end,
    ]
}

/// The largest error of position and velocity of the Taylor flow over three tolerances.
fn largest_error<S: System<1>>(
    system: &S,
    first: f64,
    until: f64,
    expected: [f64; 2],
    every: Option<f64>,
) -> f64 {
    let mut largest = 0.0_f64;
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let start = Start::second_order([0.0], [first]);
        let mut flow = TaylorFlow::new(system, start, Tolerance::relative(tolerance)).unwrap();
        if let Some(h) = every {
            flow = flow.every(h).unwrap();
        }
        let end = flow.to(until).unwrap();
        largest = largest
            .max((end.q[0] - expected[0]).abs())
            .max((end.v[0] - expected[1]).abs());
    }
    largest
}

/// A block at rest slips from the jump of its belt on, in time and in space, to four new velocities: position
/// and velocity are the closed form to 1e-9, at the flow's own steps and on two grids.
#[test]
fn what_rests_slips_where_its_surface_jumps() {
    let first = 0.5;
    for then in [-0.3, 1.5, 0.0, 0.55] {
        for every in [None, Some(0.1), Some(0.13)] {
            // on a grid the motion ends at the last node
            let until = every.map_or(1.7, |h: f64| (1.7 / h).floor() * h);
            let of_time = expected(until, (1.0, first), [first, then]);
            let belt = ByTime {
                dry: DRY,
                at: 1.0,
                first,
                then,
            };
            let found = largest_error(&belt, first, until, of_time, every);
            assert!(found < 1e-9, "{then} {every:?}: {found}");
            let belt = After {
                dry: DRY,
                at: 1.0,
                first,
                then,
            };
            let found = largest_error(&belt, first, until, of_time, every);
            assert!(found < 1e-9, "{then} {every:?}: {found}");
            let belt = ByPlace {
                dry: DRY,
                at: 0.5,
                first,
                then,
            };
            let found = largest_error(&belt, first, until, of_time, every);
            assert!(found < 1e-9, "{then} {every:?}: {found}");
        }
    }
}

/// A release by a jump costs the order, and is counted where it lies within a step.
#[test]
fn a_step_across_the_jump_is_counted() {
    for h in [0.02, 0.013, 0.003] {
        let belt = ByTime {
            dry: DRY,
            at: 1.001,
            first: 0.5,
            then: -0.3,
        };
        let mut flow = Flow::new(&belt, h, Start::second_order([0.0], [0.5])).unwrap();
        let end = flow.to(1.7).unwrap();
        let right = expected(end.t, (1.001, 0.5005), [0.5, -0.3]);
        assert!((end.q[0] - right[0]).abs() < h, "{end:?} {right:?}");
        assert!(flow.unresolved().is_some(), "{h}: {end:?} {right:?}");
    }
}
