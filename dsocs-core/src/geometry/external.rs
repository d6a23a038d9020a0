//! External forces, and what they and the constraints do to the energy.

use super::array::{moving, plus};
use super::map::Triple;
use super::solvable::Declared;
use crate::declaration::Declaration;
use crate::system::{Leg, Point};
use crate::tangent::Tangent;
use crate::tape::Number;

/// The discrete external force at the second of three nodes, `f⁻_d(q1, q2) + f⁺_d(q0, q1)`, in units of `L` per unit of the
/// coordinate; zero where no external forces are declared. (Discrete Lagrange-d'Alembert principle: Marsden and West 2001,
/// section 3.2.)
#[must_use]
pub fn external_forces<const N: usize>(system: &dyn Declared<N>, h: f64, triple: &Triple<N>) -> [f64; N] {
    discrete(&system.declaration(), h, &triple.leg, &triple.e)
}

/// The same for any number.
pub(super) fn discrete<T: Number, const N: usize>(
    declaration: &Declaration<'_, N>,
    h: T,
    leg: &Leg<T, N>,
    e: &[T; N],
) -> [T; N] {
    let mut last = *leg;
    last.t = leg.t + h;
    last.d = core::array::from_fn(|i| leg.d[i] + e[i]);
    last.q = core::array::from_fn(|i| leg.q[i] + last.d[i]);
    let [_, mut sum] = declaration.discrete_external_forces(h, leg);
    let [minus, _] = declaration.discrete_external_forces(h, &last);
    for (sum, minus) in sum.iter_mut().zip(minus) {
        *sum = *sum + minus;
    }
    sum
}

/// The power at a point of the continuous system's motion, `dE/dt = ⟨Q + f, v⟩ − ∂L/∂t`, with the constraint force `Q` and the external
/// forces `f`, in units of `L` per unit of time.
#[must_use]
pub fn power<const N: usize>(system: &dyn Declared<N>, point: &Point<f64, N>) -> f64 {
    let declaration = system.declaration();
    let constraint = declaration.continuous_force(point);
    let external = declaration.external_forces(point.t, &point.q, &point.v);
    of_force(&declaration, point, &plus(&constraint, &external))
}

/// The power at the second of three nodes, as in [`power`] but with the discrete forces, at the point `φ_{D_K}⁻¹`. Its sum over the
/// nodes, times `h`, is the change of the energy at the nodes, up to the discretization error.
#[must_use]
pub fn discrete_power<const N: usize>(system: &dyn Declared<N>, h: f64, triple: &Triple<N>) -> f64 {
    let declaration = system.declaration();
    let constraint = declaration.force(h, &triple.leg, &triple.e);
    let external = discrete(&declaration, h, &triple.leg, &triple.e);
    let point = declaration.point(h, &triple.leg, &triple.e);
    of_force(&declaration, &point, &plus(&constraint, &external))
}

/// `⟨force, v⟩ − ∂L/∂t` at a point.
fn of_force<const N: usize>(
    declaration: &Declaration<'_, N>,
    Point { t, q, v, .. }: &Point<f64, N>,
    force: &[f64; N],
) -> f64 {
    let fixed = |x| moving(x, &[0.0; N]);
    let explicit = declaration.lagrangian(Tangent::new(*t, 1.0), &fixed(q), &fixed(v));
    super::legendre::product(force, v) - explicit.derivative()
}
