//! Why a Taylor series could not go on.

use thiserror::Error;

use super::flow::State;

/// Why a motion ended early, or did not begin.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TaylorError {
    /// A coefficient of the series is infinite or not a number.
    #[error(
        "the Taylor series at t = {t}, ({}) = {q:?}, with the velocity {v:?}, is not finite: some expression of the declaration \
         has no value or no derivative there, or the constraints do not determine the acceleration",
        .coordinates.join(", ")
    )]
    NotFinite {
        /// The time.
        t: f64,
        /// The position.
        q: Vec<f64>,
        /// The velocity.
        v: Vec<f64>,
        /// The coordinates' names.
        coordinates: Vec<&'static str>,
    },
    /// The step became too small.
    #[error(
        "the step at t = {t} would be {step:e}, less than the smallest allowed, {smallest:e}: the motion comes close to a \
         singularity (q = {q:?}, v = {v:?}), or the tolerance is too small"
    )]
    StepTooSmall {
        /// The time.
        t: f64,
        /// The step.
        step: f64,
        /// The smallest step.
        smallest: f64,
        /// The position.
        q: Vec<f64>,
        /// The velocity.
        v: Vec<f64>,
    },
    /// The steps have been used up.
    #[error("{steps} steps have been made and t = {t} reached: allow more, or a larger tolerance")]
    TooManySteps {
        /// How many were made.
        steps: u64,
        /// The time.
        t: f64,
    },
    /// The function of an event has no Taylor series.
    #[error(
        "the function of event {event} has no Taylor series at t = {t}: it is not finite there, or it is an observed expression \
         that calls a function of the user's (give it as Event::function)"
    )]
    Event {
        /// The event's place among those watched.
        event: usize,
        /// The time.
        t: f64,
    },
    /// The time is not a finite number.
    #[error("the motion cannot go until t = {until}")]
    Until {
        /// The time asked for.
        until: f64,
    },
    /// The time lies behind the current one, in the direction of the motion.
    #[error("t = {until} lies behind t = {t}: the times are to come in order")]
    Behind {
        /// The time asked for.
        until: f64,
        /// The current time.
        t: f64,
    },
    /// The tolerance cannot be used.
    #[error(
        "the tolerance is {relative} (relative) and {absolute} (absolute); the first must lie between 0 and 1, the second not be negative"
    )]
    Tolerance {
        /// The relative part.
        relative: f64,
        /// The absolute part.
        absolute: f64,
    },
}

/// A motion that ended early, with all that it had computed.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{error}")]
pub struct TaylorFailure<const N: usize> {
    /// Why it ended.
    #[source]
    pub error: TaylorError,
    /// The states before.
    pub states: Vec<State<N>>,
}
