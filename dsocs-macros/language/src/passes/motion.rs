//! The accelerations of the continuous system as expressions of position and velocity.
//!
//! Rows are solved here, when the code is generated, as far as that keeps the recurrences short: rows that are linear in
//! an acceleration with a coefficient of the parameters alone by substitution, up to two rows that are left by Cramer's
//! rule. More rows, and rows that are not affine, stay equations, which are solved once an order with one matrix.

use std::collections::HashMap;

use super::collapse::{Collapse, Variables};
use super::horner::Horner;
use super::merge::Merge;
use super::simplify::Simplify;
use crate::graph::{Graph, Leaf, NodeId};
use crate::mechanics::{self, Equation};
use crate::model::Model;

/// So many rows are solved by Cramer's rule; beyond, the determinants cost more than an elimination in numbers.
const MOST_ROWS: usize = 2;

/// What the code of some expressions costs.
pub(crate) type Cost = fn(&mut Graph, &[NodeId]) -> usize;

/// The accelerations, and the equations of those that stay unknown.
pub(crate) struct Motion {
    /// The acceleration of every coordinate, in `Q`, `V` and those `A` that stay unknown.
    pub(crate) accelerations: Vec<NodeId>,
    /// The accelerations `A` and multipliers `Lambda` that stay unknown.
    pub(crate) unknown: Vec<Leaf>,
    /// As many rows, in `Q`, `V` and the unknown ones.
    pub(crate) rows: Vec<NodeId>,
    /// `∂rows[i]/∂unknown[j]`.
    pub(crate) jacobian: Vec<Vec<NodeId>>,
    /// How many multipliers there are in all.
    pub(crate) multipliers: usize,
    /// Whether the rows are affine in them.
    pub(crate) affine: bool,
}

/// A system that is being solved.
struct Solving<'g> {
    graph: &'g mut Graph,
    rows: Vec<Equation>,
    unknown: Vec<Leaf>,
    solved: Vec<(Leaf, NodeId)>,
}

/// The motion of a declaration.
pub(crate) fn motion(model: &Model, graph: &mut Graph, cost: Cost) -> Motion {
    let n = model.coordinates.len();
    let rows = mechanics::continuous(model, graph).rows;
    let mut solving = Solving {
        graph,
        rows,
        unknown: (0..n)
            .map(Leaf::A)
            .chain((0..model.multipliers()).map(Leaf::Lambda))
            .collect(),
        solved: Vec::new(),
    };
    solving.eliminate();
    solving.divide(n);
    solving.eliminate();
    solving.cramer();
    solving.finish(n, model.multipliers(), cost)
}

