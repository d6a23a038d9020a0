//! Runs forward and back: the distance from the start.

use dsocs_core::{Flow, Start, Stepper, System};

use super::{Bar, Measured, Report, distance, larger};
use crate::experiment::pendulum::{Q0, V0};
use crate::particle::CurvedParticle;
use crate::pendulum::InertiaWheelPendulum;

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    // Each step changes the length of the leg by a relative rounding ε |e|/|d|, and with it the angle α of a
    // turn. The angle makes a random walk, and the direction is its sum: after N steps it is off by N^1.5 α ε
    // |e|/|d|. With α = |e|/|d| = 0.14 at h = 0.1 this is 1e-10; with h = 0.01 it is smaller.
    for (h, bar) in [(0.1, 1e-10), (0.01, 1e-11)] {
        report.measure(
            format!("particle, h = {h}, 1e5 steps and back: distance from the start [m]"),
            Bar::AtMost(bar),
            || {
                there_and_back(
                    &CurvedParticle::default(),
                    h,
                    Start::second_order([0.0; 2], [1.0; 2]),
                    100_000,
                )
            },
        );
    }
    let pendulum = InertiaWheelPendulum::default();
    for (h, steps) in [(0.1, 300), (0.01, 3000)] {
        report.measure(
            format!("pendulum, h = {h}, {steps} steps while |w| > 20 (nothing is damped) and back [rad]"),
            Bar::AtMost(1e-9),
            || there_and_back(&pendulum, h, Start::second_order(Q0, V0), steps),
        );
    }
    report.measure(
        "pendulum, h = 0.1: steps and back after which the start is still met to 1e-3 (of 1e5)",
        Bar::AtLeast(500.0),
        || {
            let mut good = 0.0;
            for steps in (0..17).map(|k| 100_000 >> k).rev() {
                let back = there_and_back(&pendulum, 0.1, Start::second_order(Q0, V0), steps);
                match back {
                    Ok(distance) if distance <= 1e-3 => good = f64::from(steps),
                    _ => break,
                }
            }
            Ok(good)
        },
    );
}

/// Runs forward and back, and returns the largest distance of the first two nodes from their first values.
fn there_and_back<S: System<2>>(system: &S, h: f64, start: Start<2>, steps: u32) -> Measured {
    let mut flow = Flow::new(system, h, start)?;
    let (second, leg) = (*flow.position(), flow.leg());
    let first = [second[0] - leg.d[0], second[1] - leg.d[1]];
    for _ in 0..steps {
        flow.advance()?;
    }
    // the first step back
    flow.reverse()?;
    for _ in 1..steps {
        flow.advance()?;
    }
    let (last, leg) = (*flow.position(), flow.leg());
    let before = [last[0] - leg.d[0], last[1] - leg.d[1]];
    Ok(larger(distance(&last, &first), distance(&before, &second)))
}
