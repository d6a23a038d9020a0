//! The values of expressions, in numbers.

use std::collections::BTreeSet;

use crate::hash::HashMap;

use super::{Comparison, Graph, Leaf, Node, NodeId};

impl Graph {
    /// The values of some expressions, at values of the leaves and of the parameters; `None` where a function of the user's comes in,
    /// which cannot be seen into.
    pub(crate) fn values(
        &self,
        nodes: &[NodeId],
        leaf: &dyn Fn(Leaf) -> f64,
        param: &dyn Fn(usize) -> f64,
    ) -> Option<Vec<f64>> {
        let mut needed = BTreeSet::new();
        let mut left = nodes.to_vec();
        while let Some(node) = left.pop() {
            if needed.insert(node) {
                left.extend(self.parts(node));
            }
        }
        let mut values: HashMap<NodeId, f64> = HashMap::default();
        // an expression is made after its parts, so in the order of their numbers
        for node in needed {
            let of = |id: &NodeId| values.get(id).copied().unwrap_or(f64::NAN);
            let value = match self.node(node) {
                Node::Constant(bits) => bits.get(),
                Node::Leaf(which) => leaf(*which),
                Node::Param(which) => param(*which),
                Node::Sum(constant, terms) => {
                    let terms = terms.iter().map(|(term, c)| c.get() * of(term));
                    constant.get() + terms.sum::<f64>()
                }
                Node::Product(factors) => factors.iter().map(|(factor, n)| of(factor).powi(*n)).product(),
                Node::Unary(op, a) => op.apply(of(a)),
                Node::Powf(a, b) => of(a).powf(of(b)),
                Node::Atan2(y, x) => of(y).atan2(of(x)),
                Node::Select(op, [left, right, then, otherwise]) => {
                    let holds = match op {
                        Comparison::Lt => of(left) < of(right),
                        Comparison::Le => of(left) <= of(right),
                    };
                    of(if holds { then } else { otherwise })
                }
                Node::Call { .. } => return None,
            };
            values.insert(node, value);
        }
        Some(
            nodes
                .iter()
                .map(|node| values.get(node).copied().unwrap_or(f64::NAN))
                .collect(),
        )
    }
}
