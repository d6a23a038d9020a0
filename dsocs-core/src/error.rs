//! Errors of starts and of steps: messages, details and advice.

pub(crate) mod series;
pub(crate) mod stage;

use core::fmt;
use std::borrow::Cow;

use thiserror::Error;

use crate::error::series::{FORKS, SeriesError};
use crate::number::composition::Composition;
use crate::number::message::{Magnitude, Numbers, Rounded, Short};
use crate::regularity::Regularity;
use crate::regularity::deficiency::{Deficiency, DependentRow, Singularity};
use crate::regularity::undefined::Undefined;
use crate::solve::failure::{History, NewtonFailure, StepFailure};
use crate::tape::{Shape, Symmetry};

/// Makes the `Debug` of an error its message, so that `fn main() -> Result<(), Box<dyn Error>>` and `unwrap`
/// print a readable text.
///
/// A message of this library includes its cause, so the sources of an error need not be printed after it.
#[doc(hidden)]
#[macro_export]
macro_rules! debug_is_message {
    ($error:ident $(<$size:ident>)?) => {
        impl $(<const $size: usize>)? ::core::fmt::Debug for $error $(<$size>)? {
            fn fmt(&self, f: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                ::core::fmt::Display::fmt(self, f)
            }
        }
    };
}

/// Displays a failed iteration; a deficiency of the equations, or an expression without a value, comes first
/// if it is the cause.
struct CauseText<'a>(Option<&'a Deficiency>, Option<&'a Undefined>, &'a NewtonFailure);

impl fmt::Display for CauseText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(deficiency, undefined, cause) = self;
        match (deficiency, undefined) {
            (Some(deficiency), _) => write!(f, "{deficiency} ({}): {}", cause.reason, History(cause)),
            (None, Some(undefined)) => write!(f, "{undefined}"),
            (None, None) => cause.fmt(f),
        }
    }
}

/// A constraint that a start violates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The kind of the constraint.
    pub constraint: &'static str,
    /// Its index among the constraints of its kind, from 0.
    pub index: usize,
    /// The node or the map at which it is imposed.
    pub at: &'static str,
    /// Its value there, in its units.
    pub value: f64,
    /// The magnitude of its terms, in the same units.
    pub size: f64,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            constraint,
            index,
            at,
            value,
            size,
        } = *self;
        if value.is_nan() {
            return write!(f, "{constraint} {} at {at}, where it has no value", index + 1);
        }
        write!(
            f,
            "{constraint} {} at {at} by {}, where its terms are of the size {}",
            index + 1,
            Short(value),
            Short(size)
        )
    }
}

