//! Rows solved for unknowns when the code is generated.
//!
//! A row that is linear in an unknown, with a coefficient that is known early, is solved for it, and the solution put into
//! the other rows. A coefficient with parameters may be zero, and is divided by only if the rows could not be solved anyhow
//! where it is ([`Graph::has_to_be_nonzero`]): a mass is, a stiffness is not. Nor is divided by a coefficient that vanishes with the step beside another of the
//! row, such as that of a spring between two masses beside a mass: the solution would be a difference of large numbers. Other rows, and constraints of several accelerations ([`crate::mechanics::equation::Pivots`]),
//! are left to pivots in numbers. That is what the paper does by hand with the pendulum: the variational equation gives `ψ₂`, and one
//! equation for `θ₂` is left. A system whose rows are all of this kind has no unknowns left and takes no iteration.

use crate::graph::algebra::Merge;
use crate::graph::{Graph, Leaf, NodeId, Slopes, Substitution};
use crate::hash::HashMap;
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

/// What was found of a row.
struct Found {
    /// The row as it was then.
    row: NodeId,
    /// Whether it was asked for coefficients that are all known early.
    only_early: bool,
    candidates: Vec<Candidate>,
}

/// An unknown for which a row may be solved.
struct Candidate {
    /// Whether parameters are in the coefficient, and how long it is.
    order: (bool, u32),
    unknown: Leaf,
    coefficient: NodeId,
}

