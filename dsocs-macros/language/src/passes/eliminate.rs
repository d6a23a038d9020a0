//! Rows solved symbolically for unknowns.
//!
//! A row that is linear in an unknown, with a coefficient that is known early, is solved for it, and the
//! solution is substituted in the other rows. A coefficient with parameters may be zero. It is divided by
//! only if the rows are singular anyhow where it is zero ([`Graph::has_to_be_nonzero`]): that holds for a
//! mass, not for a stiffness. Nor is a coefficient divided by that vanishes with the step faster than another
//! one of the row, such as that of a spring between two masses beside a mass: the solution would be a
//! difference of large numbers. Other rows, and constraints with several accelerations
//! ([`crate::mechanics::equation::Pivots`]), are left to the numerical elimination. The paper does the same
//! by hand for the pendulum: the variational equation gives `ψ₂`, and one equation for `θ₂` is left. A system
//! in which every row is solved this way has no unknowns left and needs no iteration.

use crate::graph::algebra::Merge;
use crate::graph::{Graph, Leaf, NodeId, Slopes, Substitution};
use crate::hash::HashMap;
use crate::mechanics::Equation;

/// The rule that decides which rows are solved.
#[derive(Clone, Copy)]
pub(super) struct Rule {
    /// Whether a coefficient is known early enough to divide by it.
    pub(super) early: fn(&Graph, NodeId) -> bool,
    /// With more unknowns than this, a row is solved only if all its coefficients are known early:
    /// substituted in many other rows, a solution with products of its own would multiply them.
    pub(super) most_unknowns: usize,
}

/// The rows that are left, their unknowns, and the solutions for the other unknowns.
pub(super) struct Elimination {
    pub(super) rows: Vec<Equation>,
    pub(super) unknown: Vec<Leaf>,
    pub(super) solved: Vec<(Leaf, NodeId)>,
}

/// The candidates found in a row, kept while the row does not change.
struct RowCandidates {
    /// The row for which they were found.
    row: NodeId,
    /// Whether only rows with all coefficients known early had candidates.
    only_early: bool,
    candidates: Vec<Candidate>,
}

/// An unknown for which a row may be solved.
struct Candidate {
    /// The preference, lowest first: whether the coefficient has parameters, and its length.
    order: (bool, u32),
    unknown: Leaf,
    coefficient: NodeId,
}

/// The unknowns that an expression depends on, with their indices, in order.
fn unknowns(graph: &Graph, id: NodeId, places: &HashMap<Leaf, usize>) -> Vec<(usize, Leaf)> {
    let leaves = graph.leaves(id);
    let mut unknown: Vec<_> = leaves
        .filter_map(|leaf| Some((*places.get(&leaf)?, leaf)))
        .collect();
    unknown.sort_unstable_by_key(|&(place, _)| place);
    unknown
}

impl Elimination {
    /// The system before any row is solved.
    pub(super) fn new(rows: &[Equation], unknown: impl Iterator<Item = Leaf>) -> Self {
        Self {
            rows: rows.to_vec(),
            unknown: unknown.collect(),
            solved: Vec::new(),
        }
    }

    /// Solves rows as long as the rule admits any.
    pub(super) fn run(&mut self, graph: &mut Graph, rule: Rule) {
        // the verdicts on coefficients. They stay valid while rows are solved, because the determinant of the
        // rows that are left is that of all rows, divided by coefficients that are not zero
        let mut safe = HashMap::default();
        let mut found: Vec<Option<RowCandidates>> = self.rows.iter().map(|_| None).collect();
        while let Some(pivot) = self.linear_row(graph, rule, &mut safe, &mut found) {
            found.remove(pivot.0);
            self.solve(graph, pivot);
        }
    }

    /// Solves one row, if the rule admits any.
    pub(super) fn run_once(&mut self, graph: &mut Graph, rule: Rule) -> bool {
        let mut found: Vec<Option<RowCandidates>> = self.rows.iter().map(|_| None).collect();
        let pivot = self.linear_row(graph, rule, &mut HashMap::default(), &mut found);
        pivot.is_some_and(|pivot| {
            self.solve(graph, pivot);
            true
        })
    }

    /// Solves a row for an unknown in which it is linear, with this coefficient.
    fn solve(&mut self, graph: &mut Graph, (row, unknown, coefficient): (usize, Leaf, NodeId)) {
        let equation = self.rows.remove(row);
        let zero = graph.constant(0.0);
        let rest = graph.substitute(equation.value, &HashMap::from_iter([(unknown, zero)]));
        let quotient = graph.div(rest, coefficient);
        let solution = graph.neg(quotient);
        self.put(graph, &[(unknown, solution)]);
    }

    /// Substitutes solutions for unknowns, in the rows and in earlier solutions.
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

    /// The next row to solve, its unknown and the coefficient: the simplest admitted one, without parameters
    /// if possible. The candidates of rows that have not changed are kept in `found`.
    fn linear_row(
        &self,
        graph: &mut Graph,
        rule: Rule,
        safe: &mut HashMap<NodeId, bool>,
        found: &mut [Option<RowCandidates>],
    ) -> Option<(usize, Leaf, NodeId)> {
        let mut sizes = Merge::default();
        let places: HashMap<Leaf, usize> = self.unknown.iter().copied().zip(0..).collect();
        let only_early = self.unknown.len() > rule.most_unknowns;
        for (equation, found) in self.rows.iter().zip(found.iter_mut()) {
            let holds = |found: &RowCandidates| found.row == equation.value && found.only_early == only_early;
            if !found.as_ref().is_some_and(holds) {
                let mut candidates = Vec::new();
                if equation.divide.is_none() {
                    candidates =
                        Self::candidates(graph, rule, equation.value, only_early, (&places, &mut sizes));
                    candidates.retain(|candidate| equation.pivots.contain(candidate.unknown));
                }
                *found = Some(RowCandidates {
                    row: equation.value,
                    only_early,
                    candidates,
                });
            }
        }
        // on a copy: terms are ordered by the age of their nodes, and the test must not change that order
        let mut copy = None;
        loop {
            let candidates = found.iter().enumerate().flat_map(|(row, found)| {
                let candidates = found.iter().flat_map(|found| &found.candidates);
                candidates.map(move |candidate| (row, candidate))
            });
            // the first one of equals
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

    /// The unknowns for which a row may be solved, with their coefficients.
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
            // refuses a zero that the normal form does not show, and a row that may jump, which is not linear
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

    /// For each leaf, its solution if it is solved, else the leaf itself.
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
