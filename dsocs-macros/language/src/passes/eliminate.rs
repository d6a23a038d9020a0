//! Rows solved for unknowns when the code is generated.
//!
//! A row that is linear in an unknown, with a coefficient that is known early, is solved for it, and the solution put into
//! the other rows. A coefficient with parameters may be zero, and is divided by only if the rows could not be solved anyhow
//! where it is ([`Graph::has_to_be_nonzero`]): a mass is, a stiffness is not. Other rows are left to pivots in numbers. That is what the paper does by hand with the pendulum: the variational equation gives `ψ₂`, and one
//! equation for `θ₂` is left. A system whose rows are all of this kind has no unknowns left and takes no iteration.

use std::collections::HashMap;

use super::Merge;
use crate::graph::{Graph, Leaf, NodeId, Substitution};
use crate::mechanics::Equation;

/// Which rows are solved.
#[derive(Clone, Copy)]
pub(super) struct Rule {
    /// Whether a coefficient is known early enough to be divided by.
    pub(super) early: fn(&Graph, NodeId) -> bool,
    /// With more unknowns than these, only rows are solved whose coefficients are all known early: put into many other
    /// rows, a solution with products of its own would multiply them.
    pub(super) most_unknowns: usize,
}

/// Rows, the unknowns that are left in them, and the solutions for the others.
pub(super) struct Elimination {
    pub(super) rows: Vec<Equation>,
    pub(super) unknown: Vec<Leaf>,
    pub(super) solved: Vec<(Leaf, NodeId)>,
}

impl Elimination {
    /// Nothing is solved yet.
    pub(super) fn new(rows: &[Equation], unknown: impl Iterator<Item = Leaf>) -> Self {
        Self {
            rows: rows.to_vec(),
            unknown: unknown.collect(),
            solved: Vec::new(),
        }
    }

    /// Solves rows as long as there are any that the rule admits.
    pub(super) fn run(&mut self, graph: &mut Graph, rule: Rule) {
        // what has been found of coefficients: it does not change with what is solved, because the determinant of the rows that
        // are left is that of all rows, divided by coefficients that are not zero
        let mut safe = HashMap::new();
        while let Some((row, unknown, coefficient)) = self.linear_row(graph, rule, &mut safe) {
            let equation = self.rows.remove(row);
            let zero = graph.constant(0.0);
            let rest = graph.substitute(equation.value, &HashMap::from([(unknown, zero)]));
            let quotient = graph.div(rest, coefficient);
            let solution = graph.neg(quotient);
            self.put(graph, &[(unknown, solution)]);
        }
    }

    /// Puts solutions in the place of unknowns everywhere.
    pub(super) fn put(&mut self, graph: &mut Graph, solutions: &[(Leaf, NodeId)]) {
        let places = solutions.iter().copied().collect();
        let earlier = self.solved.iter_mut().map(|(_, solution)| solution);
        let rows = self.rows.iter_mut().flat_map(Equation::parts);
        graph.rewrite_all(rows.chain(earlier), &mut Substitution::new(&places));
        self.solved.extend(solutions);
        self.unknown
            .retain(|leaf| solutions.iter().all(|(solved, _)| solved != leaf));
    }

    /// A row, an unknown in which it is linear, and the coefficient: the simplest there is, and without parameters if possible.
    fn linear_row(
        &self,
        graph: &mut Graph,
        rule: Rule,
        safe: &mut HashMap<NodeId, bool>,
    ) -> Option<(usize, Leaf, NodeId)> {
        let mut candidates = Vec::new();
        let mut merge = Merge::default();
        for (row, equation) in self.rows.iter().enumerate() {
            if equation.divide.is_some() {
                continue;
            }
            let equation = equation.value;
            if self.unknown.len() > rule.most_unknowns && !self.all_early(graph, rule, equation) {
                continue;
            }
            for &unknown in self.unknown.iter().rev() {
                if !graph.depends_on(equation, unknown) {
                    continue;
                }
                let coefficient = graph.derivative(equation, unknown);
                // a zero that the normal form does not see would be divided by
                if !(rule.early)(graph, coefficient) || graph.vanishes(coefficient) {
                    continue;
                }
                let size = merge.size(graph, coefficient);
                let order = (graph.has_parameters(coefficient), size);
                candidates.push((order, (row, unknown, coefficient)));
            }
        }
        // stable: of equal ones the first
        candidates.sort_by_key(|&(order, _)| order);
        // on a copy: the order of terms is that in which nodes were made, and a question should not change it
        let mut copy = None;
        candidates
            .into_iter()
            .map(|(_, candidate)| candidate)
            .find(|&(_, _, coefficient)| {
                *safe.entry(coefficient).or_insert_with(|| {
                    let (graph, slopes) = copy.get_or_insert_with(|| {
                        let mut copy = graph.clone();
                        let slopes = self.slopes(&mut copy);
                        (copy, slopes)
                    });
                    graph.has_to_be_nonzero(coefficient, slopes)
                })
            })
    }

    /// The derivatives of the rows by the unknowns.
    fn slopes(&self, graph: &mut Graph) -> Vec<Vec<NodeId>> {
        let rows = self.rows.iter().map(|row| {
            let unknown = self.unknown.iter();
            unknown.map(|&leaf| graph.derivative(row.value, leaf)).collect()
        });
        rows.collect()
    }

    /// Whether a row is linear in the unknowns, with coefficients that are all known early.
    fn all_early(&self, graph: &mut Graph, rule: Rule, row: NodeId) -> bool {
        self.unknown.iter().all(|&leaf| {
            let slope = graph.derivative(row, leaf);
            (rule.early)(graph, slope)
        })
    }

    /// What has become of some unknowns: the solution for each that is solved, itself for the others.
    pub(super) fn solutions(&self, graph: &mut Graph, leaves: impl Iterator<Item = Leaf>) -> Vec<NodeId> {
        let solution = |leaf| self.solved.iter().find(|&&(solved, _)| solved == leaf);
        leaves
            .map(|leaf| match solution(leaf) {
                Some(&(_, solution)) => solution,
                None => graph.leaf(leaf),
            })
            .collect()
    }
}
