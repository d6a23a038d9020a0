//! Displacements of a pair, and two-forms on them.

use super::array::{along, zero};

/// A tangent vector at a pair of nodes, `(δq0, δq1)`; of the continuous system, `(δq, δv)`. Each part has one component for each
/// coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Displacement {
    /// `δq0`, or `δq`.
    pub first: Vec<f64>,
    /// `δq1`, or `δv`.
    pub second: Vec<f64>,
}

impl Displacement {
    /// The displacement of `n` coordinates along coordinate `index` of the first node, or from `n` on of the second; zero beyond the last.
    #[must_use]
    pub fn unit(n: usize, index: usize) -> Self {
        Self {
            first: along(n, index, 1.0),
            second: index.checked_sub(n).map_or(zero(n), |index| along(n, index, 1.0)),
        }
    }
}

/// Four blocks of a matrix on displacements, by the parts of two displacements, the rows, and the columns.
type Blocks = [[Vec<Vec<f64>>; 2]; 2];

/// A two-form `Ω(u, w) = Σ_ab u_a · B_ab w_b` on displacements, by its four blocks.
///
/// The indices of blocks are those of the parts of a displacement: `B_01` belongs to `first` of `u` and
/// `second` of `w`.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoForm {
    /// `blocks[a][b][i][j]`, antisymmetric: `blocks[b][a][j][i]` is the opposite. Each block is square, with a row for each coordinate.
    pub blocks: Blocks,
}

impl TwoForm {
    /// The form on displacements of `n` coordinates with the antisymmetric entries `entry(a, i, b, j)`.
    pub(super) fn from_fn(n: usize, entry: &dyn Fn(usize, usize, usize, usize) -> f64) -> Self {
        let row = |a, b, i| (0..n).map(|j| entry(a, i, b, j)).collect();
        let block = |a, b| (0..n).map(|i| row(a, b, i)).collect();
        Self {
            blocks: [[block(0, 0), block(0, 1)], [block(1, 0), block(1, 1)]],
        }
    }

    /// The form of two displacements.
    #[must_use]
    pub fn of(&self, u: &Displacement, w: &Displacement) -> f64 {
        let (u, w) = ([&u.first, &u.second], [&w.first, &w.second]);
        let component = |x: [&Vec<f64>; 2], a: usize, i: usize| x[a].get(i).copied().unwrap_or(0.0);
        let terms = self
            .entries()
            .map(|([a, i, b, j], x)| component(u, a, i) * x * component(w, b, j));
        terms.sum()
    }

    /// The largest absolute value of an entry; NaN if an entry is NaN.
    #[must_use]
    pub fn largest(&self) -> f64 {
        let mut largest = 0.0;
        for (_, x) in self.entries() {
            if x.abs() > largest || x.is_nan() {
                largest = x.abs();
            }
        }
        largest
    }

    /// All entries with their places `[a, i, b, j]`, block by block, row by row.
    pub(super) fn entries(&self) -> impl Iterator<Item = ([usize; 4], f64)> + '_ {
        let blocks = self.blocks.iter().enumerate();
        let blocks =
            blocks.flat_map(|(a, blocks)| blocks.iter().enumerate().map(move |(b, block)| (a, b, block)));
        let rows =
            blocks.flat_map(|(a, b, block)| block.iter().enumerate().map(move |(i, row)| ([a, i, b], row)));
        rows.flat_map(|([a, i, b], row)| row.iter().enumerate().map(move |(j, &x)| ([a, i, b, j], x)))
    }
}
