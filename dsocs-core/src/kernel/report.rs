//! How a step was solved.

use crate::solve::Vector;
use crate::solve::newton::{Root, Stop};

/// How a step was solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepReport {
    /// How often the rows and their Jacobian were evaluated, for all guesses that were tried.
    pub iterations: u32,
    /// How Newton's iteration ended.
    pub stop: Stop,
    /// The guess that led to the solution.
    pub guess: Guess,
}

/// Where Newton's iteration began.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Guess {
    /// At the polynomial through the last solutions.
    Predicted,
    /// At the solution of the step before.
    Last,
    /// At a straight line: no second difference.
    Straight,
    /// At the acceleration of the continuous system.
    Continuous,
    /// At the node where the path turns by the same angle as at the step before, in the plane of the last two legs.
    Turned,
    /// Beside a root that was found and did not continue the motion.
    Other,
    /// Where the caller asked for it.
    Given,
    /// At the end of a homotopy: a path along which the residual of the straight line is reduced to zero little by little.
    Followed,
}

/// What is told of a root.
pub(crate) fn report(root: Root<Vector>, guess: Guess) -> (Vector, StepReport) {
    let report = StepReport {
        iterations: root.evaluations,
        stop: root.stop,
        guess,
    };
    (root.z, report)
}
