//! Comparison with a published Runge–Kutta method of order 8(5,3) (`ode_solvers`, `Dop853`) on the continuous
//! equations of the same motions. The figures of that method need the feature `peers`.

#[cfg(feature = "peers")]
mod dop853;

use std::time::Instant;

use dsocs_core::{Flow, Start, Stepper};

use super::{Bar, Report};
use crate::particle::CurvedParticle;

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    let until = if report.quick { 1e4 } else { 1e6 };
    #[cfg(feature = "peers")]
    dop853::particle(report, until);
    report.measure_all(
        [
            (
                format!("particle to t = {until:e}, h = 0.1: relative drift of the energy"),
                Bar::AtMost(1e-13),
            ),
            ("the same: time [s]".to_owned(), Bar::Reported),
        ],
        || {
            let begun = Instant::now();
            let particle = CurvedParticle::default();
            let mut flow = Flow::new(&particle, 0.1, Start::second_order([0.0; 2], [1.0; 2]))?;
            let first = flow.leg().d;
            while flow.time() < until {
                flow.advance()?;
            }
            let last = flow.leg().d;
            let square = |d: [f64; 2]| d[0] * d[0] + d[1] * d[1];
            Ok([
                (square(last) / square(first) - 1.0).abs(),
                begun.elapsed().as_secs_f64(),
            ])
        },
    );
    #[cfg(feature = "peers")]
    dop853::pendulum(report);
}
