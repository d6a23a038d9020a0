//! Partial products that several products share.
//!
//! The tangents of `n/r³` contain `n/r⁵`. On its own that costs five products, and it leaves the range of
//! doubles long before the user's expression does; from `n/r³`, which is computed anyway, it costs one
//! product and stays in range. The search for shared parts is greedy: the pair of factors that most products
//! have becomes a factor of its own, until no two products have a pair in common.

pub(super) mod nested;
mod product;

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::rc::Rc;

use crate::graph::{Bits, NodeId};
use crate::hash::HashMap;
use crate::mistakes::limits;

pub(crate) use product::Product;

/// A factor of a product.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Factor {
    /// A node, or its reciprocal.
    Node { node: NodeId, inverse: bool },
    /// A number times factors that are known earlier than the rest.
    Early(Bits, Rc<[(NodeId, i32)]>),
    /// A shared part, by its index.
    Part(usize),
}

/// The shared parts, and the products in terms of them.
#[derive(Default)]
pub(crate) struct Shared {
    parts: Vec<Product>,
    products: HashMap<Product, Product>,
}

impl Shared {
    /// Finds the shared parts of some products: again and again the pair of factors that most products have.
    pub(crate) fn find(products: impl IntoIterator<Item = Product>) -> Self {
        Self::find_beyond(in_order(products), 0)
    }

    /// Finds the shared parts of sorted products without repetitions that already contain `known` parts; new parts are numbered from there
    /// on.
    fn find_beyond(products: Vec<Product>, known: usize) -> Self {
        let originals: Vec<Product> = products.into_iter().filter(|product| size(product) > 1).collect();
        let (factors, numbered) = numbered(&originals);
        let mut search = Search::new(numbered, factors.len());
        let mut parts = Vec::new();
        while let Some((pair, holders)) = search.most_frequent() {
            let part = narrow(factors.len() + parts.len());
            search.replace_all(&holders, pair, part);
            parts.push(pair);
        }
        let factor = |number: u32| {
            let number = number as usize;
            let part = number.checked_sub(factors.len());
            part.map_or_else(|| (*factors[number]).clone(), |part| Factor::Part(known + part))
        };
        let products = search.products.iter();
        let products: Vec<Product> = products
            .map(|product| {
                let factors = product.iter();
                factors.map(|&(number, count)| (factor(number), count)).collect()
            })
            .collect();
        let parts = parts
            .iter()
            .map(|&[first, second]| {
                if first == second {
                    Product::from([(factor(first), 2)])
                } else {
                    Product::from([(factor(first), 1), (factor(second), 1)])
                }
            })
            .collect();
        let products = originals.into_iter().zip(products).collect();
        Self { parts, products }
    }

    /// The product in terms of shared parts.
    pub(crate) fn product(&self, product: Product) -> Product {
        self.searched(&product).cloned().unwrap_or(product)
    }

    /// The product in terms of shared parts; `None` if it is none of those given to [`Shared::find`].
    pub(crate) fn searched(&self, product: &Product) -> Option<&Product> {
        if size(product) < 2 {
            return None;
        }
        self.products.get(product)
    }

    /// A shared part, in terms of factors and other parts.
    pub(crate) fn part(&self, place: usize) -> Product {
        self.parts.get(place).cloned().unwrap_or_default()
    }
}

/// The different factors of some products, sorted, and the products in terms of the factors' numbers.
fn numbered(products: &[Product]) -> (Vec<&Factor>, Vec<Numbered>) {
    let mut numbers: HashMap<&Factor, u32> = HashMap::default();
    for factor in products.iter().flat_map(Product::keys) {
        numbers.insert(factor, 0);
    }
    let mut factors: Vec<&Factor> = numbers.keys().copied().collect();
    factors.sort_unstable();
    for (number, &factor) in factors.iter().enumerate() {
        numbers.insert(factor, narrow(number));
    }
    let numbered = products.iter().map(|product| {
        let factors = product.iter();
        factors.map(|(factor, &count)| (numbers[factor], count)).collect()
    });
    let numbered = numbered.collect();
    (factors, numbered)
}

/// Some products, sorted and without repetitions. They are compared by the numbers of their factors, because
/// many products begin with the same factors.
pub(crate) fn in_order(products: impl IntoIterator<Item = Product>) -> Vec<Product> {
    let products: Vec<Product> = products.into_iter().collect();
    let (_, numbered) = numbered(&products);
    let mut order: Vec<(Numbered, Product)> = numbered.into_iter().zip(products).collect();
    order.sort_unstable_by(|(a, _), (b, _)| a.cmp(b));
    order.dedup_by(|(a, _), (b, _)| a == b);
    order.into_iter().map(|(_, product)| product).collect()
}

/// A product as pairs of a factor's number, in the order of [`Factor`], and its multiplicity, sorted by
/// number.
type Numbered = Vec<(u32, u32)>;

/// Two factors by their numbers, the smaller first; equal for a square.
type Pair = [u32; 2];

