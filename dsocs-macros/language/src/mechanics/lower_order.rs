//! Constraints on positions and velocities, for a pair of nodes and for a start.

use super::nodes::{Nodes, on_pair};
use crate::graph::{Graph, NodeId};
use crate::model::{Kind, Model, Row};

/// The constraints of lower order on the leg from `N - D` to `N`: `g(q1)` and `c(φ⁻¹(q0, q1))`, in the order
/// of the declaration.
pub(crate) fn pair(model: &Model, graph: &mut Graph) -> Vec<NodeId> {
    let nodes = Nodes::new(graph, model.coordinates.len());
    let (node, leg) = (nodes.middle(), nodes.first_leg());
    let lower = |row: &&Row| row.kind != Kind::Kinematic;
    let rows = model.constraints.iter().filter(lower);
    rows.map(|row| {
        if row.kind == Kind::Holonomic {
            return graph.substitute(row.value, &node);
        }
        let value = on_pair(model, graph, row.value);
        graph.substitute(value, &leg)
    })
    .collect()
}

/// The constraints on a position and a velocity: `g(q)` and `c(q, v)`, then `dg/dt`.
pub(crate) fn phase(model: &Model, graph: &mut Graph) -> Vec<NodeId> {
    let of = |kind| {
        let rows = model.constraints.iter().filter(move |row| row.kind == kind);
        rows.map(|row| row.value)
    };
    let mut rows: Vec<_> = of(Kind::Holonomic).chain(of(Kind::Nonholonomic)).collect();
    for holonomic in of(Kind::Holonomic) {
        rows.push(graph.total_derivative(holonomic));
    }
    rows
}
