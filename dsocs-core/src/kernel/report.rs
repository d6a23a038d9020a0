//! What is told of a step: how it was solved, and the node that it was solved for.

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

/// Where a node is written: by [`Run::tell`](crate::Run::tell) all of it, by [`Kernel::report`](crate::Kernel::report) what a step knows.
#[derive(Debug)]
pub struct NodeMut<'a> {
    /// Position, velocity, acceleration and generalized constraint force, one after the other: four numbers for each coordinate.
    pub vectors: &'a mut [f64],
    /// What is no vector.
    pub scalars: &'a mut NodeScalars,
}

/// What a node has beside its vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeScalars {
    /// The number of the node.
    pub index: u64,
    /// Time.
    pub t: f64,
    /// The energy.
    pub energy: f64,
    /// How often the rows were evaluated.
    pub iterations: u32,
    /// How the iteration ended.
    pub stop: Stop,
}

impl NodeScalars {
    /// Before a run has written them.
    pub const UNKNOWN: Self = Self {
        index: 0,
        t: f64::NAN,
        energy: f64::NAN,
        iterations: 0,
        stop: Stop::Start,
    };
}

impl NodeMut<'_> {
    /// Position, velocity, acceleration and constraint force, each by itself.
    pub fn split(&mut self) -> [&mut [f64]; 4] {
        let n = self.vectors.len() / 4;
        let (q, rest) = self.vectors.split_at_mut(n);
        let (v, rest) = rest.split_at_mut(n);
        let (a, force) = rest.split_at_mut(n);
        [q, v, a, force]
    }
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