/// A factor's number as `u32`: no declaration comes near four thousand million.
fn narrow(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

/// The products that have a pair of factors.
struct ProductsWithPair {
    /// The products that had it at first, in order.
    found: Vec<u32>,
    /// The number of those that still have it.
    count: usize,
}

/// The search for pairs of factors.
struct Search {
    /// The products, in terms of the parts found so far.
    products: Vec<Numbered>,
    /// The pairs that at least two products have. A product gains no pair of old factors: its new pairs
    /// contain the newest part.
    holders: HashMap<Pair, ProductsWithPair>,
    /// Pairs by the number of products that have them; outdated entries are corrected when they come up.
    order: BinaryHeap<(usize, Reverse<Pair>)>,
}

impl Search {
    /// A search among some products, with factors numbered below `factors`.
    fn new(products: Vec<Numbered>, factors: usize) -> Self {
        // for each factor, the products with it and its positions there
        let mut places: Vec<Vec<(u32, u32)>> = vec![Vec::new(); factors];
        for (holder, product) in products.iter().enumerate() {
            // all pairs of a product are looked at
            limits::spend(product.len() * product.len());
            for (at, &(factor, _)) in product.iter().enumerate() {
                places[factor as usize].push((narrow(holder), narrow(at)));
            }
        }
        let mut search = Self {
            products,
            holders: HashMap::default(),
            order: BinaryHeap::new(),
        };
        let mut found: Vec<Vec<u32>> = vec![Vec::new(); factors];
        for (first, places) in places.iter().enumerate() {
            let mut seconds = Vec::new();
            for &(holder, at) in places {
                for &(second, count) in &search.products[holder as usize][at as usize..] {
                    if second as usize == first && count < 2 {
                        continue;
                    }
                    let found = &mut found[second as usize];
                    if found.is_empty() {
                        seconds.push(second);
                    }
                    found.push(holder);
                }
            }
            for second in seconds {
                let found = &mut found[second as usize];
                search.watch([narrow(first), second], found);
                found.clear();
            }
        }
        search
    }

    /// Adds a pair to the search, if at least two products have it.
    fn watch(&mut self, pair: Pair, found: &[u32]) {
        if found.len() > 1 {
            let holders = ProductsWithPair {
                found: found.to_vec(),
                count: found.len(),
            };
            self.holders.insert(pair, holders);
            self.order.push((found.len(), Reverse(pair)));
        }
    }

    /// The pair that most products have, at least two, and those products.
    fn most_frequent(&mut self) -> Option<(Pair, Vec<u32>)> {
        while let Some((count, Reverse(pair))) = self.order.pop() {
            let Some(holders) = self.holders.get(&pair) else {
                continue;
            };
            if holders.count == count {
                let holders = self.holders.remove(&pair)?.found.into_iter();
                let holders = holders.filter(|&holder| self.has(holder, pair));
                return Some((pair, holders.collect()));
            }
            if holders.count > 1 {
                self.order.push((holders.count, Reverse(pair)));
            } else {
                self.holders.remove(&pair);
            }
        }
        None
    }

    /// The multiplicity of a factor in a product.
    fn count(&self, holder: u32, factor: u32) -> u32 {
        let product = &self.products[holder as usize];
        let place = product.binary_search_by_key(&factor, |&(factor, _)| factor);
        place.map_or(0, |place| product[place].1)
    }

    fn has(&self, holder: u32, [first, second]: Pair) -> bool {
        if first == second {
            self.count(holder, first) > 1
        } else {
            self.count(holder, first) > 0 && self.count(holder, second) > 0
        }
    }

    /// Replaces a pair by a part in some products, as often as each has the pair. Only pairs with one of
    /// these three factors change.
    fn replace_all(&mut self, holders: &[u32], pair: Pair, part: u32) {
        let mut beside = Vec::new();
        for &holder in holders {
            self.replace(holder, pair, part);
            for &(factor, count) in &self.products[holder as usize] {
                if factor != part || count > 1 {
                    beside.push((factor, holder));
                }
            }
        }
        beside.sort_unstable();
        let mut found = Vec::new();
        for with in beside.chunk_by(|a, b| a.0 == b.0) {
            found.clear();
            found.extend(with.iter().map(|&(_, holder)| holder));
            self.watch([with[0].0, part], &found);
        }
    }

    fn replace(&mut self, holder: u32, [first, second]: Pair, part: u32) {
        let before = [first, second].map(|factor| self.count(holder, factor));
        let often = if first == second {
            before[0] / 2
        } else {
            before[0].min(before[1])
        };
        let product = &mut self.products[holder as usize];
        for (factor, left) in product.iter_mut() {
            if *factor == first {
                *left -= often;
            }
            if *factor == second {
                *left -= often;
            }
        }
        product.retain(|&(_, left)| left > 0);
        limits::spend(8 * product.len());
        let after = [first, second].map(|factor| self.count(holder, factor));
        let Self {
            products, holders, ..
        } = self;
        let product = &mut products[holder as usize];
        let mut leave = |pair: Pair| {
            if let Some(holders) = holders.get_mut(&pair) {
                holders.count -= 1;
            }
        };
        for place in 0..(if first == second { 1 } else { 2 }) {
            let factor = [first, second][place];
            if before[place] > 1 && after[place] <= 1 {
                leave([factor, factor]);
            }
            if after[place] == 0 {
                for &(other, _) in &*product {
                    leave([factor.min(other), factor.max(other)]);
                }
            }
        }
        // its number is greater than all others
        product.push((part, often));
    }
}

/// The number of factors of a product, with multiplicity.
pub(crate) fn size(product: &Product) -> u32 {
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
        let value = Product::from([(n.clone(), 1), (r.clone(), 3)]);
        let by_x = Product::from([(n.clone(), 1), (r.clone(), 5), (x, 1)]);
        let by_y = Product::from([(n, 1), (r, 5), (y, 1)]);
        let shared = Shared::find([value.clone(), by_x.clone(), by_y.clone()]);
        let (value, by_x, by_y) = (shared.product(value), shared.product(by_x), shared.product(by_y));
        assert_eq!(size(&value), 1, "the value is a part of its own");
        assert_eq!(
            (size(&by_x), size(&by_y)),
            (2, 2),
            "a tangent is one product more"
        );
    }
}
