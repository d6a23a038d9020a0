//! Sums that share their terms, as running sums.
//!
//! Along a chain of `n` links each row has a sum over all links, `Σ_j c_ij x_j` with `c_ij = l_i l_j m_max(i,j)`: with what is shared taken out,
//! `l_i (m_i Σ_{j ≤ i} l_j x_j + Σ_{j > i} m_j l_j x_j)`. The inner sums of all rows are those of a sum that runs along the chain, and of one that
//! runs back. Nothing is said of an order of the links: the pair of terms that most sums have becomes a term of its own, until
//! no two sums have a pair in common (see [`crate::passes::share`]).

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::{Early, Op, Program, Value, is_one};
use crate::graph::{Bits, Node, NodeId};
use crate::passes::share::{Factor, Product, Shared};

/// Sums of fewer terms are written term by term.
const FEWEST_TERMS: usize = 4;
/// With more pairs of terms in all, none are looked for.
const MOST_PAIRS: usize = 1_000_000;

/// The terms of a sum that become known at one stage.
#[derive(Clone, Debug)]
pub(super) struct Running {
    pub(super) stage: usize,
    pub(super) negative: bool,
    /// What all terms share.
    common: Early,
    /// Sums of terms, each with what those share beyond that.
    pieces: Vec<(Early, Product)>,
    /// The terms, by their nodes.
    terms: BTreeSet<NodeId>,
}

/// A term `coefficient · early · late`.
#[derive(Clone)]
struct Item {
    coefficient: f64,
    /// By node.
    early: Vec<(NodeId, i32)>,
    late: Vec<(NodeId, i32)>,
}

impl Item {
    fn factor(&self) -> Factor {
        let factors = self.early.iter().chain(&self.late).copied().collect();
        Factor::Early(Bits::new(self.coefficient), factors)
    }
}

/// What all of some terms share: taken out of them.
fn take_common(items: &mut [Item]) -> Early {
    let mut common = items.first().map_or_else(Vec::new, |item| item.early.clone());
    for item in &*items {
        common.retain(|factor| item.early.binary_search(factor).is_ok());
    }
    let size = items.first().map_or(1.0, |item| item.coefficient.abs());
    #[allow(clippy::float_cmp)] // coefficients that are the same number
    let same = items.iter().all(|item| item.coefficient.abs() == size);
    for item in items {
        item.early.retain(|factor| common.binary_search(factor).is_err());
        if same {
            item.coefficient = item.coefficient.signum();
        }
    }
    (Bits::new(if same { size } else { 1.0 }), common.into())
}

/// What stands in most of some terms: a factor, or a number.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Mark {
    Number(Bits),
    Factor(NodeId, i32),
}

impl Mark {
    fn all(item: &Item) -> impl Iterator<Item = Self> {
        let number = Bits::new(item.coefficient.abs());
        let number = (number != Bits::new(1.0)).then_some(Self::Number(number));
        let factors = item.early.iter().map(|&(node, n)| Self::Factor(node, n));
        factors.chain(number)
    }
}

/// Terms in groups, each with what its terms share.
fn pieces(mut items: Vec<Item>) -> Vec<(Early, Vec<Item>)> {
    let mut pieces = Vec::new();
    loop {
        let mut counts: BTreeMap<Mark, usize> = BTreeMap::new();
        for mark in items.iter().flat_map(Mark::all) {
            *counts.entry(mark).or_default() += 1;
        }
        let most = counts.into_iter().max_by_key(|&(_, count)| count);
        let Some((mark, 2..)) = most else {
            break;
        };
        let (mut with, without): (Vec<_>, Vec<_>) = items
            .into_iter()
            .partition(|item| Mark::all(item).any(|own| own == mark));
        let common = take_common(&mut with);
        pieces.push((common, with));
        items = without;
    }
    if !items.is_empty() {
        pieces.push(((Bits::new(1.0), Rc::default()), items));
    }
    pieces
}

