//! Sums and products of a program: terms with common early factors are gathered, and partial products are
//! shared.

use std::rc::Rc;

use super::{Op, Program, Value};
use crate::graph::{Bits, Node, NodeId, Unary};
use crate::hash::{HashMap, HashSet};
use crate::passes::running::EarlyFactor;
use crate::passes::share::{self, Factor, Product, Shared};

/// The highest power that is written as products; a higher one is a call of `powi`.
const LONGEST_PRODUCT: i32 = 64;

/// A term of a sum: `± early · late`.
#[derive(Clone)]
pub(super) struct Term {
    pub(super) stage: usize,
    pub(super) negative: bool,
    pub(super) early: EarlyFactor,
    pub(super) late: Vec<(NodeId, i32)>,
}

impl Term {
    /// The factors, with or without the early part.
    fn product(&self, with_early: bool) -> Product {
        let mut product: Product = self
            .late
            .iter()
            .map(|&(node, n)| (Factor::Node { node, inverse: n < 0 }, n.unsigned_abs()))
            .collect();
        if with_early && !is_one(&self.early) {
            product.insert(Factor::Early(self.early.0, self.early.1.clone()), 1);
        }
        product
    }
}

/// The late factors that all terms share.
fn common_factors(group: &[Term]) -> Product {
    let mut products = group.iter().map(|term| term.product(false));
    let mut common = products.next().unwrap_or_default();
    for product in products {
        common.retain(|factor, count| {
            *count = product.get(factor).map_or(0, |&present| present.min(*count));
            *count > 0
        });
    }
    common
}

/// A product without some of its factors.
fn without_factors(mut product: Product, factors: &Product) -> Product {
    for (factor, count) in factors {
        if let Some(present) = product.get_mut(factor) {
            *present -= count;
        }
    }
    product.retain(|_, count| *count > 0);
    product
}

pub(super) fn is_one((coefficient, factors): &EarlyFactor) -> bool {
    factors.is_empty() && *coefficient == Bits::new(1.0)
}

