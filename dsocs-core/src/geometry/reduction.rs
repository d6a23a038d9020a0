//! Coordinates whose positions occur in no equation, and the momentum equation along a symmetry for systems
//! with rotations.
//!
//! If neither `L` nor the constraints nor the forces depend on the position of a coordinate, only on its
//! velocity, the step is that of the reduced system on the quotient by the group: the coordinate's increment
//! is solved for, and its position follows from increments alone, `g_{k+1} = g_k τ(d_k)` (reconstruction).
//! (J. E. Marsden, S. Pekarsky, S. Shkoller, *Discrete Euler–Poincaré and Lie–Poisson equations*,
//! Nonlinearity 12, 1999.)
//!
//! Along a field `ξ` of the symmetry the momentum changes by the work of the constraint and external forces,
//! `ΔJ = h ⟨Q, ξ⟩ + ⟨f⁻_d, ξ⟩ + ⟨f⁺_d, ξ⟩`: the nonholonomic momentum equation (A. M. Bloch, P. S.
//! Krishnaprasad, J. E. Marsden, R. M. Murray, *Nonholonomic mechanical systems with symmetry*, Arch.
//! Rational Mech. Anal. 136, 1996).

use super::legendre::legendre_plus;
use super::momentum::{Generator, size};
use crate::kernel::Kernel;
use crate::number::inner_product;
use crate::number::point::AnyLeg;
use crate::solve::rotation::SLOTS;
use crate::tape::declaration::Declaration;
use crate::tape::{Input, Leaf, Part, Segment};

/// The segments with the equations of a step, of the continuous motion and of a start.
const EQUATIONS: [Segment; 12] = [
    Segment::Residual,
    Segment::SecondDifference,
    Segment::Declared,
    Segment::Forms,
    Segment::Fields,
    Segment::Pair,
    Segment::Arriving,
    Segment::Continuous,
    Segment::ContinuousForce,
    Segment::ContinuousForms,
    Segment::Phase,
    Segment::DiscreteExternalForces,
];

/// The coordinates whose positions occur in no equation, by their places; for a rotation the first of its
/// four. The step is that of the reduced system.
#[must_use]
pub fn reduced(system: &dyn Kernel) -> Vec<usize> {
    let declaration = Declaration::of(system);
    let tape = declaration.source().tape();
    let wanted = EQUATIONS.map(|segment| (segment, Part::All));
    let read: Vec<Leaf> = (tape.differential(&wanted, &|_| false).inputs())
        .filter_map(|input| match input {
            Input::Leaf(leaf) => Some(leaf),
            Input::Constant(_) => None,
        })
        .collect();
    let shape = system.shape();
    let is_read = |i: usize| read.contains(&Leaf::N(i)) || read.contains(&Leaf::Q(i));
    (0..shape.dimension())
        .filter(|i| match shape.rotation_of(*i) {
            Some(first) => first == *i && !(first..first + SLOTS).any(is_read),
            None => !is_read(*i),
        })
        .collect()
}

/// The momentum `h (D₂L_d + f⁺_d)` of a leg of the step `h` at its second node, by coordinate; for a rotation
/// a zero and three numbers in the frame of its body.
#[must_use]
pub fn arriving_momentum(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    arriving(system, h, leg)
        .iter()
        .map(|momentum| h * momentum)
        .collect()
}

/// The momentum `h ⟨D₂L_d + f⁺_d, ξ⟩` of a leg of the step `h` at its second node, along a field there.
#[must_use]
pub fn momentum_along(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>, generator: Generator<'_>) -> f64 {
    inner_product(&arriving_momentum(system, h, leg), &generator(leg.q))
}

/// `D₂L_d + f⁺_d` of the declared map. For the paper's map, a run uses the trapezoidal one at a node where an
/// input changes; the two momenta differ if the momentum depends on the attitude.
fn arriving(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    let [_, external] = Declaration::of(system).discrete_external_forces(h, leg);
    let momentum = legendre_plus(system, h, leg);
    momentum.iter().zip(external).map(|(p, f)| p + f).collect()
}

/// The momentum equation at two consecutive legs `(q0, q1)` and `(q1, q2)` of a motion with the second
/// difference `e`: the change of the momentum minus the work of constraint forces and external forces, that
/// work, and the size of all terms. The first is zero up to rounding if `L_d` is invariant.
#[must_use]
pub fn momentum_balance(
    system: &dyn Kernel,
    h: f64,
    [first, last]: [AnyLeg<'_, f64>; 2],
    e: &[f64],
    generator: Generator<'_>,
) -> [f64; 3] {
    let declaration = Declaration::of(system);
    let (here, there) = (generator(first.q), generator(last.q));
    let constraint = declaration.force(h, first, e);
    let [leaving, arriving] = declaration.discrete_external_forces(h, last);
    let momenta = [first, last].map(|leg| self::arriving(system, h, leg));
    let work = h
        * (inner_product(&constraint, &here)
            + inner_product(&leaving, &here)
            + inner_product(&arriving, &there));
    let change = h * (inner_product(&momenta[1], &there) - inner_product(&momenta[0], &here));
    let terms = size(&momenta[1], &there) + size(&momenta[0], &here) + size(&constraint, &here);
    [change - work, work, h.abs() * terms]
}
