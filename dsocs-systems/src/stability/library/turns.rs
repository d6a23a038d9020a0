//! A particle that turns by nearly π in every step, from a start without past: to the left, to the right, and
//! alternating.
//!
//! Legs keep their length `s` and turn by `α` with `sin(α/2) = K/(1 + √(1 + K²))`, `K = κ s`: there is one root for every
//! curvature, and `α` tends to π as `K` grows.

use std::error::Error;

use dsocs_core::{Flow, Real, Start, Stepper};

use super::{Bar, Report, larger};
use crate::particle::{Constant, Curvature, CurvedParticle};

/// The step, in s.
const H: f64 = 0.1;

/// Steps in each run.
const STEPS: u32 = 500;

/// A curvature that changes its sign within a fraction of a step, `size · tanh(slope · x − 0.3)`.
struct Steep {
    /// The slope of the argument, in 1/m.
    slope: f64,
    /// The largest curvature, in 1/m.
    size: f64,
}

impl Curvature for Steep {
    fn at<D: Real>(&self, x: D, _: D) -> D {
        (x * self.slope - 0.3).tanh() * self.size
    }
}

/// The turn of a leg at a curvature, in rad.
fn turn(curvature: f64, length: f64) -> f64 {
    let k = curvature * length;
    2.0 * (k / (1.0 + k.hypot(1.0))).asin()
}

/// The largest error of a turn, in rad, and the mean number of evaluations a step.
///
/// The velocity is the mean of two legs that nearly cancel, which magnifies their rounding by `√K`. Errors
/// are in units of `ε (1 + √K)`.
fn worst<K: Curvature>(curvature: K, k: f64) -> Result<[f64; 2], Box<dyn Error>> {
    let particle = CurvedParticle { mass: 1.0, curvature };
    let mut flow = Flow::new(&particle, H, Start::paper([0.0, 0.0], [1.0, 0.0]))?;
    let (mut worst, mut evaluations) = (0.0, 0);
    for _ in 0..STEPS {
        let before = flow.leg();
        evaluations += flow.advance()?.iterations;
        let (b, a) = (before.d, flow.leg().d);
        let found = (b[0] * a[1] - b[1] * a[0]).atan2(b[0] * a[0] + b[1] * a[1]);
        let curvature = particle.curvature.at(before.q[0], before.q[1]);
        worst = larger(worst, (found - turn(curvature, b[0].hypot(b[1]))).abs());
    }
    let unit = f64::EPSILON * (1.0 + k.sqrt());
    Ok([worst / unit, f64::from(evaluations) / f64::from(STEPS)])
}

/// The largest mean number of evaluations of a step. Without the guess that the path turns as at the step
/// before, it is three times as large where it turns by much.
const EVALUATIONS: f64 = 120.0;

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    for k in [0.1, 1.0, 10.0, 14.0, 100.0, 1e4, 1e6] {
        let name = format!("κ|v|h = ±{k}: error of the turn, per ε(1+√K)");
        let mean = format!("κ|v|h = ±{k}: evaluations a step");
        report.measure_all(
            [(name, Bar::AtMost(8.0)), (mean, Bar::AtMost(EVALUATIONS))],
            || {
                let [left, evaluations] = worst(Constant(k / H), k)?;
                let [right, _] = worst(Constant(-k / H), k)?;
                Ok([larger(left, right), evaluations])
            },
        );
    }
    report.measure("κ = 0: error of the turn, per ε", Bar::AtMost(0.0), || {
        Ok(worst(Constant(0.0), 0.0)?[0])
    });
    for slope in [1.0, 50.0, -50.0] {
        let name = format!("κ|v|h = K tanh({slope} x), K = 0.1 … 1e4: error of the turn, per ε(1+√K)");
        report.measure(name, Bar::AtMost(8.0), || {
            let mut all = 0.0;
            for k in [0.1, 1.0, 10.0, 100.0, 1e4] {
                let size = k / H;
                all = larger(all, worst(Steep { slope, size }, k)?[0]);
            }
            Ok(all)
        });
    }
}
