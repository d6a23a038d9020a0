//! The nodes of the graph, and its leaves.

use proc_macro2::{Ident, Span, TokenStream};

use super::Unary;

/// A node of a [`super::Graph`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct NodeId(pub(super) u32);

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

/// The comparison of a [`Node::Select`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) enum Comparison {
    Lt,
    Le,
}

impl Comparison {
    /// Whether it holds between two numbers.
    pub(crate) fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Self::Lt => left < right,
            Self::Le => left <= right,
        }
    }
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
    /// An expression of the parameters alone, by its place in [`super::Graph::params`].
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
    /// A partial derivative of a user's function, by its place in [`super::Graph::callees`]; `wrt` lists the arguments
    /// with respect to which it is differentiated, in ascending order (empty: the function's value).
    Call {
        callee: usize,
        args: Vec<NodeId>,
        wrt: Vec<usize>,
    },
}

impl Node {
    /// The operands.
    pub(crate) fn parts(&self) -> Vec<NodeId> {
        match self {
            Self::Constant(_) | Self::Leaf(_) | Self::Param(_) => Vec::new(),
            Self::Sum(_, terms) => terms.iter().map(|&(term, _)| term).collect(),
            Self::Product(factors) => factors.iter().map(|&(factor, _)| factor).collect(),
            Self::Unary(_, a) => vec![*a],
            Self::Powf(a, b) | Self::Atan2(a, b) => vec![*a, *b],
            Self::Select(_, parts) => parts.to_vec(),
            Self::Call { args, .. } => args.clone(),
        }
    }
}
