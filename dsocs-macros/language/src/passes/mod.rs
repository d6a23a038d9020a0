//! The passes: from the equations of [`crate::mechanics`] to equations that are fast to evaluate.
//!
//! This file is the pipeline: the passes, in order, for the step ([`step`]) and for the continuous motion
//! ([`fn@motion`]). None of them changes the value of an expression, but for rounding and for the factor by
//! which a row may be multiplied. A pass that makes one expression from another is a
//! [`Pass`](crate::graph::Pass), taken through the graph by [`Graph::rewrite`].
//!
//! One more pass runs when code is written, over all products of a method: [`share`] finds the partial
//! products that are computed once.

mod addition_theorem;
mod attitude;
mod clear;
mod collapse;
mod distribute;
mod eliminate;
mod motion;
mod quotient;
pub(crate) mod running;
pub(crate) mod share;
pub(crate) mod sparse;

use attitude::Attitudes;
use clear::ScaledRow;
use collapse::{Collapse, Variables};
use eliminate::{Elimination, Rule};
use quotient::Leaves;

use crate::graph::algebra::{Merge, Simplify, gather_entries};
use crate::graph::{Graph, Leaf, NodeId, Substitution};
use crate::mechanics::Equation;

pub(crate) use motion::continuous;
pub(crate) use quotient::continuous::with_continuous_quotients;

/// The most rows for which common factors of the parameters and `h` are dropped.
const MOST_ROWS_WITH_FACTORS: usize = 2;
/// The most rows of the continuous motion that are solved symbolically; for more, determinants cost more than
/// a numerical elimination.
const MOST_SOLVED: usize = 2;

/// The rows of a step that are left for Newton's iteration, and the second difference, in terms of the
/// unknowns `Z`.
pub(crate) struct Unknowns {
    /// The rows, which the iteration makes zero.
    pub(crate) rows: Vec<NodeId>,
    /// For each row, its factor: the row divided by the declared row.
    pub(crate) scales: Vec<NodeId>,
    /// `jacobian[i][j] = ∂rows[i]/∂Z(j)`.
    pub(crate) jacobian: Vec<Vec<NodeId>>,
    /// The meaning of each unknown: a second difference `E`, or a multiplier `Lambda`.
    pub(crate) meanings: Vec<Leaf>,
    /// The second difference of every coordinate, in terms of the unknowns.
    pub(crate) second_difference: Vec<NodeId>,
}

impl Unknowns {
    /// Whether a row has a factor that is not a number.
    pub(crate) fn scaled(&self, graph: &Graph) -> bool {
        let mut scales = self.scales.iter();
        scales.any(|&scale| graph.as_constant(scale).is_none())
    }
}

