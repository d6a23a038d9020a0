//! An equation: an expression that has to vanish.

use crate::graph::{Leaf, NodeId};

/// An equation `value = 0`, and a factor to be divided out of it.
#[derive(Clone, Copy)]
pub(crate) struct Equation {
    pub(crate) value: NodeId,
    /// The value with differences formed by subtraction. It loses digits; its derivatives do not, and are shorter.
    pub(crate) by_subtraction: NodeId,
    pub(crate) divide: Option<NodeId>,
    pub(crate) pivots: Pivots,
}

/// The unknowns for which a row may be solved symbolically.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Pivots {
    /// Any unknown.
    Any,
    /// A single unknown.
    One(Leaf),
    /// None: the row is a constraint with several accelerations. The one it is solved for would be a
    /// difference of the others, with their absolute error: where a light arm turns against a heavy one, the
    /// heavy arm's acceleration would lose its digits.
    None,
}

impl Pivots {
    /// Whether the row may be solved for an unknown.
    pub(crate) fn contain(self, unknown: Leaf) -> bool {
        match self {
            Self::Any => true,
            Self::One(leaf) => leaf == unknown,
            Self::None => false,
        }
    }
}

impl Equation {
    /// The expressions of the equation, for passes to rewrite.
    pub(crate) fn parts(&mut self) -> impl Iterator<Item = &mut NodeId> {
        [&mut self.value, &mut self.by_subtraction]
            .into_iter()
            .chain(&mut self.divide)
    }
}
