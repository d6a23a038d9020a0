//! What can go wrong in a stage of a composed step.

use core::fmt;

use super::method::Composition;
use crate::error::StepError;

/// Everything known about a stage that failed.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedStage {
    /// The method.
    pub method: Composition,
    /// The stage's number, from 1.
    pub stage: usize,
    /// Whether its leg goes against the direction of the run.
    pub backward: bool,
    /// What happened.
    pub cause: StageFailure,
}

/// What happened in a stage.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StageFailure {
    /// Its equations have no solution that was found, or more than one. Times and nodes are the stage's.
    Step(StepError),
    /// It goes back in time to an acceleration far larger than any before it.
    Jump {
        /// The time at the end of the stage.
        time: f64,
        /// The coordinate's name.
        coordinate: &'static str,
        /// The largest acceleration before.
        before: f64,
        /// The acceleration at the end of the stage.
        after: f64,
    },
}

/// A composed step that could not be made. The details are boxed: a step that succeeds should not pay for them.
#[derive(Clone, Debug, PartialEq)]
pub struct StageError(Box<FailedStage>);

impl StageError {
    /// Wraps the details.
    pub(crate) fn new(details: FailedStage) -> Self {
        Self(Box::new(details))
    }

    /// Where and why the step failed.
    #[must_use]
    pub fn details(&self) -> &FailedStage {
        &self.0
    }
}

impl fmt::Display for StageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FailedStage {
            method,
            stage,
            backward,
            cause,
        } = &*self.0;
        write!(f, "stage {stage} of {} of {method}", method.stages())?;
        if *backward {
            f.write_str(", which goes back in time,")?;
        }
        match cause {
            StageFailure::Step(error) => write!(f, " failed: {error}")?,
            StageFailure::Jump {
                time,
                coordinate,
                before,
                after,
            } => write!(
                f,
                " jumps: at t = {time} the acceleration of `{coordinate}` would be {after:.3e}, where it was at most {before:.3e}",
            )?,
        }
        if method.order() > 2 {
            f.write_str(
                "; the method has legs that go back in time, where a constraint such as a decrease of energy may have no \
                 motion: take the step of order 2 (Flow) or the continuous motion to a tolerance (TaylorFlow)",
            )?;
        }
        Ok(())
    }
}

impl core::error::Error for StageError {}
