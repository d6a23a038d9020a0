//! The equations of a declaration, as expressions: the discrete step (paper, section 3) and the continuous system
//! (paper, section 2).

use std::collections::HashMap;

use crate::graph::{Change, Graph, Leaf, NodeId};
use crate::model::{Displacements, Kind, Model, Row};

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
    /// The constraints, then `⟨u, Q⟩` for every field, or `Q - Σ λ_j α_j`.
    pub(crate) rows: Vec<Equation>,
    /// How many multipliers are among the unknowns.
    pub(crate) multipliers: usize,
    /// `φ_{D_K}⁻¹(q0, q1, q2)`.
    pub(crate) point: PointNodes,
    /// The constraint force `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1))`.
    pub(crate) force: Vec<NodeId>,
    /// The forms in whose directions it acts, as far as they are known.
    pub(crate) forms: Vec<Vec<NodeId>>,
}

/// The continuous system in terms of `Q`, `V` and `A`.
pub(crate) struct ContinuousEquations {
    /// The constraints, differentiated until accelerations come in, then `⟨u, Q⟩` for every field, or `Q - Σ λ_j α_j`.
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

    /// What stands in the place of the nodes of a map.
    fn places(&self) -> HashMap<Leaf, NodeId> {
        places([
            (Leaf::X0 as LeafOf, &self.q0),
            (Leaf::X1, &self.q1),
            (Leaf::X2, &self.q2),
        ])
    }
}

/// The discrete step that the declaration asks for.
pub(crate) fn step(model: &Model, graph: &mut Graph) -> StepEquations {
    let n = model.coordinates.len();
    let nodes = Nodes::new(graph, n);
    let point = map_point(graph, &nodes, model.phi_kinematic.as_ref());
    let displacements = map_point(graph, &nodes, model.phi_variational.as_ref()).substitution();
    let force = discrete_force(model, graph, &nodes);
    let forms = discrete_forms(model, graph, &displacements);
    let kinematic = point.substitution();
    let mut rows = Vec::new();
    for row in &model.constraints {
        let value = match (row.discrete, row.kind) {
            (Some(discrete), _) => graph.substitute(discrete, &nodes.places()),
            (None, Kind::Holonomic) => {
                rows.push(holonomic(graph, &nodes, row.value));
                continue;
            }
            (None, Kind::Nonholonomic) => {
                let value = on_pair(model, graph, row.value);
                let leg = places([(Leaf::X0 as LeafOf, &nodes.q1), (Leaf::X1, &nodes.q2)]);
                graph.substitute(value, &leg)
            }
            (None, Kind::Kinematic) => graph.substitute(row.value, &kinematic),
        };
        let divide = row.divide.map(|factor| graph.substitute(factor, &kinematic));
        rows.push(Equation {
            value,
            plain: value,
            divide,
        });
    }
    let fields = match &model.displacements {
        Displacements::Fields(fields) => Some(fields.iter().map(|field| {
            let mut done = HashMap::new();
            let components = field.iter();
            components
                .map(|&u| graph.substitute_in(u, &displacements, &mut done))
                .collect()
        })),
        Displacements::Annihilated => None,
    };
    let fields: Option<Vec<Vec<NodeId>>> = fields.map(Iterator::collect);
    rows.extend(works(graph, fields.as_deref(), &forms, &force));
    StepEquations {
        rows,
        multipliers: model.multipliers(),
        point,
        force: force.value,
        forms,
    }
}

/// How much of a holonomic constraint's value at the middle node, which is nothing but rounding, the next one takes away.
const CORRECTED: f64 = 1.0 / 1024.0;

/// `g(q2)`, for a middle node with `g(q1) = 0`: the change from there, formed without cancellation, and a small part of what
/// rounding has left there, so that it does not add up. All of it would be seen in the second difference, whose own size is
/// `h²`.
fn holonomic(graph: &mut Graph, nodes: &Nodes, g: NodeId) -> Equation {
    let change = (0..nodes.q1.len())
        .map(|i| {
            let change = Change {
                before: nodes.q1[i],
                after: nodes.q2[i],
                delta: nodes.d1[i],
            };
            (Leaf::Q(i), change)
        })
        .collect();
    let late = |leaf: Leaf| matches!(leaf, Leaf::E(_));
    let Change { before, after, delta } = graph.difference(g, &change, &late, &mut HashMap::new());
    Equation {
        value: graph.linear(0.0, &[(delta, 1.0), (before, CORRECTED)]),
        plain: graph.linear(0.0, &[(after, 1.0), (before, CORRECTED - 1.0)]),
        divide: None,
    }
}

