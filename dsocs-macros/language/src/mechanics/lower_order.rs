//! Constraints on positions and velocities, for a pair of nodes and for a start.

use super::nodes::{Nodes, on_pair};
use crate::graph::{Graph, Leaf, NodeId};
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

/// Rows, and their derivatives by the coordinates or the velocities, row by row.
pub(crate) struct RowsWithSlopes {
    pub(crate) rows: Vec<NodeId>,
    slopes: Vec<NodeId>,
}

impl RowsWithSlopes {
    fn new(graph: &mut Graph, rows: Vec<NodeId>, by: fn(usize) -> Leaf, n: usize) -> Self {
        let slopes = rows.iter().flat_map(|&row| (0..n).map(move |i| (row, by(i))));
        let slopes = slopes.map(|(row, leaf)| graph.derivative(row, leaf)).collect();
        Self { rows, slopes }
    }

    /// The rows, then their slopes.
    pub(crate) fn rows_then_slopes(&self) -> Vec<NodeId> {
        [self.rows.as_slice(), &self.slopes].concat()
    }
}

/// The constraints of lower order at a position and a velocity.
pub(crate) struct LowerOrder {
    /// The rows for the position: the holonomic constraints `g(q)`.
    pub(crate) positions: RowsWithSlopes,
    /// The rows for the velocity: the nonholonomic constraints `c(q, v)`, then `dg/dt`.
    pub(crate) velocities: RowsWithSlopes,
}

impl LowerOrder {
    /// The constraints of a declaration; `None` if there are none.
    pub(crate) fn new(model: &Model, graph: &mut Graph) -> Option<Self> {
        let holonomic = model.count(Kind::Holonomic);
        if holonomic + model.count(Kind::Nonholonomic) == 0 {
            return None;
        }
        let n = model.coordinates.len();
        let mut positions = phase(model, graph);
        let velocities = positions.split_off(holonomic);
        Some(Self {
            positions: RowsWithSlopes::new(graph, positions, Leaf::Q, n),
            velocities: RowsWithSlopes::new(graph, velocities, Leaf::V, n),
        })
    }
}
