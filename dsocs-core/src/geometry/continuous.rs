//! The continuous system's form, its variational equation, and the rate at which `dν` grows.

use super::array::{along, fixed, moving, moving_twice, plus, slopes, square, zero};
use super::error::GeometryError;
use super::form::{Displacement, TwoForm};
use super::solvable::solve;
use crate::kernel::Kernel;
use crate::number::inner_product;
use crate::number::point::{AnyPoint, OwnedPoint};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::{Tangent, Tangent2};
use crate::regularity::multipliers;
use crate::solve::rotation;
use crate::start;
use crate::start::place::cubic;
use crate::tape::Shape;
use crate::tape::declaration::Declaration;

/// The Legendre transform `FL(t, q, v) = ∂L/∂v`: the momentum.
#[must_use]
pub fn legendre(system: &dyn Kernel, t: f64, q: &[f64], v: &[f64]) -> Vec<f64> {
    legendre_with(&Declaration::of(system), (t, q, v))
}

/// [`legendre`] of a declaration, with its values of the parameters.
#[must_use]
pub fn legendre_with(declaration: &Declaration<'_>, (t, q, v): (f64, &[f64], &[f64])) -> Vec<f64> {
    start::momentum(declaration, (t, q, v))
}

/// The velocity with which a motion goes on where parameters change suddenly, from those of the first declaration to those of the second: as every run
/// does at a held input ([`crate::Inputs`]), it keeps the momentum, except for impulses of the constraint forces. `None` if the constraints do not
/// determine it.
#[must_use]
pub fn velocity_after(sides: &[Declaration<'_>; 2], (t, q, v): (f64, &[f64], &[f64])) -> Option<Vec<f64>> {
    start::velocity_after(sides, (t, q, v)).ok()
}

/// The Lagrangian two-form `Ω_L = −dθ_L = dq ∧ d(∂L/∂v)` at `(t, q, v)`, on displacements `(δq, δv)` (paper, section 2).
#[must_use]
pub fn canonical_form(system: &dyn Kernel, t: f64, q: &[f64], v: &[f64]) -> TwoForm {
    let (declaration, t) = (Declaration::of(system), Tangent2::splat(t));
    let n = declaration.dimension();
    let zero = zero(n);
    // ∂²L/∂v_i∂q_j and ∂²L/∂v_i∂v_j
    let [mut by_q, mut by_v] = [square(n), square(n)];
    for (entries, [to_q, to_v]) in [(&mut by_q, [1.0, 0.0]), (&mut by_v, [0.0, 1.0])] {
        for (i, row) in entries.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let q = moving_twice(q, [&zero, &along(n, j, to_q)]);
                let v = moving_twice(v, [&along(n, i, 1.0), &along(n, j, to_v)]);
                *entry = declaration.lagrangian(t, &q, &v).mixed();
            }
        }
    }
    TwoForm::from_fn(n, &|a, i, b, j| match (a, b) {
        (0, 0) => by_q[i][j] - by_q[j][i],
        (0, 1) => by_v[i][j],
        (1, 0) => -by_v[j][i],
        _ => 0.0,
    })
}

/// The generalized constraint force of the continuous system at a point, `Q = d/dt ∂L/∂v − ∂L/∂q − f` with the external forces `f`, in units of `L`
/// per unit of the coordinate.
#[must_use]
pub fn constraint_force(system: &dyn Kernel, point: AnyPoint<'_, f64>) -> Vec<f64> {
    Declaration::of(system).continuous_force(point)
}

/// The point of the continuous system's motion through `(q, v)` at the time `t`, with the acceleration that its rows determine.
///
/// # Errors
///
/// [`GeometryError::Acceleration`] if the rows determine no acceleration.
pub fn motion(system: &dyn Kernel, t: f64, q: &[f64], v: &[f64]) -> Result<OwnedPoint<f64>, GeometryError> {
    motion_near(system, (t, q, v), None)
}

/// [`motion`] with the acceleration searched near `near`, if the rows determine several.
///
/// # Errors
///
/// The errors of [`motion`].
pub fn motion_near(
    system: &dyn Kernel,
    (t, q, v): (f64, &[f64], &[f64]),
    near: Option<&[f64]>,
) -> Result<OwnedPoint<f64>, GeometryError> {
    match start::acceleration(&Declaration::of(system), (t, q, v), near) {
        Ok((a, _)) => Ok(AnyPoint { t, q, v, a: &a }.to_owned()),
        Err(cause) => Err(GeometryError::Acceleration {
            q: q.to_vec(),
            v: v.to_vec(),
            cause: Box::new(cause),
        }),
    }
}

