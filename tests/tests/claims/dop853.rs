//! A published Runge–Kutta method of order 8(5,3), for claims that need a motion by other hands.

use ode_solvers::dop_shared::OutputType;
use ode_solvers::{Dop853, SVector, System};

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
