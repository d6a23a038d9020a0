//! What has to vanish: the paper's equations, as expressions. They are formed here and nowhere else.
//!
//! - [`nodes`]: the nodes of a step and the maps `φ⁻¹` from them to points;
//! - [`force`]: the discrete Lagrangian and the force of the discrete Euler-Lagrange equations;
//! - [`mod@works`]: the work of a force along the virtual displacements, or what multipliers leave of it;
//! - [`mod@step`]: the rows of a step, made of these;
//! - [`mod@continuous`]: the continuous system, its force and its energy;
//! - [`lower_order`]: what constraints of lower order ask of a pair of nodes and of a start;
//! - [`mod@annihilator`]: the virtual displacements from the forces, `C_V` from `F_V`;
//! - [`mod@sides`]: functions that jump with the velocity, with their sides as leaves;
//! - [`factor`]: whether a declared factor divides its constraint;
//! - [`symmetry`]: whether the step is symmetric in time.

mod annihilator;
mod continuous;
mod factor;
mod force;
mod lower_order;
mod nodes;
mod sides;
mod step;
mod symmetry;
mod works;

use crate::graph::{Leaf, NodeId};

pub(crate) use annihilator::{Defect, annihilator};
pub(crate) use continuous::{continuous, energy};
pub(crate) use factor::is_no_factor;
pub(crate) use force::{arriving, discrete_lagrangian, external_on_leg, on_first_leg};
pub(crate) use lower_order::{pair, phase};
pub(crate) use nodes::PointNodes;
pub(crate) use sides::{Sides, sides};
pub(crate) use step::{StepEquations, step};
pub(crate) use symmetry::Symmetry;

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

#[cfg(test)]
mod tests;
