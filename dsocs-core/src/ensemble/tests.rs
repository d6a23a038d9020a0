use crate::flow::Flow;
use core::ops::ControlFlow;
use std::sync::Mutex;

use super::*;
use crate::number::instructions::Instructions;
use crate::run::Stepper;
use crate::solve::failure::StepFailure;
use crate::testing::{Cliff, Particle};

/// Starts of the particle, slow and fast.
fn particles(count: u32) -> Vec<Start<2>> {
    (0..count)
        .map(|k| {
            let k = f64::from(k);
            Start::second_order([k, -0.3 * k], [0.2 + 0.37 * k, 1.0 - 0.1 * k])
        })
        .collect()
}

/// Starts on the cliff: those with an odd number fall off it at some time.
fn walkers() -> Vec<Start<1>> {
    (0..19)
        .map(|k| {
            let k = f64::from(k);
            let x = if k.rem_euclid(2.0) == 0.0 {
                -1e9 - k
            } else {
                0.9 - 0.1 * k
            };
            Start::second_order([x], [0.3])
        })
        .collect()
}

fn alone<S: System<N>, const N: usize>(
    system: &S,
    h: f64,
    start: Start<N>,
    t: f64,
) -> Result<Node<N>, RunError> {
    let mut last = None;
    let mut flow = Flow::new(system, h, start)?;
    flow.stream(t, &mut |node: &Node<N>| last = Some(*node))?;
    last.ok_or(RunError::Until { until: t })
}

#[test]
fn all_instructions_give_the_same_bits() {
    let ends = |widest| {
        let particles = Ensemble::new(&Particle::default(), 0.1)
            .unwrap()
            .starts(particles(21))
            .instructions(widest)
            .to(30.0);
        let walkers = Ensemble::new(&Cliff, 0.1)
            .unwrap()
            .starts(walkers())
            .instructions(widest)
            .to(20.0);
        // with the shortest decimals, different numbers have different texts
        format!("{particles:?} {walkers:?}")
    };
    let narrow = ends(Instructions::Compiled);
    for widest in Instructions::ALL {
        assert!(ends(widest) == narrow, "{widest}");
    }
}

#[test]
fn lanes_without_functions_are_flows_bit_for_bit() {
    for (h, t) in [(0.001, 1.0), (0.01, 7.0), (0.1, 30.0), (0.4, 50.0), (-0.05, -9.0)] {
        let starts = particles(21);
        let ended = Ensemble::new(&Particle::default(), h)
            .unwrap()
            .starts(starts.clone())
            .to(t);
        assert_eq!(ended.len(), starts.len());
        for (start, last) in starts.into_iter().zip(ended) {
            assert_eq!(last, alone(&Particle::default(), h, start, t), "h = {h}");
        }
    }
}

#[test]
fn a_lane_that_fails_has_its_error_and_the_others_go_on() {
    let ended = Ensemble::new(&Cliff, 0.01).unwrap().starts(walkers()).to(20.0);
    let mut failed = 0;
    for (start, last) in walkers().into_iter().zip(ended) {
        assert_eq!(
            format!("{last:?}"),
            format!("{:?}", alone(&Cliff, 0.01, start, 20.0))
        );
        if let Err(RunError::Step(error)) = &last {
            failed += 1;
            assert_eq!(error.details().cause.reason, StepFailure::NotFinite);
            assert!(error.details().index > 2);
        } else {
            assert!(last.is_ok_and(|node| node.q[0].is_finite()));
        }
    }
    assert_eq!(failed, 9);
}

#[test]
fn company_is_of_no_account() {
    let (all, cliff) = (walkers(), Cliff);
    let ended = Ensemble::new(&cliff, 0.01).unwrap().starts(all.clone()).to(3.0);
    for shift in [1, 3, 8] {
        let mut others = all.clone();
        others.rotate_left(shift);
        let mut again = Ensemble::new(&cliff, 0.01).unwrap().starts(others).to(3.0);
        again.rotate_right(shift);
        assert_eq!(format!("{again:?}"), format!("{ended:?}"));
    }
    let single: Vec<_> = all
        .iter()
        .flat_map(|&start| Ensemble::new(&cliff, 0.01).unwrap().starts([start]).to(3.0))
        .collect();
    assert_eq!(format!("{single:?}"), format!("{ended:?}"));
}

