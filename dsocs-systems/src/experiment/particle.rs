//! The particle with unit curvature over [0, 500] (paper, section 5.1).

use dsocs_core::{Flow, Node, Stepper};
use rayon::prelude::*;

use super::{ErrorRow, ExperimentError, StartRule, max_error, steps};
use crate::particle::{Constant, CurvedParticle};

/// The first node, in m.
pub const Q0: [f64; 2] = [0.0, 0.0];
/// The initial velocity, in m/s.
pub const V0: [f64; 2] = [1.0, 1.0];
/// The end of the runs, in s.
pub const UNTIL: f64 = 500.0;
/// The steps of the error table, in s.
pub const STEPS: [f64; 7] = [0.1, 0.05, 0.02, 0.01, 0.005, 0.0025, 0.001];
/// The step of the motion that is shown, in s.
pub const SHOWN_STEP: f64 = 0.1;

/// The largest error of `x` over all nodes in [0, 500], for every step and both starts, in this order.
///
/// `done` is called after every run.
///
/// # Errors
///
/// [`ExperimentError`] if a step has no solution.
pub fn errors(done: impl Fn() + Sync) -> Result<Vec<ErrorRow>, ExperimentError> {
    let particle = CurvedParticle::default();
    let runs: Vec<_> = STEPS
        .iter()
        .flat_map(|&h| StartRule::ALL.map(|start| (h, start)))
        .collect();
    let run = |&(h, start): &(f64, StartRule)| {
        let flow = Flow::new(&particle, h, start.start(Q0, V0))?;
        let max_error = max_error(flow, 1, steps(UNTIL, h), |_, t, q| {
            (q[0] - exact(&particle, t)[0]).abs()
        })?;
        done();
        Ok(ErrorRow { h, start, max_error })
    };
    runs.par_iter().with_max_len(1).map(run).collect()
}

/// The nodes of the motion that is shown: step 0.1, paper start.
///
/// # Errors
///
/// [`ExperimentError`] if a step has no solution.
pub fn motion() -> Result<Vec<Node<2>>, ExperimentError> {
    let particle = CurvedParticle::default();
    let mut flow = Flow::new(&particle, SHOWN_STEP, StartRule::Paper.start(Q0, V0))?;
    Ok(flow.until(UNTIL).map_err(|failure| failure.error)?.nodes)
}

/// The exact position at time `t`.
#[must_use]
pub fn exact(particle: &CurvedParticle<Constant>, t: f64) -> [f64; 2] {
    particle.exact(Q0, V0, t).0
}