/// Errors of the setup of a run.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SetupError {
    /// The step is zero, infinite or not a number.
    #[error("the step h = {h} must be finite and not zero (a negative step runs back in time)")]
    Step {
        /// The step.
        h: f64,
    },
    /// The step's square, by which accelerations are divided, is zero or infinite in double precision.
    #[error("the step h = {h:e} is out of range: h² must neither underflow nor overflow")]
    StepRange {
        /// The step.
        h: f64,
    },
    /// The start time is infinite or not a number.
    #[error("the start time t0 = {t0} must be finite")]
    StartTime {
        /// The start time.
        t0: f64,
    },
    /// A vector of the start has the wrong number of components.
    #[error(
        "the start's {vector} has {found} components, but {}",
        expected_components(.vector, *.coordinates, *.rotations)
    )]
    StartLength {
        /// The vector: `q0`, `v0` or another one of the start.
        vector: &'static str,
        /// The number of its components.
        found: usize,
        /// The number of components of a position.
        coordinates: usize,
        /// The number of rotations; each takes four of the components of a position and three of a velocity.
        rotations: usize,
    },
    /// A component of the start is infinite or not a number.
    #[error("component `{coordinate}` of the start's {vector} is {value}; it must be finite")]
    Start {
        /// `q0`, `v0` or `q1`.
        vector: &'static str,
        /// The coordinate's name.
        coordinate: Cow<'static, str>,
        /// The value.
        value: f64,
    },
    /// The start violates holonomic or nonholonomic constraints.
    #[error(
        "the start violates {}; expected a start that obeys what is declared, or project it (`Start::projected`)",
        .violations.iter().map(ToString::to_string).collect::<Vec<_>>().join(", and ")
    )]
    Inconsistent {
        /// All violated constraints.
        violations: Vec<Violation>,
    },
    /// No nearby start that obeys the constraints was found.
    #[error(
        "the start could not be projected onto the constraints: what is left of them is {}; try a start nearer to them, where their derivatives are not zero",
        Numbers(.residual)
    )]
    Projection {
        /// The values of the constraints where the projection ended.
        residual: Vec<f64>,
    },
    /// The start was computed for another step.
    #[error(
        "the start was computed by `Start::exact` for the step h = {start}, but the run has h = {h}: its second node depends on the step, so call `exact` with the step of the run"
    )]
    StartStep {
        /// The step that the start was computed for.
        start: f64,
        /// The step of the run.
        h: f64,
    },
    /// The start was computed for another time than that of the run, and the system depends on time.
    #[error(
        "the start was computed by `Start::exact` for the time {start}, but the run begins at {t0}: set the time before, `Start::second_order(q0, v0).at({t0}).exact(…)`"
    )]
    StartMoved {
        /// The time that the start was computed for.
        start: f64,
        /// The time at which the run begins.
        t0: f64,
    },
    /// A parameter is infinite or not a number.
    #[error("parameter `{name}` is {value}; it must be finite")]
    Parameter {
        /// The parameter's name.
        name: Cow<'static, str>,
        /// The value.
        value: f64,
    },
    /// A parameter lies below the smallest normal number, where numbers have lost digits.
    #[error(
        "parameter `{name}` is {value:e}: below 2.2e-308 numbers have fewer digits, and below 5e-324 none; measure in larger units, or multiply the Lagrangian and \
         the forces by a number, which changes no motion"
    )]
    SubnormalParameter {
        /// The parameter's name.
        name: Cow<'static, str>,
        /// The value.
        value: f64,
    },
    /// The equations are so small that products in them have lost their digits.
    #[error(
        "the equations at the start are so small that numbers have no digits left for them: the acceleration {acceleration:.3e} of `{coordinate}` is known to {lost:.0e}, since products \
         fall below 2.2e-308; measure in larger units, or multiply the Lagrangian and the forces by a number, which changes no motion"
    )]
    Underflow {
        /// The coordinate's name.
        coordinate: Cow<'static, str>,
        /// Its acceleration.
        acceleration: f64,
        /// Bound on the error of this acceleration.
        lost: f64,
    },
    /// The steps of this system cannot be composed.
    #[error(
        "{method} is not possible here: {reason}; take the step of order 2 (Flow){}",
        if *.reason == Symmetry::ThirdOrder { "" } else { " or the continuous motion to a tolerance (TaylorFlow)" }
    )]
    Composition {
        /// The method.
        method: Composition,
        /// The reason.
        reason: Symmetry,
    },
    /// The second-order start needs the initial acceleration, which the continuous system does not give.
    #[error(
        "the acceleration at the start q0 = {}, v0 = {} cannot be solved for: {}; {}",
        Numbers(.q0), Numbers(.v0), CauseText(.deficiency.as_deref(), .undefined.as_deref(), .cause),
        acceleration_advice(.v0, .cause, (.deficiency.as_deref(), .undefined.as_deref(), *.at_any_velocity))
    )]
    Acceleration {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
        /// Deficiency of the equations there, if it is the cause.
        deficiency: Option<Box<Deficiency>>,
        /// Expression without a value there, if it is the cause.
        undefined: Option<Box<Undefined>>,
        /// Whether the equations fail at this position with other velocities, too, for the same reason.
        at_any_velocity: bool,
        /// Failure of Newton's iteration for the acceleration.
        #[source]
        cause: Box<NewtonFailure>,
    },
    /// The equations for the acceleration are singular at the start, to within rounding.
    #[error(
        "the equations are singular at the start q0 = {}, v0 = {}: {}, so that the acceleration that they give is rounding; {}",
        Numbers(.q0), Numbers(.v0),
        .deficiency.as_ref().map_or_else(
            || "a few roundings beside it, their determinant is another one".to_owned(),
            ToString::to_string
        ),
        .deficiency.as_deref().filter(|deficiency| deficiency.is_redundancy()).and_then(Deficiency::advice).unwrap_or("start beside it")
    )]
    Singular {
        /// The position.
        q0: Vec<f64>,
        /// The velocity.
        v0: Vec<f64>,
        /// Deficiency of the equations there, if it was found.
        deficiency: Option<Box<Deficiency>>,
    },
    /// The first two nodes are equal, and every later step would rest there, only because a kinematic
    /// constraint has a factor that vanishes at rest.
    #[error(
        "from this start the system would stay at rest for ever: {deficiency}, so rest solves every step, whatever forces act; {}",
        .deficiency.advice().unwrap_or("start with a velocity")
    )]
    Rest {
        /// Deficiency of the equations at rest.
        deficiency: Box<Deficiency>,
    },
    /// The method needs an initial velocity, but the start gives two nodes.
    #[error(
        "the start gives two nodes, and this method begins with a position and a velocity: give them \
         (`Start::second_order`), or take the step of order 2 (Flow)"
    )]
    Velocity,
    /// A constraint is of third order, so the initial acceleration is free, but the start does not give it.
    #[error(
        "a constraint here is of third order, so that the acceleration at the start is free: give it (`Start::third_order(q0, v0, a0)`), or \
         the constraint force there (`Start::third_order_by_force(q0, v0, force)`)"
    )]
    FreeAcceleration,
    /// The start gives an acceleration, but the equations determine it.
    #[error(
        "the start gives an acceleration, and no constraint here is of third order: the equations determine it; take \
         `Start::second_order(q0, v0)`, and `near_acceleration` where they have several solutions"
    )]
    DeterminedAcceleration,
    /// The equations cannot be solved for the acceleration that belongs to the constraint force of the start.
    #[error(
        "no acceleration belongs to the constraint force at the start (what is left is {}), since the mass matrix is singular there: \
         give the acceleration (`Start::third_order`)", Magnitude(*.left)
    )]
    StartForce {
        /// The part of the force that is not balanced, as a magnitude.
        left: f64,
    },
    /// The equations cannot be solved for the third derivative at the start.
    #[error(
        "the third derivative at the start cannot be computed: {}; the rate of the constraint force must change the constraint of third order, but here the \
         matrix ∂c/∂j · M⁻¹ · α (constraint c, third derivatives j, mass matrix M, form α of the force) is singular: declare a force that \
         acts on what the constraint prescribes, or start where it does",
        .deficiency.as_ref().map_or_else(|| "its equations have no solution that is found".to_owned(), ToString::to_string)
    )]
    Jerk {
        /// Deficiency of the equations there, if it is the cause.
        deficiency: Option<Box<Deficiency>>,
    },
    /// A constraint is of third order, and the method allows at most second.
    #[error(
        "{method} knows constraints of up to second order, and one here is of third: take the discrete flow (Flow), which has an error of h²"
    )]
    ThirdOrder {
        /// The method.
        method: &'static str,
    },
    /// A coordinate is a rotation, and the method allows only scalar coordinates.
    #[error("{method} knows coordinates that are numbers, so far, and one here is a rotation: {instead}")]
    Rotation {
        /// The method.
        method: &'static str,
        /// The method to use instead.
        instead: &'static str,
    },
    /// A quaternion of the start does not have norm 1.
    #[error(
        "the quaternion of `{rotation}` in the start's q0 has the norm {norm}; expected one of norm 1 (w, x, y, z), the scalar first: it is brought there \
         from a millionth away, and no farther"
    )]
    Quaternion {
        /// The coordinate.
        rotation: String,
        /// The norm.
        norm: f64,
    },
    /// The first component of a rotation's velocity, which is not used, is not zero.
    #[error(
        "the velocity of `{rotation}` in the start's v0 begins with {value}; expected 0, and then the three numbers of the angular velocity in the frame of the body"
    )]
    AngularVelocity {
        /// The coordinate.
        rotation: String,
        /// The first component of the velocity.
        value: f64,
    },
    /// A rotation turns by more than a step allows in the first step.
    #[error(
        "in the first step, h = {h}, `{rotation}` turns by {turn:.2} rad, and 3 rad is the most that a step knows: take a smaller h"
    )]
    Turn {
        /// The coordinate.
        rotation: String,
        /// The angle, in radians.
        turn: f64,
        /// The step.
        h: f64,
    },
    /// The tolerance is out of range.
    #[error(
        "the tolerance is {relative} (relative) and {absolute} (absolute); the first must lie between 0 and 1 (1.1e-16, the unit round-off, is the least \
         that can be reached), the second not be negative"
    )]
    Tolerance {
        /// The relative part.
        relative: f64,
        /// The absolute part.
        absolute: f64,
    },
    /// The system is a bare tape, without recurrences for Taylor series.
    #[error(
        "a tape alone has no Taylor series: their recurrences belong to a text (`text::Text`) or a compiled system"
    )]
    NoSeries,
    /// The motion has no Taylor series at the start.
    #[error(transparent)]
    Series(#[from] SeriesError),
}

