//! The builders of nodes: each node in normal form, constants folded.

#![allow(clippy::float_cmp)] // coefficients are compared with exact ones and zeros

use core::f64::consts::FRAC_PI_2;

use proc_macro2::TokenStream;

use super::{Bits, Callee, Comparison, Graph, Leaf, Node, NodeId, Unary};

/// Least power of ten to which the coefficients of factors are collected, and least one together with constant factors.
const LEAST: f64 = -100.0;
const LEAST_OF_ALL: f64 = -290.0;

impl Graph {
    pub(crate) fn constant(&mut self, value: f64) -> NodeId {
        self.intern(Node::Constant(Bits::new(value)))
    }

    pub(crate) fn leaf(&mut self, leaf: Leaf) -> NodeId {
        self.intern(Node::Leaf(leaf))
    }

    /// A parameter: an `f64` expression in terms of `self`, independent of the coordinates.
    pub(crate) fn param(&mut self, tokens: TokenStream) -> NodeId {
        let params = &mut self.params;
        let param = *self.param_texts.entry(tokens.to_string()).or_insert_with(|| {
            params.push(tokens);
            params.len() - 1
        });
        self.intern(Node::Param(param))
    }

    pub(crate) fn add(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.linear(0.0, &[(a, 1.0), (b, 1.0)])
    }

    pub(crate) fn sub(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.linear(0.0, &[(a, 1.0), (b, -1.0)])
    }

    pub(crate) fn neg(&mut self, a: NodeId) -> NodeId {
        self.scale(-1.0, a)
    }

    pub(crate) fn scale(&mut self, coefficient: f64, a: NodeId) -> NodeId {
        self.linear(0.0, &[(a, coefficient)])
    }

    pub(crate) fn mul(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.product(&[(a, 1), (b, 1)])
    }

    pub(crate) fn div(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.product(&[(a, 1), (b, -1)])
    }

    pub(crate) fn recip(&mut self, a: NodeId) -> NodeId {
        self.product(&[(a, -1)])
    }

    pub(crate) fn powi(&mut self, a: NodeId, n: i32) -> NodeId {
        self.product(&[(a, n)])
    }

    pub(crate) fn sum(&mut self, terms: &[NodeId]) -> NodeId {
        let terms: Vec<_> = terms.iter().map(|&term| (term, 1.0)).collect();
        self.linear(0.0, &terms)
    }

    /// `constant + Σ coefficient · node`.
    pub(crate) fn linear(&mut self, constant: f64, terms: &[(NodeId, f64)]) -> NodeId {
        // a single node with coefficient 1 is itself
        if let &[(node, 1.0)] = terms
            && constant == 0.0
        {
            return node;
        }
        let mut constant = constant;
        let mut collected: Vec<(NodeId, f64)> = Vec::with_capacity(terms.len());
        for &(node, coefficient) in terms {
            match self.node(node) {
                Node::Constant(value) => constant += coefficient * value.get(),
                // a product that underflows is not collected
                Node::Sum(inner, inner_terms)
                    if coefficient == 0.0
                        || inner_terms
                            .iter()
                            .all(|(_, factor)| (coefficient * factor.get()).abs() >= f64::MIN_POSITIVE) =>
                {
                    constant += coefficient * inner.get();
                    let inner_terms = inner_terms.iter();
                    collected.extend(inner_terms.map(|&(term, factor)| (term, coefficient * factor.get())));
                }
                _ => collected.push((node, coefficient)),
            }
        }
        collect(&mut collected, |sum, more| *sum += more);
        collected.retain(|&(_, coefficient)| coefficient != 0.0);
        match collected[..] {
            [] => return self.constant(constant),
            [(node, 1.0)] if constant == 0.0 => return node,
            _ => {}
        }
        let terms = collected
            .into_iter()
            .map(|(node, coefficient)| (node, Bits::new(coefficient)))
            .collect();
        self.intern(Node::Sum(Bits::new(constant), terms))
    }

