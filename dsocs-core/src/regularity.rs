//! Whether the equations of a step determine the next node, and the node before.
//!
//! The paper's theorem on the discrete flow asks that the derivatives `D₃` and `D₁` of the equations, those by the last and
//! by the first node of a triple, be injective. With as many rows as coordinates they are square matrices, and how far they
//! are from singular is told by their smallest singular values.

use crate::declaration::Declaration;
use crate::dense::Matrix;
use crate::multipliers::of_step;
use crate::rounding;
use crate::system::{Leg, System};
use crate::tangent::Tangent;
use crate::tape::Number;

/// A singular value below this many units of rounding, relative to the largest, is zero for all that can be told.
const ROUNDINGS: f64 = 64.0;

/// A coordinate whose legs are shorter than this part of the longest stands still.
const STILL: f64 = 1e-3;

/// How regular the equations of a step are at a triple of nodes `(q0, q1, q2)`.
///
/// The rows are those of the declaration: kinematic constraints (without a factor that `branch = divide(w)` takes out) and
/// works of the constraint force; rows that were solved beforehand for a second difference count in that form, which
/// changes neither matrix's kernel. Where nodes or pairs of nodes are bound, or multipliers are unknown, `D₃` is the matrix of
/// the unknowns, multipliers among them, and `D₁` that of the step back in time from `(q2, q1)`. Singular values depend on units, so rows are taken relative to the size of their own
/// terms, and coordinates relative to the longer of their two legs (at least a thousandth of the longest of all): a value of 1 means that moving `q2` by the length of a
/// leg changes the rows by as much as their terms are large. Derivatives are exact, by dual numbers; only functions of the
/// user's whose arguments contain `q0` or `q2` are differentiated by differences of eighth order.
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
    /// The triple need not solve the equations.
    #[must_use]
    pub fn of<S: System<N>, const N: usize>(system: &S, h: f64, leg: &Leg<f64, N>, e: &[f64; N]) -> Self {
        Self::of_declaration(&Declaration::of(system), h, leg, e)
    }

    /// The same of a declaration.
    pub(crate) fn of_declaration<const N: usize>(
        declaration: &Declaration<'_, N>,
        h: f64,
        leg: &Leg<f64, N>,
        e: &[f64; N],
    ) -> Self {
        if declaration.lower() > 0 || declaration.has_multipliers() {
            // constraints on nodes and pairs bind the first node by themselves: what binds the last one, mirrored
            let back = Leg {
                t: leg.t,
                q: leg.q,
                d: core::array::from_fn(|i| -(leg.d[i] + e[i])),
            };
            let [forward, largest_forward] = of_unknowns(declaration, h, leg, e);
            let [backward, largest_backward] = of_unknowns(declaration, -h, &back, e);
            return Self {
                forward,
                backward,
                largest_forward,
                largest_backward,
            };
        }
        let bounds = rounding::stacked_bounds(declaration, h, leg, e);
        let lengths = lengths(leg, e);
        // q0 = q1 − d and q2 = q1 + d + e: moving q2 moves e, moving q0 moves d back and e on
        let [smallest, largest] = singular_values(declaration, h, leg, e, &lengths, &bounds, [0.0, 1.0]);
        let [backward, largest_backward] =
            singular_values(declaration, h, leg, e, &lengths, &bounds, [-1.0, 1.0]);
        Self {
            forward: smallest,
            backward,
            largest_forward: largest,
            largest_backward,
        }
    }

    /// Whether the equations determine the last node from the other two, here and nearby: the theorem's condition on `D₃`.
    #[must_use]
    pub fn grants_forward(&self) -> bool {
        is_regular(self.forward, self.largest_forward)
    }

    /// Whether they determine the first node from the other two: the theorem's condition on `D₁`.
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

/// Whether a smallest singular value is more than rounding.
fn is_regular(smallest: f64, largest: f64) -> bool {
    smallest > ROUNDINGS * f64::EPSILON * largest && largest.is_finite()
}

/// The longer of both legs by coordinate; for coordinates that stand still, a part of the longest of all, and 1 if none
/// moves.
pub(crate) fn lengths<const N: usize>(leg: &Leg<f64, N>, e: &[f64; N]) -> [f64; N] {
    let moved: [f64; N] = core::array::from_fn(|i| leg.d[i].abs().max((leg.d[i] + e[i]).abs()));
    let longest = moved.iter().fold(0.0_f64, |longest, &length| longest.max(length));
    moved.map(|length| {
        if longest > 0.0 {
            length.max(STILL * longest)
        } else {
            1.0
        }
    })
}