crate::debug_is_message!(SetupError);

impl SetupError {
    /// An error if the system has rotations, which names the method and its substitute.
    pub(crate) fn for_rotations(shape: &Shape, [method, instead]: [&'static str; 2]) -> Result<(), Self> {
        if shape.rotations.is_empty() {
            Ok(())
        } else {
            Err(Self::Rotation { method, instead })
        }
    }
}

/// The expected number of components of a vector of the start, as a part of the message.
fn expected_components(vector: &str, coordinates: usize, rotations: usize) -> String {
    if rotations == 0 {
        format!("there are {coordinates} coordinates")
    } else if vector.starts_with('q') {
        format!("{coordinates} are expected: of a rotation the four of a unit quaternion (w, x, y, z)")
    } else {
        let count = coordinates - rotations;
        format!("{count} are expected: of a rotation three, in the frame of its body")
    }
}

/// Advice at a multiple root.
const MULTIPLE: &str = "every update of the iteration is the same part of the one before, so several solutions are one here, and the equations do not \
                        determine it as the theorem asks: write the root itself instead of a power of it, as `ddot(x) + x` for `(ddot(x) + x).powi(2)`";

/// Advice at a singularity of the equations.
const SINGULAR: &str = "either the motion ends there, or it turns away within a time much shorter than the step: a run to a tolerance (`TaylorFlow`, `--tolerance`) \
                        tells which. What this step finds beyond is no continuation. Where the motion ends, end the run before, or look for what vanishes there \
                        (a mass, the coefficient of an acceleration or a jerk in a constraint, the forces' hold on what it prescribes)";

/// Advice if the acceleration at the start cannot be solved for.
fn acceleration_advice(
    v0: &[f64],
    cause: &NewtonFailure,
    (deficiency, undefined, at_any_velocity): (Option<&Deficiency>, Option<&Undefined>, bool),
) -> &'static str {
    if let Some(advice) = deficiency.and_then(Deficiency::advice) {
        return advice;
    }
    if let Some(undefined) = undefined {
        return undefined.advice(v0.iter().all(|&v| v == 0.0));
    }
    if cause.is_at_multiple_root() {
        return MULTIPLE;
    }
    let at_rest = v0.iter().all(|&v| v == 0.0) && !at_any_velocity;
    match (cause.reason, at_rest) {
        (StepFailure::NotFinite, true) => {
            "the system starts at rest, where an expression of the declaration has no value: a constraint on the direction of \
             the velocity, or the quotient of a constraint and the factor in `branch`, where that factor is zero; start with a \
             velocity, or write the constraint as the quotient itself"
        }
        (StepFailure::NotFinite, false) => {
            "an expression of the declaration or its derivative has no value there (a division by zero, a root of zero or of a negative \
             number): check the start and the parameters"
        }
        (_, true) => {
            "the system starts at rest, where the acceleration may not be unique: start with a velocity, say which one is meant \
             (`Start::near_acceleration`), or give both first nodes (`Start::nodes`)"
        }
        (_, false) => {
            "if the equations have several solutions, say which one is meant (`Start::near_acceleration`); or use the paper's \
             start (`Start::paper`), which needs no acceleration"
        }
    }
}

