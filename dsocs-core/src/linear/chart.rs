//! Minimal coordinates of the state near a point: the directions that constraints on positions and velocities
//! leave free.

use super::slopes::{At, Direction, Slopes};
use crate::number::{inner_product, remove_part};
use crate::solve::dense::{Matrix, ZERO, length};
use crate::tape::declaration::Declaration;
use crate::tape::{Leaf, Part, Segment};

/// A component of a direction below this is rounding.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A vector counts as longer than another only if it is longer by this factor; of vectors of equal length the first is taken.
const LONGER: f64 = 1.0 + 1e-9;

/// The constraint rows on position and velocity at a point, with their derivatives: `g(t, q)`, `c(t, q, v)`,
/// `dg/dt`.
#[derive(Clone, Debug)]
pub(super) struct ConstraintRows {
    coordinates: usize,
    holonomic: usize,
    rows: Slopes,
    /// The derivatives of the position constraints by the coordinates.
    positions: Rows,
    /// The derivatives of the velocity constraints by the velocities.
    velocities: Rows,
}

/// The derivatives of some rows, each divided by its length.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    columns: usize,
    /// The columns of the zeros of rotations, along which nothing changes.
    still: Vec<usize>,
    lengths: Vec<f64>,
    entries: Vec<Vec<f64>>,
}

impl Rows {
    /// The `wanted` rows of a matrix, given by its columns; `still` are the columns of the zeros of
    /// rotations.
    pub(super) fn new(columns: &[Vec<f64>], wanted: core::ops::Range<usize>, still: Vec<usize>) -> Self {
        let row = |i: usize| -> Vec<f64> { columns.iter().map(|column| column[i]).collect() };
        let mut entries: Vec<Vec<f64>> = wanted.map(row).collect();
        let lengths: Vec<f64> = entries.iter().map(|row| length(row)).collect();
        for (row, &length) in entries.iter_mut().zip(&lengths) {
            if length > 0.0 {
                for entry in row.iter_mut() {
                    *entry /= length;
                }
            }
        }
        Self {
            columns: columns.len(),
            still,
            lengths,
            entries,
        }
    }

    fn matrix(&self) -> Matrix {
        Matrix::from_fn(self.entries.len(), self.columns, |i, j| self.entries[i][j])
    }

    /// The shortest change of the columns' variables that changes the rows by `changes`.
    pub(super) fn shortest(&self, changes: &[f64]) -> Vec<f64> {
        if self.entries.is_empty() {
            return vec![0.0; self.columns];
        }
        let scaled = changes.iter().zip(&self.lengths);
        let scaled: Vec<f64> = scaled
            .map(|(change, length)| if *length > 0.0 { change / length } else { 0.0 })
            .collect();
        self.matrix().decomposed().solve(&scaled, ZERO)
    }

    /// An orthonormal basis of the changes that leave the rows unchanged.
    pub(super) fn kernel(&self) -> Basis {
        let axis = |i: &usize| (0..self.columns).map(|j| f64::from(u8::from(*i == j))).collect();
        let still = self.still.iter().map(axis);
        if self.entries.is_empty() {
            return Basis::of(self.columns, &still.collect::<Vec<_>>());
        }
        let singular = self.matrix().decomposed();
        let [_, largest] = singular.extremes();
        let terms = singular.values.iter().zip(&singular.right);
        let bound = terms.filter(|(value, _)| **value > ZERO * largest);
        Basis::of(
            self.columns,
            &bound
                .map(|(_, right)| right.clone())
                .chain(still)
                .collect::<Vec<_>>(),
        )
    }
}

/// An orthonormal basis of some directions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Basis {
    /// The vectors.
    pub(super) vectors: Vec<Vec<f64>>,
    /// For each vector, the coordinate that it moves most.
    pub(super) along: Vec<usize>,
}

impl Basis {
    /// The orthonormal complement of orthonormal vectors: as near as possible to the axes of the coordinates,
    /// in their order.
    pub(super) fn of(columns: usize, bound: &[Vec<f64>]) -> Self {
        let axis = |i: usize| {
            (0..columns)
                .map(|j| f64::from(u8::from(i == j)))
                .collect::<Vec<f64>>()
        };
        let mut chosen: Vec<(usize, Vec<f64>)> = Vec::new();
        while chosen.len() + bound.len() < columns {
            let mut longest: Option<(usize, f64, Vec<f64>)> = None;
            for i in (0..columns).filter(|i| chosen.iter().all(|(along, _)| along != i)) {
                let mut rest = axis(i);
                // twice, since the first pass leaves rounding errors of the removed components
                for _ in 0..2 {
                    for vector in bound.iter().chain(chosen.iter().map(|(_, vector)| vector)) {
                        remove_part(&mut rest, vector);
                    }
                }
                let size = length(&rest);
                if longest.as_ref().is_none_or(|(_, known, _)| size > known * LONGER) {
                    longest = Some((i, size, rest));
                }
            }
            let Some((along, size, rest)) = longest.filter(|(_, size, _)| *size > 0.0) else {
                break;
            };
            chosen.push((along, unit(rest, size)));
        }
        chosen.sort_by_key(|(along, _)| *along);
        let (along, vectors) = chosen.into_iter().unzip();
        Self { vectors, along }
    }

    /// The coordinates of a vector.
    pub(super) fn coordinates(&self, vector: &[f64]) -> Vec<f64> {
        self.vectors
            .iter()
            .map(|own| inner_product(own, vector))
            .collect()
    }

