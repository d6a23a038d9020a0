//! The graph made fast: from the equations of [`crate::mechanics`] to those that code is written for.

mod clear;
mod collapse;
mod distribute;
mod eliminate;
mod horner;
mod merge;
pub(crate) mod motion;
mod quotient;
mod rotate;
pub(crate) mod share;
mod simplify;

use clear::Cleared;
use collapse::{Collapse, Variables};
use eliminate::{Reduced, reduce};

use crate::graph::{Graph, Leaf, NodeId};
use crate::mechanics::Equation;

pub(crate) use merge::Merge;

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