impl Program<'_> {
    /// Finds the sums that share partial sums with others; to be called before any is lowered.
    pub(super) fn plan_running(&mut self, sums: &[NodeId]) {
        let mut candidates = Vec::new();
        let mut pairs = 0;
        for &sum in sums {
            for running in self.candidates(sum) {
                pairs += running
                    .pieces
                    .iter()
                    .map(|(_, sum)| sum.len() * sum.len())
                    .sum::<usize>();
                candidates.push((sum, running));
            }
        }
        if pairs > MOST_PAIRS {
            return;
        }
        let lists = candidates.iter().flat_map(|(_, running)| &running.pieces);
        self.running_parts = Shared::find(lists.map(|(_, list)| list.clone()).collect());
        for (sum, running) in candidates {
            let shares = |list: &Product| {
                let list = self.running_parts.product(list.clone());
                list.keys().any(|factor| matches!(factor, Factor::Part(_)))
            };
            if running.pieces.iter().any(|(_, list)| shares(list)) {
                self.running.entry(sum).or_default().push(running);
            }
        }
    }

    /// The terms of a sum that may share partial sums with others.
    fn candidates(&mut self, sum: NodeId) -> Vec<Running> {
        let graph = self.graph;
        let Node::Sum(_, terms) = graph.node(sum) else {
            return Vec::new();
        };
        let split = self.terms(terms);
        let mut by_stage: BTreeMap<usize, Vec<(NodeId, Item)>> = BTreeMap::new();
        for (&(node, _), term) in terms.iter().zip(&split) {
            let size = term.early.0.get();
            let item = Item {
                coefficient: if term.negative { -size } else { size },
                early: term.early.1.to_vec(),
                late: term.late.clone(),
            };
            by_stage.entry(term.stage).or_default().push((node, item));
        }
        by_stage.retain(|_, items| items.len() >= FEWEST_TERMS);
        let running = by_stage.into_iter().map(|(stage, items)| {
            let (terms, mut items): (BTreeSet<_>, Vec<_>) = items.into_iter().unzip();
            let common = take_common(&mut items);
            let negative = items.iter().all(|item| item.coefficient < 0.0);
            for item in &mut items {
                item.coefficient *= if negative { -1.0 } else { 1.0 };
            }
            let list = |items: Vec<Item>| items.iter().map(|item| (item.factor(), 1)).collect();
            let pieces = pieces(items);
            Running {
                stage,
                negative,
                common,
                pieces: pieces
                    .into_iter()
                    .map(|(early, items)| (early, list(items)))
                    .collect(),
                terms,
            }
        });
        running.collect()
    }

    /// The running sums of a sum, and its other terms.
    pub(super) fn apart(&self, sum: NodeId, terms: &[(NodeId, Bits)]) -> (Vec<Running>, Vec<(NodeId, Bits)>) {
        let Some(running) = self.running.get(&sum) else {
            return (Vec::new(), terms.to_vec());
        };
        let inside = |node| running.iter().any(|running| running.terms.contains(node));
        let others = terms.iter().filter(|(node, _)| !inside(node)).copied();
        (running.clone(), others.collect())
    }

    /// The value of a running sum, without its sign.
    pub(super) fn lower_running(&mut self, running: &Running) -> Value {
        let mut sum: Option<Value> = None;
        for (early, list) in &running.pieces {
            let list = self.running_parts.product(list.clone());
            let list = self.lower_list(&list);
            let piece = self.times_early(early, list);
            sum = Some(self.add(sum, false, piece));
        }
        match sum {
            Some(sum) => self.times_early(&running.common, sum),
            None => self.push(Op::Constant(Bits::new(0.0))),
        }
    }

    fn times_early(&mut self, early: &Early, value: Value) -> Value {
        if is_one(early) {
            return value;
        }
        let early = self.lower_early(early);
        self.push(Op::Mul(early, value))
    }

    /// The sum of terms and of shared parts.
    fn lower_list(&mut self, list: &Product) -> Value {
        let mut values: Vec<(bool, bool, Value)> = Vec::new();
        for factor in list.keys() {
            values.push(match factor {
                Factor::Part(place) => (false, false, self.lower_partial_sum(*place)),
                Factor::Early(coefficient, factors) => {
                    let negative = coefficient.get() < 0.0;
                    (negative, true, self.lower_item(coefficient.get().abs(), factors))
                }
                // lists are made of items
                Factor::Node { node, .. } => (false, true, self.lower(*node)),
            });
        }
        values.sort_unstable();
        let mut sum: Option<Value> = None;
        for (negative, _, value) in values {
            sum = Some(self.add(sum, negative, value));
        }
        match sum {
            Some(sum) => sum,
            None => self.push(Op::Constant(Bits::new(0.0))),
        }
    }

    /// A shared partial sum, which may be made of others.
    fn lower_partial_sum(&mut self, place: usize) -> Value {
        if let Some(&value) = self.running_values.get(&place) {
            return value;
        }
        let part = self.running_parts.part(place);
        let value = self.lower_list(&part);
        self.running_values.insert(place, value);
        value
    }

    /// A term without its sign: its factors are told apart again, by when they become known.
    fn lower_item(&mut self, coefficient: f64, factors: &Rc<[(NodeId, i32)]>) -> Value {
        let term = self.early_term(&(Bits::new(coefficient), Rc::clone(factors)));
        self.lower_term(&term)
    }
}
