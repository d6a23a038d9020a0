//! The options that choose the method, its order or tolerance, and whether errors are estimated.

use clap::Args;
use dsocs_core::Composition;

use crate::cli::CliError;
use crate::cli::arguments::expression;
use crate::entry::{Method, Row};

/// The options that choose how a motion is computed.
#[derive(Args, Clone, Debug)]
pub struct AccuracyArguments {
    /// The order of the step: 2 is the paper's; 4, 6 and 8 are compositions of it [default: 2]
    #[arg(long, value_name = "P", value_parser = order)]
    order: Option<Composition>,
    /// Compute the continuous motion by Taylor series, to this tolerance relative to the velocities, with output at every --step
    #[arg(long, value_name = "EPS", conflicts_with = "order", allow_hyphen_values = true, value_parser = expression::number)]
    tolerance: Option<f64>,
    /// Record the error of every coordinate at every node, and report the largest. Errors are distances from the continuous motion, which
    /// is computed by Taylor series to nearly all digits
    #[arg(long)]
    estimate_error: bool,
}

/// The unit round-off of double precision, `2⁻⁵³`.
const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// A larger tolerance lets the errors of the steps add up to some per cent in a run of a hundred turns: with
/// 1e-3 a particle on a circle loses 5 per cent of its speed.
const LOOSE_TOLERANCE: f64 = 1e-4;

/// The tolerance, raised to the unit round-off; zero, negative numbers and NaN stay, and the method refuses
/// them.
fn at_least_roundoff(tolerance: f64) -> f64 {
    if tolerance > 0.0 {
        tolerance.max(UNIT_ROUNDOFF)
    } else {
        tolerance
    }
}

/// Reads the order of a composition.
fn order(text: &str) -> Result<Composition, String> {
    text.parse()
        .ok()
        .and_then(Composition::of_order)
        .ok_or_else(|| "the step has order 2, its compositions 4, 6 and 8".to_owned())
}

impl AccuracyArguments {
    /// The method that is asked for.
    pub fn method(&self) -> Method {
        match (self.tolerance, self.order) {
            (Some(tolerance), _) => Method::Tolerance(at_least_roundoff(tolerance)),
            (None, Some(method)) if method.order() > 2 => Method::Composed(method),
            (None, _) => Method::Step,
        }
    }

    /// A note on a tolerance that was raised to the unit round-off, or that is so large that the motion may
    /// drift far.
    pub fn note(&self) -> Option<String> {
        let tolerance = self.tolerance?;
        if at_least_roundoff(tolerance) > tolerance {
            return Some(format!(
                "note: the tolerance {tolerance:e} cannot be reached: numbers of double precision are rounded by {UNIT_ROUNDOFF:.1e} of their size, and that is the tolerance taken"
            ));
        }
        (tolerance > LOOSE_TOLERANCE && !self.estimate_error).then(|| {
            format!(
                "warning: the tolerance {tolerance:e} is that of each step, and the errors of the steps add up: energies and constraints on \
                 accelerations drift, and in the end nothing may be left of the motion. 1e-9 costs little more; --estimate-error measures the error"
            )
        })
    }

    /// Whether errors are to be estimated.
    pub fn estimates(&self) -> bool {
        self.estimate_error
    }

    /// Refuses options that mean nothing to the method.
    ///
    /// # Errors
    ///
    /// [`CliError::Conflict`].
    pub fn check(&self, nodes: bool, start: bool, certify: bool) -> Result<(), CliError> {
        let method = match (self.tolerance, self.order) {
            (Some(_), _) => Some("--tolerance".to_owned()),
            (None, Some(method)) if method.order() > 2 => Some(format!("--order {}", method.order())),
            (None, _) => None,
        };
        let conflict = |option, other, reason| {
            Err(CliError::Conflict {
                option,
                other,
                reason,
            })
        };
        match method {
            Some(method) if nodes => conflict(
                "--q1",
                method,
                "it begins with a position and a velocity (--q0, --v0); two nodes begin the step of order 2 alone",
            ),
            Some(method) if start => conflict(
                "--start",
                method,
                "it begins with the position and the velocity themselves; only the step of order 2 needs a second node",
            ),
            Some(method) if certify => conflict(
                "--certify",
                method,
                "D₁ and D₃ belong to three nodes at equal distances, which the step of order 2 alone has",
            ),
            None if nodes && self.estimate_error => conflict(
                "--q1",
                "--estimate-error".to_owned(),
                "errors are measured against the continuous motion, which begins with a velocity (--v0)",
            ),
            _ => Ok(()),
        }
    }
}

