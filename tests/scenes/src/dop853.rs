//! DOP853, a published Runge–Kutta method of order 8(5,3): the reference for motions that must not depend on
//! this workspace.

use ode_solvers::dop_shared::OutputType;
use ode_solvers::{DVector, Dop853, System};

/// A right-hand side for any number of components, so that the solver, which is large, is compiled once: at a time and a state, it writes the
/// rate to its last argument.
type AnyRate<'f> = dyn Fn(f64, &[f64], &mut [f64]) + 'f;

/// A right-hand side for arrays as one for any number of components.
fn any<const N: usize>(rate: impl Fn(f64, [f64; N]) -> [f64; N]) -> impl Fn(f64, &[f64], &mut [f64]) {
    move |t, state, out| {
        let mut parts = [0.0; N];
        parts.copy_from_slice(state);
        out.copy_from_slice(&rate(t, parts));
    }
}

/// A right-hand side, as `ode_solvers` wants it.
struct Rate<'f>(&'f AnyRate<'f>);

impl System<f64, DVector<f64>> for Rate<'_> {
    fn system(&self, t: f64, state: &DVector<f64>, rate: &mut DVector<f64>) {
        (self.0)(t, state.as_slice(), rate.as_mut_slice());
    }
}

/// The state after a time `end`, from `state` at the time 0.
///
/// # Panics
///
/// If the solver fails.
pub fn integrate<const N: usize>(
    rate: impl Fn(f64, [f64; N]) -> [f64; N],
    state: [f64; N],
    end: f64,
    tolerance: f64,
) -> [f64; N] {
    let end = solve(&any(rate), DVector::from_column_slice(&state), end, tolerance);
    core::array::from_fn(|i| end[i])
}

/// The state at the time `end` from `state` at the time `t0`, where the right-hand side depends on time.
///
/// The time is integrated along, as the last component: with the time that `Dop853` itself hands to the right-hand side its error estimates are of
/// a low order, and it takes millions of steps to a tolerance of 1e-13.
///
/// # Panics
///
/// If the solver fails.
pub fn integrate_from<const N: usize>(
    rate: impl Fn(f64, [f64; N]) -> [f64; N],
    (t0, state): (f64, [f64; N]),
    end: f64,
    tolerance: f64,
) -> [f64; N] {
    let rate = any(rate);
    let clocked = |_: f64, state: &[f64], out: &mut [f64]| {
        rate(state[N], &state[..N], &mut out[..N]);
        out[N] = 1.0;
    };
    let state = DVector::from_iterator(N + 1, state.into_iter().chain([t0]));
    let end = solve(&clocked, state, end - t0, tolerance);
    core::array::from_fn(|i| end[i])
}

/// The state after a time `span`.
fn solve(rate: &AnyRate<'_>, state: DVector<f64>, span: f64, tolerance: f64) -> DVector<f64> {
    let mut solver = Dop853::from_param(
        Rate(rate),
        0.0,
        span,
        span,
        state,
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
    solver.y_out().last().unwrap().clone()
}
