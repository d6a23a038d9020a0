//! The paper's theorems as checks of a system: `dsocs check` prints the table.
//!
//! Each check measures a value (a *figure*) on the default motion of a system and compares it with the limit that it has to meet (its
//! *bar*). Where an equation should hold to rounding, the figure is relative to the size of the equation's terms, and the bar is a
//! small multiple of the unit round-off.

mod motion;
mod order;
pub mod orders;
mod reasons;
mod rotations;
mod theorems;
pub(crate) mod third;

use std::error::Error;

use dsocs_core::__private::TapeKernel;
use dsocs_core::geometry::GeometryError;
use dsocs_core::{NearlySingular, RunError, SeriesError, SetupError, System, Unresolved};

use crate::entry::{CheckFailure, Kind, Motions, Symmetry, TypedSystem};
use crate::stability::{Bar, larger, measured_or_reason, written_time};

use motion::extrapolation::QuadratureError;
use motion::motions::{DoubtfulSteps, MotionNode, State};
use motion::{CheckedMotion, motions, states_at};
use order::FewErrors;
use reasons::dependence::NearlyDependentConstraint;
use reasons::large_numbers::RoundingOfLargeNumbers;
use theorems::{contact, equations, flow, momentum, power, roots, symplectic};

/// The number of steps of a motion, unless an end is given.
const STEPS: f64 = 40.0;

/// A motion may end early if the continuous one ends within this many steps.
const ENDS_NEAR: f64 = 8.0;

/// The properties that a system is expected to have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// The kind of its constraints. Without constraints, and with only holonomic ones, the flow is symplectic.
    pub kind: Kind,
    /// The order.
    pub order: f64,
    /// Whether the step with `−h` is the inverse of that with `h`.
    pub reversible: bool,
}

/// The start of the motion, from its position and velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Begin {
    /// Whether the second node is the paper's, `q1 = q0 + h v0`. With it the motion is of first order, otherwise of second order.
    pub paper: bool,
    /// Whether the start is moved onto the constraints of positions and velocities first.
    pub projected: bool,
}

/// The motion that is checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings<'a> {
    /// The step, in s.
    pub h: f64,
    /// The end, in s. By default it is that of the [`Entry`](crate::Entry), or 40 steps if there is no entry.
    pub until: Option<f64>,
    /// The time of the start, in s.
    pub t0: f64,
    /// The first node.
    pub q0: &'a [f64],
    /// The initial velocity.
    pub v0: &'a [f64],
    /// The initial acceleration, where a constraint is of third order; otherwise the acceleration near which
    /// a solution is looked for.
    pub a0: Option<&'a [f64]>,
    /// The rule for the second node, and projection onto the constraints.
    pub begin: Begin,
}

/// One measured value.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The check.
    pub check: &'static str,
    /// The quantity that is measured.
    pub what: String,
    /// The measured value; NaN where there is none.
    pub figure: f64,
    /// The limit that the figure has to meet.
    pub bar: Bar,
    /// The reason, if there is no figure.
    pub failure: Option<String>,
    /// A remark.
    pub note: Option<String>,
    /// The reason why the figure need not meet its bar: the assumption of the theorem that does not hold on
    /// this motion, and what to try.
    pub excuse: Option<String>,
}

impl Finding {
    /// Whether the figure reaches its bar.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.failure.is_none() && self.bar.holds(self.figure)
    }

    /// Whether it reaches its bar, or is excused.
    #[must_use]
    pub fn ok(&self) -> bool {
        self.holds() || self.excuse.is_some()
    }
}

/// A measured value, or the reason why there is none.
type Measured<T = f64> = Result<T, Box<dyn Error>>;

/// A figure for which there is nothing to compare with is no failure of the scheme.
const NOT_MEASURED: &str = "not measured, and so neither met nor missed: the figure compares with the continuous motion, which is computed by Taylor series, \
    and these do not get through the times that are looked at; to see it, begin elsewhere or end before (`--until`)";

/// The same where the law along the continuous motion is an integral that the quadrature does not reach.
const TOO_STIFF: &str = "not measured, and so neither met nor missed: the law of the continuous motion is an integral along it, which is too stiff for the \
    quadrature of this check; to see it, take a smaller `--step`: the integral reaches over some steps";

/// The same where the errors of a motion do not show an order.
const FEW_ERRORS: &str = "not measured, and so neither met nor missed: an order is the slope of at least three errors; to see it, give a larger \
    step (`--step`)";

