//! The one walk by which expressions are rewritten: from the parts up, each node once.
//!
//! A [`Pass`] says what becomes of a node; [`Graph::rewrite`] takes it through an expression. Putting expressions in the
//! place of leaves is the simplest pass ([`Graph::substitute`]); those that make code faster are in [`crate::passes`].

use super::{Graph, Leaf, Node, NodeId, for_parts};

use crate::hash::HashMap;

/// What has become of nodes so far.
pub(crate) type Memory = HashMap<NodeId, NodeId>;

/// What becomes of a node.
pub(crate) trait Pass {
    /// Whether what the pass gives stays as it is when it comes again.
    const FINAL: bool = false;

    /// What has become of nodes so far: a pass sees each of them once, also over several expressions.
    fn memory(&mut self) -> &mut Memory;

    /// What takes a node's place, decided before its parts are looked at; `None` where they are to be rewritten.
    ///
    /// Parts that are wanted all the same are rewritten with [`Graph::rewrite`].
    fn before(&mut self, _: &mut Graph, _: NodeId) -> Option<NodeId> {
        None
    }

    /// What takes a node's place whose parts have been rewritten.
    fn after(&mut self, _: &mut Graph, id: NodeId) -> NodeId {
        id
    }
}

impl Graph {
    /// Takes a pass through an expression.
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

    /// As [`Graph::rewrite`], for several expressions in their places.
    pub(crate) fn rewrite_all<'n>(
        &mut self,
        nodes: impl IntoIterator<Item = &'n mut NodeId>,
        pass: &mut impl Pass,
    ) {
        for node in nodes {
            *node = self.rewrite(*node, pass);
        }
    }

    /// The same operation on what becomes of its parts.
    pub(crate) fn rewrite_parts(&mut self, id: NodeId, pass: &mut impl Pass) -> NodeId {
        let node = self.keep(id);
        let (mut parts, mut same) = (Vec::new(), true);
        for_parts(&node, |part| {
            let rewritten = self.rewrite(part, pass);
            same &= rewritten == part;
            parts.push(rewritten);
        });
        if same && self.is_settled(id) {
            return id;
        }
        self.rebuild(id, &parts)
    }

    /// Whether a node becomes itself when it is made again of its parts: it is in normal form, unless its numbers have left the range of doubles,
    /// since what is no number is not equal to itself.
    fn is_settled(&self, id: NodeId) -> bool {
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

    /// The same operation on other parts (in the order of [`Graph::parts`]).
    pub(super) fn rebuild(&mut self, id: NodeId, parts: &[NodeId]) -> NodeId {
        match &*self.keep(id) {
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

    /// Puts expressions in the place of leaves.
    pub(crate) fn substitute(&mut self, id: NodeId, places: &HashMap<Leaf, NodeId>) -> NodeId {
        self.rewrite(id, &mut Substitution::new(places))
    }
}

/// Expressions in the place of leaves.
pub(crate) struct Substitution<'p> {
    places: &'p HashMap<Leaf, NodeId>,
    memory: Memory,
}

impl<'p> Substitution<'p> {
    /// What stands in the place of which leaf; the others stay.
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
