//! Why a Taylor series could not go on.

use core::fmt;

use thiserror::Error;

/// Why a run by Taylor series failed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SeriesFailure {
    /// A coefficient of the series is infinite or not a number.
    #[error("a coefficient of the Taylor series is not finite")]
    NotFinite,
    /// The step became too small.
    #[error("the step would be {step:e}, less than the smallest allowed, {smallest:e}")]
    StepTooSmall {
        /// The step.
        step: f64,
        /// The smallest step.
        smallest: f64,
    },
    /// The limit of the number of steps was reached.
    #[error("{steps} steps have been made")]
    TooManySteps {
        /// How many were made.
        steps: u64,
    },
}

/// Everything known about a run by Taylor series that failed.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedSeries {
    /// How many steps were made before.
    pub step: u64,
    /// The time.
    pub time: f64,
    /// The position.
    pub q: Vec<f64>,
    /// The velocity.
    pub v: Vec<f64>,
    /// The coordinates' names.
    pub coordinates: Vec<&'static str>,
    /// What happened.
    pub cause: SeriesFailure,
}

/// A run by Taylor series that failed, or did not begin. The details are boxed, so that a step that succeeds costs nothing
/// more.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesError(Box<FailedSeries>);

impl SeriesError {
    /// Wraps the details.
    pub(crate) fn new(details: FailedSeries) -> Self {
        Self(Box::new(details))
    }

    /// Where and why the series ended.
    #[must_use]
    pub fn details(&self) -> &FailedSeries {
        &self.0
    }
}

impl fmt::Display for SeriesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FailedSeries {
            time: t,
            q,
            v,
            coordinates,
            cause,
            ..
        } = &*self.0;
        match cause {
            SeriesFailure::NotFinite => write!(
                f,
                "the Taylor series at t = {t}, ({}) = {q:?}, with the velocity {v:?}, is not finite: some expression of the \
                 declaration has no value or no derivative there, or the constraints do not determine the acceleration",
                coordinates.join(", ")
            ),
            SeriesFailure::StepTooSmall { step, smallest } => write!(
                f,
                "the step at t = {t} would be {step:e}, less than the smallest allowed, {smallest:e}: the motion comes close to \
                 a singularity (q = {q:?}, v = {v:?}), or the tolerance is too small"
            ),
            SeriesFailure::TooManySteps { steps } => write!(
                f,
                "{steps} steps have been made and t = {t} reached: allow more, or a larger tolerance"
            ),
        }
    }
}

impl core::error::Error for SeriesError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        Some(&self.0.cause)
    }
}
