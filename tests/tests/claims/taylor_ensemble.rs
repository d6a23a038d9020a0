//! Taylor flows in lanes: single flows' motions to the tolerance, and the same bits whatever runs in the
//! other lanes.

#![allow(clippy::float_cmp)] // the same numbers, to the last bit

use std::ops::ControlFlow;

use dsocs_core::prelude::*;
use dsocs_core::taylor::TaylorEnsemble;
use dsocs_core::{Instructions, Real, RunError, SeriesFailure, System};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum, Wavy};

/// A bead on a sphere, pushed in time: a constraint on positions, and time itself.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - gravity * z + push * x * (3 * t).sin();
    holonomic = x.powi(2) + y.powi(2) + z.powi(2) - 1;
}]
#[derive(Clone)]
struct Bead {
    gravity: f64,
    push: f64,
}

/// A driven mass with dry friction: a branch by a sign.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    external_forces = 2 * (1.3 * t).sin() - friction * dot(x).signum();
}]
#[derive(Clone)]
struct Dry {
    friction: f64,
}

/// A curvature by a function of the user's, with a corner.
struct Corner;

impl dsocs_systems::Curvature for Corner {
    fn at<D: Real>(&self, x: D, y: D) -> D {
        if x > D::from(0.3) { x * x + y } else { y + x * 0.3 }
    }
}

/// The bits of a node.
fn bits<const N: usize>(node: &Node<N>) -> (u64, u64, [[u64; N]; 4]) {
    let rows = [node.q, node.v, node.a, node.force].map(|x| x.map(f64::to_bits));
    (node.index, node.t.to_bits(), rows)
}

/// Compares each motion with itself alone, in another lane and on other threads (in bits), and with a single
/// flow (to `far`).
fn compare_lanes<S: System<N> + Sync, const N: usize>(system: &S, starts: &[Start<N>], until: f64, far: f64) {
    let tolerance = Tolerance::relative(1e-11);
    let ensemble = |starts: &[Start<N>]| {
        TaylorEnsemble::new(system, tolerance)
            .unwrap()
            .starts(starts.iter().copied())
    };
    let ends = ensemble(starts).threads(2).unwrap().to(until);
    assert_eq!(ends.len(), starts.len());
    let mut reversed: Vec<_> = starts.to_vec();
    reversed.reverse();
    let backwards = ensemble(&reversed).threads(1).unwrap().to(until);
    let (mut good, mut farthest) = (0, 0.0_f64);
    for (place, (end, &start)) in ends.iter().zip(starts).enumerate() {
        let own = &ensemble(&[start]).to(until)[0];
        let again = &backwards[starts.len() - 1 - place];
        match end {
            Ok(node) => {
                assert_eq!(bits(node), bits(own.as_ref().unwrap()), "{place} alone");
                assert_eq!(
                    bits(node),
                    bits(again.as_ref().unwrap()),
                    "{place} in another lane"
                );
                let mut flow = TaylorFlow::new(system, start, tolerance).unwrap();
                if until < flow.time() {
                    flow.reverse().unwrap();
                }
                let single = flow.to(until).unwrap();
                assert_eq!(node.t, single.t);
                for i in 0..N {
                    farthest = farthest.max((node.q[i] - single.q[i]).abs());
                }
                good += 1;
            }
            Err(error) => {
                assert_eq!(error.to_string(), own.as_ref().unwrap_err().to_string());
                assert_eq!(error.to_string(), again.as_ref().unwrap_err().to_string());
            }
        }
    }
    assert!(good * 10 >= starts.len() * 9, "{good} of {}", starts.len());
    assert!(farthest < far, "{farthest:e}");
}

fn pendulum(part: f64) -> Start<2> {
    Start::second_order([0.5, 0.0], [0.3 * part, 0.5 - 0.3 * part])
}

#[test]
fn motions_in_lanes_are_those_of_single_flows() {
    let parts: Vec<f64> = (0..11).map(|k| f64::from(k) / 11.0).collect();
    let starts: Vec<_> = parts.iter().map(|&part| pendulum(part)).collect();
    // up to here the pendulum's steep switch is crossed
    compare_lanes(&InertiaWheelPendulum::default(), &starts, 32.0, 1e-6);
    let particle = |&part: &f64| Start::second_order([0.1, part], [0.5 + part, 1.0]).at(part);
    let starts: Vec<_> = parts.iter().map(particle).collect();
    compare_lanes(&CurvedParticle::default(), &starts, 8.0, 1e-8);
    let field = CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    };
    compare_lanes(&field, &starts, 4.0, 1e-8);
    let corner = CurvedParticle {
        mass: 1.0,
        curvature: Corner,
    };
    compare_lanes(&corner, &starts, 3.0, 1e-7);
}

#[test]
fn constraints_time_and_jumps() {
    let bead = Bead {
        gravity: 9.81,
        push: 2.0,
    };
    let starts: Vec<_> = (0..11)
        .map(|k| {
            let angle = 0.2 + 0.2 * f64::from(k);
            Start::second_order([angle.sin(), 0.0, -angle.cos()], [0.0, 1.0, 0.0]).at(0.1 * f64::from(k))
        })
        .collect();
    compare_lanes(&bead, &starts, 5.0, 1e-7);
    let starts: Vec<_> = (0..11)
        .map(|k| Start::second_order([0.1 * f64::from(k)], [1.0]))
        .collect();
    compare_lanes(&Dry { friction: 0.2 }, &starts, 8.0, 1e-7);
    // backward in time
    let starts: Vec<_> = (0..9).map(|k| pendulum(0.1 * f64::from(k)).at(3.0)).collect();
    compare_lanes(&InertiaWheelPendulum::default(), &starts, 1.0, 1e-7);
}

