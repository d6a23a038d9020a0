//! Passes of the continuous motion alone: declared factors divided out, one or two rows solved by Cramer's
//! rule.

use super::collapse::{Collapse, Variables};
use super::eliminate::Elimination;
use super::quotient::{self, Leaves};
use super::{Cost, MOST_SOLVED};
use crate::graph::algebra::{Expansion, Simplify};
use crate::graph::{Graph, Leaf, NodeId};
use crate::hash::{HashMap, HashSet};
use crate::mechanics::{self, Equation};
use crate::model::Model;

/// The rows of the continuous system without their declared factors, then their Jacobian by the accelerations
/// and multipliers; and the constraint force.
pub(crate) fn continuous(model: &Model, graph: &mut Graph) -> (Vec<NodeId>, Vec<NodeId>) {
    let (n, multipliers) = (model.coordinates.len(), model.multipliers());
    let equations = mechanics::continuous(model, graph);
    let unknown = (0..n).map(Leaf::A).chain((0..multipliers).map(Leaf::Lambda));
    let unknown: Vec<Leaf> = unknown.collect();
    let rows = without_factors(
        graph,
        &equations.rows,
        &equations.velocities,
        (n, multipliers),
        &unknown,
    );
    let mut rows: Vec<NodeId> = rows.iter().map(|row| row.value).collect();
    for (row, declared) in rows.iter_mut().zip(&equations.rows) {
        if declared.divide.is_some() {
            *row = without_cancellation(graph, *row);
        }
    }
    for row in rows.clone() {
        rows.extend(unknown.iter().map(|&leaf| graph.derivative(row, leaf)));
    }
    (rows, equations.force)
}

/// The rows of the continuous motion of `n` coordinates without their declared factors. These are of order 1
/// at most, and where the other rows hold they divide as polynomials in a velocity; then the quotient has a
/// value where the factor is zero. `velocities` are the constraints on velocities
/// (`ContinuousEquations`).
pub(super) fn without_factors(
    graph: &mut Graph,
    rows: &[Equation],
    velocities: &[NodeId],
    (n, multipliers): (usize, usize),
    unknown: &[Leaf],
) -> Vec<Equation> {
    (0..rows.len())
        .map(|place| {
            exact(graph, rows, place, velocities, (n, multipliers), unknown)
                .unwrap_or_else(|| quotient::of_numbers(graph, rows[place]))
        })
        .collect()
}

/// A row without its factor, if that divides it exactly: by itself, or where the other rows and the
/// constraints on velocities hold.
pub(super) fn exact(
    graph: &mut Graph,
    rows: &[Equation],
    place: usize,
    velocities: &[NodeId],
    (n, multipliers): (usize, usize),
    unknown: &[Leaf],
) -> Option<Equation> {
    rows[place].divide?;
    let variables = [Leaf::V as fn(usize) -> Leaf, Leaf::Q].map(|leaf| (0..n).map(leaf).collect::<Vec<_>>());
    let leaves = Leaves {
        unknown,
        variables: [&variables[0], &variables[1]],
        multipliers,
    };
    quotient::exact(graph, rows, place, leaves).or_else(|| {
        let places = admissible(graph, velocities, n)?;
        let mut rows = rows.to_vec();
        for part in rows[place].parts() {
            *part = graph.substitute(*part, &places);
        }
        quotient::exact(graph, &rows, place, leaves)
    })
}

/// A quotient with its terms gathered, since solutions and divisions leave terms that would cancel in
/// numbers, with a loss of digits.
pub(super) fn without_cancellation(graph: &mut Graph, quotient: NodeId) -> NodeId {
    let gathered = graph.rewrite(quotient, &mut Collapse::new(Variables::Motion));
    graph.rewrite(gathered, &mut Simplify::default())
}

