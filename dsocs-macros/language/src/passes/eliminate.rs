//! Which second differences Newton's iteration looks for, and which follow from them.
//!
//! A row that is linear in a second difference, with a coefficient that only the parameters and the step decide, is
//! solved for it when the code is generated, and the solution put into the other rows. That is what the paper does by
//! hand with the pendulum: the variational equation gives `ψ₂`, and one equation for `θ₂` is left. A system whose rows
//! are all of this kind has no unknowns left and takes no iteration.

use std::collections::HashMap;

use super::Merge;
use crate::graph::{Graph, Leaf, NodeId};
use crate::mechanics::Equation;

/// The rows after the elimination.
pub(super) struct Reduced {
    pub(super) rows: Vec<Equation>,
    pub(super) kept: Vec<Leaf>,
    pub(super) second_difference: Vec<NodeId>,
}

/// Solves rows for unknowns as far as that can be done now, and names the unknowns that are left.
pub(super) fn reduce(graph: &mut Graph, rows: &[Equation], n: usize, multipliers: usize) -> Reduced {
    let mut rows = rows.to_vec();
    let mut kept: Vec<Leaf> = (0..n)
        .map(Leaf::E)
        .chain((0..multipliers).map(Leaf::Lambda))
        .collect();
    let mut eliminated: Vec<(Leaf, NodeId)> = Vec::new();
    while let Some((row, unknown, coefficient)) = linear_row(graph, &rows, &kept) {
        let equation = rows.remove(row);
        kept.retain(|&leaf| leaf != unknown);
        let zero = graph.constant(0.0);
        let rest = graph.substitute(equation.value, &HashMap::from([(unknown, zero)]));
        let quotient = graph.div(rest, coefficient);
        let solution = graph.neg(quotient);
        let map = HashMap::from([(unknown, solution)]);
        let mut done = HashMap::new();
        for part in rows.iter_mut().flat_map(Equation::parts) {
            *part = graph.substitute_in(*part, &map, &mut done);
        }
        for (_, earlier) in &mut eliminated {
            *earlier = graph.substitute_in(*earlier, &map, &mut done);
        }
        eliminated.push((unknown, solution));
    }
    let mut names = HashMap::new();
    let mut second_difference: Vec<NodeId> = (0..n).map(|i| graph.leaf(Leaf::E(i))).collect();
    for (j, &leaf) in kept.iter().enumerate() {
        let unknown = graph.leaf(Leaf::Z(j));
        names.insert(leaf, unknown);
    }
    for (leaf, solution) in eliminated {
        if let Leaf::E(i) = leaf {
            second_difference[i] = solution;
        }
    }
    let mut done = HashMap::new();
    for part in rows
        .iter_mut()
        .flat_map(Equation::parts)
        .chain(&mut second_difference)
    {
        *part = graph.substitute_in(*part, &names, &mut done);
    }
    Reduced {
        rows,
        kept,
        second_difference,
    }
}

/// A row, an unknown in which it is linear, and the coefficient: the simplest there is.
fn linear_row(graph: &mut Graph, rows: &[Equation], kept: &[Leaf]) -> Option<(usize, Leaf, NodeId)> {
    let mut best: Option<(u32, (usize, Leaf, NodeId))> = None;
    let mut merge = Merge::default();
    for (row, equation) in rows.iter().enumerate() {
        if equation.divide.is_some() {
            continue;
        }
        let equation = equation.value;
        for &unknown in kept.iter().rev() {
            if !graph.depends_on(equation, unknown) {
                continue;
            }
            let coefficient = graph.derivative(equation, unknown);
            let early = graph.leaves(coefficient).all(|leaf| matches!(leaf, Leaf::H));
            // a zero that the normal form does not see would be divided by
            if !early || graph.vanishes(coefficient) {
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
