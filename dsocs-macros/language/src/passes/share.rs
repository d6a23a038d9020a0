//! Which partial products several products share.
//!
//! The tangents of `n/r³` contain `n/r⁵`: computed on its own that costs five products and leaves the range of doubles
//! long before the user's expression does; computed from `n/r³`, which is there already, it costs one product and
//! stays in range. This module finds such parts, greedily: the pair of factors that most products have becomes a factor
//! of its own, until no two products have a pair in common.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap, HashMap};

use crate::graph::{Bits, NodeId};
use crate::limits;

/// What a product is made of.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Factor {
    /// A node, or its reciprocal.
    Node { node: NodeId, inverse: bool },
    /// A number times factors that are known before the rest.
    Early(Bits, Vec<(NodeId, i32)>),
    /// A shared part, by its place.
    Part(usize),
}

/// A product: factors and how often they occur.
pub(crate) type Product = BTreeMap<Factor, u32>;

/// The shared parts and what every product becomes with them.
#[derive(Default)]
pub(crate) struct Shared {
    parts: Vec<Product>,
    products: HashMap<Product, Product>,
}

impl Shared {
    /// Finds the shared parts of some products: again and again the pair of factors that most products have.
    pub(crate) fn find(products: BTreeSet<Product>) -> Self {
        let originals: Vec<Product> = products.into_iter().filter(|product| size(product) > 1).collect();
        let mut pairs = Pairs::default();
        let mut current = originals.clone();
        for (place, product) in current.iter().enumerate() {
            pairs.enter(place, product);
        }
        let mut parts = Vec::new();
        while let Some((pair, holders)) = pairs.most_frequent() {
            let part = Factor::Part(parts.len());
            for place in holders {
                pairs.leave(place, &current[place]);
                current[place] = with_part(&current[place], &pair, &part);
                pairs.enter(place, &current[place]);
            }
            parts.push(pair_product(&pair));
        }
        Self {
            parts,
            products: originals.into_iter().zip(current).collect(),
        }
    }

    /// The product in terms of shared parts.
    pub(crate) fn product(&self, product: Product) -> Product {
        self.products.get(&product).cloned().unwrap_or(product)
    }

    /// A shared part, in terms of others.
    pub(crate) fn part(&self, place: usize) -> Product {
        self.parts.get(place).cloned().unwrap_or_default()
    }
}

/// Two factors, or twice the same.
type Pair = (Factor, Factor);

/// In which products each pair of factors occurs.
#[derive(Default)]
struct Pairs {
    holders: HashMap<Pair, BTreeSet<usize>>,
    /// Pairs by how many products have them; entries that have become wrong are put right when they come up.
    order: BinaryHeap<(usize, Reverse<Pair>)>,
}

impl Pairs {
    fn enter(&mut self, place: usize, product: &Product) {
        for pair in pairs(product) {
            let holders = self.holders.entry(pair.clone()).or_default();
            holders.insert(place);
            if holders.len() > 1 {
                self.order.push((holders.len(), Reverse(pair)));
            }
        }
    }

    fn leave(&mut self, place: usize, product: &Product) {
        for pair in pairs(product) {
            if let Some(holders) = self.holders.get_mut(&pair) {
                holders.remove(&place);
            }
        }
    }

    /// The pair that most products have, two at least, and those products.
    fn most_frequent(&mut self) -> Option<(Pair, Vec<usize>)> {
        while let Some((count, Reverse(pair))) = self.order.pop() {
            let holders = self.holders.get(&pair).map_or(0, BTreeSet::len);
            if holders == count {
                let holders = self.holders[&pair].iter().copied().collect();
                return Some((pair, holders));
            }
            if holders > 1 {
                self.order.push((holders, Reverse(pair)));
            }
        }
        None
    }
}

/// The pairs of factors of a product.
fn pairs(product: &Product) -> Vec<Pair> {
    let factors: Vec<(&Factor, u32)> = product.iter().map(|(factor, &count)| (factor, count)).collect();
    // each is looked up and kept in several places
    limits::spend(2 * factors.len() * factors.len());
    let mut pairs = Vec::new();
    for (place, &(first, count)) in factors.iter().enumerate() {
        if count > 1 {
            pairs.push((first.clone(), first.clone()));
        }
        pairs.extend(
            factors[place + 1..]
                .iter()
                .map(|&(second, _)| (first.clone(), second.clone())),
        );
    }
    pairs
}

fn pair_product((first, second): &Pair) -> Product {
    let mut product = Product::new();
    for factor in [first, second] {
        *product.entry(factor.clone()).or_insert(0) += 1;
    }
    product
}

/// A product with a part in the place of a pair, as often as it has the pair.
fn with_part(product: &Product, pair: &Pair, part: &Factor) -> Product {
    let pair = pair_product(pair);
    let often = pair
        .iter()
        .map(|(factor, count)| product.get(factor).map_or(0, |present| present / count))
        .min()
        .unwrap_or(0);
    let mut product = product.clone();
    for (factor, count) in pair {
        if let Some(present) = product.get_mut(&factor) {
            *present -= count * often;
        }
    }
    product.retain(|_, count| *count > 0);
    product.insert(part.clone(), often);
    product
}

fn size(product: &Product) -> u32 {
    product.values().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Graph, Leaf};

    #[test]
    fn the_tangents_of_a_quotient_share_the_quotient() {
        let mut graph = Graph::new();
        let node = |graph: &mut Graph, i| Factor::Node {
            node: graph.leaf(Leaf::Z(i)),
            inverse: false,
        };
        let (n, x, y) = (node(&mut graph, 0), node(&mut graph, 1), node(&mut graph, 2));
        let r = Factor::Node {
            node: graph.leaf(Leaf::Z(3)),
            inverse: true,
        };
        let value = BTreeMap::from([(n.clone(), 1), (r.clone(), 3)]);
        let by_x = BTreeMap::from([(n.clone(), 1), (r.clone(), 5), (x, 1)]);
        let by_y = BTreeMap::from([(n, 1), (r, 5), (y, 1)]);
        let shared = Shared::find(BTreeSet::from([value.clone(), by_x.clone(), by_y.clone()]));
        let (value, by_x, by_y) = (shared.product(value), shared.product(by_x), shared.product(by_y));
        assert_eq!(size(&value), 1, "the value is a part of its own");
        assert_eq!(
            (size(&by_x), size(&by_y)),
            (2, 2),
            "a tangent is one product more"
        );
    }
}