/// State and diagnosis of a failed step.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedStep {
    /// The number of the step's middle node `q1`, counted as in [`crate::Node::index`].
    pub index: u64,
    /// The time of the middle node.
    pub time: f64,
    /// The step `h`.
    pub h: f64,
    /// The step's first node.
    pub q0: Vec<f64>,
    /// The step's middle node.
    pub q1: Vec<f64>,
    /// The last candidate for the third node; of two candidates, the one found first.
    pub q2: Vec<f64>,
    /// The second candidate for [`StepFailure::AmbiguousRoot`]; otherwise empty.
    pub other: Vec<f64>,
    /// The certificate of the equations at the last candidate.
    pub regularity: Regularity,
    /// The coordinates' names.
    pub coordinates: Vec<Cow<'static, str>>,
    /// Whether `branch = divide(…)` may help: there is a kinematic constraint, and no `branch` is declared.
    pub may_divide: bool,
    /// Deficiency of the equations at the last candidate, if it is the cause.
    pub deficiency: Option<Deficiency>,
    /// Expression without a value at the middle node, if it is the cause.
    pub undefined: Option<Undefined>,
    /// Whether a constraint is of third order, so that a step solves for a jerk.
    pub third_order: bool,
    /// Approximate time at which the equations become singular and the acceleration (in third order, the
    /// jerk) grows without bound, if it is the cause.
    pub singular_at: Option<f64>,
    /// Approximate time at which a constraint becomes dependent on the earlier ones, or nearly so, and this
    /// row, if it may be the cause.
    pub dependent: Option<(f64, DependentRow)>,
    /// A holonomic constraint that holds at the middle node with zero gradient, or a nonholonomic one that does at a velocity near that of the step, if it
    /// may be the cause.
    pub without_gradient: Option<DependentRow>,
    /// For [`StepFailure::NoSolution`], the rows that do not vanish at the minimum of the residual, each with
    /// its value in its units; otherwise empty.
    pub unmet: Vec<(DependentRow, f64)>,
    /// Failure of Newton's iteration from the best guess; the other guesses failed, too.
    pub cause: NewtonFailure,
}

