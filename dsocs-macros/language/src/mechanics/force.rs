//! The discrete Lagrangian, and the force that its discrete Euler-Lagrange equations leave at a node (paper, section 3).

use std::collections::HashMap;

use super::nodes::{LeafOf, Nodes, on_pair, places};
use super::works::Force;
use crate::graph::{Change, Graph, Leaf, NodeId, Substitution};
use crate::model::Model;

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
pub(super) fn discrete_force(model: &Model, graph: &mut Graph, nodes: &Nodes) -> Force {
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
    let (mut on_first, mut on_second) = (Substitution::new(&first), Substitution::new(&second));
    let (mut value, mut plain) = (Vec::new(), Vec::new());
    for i in 0..n {
        let rest = graph.rewrite(parts.rest[i], &mut on_second);
        let f2 = graph.rewrite(parts.second[i], &mut on_first);
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
            let mut moved = Substitution::new(&point);
            let mut slopes = |leaf: LeafOf| -> Vec<NodeId> {
                (0..n)
                    .map(|i| {
                        let slope = graph.derivative(model.lagrangian, leaf(i));
                        graph.rewrite(slope, &mut moved)
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
