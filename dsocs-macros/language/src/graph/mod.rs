//! The expression graph: all expressions of a declaration, with common subexpressions shared.
//!
//! A node is made by the builder methods of [`Graph`], which keep it in a normal form (sums with collected
//! coefficients, products with collected exponents, constants folded) and share equal nodes. There are few
//! kinds of nodes on purpose, because every walk over the graph has to know each of them:
//!
//! - [`rewrite`](Graph::rewrite): the walk of every pass that makes one expression from another
//!   ([`mod@rewrite`]);
//! - [`derivative`](Graph::derivative): forward differentiation ([`mod@derivative`]);
//! - [`mod@rotation`]: coordinates that are rotations, and their derivatives;
//! - [`difference`](Graph::difference): the change of an expression between two points, without cancellation
//!   ([`mod@difference`]);
//! - [`values`](Graph::values): numeric evaluation ([`mod@evaluate`]);
//! - [`vanishes`](Graph::vanishes): arithmetic modulo a prime, to tell whether an expression is zero
//!   ([`mod@identity`]) or cannot be ([`mod@nonzero`]);
//! - [`power_of_step`](Graph::power_of_step): the order in the step `h` with which an expression vanishes
//!   ([`mod@power`]);
//! - [`algebra`]: rewritings that make expressions shorter;
//! - code, through [`crate::emit::program`].

pub(crate) mod algebra;
mod build;
mod derivative;
mod difference;
mod evaluate;
mod identity;
mod nonzero;
mod power;
mod rewrite;
pub(crate) mod rotation;
mod sets;

use std::collections::BTreeMap;
use std::hash::BuildHasher;
use std::rc::Rc;

use proc_macro2::{Ident, Span, TokenStream};

use crate::hash::{FxBuildHasher, HashMap, HashSet};
use crate::limits;

use sets::{Set, Sets};

pub(crate) use build::collect;
pub(crate) use difference::Change;
pub(crate) use nonzero::Slopes;
pub(crate) use rewrite::{Memory, Pass, Substitution};

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

/// A node of a [`Graph`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct NodeId(u32);

impl NodeId {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// A variable of an expression.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) enum Leaf {
    /// A coordinate of the continuous motion.
    Q(usize),
    /// A velocity `q̇`.
    V(usize),
    /// An acceleration `q̈`.
    A(usize),
    /// A jerk, the third derivative.
    J(usize),
    /// The time of the continuous motion.
    T,
    /// A coordinate of a map's first node.
    X0(usize),
    /// A coordinate of a map's second node.
    X1(usize),
    /// A coordinate of a map's third node.
    X2(usize),
    /// A component of a rotation's local increment `x` from a map's first node to its second, `X1 = X0 τ(x)`.
    Chord(usize),
    /// The time of a map's first node.
    T0,
    /// The time of a map's second node.
    T1,
    /// The time of a map's third node.
    T2,
    /// The step `h`.
    H,
    /// A coordinate of the step's middle node `q1`.
    N(usize),
    /// The time of the step's middle node.
    Clock,
    /// A component of the increment `q1 - q0`.
    D(usize),
    /// A component of the previous second difference, which ends with `q1`. Only with constraints of third
    /// order.
    P(usize),
    /// A component of the unknown difference: the second, `q2 - 2 q1 + q0`, or with constraints of third
    /// order the third, by which it differs from `P`.
    E(usize),
    /// A multiplier.
    Lambda(usize),
    /// An unknown of the step, by its place.
    Z(usize),
    /// A number between -1 and 1 that replaces a sign (see [`crate::mechanics::Sides`]).
    Side(usize),
}

impl Leaf {
    /// The index of the leaf among those of its kind; `None` for times and the step.
    pub(crate) fn place(self) -> Option<usize> {
        match self {
            Self::Q(i)
            | Self::V(i)
            | Self::A(i)
            | Self::J(i)
            | Self::X0(i)
            | Self::X1(i)
            | Self::X2(i)
            | Self::Chord(i)
            | Self::N(i)
            | Self::D(i)
            | Self::P(i)
            | Self::E(i)
            | Self::Lambda(i)
            | Self::Z(i)
            | Self::Side(i) => Some(i),
            Self::T | Self::T0 | Self::T1 | Self::T2 | Self::H | Self::Clock => None,
        }
    }

    /// The order of the derivative of a coordinate; `None` for leaves that are not of the continuous motion.
    pub(crate) fn order(self) -> Option<usize> {
        match self {
            Self::Q(_) => Some(0),
            Self::V(_) => Some(1),
            Self::A(_) => Some(2),
            Self::J(_) => Some(3),
            _ => None,
        }
    }
}