/// The unknowns that an expression depends on, with their places, in order.
fn unknowns(graph: &Graph, id: NodeId, places: &HashMap<Leaf, usize>) -> Vec<(usize, Leaf)> {
    let leaves = graph.leaves(id);
    let mut unknown: Vec<_> = leaves
        .filter_map(|leaf| Some((*places.get(&leaf)?, leaf)))
        .collect();
    unknown.sort_unstable_by_key(|&(place, _)| place);
    unknown
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
        let mut safe = HashMap::default();
        let mut found: Vec<Option<Found>> = self.rows.iter().map(|_| None).collect();
        while let Some(pivot) = self.linear_row(graph, rule, &mut safe, &mut found) {
            found.remove(pivot.0);
            self.solve(graph, pivot);
        }
    }

    /// Solves one row more, if the rule admits any.
    pub(super) fn run_once(&mut self, graph: &mut Graph, rule: Rule) -> bool {
        let mut found: Vec<Option<Found>> = self.rows.iter().map(|_| None).collect();
        let pivot = self.linear_row(graph, rule, &mut HashMap::default(), &mut found);
        pivot.is_some_and(|pivot| {
            self.solve(graph, pivot);
            true
        })
    }

    /// Solves a row for an unknown, in which it is linear with the coefficient.
    fn solve(&mut self, graph: &mut Graph, (row, unknown, coefficient): (usize, Leaf, NodeId)) {
        let equation = self.rows.remove(row);
        let zero = graph.constant(0.0);
        let rest = graph.substitute(equation.value, &HashMap::from_iter([(unknown, zero)]));
        let quotient = graph.div(rest, coefficient);
        let solution = graph.neg(quotient);
        self.put(graph, &[(unknown, solution)]);
    }

    /// Puts solutions in the place of unknowns everywhere.
    pub(super) fn put(&mut self, graph: &mut Graph, solutions: &[(Leaf, NodeId)]) {
        let places = solutions.iter().copied().collect();
        let earlier = self.solved.iter_mut().map(|(_, solution)| solution);
        let rows = self.rows.iter_mut().flat_map(Equation::parts);
        let affected = rows.chain(earlier).filter(|part| {
            solutions
                .iter()
                .any(|&(solved, _)| graph.depends_on(**part, solved))
        });
        let affected: Vec<_> = affected.collect();
        graph.rewrite_all(affected, &mut Substitution::new(&places));
        self.solved.extend(solutions);
        self.unknown
            .retain(|leaf| solutions.iter().all(|(solved, _)| solved != leaf));
    }

    /// A row, an unknown in which it is linear, and the coefficient: the simplest there is, and without parameters if possible. What was
    /// found of rows stays, as long as they do: most of them do not depend on what is solved.
    fn linear_row(
        &self,
        graph: &mut Graph,
        rule: Rule,
        safe: &mut HashMap<NodeId, bool>,
        found: &mut [Option<Found>],
    ) -> Option<(usize, Leaf, NodeId)> {
        let mut sizes = Merge::default();
        let places: HashMap<Leaf, usize> = self.unknown.iter().copied().zip(0..).collect();
        let only_early = self.unknown.len() > rule.most_unknowns;
        for (equation, found) in self.rows.iter().zip(found.iter_mut()) {
            let holds = |found: &Found| found.row == equation.value && found.only_early == only_early;
            if !found.as_ref().is_some_and(holds) {
                let mut candidates = Vec::new();
                if equation.divide.is_none() {
                    candidates =
                        Self::candidates(graph, rule, equation.value, only_early, (&places, &mut sizes));
                    candidates.retain(|candidate| equation.pivots.contain(candidate.unknown));
                }
                *found = Some(Found {
                    row: equation.value,
                    only_early,
                    candidates,
                });
            }
        }
        // on a copy: the order of terms is that in which nodes were made, and a question should not change it
        let mut copy = None;
        loop {
            let candidates = found.iter().enumerate().flat_map(|(row, found)| {
                let candidates = found.iter().flat_map(|found| &found.candidates);
                candidates.map(move |candidate| (row, candidate))
            });
            // of equal ones the first
            let (row, best) = candidates
                .filter(|(_, candidate)| safe.get(&candidate.coefficient) != Some(&false))
                .min_by_key(|(_, candidate)| candidate.order)?;
            let Candidate {
                unknown, coefficient, ..
            } = *best;
            let is_safe = *safe.entry(coefficient).or_insert_with(|| {
                let (graph, slopes) = copy.get_or_insert_with(|| {
                    let mut copy = graph.clone();
                    let slopes = self.slopes(&mut copy, &places);
                    (copy, slopes)
                });
                graph.has_to_be_nonzero(coefficient, slopes)
            });
            if is_safe {
                return Some((row, unknown, coefficient));
            }
        }
    }

    /// The unknowns for which a row may be solved.
    fn candidates(
        graph: &mut Graph,
        rule: Rule,
        row: NodeId,
        only_early: bool,
        (places, sizes): (&HashMap<Leaf, usize>, &mut Merge),
    ) -> Vec<Candidate> {
        let unknown = unknowns(graph, row, places);
        let is_early = |graph: &mut Graph, leaf| {
            let slope = graph.derivative(row, leaf);
            (rule.early)(graph, slope)
        };
        if only_early && !unknown.iter().all(|&(_, leaf)| is_early(graph, leaf)) {
            return Vec::new();
        }
        let is_difference = |leaf: Leaf| matches!(leaf, Leaf::E(_));
        let differences = unknown.iter().filter(|&&(_, leaf)| is_difference(leaf));
        let powers = differences.filter_map(|&(_, leaf)| {
            let slope = graph.derivative(row, leaf);
            graph.power_of_step(slope)
        });
        let least_power = powers.min();
        let mut candidates = Vec::new();
        for &(_, unknown) in unknown.iter().rev() {
            let coefficient = graph.derivative(row, unknown);
            // a zero that the normal form does not see would be divided by, and a row that jumps is not linear
            if !(rule.early)(graph, coefficient)
                || (is_difference(unknown) && graph.power_of_step(coefficient) > least_power)
                || graph.jumps_with(row, unknown)
                || graph.vanishes(coefficient)
            {
                continue;
            }
            candidates.push(Candidate {
                order: (graph.has_parameters(coefficient), sizes.size(graph, coefficient)),
                unknown,
                coefficient,
            });
        }
        candidates
    }

    /// The derivatives of the rows by the unknowns.
    fn slopes(&self, graph: &mut Graph, places: &HashMap<Leaf, usize>) -> Slopes {
        let rows = self.rows.iter().map(|row| {
            let unknown = unknowns(graph, row.value, places).into_iter();
            unknown
                .map(|(place, leaf)| (place, graph.derivative(row.value, leaf)))
                .collect()
        });
        Slopes {
            rows: rows.collect(),
            columns: self.unknown.len(),
        }
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
