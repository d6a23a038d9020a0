//! Certificate of regularity: whether the equations of a step determine the next node, and the previous one.
//!
//! The paper's theorem on the discrete flow requires the derivatives `D₃` and `D₁` of the equations, by the
//! last and by the first node of a triple, to be injective. With as many rows as coordinates they are square
//! matrices. Their smallest singular values measure their distance from singular matrices.

pub(crate) mod deficiency;
pub(crate) mod dependence;
pub(crate) mod flat;
pub(crate) mod forks;
pub(crate) mod lengths;
pub(crate) mod multipliers;
pub(crate) mod resting;
pub(crate) mod rounding;
pub(crate) mod sides;
pub(crate) mod stacked;
pub(crate) mod sticking;
pub(crate) mod undefined;

use crate::kernel::Kernel;
use crate::number::point::{AnyLeg, OwnedLeg, map};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::lengths::{measured, weights};
use crate::regularity::multipliers::of_step;
use crate::regularity::stacked::{of_first_pair, stacked};
use crate::solve::dense::Matrix;
use crate::tape::declaration::Declaration;

/// A singular value is numerically zero below this multiple of `f64::EPSILON`, relative to the largest.
const ROUNDINGS: f64 = 64.0;

/// Bound on a row's slopes, relative to its terms. Where they are larger, the terms vanish because the motion
/// is at rest. The inverse is the fraction of the longest leg by which a coordinate at rest is measured
/// ([`lengths`]).
const STEEP: f64 = 1e3;

/// The certificate of the equations of a step at a triple of nodes `(q0, q1, q2)`.
///
/// `D₃` and `D₁` are the derivatives of the step's equations with respect to the last and the first node. The rows are those of the
/// declaration: kinematic constraints (without a factor that `branch = divide(w)` takes out) and
/// works of the constraint force. If a row was solved beforehand for a second difference, the solved form is used, which
/// does not change the kernel of either matrix. Unknown multipliers are varied together with the node. If there are constraints on
/// positions or velocities, `D₁` contains their rows for the first pair of nodes. This is the matrix with which the inverse flow
/// is computed ([`DiscreteFlow::backward`](crate::geometry::DiscreteFlow::backward)).
///
/// Singular values depend on units, so the matrices are scaled. A row is divided by the magnitude of its own
/// terms. The unit of a coordinate is the longer of its two legs, or a thousandth of the longest leg of all
/// coordinates, if that is longer; the masses `∂²L/∂v²` make the lengths of different coordinates comparable.
/// The unit of a multiplier, and of a coordinate without mass that does not move, is the change that changes
/// some row by the magnitude of its terms. So the values do not depend on the units of coordinates,
/// constraints, mass or time. A value of 1 means that a change of `q2` by the length of a leg changes the
/// rows by the magnitude of their terms. Derivatives are exact, by dual numbers. Only your own Rust functions
/// whose arguments contain `q0` or `q2` are differentiated by finite differences of eighth order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regularity {
    /// The smallest singular value of `D₃`, by the last node; NaN if the matrix is not finite.
    pub forward: f64,
    /// The smallest singular value of `D₁`, by the first node; NaN if the matrix is not finite.
    pub backward: f64,
    /// The largest singular value of `D₃`.
    pub largest_forward: f64,
    /// The largest singular value of `D₁`.
    pub largest_backward: f64,
}

impl Regularity {
    /// An unknown certificate: all values are NaN.
    pub const UNKNOWN: Self = Self {
        forward: f64::NAN,
        backward: f64::NAN,
        largest_forward: f64::NAN,
        largest_backward: f64::NAN,
    };

