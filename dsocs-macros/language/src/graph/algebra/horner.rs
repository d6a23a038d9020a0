//! Rows of many products, multiplied out and gathered again.
//!
//! The equations of a chain of `n` links have of the order of `n²` products of two functions of different
//! links, most of which cancel or share a factor: `Σ_j m_ij (cᵢ cⱼ aⱼ + sᵢ sⱼ aⱼ)` is
//! `cᵢ Σ_j m_ij cⱼ aⱼ + sᵢ Σ_j m_ij sⱼ aⱼ`, in which the products `cⱼ aⱼ` serve every row. A product of two
//! series is what costs; a sum with constant coefficients is cheap. So rows are multiplied out, terms cancel,
//! and shared factors are taken out, as in Horner's scheme.

use std::collections::BTreeMap;
use std::rc::Rc;

use crate::graph::{Graph, Leaf, Node, NodeId, collect};
use crate::hash::HashMap;
use crate::limits;

/// The most terms of a row that is multiplied out.
const MOST_TERMS: usize = 20_000;
/// The highest power of a sum that is multiplied out.
const HIGHEST_POWER: i32 = 4;

/// Moving factors and their exponents.
pub(crate) type Monomial = Vec<(NodeId, i32)>;
/// Monomials and their constant coefficients.
pub(crate) type Polynomial = BTreeMap<Monomial, NodeId>;

/// Multiplies rows out and gathers them.
#[derive(Default)]
pub(crate) struct Horner {
    known: HashMap<NodeId, Option<Rc<Polynomial>>>,
}

impl Horner {
    /// The row with few products; `None` if it has too many terms.
    pub(crate) fn rewrite(&mut self, graph: &mut Graph, row: NodeId) -> Option<NodeId> {
        let polynomial = self.polynomial(graph, row)?;
        let terms = polynomial.iter().map(|(monomial, &c)| (monomial.clone(), c));
        Some(gather(graph, terms.collect(), Ties::Last))
    }

    /// An expression multiplied out; `None` if it has too many terms.
    pub(crate) fn polynomial(&mut self, graph: &mut Graph, id: NodeId) -> Option<Rc<Polynomial>> {
        if let Some(known) = self.known.get(&id) {
            return known.clone();
        }
        let result = self
            .expand(graph, id)
            .filter(|polynomial| polynomial.len() <= MOST_TERMS)
            .map(Rc::new);
        self.known.insert(id, result.clone());
        result
    }

