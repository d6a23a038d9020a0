//! From the expression graph to sequences of Taylor coefficients.

use core::f64::consts::FRAC_PI_2;
use std::collections::BTreeSet;

use super::running::Sums;
use super::sequence::{Argument, Bound, Constant, Op, Sequence, Sequences};
use super::switches::HIGH;
use crate::graph::{Comparison, Graph, Node, NodeId, Unary};
use crate::hash::HashMap;
use crate::mechanics::Ranges;
use crate::passes::share::{Factor, Product, Shared};

/// The lowering of expressions to sequences, each expression once.
pub(crate) struct Lower<'g> {
    pub(crate) graph: &'g mut Graph,
    pub(crate) sequences: Sequences,
    done: HashMap<NodeId, Sequence>,
    pub(super) pairs: HashMap<(Sequence, bool), [Sequence; 2]>,
    pub(super) tangents: HashMap<(Sequence, bool), Sequence>,
    products: HashMap<Product, Sequence>,
    shared: Shared,
    pub(crate) sums: Sums,
    ranges: Ranges,
}

impl<'g> Lower<'g> {
    /// A lowering in which the expressions share products and running sums.
    pub(crate) fn new(graph: &'g mut Graph, outputs: &[NodeId]) -> Self {
        let sums = Sums::find(graph, outputs);
        Self {
            sums,
            ..Self::term_by_term(graph, outputs)
        }
    }

    /// A lowering in which the expressions share products, but no sums.
    fn term_by_term(graph: &'g mut Graph, outputs: &[NodeId]) -> Self {
        let products = products(graph, outputs);
        Self {
            graph,
            sequences: Sequences::default(),
            done: HashMap::default(),
            pairs: HashMap::default(),
            tangents: HashMap::default(),
            products: HashMap::default(),
            shared: Shared::find(products),
            sums: Sums::default(),
            ranges: Ranges::default(),
        }
    }

    /// The number of products of sequences in some expressions, not counting functions.
    pub(crate) fn cost(graph: &mut Graph, outputs: &[NodeId]) -> usize {
        let mut lower = Lower::term_by_term(graph, outputs);
        for &output in outputs {
            lower.lower(output);
        }
        let product = |op: &Op| {
            matches!(
                op,
                Op::Product(..) | Op::Square(_) | Op::Quotient(..) | Op::Reciprocal(_)
            )
        };
        lower.sequences.ops().filter(|(_, op)| product(op)).count()
    }

    /// The sequence of an expression.
    pub(crate) fn lower(&mut self, id: NodeId) -> Sequence {
        if let Some(&done) = self.done.get(&id) {
            return done;
        }
        let sequence = if self.graph.is_fixed(id) {
            self.sequences.push(Op::Constant(id))
        } else {
            self.varying(id)
        };
        self.done.insert(id, sequence);
        sequence
    }

    fn varying(&mut self, id: NodeId) -> Sequence {
        match self.graph.node(id).clone() {
            Node::Constant(_) | Node::Param(_) => self.sequences.push(Op::Constant(id)),
            Node::Leaf(leaf) => self.sequences.push(Op::Leaf(leaf)),
            Node::Sum(constant, terms) => {
                let terms: Vec<_> = terms.iter().map(|&(term, c)| (term, c.get())).collect();
                let running = self.running(id).unwrap_or_default();
                self.sum(constant.get(), &terms, running)
            }
            Node::Product(_) => self.sum(0.0, &[(id, 1.0)], Vec::new()),
            Node::Unary(op, node) => {
                let a = self.lower(node);
                match op {
                    Unary::Abs | Unary::Signum => self.sequences.switch(Argument::Sign(a), vec![node]),
                    Unary::Tanh | Unary::Exp | Unary::ExpM1 | Unary::Sinh | Unary::Cosh => {
                        self.sequences.switch(Argument::Steep(a), vec![node]);
                    }
                    _ => {}
                }
                let value = self.unary(op, a);
                match op {
                    Unary::Sqrt if self.may_touch(node) => self.watch_bound(value, Bound::Zero),
                    Unary::Atan => self.watch_bound(value, Bound::Quarter),
                    _ => {}
                }
                value
            }
            Node::Powf(base, exponent) => self.powf(base, exponent),
            Node::Atan2(y, x) if self.graph.is_fixed(x) && self.graph.as_constant(x).is_none() => {
                self.angle_of_fixed_abscissa(y, x)
            }
            Node::Atan2(y, x) => self.angle(y, x),
            Node::Select(op, nodes) => {
                let parts = nodes.map(|part| self.lower(part));
                let difference = Argument::Difference(parts[0], parts[1]);
                self.sequences.switch(difference, nodes[..2].to_vec());
                self.sequences.push(Op::Select(op, parts))
            }
            Node::Call { callee, args, wrt } => {
                let args = args.into_iter().map(|arg| self.lower(arg)).collect();
                self.sequences.push(Op::Call { callee, args, wrt })
            }
        }
    }

