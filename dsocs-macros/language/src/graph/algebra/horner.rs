//! Rows of many products, multiplied out and gathered again.
//!
//! The equations of a chain of `n` links have of the order of `n²` products of two functions of different links, most of which cancel or
//! share a factor: `Σ_j m_ij (cᵢ cⱼ aⱼ + sᵢ sⱼ aⱼ)` is `cᵢ Σ_j m_ij cⱼ aⱼ + sᵢ Σ_j m_ij sⱼ aⱼ`, in which the products `cⱼ aⱼ` serve every
//! row. A product of two series is expensive, a sum with constant coefficients is cheap. So rows are multiplied out, terms cancel, and shared
//! factors are taken out, as in Horner's scheme.

use super::polynomial::{Expansion, Monomial};
use crate::graph::{Graph, Leaf, NodeId};
use crate::hash::HashMap;

impl Expansion {
    /// The row with few products; `None` if it has too many terms.
    pub(crate) fn gathered(&mut self, graph: &mut Graph, row: NodeId) -> Option<NodeId> {
        let polynomial = self.polynomial(graph, row)?;
        let terms = polynomial.iter().map(|(monomial, &c)| (monomial.clone(), c));
        Some(gather(graph, terms.collect(), Ties::Last))
    }
}

/// Which factor is taken out where several occur in equally many terms.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ties {
    /// The last one.
    Last,
    /// The one whose cofactors have the fewest coordinates: such a cofactor is more likely to occur in other rows, too.
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
        let rewritten = Expansion::default().gathered(&mut graph, row);
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