/// The passes of a step with `n` coordinates.
pub(crate) fn step(graph: &mut Graph, rows: &[Equation], n: usize, multipliers: usize) -> Unknowns {
    let Eliminated {
        rows,
        leaves,
        meanings,
        mut second_difference,
    } = eliminated(graph, rows, n, multipliers);

    // quotient: a declared factor is divided out as a polynomial in an unknown. After the elimination,
    // because it divides exactly only where the other rows hold.
    // clear: a denominator with unknowns is multiplied out, and the factor kept.
    let mut rows: Vec<ScaledRow> = quotient::without_factors(graph, &rows, of_step(&leaves, multipliers))
        .into_iter()
        .map(|row| ScaledRow::untouched(graph, row.value, row.by_subtraction).without_denominator(graph))
        .collect();

    // collapse: affine expressions become `c₀ + Σ cⱼ xⱼ`, in the unknowns and then, within the coefficients,
    // in the leg. After the denominators are gone, because these hide affine expressions.
    for variables in [Variables::Unknowns, Variables::Leg] {
        let parts = rows.iter_mut().flat_map(ScaledRow::parts);
        graph.rewrite_all(parts.chain(&mut second_difference), &mut Collapse::new(variables));
    }

    // clear: factors of the parameters and `h` that all terms share are dropped, now that the terms are
    // gathered. Not with more rows: with different factors dropped, they would share fewer products.
    if rows.len() <= MOST_ROWS_WITH_FACTORS {
        for row in &mut rows {
            *row = row.without_common_factor(graph);
        }
    }

    // merge: equal expressions become the shortest of them. The rows formed by subtraction come later, since
    // they may be shorter but lose digits.
    let mut merge = Merge::default();
    let values = rows.iter_mut().flat_map(|row| [&mut row.row, &mut row.scale]);
    graph.rewrite_all(values.chain(&mut second_difference), &mut merge);
    graph.rewrite_all(rows.iter_mut().map(|row| &mut row.by_subtraction), &mut merge);

    // the Jacobian, of the rows formed by subtraction, rewritten by the same merge so that it shares most
    // expressions with the rows
    let mut jacobian: Vec<Vec<NodeId>> = rows
        .iter()
        .map(|row| {
            (0..meanings.len())
                .map(|j| {
                    let entry = graph.derivative(row.by_subtraction, Leaf::Z(j));
                    graph.rewrite(entry, &mut merge)
                })
                .collect()
        })
        .collect();

    // gather: products sorted by the coordinates of an entry's row and column
    gather_entries(graph, &mut jacobian);

    // addition theorem: sines and cosines at the second point from those at the first. Now rows and Jacobian show all
    // functions that occur.
    // distribute: constants go into sums that are used once, which is known only when nothing else changes.
    let mut all: Vec<&mut NodeId> = rows.iter_mut().map(|row| &mut row.row).collect();
    all.extend(jacobian.iter_mut().flatten());
    addition_theorem::rewrite(graph, &mut all);
    distribute::rewrite(graph, &mut all);

    Unknowns {
        scales: rows.iter().map(|row| row.scale).collect(),
        rows: rows.iter().map(|row| row.row).collect(),
        jacobian,
        meanings,
        second_difference,
    }
}

/// The leaves of a step's rows, for divisions.
fn of_step(leaves: &[Leaf], multipliers: usize) -> Leaves<'_> {
    Leaves {
        unknown: leaves,
        variables: [leaves, &[]],
        multipliers,
    }
}

/// The rows of a step that are left after the symbolic elimination.
struct Eliminated {
    /// The rows, in terms of the unknowns `Z`.
    rows: Vec<Equation>,
    /// The unknowns `Z`.
    leaves: Vec<Leaf>,
    /// The meaning of each: a second difference `E`, or a multiplier `Lambda`.
    meanings: Vec<Leaf>,
    /// The second difference of every coordinate, in terms of the unknowns.
    second_difference: Vec<NodeId>,
}

/// The first pass of a step: the symbolic elimination.
fn eliminated(graph: &mut Graph, rows: &[Equation], n: usize, multipliers: usize) -> Eliminated {
    // eliminate: a row is solved for a second difference or a multiplier if the coefficient depends on the parameters and `h` alone and has
    // to be nonzero. This comes first, because every row that is eliminated saves the later passes work.
    let unknown = (0..n).map(Leaf::E).chain((0..multipliers).map(Leaf::Lambda));
    let mut system = Elimination::new(rows, unknown);
    system.run(
        graph,
        Rule {
            early: |graph, coefficient| graph.leaves(coefficient).all(|leaf| leaf == Leaf::H),
            most_unknowns: usize::MAX,
        },
    );
    let mut second_difference = system.solutions(graph, (0..n).map(Leaf::E));
    let Elimination {
        mut rows,
        unknown: meanings,
        ..
    } = system;

    // name: the unknowns that are left become the `Z` of Newton's iteration
    let leaves: Vec<Leaf> = (0..meanings.len()).map(Leaf::Z).collect();
    let names = meanings
        .iter()
        .zip(&leaves)
        .map(|(&leaf, &unknown)| (leaf, graph.leaf(unknown)))
        .collect();
    let parts = rows.iter_mut().flat_map(Equation::parts);
    graph.rewrite_all(
        parts.chain(&mut second_difference),
        &mut Substitution::new(&names),
    );
    Eliminated {
        rows,
        leaves,
        meanings,
        second_difference,
    }
}