impl Solving<'_> {
    /// Solves rows that are linear in an acceleration with a coefficient of the parameters alone.
    fn eliminate(&mut self) {
        while let Some((row, unknown, coefficient)) = self.linear_row() {
            let equation = self.rows.remove(row);
            let zero = self.graph.constant(0.0);
            let map = HashMap::from([(unknown, zero)]);
            let rest = self.graph.substitute(equation.value, &map);
            let quotient = self.graph.div(rest, coefficient);
            let solution = self.graph.neg(quotient);
            self.put(&[(unknown, solution)]);
        }
    }

    /// Puts solutions in the place of accelerations everywhere.
    fn put(&mut self, solutions: &[(Leaf, NodeId)]) {
        let map = solutions.iter().copied().collect();
        let mut done = HashMap::new();
        for part in self.rows.iter_mut().flat_map(Equation::parts) {
            *part = self.graph.substitute_in(*part, &map, &mut done);
        }
        for (_, earlier) in &mut self.solved {
            *earlier = self.graph.substitute_in(*earlier, &map, &mut done);
        }
        self.solved.extend(solutions);
        self.unknown
            .retain(|leaf| solutions.iter().all(|(solved, _)| solved != leaf));
    }

    /// A row, an unknown in which it is linear, and the coefficient: the simplest there is.
    fn linear_row(&mut self) -> Option<(usize, Leaf, NodeId)> {
        let mut best: Option<(u32, (usize, Leaf, NodeId))> = None;
        let mut merge = Merge::default();
        for (row, equation) in self.rows.clone().into_iter().enumerate() {
            if equation.divide.is_some() {
                continue;
            }
            // put into many other rows, a solution with products of its own would multiply them
            let few = self.unknown.len() <= MOST_ROWS;
            if !few && !self.constant_coefficients(equation.value) {
                continue;
            }
            for &leaf in self.unknown.iter().rev() {
                if !self.graph.depends_on(equation.value, leaf) {
                    continue;
                }
                let coefficient = self.graph.derivative(equation.value, leaf);
                let constant = self.graph.is_fixed(coefficient);
                if !constant || self.graph.vanishes(coefficient) {
                    continue;
                }
                let size = merge.size(self.graph, coefficient);
                if best.as_ref().is_none_or(|(smallest, _)| size < *smallest) {
                    best = Some((size, (row, leaf, coefficient)));
                }
            }
        }
        best.map(|(_, choice)| choice)
    }

    /// Whether a row is linear in the accelerations with coefficients of the parameters alone.
    fn constant_coefficients(&mut self, row: NodeId) -> bool {
        self.unknown.iter().all(|&leaf| {
            let slope = self.graph.derivative(row, leaf);
            self.graph.is_fixed(slope)
        })
    }

    /// Divides the declared factors out. They are of order 1 at most, and where the other rows hold they divide as
    /// polynomials in a velocity.
    fn divide(&mut self, n: usize) {
        let mut leaves: Vec<Leaf> = (0..n).map(Leaf::V).collect();
        leaves.extend((0..n).map(Leaf::Q));
        for row in &mut self.rows {
            if let Some(factor) = row.divide.take() {
                row.value = self.graph.quotient(row.value, factor, &leaves);
            }
        }
        let mut collapse = Collapse::new(self.graph, Variables::Motion);
        for row in &mut self.rows {
            row.value = collapse.rewrite(row.value);
        }
    }

    /// Solves a row or two that are affine in as many accelerations.
    fn cramer(&mut self) {
        let m = self.unknown.len();
        if m == 0 || m > MOST_ROWS || !self.affine() {
            return;
        }
        let zero = self.graph.constant(0.0);
        let map = self.unknown.iter().map(|&leaf| (leaf, zero)).collect();
        let mut matrix = Vec::new();
        let mut right = Vec::new();
        for row in self.rows.clone() {
            let rest = self.graph.substitute(row.value, &map);
            right.push(self.graph.neg(rest));
            let coefficients: Vec<NodeId> = self
                .unknown
                .clone()
                .into_iter()
                .map(|leaf| self.graph.derivative(row.value, leaf))
                .collect();
            matrix.push(coefficients);
        }
        let solutions = if m == 1 {
            if self.graph.vanishes(matrix[0][0]) {
                return; // no such system determines its motion; the numbers will tell
            }
            vec![self.graph.div(right[0], matrix[0][0])]
        } else {
            let determinant = self.two_by_two([matrix[0][0], matrix[0][1]], [matrix[1][0], matrix[1][1]]);
            if self.graph.vanishes(determinant) {
                return;
            }
            let first = self.two_by_two([right[0], matrix[0][1]], [right[1], matrix[1][1]]);
            let second = self.two_by_two([matrix[0][0], right[0]], [matrix[1][0], right[1]]);
            // common factors of numerator and denominator cancel where both are products
            let mut simplify = Simplify::default();
            [first, second]
                .map(|numerator| {
                    let parts = [numerator, determinant].map(|part| simplify.rewrite(self.graph, part));
                    self.graph.div(parts[0], parts[1])
                })
                .to_vec()
        };
        let solutions: Vec<_> = self.unknown.iter().copied().zip(solutions).collect();
        self.rows.clear();
        self.put(&solutions);
    }

    fn two_by_two(&mut self, [a, b]: [NodeId; 2], [c, d]: [NodeId; 2]) -> NodeId {
        let (left, right) = (self.graph.mul(a, d), self.graph.mul(b, c));
        self.graph.sub(left, right)
    }

    /// Whether every row is affine in the unknown accelerations.
    fn affine(&mut self) -> bool {
        let unknown = self.unknown.clone();
        self.rows.clone().into_iter().all(|row| {
            unknown.iter().all(|&leaf| {
                let slope = self.graph.derivative(row.value, leaf);
                unknown.iter().all(|&other| !self.graph.depends_on(slope, other))
            })
        })
    }

    /// Brings the result into the form with the shortest recurrences.
    fn finish(mut self, n: usize, multipliers: usize, cost: Cost) -> Motion {
        let affine = self.affine();
        let graph = self.graph;
        let mut accelerations: Vec<NodeId> = (0..n).map(|i| graph.leaf(Leaf::A(i))).collect();
        for (leaf, solution) in self.solved {
            if let Leaf::A(i) = leaf {
                accelerations[i] = solution;
            }
        }
        let mut rows: Vec<NodeId> = self.rows.iter().map(|row| row.value).collect();
        let mut all = [accelerations.as_mut_slice(), rows.as_mut_slice()].concat();
        tidy(graph, &mut all);
        let rows = gathered(graph, &all[n..], cost);
        all.truncate(n);
        let jacobian = rows
            .iter()
            .map(|&row| {
                self.unknown
                    .iter()
                    .map(|&leaf| graph.derivative(row, leaf))
                    .collect()
            })
            .collect();
        Motion {
            accelerations: all,
            unknown: self.unknown,
            rows,
            jacobian,
            multipliers,
            affine,
        }
    }
}

/// Rows multiplied out and gathered, if that leaves fewer products.
fn gathered(graph: &mut Graph, rows: &[NodeId], cost: Cost) -> Vec<NodeId> {
    let mut horner = Horner::default();
    let rewritten: Option<Vec<NodeId>> = rows.iter().map(|&row| horner.rewrite(graph, row)).collect();
    match rewritten {
        Some(rewritten) if cost(graph, &rewritten) < cost(graph, rows) => rewritten,
        _ => rows.to_vec(),
    }
}

/// Brings expressions into the form with the shortest recurrences.
fn tidy(graph: &mut Graph, nodes: &mut [NodeId]) {
    let mut collapse = Collapse::new(graph, Variables::Motion);
    for node in nodes.iter_mut() {
        *node = collapse.rewrite(*node);
    }
    let mut simplify = Simplify::default();
    for node in nodes.iter_mut() {
        *node = simplify.rewrite(graph, *node);
    }
    let mut merge = Merge::default();
    for node in nodes {
        *node = merge.rewrite(graph, *node);
    }
}
