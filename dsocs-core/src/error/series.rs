//! Reasons why a Taylor series could not go on.

use core::fmt;
use std::borrow::Cow;

use thiserror::Error;

use crate::regularity::deficiency::{Deficiency, DependentRow};
use crate::regularity::undefined::Undefined;

/// Advice if a user's function sticks.
const UNDECLARED: &str = "Such a motion goes on at rest where a `signum` or a comparison of the declaration itself jumps with the velocity, and the forces \
    at rest are determined. Declare it so, without a function of your own; or replace the jump by a steep smooth function, such as `(v / 0.001).tanh()` for \
    `v.signum()`";

/// Advice if declared functions stick and no state of rest is found.
const UNHELD: &str = "No values between the two sides are found that hold it there: they are where a function jumps with the velocity by a finite amount, and \
    the forces at rest are determined. They are not where the force on each side vanishes with the velocity, as its root does, where infinitely many changes \
    of sides lead there, or where the factor of a constraint vanishes at rest. Let the run end before; or replace the jump by a steep smooth function, such as \
    `(v / 0.001).tanh()` for `v.signum()`; or take steps of a fixed length, which pass such a place with an error of the first order";

/// Advice if an acceleration jumps from both sides, and no expansion shows which function does.
const UNSEEN: &str = "It may be a quotient by a norm that vanishes there, as that of friction along `slip / slip.norm()`, which has no value where the slip ends, \
    or a function of your own. Let the run end before; or replace it by a smooth one, such as `slip / (slip.norm_squared() + 1e-6).sqrt()`";

/// Advice if a body at rest may go on in more than one way.
pub(crate) const FORKS: &str = "say which: begin with a velocity, however small, to the side that is meant (`--v0`, or a run from here), or with a force that is \
    larger than the jump, or hold it by a constraint; if it is to be friction, give it the sign that is against the velocity; and if it raises its own normal \
    force, as in a rod that jams, replace the rigid contact by a stiff spring";

/// Advice where a quotient is 0/0 and has no limit.
const NODE: &str = "is zero there, and so is what is divided by it, without a limit of the quotient: motions that differ before come there with the \
    same velocity, and nothing says which of them goes on. End the run before; or write a force whose numerator vanishes wherever the divisor does; \
    or give the quotient a limit, such as `x / (x.powi(2) + 1e-6)` for `1 / x`";

/// Reasons for the failure of a run by Taylor series.
#[derive(Clone, PartialEq, Error)]
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
        /// The number of steps that were made.
        steps: u64,
        /// The length of the last one.
        last: f64,
        /// The mean length.
        mean: f64,
    },
    /// The steps have become so short that the motion no longer advances.
    #[error("{steps} steps have led {led:e} further")]
    Stalls {
        /// The number of consecutive steps.
        steps: u64,
        /// The time that they advanced.
        led: f64,
    },
    /// The motion oscillates about a place where the acceleration jumps, and no expansion shows which
    /// function does.
    #[error("{steps} steps, which led {led:e} further, ended with another acceleration than their series")]
    BackAndForth {
        /// The number of steps that ended so.
        steps: u32,
        /// The time that they advanced.
        led: f64,
    },
    /// The acceleration is unbounded at a place within the next step: the equations do not determine it
    /// there, and the motion ends.
    #[error("the acceleration has no bound at t = {time}")]
    Unbounded {
        /// The time of that place.
        time: f64,
    },
    /// The acceleration is 0/0 at a place within the next step, where a divisor, or the determinant of the
    /// equations, vanishes. Many motions come there with the same velocity, and nothing says which of them goes
    /// on.
    #[error("the motion is not unique beyond t = {time}")]
    NotUnique {
        /// The time of that place.
        time: f64,
        /// The divisor, if it is a coordinate or a velocity.
        divisor: Option<String>,
    },
    /// Constraints depend on each other at a place within the next step. There they admit velocities that
    /// they exclude elsewhere, and the motion may continue in more than one way, as that of a linkage at a
    /// change point.
    #[error("{row} says nothing beside the other constraints at t = {time}")]
    Dependent {
        /// The time of that place.
        time: f64,
        /// The first constraint that depends there on those before it.
        row: DependentRow,
    },
    /// The motion has come to a place where a function jumps and both sides lead back to it, and no motion at
    /// rest is found: the function is one of your own, or does not depend on the velocity, or no forces
    /// between its two sides hold the motion there.
    #[error("the motion sticks where `{switch}` is zero")]
    Sticks {
        /// The argument whose sign changes there, as written in the declaration. For a comparison in one of your functions, the function's
        /// name.
        switch: Cow<'static, str>,
        /// Whether the declaration itself has piecewise functions; if not, one of your own jumps.
        is_declared: bool,
    },
    /// A body at rest may go on in more than one way, where a force jumps with the velocity: it may leave to
    /// either side, as by a force along the velocity, or leave and stay, as with friction that raises its own
    /// normal force. Or the motion begins where a force jumps with the position, and leads away on both sides.
    #[error("what is at rest may leave in more than one way, or stay")]
    Forks,
    /// The velocity, or the position, would have to jump: the state before a switch, or before a time at
    /// which steps end, is not a state of the system beyond it.
    #[error("the {} would have to jump", .by.what())]
    Jumps {
        /// The switch, as above; `None` at such a time.
        switch: Option<Cow<'static, str>>,
        /// The cause of the jump.
        by: Jump,
    },
}

