//! Multipliers: the parts of the constraint force that belong to the single constraints.

use super::map::Triple;
use crate::kernel::Kernel;
use crate::number::point::AnyPoint;
use crate::regularity::multipliers::{multipliers, of_point};
use crate::tape::declaration::Declaration;

/// The multipliers `λ_j` for which `Σ λ_j α_j` is nearest to the constraint force `Q` at a triple, one for each constraint. The result is
/// empty if the declaration gives the virtual displacements by fields.
#[must_use]
pub fn constraint_multipliers(system: &dyn Kernel, h: f64, triple: &Triple) -> Vec<f64> {
    let force = Declaration::of(system).force(h, triple.leg.any(), &triple.e);
    multipliers_of(system, h, triple, &force)
}

/// The best-fitting multipliers of a given force with the forms at a triple of nodes;
/// [`constraint_multipliers`] takes the constraint force there.
#[must_use]
pub fn multipliers_of(system: &dyn Kernel, h: f64, triple: &Triple, force: &[f64]) -> Vec<f64> {
    multipliers(
        force,
        &Declaration::of(system).forms(h, triple.leg.any(), &triple.e),
    )
}

/// The multipliers of the continuous system at a point, as in [`constraint_multipliers`].
#[must_use]
pub fn continuous_multipliers(system: &dyn Kernel, point: AnyPoint<'_, f64>) -> Vec<f64> {
    of_point(&Declaration::of(system), point)
}
