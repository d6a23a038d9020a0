//! Displacements of a pair, and two-forms on them.

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
        let part = |offset: usize| core::array::from_fn(|i| f64::from(u8::from(i + offset == index)));
        Self {
            first: part(0),
            second: part(N),
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
    pub(super) fn from_fn(entry: impl Fn(usize, usize, usize, usize) -> f64) -> Self {
        let blocks = core::array::from_fn(|a| {
            core::array::from_fn(|b| core::array::from_fn(|i| core::array::from_fn(|j| entry(a, i, b, j))))
        });
        Self { blocks }
    }

    /// The form of two displacements.
    #[must_use]
    pub fn of(&self, u: &Displacement<N>, w: &Displacement<N>) -> f64 {
        let (u, w) = (u.parts(), w.parts());
        self.entries().map(|(a, i, b, j, x)| u[a][i] * x * w[b][j]).sum()
    }

    /// The largest absolute value of an entry; NaN if one is.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.entries().fold(0.0, |largest, (.., x)| {
            if x.abs() > largest || x.is_nan() {
                x.abs()
            } else {
                largest
            }
        })
    }

    /// All entries, with their places.
    pub(super) fn entries(&self) -> impl Iterator<Item = (usize, usize, usize, usize, f64)> + '_ {
        let places = (0..2).flat_map(|a| (0..2).map(move |b| (a, b)));
        places.flat_map(move |(a, b)| {
            (0..N).flat_map(move |i| (0..N).map(move |j| (a, i, b, j, self.blocks[a][b][i][j])))
        })
    }
}