    /// The first number in a node that is infinite or NaN, if any.
    pub(crate) fn not_finite(&self, node: NodeId) -> Option<f64> {
        let is_wrong = |number: &f64| !number.is_finite();
        match self.node(node) {
            Node::Constant(value) => Some(value.get()).filter(is_wrong),
            Node::Sum(constant, terms) => {
                let numbers = terms.iter().map(|(_, coefficient)| coefficient);
                core::iter::once(constant)
                    .chain(numbers)
                    .map(|number| number.get())
                    .find(is_wrong)
            }
            _ => None,
        }
    }

    /// The number that scales a node, and the node without it: `3 x y` is `(3, x y)`. A sum with several terms gives
    /// its smallest coefficient if all are multiples of it, with the sign of its first term.
    pub(crate) fn split(&mut self, node: NodeId) -> (f64, NodeId) {
        match self.node(node) {
            Node::Constant(value) => {
                let value = value.get();
                (value, self.constant(1.0))
            }
            Node::Sum(constant, terms) => {
                if let Some(&known) = self.splits.get(&node) {
                    return known;
                }
                let smallest = terms
                    .iter()
                    .map(|(_, c)| c.get().abs())
                    .fold(f64::INFINITY, f64::min);
                let multiple = |c: &Bits| c.get() % smallest == 0.0;
                let multiples = multiple(constant) && terms.iter().all(|(_, c)| multiple(c));
                let common = if multiples { smallest } else { 1.0 };
                let common = common.copysign(terms[0].1.get());
                let split = if common == 1.0 {
                    (1.0, node)
                } else {
                    let constant = constant.get() / common;
                    let terms: Vec<_> = terms.iter().map(|&(term, c)| (term, c.get() / common)).collect();
                    (common, self.linear(constant, &terms))
                };
                self.splits.insert(node, split);
                split
            }
            _ => (1.0, node),
        }
    }

    /// Whether the constant coefficients of factors may be collected: their product may underflow where that of the factors does not, as
    /// in `((1 + t.cos()) / 2).powi(1500)`.
    fn may_be_split(&mut self, factors: &[(NodeId, i32)]) -> bool {
        let (mut all, mut of_motion) = (0.0, 0.0);
        for &(node, exponent) in factors {
            let magnitude = f64::from(exponent) * self.split(node).0.abs().log10();
            all += magnitude;
            if self.as_constant(node).is_none() {
                of_motion += magnitude;
            }
        }
        // what is too large is infinite and refused
        !(of_motion < LEAST || (of_motion != 0.0 && all < LEAST_OF_ALL))
    }

    /// `Π node^exponent`.
    pub(crate) fn product(&mut self, factors: &[(NodeId, i32)]) -> NodeId {
        let mut coefficient = 1.0_f64;
        let mut collected: Vec<(NodeId, i32)> = Vec::with_capacity(factors.len());
        let are_split = self.may_be_split(factors);
        for &(node, exponent) in factors {
            if exponent == 0 {
                continue;
            }
            let (scale, base) = if are_split || self.as_constant(node).is_some() {
                self.split(node)
            } else {
                (1.0, node)
            };
            if scale != 1.0 {
                coefficient *= scale.powi(exponent);
            }
            match self.node(base) {
                Node::Constant(_) => {}
                Node::Product(inner) => {
                    let inner = inner.iter();
                    collected.extend(
                        inner.map(|&(factor, power)| {
                            (factor, bounded_exponent(power.saturating_mul(exponent)))
                        }),
                    );
                }
                _ => collected.push((base, bounded_exponent(exponent))),
            }
        }
        collect(&mut collected, |power, more| {
            *power = bounded_exponent(power.saturating_add(more));
        });
        collected.retain(|&(_, exponent)| exponent != 0);
        if let Some((scale, factors)) = self.quotients_as_signs(&collected) {
            let product = self.product(&factors);
            return self.scale(coefficient * scale, product);
        }
        let base = match collected[..] {
            [] => return self.constant(coefficient),
            [(node, 1)] => node,
            _ => self.intern(Node::Product(collected)),
        };
        self.scale(coefficient, base)
    }

