//! Steps with two solutions: both of them, and going on with either.

use super::{Flow, Solved};
use crate::error::StepError;
use crate::step::StepReport;
use crate::system::System;

/// The solutions of a step, as values of its next node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roots<const N: usize> {
    /// The node that the iteration finds.
    pub found: [f64; N],
    /// Another solution, if deflation finds one.
    pub other: Option<[f64; N]>,
}

impl<S: System<N>, const N: usize> Flow<'_, S, N> {
    /// The solutions of the next step, one or two: the one that Newton's iteration finds, as in [`crate::Stepper::advance`], and another one
    /// if deflation finds it. `advance` may refuse to choose between the two. The flow stays where it is.
    ///
    /// # Errors
    ///
    /// [`StepError`] if no solution is found.
    pub fn roots(&self) -> Result<Roots<N>, StepError> {
        if let Some(e) = self.third.given {
            let found = self.q.plus(&self.d.plus(&e)).hi;
            return Ok(Roots { found, other: None });
        }
        let step = self.next_step();
        let pair = step
            .pair(&self.predictor, self.max_iterations)
            .map_err(|cause| self.failed(cause))?;
        let node = |z| {
            let e = step.second_difference(&z);
            let mut d = self.d;
            if const { S::ORDER > 2 } {
                d = self.arriving(&e).1;
            } else {
                d.add(&e);
            }
            self.q.plus(&d).hi
        };
        Ok(Roots {
            found: node(pair.found.0),
            other: pair.other.map(node),
        })
    }

    /// Solves one step like [`crate::Stepper::advance`], but takes the solution nearest to `q2`, even if there are others.
    ///
    /// # Errors
    ///
    /// [`StepError`] if no solution is found from there. The flow stays where it was.
    pub fn advance_to(&mut self, q2: &[f64; N]) -> Result<StepReport, StepError> {
        if const { S::ORDER > 2 } && self.third.given.is_some() {
            // the start has it
            let report = self.solve_third()?;
            self.clock.tick();
            return Ok(report);
        }
        let leg = self.leg();
        let step = self.next_step();
        let size = step.size(&self.predictor);
        let before = S::past(&self.constants);
        let e = core::array::from_fn(|i| ((q2[i] - leg.q[i]) - leg.d[i]) - before[i]);
        let (start, mut predictor) = (step.any().unknowns(&e), self.predictor);
        let (z, report) = step
            .any()
            .solve_near(start, &mut predictor, &size, self.max_iterations)
            .map_err(|cause| self.failed(cause))?;
        let e = step.second_difference(&z);
        let mut d = self.d;
        let mut second = self.third.e;
        if const { S::ORDER > 2 } {
            (second, d) = self.arriving(&e);
        } else {
            d.add(&e);
        }
        let q = self.q.plus(&d);
        if !q.hi.iter().all(|q| q.is_finite()) {
            return Err(self.failed(step.any().not_finite(&z)));
        }
        predictor.push(&z);
        self.predictor = predictor;
        self.solved = Some(Solved { leg, e, report });
        (self.q, self.d) = (q, d);
        if const { S::ORDER > 2 } {
            self.go_on(second);
        }
        self.clock.tick();
        Ok(report)
    }
}