crate::debug_is_message!(SeriesFailure);

/// The cause of a jump of the velocity or the position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Jump {
    /// A holonomic constraint jumps: the position would have to jump.
    Position,
    /// A holonomic constraint has a corner, or a nonholonomic one jumps.
    Constraint,
    /// The Lagrangian jumps along the motion, or the momentum does.
    Lagrangian,
}

impl Jump {
    /// The quantity that would have to jump.
    fn what(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Constraint | Self::Lagrangian => "velocity",
        }
    }
}

/// With a relative tolerance above this, errors of the steps may have led to the place where a motion ends.
const LOOSE: f64 = 1e-5;

/// A last step below this part of the mean shows that steps have become shorter and shorter.
const COLLAPSED: f64 = 1e-3;

/// State and diagnosis of a failed run by Taylor series.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedSeries {
    /// The number of steps before the failure.
    pub step: u64,
    /// The time.
    pub time: f64,
    /// The position.
    pub q: Vec<f64>,
    /// The velocity.
    pub v: Vec<f64>,
    /// The coordinates' names.
    pub coordinates: Vec<Cow<'static, str>>,
    /// The expression without a value, if it is the cause.
    pub undefined: Option<Undefined>,
    /// The near-deficiency of the equations for the acceleration, if steps have become short.
    pub deficiency: Option<Deficiency>,
    /// Whether there is a kinematic constraint, so that a vanishing factor of it may be the cause.
    pub may_divide: bool,
    /// Whether the declaration calls functions of your own.
    pub calls: bool,
    /// The relative tolerance of a step.
    pub tolerance: f64,
    /// The cause.
    pub cause: SeriesFailure,
}

/// A run by Taylor series that failed, or did not begin. The details are boxed, so that the result of a
/// successful step stays small.
#[derive(Clone, PartialEq)]
pub struct SeriesError(Box<FailedSeries>);

crate::debug_is_message!(SeriesError);

impl SeriesError {
    /// Wraps the details.
    pub(crate) fn new(details: FailedSeries) -> Self {
        Self(Box::new(details))
    }

    /// State and diagnosis of the motion where the series ended.
    #[must_use]
    pub fn details(&self) -> &FailedSeries {
        &self.0
    }

    /// The time at which the motion ends, in the declaration's unit: that of the place within the next step, if the cause names one, else the time
    /// that was reached.
    #[must_use]
    pub fn ends_at(&self) -> f64 {
        match self.details().cause {
            SeriesFailure::Unbounded { time }
            | SeriesFailure::NotUnique { time, .. }
            | SeriesFailure::Dependent { time, .. } => time,
            _ => self.details().time,
        }
    }
}

