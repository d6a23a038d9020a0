//! The nodes of a step, and the maps `φ⁻¹` from them to points of the continuous system (paper, section 3).

use std::collections::HashMap;

use crate::graph::{Graph, Leaf, NodeId};
use crate::model::Model;

/// A point of the second order tangent bundle, component by component.
pub(crate) struct PointNodes {
    pub(crate) q: Vec<NodeId>,
    pub(crate) v: Vec<NodeId>,
    pub(crate) a: Vec<NodeId>,
}

impl PointNodes {
    pub(super) fn substitution(&self) -> HashMap<Leaf, NodeId> {
        places([
            (Leaf::Q as LeafOf, &self.q),
            (Leaf::V, &self.v),
            (Leaf::A, &self.a),
        ])
    }
}

/// The leaf of a coordinate.
pub(super) type LeafOf = fn(usize) -> Leaf;

/// What stands in the place of leaves, coordinate by coordinate.
pub(super) fn places<const K: usize>(vectors: [(LeafOf, &[NodeId]); K]) -> HashMap<Leaf, NodeId> {
    let components = |(leaf, nodes): (LeafOf, &[NodeId])| {
        nodes
            .iter()
            .enumerate()
            .map(|(i, &node)| (leaf(i), node))
            .collect::<Vec<_>>()
    };
    vectors.into_iter().flat_map(components).collect()
}

/// The nodes of a step: `q0 = N - D`, `q1 = N`, `q2 = N + D + E`.
pub(super) struct Nodes {
    pub(super) q0: Vec<NodeId>,
    pub(super) q1: Vec<NodeId>,
    pub(super) q2: Vec<NodeId>,
    pub(super) d0: Vec<NodeId>,
    pub(super) d1: Vec<NodeId>,
    pub(super) e: Vec<NodeId>,
}

impl Nodes {
    pub(super) fn new(graph: &mut Graph, n: usize) -> Self {
        let mut nodes = Self {
            q0: Vec::new(),
            q1: Vec::new(),
            q2: Vec::new(),
            d0: Vec::new(),
            d1: Vec::new(),
            e: Vec::new(),
        };
        for i in 0..n {
            let (node, d, e) = (
                graph.leaf(Leaf::N(i)),
                graph.leaf(Leaf::D(i)),
                graph.leaf(Leaf::E(i)),
            );
            nodes.q0.push(graph.sub(node, d));
            nodes.q1.push(node);
            nodes.q2.push(graph.sum(&[node, d, e]));
            nodes.d0.push(d);
            nodes.d1.push(graph.add(d, e));
            nodes.e.push(e);
        }
        nodes
    }

    /// What stands in the place of the nodes of a map.
    pub(super) fn places(&self) -> HashMap<Leaf, NodeId> {
        places([
            (Leaf::X0 as LeafOf, &self.q0),
            (Leaf::X1, &self.q1),
            (Leaf::X2, &self.q2),
        ])
    }
}

/// An expression of positions and velocities on a leg, in `X0`, `X1`: its mean over the points of the first order map.
pub(super) fn on_pair(model: &Model, graph: &mut Graph, value: NodeId) -> NodeId {
    let weight = 1.0 / model.phi_lagrangian.len() as f64;
    let terms: Vec<_> = model
        .phi_lagrangian
        .iter()
        .map(|[q, v]| {
            let point = places([(Leaf::Q as LeafOf, q), (Leaf::V, v)]);
            (graph.substitute(value, &point), weight)
        })
        .collect();
    graph.linear(0.0, &terms)
}

/// The paper's map `(q1, (q2 - q0)/2h, (q2 - 2 q1 + q0)/h²)`, or the declared one.
pub(super) fn map_point(graph: &mut Graph, nodes: &Nodes, map: Option<&[Vec<NodeId>; 3]>) -> PointNodes {
    let n = nodes.q1.len();
    let Some([q, v, a]) = map else {
        let h = graph.leaf(Leaf::H);
        let (mut v, mut a) = (Vec::new(), Vec::new());
        for i in 0..n {
            let span = graph.linear(0.0, &[(nodes.d0[i], 2.0), (nodes.e[i], 1.0)]);
            let velocity = graph.div(span, h);
            v.push(graph.scale(0.5, velocity));
            a.push(graph.product(&[(nodes.e[i], 1), (h, -2)]));
        }
        return PointNodes {
            q: nodes.q1.clone(),
            v,
            a,
        };
    };
    let places = nodes.places();
    let mut put = |components: &[NodeId]| -> Vec<NodeId> {
        components
            .iter()
            .map(|&component| graph.substitute(component, &places))
            .collect()
    };
    PointNodes {
        q: put(q),
        v: put(v),
        a: put(a),
    }
}
