//! Whether the equations of a step determine the next node, and the node before.
//!
//! The paper's theorem on the discrete flow asks that the derivatives `D₃` and `D₁` of the equations, those by the last and
//! by the first node of a triple, be injective. With as many rows as coordinates they are square matrices, and how far they
//! are from singular is told by their smallest singular values.

pub(crate) mod deficiency;
pub(crate) mod dependence;
pub(crate) mod flat;
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

/// A singular value below this many units of rounding, relative to the largest, is zero for all that can be told.
const ROUNDINGS: f64 = 64.0;

/// A row's slopes are at most so many times its terms, or the terms vanish with a motion that stands still: a coordinate that moves by less than this part of
/// the others, inverted, is measured by them ([`lengths`]), and its terms are not.
const STEEP: f64 = 1e3;

/// How regular the equations of a step are at a triple of nodes `(q0, q1, q2)`.
///
/// `D₃` and `D₁` are the derivatives of the step's equations with respect to the last and the first node. The rows are those of the
/// declaration: kinematic constraints (without a factor that `branch = divide(w)` takes out) and
/// works of the constraint force. If a row was solved beforehand for a second difference, the solved form is used, which
/// does not change the kernel of either matrix. Unknown multipliers are varied together with the node. If there are constraints on
/// positions or velocities, `D₁` contains their rows for the first pair of nodes. This is the matrix with which the inverse flow
/// is computed ([`DiscreteFlow::backward`](crate::geometry::DiscreteFlow::backward)).
///
/// Singular values depend on units, so the matrices are scaled. A row is divided by the size of its own terms. A coordinate is measured
/// relative to the longer of its two legs, or to a thousandth of the longest leg of all coordinates, if that is longer; for this the masses
/// `∂²L/∂v²` make lengths of different coordinates comparable. Multipliers, and coordinates without mass that do not move, are measured
/// relative to the change that changes some row by the size of its terms. So the values do not depend on the units of coordinates,
/// constraints, mass or time. A value of 1 means that a change of `q2` by the length of a leg changes the rows by the size of their terms.
/// Derivatives are exact, by dual numbers. Only your own Rust functions whose arguments contain `q0` or `q2` are differentiated by finite
/// differences of eighth order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regularity {
    /// The smallest singular value of `D₃`, by the last node; NaN where it has none.
    pub forward: f64,
    /// The smallest singular value of `D₁`, by the first node; NaN where it has none.
    pub backward: f64,
    /// The largest singular value of `D₃`.
    pub largest_forward: f64,
    /// The largest singular value of `D₁`.
    pub largest_backward: f64,
}

impl Regularity {
    /// Nothing is known: all values are NaN.
    pub const UNKNOWN: Self = Self {
        forward: f64::NAN,
        backward: f64::NAN,
        largest_forward: f64::NAN,
        largest_backward: f64::NAN,
    };