    /// The angle `atan2(y, x)`.
    fn angle(&mut self, y: NodeId, x: NodeId) -> Sequence {
        let radius = [self.graph.powi(x, 2), self.graph.powi(y, 2)];
        let radius = self.graph.sum(&radius);
        let (y, x) = (self.lower(y), self.lower(x));
        let radius = self.lower(radius);
        let angle = self.sequences.push(Op::Atan2(y, x, radius));
        self.watch_bound(angle, Bound::Half);
        angle
    }

    /// The angle of a point whose abscissa depends on the parameters alone. If they make it zero, the angle
    /// is ±π/2 by the sign of the ordinate, which the series of the angle cannot give.
    fn angle_of_fixed_abscissa(&mut self, y: NodeId, x: NodeId) -> Sequence {
        let [none, one] = [0.0, 1.0].map(|value| self.graph.constant(value));
        let size = self.graph.unary(Unary::Abs, x);
        let is_zero = self.graph.select(Comparison::Le, size, none, one, none);
        let is_other = self.graph.sub(one, is_zero);
        let abscissa = self.graph.add(x, is_zero);
        let angle = self.angle(y, abscissa);
        // 1 where the abscissa is not zero, so that its sign is constant there
        let ordinate = self.graph.mul(is_zero, y);
        let ordinate = self.graph.add(ordinate, is_other);
        let side = self.graph.unary(Unary::Signum, ordinate);
        let side = self.lower(side);
        let quarter = self.graph.scale(FRAC_PI_2, is_zero);
        self.sequences
            .push(Op::Linear(None, vec![(quarter, side), (is_other, angle)]))
    }

    /// `constant + Σ coefficient · term`, where constant factors of terms join their coefficients. `running`,
    /// if it is not empty, replaces all terms that move.
    fn sum(
        &mut self,
        constant: f64,
        terms: &[(NodeId, f64)],
        running: Vec<(Constant, Sequence)>,
    ) -> Sequence {
        let mut constants = vec![(self.graph.constant(constant), 1.0)];
        let runs = !running.is_empty();
        let mut linear = running;
        for &(term, c) in terms {
            if self.graph.is_fixed(term) {
                constants.push((term, c));
                continue;
            }
            if runs {
                continue;
            }
            let (fixed, moving) = split(self.graph, term);
            let coefficient = self.graph.product(&fixed);
            let coefficient = self.graph.scale(c, coefficient);
            let sequence = self.product(&moving);
            match linear.iter_mut().find(|(_, present)| *present == sequence) {
                Some((present, _)) => *present = self.graph.add(*present, coefficient),
                None => linear.push((coefficient, sequence)),
            }
        }
        let constant = self.graph.linear(0.0, &constants);
        let constant = (!self.graph.is_zero(constant)).then_some(constant);
        match (constant, linear.as_slice()) {
            (None, &[(coefficient, sequence)]) if self.graph.as_constant(coefficient) == Some(1.0) => {
                sequence
            }
            _ => self.sequences.push(Op::Linear(constant, linear)),
        }
    }

    /// A product of moving factors.
    pub(crate) fn product(&mut self, factors: &[(NodeId, i32)]) -> Sequence {
        if let &[(factor, 1)] = factors {
            return self.lower(factor);
        }
        for (base, exponent) in self.powers(factors) {
            self.watch_high(base, exponent);
        }
        let product = self.shared.product(as_product(factors));
        self.shared_product(&product)
    }