impl FailedStep {
    /// The coordinate in which two candidates differ most, relative to its increment, and this difference in
    /// its units.
    fn apart(&self) -> Option<(&str, f64)> {
        let legs = self.q0.iter().zip(&self.q1).map(|(q0, q1)| (q1 - q0).abs());
        let legs: Vec<f64> = legs.collect();
        let longest = legs
            .iter()
            .fold(f64::MIN_POSITIVE, |longest, &leg| longest.max(leg));
        let apart = self
            .q2
            .iter()
            .zip(&self.other)
            .map(|(one, other)| (one - other).abs());
        let places = self.coordinates.iter().zip(apart).zip(&legs);
        places
            .max_by(|((_, one), leg), ((_, other), other_leg)| {
                // a coordinate at rest has a tiny increment: the longest one of the step limits the ratio
                let relative = |apart: f64, leg: f64| apart / leg.max(1e-3 * longest);
                relative(*one, **leg).total_cmp(&relative(*other, **other_leg))
            })
            .map(|((name, apart), _)| (&**name, apart))
    }
}

/// A step without a solution. The details are boxed, so that the result of a successful step stays small.
#[derive(Clone, PartialEq)]
pub struct StepError(Box<FailedStep>);

crate::debug_is_message!(StepError);

impl StepError {
    /// Wraps the details.
    pub(crate) fn new(details: FailedStep) -> Self {
        Self(Box::new(details))
    }

