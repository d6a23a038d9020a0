//! Sines and cosines at the second point from those at the first, by the addition theorem.
//!
//! The change of a momentum needs the sine and cosine of half an angle's change (see [`crate::graph`],
//! `difference`), and the momentum itself those of the angle after the change. The latter follow from those
//! before it, known when the step begins, and from the half angle's: four products instead of two functions.

use std::collections::BTreeSet;

use crate::graph::{Graph, Leaf, Memory, Node, NodeId, Pass, Unary};
use crate::hash::HashMap;

/// Runs the pass over expressions in the unknowns.
pub(crate) fn rewrite(graph: &mut Graph, outputs: &mut [&mut NodeId]) {
    let angles = angles(graph, outputs.iter().map(|output| **output));
    let (late, early): (BTreeSet<NodeId>, BTreeSet<NodeId>) = angles
        .iter()
        .copied()
        .partition(|&angle| is_unknown(graph, angle));
    let mut changes = HashMap::default();
    for &after in &late {
        for &half in &late {
            let before = graph.linear(0.0, &[(after, 1.0), (half, -2.0)]);
            if half != after && early.contains(&before) {
                changes.insert(after, [before, half]);
            }
        }
    }
    if changes.is_empty() {
        return;
    }
    let mut pass = AdditionTheorem {
        changes,
        memory: Memory::default(),
    };
    graph.rewrite_all(outputs.iter_mut().map(|output| &mut **output), &mut pass);
}

/// The arguments of all sines and cosines in some expressions.
fn angles(graph: &Graph, outputs: impl Iterator<Item = NodeId>) -> BTreeSet<NodeId> {
    let all = graph.subexpressions(outputs, |_| true).into_iter();
    all.filter_map(|id| match graph.node(id) {
        Node::Unary(Unary::Sin | Unary::Cos, angle) => Some(*angle),
        _ => None,
    })
    .collect()
}

fn is_unknown(graph: &Graph, id: NodeId) -> bool {
    graph.leaves(id).any(|leaf| matches!(leaf, Leaf::Z(_)))
}

/// For each angle after a change, the angle before and half of the change.
struct AdditionTheorem {
    changes: HashMap<NodeId, [NodeId; 2]>,
    memory: Memory,
}

impl Pass for AdditionTheorem {
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn before(&mut self, graph: &mut Graph, id: NodeId) -> Option<NodeId> {
        let Node::Unary(op @ (Unary::Sin | Unary::Cos), angle) = *graph.node(id) else {
            return None;
        };
        let &[before, half] = self.changes.get(&angle)?;
        let start = graph.unary(op, before);
        let change = graph.sine_change(op, before, half);
        Some(graph.add(start, change))
    }
}
