//! The pendulum with a steep dissipation, `ρ tanh w` with `ρ` up to 2000, which steps of up to half a second
//! cross.

use std::error::Error;

use dsocs_core::{Flow, Node, Start, Stepper};

use super::{Bar, Report, larger};
use crate::experiment::pendulum::{Q0, V0};
use crate::pendulum::InertiaWheelPendulum;

/// The results of one run.
#[derive(Default)]
struct Run {
    /// The largest residual of the factored equation, relative to its terms.
    residual: f64,
    /// The largest number of evaluations in a step.
    most: u32,
    /// All evaluations.
    evaluations: u64,
    /// Steps.
    steps: u64,
    /// Steps refused with a typed error.
    refused: u64,
}

/// The residual of `J(θ''+ψ'') = T − ρ tanh w` at a node, relative to the terms and to the rounding of `w`,
/// which the switch magnifies.
pub fn residual(pendulum: &InertiaWheelPendulum, node: &Node<2>) -> f64 {
    let [p1, p2] = pendulum.momentum(node.v);
    let rate = pendulum.proper_branch([node.q[0], node.q[1], p1, p2])[3];
    let found = pendulum.j * (node.a[0] + node.a[1]);
    let slope = pendulum.rho / pendulum.factor(node.q, node.v).cosh().powi(2);
    let terms = pendulum.j * (node.a[0].abs() + node.a[1].abs())
        + pendulum.rho
        + rate.abs()
        + slope * 1e3 * (p1.abs() + p2.abs());
    (found - rate).abs() / terms
}

/// Runs up to `until`, or to the first step that is refused.
fn run_one(rho: f64, h: f64, until: f64, run: &mut Run) -> Result<(), Box<dyn Error>> {
    let pendulum = InertiaWheelPendulum {
        rho,
        ..InertiaWheelPendulum::default()
    };
    let mut flow = Flow::new(&pendulum, h, Start::second_order(Q0, V0))?;
    while flow.time() < until {
        let Ok(report) = flow.advance() else {
            run.refused += 1;
            break;
        };
        run.most = run.most.max(report.iterations);
        run.evaluations += u64::from(report.iterations);
        run.steps += 1;
        let node = flow.node();
        run.residual = larger(run.residual, residual(&pendulum, &node));
    }
    Ok(())
}

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    let (until, finest) = if report.quick { (20.0, 1e-2) } else { (500.0, 1e-3) };
    for rho in [2.0, 20.0, 200.0, 2000.0] {
        let names = [
            (
                format!("pendulum, ρ = {rho}, h = {finest} … 0.5: residual relative to its terms"),
                Bar::AtMost(1e-12),
            ),
            ("the same: steps refused".to_owned(), Bar::AtMost(0.0)),
            ("the same: most evaluations in a step".to_owned(), Bar::Reported),
            ("the same: evaluations a step".to_owned(), Bar::Reported),
        ];
        report.measure_all(names, || {
            let mut all = Run::default();
            for h in [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.2, 0.3, 0.5] {
                if h >= finest {
                    run_one(rho, h, until, &mut all)?;
                }
            }
            Ok([
                all.residual,
                all.refused as f64,
                f64::from(all.most),
                all.evaluations as f64 / all.steps as f64,
            ])
        });
    }
}
