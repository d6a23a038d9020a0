//! The equations of a declaration, as expressions: the discrete step (paper, section 3) and the continuous system
//! (paper, section 2).

use std::collections::HashMap;

use crate::graph::{Change, Graph, Leaf, NodeId};
use crate::model::Model;

/// A point of the second order tangent bundle, component by component.
pub(crate) struct PointNodes {
    pub(crate) q: Vec<NodeId>,
    pub(crate) v: Vec<NodeId>,
    pub(crate) a: Vec<NodeId>,
}

impl PointNodes {
    fn substitution(&self) -> HashMap<Leaf, NodeId> {
        places([
            (Leaf::Q as LeafOf, &self.q),
            (Leaf::V, &self.v),
            (Leaf::A, &self.a),
        ])
    }
}

/// The leaf of a coordinate.
type LeafOf = fn(usize) -> Leaf;

/// What stands in the place of leaves, coordinate by coordinate.
fn places<const K: usize>(vectors: [(LeafOf, &[NodeId]); K]) -> HashMap<Leaf, NodeId> {
    let components = |(leaf, nodes): (LeafOf, &[NodeId])| {
        nodes
            .iter()
            .enumerate()
            .map(|(i, &node)| (leaf(i), node))
            .collect::<Vec<_>>()
    };
    vectors.into_iter().flat_map(components).collect()
}

/// A row that has to vanish, and a factor that has to be divided out of it.
#[derive(Clone, Copy)]
pub(crate) struct Equation {
    pub(crate) value: NodeId,
    /// The same row with differences as they are: it loses digits, but its derivative does not, and is the simpler one.
    pub(crate) plain: NodeId,
    pub(crate) divide: Option<NodeId>,
}

impl Equation {
    /// Its expressions, to be rewritten.
    pub(crate) fn parts(&mut self) -> impl Iterator<Item = &mut NodeId> {
        [&mut self.value, &mut self.plain]
            .into_iter()
            .chain(&mut self.divide)
    }
}

/// The discrete step in terms of the middle node `N`, the known increment `D` and the second difference `E`.
pub(crate) struct StepEquations {
    /// Kinematic rows, then `⟨u, Q⟩` for every field.
    pub(crate) rows: Vec<Equation>,
    /// `φ_{D_K}⁻¹(q0, q1, q2)`.
    pub(crate) point: PointNodes,
    /// The constraint force `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1))`.
    pub(crate) force: Vec<NodeId>,
}

/// The continuous system in terms of `Q`, `V` and `A`.
pub(crate) struct ContinuousEquations {
    /// Kinematic rows, then `⟨u, Q⟩` for every field.
    pub(crate) rows: Vec<Equation>,
    /// The constraint force `Q = -D_{EL}L = d/dt ∂L/∂v - ∂L/∂q`.
    pub(crate) force: Vec<NodeId>,
}

/// The nodes of a step: `q0 = N - D`, `q1 = N`, `q2 = N + D + E`.
struct Nodes {
    q0: Vec<NodeId>,
    q1: Vec<NodeId>,
    q2: Vec<NodeId>,
    d0: Vec<NodeId>,
    d1: Vec<NodeId>,
    e: Vec<NodeId>,
}

