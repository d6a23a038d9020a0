//! From the expression graph to straight-line code.
//!
//! A [`Program`] holds the operations of several functions, each operation once, with the *stage* at which it
//! can be computed. The early factors of a sum or product are gathered into a partial result of its own, so
//! that later stages have as little to do as possible. The caller defines the stages; see [`super::stages`].

mod place;
mod running;
mod schedule;
mod tape;
mod write;

pub(crate) use place::Place;
pub(crate) use tape::{Calls, Segment, number};

use std::collections::BTreeSet;
use std::rc::Rc;

use crate::graph::{Bits, Comparison, Graph, Leaf, Node, NodeId, Unary};
use crate::hash::{HashMap, HashSet};
use crate::passes::running::EarlyFactor;
use crate::passes::share::{self, Factor, Product, Shared};

/// An operation of a [`Program`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct Value(u32);

impl Value {
    fn index(self) -> usize {
        self.0 as usize
    }
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
enum Op {
    Constant(Bits),
    Leaf(Leaf),
    Param(usize),
    Neg(Value),
    Add(Value, Value),
    Sub(Value, Value),
    Mul(Value, Value),
    Recip(Value),
    Powi(Value, i32),
    Unary(Unary, Value),
    Powf(Value, Value),
    Atan2(Value, Value),
    Select(Comparison, [Value; 4]),
    Call {
        callee: usize,
        args: Vec<Value>,
        wrt: Vec<usize>,
    },
}

impl Op {
    fn parts(&self) -> Vec<Value> {
        let mut parts = Vec::new();
        self.for_parts(|part| parts.push(part));
        parts
    }

    /// Calls a function with each operand.
    fn for_parts(&self, mut with: impl FnMut(Value)) {
        match self {
            Self::Constant(_) | Self::Leaf(_) | Self::Param(_) => {}
            Self::Neg(a) | Self::Recip(a) | Self::Powi(a, _) | Self::Unary(_, a) => with(*a),
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Powf(a, b) | Self::Atan2(a, b) => {
                with(*a);
                with(*b);
            }
            Self::Select(_, parts) => parts.iter().copied().for_each(with),
            Self::Call { args, .. } => args.iter().copied().for_each(with),
        }
    }
}

/// The array and the index of a value that another method has computed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Stored {
    /// In `constants`, computed once a run.
    Constants(usize),
    /// In `known`, computed once a step.
    Known(usize),
}

/// Values that other methods have computed, and where they are stored.
pub(crate) type Given = HashMap<Value, Stored>;

/// The highest power that is written as products; a higher one is a call of `powi`.
const LONGEST_PRODUCT: i32 = 64;

/// Operations, each with the stage at which it can be computed.
pub(crate) struct Program<'g> {
    graph: &'g Graph,
    stage_of: fn(Leaf) -> usize,
    ops: Vec<Op>,
    stages: Vec<usize>,
    known: HashMap<Op, Value>,
    lowered: HashMap<NodeId, Value>,
    /// The stage at which nodes with a set of leaves are known.
    set_stages: HashMap<usize, usize>,
    shared: Shared,
    /// The shared parts that have been lowered.
    parts: HashMap<usize, Value>,
    /// The early parts of terms that have been lowered.
    early: HashMap<EarlyFactor, Value>,
    /// The parts of a sum that are computed as running sums; see [`running`].
    running: HashMap<NodeId, Vec<Rc<running::Running>>>,
    running_parts: Shared,
    /// The shared partial sums that have been lowered.
    running_values: HashMap<usize, Value>,
}

/// A term of a sum: `± early · late`.
#[derive(Clone)]
struct Term {
    stage: usize,
    negative: bool,
    early: EarlyFactor,
    late: Vec<(NodeId, i32)>,
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

fn is_one((coefficient, factors): &EarlyFactor) -> bool {
    factors.is_empty() && *coefficient == Bits::new(1.0)
}

impl<'g> Program<'g> {
    /// The number of operations.
    pub(crate) fn operations(&self) -> usize {
        self.ops.len()
    }

    /// An empty program; `stage_of` is the stage at which a leaf is known. Numbers and parameters are known
    /// at stage 0.
    pub(crate) fn new(graph: &'g Graph, stage_of: fn(Leaf) -> usize) -> Self {
        Self {
            graph,
            stage_of,
            ops: Vec::new(),
            stages: Vec::new(),
            known: HashMap::default(),
            lowered: HashMap::default(),
            set_stages: HashMap::default(),
            shared: Shared::default(),
            parts: HashMap::default(),
            early: HashMap::default(),
            running: HashMap::default(),
            running_parts: Shared::default(),
            running_values: HashMap::default(),
        }
    }