    /// The basis of another space that is nearest to this one: the vectors of this basis, projected into that
    /// space one after the other.
    fn carried_to(&self, other: &Self) -> Self {
        let mut vectors: Vec<Vec<f64>> = Vec::with_capacity(self.vectors.len());
        for vector in &self.vectors {
            let mut within = vec![0.0; vector.len()];
            for (part, own) in other.coordinates(vector).into_iter().zip(&other.vectors) {
                within.iter_mut().zip(own).for_each(|(sum, x)| *sum += part * x);
            }
            for _ in 0..2 {
                for known in &vectors {
                    remove_part(&mut within, known);
                }
            }
            let size = length(&within);
            vectors.push(unit(within, size));
        }
        Self {
            vectors,
            along: self.along.clone(),
        }
    }
}

/// A vector divided by its length, with rounding errors set to zero.
fn unit(vector: Vec<f64>, length: f64) -> Vec<f64> {
    let scaled = vector.into_iter().map(|x| x / length);
    scaled.map(|x| if x.abs() < ROUNDING { 0.0 } else { x }).collect()
}

impl ConstraintRows {
    /// The rows at a time, a position and a velocity.
    pub(super) fn of(declaration: &Declaration<'_>, at: &At<'_>) -> Self {
        let rows = at.slopes(declaration, &[(Segment::Phase, Part::All)]);
        let coordinates = declaration.dimension();
        let (holonomic, count) = (declaration.holonomic(), rows.values.len());
        let columns = |leaf: fn(usize) -> Leaf| -> Vec<Vec<f64>> {
            (0..coordinates).map(|j| rows.by(leaf(j))).collect()
        };
        let still = || declaration.shape().rotations.to_vec();
        Self {
            positions: Rows::new(&columns(Leaf::Q), 0..holonomic, still()),
            velocities: Rows::new(&columns(Leaf::V), holonomic..count, still()),
            coordinates,
            holonomic,
            rows,
        }
    }

    /// The shortest correction of a change of position, velocity and parameters after which the constraint
    /// rows are unchanged. It is orthogonal to the free directions.
    pub(super) fn obeyed(&self, direction: &Direction) -> Direction {
        let own = self.rows.along(&|leaf| direction.rate(leaf, &[]));
        let negative = |changes: &[f64]| -> Vec<f64> { changes.iter().map(|x| -x).collect() };
        let still = vec![0.0; self.coordinates];
        let q = Direction {
            q: self.positions.shortest(&negative(&own[..self.holonomic])),
            v: still.clone(),
            parameter: None,
        };
        let moved = direction.plus(&q, 1.0);
        let own = self.rows.along(&|leaf| moved.rate(leaf, &[]));
        let v = Direction {
            q: still,
            v: self.velocities.shortest(&negative(&own[self.holonomic..])),
            parameter: None,
        };
        moved.plus(&v, 1.0)
    }

    /// The free directions.
    pub(super) fn chart(&self) -> Chart {
        Chart {
            positions: self.positions.kernel(),
            velocities: self.velocities.kernel(),
        }
    }
}

/// Orthonormal bases of the free directions of the position, and of the velocity.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chart {
    pub(super) positions: Basis,
    pub(super) velocities: Basis,
}

impl Chart {
    /// The number of minimal coordinates.
    pub(super) fn len(&self) -> usize {
        self.positions.vectors.len() + self.velocities.vectors.len()
    }

    /// The minimal coordinates of a change of position and velocity.
    pub(super) fn coordinates(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        let mut coordinates = self.positions.coordinates(q);
        coordinates.extend(self.velocities.coordinates(v));
        coordinates
    }

    /// The weights of position and velocity in each minimal coordinate, one after the other.
    pub(super) fn projection(&self) -> Vec<Vec<f64>> {
        self.directions()
            .map(|direction| [direction.q, direction.v].concat())
            .collect()
    }

    /// The changes of the state along each minimal coordinate, before the correction by [`ConstraintRows::obeyed`].
    pub(super) fn directions(&self) -> impl Iterator<Item = Direction> {
        let still = |vector: &Vec<f64>| vec![0.0; vector.len()];
        let positions = self.positions.vectors.iter().map(move |q| Direction {
            v: still(q),
            q: q.clone(),
            parameter: None,
        });
        let velocities = self.velocities.vectors.iter().map(move |v| Direction {
            q: still(v),
            v: v.clone(),
            parameter: None,
        });
        positions.chain(velocities)
    }

    /// The chart at the next point of a motion, whose bases are as near as possible to those of this one.
    pub(super) fn carried_to(&self, next: &Self) -> Self {
        Self {
            positions: self.positions.carried_to(&next.positions),
            velocities: self.velocities.carried_to(&next.velocities),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_basis_of_a_plane_is_near_the_axes() {
        let normal = [0.6, 0.0, 0.8];
        let basis = Basis::of(3, &[normal.to_vec()]);
        assert_eq!(basis.along, [0, 1]);
        assert_eq!(basis.vectors[1], [0.0, 1.0, 0.0]);
        let expected = [0.8, 0.0, -0.6];
        for (x, y) in basis.vectors[0].iter().zip(expected) {
            assert!((x - y).abs() < 1e-15, "{basis:?}");
        }
        assert_eq!(Basis::of(2, &[]).vectors, [[1.0, 0.0], [0.0, 1.0]]);
        assert!(Basis::of(2, &[vec![1.0, 0.0], vec![0.0, 1.0]]).vectors.is_empty());
    }

    #[test]
    fn a_basis_is_carried_along() {
        let angle = 1e-3_f64;
        let tangent = |angle: f64| Basis::of(2, &[vec![angle.sin(), -angle.cos()]]);
        let next = tangent(0.3 + angle);
        let carried = tangent(0.3).carried_to(&next);
        assert!((inner_product(&carried.vectors[0], &next.vectors[0]) - 1.0).abs() < 1e-15);
    }
}