impl Nodes {
    fn new(graph: &mut Graph, n: usize) -> Self {
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
}

/// The discrete step that the declaration asks for.
pub(crate) fn step(model: &Model, graph: &mut Graph) -> StepEquations {
    let n = model.coordinates.len();
    let nodes = Nodes::new(graph, n);
    let point = map_point(graph, &nodes, model.phi_kinematic.as_ref());
    let displacements = match &model.phi_variational {
        Some(map) => map_point(graph, &nodes, Some(map)).substitution(),
        None => map_point(graph, &nodes, None).substitution(),
    };
    let Force { value: force, plain } = discrete_force(model, graph, &nodes);
    let kinematic = point.substitution();
    let mut rows = Vec::new();
    for row in &model.kinematic {
        let value = graph.substitute(row.value, &kinematic);
        let divide = row.divide.map(|factor| graph.substitute(factor, &kinematic));
        rows.push(Equation {
            value,
            plain: value,
            divide,
        });
    }
    for field in &model.variational {
        let field: Vec<_> = field
            .iter()
            .map(|&u| graph.substitute(u, &displacements))
            .collect();
        let mut work = |force: &[NodeId]| {
            let terms: Vec<_> = field
                .iter()
                .zip(force)
                .map(|(&u, &force)| graph.mul(u, force))
                .collect();
            graph.sum(&terms)
        };
        rows.push(Equation {
            value: work(&force),
            plain: work(&plain),
            divide: None,
        });
    }
    StepEquations { rows, point, force }
}

/// The paper's map `(q1, (q2 - q0)/2h, (q2 - 2 q1 + q0)/h²)`, or the declared one.
fn map_point(graph: &mut Graph, nodes: &Nodes, map: Option<&[Vec<NodeId>; 3]>) -> PointNodes {
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
    let places = places([
        (Leaf::X0 as LeafOf, &nodes.q0),
        (Leaf::X1, &nodes.q1),
        (Leaf::X2, &nodes.q2),
    ]);
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

/// `φ_{L_d}⁻¹(x0, x1)`: the paper's `(x0, (x1 - x0)/h)`, or the declared map.
fn lagrangian_point(model: &Model, graph: &mut Graph) -> [Vec<NodeId>; 2] {
    if let Some(map) = &model.phi_lagrangian {
        return map.clone();
    }
    let h = graph.leaf(Leaf::H);
    let (mut q, mut v) = (Vec::new(), Vec::new());
    for i in 0..model.coordinates.len() {
        let (x0, x1) = (graph.leaf(Leaf::X0(i)), graph.leaf(Leaf::X1(i)));
        let chord = graph.sub(x1, x0);
        q.push(x0);
        v.push(graph.div(chord, h));
    }
    [q, v]
}

/// `L_d(x0, x1) = L(φ_{L_d}⁻¹(x0, x1))`, on the leg from `N - D` to `N`.
pub(crate) fn discrete_lagrangian(model: &Model, graph: &mut Graph) -> NodeId {
    let n = model.coordinates.len();
    let [q, v] = lagrangian_point(model, graph);
    let point = places([(Leaf::Q as LeafOf, &q), (Leaf::V, &v)]);
    let value = graph.substitute(model.lagrangian, &point);
    let nodes = Nodes::new(graph, n);
    let leg = places([(Leaf::X0 as LeafOf, &nodes.q0), (Leaf::X1, &nodes.q1)]);
    graph.substitute(value, &leg)
}

/// `-(D₁L_d(q1,q2) + D₂L_d(q0,q1))`.
///
/// With `P₁, P₂` the parts of `D₁L_d, D₂L_d` that come through the velocity of the map and `F₁, F₂` those that come
/// through its position, the sum is `F₁(q1,q2) + F₂(q0,q1) + (P₁+P₂)(q1,q2) - [P₂(q1,q2) - P₂(q0,q1)]`. The bracket is
/// formed as a change (see [`Graph::difference`]), because its two values agree to `O(h)`; `P₁ + P₂` is zero whenever
/// the map's velocity depends on `x1 - x0` alone.
fn discrete_force(model: &Model, graph: &mut Graph, nodes: &Nodes) -> Force {
    let n = model.coordinates.len();
    let [q, v] = lagrangian_point(model, graph);
    let point = places([(Leaf::Q as LeafOf, &q), (Leaf::V, &v)]);
    let mut moved = HashMap::new();
    let mut by_position = Vec::new();
    let mut by_velocity = Vec::new();
    for i in 0..n {
        let (dq, dv) = (
            graph.derivative(model.lagrangian, Leaf::Q(i)),
            graph.derivative(model.lagrangian, Leaf::V(i)),
        );
        by_position.push(graph.substitute_in(dq, &point, &mut moved));
        by_velocity.push(graph.substitute_in(dv, &point, &mut moved));
    }
    let first = places([(Leaf::X0 as LeafOf, &nodes.q0), (Leaf::X1, &nodes.q1)]);
    let second = places([(Leaf::X0 as LeafOf, &nodes.q1), (Leaf::X1, &nodes.q2)]);
    let mut change = HashMap::new();
    for i in 0..n {
        change.insert(
            Leaf::X0(i),
            Change {
                before: nodes.q0[i],
                after: nodes.q1[i],
                delta: nodes.d0[i],
            },
        );
        change.insert(
            Leaf::X1(i),
            Change {
                before: nodes.q1[i],
                after: nodes.q2[i],
                delta: nodes.d1[i],
            },
        );
    }
    let mut changes = HashMap::new();
    let (mut on_first, mut on_second) = (HashMap::new(), HashMap::new());
    let (mut value, mut plain) = (Vec::new(), Vec::new());
    for i in 0..n {
        let through = |graph: &mut Graph, outer: &[NodeId], inner: &[NodeId], leaf: Leaf| {
            let terms: Vec<_> = outer
                .iter()
                .zip(inner)
                .map(|(&outer, &inner)| {
                    let slope = graph.derivative(inner, leaf);
                    graph.mul(outer, slope)
                })
                .collect();
            graph.sum(&terms)
        };
        let f1 = through(graph, &by_position, &q, Leaf::X0(i));
        let f2 = through(graph, &by_position, &q, Leaf::X1(i));
        let p1 = through(graph, &by_velocity, &v, Leaf::X0(i));
        let p2 = through(graph, &by_velocity, &v, Leaf::X1(i));
        let rest = graph.sum(&[f1, p1, p2]);
        let rest = graph.substitute_in(rest, &second, &mut on_second);
        let f2 = graph.substitute_in(f2, &first, &mut on_first);
        let late = |leaf: Leaf| matches!(leaf, Leaf::E(_));
        let momentum = graph.difference(p2, &change, &late, &mut changes);
        value.push(graph.linear(0.0, &[(momentum.delta, 1.0), (rest, -1.0), (f2, -1.0)]));
        let (after, before) = (momentum.after, momentum.before);
        plain.push(graph.linear(0.0, &[(after, 1.0), (before, -1.0), (rest, -1.0), (f2, -1.0)]));
    }
    Force { value, plain }
}

/// A force, component by component.
struct Force {
    value: Vec<NodeId>,
    /// With the difference of the momenta as it is.
    plain: Vec<NodeId>,
}

/// The continuous system that the declaration describes.
pub(crate) fn continuous(model: &Model, graph: &mut Graph) -> ContinuousEquations {
    let n = model.coordinates.len();
    let mut force = Vec::new();
    for i in 0..n {
        let momentum = graph.derivative(model.lagrangian, Leaf::V(i));
        let rate = graph.total_derivative(momentum);
        let slope = graph.derivative(model.lagrangian, Leaf::Q(i));
        force.push(graph.sub(rate, slope));
    }
    let mut rows = Vec::new();
    for row in &model.kinematic {
        rows.push(Equation {
            value: row.value,
            plain: row.value,
            divide: row.divide,
        });
    }
    for field in &model.variational {
        let terms: Vec<_> = field
            .iter()
            .zip(&force)
            .map(|(&u, &force)| graph.mul(u, force))
            .collect();
        let value = graph.sum(&terms);
        rows.push(Equation {
            value,
            plain: value,
            divide: None,
        });
    }
    ContinuousEquations { rows, force }
}

/// `⟨∂L/∂v, v⟩ - L`.
pub(crate) fn energy(model: &Model, graph: &mut Graph) -> NodeId {
    let mut terms = Vec::new();
    for i in 0..model.coordinates.len() {
        let (momentum, v) = (
            graph.derivative(model.lagrangian, Leaf::V(i)),
            graph.leaf(Leaf::V(i)),
        );
        terms.push((graph.mul(momentum, v), 1.0));
    }
    terms.push((model.lagrangian, -1.0));
    graph.linear(0.0, &terms)
}
