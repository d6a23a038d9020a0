//! The jerk for a position, a velocity and an acceleration.

use super::{Equations, NO_FORM};
use crate::error::SetupError;
use crate::number::point::map;
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::deficiency::{self, Deficiency};
use crate::regularity::multipliers;
use crate::solve::dense::Matrix;
use crate::solve::{Square, Vector};
use crate::start::Determined;
use crate::tape::declaration::Declaration;

/// Largest number of iterations for a jerk.
const MAX_ITERATIONS: usize = 50;

/// Updates below this part of the largest unknown are rounding.
const SETTLED: f64 = 64.0 * f64::EPSILON;

/// The derivatives of rows by the unknowns, one column each.
type Columns = Vec<Vec<Tangent>>;

/// The jerk at a time, a position, a velocity and an acceleration, searched near another one; `None` if there
/// is none.
pub(crate) fn jerk(
    declaration: &Declaration<'_>,
    t: f64,
    [q, v, a]: [&[f64]; 3],
    near: &[f64],
) -> Option<Vec<f64>> {
    Equations::at(declaration, t, q, v).jerk(a, near).ok()
}

/// The jerk and the rates of the multipliers at a time, a position, a velocity and an acceleration, searched
/// near a jerk, with the determinant of their equations; `None` if there are none.
pub(crate) fn determined(
    declaration: &Declaration<'_>,
    t: f64,
    [q, v, a]: [&[f64]; 3],
    near: &[f64],
) -> Option<Determined> {
    let equations = Equations::at(declaration, t, q, v);
    let multipliers = equations.acting(a);
    let motion = equations.with_rates(a, &multipliers, near).ok()?;
    let (_, columns) = equations.linearized(a, &multipliers, &motion);
    let mut jacobian = Square::zero(motion.len());
    for (place, entry) in jacobian.entries_mut().iter_mut().enumerate() {
        let (i, j) = (place / motion.len(), place % motion.len());
        *entry = columns[j].get(i)?.derivative();
    }
    let determinant = jacobian.determinant();
    (!determinant.value.is_nan()).then(|| Determined {
        motion: Vector::of(&motion),
        determinant,
    })
}

/// The deficiency or near-deficiency of the equations at a jerk and rates of multipliers.
#[cold]
pub(crate) fn deficiency(
    declaration: &Declaration<'_>,
    t: f64,
    [q, v, a]: [&[f64]; 3],
    found: &[f64],
) -> Option<Deficiency> {
    let equations = Equations::at(declaration, t, q, v);
    let (_, columns) = equations.linearized(a, &equations.acting(a), found);
    deficiency::near_columns(declaration, &columns, equations.point(a))
}

/// The nearest acceleration that obeys the equations without jerks, at a time, a position and a velocity;
/// `None` if there is none.
pub(crate) fn lower_acceleration(
    declaration: &Declaration<'_>,
    t: f64,
    [q, v, a]: [&[f64]; 3],
) -> Option<Vec<f64>> {
    Equations::at(declaration, t, q, v).projected(a).ok()
}

