//! Which partial products several products share.
//!
//! The tangents of `n/r³` contain `n/r⁵`: computed on its own that costs five products and leaves the range of doubles
//! long before the user's expression does; computed from `n/r³`, which is there already, it costs one product and
//! stays in range. This module finds such parts, greedily: the pair of factors that most products have becomes a factor
//! of its own, until no two products have a pair in common.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use crate::graph::{Bits, NodeId};
use crate::hash::HashMap;
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
        let factors: BTreeSet<&Factor> = originals.iter().flat_map(Product::keys).collect();
        let factors: Vec<Factor> = factors.into_iter().cloned().collect();
        let mut search = Search::new(
            originals
                .iter()
                .map(|product| numbered(product, &factors))
                .collect(),
        );
        let mut parts = Vec::new();
        while let Some((pair, holders)) = search.most_frequent() {
            let part = narrow(factors.len() + parts.len());
            for holder in holders {
                search.replace(holder, pair, part);
            }
            parts.push(pair);
        }
        let factor = |number: u32| {
            let number = number as usize;
            let part = number.checked_sub(factors.len());
            part.map_or_else(|| factors[number].clone(), Factor::Part)
        };
        let products = search.products.iter();
        let products = products.map(|product| {
            product
                .iter()
                .map(|&(number, count)| (factor(number), count))
                .collect()
        });
        Self {
            products: originals.into_iter().zip(products).collect(),
            parts: parts
                .iter()
                .map(|&[first, second]| {
                    if first == second {
                        Product::from([(factor(first), 2)])
                    } else {
                        Product::from([(factor(first), 1), (factor(second), 1)])
                    }
                })
                .collect(),
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

/// Factors by their numbers, in the order of [`Factor`], and how often they occur; by number.
type Numbered = Vec<(u32, u32)>;

/// Two factors by their numbers, the smaller first, or twice the same.
type Pair = [u32; 2];

/// A product of factors by their places.
fn numbered(product: &Product, factors: &[Factor]) -> Numbered {
    let places = product.iter().filter_map(|(factor, &count)| {
        let place = factors.binary_search(factor).ok()?;
        Some((narrow(place), count))
    });
    places.collect()
}

/// A number of a factor: no declaration comes near four thousand million.
fn narrow(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

/// The search for pairs of factors.
struct Search {
    /// The products, in terms of the parts that were found.
    products: Vec<Numbered>,
    /// In which products each pair of factors occurs.
    holders: HashMap<Pair, BTreeSet<u32>>,
    /// Pairs by how many products have them; entries that have become wrong are put right when they come up.
    order: BinaryHeap<(usize, Reverse<Pair>)>,
}

impl Search {
    fn new(products: Vec<Numbered>) -> Self {
        let mut holders: HashMap<Pair, BTreeSet<u32>> = HashMap::default();
        for (place, product) in products.iter().enumerate() {
            // each pair is looked up and kept in several places
            limits::spend(product.len() * product.len());
            for (at, &(first, count)) in product.iter().enumerate() {
                if count > 1 {
                    holders.entry([first, first]).or_default().insert(narrow(place));
                }
                for &(second, _) in &product[at + 1..] {
                    holders.entry([first, second]).or_default().insert(narrow(place));
                }
            }
        }
        let shared = holders.iter().filter(|(_, holders)| holders.len() > 1);
        Self {
            order: shared
                .map(|(&pair, holders)| (holders.len(), Reverse(pair)))
                .collect(),
            products,
            holders,
        }
    }

    /// The pair that most products have, two at least, and those products.
    fn most_frequent(&mut self) -> Option<(Pair, Vec<u32>)> {
        while let Some((count, Reverse(pair))) = self.order.pop() {
            let Some(holders) = self.holders.get(&pair) else {
                continue;
            };
            if holders.len() == count {
                return Some((pair, holders.iter().copied().collect()));
            }
            if holders.len() > 1 {
                self.order.push((holders.len(), Reverse(pair)));
            }
        }
        None
    }

    /// Puts a part in the place of a pair, as often as a product has the pair. Only pairs with one of the three change.
    fn replace(&mut self, holder: u32, [first, second]: Pair, part: u32) {
        let product = &mut self.products[holder as usize];
        let count = |product: &Numbered, factor: u32| {
            let place = product.binary_search_by_key(&factor, |&(factor, _)| factor);
            place.map_or(0, |place| product[place].1)
        };
        let before = [first, second].map(|factor| count(product, factor));
        let often = if first == second {
            before[0] / 2
        } else {
            before[0].min(before[1])
        };
        for (factor, left) in product.iter_mut() {
            if *factor == first {
                *left -= often;
            }
            if *factor == second {
                *left -= often;
            }
        }
        product.retain(|&(_, left)| left > 0);
        let after = [first, second].map(|factor| count(product, factor));
        limits::spend(8 * product.len());
        let others: Vec<u32> = product.iter().map(|&(factor, _)| factor).collect();
        // greater than all others
        product.push((part, often));
        for place in 0..(if first == second { 1 } else { 2 }) {
            let factor = [first, second][place];
            if before[place] > 1 && after[place] <= 1 {
                self.leave([factor, factor], holder);
            }
            if after[place] == 0 {
                for &other in others.iter().filter(|&&other| other != factor) {
                    self.leave([factor.min(other), factor.max(other)], holder);
                }
            }
        }
        if first != second && after.contains(&0) {
            self.leave([first, second], holder);
        }
        for other in others {
            self.enter([other, part], holder);
        }
        if often > 1 {
            self.enter([part, part], holder);
        }
    }

    fn enter(&mut self, pair: Pair, holder: u32) {
        let holders = self.holders.entry(pair).or_default();
        holders.insert(holder);
        if holders.len() > 1 {
            self.order.push((holders.len(), Reverse(pair)));
        }
    }

    fn leave(&mut self, pair: Pair, holder: u32) {
        if let Some(holders) = self.holders.get_mut(&pair) {
            holders.remove(&holder);
        }
    }
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
