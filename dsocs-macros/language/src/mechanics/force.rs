//! The discrete Lagrangian, and the constraint force from the discrete Euler-Lagrange equations (paper,
//! section 3).

use super::nodes::{LeafOf, Nodes, at_pair, mean, on_pair};
use super::works::Force;
use crate::graph::algebra::gathered_slopes;
use crate::graph::calculus::rotation::SLOTS;
use crate::graph::{Change, Graph, Leaf, NodeId, Substitution};
use crate::hash::HashMap;
use crate::model::{Model, PairPoint};

/// `L_d(x0, x1)`, on the leg from `N - D` to `N`.
pub(crate) fn discrete_lagrangian(model: &Model, graph: &mut Graph) -> NodeId {
    let value = match model.discrete_lagrangian {
        Some(given) => given,
        None => on_pair(model, graph, model.lagrangian),
    };
    let nodes = Nodes::new(graph, model.coordinates.len());
    graph.substitute(value, &nodes.first_leg())
}

/// Expressions in `X0`, `X1`, `T0` and `T1`, on the leg from `N - D` to `N`.
pub(crate) fn on_first_leg(model: &Model, graph: &mut Graph, values: &[NodeId]) -> Vec<NodeId> {
    let leg = Nodes::new(graph, model.coordinates.len()).first_leg();
    let mut moved = Substitution::new(&leg);
    values
        .iter()
        .map(|&value| graph.rewrite(value, &mut moved))
        .collect()
}

/// The constraint force `-(D₁L_d(q1,q2) + D₂L_d(q0,q1) + f⁻_d(q1,q2) + f⁺_d(q0,q1))`, with the external
/// forces of [`external_on_leg`].
///
/// With `P₁, P₂` the parts of `D₁L_d, D₂L_d` that come through the velocity of the map and `F₁, F₂` those
/// that come through its position, the sum is
/// `F₁(q1,q2) + F₂(q0,q1) + (P₁+P₂)(q1,q2) - [P₂(q1,q2) - P₂(q0,q1)]`. The bracket is formed as a change (see
/// [`Graph::difference`]), because its two values agree to `O(h)`. `P₁ + P₂` is zero whenever the map's
/// velocity depends on `x1 - x0` alone. A declared discrete Lagrangian counts as if it depended on the nodes
/// through the velocity alone.
pub(super) fn discrete_force(model: &Model, graph: &mut Graph, nodes: &Nodes) -> Force {
    let n = model.coordinates.len();
    let parts = match model.discrete_lagrangian {
        Some(given) => Parts::of_discrete(graph, given, n),
        None => Parts::of_map(model, graph),
    };
    let (first, second) = (nodes.first_leg(), nodes.second_leg());
    let mut change = HashMap::from_iter(nodes.change_of_time(graph));
    for i in 0..n {
        change.insert(
            Leaf::X0(i),
            Change {
                before: nodes.q0[i],
                after: nodes.q1[i],
                delta: nodes.changes[0][i],
            },
        );
        change.insert(
            Leaf::X1(i),
            Change {
                before: nodes.q1[i],
                after: nodes.q2[i],
                delta: nodes.changes[1][i],
            },
        );
        if graph.rotation_at(i).is_some() {
            change.insert(
                Leaf::Chord(i),
                Change {
                    before: nodes.d0[i],
                    after: nodes.d1[i],
                    delta: nodes.e[i],
                },
            );
        }
    }
    let external = external_on_leg(model, graph);
    let zero = graph.constant(0.0);
    let mut changes = HashMap::default();
    let (mut on_first, mut on_second) = (Substitution::new(&first), Substitution::new(&second));
    let (mut value, mut by_subtraction) = (Vec::new(), Vec::new());
    for i in 0..n {
        let rest = graph.rewrite(parts.rest[i], &mut on_second);
        let f2 = graph.rewrite(parts.second[i], &mut on_first);
        let external = external.as_ref().map_or(zero, |[minus, plus]| {
            let (minus, plus) = (
                graph.rewrite(minus[i], &mut on_second),
                graph.rewrite(plus[i], &mut on_first),
            );
            graph.add(minus, plus)
        });
        let late = |leaf: Leaf| matches!(leaf, Leaf::E(_));
        let momentum = graph.difference(parts.momentum[i], &change, &late, parts.gathered, &mut changes);
        let others = [(rest, -1.0), (f2, -1.0), (external, -1.0)];
        value.push(graph.linear(0.0, &[&[(momentum.delta, 1.0)], others.as_slice()].concat()));
        let momenta = [(momentum.after, 1.0), (momentum.before, -1.0)];
        by_subtraction.push(graph.linear(0.0, &[momenta.as_slice(), &others].concat()));
    }
    Force {
        value,
        by_subtraction,
    }
}