/// The accelerations of the continuous motion, and the equations for those that stay unknown.
pub(crate) struct Motion {
    /// The acceleration of every coordinate, in `Q`, `V`, `T` and the unknowns.
    pub(crate) accelerations: Vec<NodeId>,
    /// The accelerations `A` and multipliers `Lambda` that stay unknown.
    pub(crate) unknown: Vec<Leaf>,
    /// The equations for the unknowns, as many as these.
    pub(crate) rows: Vec<NodeId>,
    /// `∂rows[i]/∂unknown[j]`.
    pub(crate) jacobian: Vec<Vec<NodeId>>,
    /// The row and column of the Jacobian's entries that are not identically zero.
    pub(crate) entries: Vec<[usize; 2]>,
    /// The number of all multipliers.
    pub(crate) multipliers: usize,
    /// Whether the rows are affine in the unknowns.
    pub(crate) affine: bool,
}

/// The cost of the recurrences for some expressions.
pub(crate) type Cost = fn(&mut Graph, &[NodeId]) -> usize;

/// The passes of the continuous motion with `n` coordinates. Rows are solved for accelerations as far as that
/// keeps the recurrences of Taylor series short, in which a product is a convolution and a sum is cheap. Rows
/// that are left are solved once per order, with one matrix.
pub(crate) fn motion(
    graph: &mut Graph,
    (rows, velocities): (&[Equation], &[NodeId]),
    n: usize,
    multipliers: usize,
    cost: Cost,
) -> Motion {
    // eliminate: rows whose coefficient depends on the parameters alone and has to be nonzero
    let rule = Rule {
        early: Graph::is_fixed,
        most_unknowns: MOST_SOLVED,
    };
    let unknown = (0..n).map(Leaf::A).chain((0..multipliers).map(Leaf::Lambda));
    let mut system = Elimination::new(rows, unknown);
    system.run(graph, rule);

    // divide, then collapse: without their declared factors rows may be affine, and then they are eliminated,
    // too
    system.rows = motion::without_factors(graph, &system.rows, velocities, (n, multipliers), &system.unknown);
    graph.rewrite_all(
        system.rows.iter_mut().map(|row| &mut row.value),
        &mut Collapse::new(Variables::Motion),
    );
    system.run(graph, rule);

    // cramer: one or two rows that are affine in as many unknowns
    motion::cramer(graph, &mut system);
    let affine = motion::affine(graph, &system);

    // collapse, simplify, merge: affine expressions are gathered, then common factors of sums and squares of
    // roots taken out, then equal expressions made one. Last, since the solutions have brought new terms
    // together.
    let accelerations = system.solutions(graph, (0..n).map(Leaf::A));
    let mut all: Vec<NodeId> = system.rows.iter().map(|row| row.value).collect();
    all.splice(..0, accelerations);
    graph.rewrite_all(&mut all, &mut Collapse::new(Variables::Motion));
    graph.rewrite_all(&mut all, &mut Simplify::default());
    graph.rewrite_all(&mut all, &mut Merge::default());

    // attitudes: forms in the components of quaternions are multiplied out where that costs less
    if !graph.rotations().is_empty() {
        let mut multiplied_out = all.clone();
        graph.rewrite_all(&mut multiplied_out, &mut Attitudes::default());
        if cost(graph, &multiplied_out) < cost(graph, &all) {
            all = multiplied_out;
        }
    }

    // horner: rows that are left are multiplied out and gathered where that costs less
    let rows = motion::gathered(graph, &all[n..], cost);
    all.truncate(n);
    let jacobian: Vec<Vec<NodeId>> = rows
        .iter()
        .map(|&row| {
            let unknown = system.unknown.iter();
            unknown.map(|&leaf| graph.derivative(row, leaf)).collect()
        })
        .collect();
    Motion {
        entries: sparse::entries(graph, &jacobian),
        accelerations: all,
        unknown: system.unknown,
        rows,
        jacobian,
        multipliers,
        affine,
    }
}
