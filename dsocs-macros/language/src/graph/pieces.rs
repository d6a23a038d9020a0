//! Functions of expressions that consist of pieces.
//!
//! `x.max(0)` is zero wherever `x` is negative, and not only at a place. A sign of it that is found by the
//! zeros of its argument would be undetermined there. So the sign is that of each piece, 0 for one that is
//! zero, and changes where the condition of the pieces does: `x.max(0).signum()` is
//! `if x <= 0 { 0 } else { 1 }`.

use super::{Comparison, Graph, Memory, Node, NodeId, Pass, Unary};
use crate::hash::HashSet;

/// Largest number of comparisons and absolute values in an expression that is divided into its pieces: the number of pieces may grow as a
/// power of it.
const MOST: usize = 4;

/// An expression by its pieces.
enum Pieces {
    /// A piece, and its sign if that is known: 0 for one that is zero.
    Of(NodeId, Option<f64>),
    /// `if left < right { … } else { … }`.
    Either(Comparison, [NodeId; 2], Box<[Pieces; 2]>),
}

impl Pieces {
    /// Whether there is such a piece.
    fn any(&self, is: &dyn Fn(NodeId) -> bool) -> bool {
        match self {
            Self::Of(piece, _) => is(*piece),
            Self::Either(_, _, pieces) => pieces.iter().any(|piece| piece.any(is)),
        }
    }
}

/// Conditions of the pieces around an expression: differences with their signs.
type Known = Vec<(NodeId, f64)>;

impl Graph {
    /// A function of an expression one of whose pieces is a constant: it is taken of each piece. So the power
    /// of a piece that is zero is zero, and not a power without a derivative.
    pub(super) fn of_pieces(
        &mut self,
        id: NodeId,
        of: impl Fn(&mut Self, NodeId) -> NodeId,
    ) -> Option<NodeId> {
        if let &Node::Select(op, [left, right, then, otherwise]) = self.node(id)
            && [then, otherwise]
                .iter()
                .any(|&piece| self.as_constant(piece).is_some())
        {
            let [then, otherwise] = [then, otherwise].map(|piece| of(self, piece));
            return Some(self.select(op, left, right, then, otherwise));
        }
        let pieces = self.pieces(id)?;
        let is_any = pieces.any(&|piece| self.as_constant(piece).is_some());
        is_any.then(|| self.join(&pieces, &|graph, piece, _| of(graph, piece)))
    }

    /// The sign of an expression one of whose pieces is zero.
    pub(super) fn signum_of_pieces(&mut self, id: NodeId) -> Option<NodeId> {
        self.of_signs(id, &|graph, piece, sign| match sign {
            Some(sign) => graph.constant(sign),
            None => graph.unary(Unary::Signum, piece),
        })
    }

    /// A comparison whose difference has a piece that is zero.
    pub(super) fn select_by_pieces(
        &mut self,
        op: Comparison,
        [left, right]: [NodeId; 2],
        [then, otherwise]: [NodeId; 2],
    ) -> Option<NodeId> {
        let difference = self.sub(right, left);
        self.of_signs(difference, &|graph, piece, sign| match sign {
            Some(sign) if op.holds(0.0, sign) => then,
            Some(_) => otherwise,
            None => {
                let zero = graph.constant(0.0);
                graph.select(op, zero, piece, then, otherwise)
            }
        })
    }

    /// A function of the sign of an expression one of whose pieces is zero.
    fn of_signs(
        &mut self,
        id: NodeId,
        of: &dyn Fn(&mut Self, NodeId, Option<f64>) -> NodeId,
    ) -> Option<NodeId> {
        let pieces = self.pieces(id)?;
        let rests = pieces.any(&|piece| self.as_constant(piece) == Some(0.0));
        rests.then(|| self.join(&pieces, of))
    }

    /// The pieces of an expression; `None` if it has none, or too many comparisons.
    fn pieces(&mut self, id: NodeId) -> Option<Pieces> {
        let mut found = Vec::new();
        self.find_pieces(id, &mut HashSet::default(), &mut found);
        let is_little = (1..=MOST).contains(&found.len());
        is_little.then(|| self.pieces_under(id, &mut Known::new()))
    }

    /// The expression that has a function of each piece as its pieces.
    fn join(&mut self, pieces: &Pieces, of: &dyn Fn(&mut Self, NodeId, Option<f64>) -> NodeId) -> NodeId {
        match pieces {
            Pieces::Of(piece, sign) => of(self, *piece, *sign),
            Pieces::Either(op, [left, right], pieces) => {
                let [then, otherwise] = pieces.each_ref().map(|piece| self.join(piece, of));
                self.select(*op, *left, *right, then, otherwise)
            }
        }
    }

