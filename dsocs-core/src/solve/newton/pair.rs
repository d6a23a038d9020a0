//! Pairs of roots that lie close together: detection, and the second root.
//!
//! Two simple roots side by side lie on two sides of a fold, where the Jacobian is singular and beyond which it has the opposite orientation.
//! The change of the Jacobian on the way from the guess to the root gives the distance of the fold. The other root lies as far beyond it
//! (exactly, if the rows are of second degree). A root is searched there.
//!
//! The other root is found by deflation: the rows divided by the distance from the known root have only the
//! other root (K. M. Brown, W. B. Gearhart, *Deflation techniques for the calculation of further solutions of
//! a nonlinear system*, 1971). Newton's update for them is that of the rows, made longer or shorter.

use super::{Equations, relative};
use crate::solve::{Square, Vector};

/// Largest number of evaluations of the deflated rows.
const DEFLATED: u32 = 60;

/// Largest number of evaluations of the rows to polish the other root.
const POLISHED: u32 = 12;

/// A deflated update this small relative to the distance of the roots has converged.
const ARRIVED: f64 = 1e-3;

/// Rows within this many bounds of their rounding errors are zero.
const ROUNDINGS: f64 = 8.0;

/// Two roots are distinct if their distance exceeds this part of the bound of their rounding errors; the
/// bound itself is seldom reached.
const DISTINCT: f64 = 1.0 / 16.0;

/// The other root of a pair that Newton's iteration comes near to on its way from `start` to `root`.
#[cold]
pub(crate) fn nearby(
    equations: &dyn Equations,
    start: &Vector,
    root: &Vector,
    size: &Vector,
) -> Option<Vector> {
    let way = start.zip(root, |start, root| start - root);
    let sizes = root.zip(size, |root, size| root.abs().max(size));
    let at_root = equations.linearize(root).jacobian;
    let orientation = |z: &Vector| orientation(&at_root, &equations.linearize(z).jacobian, &way, &sizes);
    let fold = 1.0 / (1.0 - orientation(start)?);
    let other = root.zip(&way, |root, way| root + 2.0 * fold * way);
    if !other.iter().all(|z| z.is_finite()) || orientation(&other)? >= 0.0 {
        return None;
    }
    other_root(equations, &other, root, size)
}

/// The component along a direction of `unit⁻¹ · jacobian`; for one unknown, the quotient of the two.
pub(crate) fn orientation(
    unit: &Square,
    jacobian: &Square,
    direction: &Vector,
    sizes: &Vector,
) -> Option<f64> {
    let moved = unit.solve(&jacobian.times(direction))?;
    Some(scalar_product(direction, &moved, sizes) / scalar_product(direction, direction, sizes))
}

/// A root other than `root`, from a guess not too far from it.
#[cold]
pub(crate) fn other_root(
    equations: &dyn Equations,
    guess: &Vector,
    root: &Vector,
    size: &Vector,
) -> Option<Vector> {
    let mut z = guess.clone();
    let mut arrived = false;
    for _ in 0..DEFLATED {
        let update = equations.linearize(&z).update()?;
        let apart = z.zip(root, |z, root| z - root);
        // in units of the distance itself, so that the sizes of the unknowns do not matter
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
fn is_other(equations: &dyn Equations, z: &Vector, root: &Vector, size: &Vector) -> bool {
    let bounds = equations.rounding(z);
    let at = equations.linearize(z);
    let within = at.rows.iter().zip(&bounds);
    if !within
        .into_iter()
        .all(|(row, bound)| row.abs() <= ROUNDINGS * bound)
    {
        return false;
    }
    let Some(error) = at.jacobian.solve(&bounds) else {
        return false;
    };
    let apart = z.zip(root, |z, root| z - root);
    let nearby = z.zip(&apart, |z, apart| z + 1e-9 * apart);
    DISTINCT * relative(&error, root, size) < relative(&apart, root, size)
        && equations.is_declared(z, &nearby)
}

/// `Σ xᵢ yᵢ / uᵢ²`; unknowns without a unit do not count.
pub(crate) fn scalar_product(x: &Vector, y: &Vector, units: &Vector) -> f64 {
    let terms = x.iter().zip(y).zip(units);
    terms
        .filter(|(_, unit)| **unit != 0.0)
        .map(|((x, y), unit)| (x / unit) * (y / unit))
        .sum()
}
