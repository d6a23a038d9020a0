//! Constants multiplied into sums.
//!
//! `l (a x + b y)` costs one product more than `(l a) x + (l b) y`, whose constants are known when the run begins. And equations in which
//! every term has a single constant share products: the coefficients of a mass matrix, say, are symmetric. So a sum that is used once, as a
//! factor beside constants, is multiplied out.

use crate::graph::{Graph, Leaf, Memory, Node, NodeId, Pass};
use crate::hash::{HashMap, HashSet};

/// Runs the pass over the expressions of a system.
pub(crate) fn rewrite(graph: &mut Graph, outputs: &mut [&mut NodeId]) {
    let mut distribute = Distribute {
        uses: uses(graph, outputs),
        memory: Memory::default(),
    };
    graph.rewrite_all(outputs.iter_mut().map(|output| &mut **output), &mut distribute);
}

/// The number of uses of each expression.
fn uses(graph: &Graph, outputs: &[&mut NodeId]) -> HashMap<NodeId, u32> {
    let (mut uses, mut seen) = (HashMap::default(), HashSet::default());
    let mut open: Vec<NodeId> = outputs.iter().map(|output| **output).collect();
    for &output in &open {
        *uses.entry(output).or_default() += 1;
    }
    while let Some(id) = open.pop() {
        if seen.insert(id) {
            for part in graph.parts(id) {
                *uses.entry(part).or_default() += 1;
                open.push(part);
            }
        }
    }
    uses
}

/// The pass that multiplies constants into sums used once.
struct Distribute {
    uses: HashMap<NodeId, u32>,
    memory: Memory,
}

impl Pass for Distribute {
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn before(&mut self, graph: &mut Graph, id: NodeId) -> Option<NodeId> {
        let Node::Sum(constant, terms) = graph.node(id).clone() else {
            return None;
        };
        let mut constant = constant.get();
        let mut flat = Vec::new();
        for (term, c) in terms {
            match self.factored_sum(graph, term) {
                Some((factor, sum)) => {
                    let sum = graph.rewrite(sum, self);
                    let (inner, rest) = graph.terms(sum);
                    for (inner, d) in inner {
                        flat.push((graph.mul(factor, inner), c.get() * d));
                    }
                    if let Some(factor) = graph.as_constant(factor) {
                        constant += c.get() * rest * factor;
                    } else {
                        flat.push((factor, c.get() * rest));
                    }
                }
                None => flat.push((graph.rewrite(term, self), c.get())),
            }
        }
        Some(graph.linear(constant, &flat))
    }
}

impl Distribute {
    /// The constants and the sum of a product, if neither the product nor the sum is used elsewhere.
    fn factored_sum(&self, graph: &mut Graph, term: NodeId) -> Option<(NodeId, NodeId)> {
        let once = |id| self.uses.get(&id) == Some(&1);
        let late = |graph: &Graph, id| graph.leaves(id).any(|leaf| leaf != Leaf::H);
        let Node::Product(factors) = graph.node(term) else {
            return None;
        };
        let (sums, constants): (Vec<_>, Vec<_>) = factors
            .iter()
            .copied()
            .partition(|&(factor, _)| late(graph, factor));
        let [(sum, 1)] = sums[..] else {
            return None;
        };
        let is_sum = matches!(graph.node(sum), Node::Sum(..));
        (is_sum && once(term) && once(sum)).then(|| (graph.product(&constants), sum))
    }
}
