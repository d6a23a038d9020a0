//! The estimated error of a run agrees with its true error to a factor of 1.5, wherever this is above
//! rounding: for both systems of the paper, by four methods, against data from outside this workspace.

use dsocs_core::taylor::{GlobalError, Motion, Tolerance};
use dsocs_core::{ComposedFlow, Composition, RunError, Start, Stepper, System};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum};
use dsocs_tests::closed_form;
use dsocs_tests::closed_form::pendulum::START;
use dsocs_tests::data::Table;
use dsocs_tests::short_or_long;

/// Errors of the coordinates that are rounding, of the runs or of the reference.
type Rounding = [f64; 2];

/// Counts all estimates, and those within a factor of 3 of the error; `worst` is the largest factor.
#[derive(Clone, Copy, Debug)]
struct Score {
    within: u32,
    all: u32,
    worst: f64,
}

impl Score {
    const NONE: Self = Self {
        within: 0,
        all: 0,
        worst: 1.0,
    };

    fn count(&mut self, estimate: f64, error: f64) {
        let factor = (estimate / error).max(error / estimate);
        self.all += 1;
        self.within += u32::from(factor <= 3.0);
        self.worst = self.worst.max(factor);
    }
}

/// Positions at the whole seconds.
fn positions<S: System<2>>(
    system: &S,
    method: Composition,
    parts: u32,
    start: ([f64; 2], [f64; 2]),
    seconds: usize,
) -> Vec<[f64; 2]> {
    let mut flow = ComposedFlow::new(
        system,
        f64::from(parts).recip(),
        method,
        Start::second_order(start.0, start.1),
    )
    .unwrap();
    let mut positions = Vec::new();
    for _ in 0..seconds {
        for _ in 0..parts {
            flow.advance().unwrap();
        }
        positions.push(flow.position());
    }
    positions
}

/// The scores of the estimate by the Taylor flow, and of Richardson's estimate from the run with half the
/// step.
fn scores<S: System<2>>(
    system: &S,
    method: Composition,
    parts: u32,
    start: ([f64; 2], [f64; 2]),
    truth: &[[f64; 2]],
    rounding: Rounding,
) -> [Score; 2] {
    let coarse = positions(system, method, parts, start, truth.len());
    let fine = positions(system, method, 2 * parts, start, truth.len());
    let state = Start::second_order(start.0, start.1);
    let mut error = GlobalError::new(system, state, truth.len() as f64).unwrap();
    let mut scores = [Score::NONE; 2];
    let gain = 2.0_f64.powi(i32::try_from(method.order()).unwrap());
    for (k, ((coarse, fine), truth)) in coarse.iter().zip(&fine).zip(truth).enumerate() {
        let estimate = error.at((k + 1) as f64, coarse).unwrap();
        for i in 0..2 {
            let error = (coarse[i] - truth[i]).abs();
            if error > rounding[i] {
                let richardson = (coarse[i] - fine[i]).abs() * gain / (gain - 1.0);
                scores[0].count(estimate[i], error);
                scores[1].count(richardson, error);
            }
        }
    }
    assert!(
        error.uncertainty() < rounding[0].max(rounding[1]),
        "{:e}",
        error.uncertainty()
    );
    println!(
        "{method}, {parts} steps a second: Taylor {}/{} within a factor 3, at worst {:.3}; Richardson {}/{}, at worst {:.1e}",
        scores[0].within, scores[0].all, scores[0].worst, scores[1].within, scores[1].all, scores[1].worst
    );
    scores
}

const RUNS: [(Composition, [u32; 3]); 4] = [
    (Composition::SINGLE, [5, 10, 100]),
    (Composition::SUZUKI_4, [5, 10, 40]),
    (Composition::KAHAN_LI_6, [5, 10, 20]),
    (Composition::KAHAN_LI_8, [5, 8, 10]),
];

fn all_runs<S: System<2>>(
    system: &S,
    start: ([f64; 2], [f64; 2]),
    truth: &[[f64; 2]],
    rounding: Rounding,
    sizes: usize,
) -> [u32; 3] {
    let mut totals = [0; 3];
    for (method, parts) in RUNS {
        for parts in parts.into_iter().take(sizes) {
            let [taylor, richardson] = scores(system, method, parts, start, truth, rounding);
            assert!(taylor.all > 0 && taylor.worst < 1.5, "{method}: {taylor:?}");
            totals[0] += taylor.within;
            totals[1] += richardson.within;
            totals[2] += taylor.all;
        }
    }
    println!(
        "in all: Taylor {}, Richardson {}, of {}",
        totals[0], totals[1], totals[2]
    );
    totals
}

#[test]
fn of_the_particle_over_the_papers_time() {
    let truth: Vec<_> = (1..=500).map(|t| closed_form::particle(f64::from(t))).collect();
    let start = ([0.0, 0.0], [1.0, 1.0]);
    let [taylor, richardson, all] = all_runs(&CurvedParticle::default(), start, &truth, [5e-12; 2], 3);
    assert!(taylor == all && richardson < all);
}

#[test]
fn of_the_pendulum_over_the_papers_time() {
    // the smallest steps take long
    let sizes = short_or_long(2, 3);
    let table = Table::read("pendulum_continuous_every1.csv");
    let truth = &table.pairs(["theta", "psi"])[1..];
    let rounding = [2e-12, 5e-10];
    let [taylor, richardson, all] = all_runs(&InertiaWheelPendulum::default(), START, truth, rounding, sizes);
    assert!(taylor == all && richardson < all);
}

#[test]
fn a_motion_is_asked_in_order() {
    let pendulum = InertiaWheelPendulum::default();
    let state = Start::second_order(START.0, START.1);
    let mut motion = Motion::new(&pendulum, state, 10.0, Tolerance::relative(1e-12)).unwrap();
    assert!((motion.at(0.0).unwrap().q[0] - START.0[0]).abs() == 0.0);
    let [first, again] = [motion.at(5.0).unwrap(), motion.at(5.0).unwrap()];
    assert_eq!(first, again);
    assert!(motion.at(10.0).is_ok());
    assert!(matches!(motion.at(0.5), Err(RunError::TimeBehind { .. })));
    assert!(matches!(motion.at(11.0), Err(RunError::Until { .. })));
    // the acceleration solves the equations
    let rows = dsocs_core::__private::Declaration::of(&pendulum).continuous(first.any(), &[]);
    assert!(rows.iter().all(|row| row.abs() < 1e-7), "{rows:?}");
    let mut back = Motion::new(&pendulum, state, -1.0, Tolerance::relative(1e-12)).unwrap();
    assert!(back.at(-0.5).is_ok() && back.at(-1.0).is_ok());
}