    /// The certificate of the step `h` from a leg with the second difference `e = q2 − 2 q1 + q0`.
    ///
    /// The triple need not solve the equations. Leg and second difference have one component for each
    /// coordinate; otherwise the result is [`Self::UNKNOWN`].
    #[must_use]
    pub fn of(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> Self {
        let declaration = Declaration::of(system);
        if !fit(&declaration, &[leg.q, leg.d, e]) {
            return Self::UNKNOWN;
        }
        Self::of_declaration(&declaration, h, leg, e)
    }

    /// The certificate for a declaration; see [`Self::of`].
    pub(crate) fn of_declaration(
        declaration: &Declaration<'_>,
        h: f64,
        leg: AnyLeg<'_, f64>,
        e: &[f64],
    ) -> Self {
        let triple = Triple::new(declaration, h, leg, e);
        // q0 = q1 − d and q2 = q1 + d + e: a change of q2 changes e; a change δ of q0 changes d by −δ and e
        // by δ
        let forward = triple.extremes([0.0, 1.0], false);
        Self::measured(forward, triple.extremes([-1.0, 1.0], true))
    }

    /// The certificate of a step of third order: forward, the equations by the last of four nodes; backward,
    /// by the first node, the rows of third order (with the indices `third`) and the other rows at the first
    /// three nodes. Each of these is divided by its largest entry.
    pub(crate) fn of_third(
        declaration: &Declaration<'_>,
        past: &[f64],
        third: &[usize],
        h: f64,
        leg: AnyLeg<'_, f64>,
        e: &[f64],
    ) -> Self {
        let triple = Triple::new(declaration, h, leg, e);
        let forward = triple.extremes([0.0, 1.0], false);
        Self::measured(forward, triple.extremes_of_four(past, third))
    }

    /// The regularity with the smallest and the largest singular value forward and backward.
    fn measured([forward, largest_forward]: [f64; 2], [backward, largest_backward]: [f64; 2]) -> Self {
        Self {
            forward,
            backward,
            largest_forward,
            largest_backward,
        }
    }

    /// Whether the equations determine the last node from the other two, here and nearby: the theorem's condition on `D₃`.
    #[must_use]
    pub fn grants_forward(&self) -> bool {
        is_regular(self.forward, self.largest_forward)
    }

    /// Whether the equations determine the first node from the other two: the theorem's condition on `D₁`.
    #[must_use]
    pub fn grants_backward(&self) -> bool {
        is_regular(self.backward, self.largest_backward)
    }

    /// Whether the theorem grants a discrete flow here, a diffeomorphism between submanifolds of pairs of nodes.
    #[must_use]
    pub fn grants_flow(&self) -> bool {
        self.grants_forward() && self.grants_backward()
    }

    /// The condition number of `D₃`: how many times relative errors of the equations are magnified in the next node.
    #[must_use]
    pub fn condition(&self) -> f64 {
        self.largest_forward / self.forward
    }
}

/// Whether vectors have one component for each coordinate.
pub(crate) fn fit(declaration: &Declaration<'_>, vectors: &[&[f64]]) -> bool {
    vectors
        .iter()
        .all(|vector| vector.len() == declaration.dimension())
}

/// Whether the smallest singular value is above rounding.
fn is_regular(smallest: f64, largest: f64) -> bool {
    smallest > ROUNDINGS * f64::EPSILON * largest && largest.is_finite()
}

/// The singular values of the derivative by all three nodes, unsorted; empty if it is not finite.
pub(crate) fn all_singular_values(
    declaration: &Declaration<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    e: &[f64],
) -> Vec<f64> {
    let triple = Triple::new(declaration, h, leg, e);
    // a change δ of q1 changes the two increments by δ and −δ, and so e by −2δ
    let nodes = [[0.0, -1.0, 1.0], [1.0, 1.0, -2.0], [0.0, 0.0, 1.0]];
    triple
        .matrix(&nodes, false)
        .map_or_else(Vec::new, |matrix| matrix.decomposed().values)
}

/// A triple of nodes, with the units for its equations.
struct Triple<'a> {
    declaration: &'a Declaration<'a>,
    h: f64,
    leg: AnyLeg<'a, f64>,
    e: &'a [f64],
    /// Values of all multipliers at the triple.
    multipliers: Vec<f64>,
    /// The length of each coordinate in this step; `None` for a coordinate without mass that does not move.
    lengths: Vec<Option<f64>>,
}

/// The derivatives of all rows along one direction.
struct Column {
    /// The derivatives, by row.
    slopes: Vec<f64>,
    /// For each row, the largest of the parts of this sum: by the middle node, the increment and the second
    /// difference. If the parts cancel, the sum is rounding of this magnitude.
    parts: Vec<f64>,
    /// The kind of its length.
    length: Length,
}

/// Source of the length of a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Length {
    /// The length of a leg.
    Leg,
    /// The coordinate does not move: the inverse square root of its mass, up to a factor common to all such
    /// coordinates.
    Mass,
    /// Unknown: a coordinate without mass that does not move.
    Coordinate,
    /// Unknown: a multiplier.
    Multiplier,
}

