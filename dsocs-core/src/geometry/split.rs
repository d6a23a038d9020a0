//! Constraint forces, constraint by constraint.

use super::map::Triple;
use super::solvable::Declared;
use crate::multipliers::{multipliers, of_point};
use crate::system::Point;

/// The multipliers `λ_j` for which `Σ λ_j α_j` is nearest to the constraint force `Q` at a triple, one for each constraint. The result is
/// empty if the declaration gives the virtual displacements by fields.
#[must_use]
pub fn constraint_multipliers<const N: usize>(
    system: &dyn Declared<N>,
    h: f64,
    triple: &Triple<N>,
) -> Vec<f64> {
    let declaration = system.declaration();
    multipliers(
        &declaration.force(h, triple.leg.any(), &triple.e),
        &declaration.forms(h, triple.leg.any(), &triple.e),
    )
}

/// The multipliers of the continuous system at a point, as in [`constraint_multipliers`].
#[must_use]
pub fn continuous_multipliers<const N: usize>(system: &dyn Declared<N>, point: &Point<f64, N>) -> Vec<f64> {
    of_point(&system.declaration(), point.any())
}
