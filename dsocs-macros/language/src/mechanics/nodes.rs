//! The nodes of a step, and the maps `φ⁻¹` from them to points of the continuous system (paper, section 3).

use crate::graph::calculus::rotation::SLOTS;
use crate::graph::{Change, Graph, Leaf, NodeId};
use crate::hash::HashMap;
use crate::model::{Model, PairPoint, TriplePoint};

/// A point `(t, q, v, a)` of the second order tangent bundle, component by component.
pub(crate) struct PointNodes {
    pub(crate) t: NodeId,
    pub(crate) q: Vec<NodeId>,
    pub(crate) v: Vec<NodeId>,
    pub(crate) a: Vec<NodeId>,
}

impl PointNodes {
    pub(super) fn substitution(&self) -> HashMap<Leaf, NodeId> {
        let mut places = substitution_of([
            (Leaf::Q as LeafOf, &self.q),
            (Leaf::V, &self.v),
            (Leaf::A, &self.a),
        ]);
        places.insert(Leaf::T, self.t);
        places
    }
}

/// A kind of leaf, as the function from coordinate to leaf.
pub(super) type LeafOf = fn(usize) -> Leaf;

/// The substitution of the components of some vectors for leaves.
pub(super) fn substitution_of<const K: usize>(vectors: [(LeafOf, &[NodeId]); K]) -> HashMap<Leaf, NodeId> {
    let components = |(leaf, nodes): (LeafOf, &[NodeId])| {
        nodes
            .iter()
            .enumerate()
            .map(|(i, &node)| (leaf(i), node))
            .collect::<Vec<_>>()
    };
    vectors.into_iter().flat_map(components).collect()
}

/// The nodes of a step: `q0 = N - D`, `q1 = N`, `q2 = N + D + e`, at the times `Clock - H`, `Clock` and
/// `Clock + H`. The second difference `e` is `E`; in a step of third order it is `P + E`, with `P` the
/// previous second difference, which ends with `q1`.
pub(super) struct Nodes {
    pub(super) q0: Vec<NodeId>,
    pub(super) q1: Vec<NodeId>,
    pub(super) q2: Vec<NodeId>,
    pub(super) d0: Vec<NodeId>,
    pub(super) d1: Vec<NodeId>,
    /// The changes `q1 - q0` and `q2 - q1`, component by component: the increments, unless they are of a
    /// rotation.
    pub(super) changes: [Vec<NodeId>; 2],
    pub(super) e: Vec<NodeId>,
    pub(super) t0: NodeId,
    pub(super) t1: NodeId,
    pub(super) t2: NodeId,
}

impl Nodes {
    /// The nodes of a step of second order, or of a leg.
    pub(super) fn new(graph: &mut Graph, n: usize) -> Self {
        Self::with(graph, n, |graph, i| graph.leaf(Leaf::E(i)))
    }

    /// The nodes of a declaration's step.
    pub(super) fn of_step(graph: &mut Graph, model: &Model) -> Self {
        let n = model.coordinates.len();
        if model.order() < 3 {
            return Self::new(graph, n);
        }
        Self::with(graph, n, |graph, i| {
            let (before, change) = (graph.leaf(Leaf::P(i)), graph.leaf(Leaf::E(i)));
            graph.add(before, change)
        })
    }

    fn with(graph: &mut Graph, n: usize, second_difference: impl Fn(&mut Graph, usize) -> NodeId) -> Self {
        let (t1, h) = (graph.leaf(Leaf::Clock), graph.leaf(Leaf::H));
        let mut nodes = Self {
            t0: graph.sub(t1, h),
            t1,
            t2: graph.add(t1, h),
            q0: Vec::new(),
            q1: Vec::new(),
            q2: Vec::new(),
            d0: Vec::new(),
            d1: Vec::new(),
            changes: [Vec::new(), Vec::new()],
            e: Vec::new(),
        };
        for i in 0..n {
            let (node, d) = (graph.leaf(Leaf::N(i)), graph.leaf(Leaf::D(i)));
            let e = second_difference(graph, i);
            nodes.q0.push(graph.sub(node, d));
            nodes.q1.push(node);
            nodes.q2.push(graph.sum(&[node, d, e]));
            nodes.d0.push(d);
            nodes.d1.push(graph.add(d, e));
            nodes.e.push(e);
        }
        nodes.changes = [nodes.d0.clone(), nodes.d1.clone()];
        for first in graph.rotations().to_vec() {
            nodes.set_rotation(graph, first);
        }
        nodes
    }

    /// Sets the nodes of a rotation: `q0 = q1 τ(-d0)` and `q2 = q1 τ(d1)`.
    fn set_rotation(&mut self, graph: &mut Graph, first: usize) {
        let slots = first..first + SLOTS;
        let q1 = [0, 1, 2, 3].map(|k| self.q1[first + k]);
        let [back, on] = [(&self.d0, -1.0), (&self.d1, 1.0)].map(|(d, sign)| {
            let x = [1, 2, 3].map(|k| graph.scale(sign, d[first + k]));
            graph.quaternion_change(q1, x)
        });
        for (k, i) in slots.enumerate() {
            self.q0[i] = graph.add(q1[k], back[k]);
            self.q2[i] = graph.add(q1[k], on[k]);
            self.changes[0][i] = graph.neg(back[k]);
            self.changes[1][i] = on[k];
        }
    }

    /// The substitution for the nodes of a map of triples.
    pub(super) fn substitution(&self) -> HashMap<Leaf, NodeId> {
        let mut places = substitution_of([
            (Leaf::X0 as LeafOf, &self.q0),
            (Leaf::X1, &self.q1),
            (Leaf::X2, &self.q2),
        ]);
        places.extend([(Leaf::T0, self.t0), (Leaf::T1, self.t1), (Leaf::T2, self.t2)]);
        places
    }