impl Equations<'_> {
    /// The unknown multipliers for a given acceleration.
    fn acting(&self, a: &[f64]) -> Vec<f64> {
        if self.declaration.has_multipliers() {
            multipliers::of_point(self.declaration, self.point(a))
        } else {
            Vec::new()
        }
    }

    /// The jerk, from the constraints of third order and the derivatives of the other equations.
    pub(super) fn jerk(&self, a: &[f64], near: &[f64]) -> Result<Vec<f64>, SetupError> {
        let multipliers = self.acting(a);
        let found = self.with_rates(a, &multipliers, near);
        let mut x = found.map_err(|columns| {
            let deficiency = deficiency::of_columns(self.declaration, &columns, self.point(a));
            SetupError::Jerk {
                deficiency: deficiency.map(Box::new),
            }
        })?;
        x.truncate(a.len());
        Ok(x)
    }

    /// The equations at jerks and rates of multipliers `x`.
    ///
    /// If multipliers are unknown, their values follow from the acceleration, and their rates are unknowns
    /// beside the jerk.
    fn rows(&self, a: &[f64], multipliers: &[f64], x: &[f64], moved: Option<usize>) -> Vec<Tangent> {
        let n = a.len();
        let point = self.going_on(a, &x[..n]);
        let rates = x[n..].iter().zip(multipliers);
        let rates: Vec<_> = rates.map(|(&rate, &known)| Tangent::new(known, rate)).collect();
        let differentiated =
            self.declaration
                .continuous_of_third(point.any(), &vec![Tangent::splat(0.0); n], &rates);
        let fixed: Vec<Tangent> = (0..n)
            .map(|i| Tangent::new(x[i], if moved == Some(i) { 1.0 } else { 0.0 }))
            .collect();
        let own =
            self.declaration
                .continuous_of_third(self.moving(&map(a, Tangent::splat)).any(), &fixed, &[]);
        let rows = differentiated.iter().zip(own).enumerate();
        rows.map(|(place, (row, own))| {
            if self.third.contains(&place) {
                own
            } else {
                Tangent::splat(row.derivative())
            }
        })
        .collect()
    }

    /// The values of these equations, and their derivatives.
    fn linearized(&self, a: &[f64], multipliers: &[f64], x: &[f64]) -> (Vec<f64>, Columns) {
        let rows = self.rows(a, multipliers, x, None);
        let rows: Vec<f64> = rows.into_iter().map(Tangent::value).collect();
        let columns = (0..x.len()).map(|k| {
            // the equations are affine
            let mut beside = x.to_vec();
            beside[k] += 1.0;
            let slopes = self.rows(a, multipliers, x, Some(k));
            let beside = self.rows(a, multipliers, &beside, None);
            let entries = slopes.into_iter().zip(beside).zip(&rows).enumerate();
            entries
                .map(|(place, ((slope, beside), row))| {
                    if self.third.contains(&place) {
                        slope
                    } else {
                        Tangent::new(*row, beside.value() - row)
                    }
                })
                .collect()
        });
        let columns = columns.collect();
        (rows, columns)
    }

    /// The jerk and the rates of the multipliers; if there are none, the derivatives of the last rows.
    fn with_rates(&self, a: &[f64], multipliers: &[f64], near: &[f64]) -> Result<Vec<f64>, Columns> {
        let size = a.len() + multipliers.len();
        let mut x = near.to_vec();
        x.resize(size, 0.0);
        let mut columns = Vec::new();
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let rows;
            (rows, columns) = self.linearized(a, multipliers, &x);
            if rows.len() != size || rows.iter().any(|row| !row.is_finite()) {
                break;
            }
            let Some(update) = solved(&columns, &rows) else {
                return Err(columns);
            };
            let mut step = 0.0_f64;
            for (x, update) in x.iter_mut().zip(&update) {
                *x -= update;
            }
            let largest = x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            for update in &update {
                step = step.max(update.abs());
            }
            if step <= SETTLED * largest || step == 0.0 || (step >= last && step <= 1e-9 * largest) {
                return Ok(x);
            }
            last = step;
        }
        Err(columns)
    }
}

/// The solution of linear equations, given by their columns; `None` if they are singular.
fn solved(columns: &[Vec<Tangent>], right: &[f64]) -> Option<Vec<f64>> {
    let size = right.len();
    let matrix = Matrix::from_fn(size, size, |i, j| columns[j][i].derivative());
    let mut right = right.to_vec();
    let (singular, lengths) = matrix.equilibrated(&mut right)?;
    let [smallest, largest] = singular.extremes();
    if smallest <= NO_FORM * largest || smallest.is_nan() {
        return None;
    }
    let solution = singular.solve(&right, 0.0);
    Some(
        solution
            .iter()
            .zip(lengths)
            .map(|(x, length)| x / length)
            .collect(),
    )
}
