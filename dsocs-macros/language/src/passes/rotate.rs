//! Sines and cosines of the second point from those of the first.
//!
//! The change of a momentum needs the sine and cosine of half an angle's change (see [`crate::graph`], `difference`), and
//! the momentum itself those of the angle after the change. The latter are those before it, known when the step begins,
//! turned by the change: four products instead of two functions.

use std::collections::{BTreeSet, HashMap};

use crate::graph::{Graph, Leaf, Node, NodeId, Unary};

/// Rewrites expressions in the unknowns.
pub(crate) fn rewrite(graph: &mut Graph, outputs: &mut [&mut NodeId]) {
    let angles = angles(graph, outputs.iter().map(|output| **output));
    let (late, early): (BTreeSet<NodeId>, BTreeSet<NodeId>) = angles
        .iter()
        .copied()
        .partition(|&angle| is_unknown(graph, angle));
    let mut turned = HashMap::new();
    for &after in &late {
        for &half in &late {
            let before = graph.linear(0.0, &[(after, 1.0), (half, -2.0)]);
            if half != after && early.contains(&before) {
                turned.insert(after, [before, half]);
            }
        }
    }
    if turned.is_empty() {
        return;
    }
    let mut done = HashMap::new();
    for output in outputs {
        **output = put(graph, **output, &turned, &mut done);
    }
}

/// The arguments of sines and cosines.
fn angles(graph: &Graph, outputs: impl Iterator<Item = NodeId>) -> BTreeSet<NodeId> {
    let (mut seen, mut angles) = (BTreeSet::new(), BTreeSet::new());
    let mut open: Vec<NodeId> = outputs.collect();
    while let Some(id) = open.pop() {
        if seen.insert(id) {
            if let Node::Unary(Unary::Sin | Unary::Cos, angle) = graph.node(id) {
                angles.insert(*angle);
            }
            open.extend(graph.parts(id));
        }
    }
    angles
}

fn is_unknown(graph: &Graph, id: NodeId) -> bool {
    graph.leaves(id).any(|leaf| matches!(leaf, Leaf::Z(_)))
}

fn put(
    graph: &mut Graph,
    id: NodeId,
    turned: &HashMap<NodeId, [NodeId; 2]>,
    done: &mut HashMap<NodeId, NodeId>,
) -> NodeId {
    if let Some(&done) = done.get(&id) {
        return done;
    }
    let result = match *graph.node(id) {
        Node::Unary(op @ (Unary::Sin | Unary::Cos), angle) if turned.contains_key(&angle) => {
            let [before, half] = turned[&angle];
            let start = graph.unary(op, before);
            let change = graph.turn(op, before, half);
            graph.add(start, change)
        }
        _ => {
            let parts = graph.parts(id);
            let parts: Vec<_> = parts
                .into_iter()
                .map(|part| put(graph, part, turned, done))
                .collect();
            graph.rebuild(id, &parts)
        }
    };
    done.insert(id, result);
    result
}
