//! The order of elimination of a sparse Jacobian.
//!
//! Elimination by a pivot puts the entries of the pivot's row into every row with an entry below it. Minimum
//! degree takes first the pivot that makes the fewest new entries: `(r - 1)(c - 1)` for `r` entries in its
//! row and `c` in its column (Markowitz, "The elimination form of the inverse", 1957). The sizes of entries
//! are unknown here. The core checks the result, and searches for pivots numerically where it is bad.

use std::collections::BTreeSet;

use crate::graph::{Graph, Leaf, NodeId};
use crate::passes::Unknowns;

/// The fewest rows of a sparse elimination; smaller systems are eliminated as dense matrices, in registers.
const FEWEST_ROWS: usize = 12;
/// The cost of an operation of the sparse elimination, which looks up its operands, in operations of the
/// dense one.
const LOOK_UP: usize = 6;

/// The pattern and the pivots of a sparse elimination, by row and column.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Order {
    /// The entries that are not identically zero, row by row.
    pub(crate) entries: Vec<[usize; 2]>,
    /// The pivots, in order.
    pub(crate) pivots: Vec<[usize; 2]>,
}

/// Row and column of the entries that are not identically zero, row by row.
pub(crate) fn entries(graph: &Graph, jacobian: &[Vec<NodeId>]) -> Vec<[usize; 2]> {
    let mut entries = Vec::new();
    for (row, slopes) in jacobian.iter().enumerate() {
        let there = (0..slopes.len()).filter(|&column| !graph.is_zero(slopes[column]));
        entries.extend(there.map(|column| [row, column]));
    }
    entries
}

/// The order for the rows of a step; `None` where a dense elimination costs less, or every order meets a
/// pivot that is zero.
pub(crate) fn order(graph: &Graph, unknowns: &Unknowns) -> Option<Order> {
    let size = unknowns.rows.len();
    if size < FEWEST_ROWS || u16::try_from(size).is_err() {
        return None;
    }
    let entries = entries(graph, &unknowns.jacobian);
    let accelerations = unknowns
        .meanings
        .iter()
        .filter(|leaf| matches!(leaf, Leaf::E(_)))
        .count();
    let mut matrix = Matrix::new(size, &entries, accelerations);
    let mut operations = 2 * entries.len();
    let mut pivots = Vec::with_capacity(size);
    for _ in 0..size {
        let (pivot, changed) = matrix.next()?;
        operations += 1 + changed;
        pivots.push(pivot);
        matrix.take_out(pivot);
    }
    (LOOK_UP * operations < size * size * size / 3).then_some(Order { entries, pivots })
}

/// The pattern of a matrix during the elimination.
struct Matrix {
    rows: Vec<BTreeSet<usize>>,
    columns: Vec<BTreeSet<usize>>,
    /// The rows that have had no pivot yet.
    left: BTreeSet<usize>,
    /// For each row the column paired with it, if the pattern is symmetric in these pairs.
    partners: Option<Vec<usize>>,
}

impl Matrix {
    /// The rows of a step are the constraints, then the works; the unknowns are the accelerations, then the
    /// multipliers. A work is paired with the acceleration that its mass multiplies, and a constraint with
    /// its multiplier.
    fn new(size: usize, entries: &[[usize; 2]], accelerations: usize) -> Self {
        let mut rows = vec![BTreeSet::new(); size];
        let mut columns = rows.clone();
        for &[row, column] in entries {
            rows[row].insert(column);
            columns[column].insert(row);
        }
        let partners: Vec<usize> = (0..size).map(|row| (row + accelerations) % size.max(1)).collect();
        let mut rows_of = vec![0; size];
        for (row, &column) in partners.iter().enumerate() {
            rows_of[column] = row;
        }
        let symmetric = entries
            .iter()
            .all(|&[row, column]| rows[rows_of[column]].contains(&partners[row]));
        Self {
            rows,
            columns,
            left: (0..size).collect(),
            partners: symmetric.then_some(partners),
        }
    }

    /// The next pivot, and the number of entries that it changes. A paired entry is preferred: it is a mass
    /// or, for a multiplier, a sum that the eliminated coordinates have left, and of one sign. Other entries
    /// are slopes of constraints, which may be zero.
    fn next(&self) -> Option<([usize; 2], usize)> {
        let cost = |&[row, column]: &[usize; 2]| (self.rows[row].len() - 1) * self.columns[column].len();
        let best = |pivots: &mut dyn Iterator<Item = [usize; 2]>| {
            pivots
                .map(|pivot| (pivot, cost(&pivot) + self.columns[pivot[1]].len()))
                .min_by_key(|&(_, cost)| cost)
        };
        let of_pairs = self.partners.as_ref().and_then(|partners| {
            let pairs = self.left.iter().map(|&row| [row, partners[row]]);
            best(&mut pairs.filter(|&[row, column]| self.rows[row].contains(&column)))
        });
        of_pairs.or_else(|| {
            let entries = self
                .left
                .iter()
                .flat_map(|&row| self.rows[row].iter().map(move |&column| [row, column]));
            best(&mut { entries })
        })
    }

    /// Eliminates by a pivot, with the fill-in that it makes.
    fn take_out(&mut self, [row, column]: [usize; 2]) {
        self.left.remove(&row);
        let right: Vec<usize> = std::mem::take(&mut self.rows[row])
            .into_iter()
            .filter(|&j| j != column)
            .collect();
        let below: Vec<usize> = std::mem::take(&mut self.columns[column])
            .into_iter()
            .filter(|&i| i != row)
            .collect();
        for &j in &right {
            self.columns[j].remove(&row);
            self.columns[j].extend(&below);
        }
        for &i in &below {
            self.rows[i].remove(&column);
            self.rows[i].extend(&right);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pivots in order, and the number of entries that they change in all.
    fn eliminated(size: usize, entries: &[[usize; 2]], accelerations: usize) -> (Vec<[usize; 2]>, usize) {
        let mut matrix = Matrix::new(size, entries, accelerations);
        let mut changes = 0;
        let pivots = (0..size).map(|_| {
            let (pivot, changed) = matrix.next().expect("a regular pattern");
            changes += changed;
            matrix.take_out(pivot);
            pivot
        });
        (pivots.collect(), changes)
    }

    #[test]
    fn what_has_many_neighbours_comes_last() {
        // unknown 0 occurs in every row, and row 0 has every unknown
        let arrow: Vec<[usize; 2]> = (0..20)
            .flat_map(|i| [[i, i], [0, i], [i, 0]])
            .collect::<BTreeSet<_>>()
            .into_iter()
            .collect();
        let (pivots, changes) = eliminated(20, &arrow, 0);
        assert!(pivots[..18].iter().all(|pivot| *pivot != [0, 0]), "{pivots:?}");
        assert!(changes < 80, "{changes}");
    }

    #[test]
    fn a_multiplier_has_no_pivot_before_its_coordinates() {
        // two masses on a rod: the works, paired with accelerations 0 and 1, follow the constraint
        let entries = [[0, 0], [0, 1], [1, 0], [1, 2], [2, 1], [2, 2]];
        let (pivots, _) = eliminated(3, &entries, 2);
        assert_ne!(pivots[0], [0, 2]);
        assert!(pivots.contains(&[0, 2]), "the pairs are taken: {pivots:?}");
    }

    #[test]
    fn a_row_without_a_pivot_is_found() {
        let mut matrix = Matrix::new(2, &[[0, 0], [1, 0]], 0);
        let (pivot, _) = matrix.next().expect("an entry");
        matrix.take_out(pivot);
        assert!(matrix.next().is_none());
    }
}