/// The works `⟨u, Q⟩` of the constraint force along the fields, or, where there are none, what the forces of the
/// constraints leave of it: `Q - Σ λ_j α_j`.
fn works(
    graph: &mut Graph,
    fields: Option<&[Vec<NodeId>]>,
    forms: &[Vec<NodeId>],
    force: &Force,
) -> Vec<Equation> {
    let mut equation = |part: &dyn Fn(&mut Graph, &[NodeId]) -> NodeId| Equation {
        value: part(graph, &force.value),
        plain: part(graph, &force.plain),
        divide: None,
    };
    match fields {
        Some(fields) => fields
            .iter()
            .map(|field| {
                equation(&|graph, force| {
                    let terms: Vec<_> = field
                        .iter()
                        .zip(force)
                        .map(|(&u, &force)| graph.mul(u, force))
                        .collect();
                    graph.sum(&terms)
                })
            })
            .collect(),
        None => (0..force.value.len())
            .map(|i| {
                equation(&|graph, force| {
                    let mut terms = vec![(force[i], 1.0)];
                    for (j, form) in forms.iter().enumerate() {
                        let multiplier = graph.leaf(Leaf::Lambda(j));
                        terms.push((graph.mul(multiplier, form[i]), -1.0));
                    }
                    graph.linear(0.0, &terms)
                })
            })
            .collect(),
    }
}

/// The forms of the constraint forces: those of holonomic constraints at the middle node, the others at `φ_{D_V}⁻¹`.
fn discrete_forms(
    model: &Model,
    graph: &mut Graph,
    displacements: &HashMap<Leaf, NodeId>,
) -> Vec<Vec<NodeId>> {
    let node = (0..model.coordinates.len())
        .map(|i| (Leaf::Q(i), graph.leaf(Leaf::N(i))))
        .collect();
    model
        .forms
        .iter()
        .map(|form| {
            let place = if form.at_node { &node } else { displacements };
            let components = form.components.iter();
            components
                .map(|&component| graph.substitute(component, place))
                .collect()
        })
        .collect()
}

