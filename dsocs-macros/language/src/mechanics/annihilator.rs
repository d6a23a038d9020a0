//! The virtual displacements from the forces: `C_V` as the annihilator of `F_V`.

use crate::graph::{Graph, NodeId};

/// A constant below this fraction of the sizes of its summands is a rounding error.
const NEGLIGIBLE: f64 = 1e-12;

/// The reason why no annihilator was found, with the index of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Defect {
    /// The row is a combination of the others.
    Dependent(usize),
    /// No component of the row is a nonzero constant.
    NoPivot(usize),
}

/// Fields that span the annihilator of the rows: `n - m` fields for `m` independent rows of `n` components.
///
/// By Gauss elimination with pivots that are nonzero constants, so that they are nonzero everywhere. Where
/// there are no such pivots, `n - 1` rows have an annihilator of one dimension, given by their minors.
pub(crate) fn annihilator(
    graph: &mut Graph,
    rows: &[Vec<NodeId>],
    n: usize,
) -> Result<Vec<Vec<NodeId>>, Defect> {
    let mut reduced: Vec<Vec<NodeId>> = rows.to_vec();
    // the scale of each entry, because units may differ from column to column
    let mut terms: Vec<Vec<f64>> = rows.iter().map(|row| sizes(graph, row)).collect();
    let mut pivots: Vec<Option<usize>> = vec![None; rows.len()];
    while let Some((row, column)) = best_pivot(graph, &reduced, &pivots, &terms) {
        eliminate(graph, &mut reduced, &mut terms, row, column);
        pivots[row] = Some(column);
    }
    let mut free_rows = pivots
        .iter()
        .enumerate()
        .filter(|(_, pivot)| pivot.is_none())
        .map(|(row, _)| row);
    if let Some(row) = free_rows
        .clone()
        .find(|&row| is_negligible(graph, &reduced[row], &terms[row]))
    {
        return Err(Defect::Dependent(row));
    }
    if let Some(row) = free_rows.next() {
        return if rows.len() + 1 == n {
            Ok(vec![minors(graph, rows)])
        } else {
            Err(Defect::NoPivot(row))
        };
    }
    let free_columns = (0..n).filter(|&column| !pivots.contains(&Some(column)));
    Ok(free_columns
        .map(|free| field(graph, &reduced, &pivots, n, free))
        .collect())
}

/// The absolute values of a row's constants; zero for entries that are not constant.
fn sizes(graph: &Graph, row: &[NodeId]) -> Vec<f64> {
    row.iter()
        .map(|&entry| graph.as_constant(entry).map_or(0.0, f64::abs))
        .collect()
}

fn is_negligible(graph: &Graph, row: &[NodeId], terms: &[f64]) -> bool {
    row.iter().zip(terms).all(|(&entry, terms)| {
        graph
            .as_constant(entry)
            .is_some_and(|value| value.abs() <= NEGLIGIBLE * terms)
    })
}

/// The row and column of the next pivot: ±1 if there is one, because division by it is exact, else the
/// largest constant.
fn best_pivot(
    graph: &Graph,
    reduced: &[Vec<NodeId>],
    pivots: &[Option<usize>],
    terms: &[Vec<f64>],
) -> Option<(usize, usize)> {
    let mut best: Option<((usize, usize), f64)> = None;
    for (row, entries) in reduced
        .iter()
        .enumerate()
        .filter(|&(row, _)| pivots[row].is_none())
    {
        for (column, &entry) in entries.iter().enumerate() {
            let Some(value) = graph.as_constant(entry).map(f64::abs) else {
                continue;
            };
            if value <= NEGLIGIBLE * terms[row][column] || !value.is_finite() {
                continue;
            }
            #[allow(clippy::float_cmp)] // exactly one
            let merit = if value == 1.0 { f64::INFINITY } else { value };
            if best.is_none_or(|(_, known)| merit > known) {
                best = Some(((row, column), merit));
            }
        }
    }
    best.map(|(place, _)| place)
}

/// Makes the pivot 1 and the rest of its column 0. `terms` has, for each entry, the sizes of its summands.
fn eliminate(
    graph: &mut Graph,
    reduced: &mut [Vec<NodeId>],
    terms: &mut [Vec<f64>],
    row: usize,
    column: usize,
) {
    let pivot = reduced[row][column];
    let normalized: Vec<_> = reduced[row]
        .iter()
        .map(|&entry| graph.div(entry, pivot))
        .collect();
    let size = graph.as_constant(pivot).map_or(1.0, f64::abs);
    let own: Vec<f64> = terms[row].iter().map(|terms| terms / size).collect();
    for (other, (entries, terms)) in reduced.iter_mut().zip(terms).enumerate() {
        if other == row {
            entries.clone_from(&normalized);
            terms.clone_from(&own);
            continue;
        }
        let factor = entries[column];
        let size = graph.as_constant(factor).map_or(0.0, f64::abs);
        for ((entry, &pivot_entry), (terms, own)) in entries
            .iter_mut()
            .zip(&normalized)
            .zip(terms.iter_mut().zip(&own))
        {
            let product = graph.mul(factor, pivot_entry);
            *entry = graph.sub(*entry, product);
            *terms += size * own;
        }
        // exactly zero, without the rounding error
        entries[column] = graph.constant(0.0);
        terms[column] = 0.0;
    }
}

/// The field that is 1 in one free column and 0 in the other free ones.
fn field(
    graph: &mut Graph,
    reduced: &[Vec<NodeId>],
    pivots: &[Option<usize>],
    n: usize,
    free: usize,
) -> Vec<NodeId> {
    let mut field = vec![graph.constant(0.0); n];
    field[free] = graph.constant(1.0);
    for (row, pivot) in pivots.iter().enumerate() {
        if let Some(column) = *pivot {
            field[column] = graph.neg(reduced[row][free]);
        }
    }
    field
}

/// The field `u_j = (-1)^j det(rows without column j)`.
fn minors(graph: &mut Graph, rows: &[Vec<NodeId>]) -> Vec<NodeId> {
    let n = rows.len() + 1;
    let minor = |skip: usize| {
        let columns: Vec<_> = (0..n).filter(|&column| column != skip).collect();
        let minor = determinant(graph, rows, &columns);
        if skip.is_multiple_of(2) {
            minor
        } else {
            graph.neg(minor)
        }
    };
    (0..n).map(minor).collect()
}

/// The determinant of the rows restricted to some columns, expanded by the first row.
fn determinant(graph: &mut Graph, rows: &[Vec<NodeId>], columns: &[usize]) -> NodeId {
    let Some((first, rest)) = rows.split_first() else {
        return graph.constant(1.0);
    };
    let mut sum = graph.constant(0.0);
    for (place, &column) in columns.iter().enumerate() {
        let others: Vec<_> = columns.iter().copied().filter(|&other| other != column).collect();
        let minor = determinant(graph, rest, &others);
        let product = graph.mul(first[column], minor);
        sum = if place.is_multiple_of(2) {
            graph.add(sum, product)
        } else {
            graph.sub(sum, product)
        };
    }
    sum
}
