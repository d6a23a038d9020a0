//! External forces, and the power of external and constraint forces.

use super::array::{fixed, plus};
use super::map::Triple;
use crate::kernel::Kernel;
use crate::number::inner_product;
use crate::number::point::AnyPoint;
use crate::number::tangent::Tangent;
use crate::regularity::rounding;
use crate::run::AnyNode;
use crate::solve::Vector;
use crate::start::place::Place;
use crate::step::jumps;
use crate::tape::declaration::Declaration;

/// The discrete external force at the second of three nodes, `f⁻_d(q1, q2) + f⁺_d(q0, q1)`, in units of `L`
/// per unit of the coordinate; zero if no external forces are declared. (Discrete Lagrange-d'Alembert
/// principle: Marsden and West 2001, section 3.2.)
#[must_use]
pub fn external_forces(system: &dyn Kernel, h: f64, triple: &Triple) -> Vec<f64> {
    Declaration::of(system).external_force(h, triple.leg.any(), &triple.e)
}

/// A bound of the rounding errors of the constraint force plus external forces at the second of three nodes,
/// by coordinate. It includes the errors of all terms, much of which may cancel.
#[must_use]
pub fn force_roundings(system: &dyn Kernel, h: f64, triple: &Triple) -> Vec<f64> {
    rounding::force_bounds(&Declaration::of(system), h, triple.leg.any(), &triple.e)
}

/// The power at a point of the continuous system's motion, `dE/dt = ⟨Q + f, v⟩ − ∂L/∂t`, with the constraint force `Q` and the external
/// forces `f`, in units of `L` per unit of time.
#[must_use]
pub fn power(system: &dyn Kernel, point: AnyPoint<'_, f64>) -> f64 {
    let declaration = Declaration::of(system);
    let constraint = declaration.continuous_force(point);
    power_with(&declaration, (point.t, point.q, point.v), &constraint)
}

/// [`power`] at a time, a position and a velocity with a known constraint force, as at a node of a run.
#[must_use]
pub fn power_with(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    constraint: &[f64],
) -> f64 {
    let mut external = vec![0.0; constraint.len()];
    declaration.external_forces(t, q, v, &mut external);
    of_force(declaration, (t, q, v), &plus(constraint, &external))
}

/// The work on the way from one node to the next: the integral of [`power_with`], by Simpson's rule on sixteen parts, on the cubic polynomial with the
/// positions and velocities of both and with a constraint force that changes linearly. Of forces that depend on positions alone it is the work between
/// the positions of the nodes, whatever the step has made of it on the way.
#[must_use]
pub fn work_between(declaration: &Declaration<'_>, [from, to]: [&AnyNode<'_>; 2]) -> f64 {
    let ends = [from.point(), to.point()];
    let powers: Vec<f64> = jumps::places()
        .map(|part| {
            let Place { t, q, v, .. } = Place::on_hermite(&declaration.shape().rotations, ends, part);
            let force = Vector::of(from.force).zip(to.force, |from, to| from + part * (to - from));
            power_with(declaration, (t, &q, &v), &force)
        })
        .collect();
    let parts = powers.windows(3).step_by(2);
    let count = 2 * parts.len();
    let sum: f64 = parts.map(|part| part[0] + 4.0 * part[1] + part[2]).sum();
    sum * (to.t - from.t) / (3 * count) as f64
}

/// The power at the second of three nodes, as in [`power`] but with the discrete forces, at the point `φ_{D_K}⁻¹`. Its sum over the
/// nodes, times `h`, is the change of the energy at the nodes, up to the discretization error.
#[must_use]
pub fn discrete_power(system: &dyn Kernel, h: f64, triple: &Triple) -> f64 {
    let declaration = Declaration::of(system);
    let leg = triple.leg.any();
    let constraint = declaration.force(h, leg, &triple.e);
    let external = declaration.external_force(h, leg, &triple.e);
    let point = declaration.point(h, leg, &triple.e);
    let AnyPoint { t, q, v, .. } = point.any();
    of_force(&declaration, (t, q, v), &plus(&constraint, &external))
}

/// `⟨force, v⟩ − ∂L/∂t` at a point.
fn of_force(declaration: &Declaration<'_>, (t, q, v): (f64, &[f64], &[f64]), force: &[f64]) -> f64 {
    let explicit = declaration.lagrangian(Tangent::new(t, 1.0), &fixed(q), &fixed(v));
    inner_product(force, v) - explicit.derivative()
}