/// Functions of one argument.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) enum Unary {
    Sqrt,
    Cbrt,
    Exp,
    ExpM1,
    Ln,
    Ln1p,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    Abs,
    Signum,
}

/// The comparison of a [`Node::Select`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) enum Comparison {
    Lt,
    Le,
}

/// A user's function, which the graph cannot see into.
#[derive(Clone, Debug)]
pub(crate) enum Callee {
    /// Everything before the parenthesis: `my_function`, `self.curvature.at`.
    Function(TokenStream),
    /// A method of the first argument.
    Method(Ident),
}

impl Callee {
    /// The name of the table of samples that is called: `wind` of `self.wind.at`.
    pub(crate) fn of_samples(&self) -> Option<String> {
        let Self::Function(tokens) = self else { return None };
        let trees: Vec<String> = tokens.clone().into_iter().map(|tree| tree.to_string()).collect();
        match trees.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
            ["self", ".", name, ".", "at"] => Some(name.trim_start_matches("r#").to_owned()),
            _ => None,
        }
    }

    /// The function as the user wrote it.
    pub(crate) fn source_text(&self) -> String {
        match self {
            Self::Function(tokens) => tokens.to_string().replace(' ', ""),
            Self::Method(name) => name.to_string(),
        }
    }

    /// The place of the function's name in the user's source.
    pub(crate) fn span(&self) -> Span {
        match self {
            // the last token is the name, as in `self.curvature.at`
            Self::Function(tokens) => tokens
                .clone()
                .into_iter()
                .last()
                .map_or_else(Span::call_site, |token| token.span()),
            Self::Method(name) => name.span(),
        }
    }
}

/// A constant, compared and hashed by its bits.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct Bits(u64);

impl Bits {
    pub(crate) fn new(value: f64) -> Self {
        // one zero: the sign of a folded constant zero carries no meaning
        Self(if value == 0.0 { 0 } else { value.to_bits() })
    }

    pub(crate) fn get(self) -> f64 {
        f64::from_bits(self.0)
    }
}

/// An expression whose parts are nodes.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Node {
    Constant(Bits),
    Leaf(Leaf),
    /// An expression of the parameters alone, by its place in [`Graph::params`].
    Param(usize),
    /// `constant + Σ coefficient · node`, sorted by node, no coefficient zero, no term itself a sum.
    Sum(Bits, Vec<(NodeId, Bits)>),
    /// `Π node^exponent`, sorted by node, no exponent zero, no factor itself a product or a constant.
    Product(Vec<(NodeId, i32)>),
    Unary(Unary, NodeId),
    Powf(NodeId, NodeId),
    Atan2(NodeId, NodeId),
    /// `if left < right { then } else { otherwise }`, with both branches computed.
    Select(Comparison, [NodeId; 4]),
    /// A partial derivative of a user's function, by its place in [`Graph::callees`]; `wrt` lists the arguments
    /// with respect to which it is differentiated, in ascending order (empty: the function's value).
    Call {
        callee: usize,
        args: Vec<NodeId>,
        wrt: Vec<usize>,
    },
}

/// All expressions of one declaration.
#[derive(Clone, Default, Debug)]
pub(crate) struct Graph {
    nodes: Vec<Rc<Node>>,
    sets: Sets,
    /// For every node, the leaves that it depends on.
    dependence: Vec<Set>,
    /// For every node, the leaves whose change can make it jump.
    deciding: Vec<Set>,
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
    derivatives: HashMap<derivative::Direction, HashMap<NodeId, NodeId>>,
    /// The first slots of the coordinates that are rotations (see [`mod@rotation`]).
    rotations: Vec<usize>,
    /// The results of [`Graph::split`] for sums.
    splits: HashMap<NodeId, (f64, NodeId)>,
    /// The results of [`Graph::power_of_step`].
    powers: HashMap<NodeId, i32>,
    residues: identity::PointResidues,
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
        let (mut params, mut seen, mut open) = (Vec::new(), HashSet::default(), vec![id]);
        while let Some(id) = open.pop() {
            if !seen.insert(id) {
                continue;
            }
            match self.node(id) {
                Node::Param(param) => params.push(self.read_param(*param)),
                Node::Call { callee, .. } => {
                    if let Callee::Function(tokens) = self.callee(*callee) {
                        params.push(Param::Expression(tokens));
                    }
                }
                _ => {}
            }
            open.extend(self.parts(id));
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
            .is_some_and(|&bit| self.sets.contains(self.deciding[id.index()], bit))
    }

