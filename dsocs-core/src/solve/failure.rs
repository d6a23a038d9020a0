//! Reasons why Newton's iteration ends without a root.

use core::fmt;

use crate::number::message::{Magnitude, Numbers};

/// The reason why Newton's iteration ended without a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StepFailure {
    /// A row of the equations or of their Jacobian is infinite or not a number.
    NotFinite,
    /// The Jacobian is singular: the equations do not determine the unknowns.
    Singular,
    /// The updates did not become small: there may be no root, or none near the guess.
    NotConverged,
    /// The residual has a minimum that is not zero: on a path from a guess along which the rows decrease,
    /// there is a point that is not a root and beyond which they only grow. The declared equations cannot be
    /// fulfilled there.
    NoSolution,
    /// At the root that was found, a denominator of a declared row is zero, so the row is not defined. Or a factor of the row that does not
    /// depend on the unknowns is zero, so the row holds for all values of the unknowns.
    Degenerate,
    /// Between the last node and the next one the equations become singular, and the acceleration (in third
    /// order the jerk) grows without bound. No motion leads past this point; the root that was found belongs
    /// to another motion.
    PassesSingularity,
    /// The motion passes through rest, where a constraint of third order holds for every third derivative.
    /// Two motions continue from there: a smooth one, and one that keeps the prescribed quantity, such as a
    /// curvature.
    PassesRest,
    /// A body at rest may go on in more than one way, where a force jumps with the velocity: it may leave to
    /// either side, as by a force along the velocity, or leave and stay, as with friction that raises its own
    /// normal force. Or the motion begins where a force jumps with the position, and leads away on both sides.
    Forks,
    /// A rotation turns by half a turn or more in the step, so the sense of the turn is not determined.
    TurnsTooFar,
    /// There are two solutions, near or far apart, and neither the guess nor the past decides which one belongs to the motion.
    AmbiguousRoot,
}

impl fmt::Display for StepFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "the equations are not finite",
            Self::Singular => "the Jacobian is singular",
            Self::NotConverged => "Newton's iteration does not converge",
            Self::NoSolution => "what is declared cannot be met here",
            Self::PassesSingularity => "the equations become singular on the way of this step",
            Self::PassesRest => "the motion passes through rest, where a constraint of third order does not determine how it goes on",
            Self::Forks => {
                "what is at rest may leave in more than one way, or stay: a force jumps with the velocity or the position, and more than one of its \
                 values there continues the motion"
            },
            Self::TurnsTooFar => "a rotation turns by half a turn or more in this step",
            Self::AmbiguousRoot => "there are two solutions, and the nodes before do not decide which of them continues the motion",
            Self::Degenerate => "a denominator or a factor of a declared equation is zero",
        })
    }
}

/// A failed Newton iteration: the reason, and the history.
#[derive(Clone, PartialEq)]
pub struct NewtonFailure {
    /// The reason why it ended.
    pub reason: StepFailure,
    /// The unknowns where it ended.
    pub unknowns: Vec<f64>,
    /// The rows there: the kinematic constraints, then the variational equations.
    pub residual: Vec<f64>,
    /// The updates, each relative to the size of the unknowns.
    pub updates: Vec<f64>,
    /// The unknowns of the other root, for [`StepFailure::AmbiguousRoot`]; empty otherwise.
    pub other: Vec<f64>,
}

crate::debug_is_message!(NewtonFailure);

/// Number of last updates that are used to judge the convergence.
const TAIL: usize = 8;

impl NewtonFailure {
    /// Whether the iteration converges to a multiple root: at an `m`-fold root each update is `1 − 1/m` of
    /// the one before.
    #[must_use]
    pub fn is_at_multiple_root(&self) -> bool {
        let finite = self.updates.iter().skip_while(|update| !update.is_finite());
        let updates: Vec<f64> = finite.copied().collect();
        let Some(tail) = updates.len().checked_sub(TAIL + 1).map(|from| &updates[from..]) else {
            return false;
        };
        let mut ratios = tail.windows(2).map(|pair| pair[1] / pair[0]);
        let first = ratios.next().unwrap_or(f64::NAN);
        (0.45..0.9).contains(&first) && ratios.all(|ratio| (ratio - first).abs() < 0.02)
    }
}

impl fmt::Display for NewtonFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.residual.is_empty() {
            // no iteration was made
            return self.reason.fmt(f);
        }
        write!(f, "{}: {}", self.reason, History(self))
    }
}

impl fmt::Display for History<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let NewtonFailure {
            residual, updates, ..
        } = self.0;
        write!(f, "residual by row {}", Numbers(residual))?;
        match updates.as_slice() {
            [] => Ok(()),
            [.., last] if updates.len() > 6 => {
                let shown = &updates[..5];
                write!(
                    f,
                    ", relative updates {} … {} ({} in all)",
                    Numbers(shown),
                    Magnitude(*last),
                    updates.len()
                )
            }
            all => write!(f, ", relative updates {}", Numbers(all)),
        }
    }
}

impl core::error::Error for NewtonFailure {}

/// The history of a failed iteration, for display.
pub(crate) struct History<'a>(pub &'a NewtonFailure);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_without_an_iteration_has_no_history() {
        let failure = |residual: Vec<f64>| NewtonFailure {
            reason: StepFailure::TurnsTooFar,
            unknowns: Vec::new(),
            residual,
            updates: Vec::new(),
            other: Vec::new(),
        };
        assert_eq!(
            failure(Vec::new()).to_string(),
            StepFailure::TurnsTooFar.to_string()
        );
        assert!(
            failure(vec![0.5])
                .to_string()
                .ends_with(": residual by row [0.5]")
        );
    }
}
