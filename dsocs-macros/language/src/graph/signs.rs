//! Signs, absolute values and square roots in a form with derivatives and few digits lost.

#![allow(clippy::float_cmp)] // exact squares and ones

use super::{Graph, Node, NodeId, Unary};

impl Graph {
    /// A product with `s/|s|` or `|s|/s` replaced by a sign: the number and the factors; `None` if there is
    /// no such quotient.
    pub(super) fn quotients_as_signs(
        &mut self,
        factors: &[(NodeId, i32)],
    ) -> Option<(f64, Vec<(NodeId, i32)>)> {
        factors.iter().enumerate().find_map(|(place, &(size, power))| {
            let &Node::Unary(Unary::Abs, argument) = self.node(size) else {
                return None;
            };
            let mut others = factors.iter().enumerate();
            let (other, ratio) = others.find_map(|(other, &(factor, n))| {
                let is_across = (n < 0) != (power < 0);
                Some((other, is_across.then(|| self.ratio(factor, argument))??))
            })?;
            let common = power.abs().min(factors[other].1.abs());
            let mut factors = factors.to_vec();
            factors[place].1 -= common * power.signum();
            factors[other].1 += common * power.signum();
            if common % 2 != 0 {
                factors.push((self.unary(Unary::Signum, argument), 1));
            }
            Some((ratio.powi(-common * power.signum()), factors))
        })
    }

    /// The number `c` with `a = c b`, if the terms of both show it.
    pub(super) fn ratio(&self, a: NodeId, b: NodeId) -> Option<f64> {
        if a == b {
            return Some(1.0);
        }
        let ((terms, constant), (others, other)) = (self.terms(a), self.terms(b));
        let ratio = terms.first()?.1 / others.first()?.1;
        let fits = |c: f64, other: f64| (c - ratio * other).abs() <= 4.0 * f64::EPSILON * c.abs();
        let mut both = terms.iter().zip(&others);
        let fit = both.all(|((term, c), (same, other))| term == same && fits(*c, *other));
        (terms.len() == others.len() && fit && fits(constant, other)).then_some(ratio)
    }

    /// A simpler expression of the same sign: `s` for `s³`, `|s| s` and `∛s`. At a multiple root, or where a derivative is infinite, the sign
    /// of the expression itself is accurate to few digits only.
    pub(super) fn of_same_sign(&mut self, a: NodeId) -> NodeId {
        let (terms, constant) = self.terms(a);
        let &[(term, c)] = &terms[..] else {
            return a;
        };
        if constant != 0.0 {
            return a;
        }
        let factors = self.factors(term);
        let mut signs = Vec::with_capacity(factors.len());
        for &(factor, n) in &factors {
            // a fixed factor is kept: where it is zero, it is zero throughout the run
            if self.is_fixed(factor) {
                signs.push((factor, n));
                continue;
            }
            let argument = match *self.node(factor) {
                Node::Unary(Unary::Abs | Unary::Sqrt | Unary::Exp | Unary::Cosh, _) => continue,
                Node::Unary(
                    Unary::Cbrt | Unary::Sinh | Unary::Tanh | Unary::Atan | Unary::Asin,
                    argument,
                ) => self.of_same_sign(argument),
                _ => factor,
            };
            if n % 2 != 0 {
                signs.push((argument, 1));
            }
        }
        if signs == factors {
            return a;
        }
        let product = self.product(&signs);
        self.scale(c, product)
    }

    /// A square root with the squares of parameters and of the step taken out that all terms of its argument
    /// share: `√(x²/4h² + y²/4h²)` is `√(x² + y²)/2|h|`. Of a single term all squares are taken out: `√x²` is
    /// `|x|`, which has a derivative wherever it is not zero.
    pub(super) fn sqrt(&mut self, a: NodeId) -> NodeId {
        let (terms, constant) = self.terms(a);
        let common = match terms.as_slice() {
            _ if constant != 0.0 => Vec::new(),
            &[(term, _)] => self.factors(term),
            terms => self.common_factors(terms),
        };
        let size = terms[0].1.abs();
        let root = size.sqrt();
        let exact = constant == 0.0 && root * root == size && terms.iter().all(|&(_, c)| c.abs() == size);
        let root = if exact { root } else { 1.0 };
        let squares: Vec<_> = common
            .into_iter()
            .map(|(base, n)| (base, n / 2))
            .filter(|&(_, n)| n != 0)
            .collect();
        if root == 1.0 && squares.is_empty() {
            return self.intern(Node::Unary(Unary::Sqrt, a));
        }
        let inverse: Vec<_> = squares.iter().map(|&(base, n)| (base, -2 * n)).collect();
        let inverse = self.product(&inverse);
        let rest: Vec<_> = terms
            .iter()
            .map(|&(term, c)| (self.mul(term, inverse), c / (root * root)))
            .collect();
        let rest = self.linear(constant, &rest);
        let mut factors = vec![(self.unary(Unary::Sqrt, rest), 1)];
        for (base, n) in squares {
            // an even power needs no absolute value
            let base = if n % 2 == 0 {
                base
            } else {
                self.unary(Unary::Abs, base)
            };
            factors.push((base, n));
        }
        let product = self.product(&factors);
        self.scale(root, product)
    }
}
