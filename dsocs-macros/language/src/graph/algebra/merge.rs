//! One representative for all equal expressions.
//!
//! Elimination and division leave `I/h + J/h` in one place and `(I + J)/h` in another. Their difference would be rounding noise. Here every
//! expression is replaced by the shortest one that is equal to it as a rational function (by its [`Graph::fingerprint`]), so that such
//! differences vanish by themselves and nothing is computed twice.

#![allow(clippy::float_cmp)] // coefficients are compared with exact ones and zeros

use crate::graph::{Graph, Memory, Node, NodeId, Pass};
use crate::hash::HashMap;

/// Equal expressions found so far.
#[derive(Default)]
pub(crate) struct Merge {
    shortest: HashMap<[u64; 2], NodeId>,
    memory: Memory,
    sizes: HashMap<NodeId, u32>,
}

impl Pass for Merge {
    const FINAL: bool = true;

    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn after(&mut self, graph: &mut Graph, id: NodeId) -> NodeId {
        self.representative(graph, id)
    }
}

impl Merge {
    /// The shortest known expression that is equal to this one.
    fn representative(&mut self, graph: &mut Graph, id: NodeId) -> NodeId {
        if matches!(graph.node(id), Node::Constant(_)) {
            return id;
        }
        let Some((key, opposite)) = graph.fingerprint(id) else {
            return id;
        };
        if key == [0; 2] {
            return graph.constant(0.0);
        }
        let size = self.size(graph, id);
        if let Some(&known) = self.shortest.get(&key)
            && self.size(graph, known) <= size
        {
            return known;
        }
        if let Some(&known) = self.shortest.get(&opposite)
            && self.size(graph, known) < size
        {
            return graph.neg(known);
        }
        self.shortest.insert(key, id);
        id
    }

    /// The number of leaves, parameters and numbers in the expression written out.
    pub(crate) fn size(&mut self, graph: &Graph, id: NodeId) -> u32 {
        if let Some(&size) = self.sizes.get(&id) {
            return size;
        }
        let mut size = graph
            .parts(id)
            .into_iter()
            .fold(0_u32, |sum, part| sum.saturating_add(self.size(graph, part)));
        size = size.saturating_add(match graph.node(id) {
            Node::Sum(constant, terms) => {
                let scaled = terms.iter().filter(|(_, c)| c.get().abs() != 1.0).count();
                u32::from(constant.get() != 0.0).saturating_add(u32::try_from(scaled).unwrap_or(u32::MAX))
            }
            Node::Product(factors) => factors.iter().fold(0, |sum, &(_, n)| {
                sum.saturating_add(n.unsigned_abs().saturating_sub(1))
            }),
            _ => 1,
        });
        self.sizes.insert(id, size);
        size
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Leaf;

    #[test]
    fn equal_expressions_become_the_shorter_one() {
        let mut graph = Graph::new();
        let (i, j, h) = (
            graph.leaf(Leaf::Q(0)),
            graph.leaf(Leaf::Q(1)),
            graph.leaf(Leaf::H),
        );
        let sum = graph.add(i, j);
        let short = graph.div(sum, h);
        let parts = [graph.div(i, h), graph.div(j, h)];
        let long = graph.sum(&parts);
        let mut merge = Merge::default();
        assert_eq!(graph.rewrite(short, &mut merge), short);
        assert_eq!(graph.rewrite(long, &mut merge), short);
        let difference = graph.linear(0.0, &[(long, 3.0), (short, -3.0)]);
        let merged = graph.rewrite(difference, &mut merge);
        assert!(graph.is_zero(merged));
    }
}