impl Program<'_> {
    /// The terms of a sum, or a product as the only term, split into early and late factors.
    pub(super) fn terms(&mut self, terms: &[(NodeId, Bits)]) -> Vec<Term> {
        let (graph, nothing) = (self.graph, Rc::default());
        terms
            .iter()
            .map(|&(node, c)| {
                let stage = self.node_stage(node);
                let (mut late, mut early) = (Vec::new(), Vec::new());
                match graph.node(node) {
                    Node::Product(factors) => {
                        for &(factor, n) in factors {
                            let is_late = self.node_stage(factor) == stage;
                            (if is_late { &mut late } else { &mut early }).push((factor, n));
                        }
                    }
                    _ => late.push((node, 1)),
                }
                let early = if early.is_empty() {
                    Rc::clone(&nothing)
                } else {
                    early.into()
                };
                Term {
                    stage,
                    negative: c.get() < 0.0,
                    early: (Bits::new(c.get().abs()), early),
                    late,
                }
            })
            .collect()
    }

    /// The terms in groups with the same early part, which is multiplied once. Groups come in the order of
    /// their stages, so that each stage adds to the sum of the one before; positive ones first, so that the
    /// sum needs no negation.
    fn groups(&mut self, terms: &[(NodeId, Bits)]) -> Vec<Vec<Term>> {
        let mut groups: Vec<Vec<Term>> = Vec::new();
        let mut places: HashMap<(usize, EarlyFactor), usize> = HashMap::default();
        for term in self.terms(terms) {
            if is_one(&term.early) {
                groups.push(vec![term]);
                continue;
            }
            let place = *places
                .entry((term.stage, term.early.clone()))
                .or_insert(groups.len());
            match groups.get_mut(place) {
                Some(group) => group.push(term),
                None => groups.push(vec![term]),
            }
        }
        for group in &mut groups {
            group.sort_by_key(|term| term.negative);
        }
        groups.sort_by_key(|group| (group[0].stage, group[0].negative));
        groups
    }

    /// Finds the partial products and sums that the expressions share; to be called once, before anything is
    /// lowered.
    pub(crate) fn plan(&mut self, outputs: &[NodeId]) {
        self.plan_running(&self.sums(outputs));
        let mut products = Vec::new();
        let mut seen = HashSet::default();
        let mut planned: HashSet<EarlyFactor> = HashSet::default();
        let mut open = outputs.to_vec();
        while let Some(id) = open.pop() {
            if !seen.insert(id) {
                continue;
            }
            let parts = self.graph.parts(id);
            let terms = match self.graph.node(id) {
                Node::Sum(_, terms) => self.terms_outside_running(id, terms),
                Node::Product(_) => vec![(id, Bits::new(1.0))],
                _ => Vec::new(),
            };
            // a product that is a term of a sum is multiplied there, with its coefficient
            let is_term = |part: &NodeId| matches!(self.graph.node(*part), Node::Product(_));
            let sum = matches!(self.graph.node(id), Node::Sum(..));
            let (inner, others): (Vec<_>, Vec<_>) = parts.into_iter().partition(|part| sum && is_term(part));
            open.extend(others);
            open.extend(inner.iter().flat_map(|&product| self.graph.parts(product)));
            for group in self.groups(&terms) {
                let mut early = group[0].early.clone();
                let common = if group.len() > 1 {
                    common_factors(&group)
                } else {
                    Product::new()
                };
                let mut found = |product: Product| {
                    // a product of one factor shares nothing
                    if share::size(&product) > 1 {
                        products.push(product);
                    }
                };
                for term in &group {
                    found(without_factors(term.product(group.len() == 1), &common));
                }
                found(common);
                while !early.1.is_empty() {
                    if !planned.insert(early.clone()) {
                        break;
                    }
                    let term = self.early_term(&early);
                    found(term.product(true));
                    early = term.early;
                }
            }
        }
        self.shared = Shared::find(products);
    }

    /// The sums in some expressions.
    fn sums(&self, outputs: &[NodeId]) -> Vec<NodeId> {
        let mut sums = self.graph.subexpressions(outputs.iter().copied(), |_| true);
        sums.retain(|&id| matches!(self.graph.node(id), Node::Sum(..)));
        sums
    }

    pub(super) fn lower_sum(&mut self, id: NodeId, constant: Bits, terms: &[(NodeId, Bits)]) -> Value {
        let mut sum = (constant.get() != 0.0).then(|| self.push(Op::Constant(constant)));
        let others = self.terms_outside_running(id, terms);
        let running = self.running.get(&id).cloned().unwrap_or_default();
        // in the order of their stages
        let mut running = running.into_iter().peekable();
        for group in self.groups(&others) {
            while let Some(first) = running.next_if(|running| running.stage <= group[0].stage) {
                let value = self.lower_running(&first.sums);
                sum = Some(self.add(sum, first.sums.negative, value));
            }
            let value = self.lower_group(&group);
            sum = Some(self.add(sum, group[0].negative, value));
        }
        for last in running {
            let value = self.lower_running(&last.sums);
            sum = Some(self.add(sum, last.sums.negative, value));
        }
        match sum {
            Some(sum) => sum,
            None => self.push(Op::Constant(constant)),
        }
    }

    /// A sum, if there is one already, plus one term.
    pub(super) fn add(&mut self, sum: Option<Value>, negative: bool, magnitude: Value) -> Value {
        self.push(match (sum, negative) {
            (None, false) => return magnitude,
            (None, true) => Op::Neg(magnitude),
            (Some(sum), false) => Op::Add(sum, magnitude),
            (Some(sum), true) => Op::Sub(sum, magnitude),
        })
    }

    /// The value of a group of terms, without the sign of the first.
    fn lower_group(&mut self, group: &[Term]) -> Value {
        let negative = group[0].negative;
        if let [term] = group {
            self.lower_term(term)
        } else {
            let common = common_factors(group);
            let mut inner: Option<Value> = None;
            for term in group {
                let product = self.lower_shared(without_factors(term.product(false), &common));
                inner = Some(match inner {
                    None => product,
                    Some(inner) if term.negative == negative => self.push(Op::Add(inner, product)),
                    Some(inner) => self.push(Op::Sub(inner, product)),
                });
            }
            if let (Some(sum), false) = (inner, common.is_empty()) {
                let common = self.lower_shared(common);
                inner = Some(self.push(Op::Mul(common, sum)));
            }
            let early = self.lower_early(&group[0].early);
            match inner {
                Some(inner) => self.push(Op::Mul(early, inner)),
                None => early,
            }
        }
    }

    /// The value of a term, without its sign.
    pub(super) fn lower_term(&mut self, term: &Term) -> Value {
        self.lower_shared(term.product(true))
    }

    pub(super) fn lower_product(&mut self, id: NodeId) -> Value {
        match self.terms(&[(id, Bits::new(1.0))]).pop() {
            Some(term) => self.lower_term(&term),
            None => self.push(Op::Constant(Bits::new(1.0))),
        }
    }

    /// The early part of a term, as a term.
    pub(super) fn early_term(&mut self, (coefficient, factors): &EarlyFactor) -> Term {
        let stage = factors
            .iter()
            .map(|&(factor, _)| self.node_stage(factor))
            .max()
            .unwrap_or(0);
        let (late, early): (Vec<_>, Vec<_>) = factors
            .iter()
            .partition(|&&(factor, _)| self.node_stage(factor) == stage);
        Term {
            stage,
            negative: false,
            early: (*coefficient, early.into()),
            late,
        }
    }

    pub(super) fn lower_early(&mut self, early: &EarlyFactor) -> Value {
        if early.1.is_empty() {
            return self.push(Op::Constant(early.0));
        }
        if let Some(&value) = self.early.get(early) {
            return value;
        }
        let term = self.early_term(early);
        let value = self.lower_term(&term);
        self.early.insert(early.clone(), value);
        value
    }

    /// A product of factors and shared parts, earlier factors first.
    fn lower_shared(&mut self, product: Product) -> Value {
        let shared = self.shared.searched(&product).cloned();
        self.lower_factors(&shared.unwrap_or(product))
    }

    fn lower_factors(&mut self, product: &Product) -> Value {
        let mut powers: Vec<(usize, bool, Value)> = Vec::new();
        for (factor, &count) in product {
            let count = i32::try_from(count).unwrap_or(i32::MAX);
            let (inverse, power) = match factor {
                Factor::Node { node, inverse } => {
                    let base = self.lower(*node);
                    (*inverse, self.power(base, if *inverse { -count } else { count }))
                }
                Factor::Early(coefficient, factors) => {
                    let base = self.lower_early(&(*coefficient, factors.clone()));
                    (false, self.power(base, count))
                }
                Factor::Part(place) => {
                    let base = self.lower_part(*place);
                    (false, self.power(base, count))
                }
            };
            powers.push((self.stage(power), inverse, power));
        }
        // reciprocals last: a single one becomes a division
        powers.sort_unstable();
        let mut result: Option<Value> = None;
        for (_, _, power) in powers {
            result = Some(match result {
                None => power,
                Some(result) => self.push(Op::Mul(result, power)),
            });
        }
        match result {
            Some(result) => result,
            None => self.push(Op::Constant(Bits::new(1.0))),
        }
    }

    /// A shared part, which may contain others.
    fn lower_part(&mut self, place: usize) -> Value {
        if let Some(&value) = self.parts.get(&place) {
            return value;
        }
        let part = self.shared.part(place);
        let value = self.lower_factors(&part);
        self.parts.insert(place, value);
        value
    }

    fn power(&mut self, base: Value, n: i32) -> Value {
        if let (true, &Op::Unary(Unary::Sqrt, square)) = (n < 0, self.op(base)) {
            // with r = sqrt(s), 1/r = r (1/s): the reciprocal need not wait for the root
            let inverse = self.push(Op::Recip(square));
            let mut power = if n % 2 == 0 {
                inverse
            } else {
                self.push(Op::Mul(base, inverse))
            };
            for _ in 0..(-n - 1) / 2 {
                power = self.push(Op::Mul(power, inverse));
            }
            return power;
        }
        if n < 0 {
            let inverse = self.push(Op::Recip(base));
            return self.power(inverse, -n);
        }
        if let (2.., &Op::Unary(Unary::Sqrt, square)) = (n, self.op(base)) {
            // r² is known before r
            let even = self.power(square, n / 2);
            return if n % 2 == 0 {
                even
            } else {
                self.push(Op::Mul(base, even))
            };
        }
        if n > LONGEST_PRODUCT {
            return self.push(Op::Powi(base, n));
        }
        match n {
            0 => self.push(Op::Constant(Bits::new(1.0))),
            1 => base,
            _ => {
                let half = self.power(base, n / 2);
                let square = self.push(Op::Mul(half, half));
                if n % 2 == 0 {
                    square
                } else {
                    self.push(Op::Mul(square, base))
                }
            }
        }
    }
}