    /// The leaves with which a node may jump.
    pub(crate) fn deciding(&self, id: NodeId) -> impl Iterator<Item = Leaf> {
        let bits = self.sets.bits(self.deciding[id.index()]);
        bits.map(|bit| self.leaves[bit])
    }

    /// Whether a node may call a user's function of a leaf for which `asked` holds.
    pub(crate) fn calls_with(&self, id: NodeId, asked: fn(Leaf) -> bool) -> bool {
        let mut seen = HashSet::default();
        let mut open = vec![id];
        while let Some(id) = open.pop() {
            if !seen.insert(id) || !self.leaves(id).any(asked) {
                continue;
            }
            if matches!(self.node(id), Node::Call { .. }) {
                return true;
            }
            open.extend(self.parts(id));
        }
        false
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
        match self.node(id) {
            Node::Constant(_) | Node::Leaf(_) | Node::Param(_) => Vec::new(),
            Node::Sum(_, terms) => terms.iter().map(|&(term, _)| term).collect(),
            Node::Product(factors) => factors.iter().map(|&(factor, _)| factor).collect(),
            Node::Unary(_, a) => vec![*a],
            Node::Powf(a, b) | Node::Atan2(a, b) => vec![*a, *b],
            Node::Select(_, parts) => parts.to_vec(),
            Node::Call { args, .. } => args.clone(),
        }
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
        let (mut count, mut depth) = (0, 0);
        for_parts(&node, |part| {
            count += 1;
            depth = depth.max(self.depths[part.index()] + 1);
        });
        limits::spend(1 + count);
        limits::check_depth(depth);
        let id = NodeId(u32::try_from(self.nodes.len()).unwrap_or(u32::MAX));
        let dependence = if let Node::Leaf(leaf) = node {
            let bit = self.leaves.len();
            self.leaves.push(leaf);
            self.leaf_bits.insert(leaf, bit);
            self.sets.single(bit)
        } else {
            union(&mut self.sets, &self.dependence, &node)
        };
        let mut deciding = union(&mut self.sets, &self.deciding, &node);
        // the sets of a node grow with the number of leaves
        limits::spend(self.sets.size(dependence) + self.sets.size(deciding));
        let compared: &[NodeId] = match &node {
            Node::Unary(Unary::Signum, a) => &[*a],
            Node::Select(_, [left, right, ..]) => &[*left, *right],
            _ => &[],
        };
        if !compared.is_empty() {
            let compared = compared.iter().map(|part| self.dependence[part.index()]);
            deciding = self.sets.union(compared.chain([deciding]));
        }
        self.nodes.push(Rc::new(node));
        self.depths.push(depth);
        self.dependence.push(dependence);
        self.deciding.push(deciding);
        self.previous_of_hash.push(self.last_of_hash.insert(hash, id));
        id
    }
}

/// Calls a function with each operand of a node.
fn for_parts(node: &Node, mut with: impl FnMut(NodeId)) {
    match node {
        Node::Constant(_) | Node::Leaf(_) | Node::Param(_) => {}
        Node::Sum(_, terms) => terms.iter().for_each(|&(term, _)| with(term)),
        Node::Product(factors) => factors.iter().for_each(|&(factor, _)| with(factor)),
        Node::Unary(_, a) => with(*a),
        Node::Powf(a, b) | Node::Atan2(a, b) => [*a, *b].into_iter().for_each(with),
        Node::Select(_, parts) => parts.iter().copied().for_each(with),
        Node::Call { args, .. } => args.iter().copied().for_each(with),
    }
}

/// The union of the sets of a node's operands.
fn union(sets: &mut Sets, of: &[Set], node: &Node) -> Set {
    let of = |id: NodeId| of[id.index()];
    match node {
        Node::Constant(_) | Node::Leaf(_) | Node::Param(_) => Set::EMPTY,
        Node::Sum(_, terms) => sets.union(terms.iter().map(|&(term, _)| of(term))),
        Node::Product(factors) => sets.union(factors.iter().map(|&(factor, _)| of(factor))),
        Node::Unary(_, a) => of(*a),
        Node::Powf(a, b) | Node::Atan2(a, b) => sets.union([of(*a), of(*b)]),
        Node::Select(_, parts) => sets.union(parts.iter().map(|&part| of(part))),
        Node::Call { args, .. } => sets.union(args.iter().map(|&arg| of(arg))),
    }
}

#[cfg(test)]
mod tests;