impl fmt::Display for SeriesError {
    #[allow(clippy::too_many_lines)] // one text after another
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FailedSeries {
            time: t,
            q,
            v,
            coordinates,
            undefined,
            deficiency,
            may_divide,
            calls,
            tolerance,
            cause,
            ..
        } = &*self.0;
        let singular = Singular {
            deficiency: deficiency.as_ref(),
            may_divide: *may_divide,
            calls: *calls,
            tolerance: *tolerance,
            at: (q, v),
        };
        match (cause, undefined) {
            (SeriesFailure::NotFinite, Some(undefined)) => write!(
                f,
                "the motion has no Taylor series at t = {t}, ({}) = {q:?}, with the velocity {v:?}: {undefined}; {}",
                coordinates.join(", "),
                undefined.advice(v.iter().all(|&v| v == 0.0))
            ),
            (SeriesFailure::NotFinite, _) => write!(
                f,
                "the Taylor series at t = {t}, ({}) = {q:?}, with the velocity {v:?}, is not finite: some expression of the \
                 declaration has no value or no derivative there, or the constraints do not determine the acceleration",
                coordinates.join(", ")
            ),
            (SeriesFailure::Dependent { time, row }, _) => write!(
                f,
                "the rank of the constraints is lost at t = {time:.9}, past which the step from t = {t}, ({}) = {q:?}, with the velocity {v:?}, would \
                 lead: {row} says nothing there beside the others. The motion may go on in more than one way, and no tolerance decides which: end \
                 the run before, change a length a little, or leave out what the constraints say twice there",
                coordinates.join(", ")
            ),
            (SeriesFailure::Unbounded { time }, _) => write!(
                f,
                "the acceleration has no bound at t = {time:.9}, past which the step from t = {t} would lead: {singular}"
            ),
            (SeriesFailure::NotUnique { time, divisor }, _) => {
                let coordinates = coordinates.join(", ");
                let divisor = divisor.as_ref().map(|divisor| format!("the divisor `{divisor}`"));
                let divisor = divisor
                    .as_deref()
                    .unwrap_or("a divisor, or the determinant of the equations,");
                write!(
                    f,
                    "the motion is not unique beyond t = {time:.9}, past which the step from t = {t}, ({coordinates}) = {q:?}, with the velocity {v:?}, \
                     would lead: {divisor} {NODE}"
                )
            }
            (SeriesFailure::StepTooSmall { step, smallest }, _) => write!(
                f,
                "the step at t = {t} would be {step:e}, less than the smallest allowed, {smallest:e}: {singular}"
            ),
            (SeriesFailure::Stalls { steps, led }, _) => write!(
                f,
                "the motion gets no further than t = {t}: the last {steps} steps led {led:.1e} s on: {singular}"
            ),
            (SeriesFailure::BackAndForth { steps, led }, _) => write!(
                f,
                "the motion goes back and forth at t = {t}, ({}) = {q:?}, with the velocity {v:?}: {steps} steps, which led {led:.1e} s on, ended \
                 with another acceleration than their series tell, however short they were. Something jumps there from both sides. {UNSEEN}",
                coordinates.join(", ")
            ),
            (SeriesFailure::TooManySteps { steps, last, mean }, _)
                if *last < COLLAPSED * mean || deficiency.is_some() =>
            {
                write!(
                    f,
                    "{steps} steps have been made and t = {t} reached, where they have become as short as {last:e}; their mean is \
                 {mean:e}. More steps would hardly help: {singular}"
                )
            }
            (SeriesFailure::TooManySteps { steps, .. }, _) => write!(
                f,
                "{steps} steps have been made and t = {t} reached: allow more, or a larger tolerance; if a larger one makes them no fewer, the motion is \
                 stiff. Steps of a fixed length may lead on: where they do, halves of them change little"
            ),
            (SeriesFailure::Sticks { switch, is_declared }, _) => {
                let coordinates = coordinates.join(", ");
                write!(
                    f,
                    "the motion sticks at t = {t}, ({coordinates}) = {q:?}, with the velocity {v:?}: `{switch}` is zero there, and the motions on both of \
                     its sides lead back. {}",
                    if *is_declared { UNHELD } else { UNDECLARED }
                )
            }
            (SeriesFailure::Forks, _) => write!(
                f,
                "the motion is not unique beyond t = {t}, ({}) = {q:?}, with the velocity {v:?}: what is at rest may leave in more than one way, or \
                 stay, since a force jumps with the velocity or the position, and more than one of its values there continues the motion; {FORKS}",
                coordinates.join(", ")
            ),
            (SeriesFailure::Jumps { switch, by }, _) => {
                let what = by.what();
                write!(
                    f,
                    "the {what} would have to jump at t = {t}, ({}) = {q:?}, with the velocity {v:?}: {}; or let the run end here, and begin another \
                     one with the {what} after the jump",
                    coordinates.join(", "),
                    JumpText(switch.as_deref(), *by)
                )
            }
        }
    }
}

