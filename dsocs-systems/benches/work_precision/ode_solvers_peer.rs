//! The crate `ode_solvers`: the methods of Dormand and Prince of orders 5 and 8.

use ode_solvers::dop_shared::OutputType;
use ode_solvers::{Dop853, Dopri5, SVector, System};

use crate::candidate::{Candidate, tolerances};
use crate::problem::{Equations, INTERVAL, intervals};

/// A problem in the form that the crate expects.
struct Rate<P, const D: usize>(P);

impl<P: Equations<D>, const D: usize> System<f64, SVector<f64, D>> for Rate<P, D> {
    #[inline]
    fn system(&self, _: f64, y: &SVector<f64, D>, rate: &mut SVector<f64, D>) {
        *rate = SVector::from(self.0.rate(&(*y).into()));
    }
}

/// The largest number of steps: more take longer than a candidate may. At the smallest tolerances the step
/// can shrink to nothing.
const MAX_STEPS: u32 = 4_000_000;

macro_rules! solver {
    ($function:ident, $solver:ident, $name:literal, $beta:literal, $shrink:literal, $grow:literal) => {
        /// The method with dense output, over a range of tolerances.
        pub fn $function<P: Equations<D>, const D: usize>(problem: P) -> impl Iterator<Item = Candidate> {
            tolerances(1, 13).map(move |tolerance| {
                Candidate::tolerance($name, tolerance, move |out| {
                    let end = f64::from(P::END);
                    let mut solver = $solver::from_param(
                        Rate(problem),
                        0.0,
                        end,
                        INTERVAL,
                        SVector::from(problem.start()),
                        tolerance,
                        tolerance,
                        0.9,
                        $beta,
                        $shrink,
                        $grow,
                        end,
                        0.0,
                        MAX_STEPS,
                        MAX_STEPS, // no test for stiffness
                        OutputType::Dense,
                    );
                    if solver.integrate().is_err() {
                        return false;
                    }
                    let count = intervals(P::END) as usize + 1;
                    for y in solver.y_out().iter().take(count) {
                        out.extend_from_slice(&y.as_slice()[..P::MEASURED]);
                    }
                    // the rounding of its times may add one at the end, or leave the last one out
                    solver.y_out().len() + 1 >= count
                })
            })
        }
    };
}

// the defaults of the crate
solver!(dopri5, Dopri5, "ode_solvers DOPRI5", 0.04, 0.2, 10.0);
solver!(dop853, Dop853, "ode_solvers DOP853", 0.0, 0.333, 6.0);

/// The states on the grid to nearly all digits. Each interval is integrated by itself, so no dense output is
/// needed.
pub fn reference<P: Equations<D>, const D: usize>(problem: P) -> Option<Vec<f64>> {
    let mut state = SVector::from(problem.start());
    let mut out = state.as_slice()[..P::MEASURED].to_vec();
    for _ in 0..intervals(P::END) {
        let mut solver = Dop853::from_param(
            Rate(problem),
            0.0,
            INTERVAL,
            INTERVAL,
            state,
            1e-15,
            1e-15,
            0.9,
            0.0,
            0.333,
            6.0,
            INTERVAL,
            0.0,
            MAX_STEPS,
            MAX_STEPS,
            OutputType::Sparse,
        );
        solver.integrate().ok()?;
        state = *solver.y_out().last()?;
        out.extend_from_slice(&state.as_slice()[..P::MEASURED]);
    }
    Some(out)
}
