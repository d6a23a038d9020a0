//! The rows of a step for all its coordinates, and those of the first pair of nodes.

use crate::number::point::AnyLeg;
use crate::solve::rotation;
use crate::tape::Number;
use crate::tape::declaration::Declaration;

/// The rows of holonomic constraints at the first node, and of nonholonomic ones on the first pair.
pub(crate) fn of_first_pair<T: Number>(declaration: &Declaration<'_>, h: T, leg: AnyLeg<'_, T>) -> Vec<T> {
    let holonomic = declaration.holonomic();
    let back: Vec<T> = leg.d.iter().map(|&d| -d).collect();
    let q = rotation::moved(&declaration.shape().rotations, leg.q, &back);
    let first = AnyLeg {
        t: leg.t - h,
        q: &q,
        d: leg.d,
    };
    let mut rows = declaration.pair(h, first);
    rows.truncate(holonomic);
    rows.extend(declaration.pair(h, leg).into_iter().skip(holonomic));
    rows
}

/// All rows of a step: those of the iteration, then `e − S(leg, z)` for every coordinate, which is
/// identically zero for coordinates that are unknowns, and the solved equation for the others. Multipliers
/// are independent arguments.
pub(crate) fn stacked<T: Number>(
    declaration: &Declaration<'_>,
    h: T,
    leg: AnyLeg<'_, T>,
    e: &[T],
    multipliers: &[T],
) -> Vec<T> {
    let z = declaration.unknown(e, multipliers);
    let solved = declaration.second_difference(h, leg, &z);
    let mut rows = declaration.rows(h, leg, &z);
    rows.extend(e.iter().zip(&solved).map(|(&e, &solved)| e - solved));
    rows
}
