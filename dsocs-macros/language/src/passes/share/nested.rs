//! Sums that are parts of other sums.
//!
//! The sums along a chain are nested, and so are those over the branches of a tree: each is the largest of
//! those inside it plus a term or two. Where there are too many pairs of terms to search, whole sums are
//! compared instead, one comparison for each pair of sums.

use super::{Factor, Numbered, Product, Shared, in_order, numbered, size};
use crate::hash::{HashMap, HashSet};

/// The most words that are compared; beyond, no sum is searched for in another.
const MOST_COMPARED: usize = 50_000_000;

/// The set of factors of a list, as bits.
type Members = Vec<u64>;

/// Lists of factors, in terms of lists that are parts of others.
pub(crate) struct Nested {
    /// The given lists, each with its form in terms of the parts.
    lists: Vec<(Product, Product)>,
    /// The lists that are parts of others, in terms of earlier parts.
    parts: Vec<Product>,
}

impl Nested {
    /// Finds lists inside others. Each list takes the largest one that it contains, then the largest that its rest contains, and so on.
    /// Factors that occur in one list only are separated from the rest of the list, which other lists may contain.
    pub(crate) fn of(given: impl IntoIterator<Item = Product>) -> Self {
        let given: Vec<Product> = given.into_iter().filter(|list| size(list) > 1).collect();
        let mut counts: HashMap<&Factor, usize> = HashMap::default();
        for factor in given.iter().flat_map(Product::keys) {
            *counts.entry(factor).or_default() += 1;
        }
        let common = |list: &Product| -> Product {
            let common = list.iter().filter(|(factor, _)| counts[factor] > 1);
            common.map(|(factor, &count)| (factor.clone(), count)).collect()
        };
        let common = given.iter().map(common).filter(|list| size(list) > 1);
        let mut lists = in_order(common.chain(given.iter().cloned()));
        lists.sort_by_key(|list| core::cmp::Reverse(list.len()));
        let (factors, numbered) = numbered(&lists);
        let members = members(&numbered, factors.len());
        let words = members.first().map_or(0, Vec::len);
        let few = lists.len().saturating_mul(lists.len()).saturating_mul(words) / 2 <= MOST_COMPARED;
        // lists with a repeated factor are left as they are
        let is_plain: Vec<bool> = lists
            .iter()
            .map(|list| list.values().all(|&count| count == 1))
            .collect();
        let mut inner = vec![(Vec::new(), Product::new()); lists.len()];
        let mut uses = vec![0_usize; lists.len()];
        for place in 0..lists.len() {
            inner[place] = if few && is_plain[place] {
                let (inside, rest) = inside(&numbered, &is_plain, &members, place);
                let rest = rest.into_iter();
                let rest = rest.map(|(factor, count)| (factors[factor as usize].clone(), count));
                (inside, rest.collect())
            } else {
                (Vec::new(), lists[place].clone())
            };
            for &part in &inner[place].0 {
                uses[part] += 1;
            }
        }
        // a part of one list only, unless it was given itself, is written out there
        let asked: HashSet<&Product> = given.iter().collect();
        let is_asked: Vec<bool> = lists.iter().map(|list| asked.contains(list)).collect();
        let is_part = |place: usize| uses[place] > 1 || uses[place] == 1 && is_asked[place];
        let mut parts = Vec::new();
        let mut written: Vec<Product> = vec![Product::new(); lists.len()];
        // the lists are sorted by size, the largest first
        for place in (0..lists.len()).rev() {
            let (inside, rest) = &inner[place];
            let mut own = rest.clone();
            for part in inside {
                own.extend(written[*part].clone());
            }
            if is_part(place) {
                parts.push(own);
                own = Product::from([(Factor::Part(parts.len() - 1), 1)]);
            }
            written[place] = own;
        }
        let lists = lists.iter().cloned().zip(written).zip(is_asked);
        let lists = lists.filter_map(|(list, is_asked)| is_asked.then_some(list));
        Self {
            lists: lists.collect(),
            parts,
        }
    }

    /// The number of pairs of factors that are left.
    pub(crate) fn pairs(&self) -> usize {
        let written = self.lists.iter().map(|(_, written)| written);
        written
            .chain(&self.parts)
            .map(|list| list.len() * list.len())
            .sum()
    }

    /// The lists in terms of these parts alone.
    pub(crate) fn without_pairs(self) -> Shared {
        Shared {
            parts: self.parts,
            products: self.lists.into_iter().collect(),
        }
    }

