//! What a candidate's solution costs, and how far it is from the truth.

use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, SamplingMode};

use crate::candidate::Candidate;
use crate::dsocs::TAYLOR;

/// One point of a curve.
#[derive(Clone, Debug)]
pub struct Point {
    /// The problem's name.
    pub problem: &'static str,
    /// The solver's name.
    pub solver: &'static str,
    /// What was varied.
    pub setting: String,
    /// The largest error of a measured component on the grid.
    pub max_error: f64,
    /// The median time of a whole solution with its output, in s.
    pub seconds: f64,
}

/// How long it may all take.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Solutions that take longer are left out, with all finer settings of the same solver.
    pub longest: Duration,
    /// How long a candidate is measured.
    pub measured: Duration,
    /// Of so many candidates one is measured.
    pub every: usize,
}

/// The most components that are measured.
const ROW: usize = 8;

/// What solutions are compared with.
pub struct Reference {
    /// The measured components at every time of the grid, not from our Taylor series.
    pub independent: Vec<f64>,
    /// The same from our Taylor series, for all other solvers, or again the independent ones.
    pub ours: Vec<f64>,
}

impl Reference {
    /// The largest difference of the two.
    pub fn difference(&self) -> f64 {
        distance(&self.independent, &self.ours)
    }
}

/// The largest difference of two solutions, infinite if the first ends early: only its last time may be missing, of up to
/// [`ROW`] components.
fn distance(left: &[f64], right: &[f64]) -> f64 {
    if left.len() > right.len() || left.len() + ROW < right.len() {
        return f64::INFINITY;
    }
    let difference = |(left, right): (&f64, &f64)| (left - right).abs();
    let larger = |a: f64, b: f64| if b <= a { a } else { b };
    left.iter().zip(right).map(difference).fold(0.0, larger)
}

/// Measures the candidates of one solver, from the coarsest setting on, until they take too long.
pub fn sweep(
    criterion: &mut Criterion,
    effort: Effort,
    problem: &'static str,
    reference: &Reference,
    candidates: impl Iterator<Item = Candidate>,
) -> Vec<Point> {
    let mut points = Vec::new();
    let mut group = criterion.benchmark_group(problem);
    group
        .sample_size(10)
        .sampling_mode(SamplingMode::Flat)
        .warm_up_time(effort.measured / 4)
        .measurement_time(effort.measured);
    for candidate in candidates.step_by(effort.every) {
        let mut out = Vec::with_capacity(reference.ours.len());
        let start = Instant::now();
        let solved = (candidate.run)(&mut out);
        let once = start.elapsed();
        let truth = if candidate.solver.starts_with(TAYLOR) {
            &reference.independent
        } else {
            &reference.ours
        };
        let max_error = distance(&out, truth);
        if once > effort.longest {
            break;
        }
        if !solved || !max_error.is_finite() {
            continue;
        }
        let mut times = Vec::new();
        group.bench_function(
            BenchmarkId::new(candidate.solver, &candidate.setting),
            |bencher| {
                bencher.iter_custom(|iterations| {
                    let start = Instant::now();
                    for _ in 0..iterations {
                        out.clear();
                        std::hint::black_box((candidate.run)(&mut out));
                    }
                    let elapsed = start.elapsed();
                    times.push(elapsed.as_secs_f64() / iterations as f64);
                    elapsed
                });
            },
        );
        // the last ten are the samples, those before warmed up
        let mut samples = times.split_off(times.len().saturating_sub(10));
        samples.sort_by(f64::total_cmp);
        points.push(Point {
            problem,
            solver: candidate.solver,
            setting: candidate.setting,
            max_error,
            seconds: f64::midpoint(samples[(samples.len() - 1) / 2], samples[samples.len() / 2]),
        });
    }
    group.finish();
    points
}