/// The cause of a jump of the velocity or the position, and what to write instead.
struct JumpText<'a>(Option<&'a str>, Jump);

impl fmt::Display for JumpText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(switch, by) = *self;
        if let Some(function) = switch.and_then(function_of) {
            let user = match by {
                Jump::Position | Jump::Constraint => "a constraint on positions or velocities",
                Jump::Lagrangian => "the momentum",
            };
            return write!(
                f,
                "`{function}` has a corner or a jump there, and {user} depends on it. Use a smooth interpolation: `Samples::monotone` or \
                 `Samples::cubic` for `Samples::linear`{}, and in a function of your own a smooth one for `if`, `min`, `max` or `abs`",
                if function.strip_suffix(".at").is_some() {
                    " (at the end of a table: add level samples)"
                } else {
                    ""
                }
            );
        }
        let place = match switch {
            Some(switch) => format!("`{switch}` is zero there, and beyond"),
            None => "beyond this place".to_owned(),
        };
        let (why, advice) = match by {
            Jump::Position => (
                "a holonomic constraint asks for another position than before",
                "make the jump steep and smooth, such as `(x / 0.001).tanh()` for `x.signum()`",
            ),
            Jump::Constraint => (
                "a constraint on positions or velocities asks for another velocity than before. How such an impact goes on (how much energy is \
                 lost) the declaration does not say",
                "round the corner off, as `(x.powi(2) + 1e-6).sqrt()` does for `x.abs()`, or a spline for the linear pieces of `Samples`",
            ),
            Jump::Lagrangian => (
                "the Lagrangian is another, or the momentum that belongs to this velocity is. The force at such a jump is an impulse, which no \
                 derivative of the pieces has",
                "make the jump steep and smooth, such as `(x / 0.001).tanh()` for `x.signum()`",
            ),
        };
        write!(f, "{place} {why}. Either {advice}")
    }
}

/// The name of the function whose comparison is the switch, if it is one.
fn function_of(switch: &str) -> Option<&str> {
    switch.strip_prefix("a comparison in ")
}

/// Displays a place that steps cannot pass: the singular equations there, or a tolerance too large to trust them.
struct Singular<'a> {
    /// The near-deficiency of the equations there.
    deficiency: Option<&'a Deficiency>,
    /// Whether a factor of a constraint may be the cause.
    may_divide: bool,
    /// Whether the declaration calls the user's functions.
    calls: bool,
    /// The relative tolerance of a step.
    tolerance: f64,
    /// The position and the velocity.
    at: (&'a [f64], &'a [f64]),
}

impl fmt::Display for Singular<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (q, v) = self.at;
        let tolerance = self.tolerance;
        let is_loose = tolerance > LOOSE;
        if is_loose {
            // errors of the steps may have led to a place that the motion never reaches: its equations explain nothing
            return write!(
                f,
                "the tolerance {tolerance:e} is large: each step may miss the motion by this part of the velocity, the errors add up, and \
                 they may have led here, where steps become short (q = {q:?}, v = {v:?}). Take a tolerance of 1e-9 or less, which costs \
                 little more. If the motion ends here with it, too, its message says why"
            );
        }
        match self.deficiency {
            Some(deficiency) => write!(
                f,
                "at q = {q:?}, v = {v:?} the equations hardly determine the acceleration: {deficiency}"
            )?,
            None => write!(
                f,
                "the motion comes close to a singularity, or to a place where the system is not smooth (q = {q:?}, v = {v:?})"
            )?,
        }
        if self.may_divide {
            f.write_str(
                ". Perhaps a factor of a kinematic constraint is zero there: divide it out (`branch = divide(factor)`). Or the constraint force \
                 cannot do there what the constraint asks for. In a Lyapunov constraint the power of an external force may be missing: friction \
                 that it forgets has to be added to it",
            )
        } else {
            f.write_str(", or the tolerance is too small")?;
            if self.calls {
                f.write_str(
                    ". If a function of your own branches there, let it compare the numbers that it is given, not their values",
                )?;
            }
            Ok(())
        }
    }
}

impl core::error::Error for SeriesError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        Some(&self.0.cause)
    }
}
