//! A row that has to vanish.

use crate::graph::{Leaf, NodeId};

/// A row that has to vanish, and a factor that has to be divided out of it.
#[derive(Clone, Copy)]
pub(crate) struct Equation {
    pub(crate) value: NodeId,
    /// The same row with differences as they are: it loses digits, but its derivative does not, and is the simpler one.
    pub(crate) plain: NodeId,
    pub(crate) divide: Option<NodeId>,
    pub(crate) pivots: Pivots,
}

/// For which unknowns a row may be solved before any numbers are known.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Pivots {
    /// Any.
    Any,
    /// This one alone.
    One(Leaf),
    /// None: several accelerations stand in a constraint. The one that it was solved for would be known as the difference of the others and of what
    /// is prescribed, to their digits. Where a light arm turns against a heavy one the heavy one's would be lost.
    None,
}

impl Pivots {
    /// Whether an unknown is among them.
    pub(crate) fn contain(self, unknown: Leaf) -> bool {
        match self {
            Self::Any => true,
            Self::One(leaf) => leaf == unknown,
            Self::None => false,
        }
    }
}

impl Equation {
    /// Its expressions, to be rewritten.
    pub(crate) fn parts(&mut self) -> impl Iterator<Item = &mut NodeId> {
        [&mut self.value, &mut self.plain]
            .into_iter()
            .chain(&mut self.divide)
    }
}