impl<'a> Triple<'a> {
    /// The triple of a leg and a second difference.
    fn new(declaration: &'a Declaration<'a>, h: f64, leg: AnyLeg<'a, f64>, e: &'a [f64]) -> Self {
        Self {
            declaration,
            h,
            leg,
            e,
            multipliers: of_step(declaration, h, leg, e),
            lengths: measured(declaration, h, leg, e),
        }
    }

    /// The smallest and the largest singular value of the derivative by a node whose change changes `[d, e]`
    /// by these factors, and by the multipliers; `first_pair` includes the constraint rows of the first pair
    /// of nodes.
    fn extremes(&self, [by_d, by_e]: [f64; 2], first_pair: bool) -> [f64; 2] {
        match self.matrix(&[[0.0, by_d, by_e]], first_pair) {
            Some(matrix) => matrix.decomposed().extremes(),
            None => [f64::NAN; 2],
        }
    }

    /// The smallest and the largest singular value of the derivative by the first of four nodes.
    fn extremes_of_four(&self, past: &[f64], third: &[usize]) -> [f64; 2] {
        let h = Tangent::splat(self.h);
        let n = self.declaration.dimension();
        let less = |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| x - y).collect() };
        // the previous triple; its second difference is `past`
        let (q, d) = (less(self.leg.q, self.leg.d), less(self.leg.d, past));
        let before = AnyLeg {
            t: self.leg.t - self.h,
            q: &q,
            d: &d,
        };
        let known = of_step(&self.declaration.after(&[]), self.h, before, past);
        let columns = (0..n + known.len()).map(|k| {
            let moved = |x: &[f64], sign: f64| -> Vec<Tangent> {
                let numbers = x.iter().zip(&self.lengths).enumerate();
                numbers
                    .map(|(i, (&x, length))| {
                        let by = if i == k { length.unwrap_or(1.0) } else { 0.0 };
                        Tangent::new(x, sign * by)
                    })
                    .collect()
            };
            let multipliers: Vec<_> = (0..known.len())
                .map(|j| Tangent::new(known[j], if n + j == k { 1.0 } else { 0.0 }))
                .collect();
            let leg = self.leg.map(Tangent::splat);
            let own =
                self.declaration
                    .declared_after(h, leg.any(), &moved(past, 1.0), &moved(self.e, -1.0), &[]);
            let first = OwnedLeg {
                t: Tangent::splat(before.t),
                q: map(before.q, Tangent::splat),
                d: moved(before.d, -1.0),
            };
            let zero = vec![Tangent::splat(0.0); n];
            let second = moved(past, 1.0);
            let others = self
                .declaration
                .declared_after(h, first.any(), &zero, &second, &multipliers);
            let bound = of_first_pair(self.declaration, h, first.any());
            let rows = own.into_iter().zip(others).enumerate();
            rows.map(|(place, (own, other))| {
                let row = match bound.get(place) {
                    Some(bound) => *bound,
                    None if third.contains(&place) => own,
                    None => other,
                };
                row.derivative()
            })
            .collect::<Vec<f64>>()
        });
        let columns: Vec<_> = columns.collect();
        let size = columns.first().map_or(0, Vec::len);
        let mut matrix = Matrix::from_fn(size, columns.len(), |i, j| columns[j][i]);
        for i in 0..size {
            let largest = matrix.row(i).fold(0.0_f64, |largest, x| largest.max(x.abs()));
            if largest > 0.0 {
                matrix.divide_row(i, largest);
            }
        }
        if known.is_empty() {
            return if matrix.is_finite() {
                matrix.decomposed().extremes()
            } else {
                [f64::NAN; 2]
            };
        }
        // the unit of a multiplier: its column has norm 1
        matrix.normalize_columns();
        if matrix.is_finite() {
            matrix.decomposed().extremes()
        } else {
            [f64::NAN; 2]
        }
    }

    /// The scaled derivative of all rows by the multipliers and by nodes whose change changes `[q, d, e]` by
    /// these factors; `None` if it is not finite.
    ///
    /// In the equations of a step, constraints on positions and velocities bind the last node and the last
    /// pair only. If the first node is unknown, the last pair is given and obeys them, so `first_pair` takes
    /// them for the first pair.
    fn matrix(&self, nodes: &[[f64; 3]], first_pair: bool) -> Option<Matrix> {
        let weights = weights(self.declaration, self.h, self.leg);
        let mut columns = Vec::with_capacity(nodes.len() * weights.len() + self.multipliers.len());
        for &[by_q, by_d, by_e] in nodes {
            for (j, &weight) in weights.iter().enumerate() {
                let (length, kind) = match self.lengths[j] {
                    Some(length) => (length, Length::Leg),
                    None if weight > 0.0 => (weight.recip(), Length::Mass),
                    None => (1.0, Length::Coordinate),
                };
                let mut column = Column::new(kind);
                let parts = [[by_q, 0.0, 0.0], [0.0, by_d, 0.0], [0.0, 0.0, by_e]];
                for by in parts.into_iter().filter(|by| by.iter().any(|by| by.abs() > 0.0)) {
                    column.add(&self.slopes(Some((j, by.map(|by| by * length))), None, first_pair));
                }
                columns.push(column);
            }
        }
        for j in (0..self.multipliers.len()).filter(|&j| self.is_unknown(j)) {
            let mut column = Column::new(Length::Multiplier);
            column.add(&self.slopes(None, Some(j), first_pair));
            columns.push(column);
        }
        let by_slopes = nodes.len() > 1 || self.declaration.lower() > 0 || self.declaration.has_multipliers();
        let mut sizes = self.sizes(&columns, by_slopes, first_pair);
        // the best known lengths first: their columns give rows without terms their magnitudes
        scale_columns(&mut columns, &sizes, Length::Mass);
        scale_columns(&mut columns, &sizes, Length::Coordinate);
        size_rows(&mut sizes, &columns, |length| length != Length::Multiplier);
        scale_columns(&mut columns, &sizes, Length::Multiplier);
        size_rows(&mut sizes, &columns, |_| true);
        let matrix = Matrix::from_fn(sizes.len(), columns.len(), |i, j| {
            let slope = columns[j].slope(i);
            if slope == 0.0 { 0.0 } else { slope / sizes[i] }
        });
        matrix.is_finite().then_some(matrix)
    }

    /// Whether multiplier `j` is among the unknowns of the step.
    fn is_unknown(&self, j: usize) -> bool {
        let mut multipliers = vec![0.0; self.multipliers.len()];
        if let Some(multiplier) = multipliers.get_mut(j) {
            *multiplier = 1.0;
        }
        let unknown = self
            .declaration
            .unknown(&vec![0.0; self.lengths.len()], &multipliers);
        unknown.iter().any(|&x| x != 0.0)
    }

    /// The derivatives of all rows by coordinate `j` of the middle node, the increment and the second
    /// difference together, with the given factors, or by a multiplier.
    fn slopes(
        &self,
        coordinate: Option<(usize, [f64; 3])>,
        multiplier: Option<usize>,
        first_pair: bool,
    ) -> Vec<f64> {
        let along = |x: &[f64], part: usize| -> Vec<Tangent> {
            let numbers = x.iter().enumerate();
            numbers
                .map(|(i, &x)| match coordinate {
                    Some((j, by)) if i == j => Tangent::new(x, by[part]),
                    _ => Tangent::splat(x),
                })
                .collect()
        };
        let leg = OwnedLeg {
            t: Tangent::splat(self.leg.t),
            q: along(self.leg.q, 0),
            d: along(self.leg.d, 1),
        };
        let e = along(self.e, 2);
        let by = |j: usize| if Some(j) == multiplier { 1.0 } else { 0.0 };
        let multipliers: Vec<_> = self
            .multipliers
            .iter()
            .enumerate()
            .map(|(j, &x)| Tangent::new(x, by(j)))
            .collect();
        let h = Tangent::new(self.h, 0.0);
        let mut rows = stacked(self.declaration, h, leg.any(), &e, &multipliers);
        if first_pair {
            rows.extend(of_first_pair(self.declaration, h, leg.any()));
        }
        rows.into_iter().map(Tangent::derivative).collect()
    }

    /// The magnitudes of the rows: those of their terms, from the bounds on their rounding errors. With
    /// `by_slopes`, a row's largest slope counts if it is larger: where some coordinates come to rest, the
    /// terms of their rows vanish, but the equations stay regular. Otherwise the largest slope counts fully
    /// only in a row without rounding error, and elsewhere only `1/STEEP` of it: rows of different magnitudes
    /// are no loss of regularity.
    fn sizes(&self, columns: &[Column], by_slopes: bool, first_pair: bool) -> Vec<f64> {
        let mut bounds = rounding::stacked_bounds(self.declaration, self.h, self.leg, self.e);
        if first_pair {
            bounds.extend(rounding::first_pair_bounds(self.declaration, self.h, self.leg));
        }
        let measured = || columns.iter().filter(|column| column.length == Length::Leg);
        let size = |(i, &bound): (usize, &f64)| {
            let terms = bound / f64::EPSILON;
            let slope = || measured().fold(0.0, |largest, column| column.part(i).max(largest));
            if by_slopes || terms <= 0.0 || terms.is_nan() {
                slope().max(terms)
            } else {
                terms.max(slope() / STEEP)
            }
        };
        bounds.iter().enumerate().map(size).collect()
    }
}

