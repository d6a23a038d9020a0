//! The report of a step: how it was solved, and the node that it was solved for.

use crate::solve::Vector;
use crate::solve::newton::{Root, Stop};

/// Statistics of a solved step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepReport {
    /// Number of evaluations of the rows and their Jacobian, over all guesses that were tried.
    pub iterations: u32,
    /// The stop rule that ended Newton's iteration.
    pub stop: Stop,
    /// The guess that led to the solution.
    pub guess: Guess,
}

/// The starting point of Newton's iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Guess {
    /// The polynomial through the last solutions.
    Predicted,
    /// The solution of the step before.
    Last,
    /// A straight line: no second difference.
    Straight,
    /// The acceleration of the continuous system.
    Continuous,
    /// The node where the path turns by the same angle as at the step before, in the plane of the last two
    /// legs.
    EqualTurn,
    /// A point beside a root that was found and did not continue the motion.
    Other,
    /// The node or acceleration that the caller gave.
    Given,
    /// The end of a homotopy: a path along which the residual of the straight line is reduced to zero little
    /// by little.
    Homotopy,
    /// The solutions of steps beside this one, whose node lies where a quotient of the declaration is 0/0: the limit of these solutions is taken.
    Limit,
}

/// Memory for the data of a node. [`Run::write_node`](crate::Run::write_node) writes all of it, [`Kernel::report`](crate::Kernel::report) the
/// data that follow from a step.
#[derive(Debug)]
pub struct NodeMut<'a> {
    /// Position, velocity, acceleration and generalized constraint force, one after the other: four numbers for each coordinate.
    pub vectors: &'a mut [f64],
    /// The other data.
    pub scalars: &'a mut NodeScalars,
}

/// The data of a node that are not vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeScalars {
    /// The number of the node.
    pub index: u64,
    /// Time.
    pub t: f64,
    /// The energy.
    pub energy: f64,
    /// Number of evaluations of the rows.
    pub iterations: u32,
    /// The stop rule that ended the iteration.
    pub stop: Stop,
}

impl NodeScalars {
    /// The values before a run has written them.
    pub const UNKNOWN: Self = Self {
        index: 0,
        t: f64::NAN,
        energy: f64::NAN,
        iterations: 0,
        stop: Stop::Start,
    };
}

impl NodeMut<'_> {
    /// Position, velocity, acceleration and constraint force as separate slices.
    pub fn split(&mut self) -> [&mut [f64]; 4] {
        let n = self.vectors.len() / 4;
        let (q, rest) = self.vectors.split_at_mut(n);
        let (v, rest) = rest.split_at_mut(n);
        let (a, force) = rest.split_at_mut(n);
        [q, v, a, force]
    }
}

/// The unknowns of a root, and the report of the step.
pub(crate) fn report(root: Root<Vector>, guess: Guess) -> (Vector, StepReport) {
    let report = StepReport {
        iterations: root.evaluations,
        stop: root.stop,
        guess,
    };
    (root.z, report)
}