/// The smallest and the largest singular value of the derivative along `[δd, δe]` times each coordinate.
fn singular_values<const N: usize>(
    declaration: &Declaration<'_, N>,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
    lengths: &[f64; N],
    bounds: &[f64],
    [by_d, by_e]: [f64; 2],
) -> [f64; 2] {
    let columns = columns(declaration, h, leg, e, lengths, [0.0, by_d, by_e]);
    match scaled(&columns, &sizes(&columns, bounds)) {
        Some(matrix) => matrix.decomposed().extremes(),
        None => [f64::NAN; 2],
    }
}

/// The singular values of the derivative by all three nodes, in no order; none where it has none.
pub(crate) fn all_singular_values<const N: usize>(
    declaration: &Declaration<'_, N>,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
) -> Vec<f64> {
    let (bounds, lengths) = (rounding::stacked_bounds(declaration, h, leg, e), lengths(leg, e));
    // q1 moves the node, both increments and so e twice
    let nodes = [[0.0, -1.0, 1.0], [1.0, 1.0, -2.0], [0.0, 0.0, 1.0]];
    let mut columns: Vec<Vec<f64>> = nodes
        .iter()
        .flat_map(|&by| columns(declaration, h, leg, e, &lengths, by))
        .collect();
    let scales: Vec<f64> = (0..bounds.len())
        .map(|i| scale(bounds[i], columns.iter().filter_map(|column| column.get(i))))
        .collect();
    columns.extend(multiplier_columns(declaration, h, leg, e, &scales));
    scaled(&columns, &scales).map_or_else(Vec::new, |matrix| matrix.decomposed().values)
}

/// The derivatives of all rows along `[δq, δd, δe]` times each coordinate.
fn columns<const N: usize>(
    declaration: &Declaration<'_, N>,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
    lengths: &[f64; N],
    [by_q, by_d, by_e]: [f64; 3],
) -> Vec<Vec<f64>> {
    let multipliers = of_step(declaration, h, leg, e);
    let multipliers: Vec<_> = multipliers.iter().map(|&x| Tangent::new(x, 0.0)).collect();
    (0..N)
        .map(|j| {
            let along = |x: &[f64; N], part: f64| -> [Tangent; N] {
                core::array::from_fn(|i| Tangent::new(x[i], if i == j { part * lengths[j] } else { 0.0 }))
            };
            let leg = Leg {
                t: Tangent::new(leg.t, 0.0),
                q: along(&leg.q, by_q),
                d: along(&leg.d, by_d),
            };
            stacked(
                declaration,
                Tangent::new(h, 0.0),
                &leg,
                &along(e, by_e),
                &multipliers,
            )
            .into_iter()
            .map(Tangent::derivative)
            .collect()
        })
        .collect()
}

/// The derivatives of all rows by the multipliers that are unknown, each in its [`unit`].
fn multiplier_columns<const N: usize>(
    declaration: &Declaration<'_, N>,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
    scales: &[f64],
) -> Vec<Vec<f64>> {
    let multipliers = of_step(declaration, h, leg, e);
    let fixed = |x: &[f64; N]| x.map(|x| Tangent::new(x, 0.0));
    let constant_leg = Leg {
        t: Tangent::new(leg.t, 0.0),
        q: fixed(&leg.q),
        d: fixed(&leg.d),
    };
    (0..multipliers.len())
        .map(|j| {
            let moving: Vec<_> = multipliers
                .iter()
                .enumerate()
                .map(|(i, &x)| Tangent::new(x, if i == j { 1.0 } else { 0.0 }))
                .collect();
            let rows = stacked(
                declaration,
                Tangent::new(h, 0.0),
                &constant_leg,
                &fixed(e),
                &moving,
            );
            let slopes = || rows.iter().map(|row| row.derivative());
            let scaled = slopes().zip(scales).map(|(slope, &scale)| match slope {
                0.0 => 0.0,
                slope => slope / scale,
            });
            let unit = unit(scaled);
            slopes().map(|slope| unit * slope).collect()
        })
        .collect()
}

