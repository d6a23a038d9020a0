//! The errors of a run, for all methods.

use std::borrow::Cow;

use thiserror::Error;

use crate::error::series::SeriesError;
use crate::error::stage::{StageError, StageFailure};
use crate::error::{FailedStep, SetupError, StepError};
use crate::solve::failure::StepFailure;

/// Errors of the setup or of a step of a run, for all methods.
///
/// Each variant carries the step, the time, the nodes and the cause, and its message gives advice.
/// [`core::error::Error::source`] returns the cause. The details are boxed, so that the result of a
/// successful step stays small.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RunError {
    /// The run could not be set up.
    #[error(transparent)]
    Setup(Box<SetupError>),
    /// A step of a [`crate::Flow`] has no solution.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A stage of a step of a [`crate::ComposedFlow`] could not be made.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// A [`crate::TaylorFlow`] cannot continue its motion.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// The time to run to lies behind the current time, in the direction of the run.
    #[error(transparent)]
    TimeBehind(Box<TimeBehind>),
    /// The time to run to is not a number, or it is infinite and nothing else can end the run.
    #[error("the run cannot go until t = {until}")]
    Until {
        /// The requested time.
        until: f64,
    },
    /// The function of an event has no value or no derivatives.
    #[error(transparent)]
    Event(Box<FailedEvent>),
    /// An input cannot be set.
    #[error(transparent)]
    Input(Box<InputError>),
    /// The method has no step back in time.
    #[error("{method} cannot run back in time: {reason}", method = .0.method, reason = .0.reason)]
    NotReversible(Box<NotReversible>),
}

crate::debug_is_message!(RunError);

/// A time to run to that lies behind the current time, in the direction of the run.
#[derive(Clone, Copy, PartialEq, Error)]
#[error(
    "t = {until} cannot be reached from t = {time}{}: it lies the other way (a negative step, or `reverse`, runs back in time)",
    with_the_step(*.h)
)]
pub struct TimeBehind {
    /// The requested time.
    pub until: f64,
    /// The current time.
    pub time: f64,
    /// The step; `None` if the method chooses it.
    pub h: Option<f64>,
}

crate::debug_is_message!(TimeBehind);

/// The step in a message.
fn with_the_step(h: Option<f64>) -> String {
    h.map_or_else(String::new, |h| format!(" with the step h = {h}"))
}

/// The function of an event has no value or no derivatives at a point of the motion.
#[derive(Clone, Copy, PartialEq, Error)]
#[error(
    "the function of event {event} has no Taylor series at t = {time}: it is not finite there, or it is an observed expression \
     that calls a function of the user's (give it as Event::function)"
)]
pub struct FailedEvent {
    /// The event's place among those watched.
    pub event: usize,
    /// The time.
    pub time: f64,
}

crate::debug_is_message!(FailedEvent);

/// A method that has no step back in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotReversible {
    /// The method.
    pub method: &'static str,
    /// The reason.
    pub reason: &'static str,
}

/// An input that cannot be set.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum InputError {
    /// There is no parameter of that name.
    #[error("no parameter is called `{parameter}`; expected one of {}", .parameters.join(", "))]
    Unknown {
        /// The name.
        parameter: String,
        /// The names of the parameters.
        parameters: Vec<Cow<'static, str>>,
    },
    /// The field of that name is no parameter.
    #[error(
        "the field `{field}` is of type `{ty}`, and no parameter: parameters are fields of type `f64`, and the elements of arrays of them"
    )]
    Type {
        /// The field.
        field: String,
        /// Its type.
        ty: String,
    },
    /// The value is infinite or not a number.
    #[error("the input `{parameter}` is {value}; it must be finite")]
    NotFinite {
        /// The name.
        parameter: Cow<'static, str>,
        /// The value.
        value: f64,
    },
    /// A constraint is of third order, for which a change of a parameter at a node is not supported.
    #[error(
        "`{parameter}` cannot change at a node: a constraint here is of third order; write the input as a function of `t`"
    )]
    ThirdOrder {
        /// The name.
        parameter: Cow<'static, str>,
    },
    /// The method does not change parameters on the way.
    #[error("`{parameter}` cannot change during a run of this method")]
    Fixed {
        /// The name.
        parameter: Cow<'static, str>,
    },
    /// There are not as many values as starts.
    #[error("`{parameter}` has {values} values for {starts} starts; give one for each, after the starts")]
    Count {
        /// The name.
        parameter: Cow<'static, str>,
        /// The number of values.
        values: usize,
        /// The number of starts.
        starts: usize,
    },
    /// The parameter stands inside a `dot(…)`, where its own rate is taken to be zero.
    #[error(
        "`{parameter}` cannot change at a node: it stands inside a `dot(…)`, which takes its rate to be zero, so what is differentiated \
         there would have to jump; declare `{parameter}` as `Samples` or as a function of `t`, whose rates are known"
    )]
    Rate {
        /// The name.
        parameter: Cow<'static, str>,
    },
    /// A holonomic constraint depends on the parameter.
    #[error(
        "`{parameter}` cannot change at a node: a holonomic constraint depends on it, and the position would have to jump; write the \
         constraint with a function of `t`"
    )]
    Position {
        /// The name.
        parameter: Cow<'static, str>,
    },
}

crate::debug_is_message!(InputError);

impl RunError {
    /// The error for a time that lies behind.
    pub(crate) fn time_behind(details: TimeBehind) -> Self {
        Self::TimeBehind(Box::new(details))
    }

    /// The details of the equations without a solution, for a failed step or stage.
    #[must_use]
    pub fn failed_step(&self) -> Option<&FailedStep> {
        match self {
            Self::Step(error) => Some(error.details()),
            Self::Stage(error) => match &error.details().cause {
                StageFailure::Step(error) => Some(error.details()),
                _ => None,
            },
            _ => None,
        }
    }

    /// The reason why these equations have no solution.
    #[must_use]
    pub fn step_failure(&self) -> Option<StepFailure> {
        self.failed_step().map(|step| step.cause.reason)
    }

    /// The time of the failure; `None` if the run did not begin, or if the time to run to was invalid.
    #[must_use]
    pub fn time(&self) -> Option<f64> {
        match self {
            Self::Step(error) => Some(error.details().time),
            Self::Stage(error) => Some(error.details().time()),
            Self::Series(error) => Some(error.details().time),
            Self::Event(event) => Some(event.time),
            Self::Setup(_)
            | Self::TimeBehind(_)
            | Self::Until { .. }
            | Self::Input(_)
            | Self::NotReversible(_) => None,
        }
    }
}

impl From<SetupError> for RunError {
    fn from(error: SetupError) -> Self {
        Self::Setup(Box::new(error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::report::StepReport;

    #[test]
    fn an_error_costs_a_step_no_more_than_two_words() {
        assert!(size_of::<Result<StepReport, RunError>>() <= 2 * size_of::<usize>());
    }
}
