//! The paper's theorems as checks of a system: `dsocs check` prints the table.
//!
//! Each check takes the system's own motion, measures a figure and holds it against a bar. Bars at rounding are a small
//! multiple of it, and the figures are relative to the terms that they are a difference of.

mod continuous;
mod extrapolation;
mod flow;
mod momentum;
mod order;
mod probe;
mod symplectic;

use std::error::Error;

use dsocs_core::geometry::{DiscreteFlow, Triple};
use dsocs_core::{Leg, System};

use crate::entry::{CheckFailure, Kind, Symmetry};
use crate::stability::Bar;

use probe::Probe;

/// So many steps are made unless an end is given.
const STEPS: f64 = 40.0;

/// So many triples of the motion are looked at, at most.
const TRIPLES: usize = 24;

/// What is expected of a system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// The kind of its constraints: without any, and with holonomic ones, the flow is symplectic.
    pub kind: Kind,
    /// The order.
    pub order: f64,
    /// Whether the step with `−h` is the inverse of that with `h`.
    pub reversible: bool,
}

/// The motion to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings<'a> {
    /// The step, in s.
    pub h: f64,
    /// The end, in s; 40 steps unless given.
    pub until: Option<f64>,
    /// The first node.
    pub q0: &'a [f64],
    /// The initial velocity.
    pub v0: &'a [f64],
}

impl Settings<'_> {
    /// The end.
    fn end(&self) -> f64 {
        self.until.unwrap_or(STEPS * self.h)
    }
}

/// One figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The check.
    pub check: &'static str,
    /// What is measured.
    pub what: String,
    /// The figure.
    pub figure: f64,
    /// The bar.
    pub bar: Bar,
    /// Why there is no figure.
    pub failure: Option<String>,
}

impl Finding {
    /// Whether the figure reaches its bar.
    #[must_use]
    pub fn ok(&self) -> bool {
        self.failure.is_none() && self.bar.holds(self.figure)
    }
}

/// What a measurement gives.
type Measured<T = f64> = Result<T, Box<dyn Error>>;

/// The figures of one check.
struct Report {
    /// The check.
    check: &'static str,
    /// The figures so far.
    findings: Vec<Finding>,
}

impl Report {
    /// Takes in a figure, or why there is none.
    fn push(&mut self, what: impl Into<String>, bar: Bar, measured: Measured) {
        let (figure, failure) = match measured {
            Ok(figure) => (figure, None),
            Err(error) => (f64::NAN, Some(error.to_string())),
        };
        self.findings.push(Finding {
            check: self.check,
            what: what.into(),
            figure,
            bar,
            failure,
        });
    }

    /// Takes in several figures that are measured together.
    fn push_all<const K: usize>(&mut self, whats: [(&str, Bar); K], measured: &Measured<[f64; K]>) {
        for (place, (what, bar)) in whats.into_iter().enumerate() {
            let figure = match measured {
                Ok(figures) => Ok(figures[place]),
                Err(error) => Err(error.to_string().into()),
            };
            self.push(what, bar, figure);
        }
    }
}

/// A system with the motion that it is checked on.
struct Subject<'a, const N: usize> {
    /// The system.
    system: &'a dyn Probe<N>,
    /// Its step as a map.
    flow: DiscreteFlow<'a, N>,
    /// What is expected.
    expected: Expected,
    /// Symmetries of its Lagrangian.
    symmetries: &'a [Symmetry],
    /// The step.
    h: f64,
    /// The end.
    until: f64,
    /// Position and velocity at the start.
    start: [[f64; N]; 2],
    /// The legs of the motion.
    legs: Vec<Leg<f64, N>>,
    /// Triples along it, evenly spread.
    triples: Vec<Triple<N>>,
}

/// Measures the figures of one check.
type Check<const N: usize> = fn(&Subject<'_, N>, &mut Report);

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
    (q0, v0): ([f64; N], [f64; N]),
) -> Result<Vec<Finding>, CheckFailure> {
    findings(system, symmetries, expected, settings, [q0, v0])
}

/// The findings of all checks.
fn findings<const N: usize>(
    system: &dyn Probe<N>,
    symmetries: &[Symmetry],
    expected: Expected,
    settings: &Settings<'_>,
    start: [[f64; N]; 2],
) -> Result<Vec<Finding>, CheckFailure> {
    let (h, until) = (settings.h, settings.end());
    let flow = DiscreteFlow::new(system, h)?;
    let legs = probe::legs(system, h, &start, until)?;
    let subject = Subject {
        system,
        flow,
        expected,
        symmetries,
        h,
        until,
        start,
        triples: triples(&flow, &legs)?,
        legs,
    };
    let checks: [(&'static str, Check<N>); 5] = [
        ("regularity", flow::regularity),
        ("symplectic law", symplectic::law),
        ("momentum law", momentum::law),
        ("reversibility", flow::reversibility),
        ("order", order::order),
    ];
    let mut findings = Vec::new();
    for (check, measure) in checks {
        let mut report = Report {
            check,
            findings: Vec::new(),
        };
        measure(&subject, &mut report);
        findings.extend(report.findings);
    }
    Ok(findings)
}

/// Triples along a motion, evenly spread.
fn triples<const N: usize>(
    flow: &DiscreteFlow<'_, N>,
    legs: &[Leg<f64, N>],
) -> Result<Vec<Triple<N>>, CheckFailure> {
    let every = legs.len().div_ceil(TRIPLES);
    let mut found = Vec::new();
    for pair in legs.windows(2).step_by(every) {
        let e = core::array::from_fn(|i| pair[1].d[i] - pair[0].d[i]);
        found.push(flow.forward_near(&pair[0], &e)?);
    }
    Ok(found)
}

/// The larger of two numbers; NaN if either is.
fn larger(x: f64, y: f64) -> f64 {
    if x >= y || x.is_nan() { x } else { y }
}

/// The largest of some figures.
fn largest<T>(of: impl IntoIterator<Item = T>, mut figure: impl FnMut(T) -> Measured) -> Measured {
    let mut largest = 0.0;
    for item in of {
        largest = larger(largest, figure(item)?);
    }
    Ok(largest)
}