#[cfg(feature = "rayon")]
#[test]
fn the_number_of_threads_is_of_no_account() {
    let particle = Particle::default();
    let ended = |threads| {
        let ensemble = Ensemble::new(&particle, 0.01).unwrap().starts(particles(67));
        ensemble.threads(threads).unwrap().to(5.0)
    };
    let first = ended(1);
    for threads in [2, 3, 7] {
        assert_eq!(ended(threads), first);
    }
}

#[test]
fn observers_see_every_so_many_nodes() {
    let particle = Particle::default();
    for every in [1, 3, 10, 1000] {
        let every = NonZeroU64::new(every).unwrap();
        let ensemble = Ensemble::new(&particle, 0.1).unwrap().starts(particles(11));
        let observed = ensemble.stream(8.04, every, |_| Trajectory::default());
        for (start, observed) in particles(11).into_iter().zip(observed) {
            let nodes = Flow::new(&particle, 0.1, start)
                .unwrap()
                .until(8.04)
                .unwrap()
                .nodes;
            assert_eq!(observed.last, Ok(nodes[80]));
            let seen: Vec<_> = nodes
                .into_iter()
                .step_by(usize::try_from(every.get()).unwrap())
                .collect();
            // at the start, the acceleration of a paper's start may be unknown
            assert_eq!(observed.observer.nodes, seen);
        }
    }
}

#[test]
fn an_observer_breaks_off_its_own_trajectory() {
    let particle = Particle::default();
    let ensemble = Ensemble::new(&particle, 0.1).unwrap().starts(particles(10));
    let observed = ensemble.stream(f64::INFINITY, NonZeroU64::MIN, |place| {
        move |node: &Node<2>| {
            if node.index == 5 * place as u64 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        }
    });
    for (place, (start, observed)) in particles(10).into_iter().zip(observed).enumerate() {
        let t = 0.1 * 5.0 * place as f64;
        assert_eq!(observed.last, alone(&particle, 0.1, start, t), "{place}");
    }
}

#[test]
fn trajectories_may_begin_at_their_own_times() {
    let particle = Particle::default();
    let starts = || {
        particles(9)
            .into_iter()
            .zip([0.0, 1.0, 4.95, 4.85, 0.7, 5.0, 6.0, 3.0, 0.0])
    };
    let starts = || starts().map(|(start, t0)| start.at(t0));
    let ended = Ensemble::new(&particle, 0.1).unwrap().starts(starts()).to(5.0);
    for (start, last) in starts().zip(ended) {
        assert_eq!(last, alone(&particle, 0.1, start, 5.0));
    }
}

#[test]
fn what_cannot_be_run_is_told() {
    let particle = Particle::default();
    assert!(matches!(
        Ensemble::new(&particle, 0.0),
        Err(SetupError::Step { .. })
    ));
    let broken = Particle {
        mass: f64::NAN,
        curvature: 1.0,
    };
    assert!(matches!(
        Ensemble::new(&broken, 0.1),
        Err(SetupError::Parameter { name, .. }) if name == "mass"
    ));
    let ensemble = Ensemble::new(&particle, 0.1).unwrap();
    assert!(ensemble.to(1.0).is_empty());
    let starts = [
        Start::paper([0.0, 0.0], [1.0, f64::NAN]),
        Start::paper([0.0, 0.0], [1.0, 0.0]),
        Start::paper([0.0, 0.0], [0.0, 0.0]),
    ];
    let ensemble = ensemble.starts(starts);
    let ended = ensemble.to(1.0);
    assert!(matches!(
        &ended[0],
        Err(RunError::Setup(error)) if matches!(**error, SetupError::Start { .. })
    ));
    assert!(matches!(&ended[1], Ok(node) if node.index == 10));
    assert!(matches!(ended[2], Err(RunError::Step(_))));
    for t in [f64::INFINITY, f64::NAN] {
        assert!(matches!(ensemble.to(t)[1], Err(RunError::Until { .. })));
    }
    assert!(matches!(ensemble.to(-1.0)[1], Err(RunError::TimeBehind { .. })));
}

#[test]
fn progress_is_told() {
    let particle = Particle::default();
    let told = Mutex::new(Vec::new());
    let progress = |finished| told.lock().unwrap().push(finished);
    let ensemble = Ensemble::new(&particle, 0.1)
        .unwrap()
        .starts(particles(19))
        .progress(&progress);
    assert_eq!(ensemble.to(1.0).len(), 19);
    drop(ensemble);
    let mut told = told.into_inner().unwrap();
    told.sort_unstable();
    assert_eq!(told.last(), Some(&19));
    assert_eq!(told.len(), 3);
}
