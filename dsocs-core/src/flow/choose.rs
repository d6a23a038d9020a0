//! Steps with two solutions: both roots, and the choice of one.

use super::Flow;
use super::discrete::Discrete;
use crate::error::StepError;
use crate::kernel::report::StepReport;
use crate::number::point::sized;
use crate::solve::{Vector, rotation};

/// The solutions of a step, as values of its next node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roots<const N: usize> {
    /// The node that Newton's iteration finds.
    pub found: [f64; N],
    /// Another solution, if deflation finds one.
    pub other: Option<[f64; N]>,
}

impl<const N: usize> Flow<'_, N> {
    /// The solutions of the next step, one or two: the one that Newton's iteration finds, as in [`crate::Stepper::advance`], and another one
    /// if deflation finds it. `advance` may refuse to choose between the two. The flow stays where it is.
    ///
    /// # Errors
    ///
    /// [`StepError`] if no solution is found.
    pub fn roots(&self) -> Result<Roots<N>, StepError> {
        let (found, other) = self.0.roots()?;
        Ok(Roots {
            found: sized(&found),
            other: other.map(|other| sized(&other)),
        })
    }

    /// Solves one step like [`crate::Stepper::advance`], but takes the solution nearest to `q2`, even if there are others.
    ///
    /// # Errors
    ///
    /// [`StepError`] if no solution is found from there. The flow stays where it was.
    pub fn advance_to(&mut self, q2: &[f64; N]) -> Result<StepReport, StepError> {
        self.0.advance_to(q2)
    }
}

impl Discrete<'_> {
    /// The next nodes that solve the next step: the one that Newton's iteration finds, and another one if deflation finds it.
    pub fn roots(&self) -> Result<(Vector, Option<Vector>), StepError> {
        let run_state = &self.run_state;
        if let Some(e) = &run_state.given {
            let d = run_state.vectors.d().plus(e);
            return Ok((self.moved(&run_state.vectors.q(), &d).hi, None));
        }
        let step = self.next_step();
        let pair = step
            .pair(&run_state.predictor, run_state.max_iterations)
            .map_err(|cause| self.failed(cause))?;
        let node = |z: &Vector| self.leads_to(&step.second_difference(z)).q.hi;
        Ok((node(&pair.found.0), pair.other.as_ref().map(node)))
    }

    /// Solves the next step for the solution nearest to a node.
    pub fn advance_to(&mut self, q2: &[f64]) -> Result<StepReport, StepError> {
        if self.run_state.given.is_some() {
            // the start gives it
            let report = self.answer()?;
            self.run_state.clock.tick();
            return Ok(report);
        }
        let mut predictor = self.run_state.predictor.clone();
        let step = self.next_step();
        let size = step.size(&predictor);
        let leg = step.leg;
        let mut displacement = Vector::from_fn(q2.len().min(leg.q.len()), |i| q2[i] - leg.q[i]);
        rotation::difference(&self.shape().rotations, [leg.q, q2], &mut displacement);
        let e = Vector::from_fn(displacement.len(), |i| {
            (displacement[i] - leg.d[i]) - step.before[i]
        });
        let start = step.unknowns(&e);
        let (z, report) = step
            .solve_near(&start, &mut predictor, &size, self.run_state.max_iterations)
            .map_err(|cause| self.failed(cause))?;
        let e = step.second_difference(&z);
        let Some(next) = self.arriving(&e) else {
            return Err(self.not_finite(&z));
        };
        predictor.push(&z);
        self.run_state.predictor = predictor;
        self.commit(next, &e, report);
        self.run_state.clock.tick();
        Ok(report)
    }
}