/// The momentum `D₂L_d + f⁺_d` at the second node of a leg, component by component, on the leg from `N - D`
/// to `N`.
///
/// For the paper's map it is that of the trapezoid, which gives the same equations as long as no parameter
/// changes from leg to leg. Where one does, half of its change counts on each side of the node, as the order
/// 2 needs.
pub(crate) fn momentum_at_second_node(model: &Model, graph: &mut Graph) -> Vec<NodeId> {
    let value = model.discrete_lagrangian.unwrap_or_else(|| {
        let points = quadrature_points(model, graph);
        mean(graph, model.lagrangian, &points)
    });
    let external = external_on_leg(model, graph);
    let components: Vec<_> = (0..model.coordinates.len())
        .map(|i| {
            let momentum = graph.derivative(value, Leaf::X1(i));
            external
                .as_ref()
                .map_or(momentum, |[_, plus]| graph.add(momentum, plus[i]))
        })
        .collect();
    on_first_leg(model, graph, &components)
}

/// The external forces on a leg, `[f⁻_d, f⁺_d]`: those on its first and on its second node, in `X0`, `X1`,
/// `T0` and `T1`. `None` without external forces.
///
/// A force does the work `⟨f, δq⟩` at the points of `φ_{L_d}⁻¹`, where `δq` is `∂q/∂x0 δx0 + ∂q/∂x1 δx1`. The
/// midpoint gives one half to each node; the trapezoid gives each node half of the force there. So the order
/// of the step is that of the map. The paper's point would give all of it to the first node, which is of
/// order 1 if the force depends on velocity or time. So with the paper's map the forces are those of the
/// trapezoid.
pub(crate) fn external_on_leg(model: &Model, graph: &mut Graph) -> Option<[Vec<NodeId>; 2]> {
    let n = model.coordinates.len();
    if model.external_forces.is_empty() {
        return None;
    }
    let points = quadrature_points(model, graph);
    let weight = 1.0 / points.len() as f64;
    let mut sums = [vec![Vec::new(); n], vec![Vec::new(); n]];
    for point in &points {
        let places = at_pair(point);
        let mut moved = Substitution::new(&places);
        let force: Vec<_> = model
            .external_forces
            .iter()
            .map(|&component| graph.rewrite(component, &mut moved))
            .collect();
        for (sums, leaf) in sums.iter_mut().zip([Leaf::X0 as LeafOf, Leaf::X1]) {
            for (i, terms) in sums.iter_mut().enumerate() {
                for (k, (&component, &q)) in force.iter().zip(&point.q).enumerate() {
                    let slope = position_slope(graph, (q, k), leaf, i);
                    terms.push((graph.mul(component, slope), weight));
                }
            }
        }
    }
    Some(sums.map(|components| components.iter().map(|terms| graph.linear(0.0, terms)).collect()))
}

/// The derivative of the component `k` of a point's position by the slot `i` of a node. Those of a rotation
/// that is a node are in the frame of the body.
fn position_slope(graph: &mut Graph, (q, k): (NodeId, usize), leaf: LeafOf, i: usize) -> NodeId {
    let Some(first) = graph.rotation_at(k) else {
        return graph.derivative(q, leaf(i));
    };
    if graph.rotation_at(i) == Some(first) && q == graph.middle(first)[k - first] {
        let sign = if leaf(i) == Leaf::X1(i) { 1.0 } else { -1.0 };
        return graph.slope_of_middle(first, [k - first, i - first], sign);
    }
    let moves = i == k && q == graph.leaf(leaf(k));
    graph.constant(if moves { 1.0 } else { 0.0 })
}

/// The points of `φ_{L_d}⁻¹`; for the paper's map both ends of the leg.
pub(super) fn quadrature_points(model: &Model, graph: &mut Graph) -> Vec<PairPoint> {
    match model.phi_lagrangian.as_slice() {
        [only] if is_first_node(graph, only) => ends(graph, only),
        points => points.to_vec(),
    }
}

/// Whether a point of `φ_{L_d}⁻¹` is the paper's: the first node, at its time.
fn is_first_node(graph: &mut Graph, point: &PairPoint) -> bool {
    point.t == graph.leaf(Leaf::T0)
        && (point.q.iter().enumerate()).all(|(i, &q)| q == graph.leaf(Leaf::X0(i)))
}

