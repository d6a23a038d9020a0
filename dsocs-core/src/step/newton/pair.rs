//! Roots that lie close together: noticing that there are two, and finding the other one.
//!
//! Two simple roots side by side lie on two sides of a fold, where the Jacobian is singular and beyond which it has changed
//! its orientation. Along the way from the guess to the root the Jacobian's change says how far away the fold is, and the
//! other root is as far away again (exactly, where the rows are of second degree). What is there is then looked at.
//!
//! The other root itself is found by deflation: the rows over the distance from the known root have it for their root, but
//! no longer the known one (K. M. Brown, W. B. Gearhart, *Deflation techniques for the calculation of further solutions of
//! a nonlinear system*, 1971). Newton's update for them is that of the rows, made longer or shorter.

use super::{AnyEquations, relative};
use crate::step::unknown::Unknown;

/// How often the deflated rows are evaluated.
const DEFLATED: u32 = 60;

/// How often the rows are evaluated to make the other root accurate.
const POLISHED: u32 = 12;

/// A deflated update this small relative to the distance of the roots has arrived.
const ARRIVED: f64 = 1e-3;

/// Rows within so many bounds of their rounding errors are zero.
const ROUNDINGS: f64 = 8.0;

/// Roots are two if they are farther apart than this part of the bound of their rounding errors, which is seldom reached.
const DISTINCT: f64 = 1.0 / 16.0;

/// The other root of a pair that Newton's iteration on its way from `start` to `root` comes near to.
#[cold]
pub(crate) fn nearby<Z: Unknown<f64>>(
    equations: &AnyEquations<'_, Z>,
    start: &Z,
    root: &Z,
    size: &Z,
) -> Option<Z> {
    let way = start.zip(root, |start, root| start - root);
    let sizes = root.zip(size, |root, size| root.abs().max(size));
    let at_root = equations.linearize(root).jacobian;
    let orientation = |z: &Z| orientation::<Z>(&at_root, &equations.linearize(z).jacobian, &way, &sizes);
    let fold = 1.0 / (1.0 - orientation(start)?);
    let other = root.zip(&way, |root, way| root + 2.0 * fold * way);
    if !other.as_ref().iter().all(|z| z.is_finite()) || orientation(&other)? >= 0.0 {
        return None;
    }
    other_root(equations, &other, root, size)
}

/// A Jacobian along a direction, in units of another one: with one unknown, the quotient of the two.
pub(crate) fn orientation<Z: Unknown<f64>>(
    unit: &Z::Square,
    jacobian: &Z::Square,
    direction: &Z,
    sizes: &Z,
) -> Option<f64> {
    let moved = Z::solve(unit, &product::<Z>(jacobian, direction))?;
    Some(scalar_product(direction, &moved, sizes) / scalar_product(direction, direction, sizes))
}

/// A root other than `root`, from a guess that is not too far from it.
#[cold]
pub(crate) fn other_root<Z: Unknown<f64>>(
    equations: &AnyEquations<'_, Z>,
    guess: &Z,
    root: &Z,
    size: &Z,
) -> Option<Z> {
    let mut z = *guess;
    let mut arrived = false;
    for _ in 0..DEFLATED {
        let update = equations.linearize(&z).update()?;
        let apart = z.zip(root, |z, root| z - root);
        // in units of the distance itself, so that no size of unknowns comes in
        let units = apart.zip(&update, |apart, update| apart.abs().max(update.abs()));
        let square = scalar_product(&apart, &apart, &units);
        let along = scalar_product(&apart, &update, &units);
        let stretch = 1.0 / (1.0 + along / square);
        if !(stretch.is_finite() && square > 0.0) {
            return None;
        }
        let update = update.zip(&update, |update, _| stretch * update);
        z = z.zip(&update, |z, update| z + update);
        if relative(&update, root, size) <= ARRIVED * relative(&apart, root, size) {
            arrived = true;
            break;
        }
    }
    if !arrived {
        return None;
    }
    let mut before = f64::INFINITY;
    for _ in 0..POLISHED {
        let update = equations.linearize(&z).update()?;
        let apart = z.zip(root, |z, root| z - root);
        let now = scalar_product(&update, &update, &apart);
        if now >= 0.25 * before || now == 0.0 {
            break;
        }
        before = now;
        z = z.zip(&update, |z, update| z + update);
    }
    is_other(equations, &z, root, size).then_some(z)
}

/// Whether a point is a root of the declared rows and differs from `root` by more than the bound of its rounding error.
fn is_other<Z: Unknown<f64>>(equations: &AnyEquations<'_, Z>, z: &Z, root: &Z, size: &Z) -> bool {
    let bounds = equations.rounding(z);
    let at = equations.linearize(z);
    let within = at.rows.as_ref().iter().zip(bounds.as_ref());
    if !within
        .into_iter()
        .all(|(row, bound)| row.abs() <= ROUNDINGS * bound)
    {
        return false;
    }
    let Some(error) = Z::solve(&at.jacobian, &bounds) else {
        return false;
    };
    let apart = z.zip(root, |z, root| z - root);
    let nearby = z.zip(&apart, |z, apart| z + 1e-9 * apart);
    DISTINCT * relative(&error, root, size) < relative(&apart, root, size)
        && equations.is_declared(z, &nearby)
}

/// `matrix · x`.
fn product<Z: Unknown<f64>>(matrix: &Z::Square, x: &Z) -> Z {
    let mut product = Z::zero();
    for (to, row) in product.as_mut().iter_mut().zip(matrix.as_ref()) {
        *to = row
            .as_ref()
            .iter()
            .zip(x.as_ref())
            .map(|(entry, x)| entry * x)
            .sum();
    }
    product
}

/// `Σ xᵢ yᵢ / uᵢ²`; unknowns without a unit do not count.
pub(crate) fn scalar_product<Z: Unknown<f64>>(x: &Z, y: &Z, units: &Z) -> f64 {
    let terms = x.as_ref().iter().zip(y.as_ref()).zip(units.as_ref());
    terms
        .filter(|(_, unit)| **unit != 0.0)
        .map(|((x, y), unit)| (x / unit) * (y / unit))
        .sum()
}
