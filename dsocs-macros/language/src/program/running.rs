//! Running sums of a program, each of the terms of a sum that become known at one stage (see
//! [`crate::passes::running`]).

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::sums::is_one;
use super::{Op, Program, Value};
use crate::graph::{Bits, Node, NodeId};
use crate::passes::running::{self, EarlyFactor, FEWEST_TERMS, SplitTerm};
use crate::passes::share::{Factor, Product};

/// The terms of a sum that become known at one stage.
#[derive(Clone, Debug)]
pub(super) struct Running {
    pub(super) stage: usize,
    /// The terms in groups with common factors.
    pub(super) sums: running::Running,
    /// The nodes of the terms.
    terms: BTreeSet<NodeId>,
}

impl Program<'_> {
    /// Finds the sums that share partial sums with others; to be called before any sum is lowered.
    pub(super) fn plan_running(&mut self, sums: &[NodeId]) {
        let mut candidates = Vec::new();
        for &sum in sums {
            let running = self.candidates(sum).into_iter();
            candidates.extend(running.map(|running| (sum, running)));
        }
        self.running_parts = running::shared(candidates.iter().map(|(_, running)| &running.sums));
        for (sum, running) in candidates {
            let shares = |list: &Product| {
                let list = self.running_parts.searched(list).unwrap_or(list);
                list.keys().any(|factor| matches!(factor, Factor::Part(_)))
            };
            if running.sums.pieces.iter().any(|(_, list)| shares(list)) {
                self.running.entry(sum).or_default().push(Rc::new(running));
            }
        }
    }

    /// For each stage, the terms of a sum that may share partial sums with others.
    fn candidates(&mut self, sum: NodeId) -> Vec<Running> {
        let graph = self.graph;
        let Node::Sum(_, terms) = graph.node(sum) else {
            return Vec::new();
        };
        let split = self.terms(terms);
        let mut by_stage: BTreeMap<usize, Vec<(NodeId, SplitTerm)>> = BTreeMap::new();
        for (&(node, _), term) in terms.iter().zip(split) {
            let size = term.early.0.get();
            let item = SplitTerm {
                coefficient: if term.negative { -size } else { size },
                early: term.early.1.to_vec(),
                late: term.late,
            };
            by_stage.entry(term.stage).or_default().push((node, item));
        }
        by_stage.retain(|_, items| items.len() >= FEWEST_TERMS);
        let running = by_stage.into_iter().map(|(stage, items)| {
            let (terms, items): (BTreeSet<_>, Vec<_>) = items.into_iter().unzip();
            Running {
                stage,
                sums: running::Running::of(items, false),
                terms,
            }
        });
        running.collect()
    }

    /// The terms of a sum that are in none of its running sums.
    pub(super) fn terms_outside_running(&self, sum: NodeId, terms: &[(NodeId, Bits)]) -> Vec<(NodeId, Bits)> {
        let Some(running) = self.running.get(&sum) else {
            return terms.to_vec();
        };
        let inside = |node| running.iter().any(|running| running.terms.contains(node));
        let others = terms.iter().filter(|(node, _)| !inside(node)).copied();
        others.collect()
    }

    /// The value of a running sum, without its sign.
    pub(super) fn lower_running(&mut self, running: &running::Running) -> Value {
        let mut sum: Option<Value> = None;
        for (early, list) in &running.pieces {
            let shared = self.running_parts.searched(list).cloned();
            let list = self.lower_list(shared.as_ref().unwrap_or(list));
            let piece = self.times_early(early, list);
            sum = Some(self.add(sum, false, piece));
        }
        match sum {
            Some(sum) => self.times_early(&running.common, sum),
            None => self.push(Op::Constant(Bits::new(0.0))),
        }
    }

    fn times_early(&mut self, early: &EarlyFactor, value: Value) -> Value {
        if is_one(early) {
            return value;
        }
        let early = self.lower_early(early);
        self.push(Op::Mul(early, value))
    }

    /// The sum of a list of terms and shared partial sums.
    fn lower_list(&mut self, list: &Product) -> Value {
        let mut values: Vec<(bool, bool, Value)> = Vec::new();
        for factor in list.keys() {
            values.push(match factor {
                Factor::Part(place) => (false, false, self.lower_partial_sum(*place)),
                Factor::Early(coefficient, factors) => {
                    let negative = coefficient.get() < 0.0;
                    (negative, true, self.lower_item(coefficient.get().abs(), factors))
                }
                // does not occur: lists are made of items
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

    /// A shared partial sum, which may contain others.
    fn lower_partial_sum(&mut self, place: usize) -> Value {
        if let Some(&value) = self.running_values.get(&place) {
            return value;
        }
        let part = self.running_parts.part(place);
        let value = self.lower_list(&part);
        self.running_values.insert(place, value);
        value
    }

    /// A term without its sign; its factors are split again into early and late ones.
    fn lower_item(&mut self, coefficient: f64, factors: &Rc<[(NodeId, i32)]>) -> Value {
        let term = self.early_term(&(Bits::new(coefficient), Rc::clone(factors)));
        self.lower_term(&term)
    }
}
