//! The inertia wheel pendulum over [0, 2000] (paper, section 5.2).

use dsocs_core::{Flow, Node, Stepper};
use rayon::prelude::*;

use super::{ErrorRow, ExperimentError, StartRule, max_error, steps};
use crate::pendulum::InertiaWheelPendulum;
use crate::reference::Reference;

/// The first node, in rad.
pub const Q0: [f64; 2] = [0.5, 0.0];
/// The initial velocity, in rad/s.
pub const V0: [f64; 2] = [0.0, 0.5];
/// The end of the runs, in s.
pub const UNTIL: f64 = 2000.0;
/// The steps of the error table, in s.
pub const STEPS: [f64; 5] = [0.1, 0.05, 0.025, 0.0125, 0.00625];
/// Smaller steps, in s. Their errors explain the paper's slope of 1.3. They are not part of the figure.
pub const FURTHER_STEPS: [f64; 2] = [0.003_125, 0.001_562_5];
/// The step of the motion that is shown, in s.
pub const SHOWN_STEP: f64 = 0.1;
/// The times at which errors are taken are multiples of this, in s; every step divides it.
pub const INTERVAL: f64 = 0.1;

/// One node of the motion that is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time, in s.
    pub t: f64,
    /// The pendulum's angle, in rad.
    pub theta: f64,
    /// The wheel's angle, in rad.
    pub psi: f64,
    /// The Lyapunov function at `φ_D⁻¹`, in J.
    pub lyapunov: f64,
    /// The control torque: the constraint force on the wheel, in N m.
    pub torque: f64,
}

/// The continuous motion at multiples of 0.1 in [0, 2000].
///
/// # Errors
///
/// [`ExperimentError`] if the solver gives up.
pub fn reference() -> Result<Reference, ExperimentError> {
    #[allow(clippy::cast_possible_truncation)] // 20000
    let intervals = steps(UNTIL, INTERVAL) as usize;
    Ok(Reference::new(
        &InertiaWheelPendulum::default(),
        Q0,
        V0,
        INTERVAL,
        intervals,
    )?)
}

/// The largest error of `θ` over the multiples of 0.1 in [0, 2000], for every step and both starts, in this order.
///
/// `done` is called after every run.
///
/// # Errors
///
/// [`ExperimentError`] if a step has no solution.
pub fn errors(reference: &Reference, done: impl Fn() + Sync) -> Result<Vec<ErrorRow>, ExperimentError> {
    errors_at(&STEPS, reference, done)
}

/// As [`errors`], for other steps, each of which has to divide [`INTERVAL`].
///
/// # Errors
///
/// [`ExperimentError`] if a step has no solution.
pub fn errors_at(
    hs: &[f64],
    reference: &Reference,
    done: impl Fn() + Sync,
) -> Result<Vec<ErrorRow>, ExperimentError> {
    let pendulum = InertiaWheelPendulum::default();
    let runs: Vec<_> = hs
        .iter()
        .flat_map(|&h| StartRule::ALL.map(|start| (h, start)))
        .collect();
    let run = |&(h, start): &(f64, StartRule)| {
        let flow = Flow::new(&pendulum, h, start.start(Q0, V0))?;
        let stride = steps(INTERVAL, h);
        let max_error = max_error(flow, stride, steps(UNTIL, h), |k, _, q| {
            let state = usize::try_from(k / stride)
                .ok()
                .and_then(|index| reference.states.get(index));
            state.map_or(f64::NAN, |state| (q[0] - state[0]).abs())
        })?;
        done();
        Ok(ErrorRow { h, start, max_error })
    };
    runs.par_iter().with_max_len(1).map(run).collect()
}

/// The motion that is shown: step 0.1, paper start, with the Lyapunov function and the control torque.
///
/// # Errors
///
/// [`ExperimentError`] if a step has no solution.
pub fn motion() -> Result<Vec<Moment>, ExperimentError> {
    let pendulum = InertiaWheelPendulum::default();
    let mut flow = Flow::new(&pendulum, SHOWN_STEP, StartRule::Paper.start(Q0, V0))?;
    let mut moments = Vec::new();
    flow.stream(UNTIL, &mut |node: &Node<2>| {
        moments.push(Moment {
            t: node.t,
            theta: node.q[0],
            psi: node.q[1],
            lyapunov: pendulum.lyapunov(node.q, node.v),
            torque: node.force[1],
        });
    })?;
    Ok(moments)
}
