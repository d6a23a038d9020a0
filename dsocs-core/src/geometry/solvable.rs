//! What geometry asks of a system, whatever its type.
//!
//! This is compiled for every system, and the geometry for every number of coordinates.

use crate::declaration::Declaration;
use crate::error::{NewtonFailure, SetupError};
use crate::flow::{Flow, MAX_ITERATIONS};
use crate::start;
use crate::step::predictor::Predictor;
use crate::step::unknown::Unknown;
use crate::step::{AnyStep, Step};
use crate::system::{Leg, System};

/// A system, seen as its declaration alone. Every [`System`] implements it.
pub trait Declared<const N: usize> {
    /// The declaration.
    #[doc(hidden)]
    fn declaration(&self) -> Declaration<'_>;
}

impl<S: System<N>, const N: usize> Declared<N> for S {
    fn declaration(&self) -> Declaration<'_> {
        Declaration::of(self)
    }
}

/// Which solution of a step is sought.
#[derive(Clone, Copy, Debug)]
pub enum Sought<'a, const N: usize> {
    /// The first that is found.
    First,
    /// The first that is found, after a look for others wherever the rows bend.
    Watched,
    /// The one whose second difference is nearest to this.
    Near(&'a [f64; N]),
}

/// The solution of a step.
#[derive(Clone, Debug)]
pub struct Solution<const N: usize> {
    /// The unknowns.
    pub(super) z: Vec<f64>,
    /// The second difference.
    pub(super) e: [f64; N],
}

/// A system with the equations of its steps and of its accelerations. Every [`System`] implements it.
///
/// Matrices are square, row by row; their solutions are `None` where they are not finite.
pub trait Solvable<const N: usize>: Declared<N> {
    /// Checks that a step and the parameters can be used.
    #[doc(hidden)]
    fn check_step(&self, h: f64) -> Result<(), SetupError>;

    /// Solves the step `h` from a leg.
    #[doc(hidden)]
    fn step(&self, h: f64, leg: &Leg<f64, N>, sought: Sought<'_, N>) -> Result<Solution<N>, NewtonFailure>;

    /// Solves linear equations for changes of a step's unknowns.
    #[doc(hidden)]
    fn solve_unknowns(&self, matrix: &[f64], right: &[f64]) -> Option<Vec<f64>>;

    /// The acceleration of the continuous system at a time, a position and a velocity, near one if there are several.
    #[doc(hidden)]
    fn acceleration(
        &self,
        at: (f64, &[f64; N], &[f64; N]),
        near: Option<&[f64; N]>,
    ) -> Result<[f64; N], NewtonFailure>;

    /// Solves linear equations for changes of accelerations and multipliers of the continuous system.
    #[doc(hidden)]
    fn solve_accelerations(&self, matrix: &[f64], right: &[f64]) -> Option<Vec<f64>>;
}

impl<S: System<N>, const N: usize> Solvable<N> for S {
    fn check_step(&self, h: f64) -> Result<(), SetupError> {
        if const { S::ORDER > 2 } {
            return Err(SetupError::ThirdOrder {
                method: "the flow as a map of pairs of nodes (geometry::DiscreteFlow)",
            });
        }
        Flow::check(self, h)
    }

    fn step(&self, h: f64, leg: &Leg<f64, N>, sought: Sought<'_, N>) -> Result<Solution<N>, NewtonFailure> {
        let constants = self.constants(&self.parameters(), h);
        let mut step = Step::new(self, &constants, *leg, h);
        step.past_is_short = matches!(sought, Sought::Watched);
        solution(step.any(), sought)
    }

    fn solve_unknowns(&self, matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
        solve::<S::Unknown<f64>>(matrix, right)
    }

    fn acceleration(
        &self,
        at: (f64, &[f64; N], &[f64; N]),
        near: Option<&[f64; N]>,
    ) -> Result<[f64; N], NewtonFailure> {
        Ok(start::acceleration(self, at, near)?.0)
    }

    fn solve_accelerations(&self, matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
        solve::<S::Motion>(matrix, right)
    }
}

/// Solves a step without a past.
fn solution<Z: Unknown<f64>, const N: usize>(
    step: &dyn AnyStep<N, Z = Z>,
    sought: Sought<'_, N>,
) -> Result<Solution<N>, NewtonFailure> {
    let (z, _) = match sought {
        Sought::Near(e) => step.solve_from(step.unknowns(e), MAX_ITERATIONS)?,
        Sought::First | Sought::Watched => {
            step.solve_without_prediction(&mut Predictor::new(), &step.least(), MAX_ITERATIONS, 0)?
        }
    };
    Ok(Solution {
        z: z.as_ref().to_vec(),
        e: step.second_difference(&z),
    })
}

/// Solves linear equations in the way of the unknowns `U`.
fn solve<U: Unknown<f64>>(matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
    let mut square = U::zeros();
    let rows = matrix.chunks(right.len().max(1));
    for (place, row) in square.as_mut().iter_mut().zip(rows) {
        *place = start::vector(row);
    }
    let solution = U::solve(&square, &start::vector(right))?;
    Some(solution.as_ref().to_vec())
}
