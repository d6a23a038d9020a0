//! Running sums of series. The rows of a chain of `n` links have sums of `n` terms each, but `2 n` terms in
//! all if they run along the chain (see [`crate::passes::running`]). A term of a sum costs one operation per
//! order.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::lower::{Lower, split};
use super::pairs;
use super::sequence::{Constant, Op, Sequence};
use crate::graph::algebra::factored_sum;
use crate::graph::{Bits, Graph, Node, NodeId, collect};
use crate::hash::{HashMap, HashSet};
use crate::passes::running::{self, EarlyFactor, FEWEST_TERMS, Running, SplitTerm};
use crate::passes::share::{Factor, Product, Shared};

/// The running sums, and the partial sums that they share.
#[derive(Default)]
pub(crate) struct Sums {
    running: HashMap<NodeId, Rc<Running>>,
    shared: Shared,
    /// The shared partial sums that have been lowered.
    parts: HashMap<usize, Sequence>,
}

impl Sums {
    /// The running sums in some expressions; none if they spare less than a quarter of the terms.
    pub(crate) fn find(graph: &mut Graph, outputs: &[NodeId]) -> Self {
        let mut found: Vec<(NodeId, Vec<SplitTerm>)> = Vec::new();
        for sum in sums(graph, outputs) {
            let (terms, _) = graph.terms(sum);
            let items: Vec<SplitTerm> = terms
                .iter()
                .filter_map(|&(term, c)| item(graph, term, c))
                .collect();
            if items.len() >= FEWEST_TERMS {
                found.push((sum, items));
            }
        }
        let before: usize = found.iter().map(|(_, items)| items.len()).sum();
        let mut terms = pairs::join(graph, found.iter_mut().map(|(_, items)| items).collect());
        let running = found.into_iter();
        let mut running: Vec<_> = running
            .map(|(sum, items)| (sum, Running::of(items, true)))
            .collect();
        align(running.iter_mut().flat_map(|(_, running)| &mut running.pieces));
        let shared = running::shared(running.iter().map(|(_, running)| running));
        let mut parts = BTreeSet::new();
        let mut open: Vec<Product> = Vec::new();
        for (_, running) in &running {
            terms += running.pieces.len();
            open.extend(
                running
                    .pieces
                    .iter()
                    .map(|(_, list)| shared.product(list.clone())),
            );
        }
        while let Some(list) = open.pop() {
            if list.len() > 1 {
                terms += list.len();
            }
            for factor in list.keys() {
                if let Factor::Part(place) = *factor
                    && parts.insert(place)
                {
                    open.push(shared.part(place));
                }
            }
        }
        if 4 * terms >= 3 * before {
            return Self::default();
        }
        let running = running.into_iter();
        Self {
            running: running.map(|(sum, running)| (sum, Rc::new(running))).collect(),
            shared,
            parts: HashMap::default(),
        }
    }
}

/// Gives lists of terms the sign with which most of their terms occur in earlier lists, so that two lists
/// that differ by their sign become equal. The factor of a list takes the sign at no cost.
fn align<'r>(pieces: impl Iterator<Item = &'r mut (EarlyFactor, Product)>) {
    let negated = |size: Bits| Bits::new(-size.get());
    let mut known: HashSet<EarlyFactor> = HashSet::default();
    for ((size, _), list) in pieces {
        let mut agree = 0_isize;
        for factor in list.keys() {
            if let Factor::Early(size, factors) = factor {
                agree += isize::from(known.contains(&(*size, Rc::clone(factors))));
                agree -= isize::from(known.contains(&(negated(*size), Rc::clone(factors))));
            }
        }
        if agree < 0 {
            *size = negated(*size);
            let opposite = core::mem::take(list)
                .into_iter()
                .map(|(factor, count)| match factor {
                    Factor::Early(size, factors) => (Factor::Early(negated(size), factors), count),
                    other => (other, count),
                });
            *list = opposite.collect();
        }
        for factor in list.keys() {
            if let Factor::Early(size, factors) = factor
                && !known.contains(&(negated(*size), Rc::clone(factors)))
            {
                known.insert((*size, Rc::clone(factors)));
            }
        }
    }
}

/// The moving sums in some expressions.
fn sums(graph: &Graph, outputs: &[NodeId]) -> Vec<NodeId> {
    let mut sums = graph.subexpressions(outputs.iter().copied(), |id| !graph.is_fixed(id));
    sums.retain(|&id| matches!(graph.node(id), Node::Sum(..)));
    sums
}

