//! The solution of a single step from its first two nodes alone, and of linear equations.

use crate::error::SetupError;
use crate::flow::discrete::{check, constants_of, values_of};
use crate::kernel::Kernel;
use crate::kernel::run_state::MAX_ITERATIONS;
use crate::number::point::AnyLeg;
use crate::solve::Square;
use crate::solve::failure::NewtonFailure;
use crate::solve::predictor::Predictor;
use crate::step::Step;
use crate::tape::declaration::Declaration;

/// The solution of a step that is requested.
#[derive(Clone, Copy, Debug)]
pub enum WantedSolution<'a> {
    /// The first solution that is found.
    First,
    /// The first solution that is found, after a search for others wherever the rows are strongly nonlinear.
    Watched,
    /// The solution whose second difference is nearest to the given one.
    Near(&'a [f64]),
}

/// The solution of a step.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The unknowns.
    pub(crate) z: Vec<f64>,
    /// The second difference.
    pub(crate) e: Vec<f64>,
}

/// Checks that a step and the parameters can be used.
pub(crate) fn check_step(system: &dyn Kernel, h: f64) -> Result<(), SetupError> {
    if system.shape().is_of_third_order() {
        return Err(SetupError::ThirdOrder {
            method: "the flow as a map of pairs of nodes (geometry::DiscreteFlow)",
        });
    }
    check(&Declaration::of(system), h)
}

/// Solves the step `h` after a leg.
pub(crate) fn step(
    system: &dyn Kernel,
    h: f64,
    leg: AnyLeg<'_, f64>,
    wanted: WantedSolution<'_>,
) -> Result<Solution, NewtonFailure> {
    let values = values_of(system);
    let constants = constants_of(system, &values, h);
    let mut step = Step::new((system, &values), &constants, leg, h);
    step.past_is_short = matches!(wanted, WantedSolution::Watched);
    let (z, _) = match wanted {
        WantedSolution::Near(e) => step.solve_from(&step.unknowns(e), MAX_ITERATIONS)?,
        WantedSolution::First | WantedSolution::Watched => {
            let mut predictor = Predictor::new(system.shape().unknowns);
            step.solve_without_prediction(&mut predictor, &step.least(), MAX_ITERATIONS, 0)?
        }
    };
    Ok(Solution {
        z: z.to_vec(),
        e: step.second_difference(&z).to_vec(),
    })
}

/// Solves linear equations with a square matrix, given row by row; `None` if the solution is not finite.
pub(crate) fn solve(matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
    let size = right.len();
    let entry = |i: usize, j: usize| matrix.get(i * size + j).copied().unwrap_or(f64::NAN);
    Some(Square::from_fn(size, entry).solve(right)?.to_vec())
}