    /// The operation that computes a node.
    pub(crate) fn lower(&mut self, id: NodeId) -> Value {
        if let Some(&value) = self.lowered.get(&id) {
            return value;
        }
        let graph = self.graph;
        let value = match *graph.node(id) {
            Node::Constant(bits) => self.push(Op::Constant(bits)),
            Node::Leaf(leaf) => self.push(Op::Leaf(leaf)),
            Node::Param(param) => self.push(Op::Param(param)),
            Node::Sum(constant, ref terms) => self.lower_sum(id, constant, terms),
            Node::Product(_) => self.lower_product(id),
            Node::Unary(op, a) => {
                let a = self.lower(a);
                self.push(Op::Unary(op, a))
            }
            Node::Powf(a, b) => {
                let (a, b) = (self.lower(a), self.lower(b));
                self.push(Op::Powf(a, b))
            }
            Node::Atan2(y, x) => {
                let (y, x) = (self.lower(y), self.lower(x));
                self.push(Op::Atan2(y, x))
            }
            Node::Select(op, parts) => {
                let parts = parts.map(|part| self.lower(part));
                self.push(Op::Select(op, parts))
            }
            Node::Call {
                callee,
                ref args,
                ref wrt,
            } => {
                let args = args.iter().map(|&arg| self.lower(arg)).collect();
                let wrt = wrt.clone();
                self.push(Op::Call { callee, args, wrt })
            }
        };
        self.lowered.insert(id, value);
        value
    }

    /// The stage at which a value is known.
    pub(crate) fn stage(&self, value: Value) -> usize {
        self.stages[value.0 as usize]
    }

    /// Whether a value is the number 1.
    pub(crate) fn is_one(&self, value: Value) -> bool {
        matches!(self.op(value), Op::Constant(bits) if *bits == Bits::new(1.0))
    }

    fn op(&self, value: Value) -> &Op {
        &self.ops[value.0 as usize]
    }

    /// All values, in order.
    fn values(&self) -> impl Iterator<Item = Value> + use<> {
        let count = u32::try_from(self.ops.len()).unwrap_or(u32::MAX);
        (0..count).map(Value)
    }

    fn push(&mut self, op: Op) -> Value {
        if let Some(&value) = self.known.get(&op) {
            return value;
        }
        let mut stage = match &op {
            Op::Leaf(leaf) => (self.stage_of)(*leaf),
            _ => 0,
        };
        op.for_parts(|part| stage = stage.max(self.stage(part)));
        let value = Value(u32::try_from(self.ops.len()).unwrap_or(u32::MAX));
        self.ops.push(op.clone());
        self.stages.push(stage);
        self.known.insert(op, value);
        value
    }

    fn node_stage(&mut self, id: NodeId) -> usize {
        let (graph, stage_of) = (self.graph, self.stage_of);
        let stage = || graph.leaves(id).map(stage_of).max().unwrap_or(0);
        *self.set_stages.entry(graph.leaf_set(id)).or_insert_with(stage)
    }

    /// The terms of a sum, or a product as the only term, split into early and late factors.
    fn terms(&mut self, terms: &[(NodeId, Bits)]) -> Vec<Term> {
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

    fn lower_sum(&mut self, id: NodeId, constant: Bits, terms: &[(NodeId, Bits)]) -> Value {
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
    fn add(&mut self, sum: Option<Value>, negative: bool, magnitude: Value) -> Value {
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
    fn lower_term(&mut self, term: &Term) -> Value {
        self.lower_shared(term.product(true))
    }

    fn lower_product(&mut self, id: NodeId) -> Value {
        match self.terms(&[(id, Bits::new(1.0))]).pop() {
            Some(term) => self.lower_term(&term),
            None => self.push(Op::Constant(Bits::new(1.0))),
        }
    }

    /// The early part of a term, as a term.
    fn early_term(&mut self, (coefficient, factors): &EarlyFactor) -> Term {
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

    fn lower_early(&mut self, early: &EarlyFactor) -> Value {
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

    /// The values that depend on the parameters alone and that the computation of `outputs` uses directly.
    /// Numbers are not among them.
    pub(crate) fn fixed_frontier(&self, outputs: &[Value]) -> BTreeSet<Value> {
        // operands come before the operations that use them
        let mut fixed: Vec<bool> = Vec::with_capacity(self.ops.len());
        for op in &self.ops {
            let mut is_fixed = !matches!(op, Op::Leaf(_));
            op.for_parts(|part| is_fixed &= fixed[part.index()]);
            fixed.push(is_fixed);
        }
        let mut frontier = BTreeSet::new();
        let mut seen = vec![false; self.ops.len()];
        let mut open: Vec<Value> = outputs.to_vec();
        while let Some(value) = open.pop() {
            if std::mem::replace(&mut seen[value.index()], true) || matches!(self.op(value), Op::Constant(_))
            {
                continue;
            }
            if fixed[value.index()] {
                frontier.insert(value);
            } else {
                self.op(value).for_parts(|part| open.push(part));
            }
        }
        frontier
    }

    /// The values of stage `stage` or earlier that the computation of `outputs` uses directly: they are
    /// outputs, or operands of later operations. Numbers are not among them. Values in `given` need not be
    /// computed.
    pub(crate) fn frontier(
        &self,
        outputs: &[Value],
        stage: usize,
        given: &BTreeSet<Value>,
    ) -> BTreeSet<Value> {
        let mut frontier = BTreeSet::new();
        let mut seen = vec![false; self.ops.len()];
        let mut open: Vec<Value> = outputs.to_vec();
        while let Some(value) = open.pop() {
            if std::mem::replace(&mut seen[value.index()], true) || matches!(self.op(value), Op::Constant(_))
            {
                continue;
            }
            if self.stage(value) <= stage {
                frontier.insert(value);
            } else if !given.contains(&value) {
                self.op(value).for_parts(|part| open.push(part));
            }
        }
        frontier
    }
}
