//! Expressions multiplied out, as polynomials in their moving factors.

use std::collections::BTreeMap;
use std::rc::Rc;

use crate::graph::{Graph, Node, NodeId, collect};
use crate::hash::HashMap;
use crate::mistakes::limits;

/// The most terms of a product that is multiplied out.
pub(super) const MOST_TERMS: usize = 20_000;

/// Moving factors and their exponents.
pub(crate) type Monomial = Vec<(NodeId, i32)>;
/// Monomials and their constant coefficients.
pub(crate) type Polynomial = BTreeMap<Monomial, NodeId>;

/// Splits a sum that is kept as one factor, not multiplied out, into its constant coefficient and the remaining factor.
type AsFactor = fn(&mut Graph, NodeId) -> Option<[NodeId; 2]>;

/// Multiplies expressions out, each once.
pub(crate) struct Expansion {
    /// The most terms of an expression.
    most_terms: usize,
    /// The highest power of a sum that is multiplied out.
    highest_power: i32,
    as_factor: AsFactor,
    known: HashMap<NodeId, Option<Rc<Polynomial>>>,
}

impl Default for Expansion {
    /// An expansion of all sums, also in low powers.
    fn default() -> Self {
        Self::new(MOST_TERMS, 4, |_, _| None)
    }
}

impl Expansion {
    /// An expansion into so many terms at most, of powers of sums up to this one.
    pub(super) fn new(most_terms: usize, highest_power: i32, as_factor: AsFactor) -> Self {
        Self {
            most_terms,
            highest_power,
            as_factor,
            known: HashMap::default(),
        }
    }

    /// An expression multiplied out; `None` if it has too many terms.
    pub(crate) fn polynomial(&mut self, graph: &mut Graph, id: NodeId) -> Option<Rc<Polynomial>> {
        if let Some(known) = self.known.get(&id) {
            return known.clone();
        }
        let result = self
            .expand(graph, id)
            .filter(|polynomial| polynomial.len() <= self.most_terms)
            .map(Rc::new);
        self.known.insert(id, result.clone());
        result
    }

    fn expand(&mut self, graph: &mut Graph, id: NodeId) -> Option<Polynomial> {
        let one = graph.constant(1.0);
        if graph.is_fixed(id) {
            return Some(Polynomial::from([(Vec::new(), id)]));
        }
        match &*graph.shared_node(id) {
            Node::Sum(constant, terms) => {
                if let Some([coefficient, factor]) = (self.as_factor)(graph, id) {
                    return Some(Polynomial::from([(vec![(factor, 1)], coefficient)]));
                }
                let mut sum = Polynomial::new();
                if constant.get() != 0.0 {
                    sum.insert(Vec::new(), graph.constant(constant.get()));
                }
                for &(term, c) in terms {
                    for (monomial, &coefficient) in &*self.polynomial(graph, term)? {
                        let coefficient = graph.scale(c.get(), coefficient);
                        add(graph, &mut sum, monomial, coefficient);
                    }
                }
                Some(sum)
            }
            Node::Product(factors) => {
                let mut product = Polynomial::from([(Vec::new(), one)]);
                for &(factor, exponent) in factors {
                    let is_sum = matches!(graph.node(factor), Node::Sum(..));
                    let (factor, times) = if graph.is_fixed(factor) {
                        (single(Vec::new(), graph.powi(factor, exponent)), 1)
                    } else if is_sum && (0..=self.highest_power).contains(&exponent) {
                        (self.polynomial(graph, factor)?, exponent)
                    } else {
                        (single(vec![(factor, exponent)], one), 1)
                    };
                    for _ in 0..times {
                        product = multiply(graph, &product, &factor)?;
                    }
                }
                Some(product)
            }
            _ => Some(Polynomial::from([(vec![(id, 1)], one)])),
        }
    }
}

/// A polynomial of one term.
pub(crate) fn single(monomial: Monomial, coefficient: NodeId) -> Rc<Polynomial> {
    Rc::new(Polynomial::from([(monomial, coefficient)]))
}

/// Adds a term to a polynomial.
pub(crate) fn add(
    graph: &mut Graph,
    polynomial: &mut Polynomial,
    monomial: &[(NodeId, i32)],
    coefficient: NodeId,
) {
    let Some(present) = polynomial.get_mut(monomial) else {
        if !graph.vanishes(coefficient) {
            polynomial.insert(monomial.to_vec(), coefficient);
        }
        return;
    };
    let sum = graph.add(*present, coefficient);
    *present = sum;
    if graph.vanishes(sum) {
        polynomial.remove(monomial);
    }
}

pub(crate) fn multiply(graph: &mut Graph, a: &Polynomial, b: &Polynomial) -> Option<Polynomial> {
    if a.len() * b.len() > MOST_TERMS {
        return None;
    }
    limits::spend(a.len() * b.len());
    let mut product = BTreeMap::new();
    let mut monomial = Monomial::new();
    for (first, &c) in a {
        for (second, &d) in b {
            monomial.clear();
            monomial.extend(first.iter().chain(second));
            collect(&mut monomial, |exponent, more| *exponent += more);
            monomial.retain(|&(_, exponent)| exponent != 0);
            let coefficient = graph.mul(c, d);
            add(graph, &mut product, &monomial, coefficient);
        }
    }
    Some(product)
}
