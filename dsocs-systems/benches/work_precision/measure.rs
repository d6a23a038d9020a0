//! The time and the error of a candidate's solution.

use std::time::{Duration, Instant};

use crate::candidate::Candidate;
use crate::dsocs::TAYLOR;

/// One point of a curve.
#[derive(Clone, Debug)]
pub struct Point {
    /// The problem's name.
    pub problem: &'static str,
    /// The solver's name.
    pub solver: &'static str,
    /// The setting, such as `tolerance 1e-6`.
    pub setting: String,
    /// The largest error of a measured component on the grid.
    pub max_error: f64,
    /// The median time of a whole solution with its output, in s.
    pub seconds: f64,
    /// The shortest and the longest of the times, in s.
    pub between: [f64; 2],
}

/// The limits of the measuring time.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Solutions that take longer are left out, with all finer settings of the same solver.
    pub longest: Duration,
    /// The duration of a sample; it has as many solutions as fit into it.
    pub sample: Duration,
    /// The number of samples of each candidate.
    pub rounds: usize,
    /// The interval of the candidates that are measured: 1 for all.
    pub every: usize,
}

/// The largest number of measured components.
const ROW: usize = 8;

/// The solutions with which others are compared.
pub struct Reference {
    /// The measured components at every time of the grid, by a code other than this library's Taylor series.
    pub independent: Vec<f64>,
    /// The measured components by this library's Taylor series, for all other solvers; or the independent
    /// ones again.
    pub ours: Vec<f64>,
}

impl Reference {
    /// The largest difference of the two.
    pub fn difference(&self) -> f64 {
        distance(&self.independent, &self.ours)
    }
}

/// The largest difference of two solutions; infinite if the first ends early, where only its last time, of up
/// to [`ROW`] components, may be missing.
fn distance(left: &[f64], right: &[f64]) -> f64 {
    if left.len() > right.len() || left.len() + ROW < right.len() {
        return f64::INFINITY;
    }
    let difference = |(left, right): (&f64, &f64)| (left - right).abs();
    let larger = |a: f64, b: f64| if b <= a { a } else { b };
    left.iter().zip(right).map(difference).fold(0.0, larger)
}

/// A candidate that is measured.
pub struct Chosen {
    candidate: Candidate,
    max_error: f64,
    /// The number of solutions in a sample.
    solutions: u32,
}

/// Runs the candidates of one solver once each, from the coarsest setting on, until they take too long, and keeps those that solve the
/// problem.
pub fn choose(
    effort: Effort,
    reference: &Reference,
    candidates: impl Iterator<Item = Candidate>,
) -> Vec<Chosen> {
    let mut chosen = Vec::new();
    for candidate in candidates.step_by(effort.every) {
        let mut out = Vec::with_capacity(reference.ours.len());
        let start = Instant::now();
        let solved = (candidate.run)(&mut out);
        let once = match &candidate.clock {
            Some(clock) => Duration::try_from_secs_f64(clock(1)).unwrap_or(Duration::MAX),
            None => start.elapsed(),
        };
        if once > effort.longest {
            break;
        }
        let truth = if candidate.solver.starts_with(TAYLOR) {
            &reference.independent
        } else {
            &reference.ours
        };
        let max_error = distance(&out, truth);
        if !solved || !max_error.is_finite() {
            continue;
        }
        let solutions = effort.sample.as_nanos() / once.as_nanos().max(1);
        chosen.push(Chosen {
            candidate,
            max_error,
            solutions: u32::try_from(solutions).unwrap_or(u32::MAX).max(1),
        });
    }
    chosen
}

/// Measures all chosen candidates of a problem in turn, round by round, so that noise of the machine affects
/// all alike. In a sample all solutions but the first find their code and data in the caches.
pub fn measure(effort: Effort, problem: &'static str, chosen: &[Chosen]) -> Vec<Point> {
    let mut times = vec![Vec::with_capacity(effort.rounds); chosen.len()];
    let mut out = Vec::new();
    for _ in 0..effort.rounds {
        for (times, one) in times.iter_mut().zip(chosen) {
            let time = if let Some(clock) = &one.candidate.clock {
                clock(one.solutions)
            } else {
                let start = Instant::now();
                for _ in 0..one.solutions {
                    out.clear();
                    std::hint::black_box((one.candidate.run)(&mut out));
                }
                start.elapsed().as_secs_f64() / f64::from(one.solutions)
            };
            times.push(time);
        }
    }
    chosen
        .iter()
        .zip(times)
        .map(|(one, mut times)| {
            times.sort_by(f64::total_cmp);
            let last = times.len() - 1;
            Point {
                problem,
                solver: one.candidate.solver,
                setting: one.candidate.setting.clone(),
                max_error: one.max_error,
                seconds: f64::midpoint(times[last / 2], times[times.len() / 2]),
                between: [times[0], times[last]],
            }
        })
        .collect()
}