impl Column {
    /// A column without derivatives.
    fn new(length: Length) -> Self {
        Self {
            slopes: Vec::new(),
            parts: Vec::new(),
            length,
        }
    }

    /// Adds the derivatives by one more of its parts.
    fn add(&mut self, slopes: &[f64]) {
        for sums in [&mut self.slopes, &mut self.parts] {
            sums.resize(slopes.len(), 0.0);
        }
        let sums = self.slopes.iter_mut().zip(&mut self.parts);
        for ((sum, part), slope) in sums.zip(slopes) {
            *sum += slope;
            *part = part.max(slope.abs());
        }
    }

    /// The largest part of the derivative of a row.
    fn part(&self, row: usize) -> f64 {
        self.parts.get(row).copied().unwrap_or(f64::NAN)
    }

    /// The derivative of a row.
    fn slope(&self, row: usize) -> f64 {
        self.slopes.get(row).copied().unwrap_or(f64::NAN)
    }

    /// The largest part of the derivative of any row, relative to the row's magnitude.
    fn largest(&self, sizes: &[f64]) -> f64 {
        let entries = self.parts.iter().zip(sizes).filter(|(_, size)| **size > 0.0);
        entries.fold(0.0, |largest, (part, size)| largest.max(part / size))
    }
}

/// Scales directions of unknown length so that they change some row by the magnitude of its terms: each by
/// its own factor, those of kind `Mass` by a common one. (The value of a multiplier is no unit: it may vanish
/// while the equations are regular.)
fn scale_columns(columns: &mut [Column], sizes: &[f64], of: Length) {
    let scaled = || columns.iter().filter(|column| column.length == of);
    let common = scaled().fold(0.0_f64, |largest, column| largest.max(column.largest(sizes)));
    for column in columns.iter_mut().filter(|column| column.length == of) {
        let largest = if of == Length::Mass {
            common
        } else {
            column.largest(sizes)
        };
        if largest > 0.0 && largest.is_finite() {
            for slope in column.slopes.iter_mut().chain(&mut column.parts) {
                *slope /= largest;
            }
        }
    }
}

/// Sets the magnitude of each row without one to its largest slope.
fn size_rows(sizes: &mut [f64], columns: &[Column], counts: impl Fn(Length) -> bool) {
    for (i, size) in sizes.iter_mut().enumerate().filter(|(_, size)| **size <= 0.0) {
        let columns = columns.iter().filter(|column| counts(column.length));
        *size = columns.fold(0.0, |largest, column| column.part(i).max(largest));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The threshold is relative to rounding: a small singular value above it still grants a flow.
    #[test]
    fn all_but_rounding_is_regular() {
        let at = |smallest: f64| Regularity {
            forward: smallest,
            backward: 3.0 * smallest,
            largest_forward: 1.0,
            largest_backward: 3.0,
        };
        let rounding = ROUNDINGS * f64::EPSILON;
        for smallest in [1.0, 1e-6, 1e-12, 1.01 * rounding] {
            assert!(at(smallest).grants_flow(), "{smallest:e}");
        }
        for smallest in [0.99 * rounding, 0.0, f64::NAN] {
            let at = at(smallest);
            assert!(!at.grants_forward() && !at.grants_backward(), "{smallest:e}");
        }
    }
}
