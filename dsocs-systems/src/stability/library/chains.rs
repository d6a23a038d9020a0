//! Chains that start at rest. Their accelerations span many decades: a pull at the inner end moves the outer
//! one 1e-9 times as much. No unknown is known to more digits than the rounding of the rows allows, and none
//! has to be.

use std::error::Error;
use std::time::Instant;

use dsocs_core::{Flow, RunError, Start, Stepper, System};

use super::{Bar, Report};
use crate::chain::PlanarChain8;

crate::planar_chain! {
    /// A chain of sixteen links.
    struct PlanarChain16; 16
}

/// The steps, in s. With 0.02 the outer link of the bent chain turns by 0.4 rad in a step when it cracks like
/// a whip, and its step has two equally valid solutions; with sixteen links this happens with 0.01.
const STEPS: [f64; 7] = [0.01, 0.005, 0.004, 0.003, 0.002, 0.001, 1e-4];

/// The number of steps of a run.
const COUNT: usize = 400;

/// The results of the runs from one start.
#[derive(Default)]
struct Outcome {
    /// Runs that ended with an error.
    refused: f64,
    /// The most evaluations of one step.
    most: f64,
    /// The times of steps with at most two evaluations, in s.
    usual: Vec<f64>,
    /// The times of steps with three evaluations, in s.
    three: Vec<f64>,
}

/// Runs a chain from rest, with each of the steps up to `longest`.
fn run<S: System<N>, const N: usize>(
    chain: &S,
    angles: [f64; N],
    longest: f64,
) -> Result<Outcome, Box<dyn Error>> {
    let mut outcome = Outcome::default();
    for h in STEPS.into_iter().filter(|h| *h <= longest) {
        let mut flow = Flow::new(chain, h, Start::second_order(angles, [0.0; N]))?;
        for _ in 0..COUNT {
            let begun = Instant::now();
            let report = match flow.advance() {
                Ok(report) => report,
                Err(RunError::Step(_)) => {
                    outcome.refused += 1.0;
                    break;
                }
                Err(error) => return Err(error.into()),
            };
            let seconds = begun.elapsed().as_secs_f64();
            outcome.most = outcome.most.max(f64::from(report.iterations));
            match report.iterations {
                0..=2 => outcome.usual.push(seconds),
                3 => outcome.three.push(seconds),
                _ => {}
            }
        }
    }
    Ok(outcome)
}

/// The median; NaN of an empty slice.
fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The figures of one chain; from the bent start with steps up to `longest_bent` only.
fn run_chain<S: System<N>, const N: usize>(chain: &S, longest_bent: f64, report: &mut Report<'_>) {
    let mut bent = [0.0; N];
    bent[0] = 1.0;
    let mut small = [1e-7; N];
    small[N - 1] = -1e-7;
    let starts = [
        ("straight", [1.0; N], STEPS[0]),
        ("the innermost link bent", bent, longest_bent),
        ("nearly hanging", small, STEPS[0]),
    ];
    for (name, angles, longest) in starts {
        report.measure_all(
            [
                (
                    format!("{N} links at rest, {name}, h = 1e-4 … {longest}: runs that are refused"),
                    Bar::AtMost(0.0),
                ),
                (
                    "the same: evaluations of a step, at most".to_owned(),
                    Bar::AtMost(12.0),
                ),
            ],
            || run(chain, angles, longest).map(|outcome| [outcome.refused, outcome.most]),
        );
    }
    report.measure(
        format!("{N} links, straight: time of a step of three evaluations over one of at most two"),
        Bar::AtMost(2.0),
        || {
            let mut outcome = run(chain, [1.0; N], STEPS[0])?;
            Ok(median(&mut outcome.three) / median(&mut outcome.usual))
        },
    );
}

/// Measures the figures of the case.
pub fn run_all(report: &mut Report<'_>) {
    run_chain(&PlanarChain8::default(), STEPS[0], report);
    run_chain(&PlanarChain16::default(), STEPS[1], report);
}