/// The same where a state that is looked at lies on a quotient 0/0, which a step passes by its limit, or where a function has no derivative.
const NO_VALUE: &str = "not measured, and so neither met nor missed: an expression of the declaration, or a derivative of it, has no value at a state that is \
    looked at, as of a quotient 0/0 at a node; to see it, take another `--step`, begin elsewhere, or end before (`--until`)";

/// The reason why a figure could not be measured, if the continuous motion, or an integral along it, is not to be had where it is looked at, errors
/// are too few, or a state has no value there.
fn lacks_reference(error: &(dyn Error + 'static)) -> Option<&'static str> {
    if error.is::<QuadratureError>() {
        return Some(TOO_STIFF);
    }
    if error.is::<FewErrors>() {
        return Some(FEW_ERRORS);
    }
    let setup = match error.downcast_ref() {
        Some(GeometryError::Setup(setup)) => Some(setup),
        _ => error.downcast_ref::<SetupError>(),
    };
    let is_undefined = matches!(
        setup,
        Some(SetupError::Acceleration {
            undefined: Some(_),
            ..
        })
    ) || matches!(error.downcast_ref(), Some(GeometryError::Inverse { q2, .. }) if q2.iter().any(|q| q.is_nan()));
    if is_undefined {
        return Some(NO_VALUE);
    }
    let is_series = error.is::<SeriesError>()
        || matches!(error.downcast_ref(), Some(RunError::Series(_)))
        || matches!(error.downcast_ref(), Some(SetupError::Series(_)));
    if is_series {
        return Some(NOT_MEASURED);
    }
    error.source().and_then(lacks_reference)
}

/// The figures of one check.
struct Report {
    /// The check.
    check: &'static str,
    /// The figures so far.
    findings: Vec<Finding>,
}

impl Report {
    /// Adds a figure, or the reason why there is none.
    fn push(&mut self, what: impl Into<String>, bar: Bar, measured: Measured) {
        let excuse = match &measured {
            Ok(figure) if figure.is_nan() => Some(NO_VALUE),
            Ok(_) => None,
            Err(error) => lacks_reference(&**error),
        };
        let (figure, failure) = measured_or_reason(measured);
        self.findings.push(Finding {
            check: self.check,
            what: what.into(),
            figure,
            bar,
            failure,
            note: None,
            excuse: excuse.map(str::to_owned),
        });
    }

    /// Adds a remark on the last figure.
    fn note(&mut self, note: &str) {
        if let Some(last) = self.findings.last_mut() {
            let before = last.note.take().map(|before| before + "; ");
            last.note = Some(before.unwrap_or_default() + note);
        }
    }

    /// Adds several figures that are measured together.
    fn push_all<const K: usize>(&mut self, whats: [(&str, Bar); K], measured: &Measured<[f64; K]>) {
        let excuse = measured
            .as_ref()
            .err()
            .and_then(|error| lacks_reference(&**error));
        for (place, (what, bar)) in whats.into_iter().enumerate() {
            let figure = match measured {
                Ok(figures) => Ok(figures[place]),
                Err(error) => Err(error.to_string().into()),
            };
            self.push(what, bar, figure);
            if let (Some(excuse), Some(last)) = (excuse, self.findings.last_mut()) {
                last.excuse = Some(excuse.to_owned());
            }
        }
    }
}

/// The reason why the theorems on the motion as a whole are not required: in some of its `steps` a function
/// jumps, a coordinate is held at rest, or the equations are nearly singular.
fn excuse(doubtful: DoubtfulSteps, held: usize, steps: usize) -> Option<String> {
    if let Some(NearlySingular { first, .. }) = doubtful.nearly_singular {
        return Some(format!(
            "not required here: the theorem is about motions along which the equations are regular, and here they come near to a singularity, first about \
             t = {}, beside which errors do not fall as a power of the step; to see it required, end before (`--until`)",
            written_time(first)
        ));
    }
    let jumps = doubtful.unresolved.map_or(0, |unresolved| unresolved.steps);
    if held == 0 && jumps == 0 {
        return None;
    }
    Some(format!(
        "not required here: the theorem is about functions that are smooth along the motion, and in {} of its {steps} steps one jumps, has no bound on \
         its rate, as a root at its zero, or holds something at rest, which lowers the order, to 1 at a jump, and forgets where the motion came from; to see it required, end before ({}), or declare a \
         function that changes smoothly, as `tanh`",
        larger(held as f64, jumps as f64),
        "`--until`"
    ))
}

/// The checks of the motion as a whole, not of each triple of nodes.
const CHECKS_OF_THE_MOTION: [&str; 7] = [
    "roots",
    "symplectic law",
    "momentum law",
    "power balance",
    "reversibility",
    "contact",
    "order",
];

/// Measures the figures of one check.
type Check = fn(&CheckedMotion<'_>, &mut Report);

/// Checks a system on one of its motions.
///
/// # Errors
///
/// [`CheckFailure`] if the motion cannot be computed: there is nothing to check.
pub fn check<S: System<N>, const N: usize>(
    system: &S,
    symmetries: &[Symmetry],
    expected: Expected,
    settings: &Settings<'_>,
    (q, v): ([f64; N], [f64; N]),
) -> Result<Vec<Finding>, CheckFailure> {
    let default_duration = STEPS * settings.h;
    let settings = Settings {
        q0: &q,
        v0: &v,
        a0: None,
        ..*settings
    };
    check_to(
        &TypedSystem::new(system),
        symmetries,
        expected,
        &settings,
        default_duration,
    )
}

/// Checks a system that was not compiled, from the start of the settings.
///
/// # Errors
///
/// As [`check`].
#[doc(hidden)]
pub fn check_tape(
    kernel: &TapeKernel,
    symmetries: &[Symmetry],
    expected: Expected,
    settings: &Settings<'_>,
) -> Result<Vec<Finding>, CheckFailure> {
    check_to(kernel, symmetries, expected, settings, STEPS * settings.h)
}

/// Position and velocity on the constraints, projected from those of the settings.
pub(crate) fn projected(
    system: &dyn Motions,
    settings: &Settings<'_>,
) -> Result<[Vec<f64>; 2], CheckFailure> {
    let state = motions::projected(system.kernel(), settings.h, &State::of(settings))?;
    Ok([state.q, state.v])
}

/// Checks any system from the start of the settings, with the acceleration near the given one where there are
/// several; for the time `default_duration` unless the settings give an end.
pub(crate) fn check_to(
    system: &dyn Motions,
    symmetries: &[Symmetry],
    expected: Expected,
    settings: &Settings<'_>,
    default_duration: f64,
) -> Result<Vec<Finding>, CheckFailure> {
    if !system.kernel().shape().rotations.is_empty() {
        return rotations::check_to(system, symmetries, expected, settings, default_duration);
    }
    let motion = CheckedMotion::new(system, symmetries, expected, settings, default_duration)?;
    let checks: [(&'static str, Check); 11] = [
        ("window", window),
        ("regularity", flow::regularity),
        ("equations", equations::equations),
        ("roots", roots::roots),
        ("identities, which hold at any triple", identities),
        ("symplectic law", symplectic::law),
        ("momentum law", momentum::law),
        ("power balance", power::balance),
        ("reversibility", flow::reversibility),
        ("contact", contact::contact),
        ("order", order::order),
    ];
    let mut findings = CheckFindings::new(motion.excuse());
    findings.dependent = motion.dependent.as_ref();
    findings.large_numbers = Some(&motion.large_numbers);
    for (check, measure) in checks {
        findings.carry_out(check, |report| measure(&motion, report));
    }
    Ok(findings.findings)
}

/// The findings of the checks of a motion, and the reasons that excuse them.
#[derive(Default)]
struct CheckFindings<'s> {
    findings: Vec<Finding>,
    /// The reason why checks of the motion as a whole are not required.
    excuse: Option<String>,
    /// The constraint that is nearly dependent on the others.
    dependent: Option<&'s NearlyDependentConstraint>,
    /// The rounding of large times and positions.
    large_numbers: Option<&'s RoundingOfLargeNumbers>,
}

impl CheckFindings<'_> {
    fn new(excuse: Option<String>) -> Self {
        Self {
            excuse,
            ..Self::default()
        }
    }

    /// Carries out a check.
    fn carry_out(&mut self, check: &'static str, measure: impl FnOnce(&mut Report)) {
        let mut report = Report {
            check,
            findings: Vec::new(),
        };
        measure(&mut report);
        if CHECKS_OF_THE_MOTION.contains(&check) {
            for finding in report.findings.iter_mut().filter(|finding| !finding.ok()) {
                finding.excuse.clone_from(&self.excuse);
            }
        }
        if let Some(dependent) = self.dependent {
            for finding in report.findings.iter_mut().filter(|finding| !finding.ok()) {
                finding.excuse = dependent.excuse(finding);
            }
        }
        if let Some(large_numbers) = self.large_numbers {
            for finding in report.findings.iter_mut().filter(|finding| !finding.ok()) {
                finding.excuse = large_numbers.excuse(finding);
            }
        }
        self.findings.extend(report.findings);
    }
}

/// Reports the time that a motion reaches, for systems with fewer checks; `left_out` says which are left out.
fn report_reached_time(
    [from, until, h]: [f64; 3],
    nodes: &[MotionNode],
    left_out: &str,
    report: &mut Report,
) {
    let asked = (until - from).abs();
    report.push(
        format!("time that the motion reaches, of {asked} s"),
        Bar::AtLeast(asked * (1.0 - 1e-9) - h.abs()),
        Ok(nodes.last().map_or(0.0, |node| (node.t - from).abs())),
    );
    report.note(left_out);
}

/// The time that the motion reaches.
fn window(motion: &CheckedMotion<'_>, report: &mut Report) {
    let asked = (motion.asked - motion.start.t).abs();
    report.push(
        format!("time that the motion reaches, of {asked} s"),
        Bar::AtLeast(asked * (1.0 - 1e-9) - motion.h.abs()),
        Ok((motion.until - motion.start.t).abs()),
    );
    if let Some(ended) = &motion.ended {
        report.note(&format!("{ended}; what follows is about the motion up to there"));
        let excuse = ends_itself(motion).or_else(|| motion.excuse());
        if let Some(last) = report.findings.last_mut().filter(|last| !last.holds()) {
            last.excuse = excuse;
        }
    }
    if motion.kernel.shape().external_forces || motion.doubtful.unresolved.is_some() {
        let steps = motion
            .doubtful
            .unresolved
            .map_or(0, |unresolved| unresolved.steps);
        report.push(
            "steps within which a force or a constraint jumps",
            Bar::Reported,
            Ok(steps as f64),
        );
        if let Some(Unresolved { first, .. }) = motion.doubtful.unresolved {
            report.note(&format!(
                "a force or a constraint jumps, or varies too fast for the nodes, within a step, first about t = {}: such steps lower the order, to 1 at a jump, and to between 1 and 2 where a root is zero, whose rate has no bound there; take a smaller step, or a smoother function",
                written_time(first)
            ));
        }
    }
    if motion.held > 0 {
        report.push(
            "steps in which a function jumps or holds something at rest",
            Bar::Reported,
            Ok(motion.held as f64),
        );
        report.note(
            "there the equations are an inclusion: the function has a value between its two sides, which the rows at the nodes do not know. These \
             steps are left out of what follows about single triples",
        );
    }
}

/// The reason why a motion need not reach the end of its window: the continuous one ends there, too.
fn ends_itself(motion: &CheckedMotion<'_>) -> Option<String> {
    let end = [motion.asked];
    let exact = motions::continuous_to_its_end(motion.system, motion.h, &motion.start, &end, 1e-12);
    let ended = exact.ok()?.1?;
    let RunError::Series(series) = &ended else {
        return None;
    };
    let t = series.ends_at();
    let apart = (t - motion.until).abs();
    (apart <= ENDS_NEAR * motion.h.abs()).then(|| {
        format!(
            "not required here: the theorem is about a motion as long as there is one, and the continuous motion ends, too, at t = {}: {ended}; to see it required, end before (`--until`)",
            written_time(t)
        )
    })
}

/// Laws that hold at every triple, whatever the motion: they test the code of the constraint force and of the
/// tangent map against that of `L_d`.
fn identities(motion: &CheckedMotion<'_>, report: &mut Report) {
    symplectic::identity(motion, report);
    momentum::identity(motion, report);
}

/// The largest of some figures.
fn largest<T>(of: impl IntoIterator<Item = T>, mut figure: impl FnMut(T) -> Measured) -> Measured {
    let mut largest = 0.0;
    for item in of {
        largest = larger(largest, figure(item)?);
    }
    Ok(largest)
}

/// The smallest of some figures, without NaN; an error if all are NaN.
fn smallest(figures: impl Iterator<Item = f64>) -> Measured {
    let least = figures.filter(|figure| !figure.is_nan()).reduce(f64::min);
    least.ok_or_else(|| "it has no value anywhere along the motion".into())
}
