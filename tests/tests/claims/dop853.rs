//! A published Runge–Kutta method of order 8(5,3), for claims that need a motion by other hands.

use ode_solvers::dop_shared::OutputType;
use ode_solvers::{DVector, Dop853, SVector, System};

/// A right-hand side, as `ode_solvers` wants it.
struct Rate<F>(F);

impl<F: Fn(f64, [f64; N]) -> [f64; N], const N: usize> System<f64, SVector<f64, N>> for Rate<F> {
    fn system(&self, t: f64, state: &SVector<f64, N>, rate: &mut SVector<f64, N>) {
        *rate = (self.0)(t, (*state).into()).into();
    }
}

/// The state after a time `end`, from `state` at the time 0.
pub fn integrate<const N: usize>(
    rate: impl Fn(f64, [f64; N]) -> [f64; N],
    state: [f64; N],
    end: f64,
    tolerance: f64,
) -> [f64; N] {
    let mut solver = Dop853::from_param(
        Rate(rate),
        0.0,
        end,
        end,
        state.into(),
        tolerance,
        tolerance,
        0.9,
        0.0,
        0.333,
        6.0,
        end,
        0.0,
        1_000_000,
        1_000_000,
        OutputType::Sparse,
    );
    solver.integrate().unwrap();
    (*solver.y_out().last().unwrap()).into()
}

/// The same, as `ode_solvers` wants it where the time is the last component of the state.
struct Clocked<F, const N: usize>(F);

impl<F: Fn(f64, [f64; N]) -> [f64; N], const N: usize> System<f64, DVector<f64>> for Clocked<F, N> {
    fn system(&self, _: f64, state: &DVector<f64>, rate: &mut DVector<f64>) {
        let parts = core::array::from_fn(|i| state[i]);
        rate.as_mut_slice()[..N].copy_from_slice(&(self.0)(state[N], parts));
        rate[N] = 1.0;
    }
}

/// The state at the time `end` from `state` at the time `t0`, where the right-hand side depends on time.
///
/// The time is integrated along: with the time that `Dop853` itself hands to the right-hand side its error estimates are of a
/// low order, and it takes millions of steps to a tolerance of 1e-13.
pub fn integrate_from<const N: usize>(
    rate: impl Fn(f64, [f64; N]) -> [f64; N],
    (t0, state): (f64, [f64; N]),
    end: f64,
    tolerance: f64,
) -> [f64; N] {
    let clocked = DVector::from_iterator(N + 1, state.into_iter().chain([t0]));
    let span = end - t0;
    let mut solver = Dop853::from_param(
        Clocked(rate),
        0.0,
        span,
        span,
        clocked,
        tolerance,
        tolerance,
        0.9,
        0.0,
        0.333,
        6.0,
        span,
        0.0,
        1_000_000,
        1_000_000,
        OutputType::Sparse,
    );
    solver.integrate().unwrap();
    let last = solver.y_out().last().unwrap();
    core::array::from_fn(|i| last[i])
}
