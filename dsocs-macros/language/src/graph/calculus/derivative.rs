//! Forward differentiation on the graph: each node's tangent, and no node where the tangent is structurally
//! zero.

use crate::graph::calculus::rotation::SLOTS;
use crate::graph::{Graph, Leaf, Node, NodeId, Unary};
use crate::hash::HashMap;
use crate::mistakes::limits;

/// The direction of a derivative.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Direction {
    /// Along one leaf.
    Of(Leaf),
    /// Along the motion: `q̇ = v`, `v̇ = a`, `ȧ = j`, and time has rate 1.
    Time,
}

/// The nodes that vary in a direction.
enum VaryingNodes {
    /// The nodes that depend on one of some leaves, given by their bits.
    WithLeaves { bits: [usize; 2 * SLOTS], count: usize },
    /// The nodes that vary with time.
    WithTime,
}

impl VaryingNodes {
    fn contains(&self, graph: &Graph, id: NodeId) -> bool {
        match self {
            Self::WithLeaves { bits, count } => {
                let set = graph.dependence[id.index()];
                bits[..*count].iter().any(|&bit| graph.sets.contains(set, bit))
            }
            Self::WithTime => graph
                .leaves(id)
                .any(|leaf| matches!(leaf, Leaf::Q(_) | Leaf::V(_) | Leaf::A(_) | Leaf::T)),
        }
    }
}

impl Graph {
    /// `∂node/∂leaf`.
    pub(crate) fn derivative(&mut self, id: NodeId, leaf: Leaf) -> NodeId {
        self.tangent(id, Direction::Of(leaf))
    }

    /// `d/dt` along the motion. The node must be of order 2 at most.
    ///
    /// The tangent is carried through each operation, not summed up from partial derivatives: `d/dt (p²/2)`
    /// is `p ṗ`, where `ṗ` may be small although its terms are not.
    pub(crate) fn total_derivative(&mut self, id: NodeId) -> NodeId {
        self.tangent(id, Direction::Time)
    }

    /// Whether a node varies with a leaf: it depends on the leaf, or on a component of the same rotation.
    pub(crate) fn varies_with(&self, id: NodeId, leaf: Leaf) -> bool {
        self.varying(Direction::Of(leaf)).contains(self, id)
    }

    /// The nodes that vary in a direction.
    fn varying(&self, direction: Direction) -> VaryingNodes {
        match direction {
            Direction::Of(leaf) => {
                let mut bits = [usize::MAX; 2 * SLOTS];
                let leaves = self.leaves_varying_with(leaf).into_iter().flatten();
                let found = leaves.filter_map(|leaf| self.leaf_bits.get(&leaf));
                let count = found.zip(&mut bits).map(|(&bit, place)| *place = bit).count();
                VaryingNodes::WithLeaves { bits, count }
            }
            Direction::Time => VaryingNodes::WithTime,
        }
    }

    fn tangent(&mut self, id: NodeId, direction: Direction) -> NodeId {
        let varying = self.varying(direction);
        if !varying.contains(self, id) {
            return self.constant(0.0);
        }
        let mut known = self.derivatives.remove(&direction).unwrap_or_default();
        let result = self.tangent_with(id, (direction, &varying), &mut known);
        self.derivatives.insert(direction, known);
        result
    }

