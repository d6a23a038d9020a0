//! DOP853, a published Runge–Kutta method of order 8(5,3): the reference for motions that must not depend on
//! this workspace.

use ode_solvers::dop_shared::OutputType;
use ode_solvers::{DVector, Dop853, SVector, System};

/// A right-hand side, as `ode_solvers` wants it. Its type is no part of the solver's, which is large and compiled once for each number of
/// components.
struct Rate<'f, const N: usize>(&'f dyn Fn(f64, [f64; N]) -> [f64; N]);

impl<const N: usize> System<f64, SVector<f64, N>> for Rate<'_, N> {
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
        Rate(&rate),
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

/// A right-hand side for any number of components: at a time and a state, it writes the rate to its last
/// argument.
type AnyRate<'f> = dyn Fn(f64, &[f64], &mut [f64]) + 'f;

/// This right-hand side for `ode_solvers`, with the time as the last component of the state.
struct Clocked<'f>(&'f AnyRate<'f>);

impl System<f64, DVector<f64>> for Clocked<'_> {
    fn system(&self, _: f64, state: &DVector<f64>, rate: &mut DVector<f64>) {
        let n = state.len() - 1;
        (self.0)(state[n], &state.as_slice()[..n], &mut rate.as_mut_slice()[..n]);
        rate[n] = 1.0;
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
    let rate = |t: f64, state: &[f64], out: &mut [f64]| {
        let mut parts = [0.0; N];
        parts.copy_from_slice(state);
        out.copy_from_slice(&rate(t, parts));
    };
    let end = clocked(&rate, (t0, &state), end, tolerance);
    core::array::from_fn(|i| end[i])
}

/// [`integrate_from`] for any number of components.
fn clocked(rate: &AnyRate<'_>, (t0, state): (f64, &[f64]), end: f64, tolerance: f64) -> DVector<f64> {
    let clocked = DVector::from_iterator(state.len() + 1, state.iter().copied().chain([t0]));
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
    solver.y_out().last().unwrap().clone()
}
