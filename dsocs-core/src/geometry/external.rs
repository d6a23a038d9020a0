//! External forces, and what they and the constraints do to the energy.

use super::array::{moving, plus};
use super::map::Triple;
use super::solvable::Declared;
use crate::any::{AnyLeg, continuous_force, sized};
use crate::declaration::Declaration;
use crate::system::Point;
use crate::tangent::Tangent;
use crate::tape::Number;

/// The discrete external force at the second of three nodes, `f⁻_d(q1, q2) + f⁺_d(q0, q1)`, in units of `L` per unit of the
/// coordinate; zero where no external forces are declared. (Discrete Lagrange-d'Alembert principle: Marsden and West 2001,
/// section 3.2.)
#[must_use]
pub fn external_forces<const N: usize>(system: &dyn Declared<N>, h: f64, triple: &Triple<N>) -> [f64; N] {
    sized(&discrete(&system.declaration(), h, triple.leg.any(), &triple.e))
}

/// The same for any number.
pub(super) fn discrete<T: Number>(
    declaration: &Declaration<'_>,
    h: T,
    leg: AnyLeg<'_, T>,
    e: &[T],
) -> Vec<T> {
    let d: Vec<T> = leg.d.iter().zip(e).map(|(&d, &e)| d + e).collect();
    let q: Vec<T> = leg.q.iter().zip(&d).map(|(&q, &d)| q + d).collect();
    let last = AnyLeg {
        t: leg.t + h,
        q: &q,
        d: &d,
    };
    let [_, mut sum] = declaration.discrete_external_forces(h, leg);
    let [minus, _] = declaration.discrete_external_forces(h, last);
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
    let constraint = continuous_force(&declaration, point);
    let mut external = [0.0; N];
    declaration.external_forces(point.t, &point.q, &point.v, &mut external);
    of_force(&declaration, point, &plus(&constraint, &external))
}

/// The power at the second of three nodes, as in [`power`] but with the discrete forces, at the point `φ_{D_K}⁻¹`. Its sum over the
/// nodes, times `h`, is the change of the energy at the nodes, up to the discretization error.
#[must_use]
pub fn discrete_power<const N: usize>(system: &dyn Declared<N>, h: f64, triple: &Triple<N>) -> f64 {
    let declaration = system.declaration();
    let leg = triple.leg.any();
    let constraint: [f64; N] = sized(&declaration.force(h, leg, &triple.e));
    let external = sized(&discrete(&declaration, h, leg, &triple.e));
    let point: Point<f64, N> = declaration.point(h, leg, &triple.e).sized();
    of_force(&declaration, &point, &plus(&constraint, &external))
}

/// `⟨force, v⟩ − ∂L/∂t` at a point.
fn of_force<const N: usize>(
    declaration: &Declaration<'_>,
    Point { t, q, v, .. }: &Point<f64, N>,
    force: &[f64; N],
) -> f64 {
    let fixed = |x| moving(x, &[0.0; N]);
    let explicit = declaration.lagrangian(Tangent::new(*t, 1.0), &fixed(q), &fixed(v));
    super::legendre::product(force, v) - explicit.derivative()
}
