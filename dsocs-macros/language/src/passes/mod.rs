//! The graph made fast: from the equations of [`crate::mechanics`] to those that code is written for.
//!
//! This page is the pipeline: the passes, in order, for the step ([`step`]) and for the continuous motion ([`motion`]). None
//! of them changes what an expression is worth, but for rounding and for the factor that a row may be multiplied by. A pass
//! that makes one expression of another is a [`Pass`](crate::graph::Pass), taken through the graph by [`Graph::rewrite`].
//!
//! One more comes when code is written, over all products of a method: [`share`], which parts of them are computed once.

mod attitude;
mod clear;
mod collapse;
mod distribute;
mod eliminate;
mod motion;
mod quotient;
mod rotate;
pub(crate) mod running;
pub(crate) mod share;
pub(crate) mod sparse;
mod together;

use attitude::Attitudes;
use clear::Cleared;
use collapse::{Collapse, Variables};
use eliminate::{Elimination, Rule};
use quotient::Leaves;

use crate::graph::algebra::{Merge, Simplify, gather_entries};
use crate::graph::{Graph, Leaf, NodeId, Substitution};
use crate::mechanics::Equation;

pub(crate) use motion::{without_cancellation, without_factors};
pub(crate) use together::together;

/// With more rows than this, none is divided by what its terms have in common.
const MOST_ROWS_WITH_FACTORS: usize = 2;
/// So many rows of the continuous motion are solved in symbols; beyond, the determinants cost more than an elimination in
/// numbers.
const MOST_SOLVED: usize = 2;

/// The rows of a step that are left, and its second difference, in terms of the unknowns `Z`.
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

impl Unknowns {
    /// Whether rows were multiplied by more than a number.
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
        kept,
        mut second_difference,
    } = eliminated(graph, rows, n, multipliers);

    // quotient: a declared factor is divided out as a polynomial in an unknown. After the elimination, because only where
    // the other rows hold does it divide exactly.
    // clear: a denominator with unknowns is multiplied out, and the factor kept.
    let mut rows: Vec<Cleared> = quotient::without_factors(graph, &rows, of_step(&leaves, multipliers))
        .into_iter()
        .map(|row| Cleared::untouched(graph, row.value, row.plain).without_denominator(graph))
        .collect();

    // collapse: what is affine becomes `c₀ + Σ cⱼ xⱼ`, in the unknowns and then, within the coefficients, in the leg. Once
    // denominators are gone, because they hide what is affine.
    for variables in [Variables::Unknowns, Variables::Leg] {
        let parts = rows.iter_mut().flat_map(Cleared::parts);
        graph.rewrite_all(parts.chain(&mut second_difference), &mut Collapse::new(variables));
    }

    // clear: what the parameters and `h` alone contribute to all terms is dropped, now that the terms are gathered. Rows that
    // share products would share fewer of them, each with factors of its own.
    if rows.len() <= MOST_ROWS_WITH_FACTORS {
        for row in &mut rows {
            *row = row.without_common_factor(graph);
        }
    }

    // merge: equal expressions become the shortest of them. The rows as they are differentiated come later, since what loses
    // digits may be shorter.
    let mut merge = Merge::default();
    let values = rows.iter_mut().flat_map(|row| [&mut row.row, &mut row.scale]);
    graph.rewrite_all(values.chain(&mut second_difference), &mut merge);
    graph.rewrite_all(rows.iter_mut().map(|row| &mut row.plain), &mut merge);

    // the Jacobian, of rows in their last form but one, so that both have most in common
    let mut jacobian: Vec<Vec<NodeId>> = rows
        .iter()
        .map(|row| {
            (0..kept.len())
                .map(|j| {
                    let entry = graph.derivative(row.plain, Leaf::Z(j));
                    graph.rewrite(entry, &mut merge)
                })
                .collect()
        })
        .collect();

    // gather: what belongs to the coordinate of an entry's column, and to that of its row
    gather_entries(graph, &mut jacobian);

    // rotate: sines and cosines at the second point from those at the first. Then rows and Jacobian show all functions that
    // there are.
    // distribute: constants go into sums that are used once, which is known once nothing else changes.
    let mut all: Vec<&mut NodeId> = rows.iter_mut().map(|row| &mut row.row).collect();
    all.extend(jacobian.iter_mut().flatten());
    rotate::rewrite(graph, &mut all);
    distribute::rewrite(graph, &mut all);

    Unknowns {
        scales: rows.iter().map(|row| row.scale).collect(),
        rows: rows.iter().map(|row| row.row).collect(),
        jacobian,
        kept,
        second_difference,
    }
}

