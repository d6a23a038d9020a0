//! The continuous system's form, its variational equation, and the rate at which `dν` grows.

use super::array::{along, moving, moving_twice, plus, slopes};
use super::error::GeometryError;
use super::form::{Displacement, TwoForm};
use super::solvable::{Declared, Solvable};
use crate::any::{continuous_force as continuous, sized};
use crate::multipliers;
use crate::scalar::Scalar as _;
use crate::system::Point;
use crate::tangent::{Tangent, Tangent2};

/// The Legendre transform `FL(t, q, v) = ∂L/∂v`: the momentum.
#[must_use]
pub fn legendre<const N: usize>(system: &dyn Declared<N>, t: f64, q: &[f64; N], v: &[f64; N]) -> [f64; N] {
    let (declaration, t) = (system.declaration(), Tangent::new(t, 0.0));
    let q = moving(q, &[0.0; N]);
    let mut momentum = [0.0; N];
    for (j, momentum) in momentum.iter_mut().enumerate() {
        *momentum = declaration
            .lagrangian(t, &q, &moving(v, &along(j, 1.0)))
            .derivative();
    }
    momentum
}

/// The Lagrangian two-form `Ω_L = −dθ_L = dq ∧ d(∂L/∂v)` at `(t, q, v)`, on displacements `(δq, δv)` (paper, section 2).
#[must_use]
pub fn canonical_form<const N: usize>(
    system: &dyn Declared<N>,
    t: f64,
    q: &[f64; N],
    v: &[f64; N],
) -> TwoForm<N> {
    let (declaration, t) = (system.declaration(), Tangent2::splat(t));
    // ∂²L/∂v_i∂q_j and ∂²L/∂v_i∂v_j
    let [mut by_q, mut by_v] = [[[0.0; N]; N]; 2];
    for (entries, [to_q, to_v]) in [(&mut by_q, [1.0, 0.0]), (&mut by_v, [0.0, 1.0])] {
        for (i, row) in entries.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let q = moving_twice(q, [&[0.0; N], &along(j, to_q)]);
                let v = moving_twice(v, [&along(i, 1.0), &along(j, to_v)]);
                *entry = declaration.lagrangian(t, &q, &v).mixed();
            }
        }
    }
    TwoForm::from_fn(&|a, i, b, j| match (a, b) {
        (0, 0) => by_q[i][j] - by_q[j][i],
        (0, 1) => by_v[i][j],
        (1, 0) => -by_v[j][i],
        _ => 0.0,
    })
}

/// The generalized constraint force of the continuous system at a point, `Q = d/dt ∂L/∂v − ∂L/∂q − f` with the external forces `f`, in units of `L`
/// per unit of the coordinate.
#[must_use]
pub fn constraint_force<const N: usize>(system: &dyn Declared<N>, point: &Point<f64, N>) -> [f64; N] {
    continuous(&system.declaration(), point)
}

/// The point of the continuous system's motion through `(q, v)` at the time `t`, with the acceleration that its rows determine.
///
/// # Errors
///
/// [`GeometryError::Acceleration`] if the rows determine no acceleration.
pub fn motion<const N: usize>(
    system: &dyn Solvable<N>,
    t: f64,
    q: [f64; N],
    v: [f64; N],
) -> Result<Point<f64, N>, GeometryError> {
    motion_near(system, (t, q, v), None)
}

/// The same, with the acceleration near one, if the rows determine several.
///
/// # Errors
///
/// As [`motion`].
pub fn motion_near<const N: usize>(
    system: &dyn Solvable<N>,
    (t, q, v): (f64, [f64; N], [f64; N]),
    near: Option<&[f64; N]>,
) -> Result<Point<f64, N>, GeometryError> {
    match system.acceleration((t, &q, &v), near) {
        Ok(a) => Ok(Point { t, q, v, a }),
        Err(cause) => Err(GeometryError::Acceleration {
            q: q.to_vec(),
            v: v.to_vec(),
            cause: Box::new(cause),
        }),
    }
}

/// The variations of the acceleration and of the constraint force under a displacement of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation<const N: usize> {
    /// `δa`, from the rows of the continuous system by the implicit function theorem.
    pub a: [f64; N],
    /// `δ(Q + f)`, the variation of the constraint force and the external forces.
    pub force: [f64; N],
}

impl<const N: usize> Variation<N> {
    /// The rate `d/ds dν(u, w)` at which the paper's `dν = (F^t)*Ω_L − Ω_L` grows, `⟨δ_w Q, δ_u q⟩ − ⟨δ_u Q, δ_w q⟩`, from the variations of two
    /// displacements, with `Q + f` for `Q` where external forces act. (`ν = ∫ D_{EL}L · δq ds` and `D_{EL}L = −Q − f`; paper, section 2.)
    #[must_use]
    pub fn rate(u: (&Displacement<N>, &Self), w: (&Displacement<N>, &Self)) -> f64 {
        let product = super::legendre::product;
        product(&w.1.force, &u.0.first) - product(&u.1.force, &w.0.first)
    }
}

/// The variational equation of the continuous system at a point of its motion: the variations under the displacement `(δq, δv)`.
///
/// `None` if the rows do not determine the acceleration.
#[must_use]
pub fn variation<const N: usize>(
    system: &dyn Solvable<N>,
    point: &Point<f64, N>,
    displacement: &Displacement<N>,
) -> Option<Variation<N>> {
    let at = |a: &[f64; N]| Point {
        t: Tangent::new(point.t, 0.0),
        q: moving(&point.q, &displacement.first),
        v: moving(&point.v, &displacement.second),
        a: moving(&point.a, a),
    };
    let declaration = system.declaration();
    let multipliers = multipliers::of_point(&declaration, point.any());
    let fixed: Vec<_> = multipliers.iter().map(|&x| Tangent::new(x, 0.0)).collect();
    let rows = declaration.continuous(at(&[0.0; N]).any(), &fixed);
    let right: Vec<f64> = rows.iter().map(|row| -row.derivative()).collect();
    // the rows come first
    let both = declaration.continuous_with_jacobian(point.any(), &multipliers);
    let change = system.solve_accelerations(both.get(right.len()..)?, &right)?;
    let a = *change.first_chunk()?;
    let moved = at(&a);
    let force = slopes(&sized(&declaration.continuous_force(moved.any())), 1.0);
    let mut external = [Tangent::splat(0.0); N];
    declaration.external_forces(moved.t, &moved.q, &moved.v, &mut external);
    let force = plus(&force, &slopes(&external, 1.0));
    Some(Variation { a, force })
}
