//! The one walk by which expressions are rewritten: from the operands up, each node once.
//!
//! A [`Pass`] rewrites a node; [`Graph::rewrite`] takes it through an expression. The simplest pass
//! substitutes expressions for leaves ([`Graph::substitute`]); those that make code faster are in
//! [`crate::passes`].

use super::{Graph, Leaf, Node, NodeId};

use crate::hash::HashMap;

/// The nodes rewritten so far, and their results.
pub(crate) type Memory = HashMap<NodeId, NodeId>;

/// A rewriting of nodes.
pub(crate) trait Pass {
    /// Whether the pass leaves its own results unchanged.
    const FINAL: bool = false;

    /// The nodes rewritten so far: each is rewritten once, also across several expressions.
    fn memory(&mut self) -> &mut Memory;

    /// The replacement of a node, decided before its operands are rewritten; `None` to rewrite them first.
    ///
    /// An implementation can rewrite an operand that it needs with [`Graph::rewrite`].
    fn before(&mut self, _: &mut Graph, _: NodeId) -> Option<NodeId> {
        None
    }

    /// The replacement of a node whose operands have been rewritten.
    fn after(&mut self, _: &mut Graph, id: NodeId) -> NodeId {
        id
    }
}

impl Graph {
    /// An expression rewritten by a pass.
    pub(crate) fn rewrite<P: Pass>(&mut self, id: NodeId, pass: &mut P) -> NodeId {
        if let Some(&done) = pass.memory().get(&id) {
            return done;
        }
        let result = if let Some(result) = pass.before(self, id) {
            result
        } else {
            let rebuilt = self.rewrite_parts(id, pass);
            pass.after(self, rebuilt)
        };
        let memory = pass.memory();
        memory.insert(id, result);
        if P::FINAL {
            memory.insert(result, result);
        }
        result
    }

    /// Rewrites several expressions in place.
    pub(crate) fn rewrite_all<'n>(
        &mut self,
        nodes: impl IntoIterator<Item = &'n mut NodeId>,
        pass: &mut impl Pass,
    ) {
        for node in nodes {
            *node = self.rewrite(*node, pass);
        }
    }

    /// A node of the same operation, with its operands rewritten.
    pub(crate) fn rewrite_parts(&mut self, id: NodeId, pass: &mut impl Pass) -> NodeId {
        let before = self.parts(id);
        let parts: Vec<NodeId> = before.iter().map(|&part| self.rewrite(part, pass)).collect();
        if parts == before && self.rebuilds_to_itself(id) {
            return id;
        }
        self.rebuild(id, &parts)
    }

    /// Whether a node that is made again of its operands is itself. It is, being in normal form, unless one
    /// of its numbers is NaN, which is not equal to itself.
    fn rebuilds_to_itself(&self, id: NodeId) -> bool {
        let is_number = |id: NodeId| match self.node(id) {
            Node::Sum(constant, terms) => {
                !constant.get().is_nan() && terms.iter().all(|(_, c)| !c.get().is_nan())
            }
            _ => true,
        };
        match self.node(id) {
            Node::Product(factors) => factors.iter().all(|&(factor, _)| is_number(factor)),
            _ => is_number(id),
        }
    }

    /// A node of the same operation with other operands, in the order of [`Graph::parts`].
    pub(super) fn rebuild(&mut self, id: NodeId, parts: &[NodeId]) -> NodeId {
        match &*self.shared_node(id) {
            Node::Constant(_) | Node::Leaf(_) | Node::Param(_) => id,
            Node::Sum(constant, terms) => {
                let terms: Vec<_> = parts
                    .iter()
                    .zip(terms)
                    .map(|(&part, term)| (part, term.1.get()))
                    .collect();
                self.linear(constant.get(), &terms)
            }
            Node::Product(factors) => {
                let factors: Vec<_> = parts.iter().zip(factors).map(|(&part, f)| (part, f.1)).collect();
                self.product(&factors)
            }
            Node::Unary(op, _) => self.unary(*op, parts[0]),
            Node::Powf(..) => self.powf(parts[0], parts[1]),
            Node::Atan2(..) => self.atan2(parts[0], parts[1]),
            Node::Select(op, _) => self.select(*op, parts[0], parts[1], parts[2], parts[3]),
            Node::Call { callee, wrt, .. } => self.call_partial(*callee, parts.to_vec(), wrt.clone()),
        }
    }

    /// Substitutes expressions for leaves.
    pub(crate) fn substitute(&mut self, id: NodeId, places: &HashMap<Leaf, NodeId>) -> NodeId {
        self.rewrite(id, &mut Substitution::new(places))
    }
}

/// The substitution of expressions for leaves.
pub(crate) struct Substitution<'p> {
    places: &'p HashMap<Leaf, NodeId>,
    memory: Memory,
}

impl<'p> Substitution<'p> {
    /// The expression for each leaf that is replaced; other leaves stay.
    pub(crate) fn new(places: &'p HashMap<Leaf, NodeId>) -> Self {
        Self {
            places,
            memory: Memory::default(),
        }
    }
}

impl Pass for Substitution<'_> {
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn before(&mut self, graph: &mut Graph, id: NodeId) -> Option<NodeId> {
        match graph.node(id) {
            Node::Leaf(leaf) => Some(self.places.get(leaf).copied().unwrap_or(id)),
            _ => None,
        }
    }
}
