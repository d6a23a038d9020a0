//! Steps and accelerations of a system: made for its type, until steps are solved on slices.

use crate::any::{AnyLeg, sized};
use crate::error::{NewtonFailure, SetupError};
use crate::flow::{Flow, MAX_ITERATIONS};
use crate::kernel::Kernel;
use crate::start;
use crate::step::predictor::Predictor;
use crate::step::unknown::Unknown;
use crate::step::{AnyStep, Step};
use crate::system::{Leg, System};

/// Which solution of a step is sought.
#[derive(Clone, Copy, Debug)]
pub enum Sought<'a> {
    /// The first that is found.
    First,
    /// The first that is found, after a look for others wherever the rows bend.
    Watched,
    /// The one whose second difference is nearest to this.
    Near(&'a [f64]),
}

/// The solution of a step.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The unknowns.
    pub(super) z: Vec<f64>,
    /// The second difference.
    pub(super) e: Vec<f64>,
}

/// A system with the equations of its steps and of its accelerations.
///
/// Matrices are square, row by row; their solutions are `None` where they are not finite.
pub trait Bridge: Send + Sync {
    /// The system.
    fn kernel(&self) -> &dyn Kernel;

    /// Checks that a step and the parameters can be used.
    fn check_step(&self, h: f64) -> Result<(), SetupError>;

    /// Solves the step `h` from a leg.
    fn step(&self, h: f64, leg: AnyLeg<'_, f64>, sought: Sought<'_>) -> Result<Solution, NewtonFailure>;

    /// Solves linear equations for changes of a step's unknowns.
    fn solve_unknowns(&self, matrix: &[f64], right: &[f64]) -> Option<Vec<f64>>;

    /// The acceleration of the continuous system at a time, a position and a velocity, near one if there are several.
    fn acceleration(
        &self,
        at: (f64, &[f64], &[f64]),
        near: Option<&[f64]>,
    ) -> Result<Vec<f64>, NewtonFailure>;

    /// Solves linear equations for changes of accelerations and multipliers of the continuous system.
    fn solve_accelerations(&self, matrix: &[f64], right: &[f64]) -> Option<Vec<f64>>;
}

/// A system of a type.
pub struct Typed<'s, S, const N: usize>(pub &'s S);

impl<S: System<N>, const N: usize> Bridge for Typed<'_, S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.0.kernel()
    }

    fn check_step(&self, h: f64) -> Result<(), SetupError> {
        if const { S::ORDER > 2 } {
            return Err(SetupError::ThirdOrder {
                method: "the flow as a map of pairs of nodes (geometry::DiscreteFlow)",
            });
        }
        Flow::check(self.0, h)
    }

    fn step(&self, h: f64, leg: AnyLeg<'_, f64>, sought: Sought<'_>) -> Result<Solution, NewtonFailure> {
        let system = self.0;
        let constants = system.constants(&system.parameters(), h);
        let leg = Leg {
            t: leg.t,
            q: sized(leg.q),
            d: sized(leg.d),
        };
        let mut step = Step::new(system, &constants, leg, h);
        step.past_is_short = matches!(sought, Sought::Watched);
        solution(step.any(), sought)
    }

    fn solve_unknowns(&self, matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
        solve::<S::Unknown<f64>>(matrix, right)
    }

    fn acceleration(
        &self,
        (t, q, v): (f64, &[f64], &[f64]),
        near: Option<&[f64]>,
    ) -> Result<Vec<f64>, NewtonFailure> {
        let near: Option<[f64; N]> = near.map(sized);
        let (a, _) = start::acceleration(self.0, (t, &sized(q), &sized(v)), near.as_ref())?;
        Ok(a.to_vec())
    }

    fn solve_accelerations(&self, matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
        solve::<S::Motion>(matrix, right)
    }
}

/// Solves a step without a past.
fn solution<Z: Unknown<f64>, const N: usize>(
    step: &dyn AnyStep<N, Z = Z>,
    sought: Sought<'_>,
) -> Result<Solution, NewtonFailure> {
    let (z, _) = match sought {
        Sought::Near(e) => step.solve_from(step.unknowns(&sized(e)), MAX_ITERATIONS)?,
        Sought::First | Sought::Watched => {
            step.solve_without_prediction(&mut Predictor::new(), &step.least(), MAX_ITERATIONS, 0)?
        }
    };
    Ok(Solution {
        z: z.as_ref().to_vec(),
        e: step.second_difference(&z).to_vec(),
    })
}

/// Solves linear equations in the way of the unknowns `U`.
pub(crate) fn solve<U: Unknown<f64>>(matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
    let mut square = U::zeros();
    let rows = matrix.chunks(right.len().max(1));
    for (place, row) in square.as_mut().iter_mut().zip(rows) {
        *place = start::vector(row);
    }
    let solution = U::solve(&square, &start::vector(right))?;
    Some(solution.as_ref().to_vec())
}