    pub(crate) fn unary(&mut self, op: Unary, a: NodeId) -> NodeId {
        match self.as_constant(a) {
            Some(value) => self.constant(op.apply(value)),
            None if matches!(op, Unary::Sqrt | Unary::Cbrt) => {
                match self.of_pieces(a, |graph, piece| graph.unary(op, piece)) {
                    Some(pieces) => pieces,
                    None if op == Unary::Sqrt => self.sqrt(a),
                    None => self.intern(Node::Unary(op, a)),
                }
            }
            None if op == Unary::Signum => {
                if let Some(pieces) = self.signum_of_pieces(a) {
                    return pieces;
                }
                let argument = self.of_same_sign(a);
                match self.as_constant(argument) {
                    Some(value) => self.constant(op.apply(value)),
                    None => self.intern(Node::Unary(op, argument)),
                }
            }
            None => self.intern(Node::Unary(op, a)),
        }
    }

    /// An expression as a sum: its terms with their coefficients, and the constant.
    pub(crate) fn terms(&self, a: NodeId) -> (Vec<(NodeId, f64)>, f64) {
        match self.node(a) {
            Node::Sum(constant, terms) => (
                terms.iter().map(|&(term, c)| (term, c.get())).collect(),
                constant.get(),
            ),
            _ => (vec![(a, 1.0)], 0.0),
        }
    }

    /// Whether an expression is visibly a sum of squares, and so never negative.
    pub(crate) fn is_sum_of_squares(&self, id: NodeId) -> bool {
        let (terms, constant) = self.terms(id);
        let is_square = |term: NodeId| self.factors(term).iter().all(|&(_, n)| n % 2 == 0);
        constant >= 0.0 && terms.iter().all(|&(term, c)| c > 0.0 && is_square(term))
    }

    /// Whether an expression is visibly a sum of two or more squares, so that it is zero only where all of
    /// them are.
    pub(crate) fn is_several_squares(&self, id: NodeId) -> bool {
        let (terms, constant) = self.terms(id);
        terms.len() + usize::from(constant != 0.0) > 1 && self.is_sum_of_squares(id)
    }

    /// Whether an expression is visibly a sum of squares and a positive number or the square of a parameter, which has no zero.
    pub(crate) fn is_softened_sum(&self, id: NodeId) -> bool {
        let (terms, constant) = self.terms(id);
        let is_softened = constant != 0.0 || terms.iter().any(|&(term, _)| self.is_fixed(term));
        is_softened && self.is_sum_of_squares(id)
    }

    /// An expression as the factors of a product with their exponents.
    pub(crate) fn factors(&self, a: NodeId) -> Vec<(NodeId, i32)> {
        match self.node(a) {
            Node::Product(factors) => factors.clone(),
            _ => vec![(a, 1)],
        }
    }

    /// The factors of parameters and of the step that all terms share, each with the exponent of least size.
    pub(crate) fn common_factors(&self, terms: &[(NodeId, f64)]) -> Vec<(NodeId, i32)> {
        let early = |&(base, _): &(NodeId, i32)| self.leaves(base).all(|leaf| leaf == Leaf::H);
        let mut common: Option<Vec<(NodeId, i32)>> = None;
        for &(term, _) in terms {
            let factors: Vec<_> = self.factors(term).into_iter().filter(early).collect();
            common = Some(match common {
                None => factors,
                Some(common) => common
                    .into_iter()
                    .filter_map(|(base, n)| {
                        let &(_, m) = factors.iter().find(|&&(other, _)| other == base)?;
                        let least = if n.abs() < m.abs() { n } else { m };
                        (n.signum() == m.signum()).then_some((base, least))
                    })
                    .collect(),
            });
        }
        common.unwrap_or_default()
    }

