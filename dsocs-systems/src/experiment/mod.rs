//! The paper's numerical experiments: motions, and errors against the continuous motion.

pub mod particle;
pub mod pendulum;

use dsocs_core::{Flow, RunError, SetupError, Start, Stepper};
use serde::Serialize;
use thiserror::Error;

use crate::reference::ReferenceError;

/// An experiment failed.
#[derive(Clone, Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// A run could not be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A run ended early.
    #[error(transparent)]
    Run(#[from] RunError),
    /// There is no continuous motion to compare with.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
}

dsocs_core::debug_is_message!(ExperimentError);

/// The rule that gives the second node from position and velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StartRule {
    /// `q1 = q0 + h v0`.
    Paper,
    /// `q1 = q0 + h v0 + h²/2 a0`.
    SecondOrder,
}

impl StartRule {
    /// Both rules, the paper's first.
    pub const ALL: [Self; 2] = [Self::Paper, Self::SecondOrder];

    /// The start by this rule.
    pub fn start<const N: usize>(self, q0: [f64; N], v0: [f64; N]) -> Start<N> {
        match self {
            Self::Paper => Start::paper(q0, v0),
            Self::SecondOrder => Start::second_order(q0, v0),
        }
    }

    /// The rule's name, for people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper start",
            Self::SecondOrder => "second-order start",
        }
    }
}

/// The largest error of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorRow {
    /// The step, in s.
    pub h: f64,
    /// The start.
    pub start: StartRule,
    /// The largest error over the compared nodes, in the unit of the coordinate.
    pub max_error: f64,
}

/// The least-squares slope of `ln error` against `ln h` over the rows of one start.
#[must_use]
pub fn slope(rows: &[ErrorRow], start: StartRule) -> f64 {
    fit(rows, start).0
}

/// The slope over the rows of one start whose steps lie between two bounds, in s.
#[must_use]
pub fn slope_between(rows: &[ErrorRow], start: StartRule, [least, most]: [f64; 2]) -> f64 {
    let within = |row: &&ErrorRow| (least..=most).contains(&row.h);
    let rows: Vec<ErrorRow> = rows.iter().filter(within).copied().collect();
    slope(&rows, start)
}

/// The slope and the intercept of the least-squares line through `(ln h, ln error)` of one start.
#[must_use]
pub fn fit(rows: &[ErrorRow], start: StartRule) -> (f64, f64) {
    let points = || {
        rows.iter()
            .filter(|row| row.start == start)
            .map(|row| (row.h.ln(), row.max_error.ln()))
    };
    let count = points().count() as f64;
    let (x, y) = points().fold((0.0, 0.0), |(x, y), point| {
        (x + point.0 / count, y + point.1 / count)
    });
    let (xx, xy) = points().fold((0.0, 0.0), |(xx, xy), point| {
        (xx + (point.0 - x).powi(2), xy + (point.0 - x) * (point.1 - y))
    });
    (xy / xx, y - xy / xx * x)
}

/// The number of steps of size `h` in the time `t`.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a few million at most, and positive
fn steps(t: f64, h: f64) -> u64 {
    (t / h).round() as u64
}

/// The largest value of `error(t, q)` over every node whose number is a multiple of `stride`, up to node
/// `last`. Only positions are computed.
fn max_error<const N: usize>(
    mut flow: Flow<'_, N>,
    stride: u64,
    last: u64,
    mut error: impl FnMut(u64, f64, &[f64; N]) -> f64,
) -> Result<f64, RunError> {
    let mut greatest = 0f64;
    loop {
        let k = flow.index();
        if k.is_multiple_of(stride) {
            greatest = greatest.max(error(k, flow.time(), flow.position()));
        }
        if k >= last {
            return Ok(greatest);
        }
        flow.advance()?;
    }
}
