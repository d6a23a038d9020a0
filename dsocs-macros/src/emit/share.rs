//! Which partial products several products share.
//!
//! The tangents of `n/r³` contain `n/r⁵`: computed on its own that costs five products and leaves the range of doubles
//! long before the user's expression does; computed from `n/r³`, which is there already, it costs one product and
//! stays in range. This module finds such parts, greedily: the part that saves most products becomes a factor of its
//! own, until nothing is saved any more.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::graph::{Bits, NodeId};

/// Beyond this many products the search would take longer than it gains.
const MOST_PRODUCTS: usize = 96;

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
    /// Finds the shared parts of some products.
    pub(crate) fn find(products: BTreeSet<Product>) -> Self {
        let originals: Vec<Product> = products.into_iter().filter(|product| size(product) > 1).collect();
        if originals.len() > MOST_PRODUCTS {
            return Self::default();
        }
        let mut current = originals.clone();
        let mut parts = 0;
        while let Some(part) = best_part(&current) {
            for product in &mut current {
                while *product != part && contains(product, &part) {
                    for (factor, count) in &part {
                        if let Some(present) = product.get_mut(factor) {
                            *present -= count;
                        }
                    }
                    product.retain(|_, count| *count > 0);
                    *product.entry(Factor::Part(parts)).or_insert(0) += 1;
                }
            }
            // a product that is the part itself is replaced by it, the part is defined at the end of the list
            for product in &mut current {
                if *product == part {
                    *product = BTreeMap::from([(Factor::Part(parts), 1)]);
                }
            }
            current.push(part);
            parts += 1;
        }
        let parts = current.split_off(originals.len());
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

fn size(product: &Product) -> u32 {
    product.values().sum()
}

fn contains(product: &Product, part: &Product) -> bool {
    part.iter()
        .all(|(factor, count)| product.get(factor).is_some_and(|present| present >= count))
}

/// The common part of two products that saves most multiplications.
fn best_part(products: &[Product]) -> Option<Product> {
    let mut candidates = BTreeSet::new();
    for (i, first) in products.iter().enumerate() {
        for second in &products[..i] {
            let common: Product = first
                .iter()
                .filter_map(|(factor, &count)| {
                    let both = count.min(*second.get(factor)?);
                    Some((factor.clone(), both))
                })
                .collect();
            if size(&common) > 1 {
                candidates.insert(common);
            }
        }
    }
    let saving = |part: &Product| {
        let holders = products.iter().filter(|product| contains(product, part)).count();
        u32::try_from(holders.saturating_sub(1)).unwrap_or(u32::MAX) * (size(part) - 1)
    };
    let mut best: Option<(u32, Product)> = None;
    for candidate in candidates {
        let saved = saving(&candidate);
        if saved > 0 && best.as_ref().is_none_or(|(most, _)| saved > *most) {
            best = Some((saved, candidate));
        }
    }
    best.map(|(_, part)| part)
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