/// The largest estimated error of each coordinate.
#[derive(Default)]
pub struct Errors {
    /// The largest error and the time of its node, by coordinate.
    largest: Vec<(f64, f64)>,
    /// The errors at the last node that has them, by coordinate.
    last: Vec<f64>,
    /// The time of that node.
    time: f64,
    /// The uncertainty of the reference motion at that node.
    uncertainty: f64,
    /// Why the reference motion ends there.
    unknown: Option<String>,
}

impl Errors {
    /// Looks at a node.
    #[inline]
    pub fn look(&mut self, row: &Row<'_>) {
        // most runs estimate none
        if row.unknown.is_some() || !row.errors.is_empty() {
            self.take(row);
        }
    }

    /// Takes the errors of a node, or why they are not known.
    fn take(&mut self, row: &Row<'_>) {
        if let Some(unknown) = row.unknown {
            self.unknown.get_or_insert_with(|| unknown.to_string());
            return;
        }
        self.largest.resize(row.errors.len(), (0.0, row.node.t));
        for (largest, &error) in self.largest.iter_mut().zip(row.errors) {
            if error > largest.0 {
                *largest = (error, row.node.t);
            }
        }
        self.last.clear();
        self.last.extend_from_slice(row.errors);
        self.time = row.node.t;
        self.uncertainty = row.uncertainty;
    }

    /// A note of the largest errors by coordinate, or a warning that none could be estimated.
    pub fn note<'a>(&self, coordinates: impl Iterator<Item = &'a str>, ended_early: bool) -> Option<String> {
        if self.largest.is_empty() {
            let why = self.unknown.as_ref()?;
            return Some(format!("warning: the error cannot be estimated: {why}"));
        }
        let coordinates = coordinates.zip(&self.largest).zip(&self.last);
        let parts: Vec<String> = coordinates
            .map(|((name, (largest, t)), last)| {
                let end = if ended_early || self.unknown.is_some() {
                    "then"
                } else {
                    "at the end"
                };
                format!("{name} {largest:.1e} (at t = {t}; {last:.1e} {end})")
            })
            .collect();
        let until = if ended_early || self.unknown.is_some() {
            format!(" up to t = {}", self.time)
        } else {
            String::new()
        };
        let note = format!(
            "note: the largest errors{until} are {}; the motion they are measured against is known to {:.0e}",
            parts.join(", "),
            self.uncertainty
        );
        Some(match &self.unknown {
            Some(why) => format!("{note}\nwarning: beyond, the errors cannot be estimated: {why}"),
            None => note,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::AccuracyArguments;

    #[test]
    fn a_tolerance_is_told_of_where_little_may_be_left_of_the_motion() {
        let note = |tolerance, estimate_error| {
            let arguments = AccuracyArguments {
                order: None,
                tolerance: Some(tolerance),
                estimate_error,
            };
            arguments.note().unwrap_or_default()
        };
        for tolerance in [0.3, 1e-2, 1e-3] {
            assert!(
                note(tolerance, false).contains("errors of the steps add up"),
                "{tolerance}"
            );
            assert_eq!(note(tolerance, true), "", "the error is measured");
        }
        for tolerance in [1e-4, 1e-9, 1e-15] {
            assert_eq!(note(tolerance, false), "");
        }
        assert!(note(1e-17, false).contains("cannot be reached"));
    }
}