#[test]
fn nodes_lie_on_a_grid_or_at_the_ends_of_steps() {
    let system = InertiaWheelPendulum::default();
    let tolerance = Tolerance::relative(1e-12);
    let ensemble = || {
        TaylorEnsemble::new(&system, tolerance)
            .unwrap()
            .starts((0..10).map(|k| pendulum(0.1 * f64::from(k))))
    };
    let on_grid = ensemble().every(0.25).unwrap().until(6.1);
    let at_steps = ensemble().until(6.1);
    for (k, (grid, steps)) in on_grid.iter().zip(&at_steps).enumerate() {
        let (grid, steps) = (grid.as_ref().unwrap(), steps.as_ref().unwrap());
        let start = pendulum(0.1 * k as f64);
        let mut flow = TaylorFlow::new(&system, start, tolerance).unwrap();
        let single = flow.until(6.1).unwrap();
        assert!(steps.len().abs_diff(single.len()) <= 1 + single.len() / 10);
        assert_eq!(steps.last().unwrap().t, 6.1);
        let flow = TaylorFlow::new(&system, start, tolerance).unwrap();
        let single = flow.every(0.25).unwrap().until(6.1).unwrap();
        assert_eq!(grid.len(), 25);
        for (node, single) in grid.iter().zip(&single) {
            assert_eq!((node.index, node.t), (single.index, single.t));
            for i in 0..2 {
                assert!((node.q[i] - single.q[i]).abs() < 1e-8, "{k} {}", node.t);
                assert!((node.a[i] - single.a[i]).abs() < 1e-6, "{k} {}", node.t);
            }
        }
    }
    // an observer may end its motion, and no other
    let ended = ensemble().every(0.25).unwrap().stream(6.0, |place| {
        move |node: &Node<2>| {
            if place == 3 && node.t >= 2.0 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        }
    });
    for (place, run) in ended.into_iter().enumerate() {
        assert_eq!(run.last.unwrap().t, if place == 3 { 2.0 } else { 6.0 });
    }
    let nothing = TaylorEnsemble::new(&system, tolerance).unwrap().until(1.0);
    assert!(nothing.is_empty());
}

#[test]
fn failures_are_entries() {
    let system = Bead {
        gravity: 9.81,
        push: 0.0,
    };
    let start =
        |k: u32| Start::second_order([0.0, 0.0, if k == 4 { f64::NAN } else { -1.0 }], [1.0, 0.0, 0.0]);
    let ensemble = TaylorEnsemble::new(&system, Tolerance::relative(1e-9))
        .unwrap()
        .starts((0..19).map(start))
        .varied(
            "gravity",
            (0..19).map(|k| {
                if k == 11 {
                    f64::INFINITY
                } else {
                    1.0 + f64::from(k)
                }
            }),
        )
        .unwrap();
    let ends = ensemble.to(3.0);
    for (k, end) in (0..).zip(&ends) {
        assert_eq!(end.is_err(), k == 4 || k == 11, "{k}");
        if let Ok(end) = end {
            let own = Bead {
                gravity: 1.0 + f64::from(k),
                push: 0.0,
            };
            let mut flow = TaylorFlow::new(&own, start(k), Tolerance::relative(1e-9)).unwrap();
            let single = flow.to(3.0).unwrap();
            assert!((end.q[0] - single.q[0]).abs() < 1e-7, "{k}");
        }
    }
    let many: Vec<_> = ensemble.max_steps(7).until(3.0);
    for (k, run) in (0..).zip(many) {
        let failure = run.unwrap_err();
        if k == 4 || k == 11 {
            assert!(matches!(failure.error, RunError::Setup(_)), "{failure}");
        } else {
            let RunError::Series(error) = &failure.error else {
                panic!("{failure}");
            };
            assert!(matches!(
                error.details().cause,
                SeriesFailure::TooManySteps { steps: 7, .. }
            ));
            assert_eq!(failure.trajectory.len(), 8);
        }
    }
    for t in [f64::NAN, f64::INFINITY, -1.0] {
        let ends = TaylorEnsemble::new(&system, Tolerance::relative(1e-9))
            .unwrap()
            .starts([start(0)])
            .every(0.1)
            .unwrap()
            .to(t);
        assert!(ends[0].is_err(), "{t}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a debug build has one set of instructions")]
fn all_instructions_give_the_same_bits() {
    let system = InertiaWheelPendulum::default();
    let ends = |these| {
        let ensemble = TaylorEnsemble::new(&system, Tolerance::relative(1e-9))
            .unwrap()
            .starts((0..19).map(|k| pendulum(0.05 * f64::from(k))))
            .instructions(these);
        format!("{:?}", ensemble.to(60.0))
    };
    let narrow = ends(Instructions::Compiled);
    for these in Instructions::ALL {
        assert!(ends(these) == narrow, "{these}");
    }
}