    fn tangent_with(
        &mut self,
        id: NodeId,
        of: (Direction, &VaryingNodes),
        known: &mut HashMap<NodeId, NodeId>,
    ) -> NodeId {
        let (direction, varying) = of;
        // most nodes do not depend on a given leaf
        if !varying.contains(self, id) {
            return self.constant(0.0);
        }
        if let Some(&known) = known.get(&id) {
            return known;
        }
        let result = match *self.shared_node(id) {
            Node::Constant(_) | Node::Param(_) => self.constant(0.0),
            Node::Leaf(leaf) if self.is_of_rotation(leaf) => self.rotation_derivative(leaf, direction),
            Node::Leaf(leaf) => match (direction, leaf) {
                (Direction::Time, Leaf::Q(i)) => self.leaf(Leaf::V(i)),
                (Direction::Time, Leaf::V(i)) => self.leaf(Leaf::A(i)),
                (Direction::Time, Leaf::A(i)) => self.leaf(Leaf::J(i)),
                _ => self.constant(1.0),
            },
            Node::Sum(_, ref terms) => {
                // testing a term costs about an eighth of an operation
                limits::spend(terms.len() / 8);
                let mut tangents = Vec::new();
                for &(term, c) in terms {
                    if varying.contains(self, term) {
                        tangents.push((self.tangent_with(term, of, known), c.get()));
                    }
                }
                self.linear(0.0, &tangents)
            }
            Node::Product(ref factors) => {
                let mut terms = Vec::new();
                let mut rest = Vec::with_capacity(factors.len() + 1);
                for (k, &(base, exponent)) in factors.iter().enumerate() {
                    if !varying.contains(self, base) {
                        continue;
                    }
                    let tangent = self.tangent_with(base, of, known);
                    if self.is_zero(tangent) {
                        continue;
                    }
                    rest.clear();
                    rest.extend_from_slice(factors);
                    rest[k].1 = exponent.saturating_sub(1);
                    rest.push((tangent, 1));
                    terms.push((self.product(&rest), f64::from(exponent)));
                }
                self.linear(0.0, &terms)
            }
            Node::Unary(op, a) => {
                let outer = op.derivative(self, a, id);
                let tangent = self.tangent_with(a, of, known);
                self.mul(outer, tangent)
            }
            Node::Powf(a, b) => self.powf_derivative(id, [a, b], of, known),
            Node::Atan2(y, x) => {
                let (dy, dx) = (self.tangent_with(y, of, known), self.tangent_with(x, of, known));
                let squares = [self.powi(x, 2), self.powi(y, 2)];
                let radius = self.sum(&squares);
                let (left, right) = (self.mul(x, dy), self.mul(y, dx));
                let numerator = self.sub(left, right);
                self.div(numerator, radius)
            }
            Node::Select(op, [left, right, then, otherwise]) => {
                let (then, otherwise) = (
                    self.tangent_with(then, of, known),
                    self.tangent_with(otherwise, of, known),
                );
                self.select(op, left, right, then, otherwise)
            }
            Node::Call {
                callee,
                ref args,
                ref wrt,
            } => {
                let mut terms = Vec::new();
                for (place, &arg) in args.iter().enumerate() {
                    let tangent = self.tangent_with(arg, of, known);
                    if self.is_zero(tangent) {
                        continue;
                    }
                    let mut wrt = wrt.clone();
                    wrt.push(place);
                    wrt.sort_unstable();
                    let partial = self.call_partial(callee, args.clone(), wrt);
                    terms.push(self.mul(partial, tangent));
                }
                self.sum(&terms)
            }
        };
        known.insert(id, result);
        result
    }

    fn powf_derivative(
        &mut self,
        id: NodeId,
        [a, b]: [NodeId; 2],
        of: (Direction, &VaryingNodes),
        known: &mut HashMap<NodeId, NodeId>,
    ) -> NodeId {
        let mut terms = Vec::new();
        let base_tangent = self.tangent_with(a, of, known);
        if !self.is_zero(base_tangent) {
            let lower = self.linear(-1.0, &[(b, 1.0)]);
            let power = self.powf(a, lower);
            terms.push(self.product(&[(b, 1), (power, 1), (base_tangent, 1)]));
        }
        let exponent_tangent = self.tangent_with(b, of, known);
        if !self.is_zero(exponent_tangent) {
            let log = self.unary(Unary::Ln, a);
            terms.push(self.product(&[(id, 1), (log, 1), (exponent_tangent, 1)]));
        }
        self.sum(&terms)
    }
}
