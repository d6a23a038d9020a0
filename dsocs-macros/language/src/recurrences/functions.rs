//! The recurrences of the functions of one argument.

use super::lower::Lower;
use super::sequence::{Bound, Inverse, Op, Sequence};
use crate::graph::Unary;

impl Lower<'_> {
    /// The sequence of a function of a sequence.
    pub(super) fn unary(&mut self, op: Unary, a: Sequence) -> Sequence {
        let op = match op {
            Unary::Sqrt => Op::Root(a),
            Unary::Cbrt => Op::CubeRoot(a),
            Unary::Exp => Op::Exp(a),
            Unary::ExpM1 => Op::ExpM1(a),
            Unary::Ln => Op::Ln(a),
            Unary::Ln1p => Op::Ln1p(a),
            Unary::Abs => Op::Abs(a),
            Unary::Signum => Op::Signum(a),
            Unary::Sin | Unary::Cos => {
                let [sine, cosine] = self.pair(a, true);
                return if op == Unary::Sin { sine } else { cosine };
            }
            Unary::Sinh | Unary::Cosh => {
                let [sine, cosine] = self.pair(a, false);
                return if op == Unary::Sinh { sine } else { cosine };
            }
            Unary::Tan | Unary::Tanh => {
                let conjugate = op == Unary::Tanh;
                if let Some(&known) = self.tangents.get(&(a, conjugate)) {
                    return known;
                }
                let one = self.graph.constant(1.0);
                let value = self.sequences.tangent(a, one, conjugate);
                self.tangents.insert((a, conjugate), value);
                return value;
            }
            Unary::Asin => Op::Inverse(Inverse::Asin, a, self.conjugate_root(a)),
            Unary::Acos => {
                let root = self.conjugate_root(a);
                let minus_one = self.graph.constant(-1.0);
                let negative = self.sequences.push(Op::Linear(None, vec![(minus_one, root)]));
                Op::Inverse(Inverse::Acos, a, negative)
            }
            Unary::Atan => Op::Inverse(Inverse::Atan, a, self.one_and(a)),
            Unary::Asinh => {
                let sum = self.one_and(a);
                Op::Inverse(Inverse::Asinh, a, self.sequences.push(Op::Root(sum)))
            }
            Unary::Acosh => {
                let conjugate = self.conjugate(a);
                let minus_one = self.graph.constant(-1.0);
                let opposite = self
                    .sequences
                    .push(Op::Linear(None, vec![(minus_one, conjugate)]));
                let root = self.sequences.push(Op::Root(opposite));
                self.watch_bound(root, Bound::Zero);
                Op::Inverse(Inverse::Acosh, a, root)
            }
            Unary::Atanh => Op::Inverse(Inverse::Atanh, a, self.conjugate(a)),
        };
        self.sequences.push(op)
    }

    fn pair(&mut self, a: Sequence, circular: bool) -> [Sequence; 2] {
        if let Some(&known) = self.pairs.get(&(a, circular)) {
            return known;
        }
        let pair = if circular {
            self.sequences.pair(a, Op::Sin, Op::Cos)
        } else {
            self.sequences.pair(a, Op::Sinh, Op::Cosh)
        };
        self.pairs.insert((a, circular), pair);
        pair
    }

    /// `1 - u²`.
    fn conjugate(&mut self, u: Sequence) -> Sequence {
        let square = self.sequences.push(Op::Square(u));
        self.sequences.push(Op::Conjugate(u, square))
    }

    /// `√(1 - u²)`.
    fn conjugate_root(&mut self, u: Sequence) -> Sequence {
        let conjugate = self.conjugate(u);
        let root = self.sequences.push(Op::Root(conjugate));
        self.watch_bound(root, Bound::Zero);
        root
    }

    /// `1 + u²`.
    fn one_and(&mut self, u: Sequence) -> Sequence {
        let one = self.graph.constant(1.0);
        let square = self.sequences.push(Op::Square(u));
        self.sequences.push(Op::Linear(Some(one), vec![(one, square)]))
    }
}