    /// The substitution for the nodes of a map of pairs, on the leg from `q0` to `q1`.
    pub(super) fn first_leg(&self) -> HashMap<Leaf, NodeId> {
        leg([(&self.q0, self.t0), (&self.q1, self.t1)], &self.d0)
    }

    /// The substitution for the nodes of a map of pairs, on the leg from `q1` to `q2`.
    pub(super) fn second_leg(&self) -> HashMap<Leaf, NodeId> {
        leg([(&self.q1, self.t1), (&self.q2, self.t2)], &self.d1)
    }

    /// The substitution for a position and its time, at the middle node.
    pub(super) fn middle(&self) -> HashMap<Leaf, NodeId> {
        let mut places = substitution_of([(Leaf::Q as LeafOf, &self.q1)]);
        places.insert(Leaf::T, self.t1);
        places
    }

    /// The substitution by the map of four nodes `(p, q0, q1, q2)`, of second order and symmetric in time, at
    /// the middle of the leg from `q0` to `q1`:
    /// `((q0+q1)/2, (q1-q0)/h, (q2-q1-q0+p)/2h², (q2-3q1+3q0-p)/h³)`.
    pub(super) fn middle_of_four(&self, graph: &mut Graph) -> HashMap<Leaf, NodeId> {
        let h = graph.leaf(Leaf::H);
        let mut places = HashMap::from_iter([(Leaf::T, graph.linear(0.0, &[(self.t1, 1.0), (h, -0.5)]))]);
        for i in 0..self.q1.len() {
            let (before, change) = (graph.leaf(Leaf::P(i)), graph.leaf(Leaf::E(i)));
            let a = graph.linear(0.0, &[(before, 1.0), (change, 0.5)]);
            places.extend([
                (
                    Leaf::Q(i),
                    graph.linear(0.0, &[(self.q1[i], 1.0), (self.d0[i], -0.5)]),
                ),
                (Leaf::V(i), graph.div(self.d0[i], h)),
                (Leaf::A(i), graph.product(&[(a, 1), (h, -2)])),
                (Leaf::J(i), graph.product(&[(change, 1), (h, -3)])),
            ]);
        }
        places
    }

    /// The changes of `T0` and `T1` from the first leg to the second.
    pub(super) fn change_of_time(&self, graph: &mut Graph) -> [(Leaf, Change); 2] {
        let delta = graph.leaf(Leaf::H);
        let change = |before, after| Change { before, after, delta };
        [
            (Leaf::T0, change(self.t0, self.t1)),
            (Leaf::T1, change(self.t1, self.t2)),
        ]
    }
}

/// The substitution for the nodes of a map of pairs, with the increment `d` of the leg.
fn leg([(q0, t0), (q1, t1)]: [(&[NodeId], NodeId); 2], d: &[NodeId]) -> HashMap<Leaf, NodeId> {
    let mut places = substitution_of([(Leaf::X0 as LeafOf, q0), (Leaf::X1, q1), (Leaf::Chord, d)]);
    places.extend([(Leaf::T0, t0), (Leaf::T1, t1)]);
    places
}

/// The substitution for position, velocity and time at a point of `φ_{L_d}⁻¹`.
pub(super) fn at_pair(point: &PairPoint) -> HashMap<Leaf, NodeId> {
    let mut places = substitution_of([(Leaf::Q as LeafOf, &point.q), (Leaf::V, &point.v)]);
    places.insert(Leaf::T, point.t);
    places
}

/// The mean of an expression of `Q`, `V` and `T` over the points of `φ_{L_d}⁻¹`, in `X0`, `X1`, `T0` and
/// `T1`.
pub(super) fn on_pair(model: &Model, graph: &mut Graph, value: NodeId) -> NodeId {
    mean(graph, value, &model.phi_lagrangian)
}

/// The mean of an expression over points of a leg.
pub(super) fn mean(graph: &mut Graph, value: NodeId, points: &[PairPoint]) -> NodeId {
    let weight = 1.0 / points.len() as f64;
    let terms: Vec<_> = points
        .iter()
        .map(|point| (graph.substitute(value, &at_pair(point)), weight))
        .collect();
    graph.linear(0.0, &terms)
}

/// The point `φ⁻¹(q0, q1, q2)` by a declared map, or else by the paper's
/// `(q1, (q2 - q0)/2h, (q2 - 2 q1 + q0)/h²)`.
pub(super) fn map_point(graph: &mut Graph, nodes: &Nodes, map: Option<&TriplePoint>) -> PointNodes {
    let n = nodes.q1.len();
    let Some(TriplePoint { t, q, v, a }) = map else {
        let h = graph.leaf(Leaf::H);
        let (mut v, mut a) = (Vec::new(), Vec::new());
        for i in 0..n {
            let span = graph.linear(0.0, &[(nodes.d0[i], 2.0), (nodes.e[i], 1.0)]);
            let velocity = graph.div(span, h);
            v.push(graph.scale(0.5, velocity));
            a.push(graph.product(&[(nodes.e[i], 1), (h, -2)]));
        }
        return PointNodes {
            t: nodes.t1,
            q: nodes.q1.clone(),
            v,
            a,
        };
    };
    let places = nodes.substitution();
    let mut at_nodes = |components: &[NodeId]| -> Vec<NodeId> {
        components
            .iter()
            .map(|&component| graph.substitute(component, &places))
            .collect()
    };
    let (q, v, a) = (at_nodes(q), at_nodes(v), at_nodes(a));
    let t = graph.substitute(*t, &places);
    PointNodes { t, q, v, a }
}
