//! The paper's equations, as expressions that have to vanish. They are formed here and nowhere else.
//!
//! - [`mod@equation`]: an expression that has to vanish;
//! - [`nodes`]: the nodes of a step and the maps `φ⁻¹` from them to points;
//! - [`force`]: the discrete Lagrangian and the force of the discrete Euler-Lagrange equations;
//! - [`mod@works`]: the work of the constraint force along the virtual displacements, or the force less its
//!   multipliers;
//! - [`mod@step`]: the rows of a step, made of these;
//! - [`mod@continuous`]: the continuous system, its force and its energy;
//! - [`lower_order`]: constraints on positions and velocities, for a pair of nodes and for a start;
//! - [`mod@annihilator`]: the virtual displacements from the forces, `C_V` from `F_V`;
//! - [`mod@properties::sides`]: functions that jump with the velocity, with their sides as leaves;
//! - [`mod@properties::switches`]: where a declaration changes between pieces, or has a pole;
//! - [`mod@properties::reduction`]: coordinates whose positions occur in no equation;
//! - [`properties::factor`]: whether a declared factor divides its constraint;
//! - [`properties::symmetry`]: whether the step is symmetric in time.

mod annihilator;
mod continuous;
pub(crate) mod equation;
mod force;
mod lower_order;
mod nodes;
mod properties;
mod step;
mod works;

pub(crate) use annihilator::{Defect, annihilator};
pub(crate) use continuous::{continuous, energy};
pub(crate) use equation::Equation;
pub(crate) use force::{discrete_lagrangian, external_on_leg, momentum_at_second_node, on_first_leg};
pub(crate) use lower_order::{LowerOrder, pair, phase};
pub(crate) use nodes::PointNodes;
pub(crate) use properties::factor::is_no_factor;
pub(crate) use properties::reduction::where_position_is;
pub(crate) use properties::sides::{Sides, sides};
pub(crate) use properties::switches::{Ranges, Steep, Switches, Table, switches};
pub use properties::symmetry::Symmetry;
pub(crate) use step::{StepEquations, step};

#[cfg(test)]
mod tests;
