//! Rows solved for unknowns when the code is generated.
//!
//! A row that is linear in an unknown, with a coefficient that is known early, is solved for it, and the solution put into
//! the other rows. That is what the paper does by hand with the pendulum: the variational equation gives `ψ₂`, and one
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
        while let Some((row, unknown, coefficient)) = self.linear_row(graph, rule) {
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

    /// A row, an unknown in which it is linear, and the coefficient: the simplest there is.
    fn linear_row(&self, graph: &mut Graph, rule: Rule) -> Option<(usize, Leaf, NodeId)> {
        let mut best: Option<(u32, (usize, Leaf, NodeId))> = None;
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
                if best.as_ref().is_none_or(|(smallest, _)| size < *smallest) {
                    best = Some((size, (row, unknown, coefficient)));
                }
            }
        }
        best.map(|(_, choice)| choice)
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
