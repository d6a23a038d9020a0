//! The unknowns of a step: which second differences Newton's iteration looks for, and which follow from them.
//!
//! A row that is linear in a second difference, with a coefficient that only the parameters and the step decide, is
//! solved for it when the code is generated, and the solution put into the other rows. That is what the paper does by
//! hand with the pendulum: the variational equation gives `ψ₂`, and one equation for `θ₂` is left. A system whose rows
//! are all of this kind has no unknowns left and takes no iteration.

use std::collections::HashMap;

use super::clear::Cleared;
use super::collapse::{Collapse, Variables};
use super::equations::Equation;
use super::{distribute, rotate};
use crate::graph::{Graph, Leaf, Merge, NodeId};

/// With more rows than this, none is divided by what its terms have in common.
const MOST_ROWS_WITH_FACTORS: usize = 2;

/// The rows that are left, and the second difference, in terms of the unknowns `Z`.
pub(crate) struct Unknowns {
    /// The rows that Newton's iteration makes zero.
    pub(crate) rows: Vec<NodeId>,
    /// What each of them is, divided by the declared row.
    pub(crate) scales: Vec<NodeId>,
    /// `jacobian[i][j] = ∂rows[i]/∂Z(j)`.
    pub(crate) jacobian: Vec<Vec<NodeId>>,
    /// What unknown `j` is: a second difference `E`, or a multiplier `Lambda`.
    pub(crate) kept: Vec<Leaf>,
    /// The second difference of every coordinate.
    pub(crate) second_difference: Vec<NodeId>,
}

/// Eliminates what can be and names the rest.
pub(crate) fn choose(graph: &mut Graph, rows: &[Equation], n: usize, multipliers: usize) -> Unknowns {
    let Reduced {
        rows,
        kept,
        mut second_difference,
    } = reduce(graph, rows, n, multipliers);
    let leaves: Vec<Leaf> = (0..kept.len()).map(Leaf::Z).collect();
    let mut rows: Vec<Cleared> = rows
        .into_iter()
        .map(|row| {
            let mut divided = |value| match row.divide {
                Some(factor) => graph.quotient(value, factor, &leaves),
                None => value,
            };
            let (value, plain) = (divided(row.value), divided(row.plain));
            Cleared::untouched(graph, value, plain).without_denominator(graph)
        })
        .collect();
    for variables in [Variables::Unknowns, Variables::Leg] {
        let mut collapse = Collapse::new(graph, variables);
        for node in rows
            .iter_mut()
            .flat_map(Cleared::parts)
            .chain(&mut second_difference)
        {
            *node = collapse.rewrite(*node);
        }
    }
    // rows that share products would share fewer of them, each with factors of its own
    if rows.len() <= MOST_ROWS_WITH_FACTORS {
        for row in &mut rows {
            *row = row.without_common_factor(graph);
        }
    }
    let mut merge = Merge::default();
    let values = rows.iter_mut().flat_map(|row| [&mut row.row, &mut row.scale]);
    for node in values.chain(&mut second_difference) {
        *node = merge.rewrite(graph, *node);
    }
    // later, since what loses digits may be shorter
    for row in &mut rows {
        row.plain = merge.rewrite(graph, row.plain);
    }
    let mut jacobian: Vec<Vec<NodeId>> = rows
        .iter()
        .map(|row| {
            (0..kept.len())
                .map(|j| {
                    let entry = graph.derivative(row.plain, Leaf::Z(j));
                    merge.rewrite(graph, entry)
                })
                .collect()
        })
        .collect();
    let mut all: Vec<&mut NodeId> = rows.iter_mut().map(|row| &mut row.row).collect();
    all.extend(jacobian.iter_mut().flatten());
    rotate::rewrite(graph, &mut all);
    distribute::rewrite(graph, &mut all);
    let scales = rows.iter().map(|row| row.scale).collect();
    let rows = rows.iter().map(|row| row.row).collect();
    Unknowns {
        rows,
        scales,
        jacobian,
        kept,
        second_difference,
    }
}

/// The rows after the elimination.
struct Reduced {
    rows: Vec<Equation>,
    kept: Vec<Leaf>,
    second_difference: Vec<NodeId>,
}

/// Solves rows for unknowns as far as that can be done now, and names the unknowns that are left.
fn reduce(graph: &mut Graph, rows: &[Equation], n: usize, multipliers: usize) -> Reduced {
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
