//! Constraint forces, constraint by constraint.

use super::map::Triple;
use crate::kernel::Kernel;
use crate::number::point::AnyPoint;
use crate::regularity::multipliers::{multipliers, of_point};
use crate::tape::declaration::Declaration;

/// The multipliers `λ_j` for which `Σ λ_j α_j` is nearest to the constraint force `Q` at a triple, one for each constraint. The result is
/// empty if the declaration gives the virtual displacements by fields.
#[must_use]
pub fn constraint_multipliers(system: &dyn Kernel, h: f64, triple: &Triple) -> Vec<f64> {
    let declaration = Declaration::of(system);
    multipliers(
        &declaration.force(h, triple.leg.any(), &triple.e),
        &declaration.forms(h, triple.leg.any(), &triple.e),
    )
}

/// The multipliers of the continuous system at a point, as in [`constraint_multipliers`].
#[must_use]
pub fn continuous_multipliers(system: &dyn Kernel, point: AnyPoint<'_, f64>) -> Vec<f64> {
    of_point(&Declaration::of(system), point)
}
