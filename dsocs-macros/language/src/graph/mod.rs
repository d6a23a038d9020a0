//! The expression graph: all expressions of a declaration, with common subexpressions shared.
//!
//! A node is made by the builder methods of [`Graph`], which keep it in a normal form (sums with collected
//! coefficients, products with collected exponents, constants folded) and share equal nodes. There are few
//! kinds of nodes on purpose, because every walk over the graph has to know each of them:
//!
//! - [`rewrite`](Graph::rewrite): the walk of every pass that makes one expression from another
//!   ([`mod@rewrite`]);
//! - [`calculus::derivative`](Graph::derivative): forward differentiation ([`mod@calculus::derivative`]);
//! - [`mod@unary`]: the functions of one argument;
//! - [`mod@calculus::rotation`]: coordinates that are rotations, and their derivatives;
//! - [`calculus::difference`](Graph::difference): the change of an expression between two points, without cancellation
//!   ([`mod@calculus::difference`]);
//! - [`values`](Graph::values): numeric evaluation ([`mod@evaluate`]);
//! - [`vanishes`](Graph::vanishes): arithmetic modulo a prime, to tell whether an expression is zero
//!   ([`mod@zeros::identity`]) or cannot be ([`mod@zeros::nonzero`]);
//! - [`power_of_step`](Graph::power_of_step): the order in the step `h` with which an expression vanishes
//!   ([`mod@zeros::power`]);
//! - [`algebra`]: rewritings that make expressions shorter;
//! - code, through [`crate::program`].

pub(crate) mod algebra;
mod build;
pub(crate) mod calculus;
mod evaluate;
mod node;
mod pieces;
mod rewrite;
mod sets;
mod signs;
mod unary;
mod zeros;

use std::collections::BTreeMap;
use std::hash::BuildHasher;
use std::rc::Rc;

use proc_macro2::TokenStream;

use crate::hash::{FxBuildHasher, HashMap, HashSet};
use crate::mistakes::limits;

use sets::{Set, Sets};

pub(crate) use build::collect;
pub(crate) use calculus::difference::Change;
pub(crate) use node::{Bits, Callee, Comparison, Leaf, Node, NodeId};
pub(crate) use rewrite::{Memory, Pass, Substitution};
pub(crate) use unary::Unary;
pub(crate) use zeros::nonzero::Slopes;

/// A parameter as it is read from the struct.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Param<'g> {
    /// A number that can be listed and set, by its place among the numbers.
    Number(usize),
    /// Any other expression in terms of `self`.
    Expression(&'g TokenStream),
}

/// The text of some tokens without white space, so that it does not depend on how they were put together.
fn without_spaces(tokens: &TokenStream) -> String {
    tokens.to_string().replace(char::is_whitespace, "")
}

/// All expressions of one declaration.
#[derive(Clone, Default, Debug)]
pub(crate) struct Graph {
    nodes: Vec<Rc<Node>>,
    sets: Sets,
    /// For every node, the leaves that it depends on.
    dependence: Vec<Set>,
    /// For every node, the leaves whose change can make it jump.
    jumps: Vec<Set>,
    /// For every node, its depth: the longest chain of operations below it.
    depths: Vec<u32>,
    /// The last node of each hash.
    last_of_hash: HashMap<u64, NodeId>,
    /// For every node, the previous one with the same hash.
    previous_of_hash: Vec<Option<NodeId>>,
    leaves: Vec<Leaf>,
    leaf_bits: HashMap<Leaf, usize>,
    params: Vec<TokenStream>,
    param_texts: BTreeMap<String, usize>,
    /// The parameters that are numbers, as the struct's fields are read, without spaces.
    numbers: Vec<String>,
    callees: Vec<Callee>,
    callee_texts: BTreeMap<String, usize>,
    derivatives: HashMap<calculus::derivative::Direction, HashMap<NodeId, NodeId>>,
    /// The first slots of the coordinates that are rotations (see [`mod@calculus::rotation`]).
    rotations: Vec<usize>,
    /// The results of [`Graph::split`] for sums.
    splits: HashMap<NodeId, (f64, NodeId)>,
    /// The results of [`Graph::power_of_step`].
    powers: HashMap<NodeId, i32>,
    residues: zeros::identity::PointResidues,
}

