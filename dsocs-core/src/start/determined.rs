//! Whether the equations determine the acceleration.

use super::{acceleration, underflow};
use crate::error::SetupError;
use crate::number::point::AnyPoint;
use crate::regularity::deficiency::{self, Deficiency};
use crate::regularity::dependence;
use crate::solve::elimination::Determinant;
use crate::solve::{Square, Vector};
use crate::tape::declaration::Declaration;

/// Shifts of a start, in roundings of time, position and velocity, at which its equations are compared.
const BESIDE: [[f64; 3]; 2] = [[4.0, 4.0, 4.0], [4.0, -3.0, 2.0]];

/// If the determinant changes by this part of itself under these shifts, it counts as zero.
const CHANGES: f64 = 0.5;

/// The acceleration and the multipliers at a place, with the determinant of their equations.
#[derive(Clone)]
pub(crate) struct Determined {
    /// The accelerations, then the multipliers.
    pub(crate) motion: Vector,
    /// The determinant.
    pub(crate) determinant: Determinant,
}

/// The determinant of the equations for the acceleration, at a point and its multipliers.
pub(crate) fn determinant_at(
    declaration: &Declaration<'_>,
    point: AnyPoint<'_, f64>,
    multipliers: &[f64],
) -> Determinant {
    let size = point.a.len() + multipliers.len();
    let (mut rows, mut jacobian) = (Vector::nan(size), Square::zero(size));
    declaration.linearize_continuous(point, multipliers, &mut rows, jacobian.entries_mut());
    jacobian.determinant()
}

/// The acceleration and the multipliers at a time, a position and a velocity, searched near an acceleration;
/// `None` if there are none.
pub(crate) fn determined(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    near: &[f64],
) -> Option<Determined> {
    let (a, multipliers) = acceleration(declaration, (t, q, v), Some(near)).ok()?;
    let size = a.len() + multipliers.len();
    let determinant = determinant_at(declaration, AnyPoint { t, q, v, a: &a }, &multipliers);
    (!determinant.value.is_nan()).then(|| Determined {
        motion: Vector::from_fn(size, |i| {
            a.get(i).copied().unwrap_or_else(|| multipliers[i - a.len()])
        }),
        determinant,
    })
}

/// [`determined`] by one update from a solution close by, which is enough for a determinant.
fn updated(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    near: &Vector,
) -> Option<Determined> {
    let n = q.len();
    if declaration.shape().jumps && declaration.sides() > 0 {
        // with bodies at rest the acceleration is found by a search, not by one update
        return determined(declaration, (t, q, v), &near[..n]);
    }
    let point = |a| AnyPoint { t, q, v, a };
    let mut rows = Vector::nan(near.len());
    let mut jacobian = Square::zero(near.len());
    let (a, multipliers) = near.split_at(n);
    declaration.linearize_continuous(point(a), multipliers, &mut rows, jacobian.entries_mut());
    let update = jacobian.solve(&rows)?;
    let motion = near.zip(&update, |near, update| near - update);
    let (a, multipliers) = motion.split_at(n);
    let determinant = determinant_at(declaration, point(a), multipliers);
    (!determinant.value.is_nan()).then_some(Determined { motion, determinant })
}

/// Checks that the equations are regular at a start: that no constraints repeat each other, and that the
/// determinant hardly changes a few roundings beside it. If it does, as with `theta = pi / 2` and a factor
/// `cos(theta)`, the acceleration is only rounding.
#[cold]
pub(crate) fn check(
    declaration: &Declaration<'_>,
    (t, q0, v0): (f64, &[f64], &[f64]),
    a: &[f64],
) -> Result<(), SetupError> {
    underflow::check(declaration, (t, q0, v0), None)?;
    let point = AnyPoint { t, q: q0, v: v0, a };
    let singular = |deficiency: Option<Deficiency>| SetupError::Singular {
        q0: q0.to_vec(),
        v0: v0.to_vec(),
        deficiency: deficiency.map(Box::new),
    };
    // rounding may change the determinant of redundant rows by less than itself
    if let Some(redundant) = dependence::to_rounding(declaration, (t, q0, v0), Some(a)) {
        return Err(singular(Some(redundant)));
    }
    let guess = Vector::resized(a, declaration.shape().motion);
    let Some(here) = updated(declaration, (t, q0, v0), &guess) else {
        return Ok(());
    };
    let is_other = |roundings: [f64; 3]| {
        let moved = |x: f64, i: usize| x * (1.0 + roundings[i % 3] * f64::EPSILON);
        let [q, v] = [q0, v0].map(|x| Vector::from_fn(x.len(), |i| moved(x[i], i)));
        let beside = updated(declaration, (moved(t, 2), &q, &v), &here.motion);
        beside.is_some_and(|beside| {
            let unit = here.determinant.exponent;
            let [here, beside] = [&here, &beside].map(|at| at.determinant.in_units_of(unit));
            (beside - here).abs() > CHANGES * here.abs()
        })
    };
    if !BESIDE.into_iter().any(is_other) {
        return Ok(());
    }
    Err(singular(deficiency::near_point(declaration, point)))
}
