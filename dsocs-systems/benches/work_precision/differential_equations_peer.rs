//! The crate `differential-equations`: Dormand and Prince's method of order 8, and Verner's of order 9.

use differential_equations::prelude::{ExplicitRungeKutta, IVP, ODE};

use crate::candidate::{Candidate, tolerances};
use crate::problem::{Equations, grid};

/// A problem in the form that the crate expects.
struct Rate<P>(P);

impl<P: Equations<D>, const D: usize> ODE<f64, [f64; D]> for Rate<P> {
    #[inline]
    fn diff(&self, _: f64, y: &[f64; D], rate: &mut [f64; D]) {
        *rate = self.0.rate(y);
    }
}

macro_rules! solver {
    ($function:ident, $method:ident, $name:literal) => {
        /// The method with its interpolant, over a range of tolerances.
        pub fn $function<P: Equations<D>, const D: usize>(problem: P) -> impl Iterator<Item = Candidate> {
            tolerances(1, 13).map(move |tolerance| {
                Candidate::tolerance($name, tolerance, move |out| {
                    let system = Rate(problem);
                    let method = ExplicitRungeKutta::$method()
                        .rtol(tolerance)
                        .atol(tolerance)
                        .max_steps(4_000_000);
                    let times = grid(P::END);
                    let solution = IVP::ode(&system, 0.0, f64::from(P::END), problem.start())
                        .method(method)
                        .t_eval(&times)
                        .solve();
                    let Ok(solution) = solution else {
                        return false;
                    };
                    for y in &solution.y {
                        out.extend_from_slice(&y[..P::MEASURED]);
                    }
                    true
                })
            })
        }
    };
}

solver!(dop853, dop853, "differential-equations DOP853");
solver!(rkv98, rkv988e, "differential-equations RKV9(8)");