impl Graph {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    pub(crate) fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()]
    }

    /// A node that may be read while others are made.
    pub(crate) fn shared_node(&self, id: NodeId) -> Rc<Node> {
        Rc::clone(&self.nodes[id.index()])
    }

    /// The tokens of a [`Node::Param`].
    pub(crate) fn param_tokens(&self, param: usize) -> &TokenStream {
        &self.params[param]
    }

    /// A [`Node::Param`] as a number or an expression.
    pub(crate) fn read_param(&self, param: usize) -> Param<'_> {
        let tokens = self.param_tokens(param);
        let text = without_spaces(tokens);
        match self.numbers.iter().position(|number| *number == text) {
            Some(place) => Param::Number(place),
            None => Param::Expression(tokens),
        }
    }

    /// The parameters that an expression reads.
    pub(crate) fn params_of(&self, id: NodeId) -> Vec<Param<'_>> {
        let mut params = Vec::new();
        for id in self.subexpressions([id], |_| true) {
            match self.node(id) {
                Node::Param(param) => params.push(self.read_param(*param)),
                Node::Call { callee, .. } => {
                    if let Callee::Function(tokens) = self.callee(*callee) {
                        params.push(Param::Expression(tokens));
                    }
                }
                _ => {}
            }
        }
        params
    }

    /// Sets which parameters are numbers: the expressions by which they are read, in order.
    pub(crate) fn set_numbers(&mut self, places: impl Iterator<Item = TokenStream>) {
        self.numbers = places.map(|place| without_spaces(&place)).collect();
    }

    /// The callee of a [`Node::Call`].
    pub(crate) fn callee(&self, callee: usize) -> &Callee {
        &self.callees[callee]
    }

    /// The value of a node that is a constant.
    pub(crate) fn as_constant(&self, id: NodeId) -> Option<f64> {
        match self.node(id) {
            Node::Constant(value) => Some(value.get()),
            _ => None,
        }
    }

    pub(crate) fn is_zero(&self, id: NodeId) -> bool {
        self.as_constant(id) == Some(0.0)
    }

    /// Whether an expression depends on the parameters alone.
    pub(crate) fn is_fixed(&self, id: NodeId) -> bool {
        self.dependence[id.index()] == Set::EMPTY
    }

    /// Whether any expression of the graph depends on a leaf.
    pub(crate) fn has_leaf(&self, leaf: Leaf) -> bool {
        self.leaf_bits.contains_key(&leaf)
    }

    pub(crate) fn depends_on(&self, id: NodeId, leaf: Leaf) -> bool {
        self.leaf_bits
            .get(&leaf)
            .is_some_and(|&bit| self.sets.contains(self.dependence[id.index()], bit))
    }

    /// Whether a node may jump where a leaf changes. A derivative does not show it: it is that of one side.
    pub(crate) fn jumps_with(&self, id: NodeId, leaf: Leaf) -> bool {
        self.leaf_bits
            .get(&leaf)
            .is_some_and(|&bit| self.sets.contains(self.jumps[id.index()], bit))
    }

    /// The leaves with which a node may jump.
    pub(crate) fn jump_leaves(&self, id: NodeId) -> impl Iterator<Item = Leaf> {
        let bits = self.sets.bits(self.jumps[id.index()]);
        bits.map(|bit| self.leaves[bit])
    }

    /// Whether a node may call a user's function of a leaf for which `is_argument` holds.
    pub(crate) fn calls_with(&self, id: NodeId, is_argument: fn(Leaf) -> bool) -> bool {
        self.subexpressions([id], |id| self.leaves(id).any(is_argument))
            .into_iter()
            .any(|id| matches!(self.node(id), Node::Call { .. }))
    }

    /// Whether a node is affine in a leaf, given its derivative `slope`. A node that may jump is not.
    pub(crate) fn is_affine(&self, id: NodeId, slope: NodeId, leaf: Leaf) -> bool {
        !self.depends_on(slope, leaf) && !self.jumps_with(id, leaf)
    }

    /// Every leaf that a node depends on.
    pub(crate) fn leaves(&self, id: NodeId) -> impl Iterator<Item = Leaf> {
        let bits = self.sets.bits(self.dependence[id.index()]);
        bits.map(|bit| self.leaves[bit])
    }

    /// The number of the set of leaves that a node depends on: equal for nodes with the same leaves.
    pub(crate) fn leaf_set(&self, id: NodeId) -> usize {
        self.dependence[id.index()].index()
    }

    /// The highest derivative of a coordinate that a node depends on; `None` if it depends on no coordinate.
    pub(crate) fn order(&self, id: NodeId) -> Option<usize> {
        self.leaves(id).filter_map(Leaf::order).max()
    }

    /// The operands of a node.
    pub(crate) fn parts(&self, id: NodeId) -> Vec<NodeId> {
        self.node(id).parts()
    }

    /// The given expressions and their subexpressions, each once; without those that are not `wanted`, and without those that occur only in
    /// such.
    pub(crate) fn subexpressions(
        &self,
        of: impl IntoIterator<Item = NodeId>,
        wanted: impl Fn(NodeId) -> bool,
    ) -> Vec<NodeId> {
        let (mut found, mut seen, mut open) = (Vec::new(), HashSet::default(), Vec::from_iter(of));
        while let Some(id) = open.pop() {
            if wanted(id) && seen.insert(id) {
                found.push(id);
                open.extend(self.parts(id));
            }
        }
        found
    }

    /// The node that is equal to a given one, if it is in the graph.
    fn find(&self, hash: u64, node: &Node) -> Option<NodeId> {
        let mut found = self.last_of_hash.get(&hash).copied();
        while let Some(id) = found {
            if *self.nodes[id.index()] == *node {
                return Some(id);
            }
            found = self.previous_of_hash[id.index()];
        }
        None
    }

    fn intern(&mut self, node: Node) -> NodeId {
        let hash = FxBuildHasher.hash_one(&node);
        if let Some(id) = self.find(hash, &node) {
            return id;
        }
        let parts = node.parts();
        let depths = parts.iter().map(|part| self.depths[part.index()] + 1);
        let depth = depths.max().unwrap_or(0);
        limits::spend(1 + parts.len());
        limits::check_depth(depth);
        let id = NodeId(u32::try_from(self.nodes.len()).unwrap_or(u32::MAX));
        let dependence = if let Node::Leaf(leaf) = node {
            let bit = self.leaves.len();
            self.leaves.push(leaf);
            self.leaf_bits.insert(leaf, bit);
            self.sets.single(bit)
        } else {
            let sets = parts.iter().map(|part| self.dependence[part.index()]);
            self.sets.union(sets)
        };
        let jumps = parts.iter().map(|part| self.jumps[part.index()]);
        let mut jumps = self.sets.union(jumps);
        // the sets of a node grow with the number of leaves
        limits::spend(self.sets.size(dependence) + self.sets.size(jumps));
        let compared: &[NodeId] = match &node {
            Node::Unary(Unary::Signum, a) => &[*a],
            Node::Select(_, [left, right, ..]) => &[*left, *right],
            _ => &[],
        };
        if !compared.is_empty() {
            let compared = compared.iter().map(|part| self.dependence[part.index()]);
            jumps = self.sets.union(compared.chain([jumps]));
        }
        self.nodes.push(Rc::new(node));
        self.depths.push(depth);
        self.dependence.push(dependence);
        self.jumps.push(jumps);
        self.previous_of_hash.push(self.last_of_hash.insert(hash, id));
        id
    }
}

#[cfg(test)]
mod tests;