    /// The regularity of the step `h` from a leg with the second difference `e = q2 − 2 q1 + q0`.
    ///
    /// The triple need not solve the equations. Leg and second difference have one component for each coordinate; of others nothing is known.
    #[must_use]
    pub fn of(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> Self {
        let declaration = Declaration::of(system);
        if !fit(&declaration, &[leg.q, leg.d, e]) {
            return Self::UNKNOWN;
        }
        Self::of_declaration(&declaration, h, leg, e)
    }

    /// The same of a declaration.
    pub(crate) fn of_declaration(
        declaration: &Declaration<'_>,
        h: f64,
        leg: AnyLeg<'_, f64>,
        e: &[f64],
    ) -> Self {
        let triple = Triple::new(declaration, h, leg, e);
        // q0 = q1 − d and q2 = q1 + d + e: moving q2 moves e, moving q0 moves d back and e on
        let forward = triple.extremes([0.0, 1.0], false);
        Self::measured(forward, triple.extremes([-1.0, 1.0], true))
    }

    /// The regularity of a step of third order, with the equations by the last of four nodes; and, for the inverse flow, the constraints of
    /// third order (at the places `third`) by the first of them beside the other equations of the first three nodes. Each row of these is
    /// measured by the largest of its entries.
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

/// Whether a smallest singular value is more than rounding.
fn is_regular(smallest: f64, largest: f64) -> bool {
    smallest > ROUNDINGS * f64::EPSILON * largest && largest.is_finite()
}

/// The singular values of the derivative by all three nodes, in no order; none where it has none.
pub(crate) fn all_singular_values(
    declaration: &Declaration<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    e: &[f64],
) -> Vec<f64> {
    let triple = Triple::new(declaration, h, leg, e);
    // q1 moves the node, both increments and so e twice
    let nodes = [[0.0, -1.0, 1.0], [1.0, 1.0, -2.0], [0.0, 0.0, 1.0]];
    triple
        .matrix(&nodes, false)
        .map_or_else(Vec::new, |matrix| matrix.decomposed().values)
}

/// A triple of nodes, and what its equations are measured by.
struct Triple<'a> {
    declaration: &'a Declaration<'a>,
    h: f64,
    leg: AnyLeg<'a, f64>,
    e: &'a [f64],
    /// The multipliers that are unknown or were solved for.
    multipliers: Vec<f64>,
    /// How far each coordinate moves.
    lengths: Vec<Option<f64>>,
}

/// The derivatives of all rows along one direction.
struct Column {
    /// By row.
    slopes: Vec<f64>,
    /// The largest of those that they are the sums of: by the middle node, the increment and the second difference. What is left of
    /// them where they cancel is rounding.
    parts: Vec<f64>,
    /// What is known of the length that they are along.
    length: Length,
}

/// What is known of the length of a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Length {
    /// It is that of a leg.
    Leg,
    /// Nothing moves. It is that of the other coordinates, by their masses, but for one factor.
    Mass,
    /// Nothing.
    Coordinate,
    /// Nothing; the direction is a multiplier.
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

    /// The smallest and the largest singular value of the derivative by a node that moves `[d, e]`, and by the multipliers;
    /// with what constraints ask of the first pair of nodes, or without.
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
        // the triple before: its second difference is the one that the step went on from
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
        // a multiplier is measured by its force
        matrix.normalize_columns();
        if matrix.is_finite() {
            matrix.decomposed().extremes()
        } else {
            [f64::NAN; 2]
        }
    }

    /// The derivative of all rows by nodes that move `[q, d, e]`, and by the multipliers, with rows and columns in their own
    /// units; `None` if it is not finite.
    ///
    /// The equations of a step ask constraints of positions and velocities of the last node and the last pair alone. Where it is the
    /// first node that is sought, the last pair is given and obeys them, and they bind the first pair.
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
        // what is known best comes first, and gives rows without terms their sizes
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

    /// Whether a multiplier is among the unknowns, and was not solved for.
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

    /// The derivatives of all rows where a coordinate of the middle node, the increment and the second difference moves, or a
    /// multiplier.
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

    /// The sizes of the rows: those of their terms, from the bounds of their rounding. By slopes it is the largest slope of
    /// a row, if that is larger: where a motion comes to rest in some coordinates the terms of their rows vanish, and the
    /// equations are as regular as before. Else it is the largest slope only of a row that does not round, or a part of it where hardly anything is
    /// left of the terms: rows of different sizes are no loss of regularity.
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
    /// Nothing moves yet.
    fn new(length: Length) -> Self {
        Self {
            slopes: Vec::new(),
            parts: Vec::new(),
            length,
        }
    }

    /// Adds the derivatives where one thing more moves.
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

    /// The largest part of a row's size.
    fn largest(&self, sizes: &[f64]) -> f64 {
        let entries = self.parts.iter().zip(sizes).filter(|(_, size)| **size > 0.0);
        entries.fold(0.0, |largest, (part, size)| largest.max(part / size))
    }
}

/// Gives directions whose length is not known one that changes some row by as much as its terms are: each its own, and those
/// that are known by their masses one in common. (A multiplier itself is no measure: it may vanish where the equations are as
/// regular as anywhere.)
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

/// Gives rows without a size that of their largest slope.
fn size_rows(sizes: &mut [f64], columns: &[Column], counts: impl Fn(Length) -> bool) {
    for (i, size) in sizes.iter_mut().enumerate().filter(|(_, size)| **size <= 0.0) {
        let columns = columns.iter().filter(|column| counts(column.length));
        *size = columns.fold(0.0, |largest, column| column.part(i).max(largest));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Small is not singular: what can be told from rounding grants a flow.
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
