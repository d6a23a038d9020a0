//! How the discrete two-form evolves.

use super::error::GeometryError;
use super::form::{Displacement, TwoForm};
use super::legendre::{discrete_form, mixed};
use super::map::{DiscreteFlow, TangentMap, Triple};
use super::units;
use crate::scalar::Scalar as _;
use crate::system::Leg;
use crate::tangent::Tangent;

/// The paper's law `F*Ω_{L_d} = Ω_{L_d} + dξ` at a trajectory, each of its terms computed by itself.
///
/// `ξ(δq0, δq1) = (F⁺L_d(q0, q1) − F⁻L_d(q1, q2)) · δq1` (paper, section 6) is `−Q · δq1` with the constraint force `Q`. `Ω` comes
/// from second derivatives of `L_d`, `F*` from the tangent map, `dξ` from first derivatives of the generated force along the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evolution<const N: usize> {
    /// `Ω_{L_d}` at `(q0, q1)`.
    pub before: TwoForm<N>,
    /// `F*Ω_{L_d}` at `(q0, q1)`.
    pub after: TwoForm<N>,
    /// `dξ` at `(q0, q1)`.
    pub d_xi: TwoForm<N>,
    /// The sum of the absolute values of all terms that an entry was summed up from: what its rounding is relative to.
    pub terms: TwoForm<N>,
    /// The tangent map that `F*` is by.
    pub tangent: TangentMap<N>,
}

impl<const N: usize> Evolution<N> {
    /// The terms of the law at a trajectory.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the triple is no trajectory or the flow has no derivative there.
    pub fn of(flow: &DiscreteFlow<'_, N>, triple: &Triple<N>) -> Result<Self, GeometryError> {
        let tangent = flow.tangent(triple)?;
        let before = discrete_form(flow.system, flow.h, &triple.leg);
        let last = mixed(&flow.declaration(), flow.h, &triple.last());
        // D₁D₂L_d(q1, q2) times the derivatives of q2
        let [by_first, by_second] = [tangent.by_first, tangent.by_second].map(|of| chained(&last, &of));
        let after = TwoForm::from_fn(|a, i, b, j| match (a, b) {
            (0, 1) => by_first[j][i].0,
            (1, 0) => -by_first[i][j].0,
            (1, 1) => by_second[j][i].0 - by_second[i][j].0,
            _ => 0.0,
        });
        let force = force_slopes(flow, triple, &tangent);
        let d_xi = TwoForm::from_fn(|a, i, b, j| {
            let left = if b == 1 { force[a][i][j] } else { 0.0 };
            let right = if a == 1 { force[b][j][i] } else { 0.0 };
            right - left
        });
        let terms = TwoForm::from_fn(|a, i, b, j| {
            let pulled = match (a, b) {
                (0, 1) => by_first[j][i].1,
                (1, 0) => by_first[i][j].1,
                (1, 1) => by_second[j][i].1 + by_second[i][j].1,
                _ => 0.0,
            };
            pulled + before.blocks[a][b][i][j].abs()
        });
        Ok(Self {
            before,
            after,
            d_xi,
            terms,
            tangent,
        })
    }

    /// By how much the law is missed, relative to the terms: rounding, if it holds.
    #[must_use]
    pub fn defect(&self) -> f64 {
        self.relative(|a, i, b, j| {
            let entry = |form: &TwoForm<N>| form.blocks[a][b][i][j];
            entry(&self.after) - entry(&self.before) - entry(&self.d_xi)
        })
    }

    /// How large `dξ` is, relative to the terms: rounding, if the flow is symplectic.
    #[must_use]
    pub fn change(&self) -> f64 {
        self.relative(|a, i, b, j| self.d_xi.blocks[a][b][i][j])
    }

    /// How large `dξ` is on some displacements, relative to the terms.
    ///
    /// Constraints of lower order bind pairs of nodes, and the flow is a map of those pairs alone: the displacements along
    /// them are those of [`pair_displacements`](super::pair_displacements).
    #[must_use]
    pub fn change_on(&self, displacements: &[Displacement<N>]) -> f64 {
        let absolute = |x: &[f64; N]| x.map(f64::abs);
        let size = |u: &Displacement<N>| Displacement {
            first: absolute(&u.first),
            second: absolute(&u.second),
        };
        let mut largest = 0.0;
        for (k, u) in displacements.iter().enumerate() {
            for w in &displacements[..k] {
                let terms = self.terms.of(&size(u), &size(w));
                if terms > 0.0 {
                    largest = larger(largest, self.d_xi.of(u, w).abs() / terms);
                }
            }
        }
        largest
    }

    /// The largest entry over its terms.
    fn relative(&self, entry: impl Fn(usize, usize, usize, usize) -> f64) -> f64 {
        self.terms.entries().fold(0.0, |largest, (a, i, b, j, terms)| {
            let entry = entry(a, i, b, j).abs();
            larger(largest, if entry == 0.0 { 0.0 } else { entry / terms })
        })
    }
}

/// The larger of two numbers; NaN if either is.
fn larger(x: f64, y: f64) -> f64 {
    if x >= y || x.is_nan() { x } else { y }
}

/// A product of matrices, each entry with the sum of its terms' absolute values.
fn chained<const N: usize>(left: &[[f64; N]; N], right: &[[f64; N]; N]) -> [[(f64, f64); N]; N] {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            (0..N).fold((0.0, 0.0), |(sum, size), k| {
                let term: f64 = left[i][k] * right[k][j];
                (sum + term, size + term.abs())
            })
        })
    })
}

/// The derivative of the constraint force along the flow: `[a][i][j]` of component `j` by coordinate `i` of `q0` (`a = 0`) or
/// `q1`.
fn force_slopes<const N: usize>(
    flow: &DiscreteFlow<'_, N>,
    triple: &Triple<N>,
    tangent: &TangentMap<N>,
) -> [[[f64; N]; N]; 2] {
    let Triple { leg, e } = triple;
    let units = units(leg);
    let (declaration, h) = (flow.declaration(), Tangent::splat(flow.h));
    core::array::from_fn(|a| {
        core::array::from_fn(|i| {
            let unit = units[i];
            let part = |k: usize, times: f64| if k == i { times } else { 0.0 };
            // e = q2 − 2 q1 + q0 along the flow
            let by = |k: usize| match a {
                0 => tangent.by_first[k][i] + part(k, 1.0),
                _ => tangent.by_second[k][i] - part(k, 2.0),
            };
            let [by_q, by_d] = if a == 0 { [0.0, -1.0] } else { [1.0, 1.0] };
            let moving = Leg {
                q: core::array::from_fn(|k| Tangent::new(leg.q[k], part(k, by_q * unit))),
                d: core::array::from_fn(|k| Tangent::new(leg.d[k], part(k, by_d * unit))),
            };
            let e = core::array::from_fn(|k| Tangent::new(e[k], by(k) * unit));
            let force = declaration.force(h, &moving, &e);
            force.map(|force| force.derivative() / unit)
        })
    })
}
