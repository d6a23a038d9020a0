//! What only the continuous motion needs: declared factors divided out, one or two rows solved by Cramer's rule.

use std::collections::HashSet;

use super::eliminate::Elimination;
use super::horner::Horner;
use super::quotient::quotient;
use super::simplify::Simplify;
use super::{Cost, MOST_SOLVED};
use crate::graph::{Graph, Leaf, NodeId};
use crate::mechanics::Equation;

/// A row of the continuous motion without its declared factor, as it stands: a polynomial where the factor divides it as one, so that it
/// has a value where the factor is zero; else the quotient.
pub(crate) fn without_factor(graph: &mut Graph, value: NodeId, factor: NodeId, n: usize) -> NodeId {
    let leaves: Vec<Leaf> = (0..n).map(Leaf::V).chain((0..n).map(Leaf::Q)).collect();
    quotient(graph, value, factor, &leaves)
}

/// Divides the declared factors out. They are of order 1 at most, and where the other rows hold they divide as polynomials
/// in a velocity.
pub(super) fn divide(graph: &mut Graph, rows: &mut [Equation], n: usize) {
    for row in rows {
        if let Some(factor) = row.divide.take() {
            row.value = without_factor(graph, row.value, factor, n);
        }
    }
}

/// Solves a row or two that are affine in as many accelerations; more cost less when they are eliminated in numbers.
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
            return; // no such system determines its motion; the numbers will tell
        }
        vec![graph.div(right[0], matrix[0][0])]
    } else {
        let determinant = two_by_two(graph, [matrix[0][0], matrix[0][1]], [matrix[1][0], matrix[1][1]]);
        if graph.vanishes(determinant) {
            return;
        }
        let first = two_by_two(graph, [right[0], matrix[0][1]], [right[1], matrix[1][1]]);
        let second = two_by_two(graph, [matrix[0][0], right[0]], [matrix[1][0], right[1]]);
        // common factors of numerator and denominator cancel where both are products
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
            graph.leaves(slope).all(|other| !unknown.contains(&other))
        })
    })
}

/// Rows multiplied out and gathered, if that costs less.
pub(super) fn gathered(graph: &mut Graph, rows: &[NodeId], cost: Cost) -> Vec<NodeId> {
    let mut horner = Horner::default();
    let rewritten: Option<Vec<NodeId>> = rows.iter().map(|&row| horner.rewrite(graph, row)).collect();
    match rewritten {
        Some(rewritten) if cost(graph, &rewritten) < cost(graph, rows) => rewritten,
        _ => rows.to_vec(),
    }
}