/// Both ends of a leg, with the velocity of a given point.
fn ends(graph: &mut Graph, point: &PairPoint) -> Vec<PairPoint> {
    let mut end = |t: Leaf, x: LeafOf| PairPoint {
        t: graph.leaf(t),
        q: (0..point.q.len()).map(|i| graph.leaf(x(i))).collect(),
        v: point.v.clone(),
    };
    vec![end(Leaf::T0, Leaf::X0), end(Leaf::T1, Leaf::X1)]
}

/// The parts of `D₁L_d` and `D₂L_d` (see [`discrete_force`]), component by component, in `X0`, `X1`.
struct Parts {
    /// `F₁ + P₁ + P₂`.
    rest: Vec<NodeId>,
    /// `F₂`.
    second: Vec<NodeId>,
    /// `P₂`.
    momentum: Vec<NodeId>,
    /// Whether products of functions of two coordinates are gathered (see [`gathered_slopes`]).
    gathered: bool,
}

impl Parts {
    /// The parts for the mean of the Lagrangian over the points of `φ_{L_d}⁻¹`.
    fn of_map(model: &Model, graph: &mut Graph) -> Self {
        let n = model.coordinates.len();
        let weight = 1.0 / model.phi_lagrangian.len() as f64;
        let [mut rest, mut second, mut momentum] =
            [const { Vec::new() }; 3].map(|_: Vec<()>| vec![Vec::new(); n]);
        let mut gathered = false;
        // the velocity of a rotation that is its increment over `h` is treated apart: the terms of `T(x)ᵀp`
        // share much
        let rotations = graph.rotations().to_vec();
        let turns: Vec<usize> = rotations
            .iter()
            .flat_map(|first| first + 1..first + SLOTS)
            .collect();
        for point in &model.phi_lagrangian {
            let (q, v) = (&point.q, &point.v);
            let point = at_pair(point);
            let mut moved = Substitution::new(&point);
            let leaves = (0..n).map(Leaf::Q).chain((0..n).map(Leaf::V));
            let mut slopes: Vec<_> = leaves
                .map(|leaf| graph.derivative(model.lagrangian, leaf))
                .collect();
            if let Some(short) = gathered_slopes(graph, &slopes) {
                slopes = short;
                gathered = true;
            }
            graph.rewrite_all(&mut slopes, &mut moved);
            let (by_position, by_velocity) = slopes.split_at(n);
            let mut through =
                |outer: &[NodeId], inner: &[NodeId], leaf: LeafOf, i: usize, is_position: bool| {
                    let mut terms = Vec::new();
                    for (k, (&outer, &inner)) in outer.iter().zip(inner).enumerate() {
                        // most components of a map depend on other coordinates
                        if graph.varies_with(inner, leaf(i)) {
                            let slope = if is_position {
                                position_slope(graph, (inner, k), leaf, i)
                            } else {
                                graph.derivative(inner, leaf(i))
                            };
                            terms.push(graph.mul(outer, slope));
                        }
                    }
                    graph.sum(&terms)
                };
            for i in 0..n {
                let f1 = through(by_position, q, Leaf::X0, i, true);
                let f2 = through(by_position, q, Leaf::X1, i, true);
                rest[i].push((f1, weight));
                second[i].push((f2, weight));
                if turns.contains(&i) {
                    continue;
                }
                let p1 = through(by_velocity, v, Leaf::X0, i, false);
                let p2 = through(by_velocity, v, Leaf::X1, i, false);
                rest[i].extend([(p1, weight), (p2, weight)]);
                momentum[i].push((p2, weight));
            }
            for &first in &rotations {
                let h = graph.leaf(Leaf::H);
                let of_body = [1, 2, 3].map(|k| graph.div(by_velocity[first + k], h));
                let [both, second] = graph.momenta_of_increment(first, of_body);
                for k in 1..SLOTS {
                    rest[first + k].push((both[k - 1], weight));
                    momentum[first + k].push((second[k - 1], weight));
                }
            }
        }
        let [rest, second, momentum] = [rest, second, momentum]
            .map(|components| components.iter().map(|terms| graph.linear(0.0, terms)).collect());
        Self {
            rest,
            second,
            momentum,
            gathered,
        }
    }

    /// The parts for a declared discrete Lagrangian.
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
            gathered: false,
        }
    }
}
