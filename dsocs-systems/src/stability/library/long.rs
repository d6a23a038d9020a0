//! Long runs: ten million steps of the particle, 400 000 of the pendulum.

use std::error::Error;

use dsocs_core::geometry::discrete_lagrangian;
use dsocs_core::{Flow, Start, Stepper};

use super::switch::residual;
use super::{Bar, Measured, Report, distance, larger};
use crate::experiment::pendulum::{Q0, V0};
use crate::particle::CurvedParticle;
use crate::pendulum::InertiaWheelPendulum;

/// The particle's step, in s.
const H: f64 = 0.1;

/// Nodes of the exact discrete motion from the chord (0.1, 0.1) (as doubles), in 300-bit arithmetic.
const POLYGON: [(u64, [f64; 2]); 5] = [
    (1_000, [-8.396_857_662_595_683e-1, 1.747_437_635_765_698_7]),
    (10_000, [3.423_371_306_256_898e-1, 8.458_826_671_637_542e-1]),
    (100_000, [-1.318_000_299_298_889, 1.517_490_055_289_209_2]),
    (1_000_000, [2.726_863_930_959_822e-3, 2.376_148_130_760_18e-3]),
    (10_000_000, [2.687_881_666_235_834e-2, 2.419_867_996_899_282e-2]),
];

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    let steps = if report.quick { 1_000_000 } else { 10_000_000 };
    let members = if report.quick { 8 } else { 16 };
    let names = [
        (
            format!("particle, h = 0.1, {steps:e} steps: largest relative drift of L_d"),
            Bar::AtMost(1e-13),
        ),
        (
            format!("the same from {members} starts: root of the mean square of the drift at the end"),
            Bar::AtMost(1e-13),
        ),
        ("the same: largest of all".to_owned(), Bar::Reported),
        (
            "the same: exponent of the drift's growth with time (1/2 by Brouwer's law, fitted to ±0.05)"
                .to_owned(),
            Bar::AtMost(0.6),
        ),
    ];
    report.measure_all(names, || drift(steps, members));
    report.measure(
        format!("particle, h = 0.1, {steps:e} steps: distance from the exact discrete polygon [m]"),
        Bar::Reported,
        || polygon(steps),
    );
    let (until, bar) = if report.quick {
        (2000.0, None)
    } else {
        (40_000.0, Some(1.032_067_9))
    };
    pendulum(report, until, bar);
}

/// The relative drift of `L_d`: the largest from the paper's start, the mean and the largest over some
/// starts, and the exponent of its growth with the number of steps.
fn drift(steps: u64, members: u32) -> Result<[f64; 4], Box<dyn Error>> {
    let particle = CurvedParticle::default();
    let marks: Vec<u64> = (0..40)
        .map(|k| 1000_u64 << k)
        .take_while(|&mark| mark <= steps)
        .chain([steps])
        .collect();
    let mut squares = vec![0.0; marks.len()];
    let (mut first_worst, mut worst) = (0.0, 0.0);
    for member in 0..members {
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 + f64::from(member)).sin_cos();
        let v = 2.0_f64.sqrt();
        let mut flow = Flow::new(&particle, H, Start::second_order([0.0, 0.0], [v * cos, v * sin]))?;
        let first = discrete_lagrangian(&particle, H, flow.leg().any());
        let mut marks = marks.iter().zip(&mut squares).peekable();
        for step in 1..=steps {
            flow.advance()?;
            if let Some((_, square)) = marks.next_if(|(mark, _)| **mark == step) {
                let change = discrete_lagrangian(&particle, H, flow.leg().any()) / first - 1.0;
                worst = larger(worst, change.abs());
                if member == 0 {
                    first_worst = worst;
                }
                *square += change * change / f64::from(members);
            }
        }
    }
    // by least squares through the logarithms
    let points: Vec<(f64, f64)> = marks
        .iter()
        .zip(&squares)
        .map(|(&mark, square)| ((mark as f64).ln(), 0.5 * square.ln()))
        .collect();
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let above: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let below: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    let end = squares.last().copied().unwrap_or(f64::NAN).sqrt();
    Ok([first_worst, end, worst, above / below])
}

/// The largest distance from the exact polygon.
fn polygon(steps: u64) -> Measured {
    let particle = CurvedParticle::default();
    let mut flow = Flow::new(&particle, H, Start::nodes([0.0, 0.0], [H, H]))?;
    let mut worst = 0.0;
    for (k, node) in POLYGON {
        if k > steps {
            break;
        }
        while flow.index() < k {
            flow.advance()?;
        }
        worst = larger(worst, distance(flow.position(), &node));
    }
    Ok(worst)
}

/// Whether the pendulum stays on its proper branch, and the value of `V` at the end.
fn pendulum(report: &mut Report<'_>, until: f64, end: Option<f64>) {
    let names = [
        (
            format!("pendulum to t = {until}: steps on the spurious branch"),
            Bar::AtMost(0.0),
        ),
        (
            "the same: largest |J(θ''+ψ'') − T + ρ tanh w| relative to its terms".to_owned(),
            Bar::AtMost(1e-12),
        ),
    ];
    let mut value = f64::NAN;
    report.measure_all(names, || {
        let (figures, last) = branch(until, 0.1)?;
        value = last;
        Ok(figures)
    });
    let Some(end) = end else { return };
    report.measure_all(
        [
            (
                "pendulum, V(40000) against 1.0320679, h = 0.1 [J]".to_owned(),
                Bar::Reported,
            ),
            ("the same, h = 0.05 [J]".to_owned(), Bar::Reported),
            (
                "order 2: part of the error at h = 0.1 that is left at h = 0.05 (1/4)".to_owned(),
                Bar::AtMost(0.3),
            ),
        ],
        || {
            let (_, half) = branch(until, 0.05)?;
            let errors = [value, half].map(|value| (value - end).abs());
            Ok([errors[0], errors[1], errors[1] / errors[0]])
        },
    );
}

/// The number of steps on the spurious branch and the largest residual of the proper one; and `V` at the end.
///
/// A step is on the spurious branch if its `w` vanishes to within rounding although the proper root's does not.
fn branch(until: f64, h: f64) -> Result<([f64; 2], f64), Box<dyn Error>> {
    let pendulum = InertiaWheelPendulum::default();
    let mut flow = Flow::new(&pendulum, h, Start::second_order(Q0, V0))?;
    let (mut spurious, mut worst, mut value) = (0, 0.0, f64::NAN);
    while flow.time() <= until {
        flow.advance()?;
        let node = flow.node();
        let residual = residual(&pendulum, &node);
        let w = pendulum.factor(node.q, node.v);
        worst = larger(worst, residual);
        // on the spurious branch the residual of the proper one is far from zero, and w is zero to rounding
        if residual > 1e-6 && w.abs() < 1e-6 {
            spurious += 1;
        }
        value = pendulum.lyapunov(node.q, node.v);
    }
    Ok(([f64::from(spurious), worst], value))
}
