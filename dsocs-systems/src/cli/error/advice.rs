//! The options of the command line that do what an error advises.

use std::borrow::Cow;

use dsocs_core::linear::LinearizationError;
use dsocs_core::{RunError, SetupError, StepFailure, Symmetry, Undefined};

use crate::entry::{CheckFailure, RunFailure};

/// The expression without a value, where a run does not begin because of one.
fn undefined(failure: &RunFailure) -> Option<&Undefined> {
    match failure {
        RunFailure::Setup(SetupError::Acceleration { undefined, .. }) => undefined.as_deref(),
        RunFailure::Setup(SetupError::Series(error)) => error.details().undefined.as_ref(),
        RunFailure::Run(RunError::Step(error)) if error.details().index == 1 => {
            error.details().undefined.as_ref()
        }
        _ => None,
    }
}

/// The options that do what an error advises.
pub(super) fn options(failure: &RunFailure) -> Cow<'static, str> {
    match undefined(failure) {
        Some(undefined) => options_of_undefined(undefined).into(),
        None => options_of_others(failure).into(),
    }
}

/// The options that set the position, velocity and parameters in an expression.
fn options_of_undefined(undefined: &Undefined) -> String {
    let options = [
        (undefined.contains_position(), "`--q0`"),
        (undefined.contains_velocity(), "`--v0`"),
        (undefined.contains_parameter(), "`--set`"),
    ];
    let options: Vec<_> = options.into_iter().filter(|(contains, _)| *contains).collect();
    match options.as_slice() {
        [] => String::new(),
        options => {
            let options: Vec<&str> = options.iter().map(|(_, option)| *option).collect();
            format!("\n(on the command line: {})", options.join(", "))
        }
    }
}

/// The options that do what any other error advises.
fn options_of_others(failure: &RunFailure) -> &'static str {
    match failure {
        // a missing mass or row does not depend on the start, and rows that repeat each other do so at all
        // values of the parameters
        RunFailure::Setup(SetupError::Acceleration {
            deficiency: Some(deficiency),
            at_any_velocity,
            ..
        }) if !deficiency.at_guess_alone => {
            match (at_any_velocity, deficiency.massless, deficiency.rows.len()) {
                (false, ..) => "\n(on the command line: `--v0`)",
                (true, true, _) | (true, _, 1) => {
                    "\n(on the command line: `--set`, if a parameter is zero that should not be)"
                }
                _ => "",
            }
        }
        // a multiple root does not depend on the start, nor does a position at which no velocity has a value
        RunFailure::Setup(SetupError::Acceleration { cause, .. }) if cause.is_at_multiple_root() => "",
        RunFailure::Setup(SetupError::Acceleration {
            at_any_velocity: true,
            cause,
            ..
        }) => match cause.reason {
            StepFailure::NotFinite => "\n(on the command line: `--q0`, or `--set` where a parameter is why)",
            _ => "\n(on the command line: `--near-a0`)",
        },
        // the paper's start has no velocity there either
        RunFailure::Setup(SetupError::Acceleration { v0, cause, .. })
            if cause.reason == StepFailure::NotFinite && v0.iter().all(|&v| v == 0.0) =>
        {
            "\n(on the command line: `--v0`)"
        }
        RunFailure::Setup(SetupError::Rest { .. }) => "\n(on the command line: `--v0`)",
        RunFailure::Setup(SetupError::Acceleration { .. }) => {
            "\n(on the command line: `--near-a0`, `--v0`, `--q1`, `--start paper`)"
        }
        RunFailure::Setup(SetupError::Composition { reason, .. }) if *reason != Symmetry::ThirdOrder => {
            "\n(on the command line: `--order 2`, which is the default, or `--tolerance`)"
        }
        RunFailure::Setup(SetupError::FreeAcceleration) => "\n(on the command line: `--a0` or `--f0`)",
        RunFailure::Setup(SetupError::DeterminedAcceleration) => {
            "\n(on the command line: leave out `--a0` and `--f0`)"
        }
        RunFailure::Setup(
            SetupError::ThirdOrder { .. }
            | SetupError::Composition {
                reason: Symmetry::ThirdOrder,
                ..
            },
        ) => "\n(on the command line: leave out `--tolerance`, `--order` and `--estimate-error`)",
        RunFailure::Estimate(RunError::Setup(cause)) if matches!(**cause, SetupError::ThirdOrder { .. }) => {
            "\n(run again with half the `--step`: the two runs differ by three quarters of the first one's error)"
        }
        RunFailure::Run(RunError::Step(error))
            if error.details().index == 1 && error.details().cause.reason == StepFailure::AmbiguousRoot =>
        {
            "\n(on the command line: `--near-a0`, `--step`)"
        }
        RunFailure::Run(RunError::Stage(_)) => {
            "\n(on the command line: a smaller `--step`, `--order 2`, or `--tolerance`)"
        }
        RunFailure::Setup(SetupError::Quaternion { .. }) => {
            "\n(on the command line: `--q0`, all four numbers of it)"
        }
        RunFailure::Setup(SetupError::AngularVelocity { .. }) => {
            "\n(on the command line: `--v0`, three numbers of it)"
        }
        RunFailure::Setup(SetupError::Turn { .. }) => "\n(on the command line: `--step`, or `--tolerance`)",
        RunFailure::Run(RunError::Step(error))
            if error.details().cause.reason == StepFailure::TurnsTooFar =>
        {
            "\n(on the command line: `--step`, or `--tolerance`)"
        }
        RunFailure::Setup(SetupError::Inconsistent { .. }) => "\n(on the command line: `--project`)",
        RunFailure::Run(RunError::TimeBehind { .. }) => {
            "\n(on the command line: `--until` and `--step` of one sign)"
        }
        _ => "",
    }
}

/// The options that do what an error of a check advises; a check begins with position and velocity.
pub(super) fn options_of_check(failure: &CheckFailure) -> Cow<'static, str> {
    match failure {
        CheckFailure::Setup(error @ SetupError::Acceleration { .. }) => {
            match options(&RunFailure::Setup(error.clone())) {
                paper if paper.contains("--start paper") => {
                    "\n(on the command line: `--near-a0`, `--v0`, `--start paper`)".into()
                }
                other => other,
            }
        }
        CheckFailure::Setup(error) => options(&RunFailure::Setup(error.clone())),
        CheckFailure::Run(error) => options(&RunFailure::Run(error.clone())),
        _ => "".into(),
    }
}

/// The options that do what an error of a linear model advises.
pub(super) fn options_of_model(error: &LinearizationError) -> Cow<'static, str> {
    match error {
        LinearizationError::Setup(SetupError::ThirdOrder { .. }) => "".into(),
        LinearizationError::Setup(error) => match options(&RunFailure::Setup(error.clone())) {
            paper if paper.contains("--start paper") => {
                "\n(on the command line: `--near-a0`, `--q0`, `--v0`)".into()
            }
            other => other,
        },
        LinearizationError::Corner { .. } | LinearizationError::Singular { .. } => {
            "\n(on the command line: `--q0`, `--v0`)".into()
        }
        _ => "".into(),
    }
}