    fn expand(&mut self, graph: &mut Graph, id: NodeId) -> Option<Polynomial> {
        if graph.is_fixed(id) {
            return Some(BTreeMap::from([(Vec::new(), id)]));
        }
        let one = graph.constant(1.0);
        match &*graph.shared_node(id) {
            Node::Sum(constant, terms) => {
                let mut sum = BTreeMap::new();
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
                    let sum = matches!(graph.node(factor), Node::Sum(..)) && !graph.is_fixed(factor);
                    let (factor, times) = if sum && (0..=HIGHEST_POWER).contains(&exponent) {
                        (self.polynomial(graph, factor)?, exponent)
                    } else if graph.is_fixed(factor) {
                        (single(Vec::new(), graph.powi(factor, exponent)), 1)
                    } else {
                        (single(vec![(factor, exponent)], one), 1)
                    };
                    for _ in 0..times {
                        product = multiply(graph, &product, &factor)?;
                    }
                }
                Some(product)
            }
            _ => Some(BTreeMap::from([(vec![(id, 1)], one)])),
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

/// Which factor is taken out where several occur in equally many terms.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ties {
    /// The last one.
    Last,
    /// The one whose cofactors have the fewest coordinates: what is left is more likely to occur in other
    /// rows, too.
    FewestCoordinates,
}

/// A factor, and whether its exponent is positive.
type SignedFactor = (NodeId, bool);

/// The factor to be taken out of some terms, if two share one.
fn most_shared(graph: &Graph, terms: &[(Monomial, NodeId)], ties: Ties) -> Option<SignedFactor> {
    let mut counts: HashMap<SignedFactor, usize> = HashMap::default();
    for (monomial, _) in terms {
        for &(factor, exponent) in monomial {
            *counts.entry((factor, exponent > 0)).or_insert(0) += 1;
        }
    }
    let most = counts.values().copied().max().filter(|&count| count > 1)?;
    counts.retain(|_, count| *count == most);
    let mut shared = counts.into_keys();
    match ties {
        _ if shared.len() == 1 => shared.next(),
        Ties::Last => shared.max(),
        Ties::FewestCoordinates => {
            let sets = cofactor_coordinates(graph, terms, shared);
            let counts = sets.into_iter().map(|(shared, set)| (size(&set), shared));
            counts.min().map(|(_, shared)| shared)
        }
    }
}

/// A set of coordinates, as bits.
type CoordinateSet = Vec<u64>;

fn size(set: &CoordinateSet) -> u32 {
    set.iter().map(|word| word.count_ones()).sum()
}

/// For each of some factors, the coordinates of its cofactors in the terms.
fn cofactor_coordinates(
    graph: &Graph,
    terms: &[(Monomial, NodeId)],
    shared: impl Iterator<Item = SignedFactor>,
) -> HashMap<SignedFactor, CoordinateSet> {
    let mut sets: HashMap<SignedFactor, CoordinateSet> =
        shared.map(|shared| (shared, CoordinateSet::new())).collect();
    let mut known: HashMap<NodeId, CoordinateSet> = HashMap::default();
    for (monomial, _) in terms {
        for &(factor, exponent) in monomial {
            let Some(set) = sets.get_mut(&(factor, exponent > 0)) else {
                continue;
            };
            for &(other, _) in monomial.iter().filter(|&&(other, _)| other != factor) {
                let more = known.entry(other).or_insert_with(|| coordinate_set(graph, other));
                if set.len() < more.len() {
                    set.resize(more.len(), 0);
                }
                for (word, more) in set.iter_mut().zip(more) {
                    *word |= *more;
                }
            }
        }
    }
    sets
}

/// The coordinates that an expression depends on.
fn coordinate_set(graph: &Graph, id: NodeId) -> CoordinateSet {
    let mut set = CoordinateSet::new();
    for place in graph.leaves(id).filter_map(Leaf::place) {
        if set.len() <= place / 64 {
            set.resize(place / 64 + 1, 0);
        }
        set[place / 64] |= 1 << (place % 64);
    }
    set
}

/// The sum of some terms, with the factor that most of them share taken out, and so on in both parts.
pub(crate) fn gather(graph: &mut Graph, terms: Vec<(Monomial, NodeId)>, ties: Ties) -> NodeId {
    let Some((shared, positive)) = most_shared(graph, &terms, ties) else {
        let terms: Vec<_> = terms
            .into_iter()
            .map(|(monomial, coefficient)| {
                let product = graph.product(&monomial);
                (graph.mul(coefficient, product), 1.0)
            })
            .collect();
        return graph.linear(0.0, &terms);
    };
    let (mut inner, mut rest) = (Vec::new(), Vec::new());
    for (mut monomial, coefficient) in terms {
        let place = monomial
            .iter()
            .position(|&(factor, exponent)| factor == shared && (exponent > 0) == positive);
        match place {
            Some(place) => {
                monomial[place].1 -= if positive { 1 } else { -1 };
                monomial.retain(|&(_, exponent)| exponent != 0);
                inner.push((monomial, coefficient));
            }
            None => rest.push((monomial, coefficient)),
        }
    }
    let inner = gather(graph, inner, ties);
    let product = graph.product(&[(shared, if positive { 1 } else { -1 }), (inner, 1)]);
    if rest.is_empty() {
        return product;
    }
    let rest = gather(graph, rest, ties);
    graph.add(product, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cancels_goes_and_what_is_shared_is_taken_out() {
        let mut graph = Graph::new();
        let [x, y, z] = [Leaf::Q(0), Leaf::Q(1), Leaf::Q(2)].map(|leaf| graph.leaf(leaf));
        // (x + y)(x + z) - x² is x (y + z) + y z
        let (first, second) = (graph.add(x, y), graph.add(x, z));
        let (product, square) = (graph.mul(first, second), graph.powi(x, 2));
        let row = graph.sub(product, square);
        let rewritten = Horner::default().rewrite(&mut graph, row);
        let inner = graph.add(y, z);
        let (left, right) = (graph.mul(x, inner), graph.mul(y, z));
        let (left_sum, other) = (graph.add(left, right), graph.add(x, z));
        // or y (x + z) + x z, or z (x + y) + x y: each factor is in two of the three terms
        let alternatives = [
            left_sum,
            {
                let (a, b) = (graph.mul(y, other), graph.mul(x, z));
                graph.add(a, b)
            },
            {
                let (a, b) = (graph.mul(z, first), graph.mul(x, y));
                graph.add(a, b)
            },
        ];
        assert!(rewritten.is_some_and(|row| alternatives.contains(&row)));
    }
}
