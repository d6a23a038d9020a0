//! Sums that share their terms, as running sums.
//!
//! Along a chain of `n` links each row has a sum over all links, `Σ_j c_ij x_j` with
//! `c_ij = l_i l_j m_max(i,j)`. With shared factors taken out it is
//! `l_i (m_i Σ_{j ≤ i} l_j x_j + Σ_{j > i} m_j l_j x_j)`. The inner sums of all rows are partial sums of one
//! sum that runs along the chain and of one that runs back. No order of the links is assumed, so a tree works
//! like a chain: a sum that is a part of another becomes a term of it; then the pair of terms that most sums
//! have becomes a term of its own, until no two sums have a pair in common (see [`super::share`]).
//!
//! Here sums are grouped. Programs and Taylor series write them, each in its own way.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::share::{Factor, Product, Shared, in_order, nested};
use crate::graph::{Bits, NodeId};

/// The fewest terms of a sum that is grouped.
pub(crate) const FEWEST_TERMS: usize = 4;
/// With more pairs of terms in all, sums inside others are first found as wholes: a whole sum costs no more
/// than a pair.
const FEW_PAIRS: usize = 20_000;
/// With more pairs of terms left in all, no pairs are searched for.
const MOST_PAIRS: usize = 1_000_000;

/// A number times factors that are known earlier than the rest of a term.
pub(crate) type EarlyFactor = (Bits, Rc<[(NodeId, i32)]>);

/// Some terms of a sum, with common factors taken out.
#[derive(Clone, Debug)]
pub(crate) struct Running {
    pub(crate) negative: bool,
    /// The factor that all terms share.
    pub(crate) common: EarlyFactor,
    /// Groups of terms, each with the factor that its terms share beyond the common one.
    pub(crate) pieces: Vec<(EarlyFactor, Product)>,
}

impl Running {
    /// The groups of some terms. With `of_powers`, the least power of a factor is taken out; else only powers that are equal in all terms.
    /// The latter is cheaper if the factors are not yet numbers when the sum is formed: a power that is computed anyway costs nothing,
    /// another one does.
    pub(crate) fn of(mut items: Vec<SplitTerm>, of_powers: bool) -> Self {
        let common = take_common(&mut items, of_powers);
        let negative = items.iter().all(|item| item.coefficient < 0.0);
        for item in &mut items {
            item.coefficient *= if negative { -1.0 } else { 1.0 };
        }
        let list = |items: Vec<SplitTerm>| items.iter().map(|item| (item.factor(), 1)).collect();
        let pieces = pieces(items).into_iter();
        Self {
            negative,
            common,
            pieces: pieces.map(|(early, items)| (early, list(items))).collect(),
        }
    }
}

/// The parts that the sums of some groups share.
pub(crate) fn shared<'r>(running: impl Iterator<Item = &'r Running>) -> Shared {
    let lists = running.flat_map(|running| &running.pieces);
    let lists = in_order(lists.map(|(_, list)| list.clone()));
    let pairs: usize = lists.iter().map(|list| list.len() * list.len()).sum();
    if pairs <= FEW_PAIRS {
        return Shared::find(lists);
    }
    let nested = nested::Nested::of(lists);
    if nested.pairs() > MOST_PAIRS {
        return nested.without_pairs();
    }
    nested.with_pairs()
}

/// A term `coefficient · early · late`.
#[derive(Clone)]
pub(crate) struct SplitTerm {
    pub(crate) coefficient: f64,
    /// Sorted by node.
    pub(crate) early: Vec<(NodeId, i32)>,
    pub(crate) late: Vec<(NodeId, i32)>,
}

impl SplitTerm {
    fn factor(&self) -> Factor {
        let factors = self.early.iter().chain(&self.late).copied().collect();
        Factor::Early(Bits::new(self.coefficient), factors)
    }
}

/// The factor that all terms share, taken out of them.
fn take_common(items: &mut [SplitTerm], of_powers: bool) -> EarlyFactor {
    let mut common = items.first().map_or_else(Vec::new, |item| item.early.clone());
    for item in &*items {
        common.retain_mut(|(factor, n)| {
            let place = item.early.binary_search_by_key(factor, |&(factor, _)| factor);
            let own = place.map_or(0, |place| item.early[place].1);
            if of_powers && own.abs() < n.abs() && own.signum() == n.signum() {
                *n = own;
            }
            own == *n || of_powers && own.signum() == n.signum()
        });
    }
    let size = items.first().map_or(1.0, |item| item.coefficient.abs());
    #[allow(clippy::float_cmp)] // coefficients that are the same number
    let same = items.iter().all(|item| item.coefficient.abs() == size);
    for item in items {
        item.early.retain_mut(|(factor, n)| {
            let place = common.binary_search_by_key(factor, |&(factor, _)| factor);
            *n -= place.map_or(0, |place| common[place].1);
            *n != 0
        });
        if same {
            item.coefficient = item.coefficient.signum();
        }
    }
    (Bits::new(if same { size } else { 1.0 }), common.into())
}

/// A factor, or the size of the coefficient, by which terms are grouped.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum GroupingFactor {
    Number(Bits),
    Factor(NodeId, i32),
}

impl GroupingFactor {
    fn all(item: &SplitTerm) -> impl Iterator<Item = Self> {
        let number = Bits::new(item.coefficient.abs());
        let number = (number != Bits::new(1.0)).then_some(Self::Number(number));
        let factors = item.early.iter().map(|&(node, n)| Self::Factor(node, n));
        factors.chain(number)
    }
}

/// Terms in groups, each with the factor that its terms share.
fn pieces(mut items: Vec<SplitTerm>) -> Vec<(EarlyFactor, Vec<SplitTerm>)> {
    let mut pieces = Vec::new();
    loop {
        let mut counts: BTreeMap<GroupingFactor, usize> = BTreeMap::new();
        for factor in items.iter().flat_map(GroupingFactor::all) {
            *counts.entry(factor).or_default() += 1;
        }
        let most = counts.into_iter().max_by_key(|&(_, count)| count);
        let Some((factor, 2..)) = most else {
            break;
        };
        let (mut with, without): (Vec<_>, Vec<_>) = items
            .into_iter()
            .partition(|item| GroupingFactor::all(item).any(|own| own == factor));
        let common = take_common(&mut with, false);
        pieces.push((common, with));
        items = without;
    }
    if !items.is_empty() {
        pieces.push(((Bits::new(1.0), Rc::default()), items));
    }
    pieces
}
