//! The errors of a stage of a composed step.

use core::fmt;

use crate::error::StepError;
use crate::number::composition::Composition;
use crate::solve::failure::NewtonFailure;

/// State and diagnosis of a failed stage.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedStage {
    /// The method.
    pub method: Composition,
    /// The number of the node that the step begins at, counted as in [`crate::Node::index`].
    pub index: u64,
    /// The stage's number, from 1.
    pub stage: usize,
    /// Whether its leg goes against the direction of the run.
    pub backward: bool,
    /// Whether there is a constraint on accelerations; the motion may not exist back in time then.
    pub constrained: bool,
    /// Whether a force or a constraint jumps with positions or velocities.
    pub piecewise: bool,
    /// The cause.
    pub cause: StageFailure,
}

/// The cause of a failed stage.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StageFailure {
    /// No solution of the stage's equations was found, or more than one. Times and nodes are those of the stage.
    Step(StepError),
    /// The legs are joined by momenta, and no solution of the stage's equations was found.
    Leg {
        /// The time at the end of the stage.
        time: f64,
        /// The length of its leg.
        h: f64,
        /// Failure of Newton's iteration for the increment of the leg, or for the velocity at its end.
        cause: NewtonFailure,
    },
    /// The stage goes back in time beyond a singularity of its equations. There is a solution, but it does not belong to the motion.
    Singularity {
        /// The time at the end of the stage.
        time: f64,
        /// The length of its leg.
        h: f64,
    },
    /// The stage goes back in time, and its solution does not continue the motion: the acceleration jumps.
    Jump {
        /// The time at the end of the stage.
        time: f64,
        /// The length of its leg.
        h: f64,
    },
}

impl FailedStage {
    /// The time at the end of the stage.
    #[must_use]
    pub fn time(&self) -> f64 {
        match &self.cause {
            StageFailure::Step(error) => error.details().time,
            StageFailure::Leg { time, .. }
            | StageFailure::Singularity { time, .. }
            | StageFailure::Jump { time, .. } => *time,
        }
    }
}

/// A composed step that failed. The details are boxed, so that the result of a successful step stays small.
#[derive(Clone, PartialEq)]
pub struct StageError(Box<FailedStage>);

crate::debug_is_message!(StageError);

impl StageError {
    /// Wraps the details.
    pub(crate) fn new(details: FailedStage) -> Self {
        Self(Box::new(details))
    }

    /// State and diagnosis of the failed step.
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
            constrained,
            piecewise,
            cause,
            ..
        } = &*self.0;
        write!(f, "stage {stage} of {} of {method}", method.stages())?;
        if *backward {
            f.write_str(", which goes back in time,")?;
        }
        match cause {
            StageFailure::Step(error) => write!(f, " failed: {error}")?,
            StageFailure::Leg { time, h, cause } => {
                write!(f, " failed: the leg of {h:.3e} to t = {time}: {cause}")?;
            }
            StageFailure::Singularity { time, h } => write!(
                f,
                " passes a singularity: its equations at t = {time} have changed their orientation over the leg of {h:.3e}, so that \
                 their solution does not continue the motion",
            )?,
            StageFailure::Jump { time, h } => write!(
                f,
                " jumps: the solution at t = {time} is not the one that the motion leads to over the leg of {h:.3e}",
            )?,
        }
        let is_explained = matches!(cause, StageFailure::Step(error) if error.details().undefined.is_some());
        if method.order() > 2 && *constrained && !is_explained {
            f.write_str(
                "; the method has legs that go back in time, where a constraint such as a decrease of energy may have no \
                 motion: take a smaller h, the step of order 2 (Flow) or the continuous motion to a tolerance (TaylorFlow)",
            )?;
        } else if *piecewise && !is_explained {
            f.write_str(
                "; a force here jumps with the motion (`signum`, a comparison), and this method does not follow a motion that comes to rest \
                 at a jump: take the step of order 2 (Flow), which does, or a steep smooth function, such as `(v / 0.001).tanh()`",
            )?;
        } else if method.order() > 2 && !is_explained {
            f.write_str(
                "; take a smaller h, the step of order 2 (Flow) or the continuous motion to a tolerance (TaylorFlow)",
            )?;
        } else if !matches!(cause, StageFailure::Step(_)) {
            f.write_str("; take a smaller h, Flow or the continuous motion to a tolerance (TaylorFlow)")?;
        }
        Ok(())
    }
}

impl core::error::Error for StageError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match &self.0.cause {
            StageFailure::Step(error) => Some(error),
            StageFailure::Leg { .. } | StageFailure::Singularity { .. } | StageFailure::Jump { .. } => None,
        }
    }
}
