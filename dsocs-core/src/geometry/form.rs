//! Displacements of a pair, and two-forms on them.

use super::array::along;

/// A tangent vector at a pair of nodes, `(δq0, δq1)`; of the continuous system, `(δq, δv)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement<const N: usize> {
    /// `δq0`, or `δq`.
    pub first: [f64; N],
    /// `δq1`, or `δv`.
    pub second: [f64; N],
}

impl<const N: usize> Displacement<N> {
    /// The displacement along coordinate `index` of the first node, or from `N` on of the second; zero beyond the last.
    #[must_use]
    pub fn unit(index: usize) -> Self {
        Self {
            first: along(index, 1.0),
            second: index.checked_sub(N).map_or([0.0; N], |index| along(index, 1.0)),
        }
    }

    /// Both parts.
    pub(super) fn parts(&self) -> [[f64; N]; 2] {
        [self.first, self.second]
    }
}

/// A two-form `Ω(u, w) = Σ_ab u_a · B_ab w_b` on displacements, by its four blocks.
///
/// Blocks are counted by the parts of a displacement: `B_01` belongs to `first` of `u` and `second` of `w`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoForm<const N: usize> {
    /// `blocks[a][b][i][j]`, antisymmetric: `blocks[b][a][j][i]` is the opposite.
    pub blocks: [[[[f64; N]; N]; 2]; 2],
}

impl<const N: usize> TwoForm<N> {
    /// The form with the antisymmetric entries `entry(a, i, b, j)`.
    pub(super) fn from_fn(entry: &dyn Fn(usize, usize, usize, usize) -> f64) -> Self {
        let mut blocks = [[[[0.0; N]; N]; 2]; 2];
        for place in places::<N>() {
            let [a, i, b, j] = place;
            blocks[a][b][i][j] = entry(a, i, b, j);
        }
        Self { blocks }
    }

    /// The form of two displacements.
    #[must_use]
    pub fn of(&self, u: &Displacement<N>, w: &Displacement<N>) -> f64 {
        let (u, w) = (u.parts(), w.parts());
        let terms = self.entries().map(|([a, i, b, j], x)| u[a][i] * x * w[b][j]);
        terms.sum()
    }

    /// The largest absolute value of an entry; NaN if one is.
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

    /// All entries, with their places.
    pub(super) fn entries(&self) -> impl Iterator<Item = ([usize; 4], f64)> + '_ {
        places::<N>().map(|[a, i, b, j]| ([a, i, b, j], self.blocks[a][b][i][j]))
    }
}

/// The places `[a, i, b, j]` of entries: block by block, row by row.
fn places<const N: usize>() -> impl Iterator<Item = [usize; 4]> {
    let square = N * N;
    (0..4 * square).map(move |place| {
        let (block, inside) = (place / square, place % square);
        [block / 2, inside / N, block % 2, inside % N]
    })
}
