//! Numeric evaluation of expressions.

use super::{Graph, Leaf, Node, NodeId};

impl Graph {
    /// The values of some expressions, given those of the leaves and the parameters; `None` where one calls a
    /// user's function, which the graph cannot evaluate.
    pub(crate) fn values(
        &self,
        nodes: &[NodeId],
        leaf: &dyn Fn(Leaf) -> f64,
        param: &dyn Fn(usize) -> f64,
    ) -> Option<Vec<f64>> {
        let count = nodes.iter().map(|node| node.index() + 1).max().unwrap_or(0);
        let mut needed = vec![false; count];
        for node in nodes {
            needed[node.index()] = true;
        }
        // the parts of a node have smaller numbers than the node
        for place in (0..count).rev() {
            if needed[place] {
                for part in self.nodes[place].parts() {
                    needed[part.index()] = true;
                }
            }
        }
        let mut values = vec![f64::NAN; count];
        for place in (0..count).filter(|&place| needed[place]) {
            let of = |id: &NodeId| values[id.index()];
            let value = match &*self.nodes[place] {
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
                    let holds = op.holds(of(left), of(right));
                    of(if holds { then } else { otherwise })
                }
                Node::Call { .. } => return None,
            };
            values[place] = value;
        }
        Some(nodes.iter().map(|node| values[node.index()]).collect())
    }
}