/// The unit of a multiplier, from its column in rows of the size of their terms: one that changes a row by as much as its terms
/// are. (The multiplier itself is no measure: it may vanish where the equations are as regular as anywhere.)
fn unit(column: impl Iterator<Item = f64>) -> f64 {
    let largest = column.fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    if largest > 0.0 && largest.is_finite() {
        largest.recip()
    } else {
        1.0
    }
}

/// The matrix of some columns with rows in some sizes, if it is finite.
fn scaled(columns: &[Vec<f64>], sizes: &[f64]) -> Option<Matrix> {
    let matrix = Matrix::from_fn(sizes.len(), columns.len(), |i, j| {
        let slope = columns[j].get(i).copied().unwrap_or(f64::NAN);
        if slope == 0.0 { 0.0 } else { slope / sizes[i] }
    });
    matrix.is_finite().then_some(matrix)
}

/// The sizes of the rows' terms, from the bounds of their rounding; of a row that does not round, its largest slope.
fn sizes(columns: &[Vec<f64>], bounds: &[f64]) -> Vec<f64> {
    let size = |(i, &bound): (usize, &f64)| {
        let terms = bound / f64::EPSILON;
        if terms > 0.0 {
            terms
        } else {
            scale(0.0, columns.iter().filter_map(|column| column.get(i)))
        }
    };
    bounds.iter().enumerate().map(size).collect()
}

/// The smallest and the largest singular value of the derivative by the unknowns.
fn of_unknowns<const N: usize>(
    declaration: &Declaration<'_, N>,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
) -> [f64; 2] {
    let z = declaration.unknown(e, &of_step(declaration, h, leg, e));
    let jacobian = declaration.jacobian(h, leg, &z);
    let mut bounds = vec![f64::NAN; z.len()];
    declaration.bounds(h, leg, &z, &mut bounds);
    let lengths = declaration.unknown(&lengths(leg, e), &[]);
    let rows: Vec<Vec<f64>> = jacobian
        .chunks(z.len().max(1))
        .map(|row| {
            let entries = row.iter().zip(&lengths);
            entries
                .map(|(slope, &length)| slope * if length > 0.0 { length } else { 1.0 })
                .collect()
        })
        .collect();
    let size = rows.len();
    let is_multiplier = |j: usize| lengths.get(j).is_none_or(|&length| length <= 0.0);
    let scales: Vec<f64> = rows
        .iter()
        .zip(&bounds)
        .map(|(row, &bound)| {
            let coordinates = row.iter().enumerate().filter(|(j, _)| !is_multiplier(*j));
            scale(bound, coordinates.map(|(_, slope)| slope))
        })
        .collect();
    let entry = |i: usize, j: usize| match rows[i][j] {
        0.0 => 0.0,
        slope => slope / scales[i],
    };
    let units: Vec<f64> = (0..size)
        .map(|j| {
            if is_multiplier(j) {
                unit((0..size).map(|i| entry(i, j)))
            } else {
                1.0
            }
        })
        .collect();
    let matrix = Matrix::from_fn(size, size, |i, j| units[j] * entry(i, j));
    if matrix.is_finite() {
        matrix.decomposed().extremes()
    } else {
        [f64::NAN; 2]
    }
}

/// The size of a row: that of its terms, from the bound of their rounding, or its largest slope, if that is larger. (Where a motion
/// comes to rest in some coordinates the terms of their rows vanish, and the equations are as regular as before.)
fn scale<'a>(bound: f64, slopes: impl Iterator<Item = &'a f64>) -> f64 {
    let terms = bound / f64::EPSILON;
    slopes.fold(terms, |largest, slope| slope.abs().max(largest))
}

/// All rows of a step: those left to be iterated, then `e − S(leg, z)` for every coordinate, which is zero at all times for
/// the coordinates of the unknowns and what was solved beforehand for the others. Multipliers have their own values.
pub(crate) fn stacked<T: Number, const N: usize>(
    declaration: &Declaration<'_, N>,
    h: T,
    leg: &Leg<T, N>,
    e: &[T; N],
    multipliers: &[T],
) -> Vec<T> {
    let z = declaration.unknown(e, multipliers);
    let solved = declaration.second_difference(h, leg, &z);
    let mut rows = declaration.rows(h, leg, &z);
    rows.extend(e.iter().zip(&solved).map(|(&e, &solved)| e - solved));
    rows
}
