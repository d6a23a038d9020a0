//! The continuous motion of the pendulum to nearly all digits. Errors of its discrete motion are measured against it.

use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{RunError, Start, Stepper};
use thiserror::Error;

use crate::pendulum::InertiaWheelPendulum;

/// The tolerance of a step. Against the 200-bit reference over the paper's time, `θ` is accurate to 2e-13,
/// `ψ` to 5e-11 and `V(2000)` to 1e-9; the remaining error is rounding.
const TOLERANCE: f64 = 1e-16;

/// The continuous motion could not be computed.
#[derive(Clone, Error)]
#[error("the continuous pendulum cannot be integrated beyond t = {time}: {cause}")]
pub struct ReferenceError {
    /// The time that was reached, in s.
    pub time: f64,
    /// The cause.
    #[source]
    pub cause: RunError,
}

dsocs_core::debug_is_message!(ReferenceError);

/// A motion of the continuous pendulum on its proper branch, at equal intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The interval between two states, in s.
    pub interval: f64,
    /// The states `(θ, ψ, p₁, p₂)` from the start on, in rad and kg m²/s.
    pub states: Vec<[f64; 4]>,
}

impl Reference {
    /// Follows the continuous system from `(q0, v0)` over a number of intervals by Taylor series of the declaration.
    ///
    /// # Errors
    ///
    /// [`ReferenceError`] if the motion cannot be computed to its end.
    pub fn new(
        pendulum: &InertiaWheelPendulum,
        q0: [f64; 2],
        v0: [f64; 2],
        interval: f64,
        intervals: usize,
    ) -> Result<Self, ReferenceError> {
        let failed = |time| move |cause: RunError| ReferenceError { time, cause };
        let mut flow = TaylorFlow::new(
            pendulum,
            Start::second_order(q0, v0),
            Tolerance::relative(TOLERANCE),
        )
        .map_err(|error| failed(0.0)(error.into()))?;
        let times: Vec<f64> = (0..=intervals).map(|k| k as f64 * interval).collect();
        let mut states = Vec::with_capacity(times.len());
        let result = flow.sample(&times, &mut |_, point| {
            let [p1, p2] = pendulum.momentum(point.v);
            states.push([point.q[0], point.q[1], p1, p2]);
        });
        result.map_err(failed(flow.time()))?;
        Ok(Self { interval, states })
    }

    /// The Lyapunov function, in J, in state number `index`, `None` beyond the last.
    #[must_use]
    pub fn lyapunov(&self, pendulum: &InertiaWheelPendulum, index: usize) -> Option<f64> {
        let &[theta, psi, p1, p2] = self.states.get(index)?;
        Some(pendulum.lyapunov([theta, psi], pendulum.velocity([p1, p2])))
    }
}
