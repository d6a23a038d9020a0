//! Steps down to a millionth of a second.

use std::error::Error;

use dsocs_core::{Flow, Start, Stepper};

use super::{Bar, Report, distance, larger};
use crate::experiment::particle::exact;
use crate::experiment::pendulum::{Q0, V0};
use crate::particle::CurvedParticle;
use crate::pendulum::InertiaWheelPendulum;

/// The pendulum's discrete motion with `h = 1e-4` and the paper's start, at every second, in 200-bit
/// arithmetic.
const PENDULUM: &str = include_str!("../../../data/pendulum_discrete_h0.0001.csv");

/// The largest error of the particle's true motion with the second-order start over [0, 500], over `h²`.
const SLOPE: f64 = 117.508_5;

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    let steps: &[f64] = if report.quick {
        &[1e-2, 1e-3, 1e-4]
    } else {
        &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
    };
    for &h in steps {
        let names = [
            (
                format!("particle to t = 500, h = {h:e}: distance from the exact discrete motion [m]"),
                Bar::AtMost(1e-12),
            ),
            (
                "the same: distance from the true motion, over 117.5 h²".to_owned(),
                Bar::AtMost(1.01),
            ),
        ];
        report.measure_all(names, || particle(h));
    }
    let names = [
        (
            "pendulum to t = 50, h = 1e-4: θ against 200-bit arithmetic [rad]".to_owned(),
            Bar::AtMost(1e-11),
        ),
        ("the same: ψ [rad]".to_owned(), Bar::AtMost(2e-9)),
    ];
    report.measure_all(names, pendulum);
}

/// The largest distances of `x` from the discrete motion and from the continuous one, over 5000 nodes.
fn particle(h: f64) -> Result<[f64; 2], Box<dyn Error>> {
    let particle = CurvedParticle::default();
    let mut flow = Flow::new(&particle, h, Start::second_order([0.0, 0.0], [1.0, 1.0]))?;
    let chord = flow.leg().d;
    let length = chord[0].hypot(chord[1]);
    let half = (length / (1.0 + length.hypot(1.0))).asin();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most 10⁵
    let stride = (0.1 / h).round() as u64;
    let (mut discrete, mut continuous) = (0.0, 0.0);
    for mark in 1..=5000 {
        while flow.index() < mark * stride {
            flow.advance()?;
        }
        // the sum of the turned chords, a geometric series
        let angle = (mark * stride) as f64 * half;
        let (sin, cos) = (angle - half).sin_cos();
        let stretch = angle.sin() / half.sin();
        let node = [
            stretch * (cos * chord[0] - sin * chord[1]),
            stretch * (sin * chord[0] + cos * chord[1]),
        ];
        discrete = larger(discrete, distance(flow.position(), &node));
        let x = exact(&particle, flow.time())[0];
        continuous = larger(continuous, (flow.position()[0] - x).abs());
    }
    Ok([discrete, continuous / (SLOPE * h * h)])
}

/// The largest deviations of `θ` and `ψ` from the reference.
fn pendulum() -> Result<[f64; 2], Box<dyn Error>> {
    let pendulum = InertiaWheelPendulum::default();
    let mut flow = Flow::new(&pendulum, 1e-4, Start::paper(Q0, V0))?;
    let mut worst = [0.0; 2];
    for line in PENDULUM.lines().skip(2) {
        let fields: Vec<f64> = line.split(',').map(str::parse).collect::<Result<_, _>>()?;
        let [k, _, theta, psi] = fields[..] else {
            return Err(format!("four numbers expected in {line}").into());
        };
        while (flow.index() as f64) < k {
            flow.advance()?;
        }
        for (worst, (found, wanted)) in worst.iter_mut().zip(flow.position().iter().zip([theta, psi])) {
            *worst = larger(*worst, (found - wanted).abs());
        }
    }
    Ok(worst)
}
