//! Constraint forces, constraint by constraint.

use super::map::Triple;
use super::solvable::Declared;
use crate::multipliers::{multipliers, of_point};
use crate::system::Point;

/// The multipliers `λ_j` of the forms with which `Σ λ_j α_j` comes nearest to the constraint force `Q` at a triple, one for each constraint;
/// none where the declaration gives the virtual displacements by fields.
#[must_use]
pub fn constraint_multipliers<const N: usize>(
    system: &dyn Declared<N>,
    h: f64,
    triple: &Triple<N>,
) -> Vec<f64> {
    let declaration = system.declaration();
    multipliers(
        &declaration.force(h, &triple.leg, &triple.e),
        &declaration.forms(h, &triple.leg, &triple.e),
    )
}

/// The same of the continuous system at a point.
#[must_use]
pub fn continuous_multipliers<const N: usize>(system: &dyn Declared<N>, point: &Point<f64, N>) -> Vec<f64> {
    of_point(&system.declaration(), point)
}
