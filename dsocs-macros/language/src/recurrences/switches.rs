//! Values that are watched, because a series does not show from afar where its motion changes quickly.

use super::lower::{Lower, split};
use super::sequence::{Argument, Bound, Op, Sequence};
use crate::graph::{Node, NodeId, Unary};

/// A divisor with a power of this degree or a higher one may make a function flat far from its zero.
pub(super) const HIGH: f64 = 4.0;

/// `1 + c u²` is not narrow if `c` is at most this large.
const WIDE: f64 = 100.0;

/// A factor with this power or a higher one is flat where it is small, so the series has to see at least so
/// many orders to detect its rise.
const LEAST_HILL: f64 = 8.0;

/// The highest degree of a root that is looked for in exponents.
const MOST_DEGREE: u32 = 16;

/// The integer of least size that is not below an exponent.
#[allow(clippy::cast_possible_truncation)] // the nearest in its range
fn whole(exponent: f64) -> i32 {
    exponent.abs().ceil().copysign(exponent) as i32
}

impl Lower<'_> {
    /// Watches the base of a power, if the power may be flat far from where it is large.
    pub(super) fn watch_high(&mut self, base: NodeId, exponent: f64) {
        let degree = exponent.abs() * self.degree(base);
        if exponent < 0.0 && (degree >= HIGH || self.is_softened(base)) {
            // of the same steepness as before where a root has been taken off
            let steepness = if exponent.fract() == 0.0 {
                degree
            } else {
                exponent.abs()
            };
            self.watch_divisor(base, steepness);
        } else if exponent >= LEAST_HILL {
            self.watch_power(base, exponent);
        }
    }

    /// Whether an expression is a fixed number plus an even power of one factor, both positive as far as that
    /// is known, as `1 + u²`. A motion in which `u` passes zero meets the least value, however narrow the place
    /// is. A circular function has no narrow places.
    fn is_softened(&self, id: NodeId) -> bool {
        let (terms, constant) = self.graph.terms(id);
        let (fixed, moving): (Vec<_>, Vec<_>) =
            terms.iter().partition(|(term, _)| self.graph.is_fixed(*term));
        let &[&(term, c)] = &moving[..] else {
            return false;
        };
        let (_, factors) = split(self.graph, term);
        let &[(factor, n)] = &factors[..] else {
            return false;
        };
        let is_circular = matches!(self.graph.node(factor), Node::Unary(Unary::Sin | Unary::Cos, _));
        // of a coordinate itself, with a literal width that is not small
        let is_wide = matches!(self.graph.node(factor), Node::Leaf(_)) && c <= WIDE * constant;
        let (_, exponent) = self.base(factor);
        let power = exponent * f64::from(n);
        c > 0.0
            && constant >= 0.0
            && (constant > 0.0 || !fixed.is_empty())
            && power >= 2.0
            && !is_circular
            && !is_wide
    }

    /// Watches a divisor, and its factors with a high power: a multiple root is known to few digits only.
    pub(super) fn watch_divisor(&mut self, id: NodeId, degree: f64) {
        let mut watched = vec![(id, degree)];
        if let Node::Sum(_, terms) = self.graph.node(id) {
            for (term, _) in terms {
                if let Node::Product(factors) = self.graph.node(*term) {
                    let high = self.powers(factors).into_iter();
                    watched.extend(high.filter(|(_, n)| n.abs() >= HIGH));
                }
            }
        }
        for (id, degree) in watched {
            self.watch_power(id, -degree.abs());
        }
    }

    /// The bases of a product's factors with their exponents, those of roots taken together. The series of a
    /// root ends at the complex zero of its base, and does not show from afar where the base is small; that
    /// of the base does.
    pub(super) fn powers(&self, factors: &[(NodeId, i32)]) -> Vec<(NodeId, f64)> {
        let mut powers: Vec<(NodeId, f64)> = Vec::new();
        for &(factor, n) in factors {
            let (base, exponent) = self.base(factor);
            let exponent = exponent * f64::from(n);
            match powers.iter_mut().find(|(present, _)| *present == base) {
                Some((_, present)) => *present += exponent,
                None => powers.push((base, exponent)),
            }
        }
        powers
    }

    /// An expression as a power of a constant exponent of another one, which is no root.
    pub(super) fn base(&self, id: NodeId) -> (NodeId, f64) {
        let (of, exponent) = match *self.graph.node(id) {
            Node::Unary(Unary::Sqrt, of) => (of, Some(0.5)),
            Node::Unary(Unary::Cbrt, of) => (of, Some(1.0 / 3.0)),
            Node::Powf(of, exponent) => (of, self.graph.as_constant(exponent)),
            _ => return (id, 1.0),
        };
        exponent.map_or((id, 1.0), |exponent| {
            let (base, inner) = self.base(of);
            (base, inner * exponent)
        })
    }

    /// Watches the base of a power with a high exponent.
    pub(super) fn watch_power(&mut self, id: NodeId, exponent: f64) {
        let exponent = whole(exponent);
        let sequence = self.lower(id);
        self.sequences
            .switch(Argument::Power(sequence, exponent), Vec::new());
    }

    /// Watches a value that has bounds.
    pub(super) fn watch_bound(&mut self, value: Sequence, bound: Bound) {
        self.sequences.switch(Argument::Bounded(value, bound), Vec::new());
    }

    /// Watches a root of the base of a power, if the base may touch zero. The root has the lowest degree with
    /// which the base touching zero makes a corner: the fourth root for the exponents 1/4 and -3/4.
    pub(super) fn watch_root(&mut self, base: NodeId, exponent: f64) {
        let degree = (2..=MOST_DEGREE)
            .step_by(2)
            .map(f64::from)
            .find(|degree| (exponent * degree).fract() == 0.0);
        if let Some(degree) = degree
            && exponent.fract() != 0.0
            && self.may_touch(base)
        {
            let (base, exponent) = (self.lower(base), self.graph.constant(degree.recip()));
            let root = self.sequences.push(Op::Power(base, exponent));
            self.watch_bound(root, Bound::Zero);
        }
    }

    /// Whether an expression may touch zero without another switch showing it. A motion goes through the zero of a norm of positions;
    /// where a speed vanishes it ends, or has none.
    pub(super) fn may_touch(&self, id: NodeId) -> bool {
        let is_norm_of_rates = self.graph.is_several_squares(id) && self.graph.order(id) > Some(0);
        !self.graph.is_softened_sum(id) && !is_norm_of_rates && !self.begins_piece(id)
    }

    /// Whether an expression is zero where a factor changes to another piece, such as `x.max(0)`, which is
    /// watched already.
    pub(super) fn begins_piece(&self, id: NodeId) -> bool {
        let is_piece = |node: NodeId| {
            matches!(
                self.graph.node(node),
                Node::Select(..) | Node::Unary(Unary::Abs, _)
            )
        };
        match self.graph.terms(id) {
            (terms, constant) if terms.len() == 1 && constant == 0.0 => {
                let factors = self.graph.factors(terms[0].0);
                factors.iter().any(|&(factor, _)| is_piece(factor))
            }
            _ => false,
        }
    }

    /// The highest degree of a term in moving factors, for an expression that is a sum or a product.
    pub(super) fn degree(&self, id: NodeId) -> f64 {
        let of_factor = |id: NodeId| match self.base(id) {
            (base, _) if base == id => 1.0,
            (base, exponent) => exponent.abs() * self.degree(base),
        };
        let of_factors = |id: NodeId| match self.graph.node(id) {
            Node::Product(factors) => {
                let moving = factors.iter().filter(|(factor, _)| !self.graph.is_fixed(*factor));
                moving
                    .map(|&(factor, n)| f64::from(n.unsigned_abs()) * of_factor(factor))
                    .sum()
            }
            _ => of_factor(id),
        };
        match self.graph.node(id) {
            Node::Sum(_, terms) => {
                let degrees = terms.iter().map(|(term, _)| of_factors(*term));
                degrees.reduce(f64::max).unwrap_or(1.0)
            }
            _ => of_factors(id),
        }
    }
}
