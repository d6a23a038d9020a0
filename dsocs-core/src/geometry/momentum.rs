//! Discrete momentum maps: Noether's theorem, and the momentum equation where constraint forces break it.
//!
//! A symmetry is given by its infinitesimal generator `ξ_Q`, a vector field on the configurations. If `L_d` is invariant ([`asymmetry`] is zero), the
//! momentum of a leg is the same at both of its nodes. From leg to leg it changes by the work of the constraint force and the external forces,
//! `J(q1, q2) − J(q0, q1) = h ⟨Q + f_d, ξ_Q(q1)⟩`. So it is conserved if these forces do no work along the symmetry. Constraint forces do no
//! work if the symmetry is a virtual displacement. (The discrete Noether theorem is in Marsden and West 2001, section 1.3.3; the momentum
//! equation with constraints in Cortés and Martínez 2001, section 6.)

use super::array::{minus, plus};
use super::external::external_forces;
use super::legendre::{legendre_minus, legendre_plus, momentum_plus};
use super::map::{DiscreteFlow, Triple};
use crate::number::inner_product;
use crate::number::point::AnyLeg;

/// A generator of a symmetry: maps a position to its vector there, with one component for each coordinate;
/// for a rotation a zero and three numbers in the frame of its body.
pub(super) type Generator<'g> = &'g dyn Fn(&[f64]) -> Vec<f64>;

/// The discrete momentum map `J(q0, q1) = h ⟨F⁺L_d(q0, q1), ξ_Q(q1)⟩` of a symmetry's generator, in units of `∂L/∂v` times
/// those of the generator.
#[must_use]
pub fn momentum_map(flow: &DiscreteFlow<'_>, leg: AnyLeg<'_, f64>, generator: Generator<'_>) -> f64 {
    inner_product(&momentum_plus(flow.system(), flow.h(), leg), &generator(leg.q))
}

/// The derivative of `L_d` along the symmetry, `D₁L_d · ξ_Q(q0) + D₂L_d · ξ_Q(q1)`, as an absolute value relative to its terms: zero up to rounding if
/// `L_d` is invariant.
#[must_use]
pub fn asymmetry(flow: &DiscreteFlow<'_>, leg: AnyLeg<'_, f64>, generator: Generator<'_>) -> f64 {
    let q0 = minus(leg.q, leg.d);
    let (minus, plus) = (
        legendre_minus(flow.system(), flow.h(), leg),
        legendre_plus(flow.system(), flow.h(), leg),
    );
    let (first, second) = (generator(&q0), generator(leg.q));
    let change = inner_product(&plus, &second) - inner_product(&minus, &first);
    let terms = size(&plus, &second) + size(&minus, &first);
    if change == 0.0 { 0.0 } else { change.abs() / terms }
}

/// The momentum equation at a trajectory: `J(q1, q2) − J(q0, q1) − h ⟨Q + f_d, ξ_Q(q1)⟩` with the external forces `f_d`, and the size of its terms.
///
/// If `L_d` is not invariant, the first value is not zero.
#[must_use]
pub fn momentum_equation(flow: &DiscreteFlow<'_>, triple: &Triple, generator: Generator<'_>) -> [f64; 2] {
    let (system, h) = (flow.system(), flow.h());
    let last = triple.last(h);
    let (first, last) = (triple.first(), last.any());
    let constraint = flow.declaration().force(h, first, &triple.e);
    let force = plus(&constraint, &external_forces(system, h, triple));
    let at = generator(first.q);
    let work = h * inner_product(&force, &at);
    let change = momentum_map(flow, last, generator) - momentum_map(flow, first, generator);
    let terms = |leg: AnyLeg<'_, f64>| size(&momentum_plus(system, h, leg), &generator(leg.q));
    let all = terms(first) + terms(last) + h.abs() * size(&force, &at);
    [change - work, all]
}

/// The sum of the absolute values of products.
pub(super) fn size(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| (x * y).abs()).sum()
}
