//! The continuous motion of the pendulum, to nearly all digits: what its discrete motion is measured against.

use ode_solvers::dop_shared::{IntegrationError, OutputType};
use ode_solvers::{Dop853, SVector, System};
use thiserror::Error;

use crate::pendulum::InertiaWheelPendulum;

/// The state `(θ, ψ, p₁, p₂)` as the solver wants it.
type State = SVector<f64, 4>;

/// The solver's relative and absolute tolerance. Against the 200-bit reference over the paper's time, `θ` is good to
/// 5.5e-13, `ψ` to 8.5e-11 and `V(2000)` to 2e-11 (at 1e-13: 2.5e-11, 3.8e-9 and 2e-10); what is left is rounding.
const TOLERANCE: f64 = 1e-15;

/// How many steps one interval may take.
const MAX_STEPS: u32 = 100_000;

/// The continuous motion could not be computed.
#[derive(Clone, Debug, Error)]
#[error("the continuous pendulum cannot be integrated beyond t = {time}: {cause}")]
pub struct ReferenceError {
    /// The time that was reached, in s.
    pub time: f64,
    /// What the solver says.
    pub cause: String,
}

/// A motion of the continuous pendulum on its proper branch, at equal intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The interval between two states, in s.
    pub interval: f64,
    /// The states `(θ, ψ, p₁, p₂)` from the start on, in rad and kg m²/s.
    pub states: Vec<[f64; 4]>,
}

impl Reference {
    /// Integrates the continuous system from `(q0, v0)` over a number of intervals with the Runge–Kutta method of
    /// Dormand and Prince of order 8(5,3).
    ///
    /// Each interval is integrated by itself: its end is then a step's end, which dense output of order 7 between two
    /// steps would not match in accuracy, and its time is exact.
    ///
    /// # Errors
    ///
    /// [`ReferenceError`] if the solver gives up.
    pub fn new(
        pendulum: &InertiaWheelPendulum,
        q0: [f64; 2],
        v0: [f64; 2],
        interval: f64,
        intervals: usize,
    ) -> Result<Self, ReferenceError> {
        let [p1, p2] = pendulum.momentum(v0);
        let mut states = Vec::with_capacity(intervals + 1);
        let mut state = [q0[0], q0[1], p1, p2];
        states.push(state);
        for k in 0..intervals {
            let failed = |cause| ReferenceError {
                time: k as f64 * interval,
                cause,
            };
            state = advance(pendulum, state, interval).map_err(|error| failed(error.to_string()))?;
            if !state.iter().all(|x| x.is_finite()) {
                return Err(failed("the state is not finite".to_owned()));
            }
            states.push(state);
        }
        Ok(Self { interval, states })
    }

    /// The Lyapunov function, in J, in state number `index`, `None` beyond the last.
    #[must_use]
    pub fn lyapunov(&self, pendulum: &InertiaWheelPendulum, index: usize) -> Option<f64> {
        let &[theta, psi, p1, p2] = self.states.get(index)?;
        Some(pendulum.lyapunov([theta, psi], pendulum.velocity([p1, p2])))
    }
}

/// The state one interval later.
fn advance(
    pendulum: &InertiaWheelPendulum,
    state: [f64; 4],
    interval: f64,
) -> Result<[f64; 4], IntegrationError> {
    let mut solver = Dop853::from_param(
        ProperBranch(pendulum),
        0.0,
        interval,
        interval,
        State::from(state),
        TOLERANCE,
        TOLERANCE,
        0.9,   // safety factor
        0.0,   // no PI control
        0.333, // a step may shrink to this part of the last,
        6.0,   // or grow to this multiple
        interval,
        0.0, // let the solver choose its first step
        MAX_STEPS,
        MAX_STEPS, // no test for stiffness
        OutputType::Sparse,
    );
    solver.integrate()?;
    Ok(solver.y_out().last().map_or(state, |&end| end.into()))
}

/// The continuous system as the solver wants it.
struct ProperBranch<'a>(&'a InertiaWheelPendulum);

impl System<f64, State> for ProperBranch<'_> {
    fn system(&self, _: f64, state: &State, rate: &mut State) {
        *rate = self.0.proper_branch((*state).into()).into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_is_accurate() -> Result<(), ReferenceError> {
        let pendulum = InertiaWheelPendulum::default();
        let reference = Reference::new(&pendulum, [0.5, 0.0], [0.0, 0.5], 0.1, 20_000)?;
        let value = reference.lyapunov(&pendulum, 20_000).unwrap_or(f64::NAN);
        // from Taylor series of order 70 in 200-bit arithmetic
        assert!((value - 195.472_779_467_478_1).abs() < 1e-8, "{value}");
        assert!((reference.states[10][0] + 4.421_440_434_001_807_5e-1).abs() < 1e-12);
        assert_eq!(reference.lyapunov(&pendulum, 20_001), None);
        Ok(())
    }
}