    /// The pieces of an expression under conditions.
    fn pieces_under(&mut self, id: NodeId, known: &mut Known) -> Pieces {
        let mut found = Vec::new();
        self.find_pieces(id, &mut HashSet::default(), &mut found);
        let Some(&piece) = found.first() else {
            return Pieces::Of(id, self.known_sign(id, known));
        };
        let (mut op, sides, branches) = match *self.node(piece) {
            Node::Select(op, [left, right, then, otherwise]) => (op, [left, right], [then, otherwise]),
            Node::Unary(_, argument) => {
                let (zero, opposite) = (self.constant(0.0), self.scale(-1.0, argument));
                (Comparison::Lt, [argument, zero], [opposite, argument])
            }
            _ => return Pieces::Of(id, None),
        };
        let difference = self.sub(sides[1], sides[0]);
        let difference = self.of_same_sign(difference);
        let [then, otherwise] = branches.map(|branch| self.replace(id, piece, branch));
        match self.known_sign(difference, known) {
            Some(sign) if sign > 0.0 => return self.pieces_under(then, known),
            Some(_) => return self.pieces_under(otherwise, known),
            None => {}
        }
        let mut under = |value: NodeId, side: f64| {
            known.push((difference, side));
            let pieces = self.pieces_under(value, known);
            known.pop();
            pieces
        };
        let pieces = [under(then, 1.0), under(otherwise, -1.0)];
        // where a piece that is zero meets another one that vanishes there, the expression is zero
        match &pieces {
            [Pieces::Of(_, Some(0.0)), _] if self.vanishes_with(otherwise, difference) => op = Comparison::Le,
            [_, Pieces::Of(_, Some(0.0))] if self.vanishes_with(then, difference) => op = Comparison::Lt,
            _ => {}
        }
        Pieces::Either(op, sides, Box::new(pieces))
    }

    /// Whether an expression is zero wherever an argument is, as the difference of a corner's two pieces. The argument is solved for a leaf, or else for
    /// a part, such as a corner within it.
    pub(crate) fn vanishes_with(&mut self, value: NodeId, argument: NodeId) -> bool {
        // as of `min` and `max`
        if self.ratio(value, argument).is_some() {
            return true;
        }
        let (terms, constant) = self.terms(argument);
        let leaf = terms
            .iter()
            .find(|(node, _)| matches!(self.node(*node), Node::Leaf(_)));
        let Some(&(solved, slope)) = leaf.or(terms.first()) else {
            return false;
        };
        let others: Vec<_> = terms.iter().filter(|(node, _)| *node != solved).collect();
        let is_within = |part: NodeId| self.subexpressions([part], |_| true).contains(&solved);
        if others.iter().any(|(node, _)| is_within(*node)) {
            return false;
        }
        let others: Vec<_> = others.iter().map(|&&(node, c)| (node, -c / slope)).collect();
        let zero = self.linear(-constant / slope, &others);
        let there = self.replace(value, solved, zero);
        self.vanishes(there)
    }

    /// The sign of a constant, or of a multiple of a difference whose sign is known.
    fn known_sign(&mut self, id: NodeId, known: &Known) -> Option<f64> {
        let same = self.of_same_sign(id);
        if let Some(value) = self.as_constant(same) {
            return (!value.is_nan()).then(|| if value == 0.0 { 0.0 } else { value.signum() });
        }
        known
            .iter()
            .find_map(|&(difference, side)| Some(self.ratio(same, difference)?.signum() * side))
    }

    /// Finds the comparisons and absolute values in an expression, operands before what depends on them, up to one
    /// more than [`MOST`].
    fn find_pieces(&self, id: NodeId, seen: &mut HashSet<NodeId>, found: &mut Vec<NodeId>) {
        let node = self.node(id);
        if found.len() > MOST || matches!(node, Node::Call { .. }) || !seen.insert(id) {
            return;
        }
        for part in self.parts(id) {
            self.find_pieces(part, seen, found);
        }
        if matches!(node, Node::Select(..) | Node::Unary(Unary::Abs, _)) {
            found.push(id);
        }
    }

    /// An expression with another one in place of a part.
    fn replace(&mut self, id: NodeId, part: NodeId, by: NodeId) -> NodeId {
        self.rewrite(
            id,
            &mut Replacement {
                part,
                by,
                memory: Memory::default(),
            },
        )
    }
}

/// The replacement of a part of an expression.
struct Replacement {
    part: NodeId,
    by: NodeId,
    memory: Memory,
}

impl Pass for Replacement {
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn before(&mut self, _: &mut Graph, id: NodeId) -> Option<NodeId> {
        (id == self.part).then_some(self.by)
    }
}
