//! Counts and kinds of a declaration, for code and for data.

use crate::graph::{Graph, Leaf, NodeId};
use crate::mechanics::Symmetry;
use crate::model::{Kind, Model};
use crate::passes::Unknowns;
use crate::program::stages::Stages;

/// Counts and kinds of a declaration, as explained at `dsocs_core::Shape`.
#[expect(
    clippy::struct_excessive_bools,
    reason = "facts that do not depend on each other"
)]
pub(crate) struct Facts {
    pub(crate) parameters: usize,
    pub(crate) unknowns: usize,
    pub(crate) motion: usize,
    pub(crate) constants: usize,
    pub(crate) known: usize,
    pub(crate) order: usize,
    pub(crate) holonomic: usize,
    pub(crate) nonholonomic: usize,
    pub(crate) kinematic: usize,
    pub(crate) forms: usize,
    pub(crate) third_order: Vec<usize>,
    pub(crate) rotations: Vec<usize>,
    pub(crate) of_positions: Vec<usize>,
    pub(crate) of_rates: Vec<usize>,
    pub(crate) depends_on_time: bool,
    pub(crate) external_forces: bool,
    pub(crate) linear: bool,
    pub(crate) jumps: bool,
    pub(crate) piecewise: bool,
    pub(crate) switches: bool,
    pub(crate) scaled: bool,
    pub(crate) divided: bool,
    pub(crate) symmetry: Symmetry,
}

impl Facts {
    /// The facts of a declaration, from the stages and the unknowns of its step.
    pub(crate) fn new(
        model: &Model,
        graph: &Graph,
        stages: &Stages,
        unknowns: &Unknowns,
        (symmetry, switches): (Symmetry, bool),
    ) -> Self {
        let n = model.coordinates.len();
        let affine = |&entry: &NodeId| graph.leaves(entry).all(|leaf| !matches!(leaf, Leaf::Z(_)));
        let is_unknown = |leaf| matches!(leaf, Leaf::Z(_));
        let jumps =
            |&row: &NodeId| graph.jump_leaves(row).any(is_unknown) || graph.calls_with(row, is_unknown);
        let moves = |leaf| matches!(leaf, Leaf::N(_) | Leaf::D(_) | Leaf::P(_) | Leaf::Z(_));
        let mut solved = unknowns.rows.iter().chain(&unknowns.second_difference);
        // with constraints of third order a step also knows the previous second difference
        let past = if model.order() > 2 { n } else { 0 };
        Self {
            parameters: model.parameters.len(),
            unknowns: unknowns.meanings.len(),
            motion: n + model.multipliers(),
            constants: stages.constants_count() + past,
            known: stages.known.len(),
            order: model.order(),
            holonomic: model.count(Kind::Holonomic),
            nonholonomic: model.count(Kind::Nonholonomic),
            kinematic: model.count(Kind::Kinematic),
            forms: model.forms.len(),
            third_order: model.third_order().collect(),
            rotations: model.graph.rotations().to_vec(),
            of_positions: model.parameters_of_positions(),
            of_rates: model.parameters_of_rates(),
            depends_on_time: model.depends_on_time(),
            external_forces: !model.external_forces.is_empty(),
            linear: unknowns.jacobian.iter().flatten().all(affine),
            jumps: unknowns.rows.iter().any(jumps),
            piecewise: solved.any(|&value| graph.jump_leaves(value).any(moves)),
            switches,
            scaled: unknowns.scaled(graph),
            divided: (model.constraints.iter()).any(|row| row.divided || row.divide.is_some()),
            symmetry,
        }
    }
}
