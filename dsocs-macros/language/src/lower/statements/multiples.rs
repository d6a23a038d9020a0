//! Constraints that are multiples of each other.
//!
//! A row that is a multiple of another one adds no condition, so the step has no unique solution. Other
//! dependent rows are found in a run, which names them.

use crate::graph::{Graph, Leaf, NodeId};
use crate::mistakes::errors::{Errors, Reported};
use crate::model::{Kind, Row};

/// Refuses rows that are multiples of earlier rows or of their derivatives, by factors of lower order than
/// the row.
pub(crate) fn check(rows: &[Row], graph: &Graph, errors: &Errors) -> Result<(), Reported> {
    if rows.len() < 2 {
        return Ok(());
    }
    // on a copy, so that the test adds no nodes to the code
    let mut graph = graph.clone();
    let mut wrong = Ok(());
    for (place, row) in rows.iter().enumerate() {
        let repeated = rows[..place].iter().enumerate().find_map(|(before, other)| {
            let derivatives = derivatives_to_multiple(&mut graph, other, row)?;
            Some((before, derivatives))
        });
        let Some((before, derivatives)) = repeated else {
            continue;
        };
        let (kind, number) = kind_and_number(rows, before);
        let of_what = match derivatives {
            0 => format!("a multiple of {kind} constraint {number}"),
            1 => format!("a multiple of the time derivative of {kind} constraint {number}"),
            _ => format!("a multiple of the second time derivative of {kind} constraint {number}"),
        };
        wrong = Err(errors.at(
            &row.tokens,
            format!(
                "this constraint is {of_what}, and holds wherever that one does: the two together do not determine the motion; leave this one out"
            ),
        ));
    }
    wrong
}

/// The number of time derivatives after which the first row is a multiple of the second; `None` if this is not certain of any number.
fn derivatives_to_multiple(graph: &mut Graph, first: &Row, second: &Row) -> Option<usize> {
    let discrete = [first, second].iter().any(|row| row.discrete.is_some());
    if discrete || first.order > second.order || second.order > 2 {
        return None;
    }
    let mut value = first.value;
    for _ in first.order..second.order {
        value = graph.total_derivative(value);
    }
    let top: Vec<Leaf> = (graph.leaves(value).chain(graph.leaves(second.value)))
        .filter(|leaf| leaf.order() == Some(second.order))
        .collect();
    // the quotient of the two must not depend on the highest derivatives
    let same = top
        .into_iter()
        .all(|leaf| is_constant(graph, value, second.value, leaf));
    same.then_some(second.order - first.order)
}

/// Whether the quotient of two expressions does not depend on a leaf.
fn is_constant(graph: &mut Graph, one: NodeId, other: NodeId, leaf: Leaf) -> bool {
    let slopes = [one, other].map(|value| graph.derivative(value, leaf));
    let (left, right) = (graph.mul(slopes[0], other), graph.mul(one, slopes[1]));
    let difference = graph.sub(left, right);
    graph.vanishes(difference)
}

/// The kind of a constraint, and its number among those of the kind, from 1.
fn kind_and_number(rows: &[Row], place: usize) -> (&'static str, usize) {
    let kind = rows[place].kind;
    let word = match kind {
        Kind::Holonomic => "holonomic",
        Kind::Nonholonomic => "nonholonomic",
        Kind::Kinematic => "kinematic",
    };
    let number = rows[..=place].iter().filter(|row| row.kind == kind).count();
    (word, number)
}