    fn shared_product(&mut self, product: &Product) -> Sequence {
        if let Some(&done) = self.products.get(product) {
            return done;
        }
        let (mut above, mut below) = (None, None);
        for (factor, &count) in product {
            let (sequence, inverse) = match factor {
                Factor::Node { node, inverse } => {
                    let sequence = self.lower(*node);
                    let may_change = *inverse && !count.is_multiple_of(2);
                    if may_change && !self.ranges.have_one_sign(self.graph, *node) {
                        self.sequences.add_divisor(sequence);
                    }
                    (sequence, *inverse)
                }
                Factor::Part(place) => {
                    let part = self.shared.part(*place);
                    (self.shared_product(&part), false)
                }
                // constant factors have been taken out before
                Factor::Early(..) => continue,
            };
            let power = self.power(sequence, count);
            let side = if inverse { &mut below } else { &mut above };
            *side = Some(match *side {
                None => power,
                Some(before) => self.times(before, power),
            });
        }
        let sequence = match (above, below) {
            (Some(above), Some(below)) => self.sequences.push(Op::Quotient(above, below)),
            (None, Some(below)) => self.sequences.push(Op::Reciprocal(below)),
            (Some(above), None) => above,
            (None, None) => {
                let one = self.graph.constant(1.0);
                self.sequences.push(Op::Constant(one))
            }
        };
        self.products.insert(product.clone(), sequence);
        sequence
    }

    fn power(&mut self, base: Sequence, n: u32) -> Sequence {
        match n {
            0 | 1 => base,
            _ => {
                let half = self.power(base, n / 2);
                let square = self.times(half, half);
                if n.is_multiple_of(2) {
                    square
                } else {
                    self.times(square, base)
                }
            }
        }
    }

    fn times(&mut self, a: Sequence, b: Sequence) -> Sequence {
        self.sequences.push(if a == b {
            Op::Square(a)
        } else {
            Op::Product(a.min(b), a.max(b))
        })
    }

    fn powf(&mut self, base: NodeId, exponent: NodeId) -> Sequence {
        if self.graph.is_fixed(exponent) {
            let node = base;
            let base = self.lower(node);
            match self.graph.as_constant(exponent) {
                Some(exponent) => {
                    let (root, inner) = self.base(node);
                    self.watch_high(root, inner * exponent);
                }
                // a parameter may give the exponent any value
                None => self.watch_divisor(node, HIGH),
            }
            let power = self.sequences.push(Op::Power(base, exponent));
            if let Some(exponent) = self.graph.as_constant(exponent) {
                self.watch_root(node, exponent);
            }
            return power;
        }
        let log = self.graph.unary(Unary::Ln, base);
        let product = self.graph.mul(log, exponent);
        let product = self.lower(product);
        self.sequences.switch(Argument::Steep(product), Vec::new());
        self.sequences.push(Op::Exp(product))
    }
}

/// Factors and their exponents.
type Factors = Vec<(NodeId, i32)>;

/// The constant and the moving factors of a term.
pub(crate) fn split(graph: &Graph, term: NodeId) -> (Factors, Factors) {
    let factors = match graph.node(term) {
        Node::Product(factors) => factors.clone(),
        _ => vec![(term, 1)],
    };
    factors
        .into_iter()
        .partition(|&(factor, _)| graph.is_fixed(factor))
}

fn as_product(factors: &[(NodeId, i32)]) -> Product {
    let mut product = Product::new();
    for &(node, n) in factors {
        product.insert(Factor::Node { node, inverse: n < 0 }, n.unsigned_abs());
    }
    product
}

/// All products of moving factors in some expressions.
fn products(graph: &Graph, outputs: &[NodeId]) -> BTreeSet<Product> {
    let all = graph.subexpressions(outputs.iter().copied(), |id| !graph.is_fixed(id));
    all.into_iter()
        .filter(|&id| matches!(graph.node(id), Node::Product(_)))
        .map(|id| as_product(&split(graph, id).1))
        .collect()
}