/// A moving term: its coefficient and constant factors, with sums among these factored, and its moving
/// factors. `None` for a constant term.
fn item(graph: &mut Graph, term: NodeId, mut coefficient: f64) -> Option<SplitTerm> {
    if graph.is_fixed(term) {
        return None;
    }
    let (fixed, moving) = split(graph, term);
    let mut early = Vec::new();
    for (factor, n) in fixed {
        if n == 1 && matches!(graph.node(factor), Node::Sum(..)) {
            let factored = factored_sum(graph, factor);
            let (size, factored) = graph.split(factored);
            coefficient *= size;
            early.extend(graph.factors(factored));
        } else {
            early.push((factor, n));
        }
    }
    collect(&mut early, |n, more| *n += more);
    early.retain(|&(_, n)| n != 0);
    let late = vec![(graph.product(&moving), 1)];
    Some(SplitTerm {
        coefficient,
        early,
        late,
    })
}

impl Lower<'_> {
    /// The terms of a sum as running sums, with their coefficients; `None` if it has none.
    pub(crate) fn running(&mut self, sum: NodeId) -> Option<Vec<(Constant, Sequence)>> {
        let running = Rc::clone(self.sums.running.get(&sum)?);
        let mut terms = Vec::new();
        for (early, list) in &running.pieces {
            let list = self.sums.shared.product(list.clone());
            let sign = if running.negative { -1.0 } else { 1.0 };
            let factors = [&running.common.1[..], &early.1[..]].concat();
            let factor = self.graph.product(&factors);
            let factor = self
                .graph
                .scale(sign * running.common.0.get() * early.0.get(), factor);
            if let (1, Some((Factor::Early(size, factors), _))) = (list.len(), list.iter().next()) {
                let (c, sequence) = self.term(&(*size, Rc::clone(factors)));
                terms.push((self.graph.mul(factor, c), sequence));
            } else {
                let sequence = self.list(&list);
                terms.push((factor, sequence));
            }
        }
        Some(terms)
    }

    /// The sum of a list of terms and shared partial sums.
    fn list(&mut self, list: &Product) -> Sequence {
        let one = self.graph.constant(1.0);
        let mut terms = Vec::new();
        for factor in list.keys() {
            match factor {
                Factor::Part(place) => terms.insert(0, (one, self.part(*place))),
                Factor::Early(size, factors) => terms.push(self.term(&(*size, Rc::clone(factors)))),
                // does not occur: lists are made of items
                Factor::Node { node, .. } => terms.push((one, self.lower(*node))),
            }
        }
        match terms[..] {
            [(c, sequence)] if c == one => sequence,
            _ => self.sequences.push(Op::Linear(None, terms)),
        }
    }

    /// A shared partial sum, which may contain others.
    fn part(&mut self, place: usize) -> Sequence {
        if let Some(&known) = self.sums.parts.get(&place) {
            return known;
        }
        let part = self.sums.shared.part(place);
        let sequence = self.list(&part);
        self.sums.parts.insert(place, sequence);
        sequence
    }

    /// The coefficient and the sequence of a term.
    fn term(&mut self, (size, factors): &EarlyFactor) -> (Constant, Sequence) {
        let product = self.graph.product(factors);
        let (fixed, moving) = split(self.graph, product);
        let fixed = self.graph.product(&fixed);
        (self.graph.scale(size.get(), fixed), self.product(&moving))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Leaf;
    use crate::mechanics;
    use crate::model::Model;
    use crate::recurrences::plan::Plan;

    /// Rods that hang one from the other or from a pivot, each with a mass at its end; rod `i` hangs from an
    /// earlier one.
    fn rods(parents: &[usize]) -> Model {
        let n = parents.len();
        let places = parents.iter().enumerate().map(|(i, parent)| {
            let [x, y] = match i {
                0 => [String::new(), String::new()],
                _ => [format!("x{parent} +"), format!("y{parent}")],
            };
            format!("let x{i} = {x} l[{i}] * a[{i}].sin(); let y{i} = {y} - l[{i}] * a[{i}].cos();")
        });
        let energy = |i| format!("m[{i}] * ((dot(x{i}).powi(2) + dot(y{i}).powi(2)) / 2 - g * y{i})");
        let (places, energy): (String, Vec<_>) = (places.collect(), (0..n).map(energy).collect());
        let energy = energy.join(" + ");
        let numbers = vec!["1.0"; n].join(", ");
        let text = format!(
            "parameters {{ m = [{numbers}], l = [{numbers}], g = 9.81 }} coordinates(a: [{n}]); {places} lagrangian = {energy};"
        );
        match crate::read("rods", &text, &[]) {
            Ok(text) => text.model,
            Err(mistakes) => panic!("{mistakes:?}"),
        }
    }

    /// Pseudo-random numbers between 1 and 2.
    fn number(seed: usize) -> f64 {
        1.0 + (seed as f64 * 0.618_033_988_749_895).fract()
    }

    /// For each rod, the rod that it hangs from: in a tree one of the three before it, in a chain the last
    /// one.
    fn tree(n: usize, seed: usize) -> Vec<usize> {
        let parent = |i: usize| i.saturating_sub(1 + (seed + 7 * i) * (i + 5) % 11 % 3);
        (0..n).map(parent).collect()
    }

    fn chain(n: usize) -> Vec<usize> {
        (0..n).map(|i| i.saturating_sub(1)).collect()
    }

    /// The number of terms of all sums beyond order 0.
    fn terms(plan: &Plan) -> usize {
        let all = [false, true]
            .into_iter()
            .flat_map(|accelerated| plan.beyond(accelerated));
        let terms = all.map(|(_, op)| match op {
            Op::Linear(_, terms) => terms.len(),
            _ => 0,
        });
        terms.sum()
    }

    #[test]
    fn the_sums_of_a_chain_and_of_a_tree_grow_as_their_number_of_links() {
        let of = |parents: &[usize]| {
            let model = rods(parents);
            terms(&Plan::of(&model, &mut model.graph.clone()))
        };
        for (n, most) in [(8, 20 * 8), (20, 22 * 20)] {
            assert!(of(&chain(n)) <= most, "{n}: {}", of(&chain(n)));
        }
        let binary: Vec<usize> = (0..31_usize).map(|i| i.saturating_sub(1) / 2).collect();
        assert!(of(&binary) <= 20 * 31, "{}", of(&binary));
    }

    #[test]
    fn running_sums_are_worth_what_the_equations_are() {
        let all = [3, 4, 9, 14].map(chain).into_iter();
        let all = all.chain((1..9).map(|seed| tree(8 + 2 * seed, seed)));
        let mut runs = 0;
        for parents in all {
            let model = rods(&parents);
            let mut graph = model.graph.clone();
            let rows = mechanics::continuous(&model, &mut graph).rows;
            let plan = Plan::of(&model, &mut graph);
            let lower = Lower::new(&mut graph, &plan.motion.rows);
            runs += usize::from(!lower.sums.running.is_empty());
            let leaf = |leaf: Leaf| match leaf {
                Leaf::Q(i) => number(i),
                Leaf::V(i) => number(100 + i) - 1.5,
                Leaf::A(i) => number(200 + i) - 1.4,
                _ => f64::NAN,
            };
            let value = |node: NodeId| {
                graph
                    .values(&[node], &leaf, &|param| number(300 + param))
                    .unwrap()[0]
            };
            let mut values = vec![f64::NAN; plan.sequences.ops().count()];
            for (to, op) in plan.sequences.ops() {
                let of = |sequence: &Sequence| values[sequence.index()];
                values[to.index()] = match op {
                    Op::Leaf(which) => leaf(*which),
                    Op::Constant(constant) => value(*constant),
                    Op::Linear(constant, terms) => {
                        let terms = terms.iter().map(|(c, term)| value(*c) * of(term));
                        constant.map_or(0.0, value) + terms.sum::<f64>()
                    }
                    Op::Product(u, v) => of(u) * of(v),
                    Op::Square(u) => of(u) * of(u),
                    Op::Sin(u, _) => of(u).sin(),
                    Op::Cos(u, _) => of(u).cos(),
                    op => panic!("{op:?} in a chain"),
                };
            }
            let rows: Vec<f64> = rows.iter().map(|row| value(row.value)).collect();
            let size = rows.iter().fold(1.0, |size: f64, row| size.max(row.abs()));
            for (&row, sequence) in rows.iter().zip(&plan.rows) {
                let own = values[sequence.index()];
                assert!((row - own).abs() < 1e-13 * size, "{parents:?}: {row} {own}");
            }
        }
        assert!(runs > 8, "{runs} run");
    }
}
