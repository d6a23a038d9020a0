//! Coordinates whose positions occur in no equation, as that of a body in free space or of a cart on a
//! straight track. The step is that of the reduced system, and the positions follow from their increments
//! (reconstruction).

use std::ops::Range;

use crate::graph::{Graph, Leaf, NodeId, Substitution};
use crate::mechanics::nodes::Nodes;
use crate::model::{Displacements, Kind, Model, PairPoint, TriplePoint};

/// A search for the positions of some coordinates in the expressions of a model.
struct PositionSearch<'p> {
    graph: Graph,
    /// The nodes of a step, for expressions in terms of a map's nodes.
    nodes: Substitution<'p>,
    coordinates: Range<usize>,
}

impl PositionSearch<'_> {
    /// Whether an expression depends on one of the positions. Differences of nodes do not.
    fn positions_occur_in(&mut self, value: NodeId) -> bool {
        let value = self.graph.rewrite(value, &mut self.nodes);
        let mut coordinates = self.coordinates.clone();
        coordinates
            .any(|i| self.graph.depends_on(value, Leaf::Q(i)) || self.graph.depends_on(value, Leaf::N(i)))
    }

    /// Whether a map, given by its position and its other components, depends on one of the positions other
    /// than by mapping it to itself.
    fn positions_occur_in_map(&mut self, [position, others]: [&[NodeId]; 2]) -> bool {
        let own = self.coordinates.clone();
        let other = position.iter().enumerate().filter(|(i, _)| !own.contains(i));
        let other: Vec<NodeId> = other.map(|(_, value)| *value).collect();
        other
            .iter()
            .chain(others)
            .any(|&value| self.positions_occur_in(value))
    }
}

/// The part of the declaration in which the positions of some coordinates occur, for a message; `None` if
/// they occur in no equation.
pub(crate) fn where_position_is(model: &Model, coordinates: Range<usize>) -> Option<&'static str> {
    let mut graph = model.graph.clone();
    let places = Nodes::new(&mut graph, model.coordinates.len()).substitution();
    let mut search = PositionSearch {
        nodes: Substitution::new(&places),
        graph,
        coordinates,
    };
    if model.discrete_lagrangian.is_none() && search.positions_occur_in(model.lagrangian) {
        return Some("the Lagrangian");
    }
    if model
        .discrete_lagrangian
        .is_some_and(|value| search.positions_occur_in(value))
    {
        return Some("the discrete Lagrangian");
    }
    for row in &model.constraints {
        let all = [Some(row.value), row.discrete, row.divide];
        if all
            .into_iter()
            .flatten()
            .any(|value| search.positions_occur_in(value))
        {
            return Some(match row.kind {
                Kind::Holonomic => "a holonomic constraint",
                Kind::Nonholonomic => "a nonholonomic constraint",
                Kind::Kinematic => "a kinematic constraint",
            });
        }
    }
    let mut forms = model.forms.iter().flat_map(|form| &form.components);
    if forms.any(|&value| search.positions_occur_in(value)) {
        return Some("a constraint force");
    }
    if let Displacements::Fields(fields) = &model.displacements
        && fields
            .iter()
            .flatten()
            .any(|&value| search.positions_occur_in(value))
    {
        return Some("a virtual displacement");
    }
    if model
        .external_forces
        .iter()
        .any(|&value| search.positions_occur_in(value))
    {
        return Some("an external force");
    }
    let mut pairs = model.phi_lagrangian.iter();
    if model.discrete_lagrangian.is_none()
        && pairs.any(|PairPoint { t: _, q, v }| search.positions_occur_in_map([q, v]))
    {
        return Some("the map of the Lagrangian");
    }
    let mut triples = [&model.phi_kinematic, &model.phi_variational]
        .into_iter()
        .flatten();
    triples
        .any(|TriplePoint { t: _, q, v, a }| search.positions_occur_in_map([q, &[&v[..], a].concat()]))
        .then_some("a map of three nodes")
}