/// An expression of positions and velocities on a leg, in `X0`, `X1`: its mean over the points of the first order map.
fn on_pair(model: &Model, graph: &mut Graph, value: NodeId) -> NodeId {
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

/// The constraints of lower order on the leg from `N - D` to `N`: `g(q1)`, `c(φ⁻¹(q0, q1))`.
pub(crate) fn pair(model: &Model, graph: &mut Graph) -> Vec<NodeId> {
    let nodes = Nodes::new(graph, model.coordinates.len());
    let (node, leg) = (
        places([(Leaf::Q as LeafOf, &nodes.q1)]),
        places([(Leaf::X0 as LeafOf, &nodes.q0), (Leaf::X1, &nodes.q1)]),
    );
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

/// What the constraints of lower order ask of a position and a velocity: `g(q)` and `c(q, v)`, then `dg/dt`.
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

/// `L_d(x0, x1)`, on the leg from `N - D` to `N`.
pub(crate) fn discrete_lagrangian(model: &Model, graph: &mut Graph) -> NodeId {
    let value = match model.discrete_lagrangian {
        Some(given) => given,
        None => on_pair(model, graph, model.lagrangian),
    };
    let nodes = Nodes::new(graph, model.coordinates.len());
    let leg = places([(Leaf::X0 as LeafOf, &nodes.q0), (Leaf::X1, &nodes.q1)]);
    graph.substitute(value, &leg)
}

/// `-(D₁L_d(q1,q2) + D₂L_d(q0,q1))`.
///
/// With `P₁, P₂` the parts of `D₁L_d, D₂L_d` that come through the velocity of the map and `F₁, F₂` those that come
/// through its position, the sum is `F₁(q1,q2) + F₂(q0,q1) + (P₁+P₂)(q1,q2) - [P₂(q1,q2) - P₂(q0,q1)]`. The bracket is
/// formed as a change (see [`Graph::difference`]), because its two values agree to `O(h)`; `P₁ + P₂` is zero whenever
/// the map's velocity depends on `x1 - x0` alone. Of a discrete Lagrangian that is given itself, all is taken to come through
/// the velocity.
fn discrete_force(model: &Model, graph: &mut Graph, nodes: &Nodes) -> Force {
    let n = model.coordinates.len();
    let parts = match model.discrete_lagrangian {
        Some(given) => Parts::of_discrete(graph, given, n),
        None => Parts::of_map(model, graph),
    };
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
        let rest = graph.substitute_in(parts.rest[i], &second, &mut on_second);
        let f2 = graph.substitute_in(parts.second[i], &first, &mut on_first);
        let late = |leaf: Leaf| matches!(leaf, Leaf::E(_));
        let momentum = graph.difference(parts.momentum[i], &change, &late, &mut changes);
        value.push(graph.linear(0.0, &[(momentum.delta, 1.0), (rest, -1.0), (f2, -1.0)]));
        let (after, before) = (momentum.after, momentum.before);
        plain.push(graph.linear(0.0, &[(after, 1.0), (before, -1.0), (rest, -1.0), (f2, -1.0)]));
    }
    Force { value, plain }
}

/// The parts of `D₁L_d` and `D₂L_d`, component by component, in `X0`, `X1`.
struct Parts {
    /// `F₁ + P₁ + P₂`.
    rest: Vec<NodeId>,
    /// `F₂`.
    second: Vec<NodeId>,
    /// `P₂`.
    momentum: Vec<NodeId>,
}

impl Parts {
    /// Of the mean of the Lagrangian over the points of the first order map.
    fn of_map(model: &Model, graph: &mut Graph) -> Self {
        let n = model.coordinates.len();
        let weight = 1.0 / model.phi_lagrangian.len() as f64;
        let [mut rest, mut second, mut momentum] =
            [const { Vec::new() }; 3].map(|_: Vec<()>| vec![Vec::new(); n]);
        for [q, v] in &model.phi_lagrangian {
            let point = places([(Leaf::Q as LeafOf, q), (Leaf::V, v)]);
            let mut moved = HashMap::new();
            let mut slopes = |leaf: LeafOf| -> Vec<NodeId> {
                (0..n)
                    .map(|i| {
                        let slope = graph.derivative(model.lagrangian, leaf(i));
                        graph.substitute_in(slope, &point, &mut moved)
                    })
                    .collect()
            };
            let (by_position, by_velocity) = (slopes(Leaf::Q), slopes(Leaf::V));
            let mut through = |outer: &[NodeId], inner: &[NodeId], leaf: Leaf| {
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
            for i in 0..n {
                let f1 = through(&by_position, q, Leaf::X0(i));
                let f2 = through(&by_position, q, Leaf::X1(i));
                let p1 = through(&by_velocity, v, Leaf::X0(i));
                let p2 = through(&by_velocity, v, Leaf::X1(i));
                rest[i].extend([(f1, weight), (p1, weight), (p2, weight)]);
                second[i].push((f2, weight));
                momentum[i].push((p2, weight));
            }
        }
        let [rest, second, momentum] = [rest, second, momentum]
            .map(|components| components.iter().map(|terms| graph.linear(0.0, terms)).collect());
        Self {
            rest,
            second,
            momentum,
        }
    }

    /// Of a discrete Lagrangian that is given.
    fn of_discrete(graph: &mut Graph, value: NodeId, n: usize) -> Self {
        let momentum: Vec<_> = (0..n).map(|i| graph.derivative(value, Leaf::X1(i))).collect();
        let rest = (0..n)
            .map(|i| {
                let first = graph.derivative(value, Leaf::X0(i));
                graph.add(first, momentum[i])
            })
            .collect();
        let zero = graph.constant(0.0);
        Self {
            rest,
            second: vec![zero; n],
            momentum,
        }
    }
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
    for row in &model.constraints {
        // differentiated until accelerations come in
        let mut value = row.value;
        for _ in row.order..2 {
            value = graph.total_derivative(value);
        }
        rows.push(Equation {
            value,
            plain: value,
            divide: row.divide,
        });
    }
    let forms: Vec<_> = model.forms.iter().map(|form| form.components.clone()).collect();
    let force = Force {
        plain: force.clone(),
        value: force,
    };
    let fields = match &model.displacements {
        Displacements::Fields(fields) => Some(fields.as_slice()),
        Displacements::Annihilated => None,
    };
    rows.extend(works(graph, fields, &forms, &force));
    let force = force.value;
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