/// The substitution for every velocity of the nearest one that satisfies the constraints: the same velocity
/// where they hold.
fn admissible(graph: &mut Graph, velocities: &[NodeId], n: usize) -> Option<HashMap<Leaf, NodeId>> {
    let leaves: Vec<Leaf> = (0..n).map(Leaf::V).collect();
    let mut slopes: Vec<Vec<NodeId>> = Vec::new();
    for &row in velocities {
        slopes.push(leaves.iter().map(|&leaf| graph.derivative(row, leaf)).collect());
    }
    let multiples = quotient::multiples(graph, &slopes, velocities.to_vec())?;
    let nearest = leaves.iter().enumerate().map(|(i, &leaf)| {
        let mut terms = vec![(graph.leaf(leaf), 1.0)];
        for (slopes, &multiple) in slopes.iter().zip(&multiples) {
            terms.push((graph.mul(multiple, slopes[i]), -1.0));
        }
        (leaf, graph.linear(0.0, &terms))
    });
    Some(nearest.collect())
}

/// Solves one or two rows that are affine in as many unknowns; more rows cost less when they are eliminated
/// numerically.
pub(super) fn cramer(graph: &mut Graph, system: &mut Elimination) {
    let m = system.unknown.len();
    if m == 0 || m > MOST_SOLVED || !affine(graph, system) {
        return;
    }
    let zero = graph.constant(0.0);
    let at_zero = system.unknown.iter().map(|&leaf| (leaf, zero)).collect();
    let mut matrix = Vec::new();
    let mut right = Vec::new();
    for row in &system.rows {
        let rest = graph.substitute(row.value, &at_zero);
        right.push(graph.neg(rest));
        let slopes = system.unknown.iter();
        let slopes: Vec<NodeId> = slopes.map(|&leaf| graph.derivative(row.value, leaf)).collect();
        matrix.push(slopes);
    }
    let solutions = if m == 1 {
        if graph.vanishes(matrix[0][0]) {
            return; // singular at all points: the numerical elimination reports it
        }
        vec![graph.div(right[0], matrix[0][0])]
    } else {
        let determinant = two_by_two(graph, [matrix[0][0], matrix[0][1]], [matrix[1][0], matrix[1][1]]);
        if graph.vanishes(determinant) {
            return;
        }
        let first = two_by_two(graph, [right[0], matrix[0][1]], [right[1], matrix[1][1]]);
        let second = two_by_two(graph, [matrix[0][0], right[0]], [matrix[1][0], right[1]]);
        // common factors of numerator and denominator cancel where both are written as products
        let mut simplify = Simplify::default();
        [first, second]
            .map(|numerator| {
                let parts = [numerator, determinant].map(|part| graph.rewrite(part, &mut simplify));
                graph.div(parts[0], parts[1])
            })
            .to_vec()
    };
    let solutions: Vec<_> = system.unknown.iter().copied().zip(solutions).collect();
    system.rows.clear();
    system.put(graph, &solutions);
}

fn two_by_two(graph: &mut Graph, [a, b]: [NodeId; 2], [c, d]: [NodeId; 2]) -> NodeId {
    let (left, right) = (graph.mul(a, d), graph.mul(b, c));
    graph.sub(left, right)
}

/// Whether every row is affine in the unknowns.
pub(super) fn affine(graph: &mut Graph, system: &Elimination) -> bool {
    let unknown: HashSet<Leaf> = system.unknown.iter().copied().collect();
    system.rows.iter().all(|row| {
        let own: Vec<Leaf> = graph
            .leaves(row.value)
            .filter(|leaf| unknown.contains(leaf))
            .collect();
        own.into_iter().all(|leaf| {
            let slope = graph.derivative(row.value, leaf);
            let is_constant = graph.leaves(slope).all(|other| !unknown.contains(&other));
            is_constant && !graph.jumps_with(row.value, leaf)
        })
    })
}

/// The rows multiplied out and gathered, if that costs less; else unchanged.
pub(super) fn gathered(graph: &mut Graph, rows: &[NodeId], cost: Cost) -> Vec<NodeId> {
    let mut expansion = Expansion::default();
    let rewritten: Option<Vec<NodeId>> = rows.iter().map(|&row| expansion.gathered(graph, row)).collect();
    match rewritten {
        Some(rewritten) if cost(graph, &rewritten) < cost(graph, rows) => rewritten,
        _ => rows.to_vec(),
    }
}
