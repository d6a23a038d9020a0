//! Discrete Legendre transforms and the forms that they define.

use super::array::{along, moving_twice, times, zero};
use super::form::{Displacement, TwoForm};
use super::nodes::{moves, moving_nodes};
use super::units;
use crate::kernel::Kernel;
use crate::number::inner_product;
use crate::number::point::{AnyLeg, OwnedLeg};
use crate::number::scalar::Scalar;
use crate::number::tangent::{Tangent, Tangent2};
use crate::tape::declaration::Declaration;

/// The derivatives `parts[0] D₁L_d + parts[1] D₂L_d` by coordinate; zero for the first slot of a rotation.
fn derivative(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, parts: [f64; 2]) -> Vec<f64> {
    let (units, rotations) = (units(leg), &declaration.shape().rotations);
    let slope = |(j, &unit): (usize, &f64)| {
        if !moves(rotations, j) {
            return 0.0;
        }
        let leg = moving_nodes(rotations, leg, j, parts.map(|part| part * unit));
        let value = declaration.discrete_lagrangian(Tangent::splat(h), leg.any());
        value.derivative() / unit
    };
    units.iter().enumerate().map(slope).collect()
}

/// The discrete Lagrangian `L_d(q0, q1) = L(φ_{L_d}⁻¹(q0, q1))` on a leg (paper, section 3: it is not multiplied by `h`).
#[must_use]
pub fn discrete_lagrangian(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> f64 {
    Declaration::of(system).discrete_lagrangian(h, leg)
}

/// The discrete Legendre transform `F⁻L_d(q0, q1) = −D₁L_d(q0, q1)` at `q0`, in units of `L` per unit of the
/// coordinate (paper, section 3: `L_d` is not multiplied by `h`). For a rotation, by turns in the frame of
/// its body at `q0`, behind a zero.
#[must_use]
pub fn legendre_minus(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    derivative(&Declaration::of(system), h, leg, [-1.0, 0.0])
}

/// The discrete Legendre transform `F⁺L_d(q0, q1) = D₂L_d(q0, q1)` at `q1`, in units of `L` per unit of the
/// coordinate. For a rotation, by turns in the frame of its body at `q1`, behind a zero.
#[must_use]
pub fn legendre_plus(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    derivative(&Declaration::of(system), h, leg, [0.0, 1.0])
}

/// The discrete momentum at the first node of a leg, `h F⁻L_d`, in units of `∂L/∂v`.
#[must_use]
pub fn momentum_minus(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    times(h, &legendre_minus(system, h, leg))
}

/// The discrete momentum at the second node of a leg, `h F⁺L_d`, in units of `∂L/∂v`.
#[must_use]
pub fn momentum_plus(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    times(h, &legendre_plus(system, h, leg))
}

/// The discrete one-form `θ⁻(δq0, δq1) = F⁻L_d(q0, q1) · δq0` (paper, section 6).
#[must_use]
pub fn theta_minus(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>, displacement: &Displacement) -> f64 {
    inner_product(&legendre_minus(system, h, leg), &displacement.first)
}

/// The discrete one-form `θ⁺(δq0, δq1) = F⁺L_d(q0, q1) · δq1` (paper, section 6).
#[must_use]
pub fn theta_plus(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>, displacement: &Displacement) -> f64 {
    inner_product(&legendre_plus(system, h, leg), &displacement.second)
}

/// `D₁D₂L_d`: row `i` by the first node's coordinate `i`, column `j` by the second's coordinate `j`.
pub(super) fn mixed(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Vec<Vec<f64>> {
    let units = units(leg);
    let n = units.len();
    let zero = zero(n);
    let entry = |i: usize, j: usize| {
        let second = along(n, j, units[j]);
        let moved = OwnedLeg {
            t: Tangent2::splat(leg.t),
            q: moving_twice(leg.q, [&zero, &second]),
            d: moving_twice(leg.d, [&along(n, i, -units[i]), &second]),
        };
        let value = declaration.discrete_lagrangian(Tangent2::splat(h), moved.any());
        value.mixed() / (units[i] * units[j])
    };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

/// The discrete Lagrangian two-form `Ω_{L_d} = −dθ⁺ = −dθ⁻ = −Σ D₁D₂L_d dq0 ∧ dq1` (paper, section 6), in units of `L` per
/// units of two coordinates.
#[must_use]
pub fn discrete_form(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> TwoForm {
    let mixed = mixed(&Declaration::of(system), h, leg);
    TwoForm::from_fn(mixed.len(), &|a, i, b, j| match (a, b) {
        (0, 1) => -mixed[i][j],
        (1, 0) => mixed[j][i],
        _ => 0.0,
    })
}