    /// The lists in terms of these parts and of the pairs that the rests share.
    pub(crate) fn with_pairs(self) -> Shared {
        let written = self.lists.iter().map(|(_, written)| written);
        let all = in_order(written.chain(&self.parts).cloned());
        let mut found = Shared::find_beyond(all, self.parts.len());
        let mut parts: Vec<Product> = self.parts.into_iter().map(|part| found.product(part)).collect();
        let lists = self.lists.into_iter();
        let products = lists.map(|(list, written)| (list, found.product(written)));
        let products = products.collect();
        parts.append(&mut found.parts);
        Shared { parts, products }
    }
}

/// The largest disjoint lists inside one, and its rest. The lists are sorted by size, the largest first.
fn inside(
    lists: &[Numbered],
    is_plain: &[bool],
    members: &[Members],
    place: usize,
) -> (Vec<usize>, Numbered) {
    let mut rest = members[place].clone();
    let mut left = lists[place].len();
    let mut found = Vec::new();
    for (other, inner) in members.iter().enumerate().skip(place + 1) {
        let count = lists[other].len();
        if count > left || !is_plain[other] {
            continue;
        }
        if inner.iter().zip(&rest).all(|(inner, rest)| inner & !rest == 0) {
            for (rest, inner) in rest.iter_mut().zip(inner) {
                *rest &= !inner;
            }
            left -= count;
            found.push(other);
        }
    }
    let is_left = |&&(factor, _): &&(u32, u32)| rest[factor as usize / 64] >> (factor % 64) & 1 == 1;
    let rest = lists[place].iter().filter(is_left).copied();
    let rest = rest.collect();
    (found, rest)
}

/// The set of factors of each list, out of `factors` in all.
fn members(lists: &[Numbered], factors: usize) -> Vec<Members> {
    let words = factors.div_ceil(64);
    let of = |list: &Numbered| {
        let mut members = vec![0; words];
        for &(factor, _) in list {
            members[factor as usize / 64] |= 1 << (factor % 64);
        }
        members
    };
    lists.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::rc::Rc;

    use super::*;
    use crate::graph::Bits;

    /// A list of terms that are plain numbers.
    fn list(terms: impl IntoIterator<Item = u32>) -> Product {
        let term = |number: u32| (Factor::Early(Bits::new(f64::from(number)), Rc::default()), 1);
        terms.into_iter().map(term).collect()
    }

    /// A list with all parts written out.
    fn written_out(shared: &Shared, list: &Product) -> Product {
        let mut all = Product::new();
        for (factor, &count) in list {
            match factor {
                Factor::Part(place) => all.extend(written_out(shared, &shared.part(*place))),
                _ => {
                    all.insert(factor.clone(), count);
                }
            }
        }
        all
    }

    /// The number of terms of all lists and of their parts.
    fn terms(shared: &Shared, lists: &BTreeSet<Product>) -> u32 {
        let lists = lists.iter().map(|list| size(&shared.product(list.clone())));
        lists.chain(shared.parts.iter().map(size)).sum()
    }

    #[test]
    fn sums_along_chains_and_trees_take_a_term_or_two_each() {
        let along = (2..=60).map(|end| list(0..end));
        let back = (0..58).map(|first| list(first..60));
        let chain: BTreeSet<Product> = along.chain(back).collect();
        // over the branches of a tree of two branches each, and from the root to each node
        let below = |node: u32| {
            (0..63).filter(move |other| (1..6).any(|up| (other + 1) >> up == node + 1) || *other == node)
        };
        let above = |node: u32| {
            (0..6)
                .map(move |up| (node + 1) >> up)
                .filter(|up| *up > 0)
                .map(|up| up - 1)
        };
        let tree: BTreeSet<Product> = (0..31)
            .map(|node| list(below(node)))
            .chain((1..63).map(|node| list(above(node))))
            .collect();
        for (lists, most) in [(chain, 3 * 118), (tree, 4 * 93)] {
            for shared in [
                Nested::of(lists.clone()).without_pairs(),
                Nested::of(lists.clone()).with_pairs(),
            ] {
                for list in &lists {
                    assert_eq!(written_out(&shared, &shared.product(list.clone())), *list);
                }
                assert!(terms(&shared, &lists) <= most, "{}", terms(&shared, &lists));
            }
        }
    }
}