    /// State and diagnosis of the failed step.
    #[must_use]
    pub fn details(&self) -> &FailedStep {
        &self.0
    }

    /// Adds the cause: a singularity within the step, beyond which no motion continues.
    pub(crate) fn at(mut self, singularity: Singularity) -> Self {
        self.0.singular_at = Some(singularity.time);
        self.0.deficiency = singularity.deficiency;
        self
    }

    /// Advice for the user.
    fn advice(&self) -> &'static str {
        let step = &*self.0;
        if step.singular_at.is_some() {
            return SINGULAR;
        }
        if let Some(DependentRow::Nonholonomic(_)) = step.without_gradient {
            return "the motion comes to where nothing determines this force, and a smaller h does not help: end the run before, or write rows whose gradients are \
                    independent where they hold";
        }
        if step.without_gradient.is_some() {
            return "write rows whose gradients are independent where they hold: two rows for an axis, `(r * a).inner(s * b)` and `(r * a).inner(s * c)`, in place of \
                    `(r * a).inner(s * a) - 1`; `x` in place of `x.powi(2)`";
        }
        if step.dependent.is_some() {
            return "the motion may go on there in more than one way, and a smaller h decides by chance: end the run before, change a length a little, or \
                    leave out what the constraints say twice there";
        }
        // where a factor may be divided out, this advice comes first
        let deficiency = step.deficiency.as_ref().filter(|_| !step.may_divide);
        if let Some(advice) = deficiency.and_then(Deficiency::advice) {
            return advice;
        }
        match &step.undefined {
            Some(undefined) if step.index == 1 => return undefined.advice(step.q0 == step.q1),
            Some(undefined) if undefined.overflows() => return undefined.advice(false),
            // a quotient by zero has no value whatever the step is
            Some(undefined) if undefined.value == 0.0 => {
                return "the equations have no limit at this node, and the motion ends here, unless what is infinite can be integrated: end the run before, \
                        or write what is bounded without the divisor";
            }
            Some(_) => return "the motion ends here, unless a smaller h leads past",
            None => {}
        }
        if step.cause.is_at_multiple_root() {
            return MULTIPLE;
        }
        match step.cause.reason {
            StepFailure::NotFinite | StepFailure::Degenerate if step.q0 == step.q1 => {
                "the system is at rest here (q0 = q1), where a constraint on the direction of the velocity has no value, nor has \
                 the quotient of a constraint and the factor in `branch`: start with a velocity that is not zero, or write the \
                 constraint as the quotient itself; or a potential has no derivative at this position: start elsewhere"
            }
            StepFailure::NotFinite => {
                "some expression of the declaration has no value here (a division by zero, a root or logarithm of a \
                 negative number, an overflow): check the start and the parameters, and try a smaller h"
            }
            StepFailure::TurnsTooFar => {
                "try a smaller h: a step is to resolve how the body turns; or look for what makes it turn faster and faster"
            }
            StepFailure::Singular if step.may_divide => {
                "the constraints and the variational equations are not independent here; if two roots meet at a factor \
                 of the constraint, divide it out with `branch = divide(factor)`"
            }
            StepFailure::Singular => {
                "the constraints and the variational equations are not independent here: look for a constraint that \
                 repeats another one, or for a coordinate whose acceleration nothing determines"
            }
            StepFailure::Degenerate => {
                "the declaration divides by something that is zero at this root, or a parameter makes one of its rows \
                 vanish: look for a velocity or a mass that is zero"
            }
            StepFailure::AmbiguousRoot if step.index == 1 => {
                "say with which acceleration the motion begins (`Start::near_acceleration`), choose a root with \
                 `Flow::advance_to`, or try a smaller h"
            }
            StepFailure::AmbiguousRoot if step.may_divide => {
                "name the factor that belongs to the unwanted root with `branch = divide(factor)`, choose a root with \
                 `Flow::advance_to`, or try a smaller h"
            }
            StepFailure::AmbiguousRoot => "choose a root with `Flow::advance_to`, or try a smaller h",
            StepFailure::NoSolution
                if !step
                    .unmet
                    .iter()
                    .any(|(row, _)| row.is_constraint() || row.is_work()) =>
            {
                "the motion ends here, unless a smaller h leads past: a force or a velocity may grow without bound, as where a mass vanishes"
            }
            StepFailure::NoSolution => {
                "the motion ends here, unless a smaller h leads past: ask whether the constraint forces can do at this state what the \
                 constraints ask for, with the external forces that act"
            }
            StepFailure::PassesSingularity => SINGULAR,
            StepFailure::PassesRest => {
                "say how it goes on: the smooth motion has the last candidate, which `Flow::advance_to` takes, and there what the constraint prescribes, \
                 such as a curvature, may change its sign; for the motion on which it goes on, prescribe it itself, as a row of second order with \
                 its value as a function of `t`, or begin another run behind the rest (`Start::third_order`)"
            }
            StepFailure::Forks => FORKS,
            StepFailure::NotConverged if step.may_divide => {
                "try a smaller h and check that the start is consistent with the constraints; if two roots meet, name \
                 the factor that belongs to the unwanted one with `branch = divide(factor)`"
            }
            StepFailure::NotConverged => {
                "try a smaller h and check that the start is consistent with the constraints"
            }
        }
    }
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let step = &*self.0;
        // a lost rank of the constraints causes all other failures, so it is named first
        let rank = step.dependent.as_ref().map_or_else(String::new, |(time, row)| {
            format!(
                "the rank of the constraints is lost, or nearly so, near t = {}, where {row} says nothing beside the others; ",
                Rounded(*time)
            )
        });
        write!(
            f,
            "step {} at t = {} (h = {}) has no {}solution: {rank}{}; ({}): q0 = {}, q1 = {}, last candidate q2 = {}",
            step.index,
            Rounded(step.time),
            step.h,
            if step.other.is_empty() && step.cause.reason != StepFailure::Forks {
                ""
            } else {
                "unique "
            },
            CauseText(step.deficiency.as_ref(), step.undefined.as_ref(), &step.cause),
            step.coordinates.join(", "),
            Numbers(&step.q0),
            Numbers(&step.q1),
            Numbers(&step.q2),
        )?;
        if !step.other.is_empty() {
            write!(f, " or {}", Numbers(&step.other))?;
            if let Some((name, apart)) = step.apart() {
                write!(f, ", farthest apart in `{name}`, by {apart:.1e}")?;
            }
        }
        for (row, left) in &step.unmet {
            write!(
                f,
                "; the smallest value of {row} that is reached is {}, and it has to be 0",
                Short(left.abs())
            )?;
        }
        match &step.without_gradient {
            Some(row @ DependentRow::Nonholonomic(_)) => write!(
                f,
                "; {row} has no gradient at a velocity near that of this step, where it holds, so that it does not determine its multiplier"
            )?,
            Some(row) => write!(
                f,
                "; {row} has no gradient at q1, where it holds, so that no force belongs to it"
            )?,
            None => {}
        }
        if let Some(time) = step.singular_at {
            write!(
                f,
                "; the equations become singular near t = {}, where the {} grows without bound",
                Rounded(time),
                if step.third_order { "jerk" } else { "acceleration" }
            )?;
        }
        let condition = step.regularity.condition();
        if condition.is_finite() {
            write!(f, ", condition {condition:.0e} there")?;
        }
        write!(f, "; {}", self.advice())
    }
}

impl core::error::Error for StepError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        Some(&self.0.cause)
    }
}