    pub(crate) fn powf(&mut self, a: NodeId, b: NodeId) -> NodeId {
        if let Some(pieces) = self.of_pieces(a, |graph, piece| graph.powf(piece, b)) {
            return pieces;
        }
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(base), Some(exponent)) => self.constant(base.powf(exponent)),
            (None, Some(exponent)) if exponent.fract() == 0.0 && exponent.abs() <= f64::from(i16::MAX) => {
                #[allow(clippy::cast_possible_truncation)] // an integer of at most 16 bits
                self.powi(a, exponent as i32)
            }
            (None, Some(0.5)) => self.unary(Unary::Sqrt, a),
            _ => self.intern(Node::Powf(a, b)),
        }
    }

    pub(crate) fn atan2(&mut self, y: NodeId, x: NodeId) -> NodeId {
        match (self.as_constant(y), self.as_constant(x)) {
            (Some(y), Some(x)) => self.constant(y.atan2(x)),
            // the angle is ±π/2, by the sign of the ordinate
            (None, Some(0.0)) => {
                let side = self.unary(Unary::Signum, y);
                self.scale(FRAC_PI_2, side)
            }
            _ => self.intern(Node::Atan2(y, x)),
        }
    }

    /// The `else` branch of a comparison of velocities, without a branch that holds at equality alone: `B`
    /// for `if s < 0 { B } else { C }` after `if s > 0 { A }`. At equality a function that jumps with the
    /// velocity may have any value between its two sides (Filippov).
    fn without_instant(&self, op: Comparison, [left, right]: [NodeId; 2], otherwise: NodeId) -> NodeId {
        let is_of_velocity = [left, right]
            .iter()
            .any(|&side| self.leaves(side).any(|leaf| matches!(leaf, Leaf::V(_))));
        match self.node(otherwise) {
            &Node::Select(Comparison::Lt, [l, r, then, _])
                if op == Comparison::Lt && is_of_velocity && [l, r] == [right, left] =>
            {
                then
            }
            _ => otherwise,
        }
    }

    pub(crate) fn select(
        &mut self,
        op: Comparison,
        left: NodeId,
        right: NodeId,
        then: NodeId,
        otherwise: NodeId,
    ) -> NodeId {
        if then == otherwise {
            return then;
        }
        if let Some(pieces) = self.select_by_pieces(op, [left, right], [then, otherwise]) {
            return pieces;
        }
        let (left, right) = match (self.as_constant(left), self.as_constant(right)) {
            (Some(0.0), None) => (left, self.of_same_sign(right)),
            (None, Some(0.0)) => (self.of_same_sign(left), right),
            _ => (left, right),
        };
        let otherwise = self.without_instant(op, [left, right], otherwise);
        if then == otherwise {
            return then;
        }
        if let (Some(l), Some(r)) = (self.as_constant(left), self.as_constant(right)) {
            return if op.holds(l, r) { then } else { otherwise };
        }
        self.intern(Node::Select(op, [left, right, then, otherwise]))
    }

    /// A function of the user's; its derivatives are taken with `num-dual` when the code runs.
    pub(crate) fn call(&mut self, callee: Callee, args: &[NodeId]) -> NodeId {
        let text = match &callee {
            Callee::Function(tokens) => tokens.to_string(),
            Callee::Method(name) => format!(". {name}"),
        };
        let callees = &mut self.callees;
        let callee = *self.callee_texts.entry(text).or_insert_with(|| {
            callees.push(callee);
            callees.len() - 1
        });
        self.intern(Node::Call {
            callee,
            args: args.to_vec(),
            wrt: Vec::new(),
        })
    }

    pub(crate) fn call_partial(&mut self, callee: usize, args: Vec<NodeId>, wrt: Vec<usize>) -> NodeId {
        self.intern(Node::Call { callee, args, wrt })
    }
}

/// An exponent within ±2³⁰: a power beyond is 0, 1 or infinite in double precision.
fn bounded_exponent(exponent: i32) -> i32 {
    const LARGEST: i32 = 1 << 30;
    exponent.clamp(-LARGEST, LARGEST)
}

/// Sorts by node and adds up the entries of the same node, in their order.
pub(crate) fn collect<T: Copy>(collected: &mut Vec<(NodeId, T)>, add: impl Fn(&mut T, T)) {
    // mostly they are in order, each node once
    if collected.is_sorted_by(|a, b| a.0 < b.0) {
        return;
    }
    collected.sort_by_key(|&(node, _)| node);
    collected.dedup_by(|next, first| {
        let same = next.0 == first.0;
        if same {
            add(&mut first.1, next.1);
        }
        same
    });
}