/// In what the rows of a step are divided.
fn of_step(leaves: &[Leaf], multipliers: usize) -> Leaves<'_> {
    Leaves {
        unknown: leaves,
        variables: [leaves, &[]],
        multipliers,
    }
}

/// The rows of a step that are left when others are solved.
struct Eliminated {
    /// The rows, in the unknowns `Z`.
    rows: Vec<Equation>,
    /// These unknowns.
    leaves: Vec<Leaf>,
    /// What each is: a second difference `E`, or a multiplier `Lambda`.
    kept: Vec<Leaf>,
    /// The second difference of every coordinate.
    second_difference: Vec<NodeId>,
}

/// The first pass of a step.
fn eliminated(graph: &mut Graph, rows: &[Equation], n: usize, multipliers: usize) -> Eliminated {
    // eliminate: rows whose coefficient the parameters and `h` decide, and which has to be nonzero, are solved for a second difference or a multiplier.
    // First, since every row that goes spares all that follows.
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
        unknown: kept,
        ..
    } = system;

    // name: what is left is the unknowns `Z` of Newton's iteration
    let leaves: Vec<Leaf> = (0..kept.len()).map(Leaf::Z).collect();
    let names = kept
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
        kept,
        second_difference,
    }
}

/// The accelerations of the continuous motion, and the equations of those that stay unknown.
pub(crate) struct Motion {
    /// The acceleration of every coordinate, in `Q`, `V` and those `A` that stay unknown.
    pub(crate) accelerations: Vec<NodeId>,
    /// The accelerations `A` and multipliers `Lambda` that stay unknown.
    pub(crate) unknown: Vec<Leaf>,
    /// As many rows, in `Q`, `V` and the unknown ones.
    pub(crate) rows: Vec<NodeId>,
    /// `∂rows[i]/∂unknown[j]`.
    pub(crate) jacobian: Vec<Vec<NodeId>>,
    /// Row and column of its entries that are not zero everywhere.
    pub(crate) entries: Vec<[usize; 2]>,
    /// How many multipliers there are in all.
    pub(crate) multipliers: usize,
    /// Whether the rows are affine in them.
    pub(crate) affine: bool,
}

/// What the code for some expressions costs.
pub(crate) type Cost = fn(&mut Graph, &[NodeId]) -> usize;

/// The passes of the continuous motion with `n` coordinates: rows are solved for accelerations as far as that keeps the
/// recurrences of Taylor series short, which have a convolution for every product and nothing for a sum. Rows that are left
/// are solved once an order, with one matrix.
pub(crate) fn motion(
    graph: &mut Graph,
    (rows, velocities): (&[Equation], &[NodeId]),
    n: usize,
    multipliers: usize,
    cost: Cost,
) -> Motion {
    // eliminate: rows whose coefficient the parameters alone decide, and which has to be nonzero
    let rule = Rule {
        early: Graph::is_fixed,
        most_unknowns: MOST_SOLVED,
    };
    let unknown = (0..n).map(Leaf::A).chain((0..multipliers).map(Leaf::Lambda));
    let mut system = Elimination::new(rows, unknown);
    system.run(graph, rule);

    // divide, then collapse: without their declared factors rows may be affine, and eliminated too
    system.rows = without_factors(graph, &system.rows, velocities, (n, multipliers), &system.unknown);
    graph.rewrite_all(
        system.rows.iter_mut().map(|row| &mut row.value),
        &mut Collapse::new(Variables::Motion),
    );
    system.run(graph, rule);

    // cramer: a row or two that are affine in as many accelerations
    motion::cramer(graph, &mut system);
    let affine = motion::affine(graph, &system);

    // collapse, simplify, merge: what is affine is gathered, then common factors of sums and squares of roots are taken out,
    // then equal expressions become one. Last, since the solutions have brought new terms together.
    let accelerations = system.solutions(graph, (0..n).map(Leaf::A));
    let mut all: Vec<NodeId> = system.rows.iter().map(|row| row.value).collect();
    all.splice(..0, accelerations);
    graph.rewrite_all(&mut all, &mut Collapse::new(Variables::Motion));
    graph.rewrite_all(&mut all, &mut Simplify::default());
    graph.rewrite_all(&mut all, &mut Merge::default());

    // attitudes: forms in the components of quaternions share their products, where that leaves fewer
    if !graph.rotations().is_empty() {
        let mut turned = all.clone();
        graph.rewrite_all(&mut turned, &mut Attitudes::default());
        if cost(graph, &turned) < cost(graph, &all) {
            all = turned;
        }
    }

    // horner: rows that stay are multiplied out and gathered, where that leaves fewer products
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
