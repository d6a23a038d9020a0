//! Discrete Legendre transforms and the forms that they make.

use super::array::{along, moving_leg, moving_twice, times};
use super::form::{Displacement, TwoForm};
use super::solvable::Declared;
use super::units;
use crate::declaration::Declaration;
use crate::scalar::Scalar;
use crate::system::Leg;
use crate::tangent::{Tangent, Tangent2};

/// The derivative of `L_d` along `part` times each coordinate of the node `q1`, and each of the increment.
fn derivative<const N: usize>(
    declaration: &Declaration<'_>,
    h: f64,
    leg: &Leg<f64, N>,
    [by_q, by_d]: [f64; 2],
) -> [f64; N] {
    let units = units(leg);
    let mut slopes = [0.0; N];
    for (j, (slope, &unit)) in slopes.iter_mut().zip(&units).enumerate() {
        let leg = moving_leg(leg, &along(j, by_q * unit), &along(j, by_d * unit));
        let value = declaration.discrete_lagrangian(Tangent::splat(h), leg.any());
        *slope = value.derivative() / unit;
    }
    slopes
}

/// The discrete Lagrangian `L_d(q0, q1) = L(φ_{L_d}⁻¹(q0, q1))` on a leg (paper, section 3: it is not multiplied by `h`).
#[must_use]
pub fn discrete_lagrangian<const N: usize>(system: &dyn Declared<N>, h: f64, leg: &Leg<f64, N>) -> f64 {
    system.declaration().discrete_lagrangian(h, leg.any())
}

/// The discrete Legendre transform `F⁻L_d(q0, q1) = −D₁L_d(q0, q1)` at `q0`, in units of `L` per unit of the coordinate
/// (paper, section 3: `L_d` is not multiplied by `h`).
#[must_use]
pub fn legendre_minus<const N: usize>(system: &dyn Declared<N>, h: f64, leg: &Leg<f64, N>) -> [f64; N] {
    // q0 = q1 − d
    derivative(&system.declaration(), h, leg, [0.0, 1.0])
}

/// The discrete Legendre transform `F⁺L_d(q0, q1) = D₂L_d(q0, q1)` at `q1`, in units of `L` per unit of the coordinate.
#[must_use]
pub fn legendre_plus<const N: usize>(system: &dyn Declared<N>, h: f64, leg: &Leg<f64, N>) -> [f64; N] {
    derivative(&system.declaration(), h, leg, [1.0, 1.0])
}

/// The discrete momentum at the first node of a leg, `h F⁻L_d`, in units of `∂L/∂v`.
#[must_use]
pub fn momentum_minus<const N: usize>(system: &dyn Declared<N>, h: f64, leg: &Leg<f64, N>) -> [f64; N] {
    times(h, &legendre_minus(system, h, leg))
}

/// The discrete momentum at the second node of a leg, `h F⁺L_d`, in units of `∂L/∂v`.
#[must_use]
pub fn momentum_plus<const N: usize>(system: &dyn Declared<N>, h: f64, leg: &Leg<f64, N>) -> [f64; N] {
    times(h, &legendre_plus(system, h, leg))
}

/// The discrete one-form `θ⁻(δq0, δq1) = F⁻L_d(q0, q1) · δq0` (paper, section 6).
#[must_use]
pub fn theta_minus<const N: usize>(
    system: &dyn Declared<N>,
    h: f64,
    leg: &Leg<f64, N>,
    displacement: &Displacement<N>,
) -> f64 {
    product(&legendre_minus(system, h, leg), &displacement.first)
}

/// The discrete one-form `θ⁺(δq0, δq1) = F⁺L_d(q0, q1) · δq1` (paper, section 6).
#[must_use]
pub fn theta_plus<const N: usize>(
    system: &dyn Declared<N>,
    h: f64,
    leg: &Leg<f64, N>,
    displacement: &Displacement<N>,
) -> f64 {
    product(&legendre_plus(system, h, leg), &displacement.second)
}

/// The sum of products.
pub(super) fn product<const N: usize>(x: &[f64; N], y: &[f64; N]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// `D₁D₂L_d`: row `i` by the first node's coordinate `i`, column `j` by the second's coordinate `j`.
pub(super) fn mixed<const N: usize>(
    declaration: &Declaration<'_>,
    h: f64,
    leg: &Leg<f64, N>,
) -> [[f64; N]; N] {
    let units = units(leg);
    let mut mixed = [[0.0; N]; N];
    for (i, row) in mixed.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let second = along(j, units[j]);
            let moved = Leg {
                t: Tangent2::splat(leg.t),
                q: moving_twice(&leg.q, [&[0.0; N], &second]),
                d: moving_twice(&leg.d, [&along(i, -units[i]), &second]),
            };
            let value = declaration.discrete_lagrangian(Tangent2::splat(h), moved.any());
            *entry = value.mixed() / (units[i] * units[j]);
        }
    }
    mixed
}

/// The discrete Lagrangian two-form `Ω_{L_d} = −dθ⁺ = −dθ⁻ = −Σ D₁D₂L_d dq0 ∧ dq1` (paper, section 6), in units of `L` per
/// units of two coordinates.
#[must_use]
pub fn discrete_form<const N: usize>(system: &dyn Declared<N>, h: f64, leg: &Leg<f64, N>) -> TwoForm<N> {
    let mixed = mixed(&system.declaration(), h, leg);
    TwoForm::from_fn(&|a, i, b, j| match (a, b) {
        (0, 1) => -mixed[i][j],
        (1, 0) => mixed[j][i],
        _ => 0.0,
    })
}