/// The increment from one point to another, and the integral of the velocity on the way, with errors of the fifth order in the time
/// between them: by the cubic polynomial with the velocities and accelerations of both. For a rotation both are rotation vectors in
/// the frame of the body; the second is that of Magnus's expansion.
#[must_use]
pub fn position_changes(shape: &Shape, [from, to]: [AnyPoint<'_, f64>; 2]) -> [Vec<f64>; 2] {
    let h = to.t - from.t;
    let n = from.q.len();
    let mut increment: Vec<f64> = (0..n).map(|i| to.q[i] - from.q[i]).collect();
    let mut integral: Vec<f64> = (0..n)
        .map(|i| h * (0.5 * (from.v[i] + to.v[i]) + h / 12.0 * (from.a[i] - to.a[i])))
        .collect();
    rotation::turns(&shape.rotations, [from.q, to.q], &mut increment);
    for &first in shape.rotations.iter() {
        // the angular velocities at the places of Gauss's quadrature with two points, and the commutator of both
        let part = 0.5 - 3_f64.sqrt() / 6.0;
        let at = |x: f64| {
            [1, 2, 3].map(|slot| {
                let i = first + slot;
                cubic([from.v[i], to.v[i]], [h * from.a[i], h * to.a[i]], x)[0]
            })
        };
        let [[x, y, z], [u, v, w]] = [at(part), at(1.0 - part)];
        let cross = [y * w - z * v, z * u - x * w, x * v - y * u];
        for (slot, cross) in cross.into_iter().enumerate() {
            integral[first + 1 + slot] += 3_f64.sqrt() / 12.0 * h * h * cross;
        }
        (increment[first], integral[first]) = (0.0, 0.0);
    }
    [increment, integral]
}

/// The variations of the acceleration and of the constraint force under a displacement of the state.
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    /// `δa`, from the rows of the continuous system by the implicit function theorem.
    pub a: Vec<f64>,
    /// `δ(Q + f)`, the variation of the constraint force and the external forces.
    pub force: Vec<f64>,
}

impl Variation {
    /// The growth rate `d/ds dν(u, w)` of the paper's `dν = (F^t)*Ω_L − Ω_L`,
    /// `⟨δ_w Q, δ_u q⟩ − ⟨δ_u Q, δ_w q⟩`, from the variations under two displacements; with external forces,
    /// `Q + f` takes the place of `Q`. (`ν = ∫ D_{EL}L · δq ds` and `D_{EL}L = −Q − f`; paper, section 2.)
    #[must_use]
    pub fn rate(u: (&Displacement, &Self), w: (&Displacement, &Self)) -> f64 {
        inner_product(&w.1.force, &u.0.first) - inner_product(&u.1.force, &w.0.first)
    }
}

/// The variational equation of the continuous system at a point of its motion: the variations under the displacements `(δq, δv)`, in
/// their order.
///
/// `None` if the rows do not determine the acceleration.
#[must_use]
pub fn variations(
    system: &dyn Kernel,
    point: AnyPoint<'_, f64>,
    displacements: &[Displacement],
) -> Option<Vec<Variation>> {
    let declaration = Declaration::of(system);
    let n = declaration.dimension();
    let t = Tangent::new(point.t, 0.0);
    let multipliers = multipliers::of_point(&declaration, point);
    let still = fixed(&multipliers);
    let both = declaration.continuous_with_jacobian(point, &multipliers);
    let along = |displacement: &Displacement| {
        let q = &moving(point.q, &displacement.first);
        let v = &moving(point.v, &displacement.second);
        let a = &moving(point.a, &zero(n));
        let rows = declaration.continuous(AnyPoint { t, q, v, a }, &still);
        let right: Vec<f64> = rows.iter().map(|row| -row.derivative()).collect();
        // the rows come first
        let mut change = solve(both.get(right.len()..)?, &right)?;
        change.truncate(n);
        let a = &moving(point.a, &change);
        let force = slopes(&declaration.continuous_force(AnyPoint { t, q, v, a }), 1.0);
        let mut external = vec![Tangent::splat(0.0); n];
        declaration.external_forces(t, q, v, &mut external);
        let force = plus(&force, &slopes(&external, 1.0));
        Some(Variation { a: change, force })
    };
    displacements.iter().map(along).collect()
}
