//! The evolution of the discrete two-form.

use super::array::{along, minus, moving, moving_leg, plus, slopes, square, times, zero};
use super::error::GeometryError;
use super::form::{Displacement, TwoForm};
use super::legendre::{discrete_form, mixed};
use super::map::{DiscreteFlow, TangentMap, Triple};
use super::units;
use crate::number::larger;
use crate::number::point::AnyLeg;
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;

/// The paper's law `F*Ω_{L_d} = Ω_{L_d} + dξ` at a trajectory, with each of its terms computed independently.
///
/// `ξ(δq0, δq1) = (F⁺L_d(q0, q1) − F⁻L_d(q1, q2)) · δq1` (paper, section 6) is `−(Q + f_d) · δq1` with the constraint force `Q` and the external
/// forces `f_d`. `Ω` comes from second derivatives of `L_d`, `F*` from the tangent map, `dξ` from first derivatives of the generated force along the
/// flow.
#[derive(Clone, Debug, PartialEq)]
pub struct Evolution {
    /// `Ω_{L_d}` at `(q0, q1)`.
    pub before: TwoForm,
    /// `F*Ω_{L_d}` at `(q0, q1)`.
    pub after: TwoForm,
    /// `dξ` at `(q0, q1)`.
    pub d_xi: TwoForm,
    /// For each entry, the sum of the absolute values of all its terms. Rounding errors are relative to this size.
    pub terms: TwoForm,
    /// The tangent map from which `F*` is computed.
    pub tangent: TangentMap,
}

impl Evolution {
    /// The terms of the law at a trajectory.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the triple does not solve the step, or if the flow has no derivative there.
    pub fn of(flow: &DiscreteFlow<'_>, triple: &Triple) -> Result<Self, GeometryError> {
        let tangent = flow.tangent(triple)?;
        let before = discrete_form(flow.system(), flow.h, triple.leg.any());
        let last = mixed(&flow.declaration(), flow.h, triple.last(flow.h).any());
        let n = last.len();
        // D₁D₂L_d(q1, q2) times the derivatives of q2
        let by_first = chained(&last, &tangent.by_first);
        let by_second = chained(&last, &tangent.by_second);
        let after = TwoForm::from_fn(n, &|a, i, b, j| match (a, b) {
            (0, 1) => by_first[j][i].0,
            (1, 0) => -by_first[i][j].0,
            (1, 1) => by_second[j][i].0 - by_second[i][j].0,
            _ => 0.0,
        });
        let force = force_slopes(flow, triple, &tangent);
        let d_xi = TwoForm::from_fn(n, &|a, i, b, j| {
            let left = if b == 1 { force[a][i][j] } else { 0.0 };
            let right = if a == 1 { force[b][j][i] } else { 0.0 };
            right - left
        });
        let terms = TwoForm::from_fn(n, &|a, i, b, j| {
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

    /// The error of the law, relative to the terms: of the size of rounding if the law holds.
    #[must_use]
    pub fn defect(&self) -> f64 {
        self.relative(&|a, i, b, j| {
            let entry = |form: &TwoForm| form.blocks[a][b][i][j];
            entry(&self.after) - entry(&self.before) - entry(&self.d_xi)
        })
    }

    /// The change of the law's terms by one unit in the last place of the time, the nodes and the increments,
    /// relative to the terms. It is large where, for example, a velocity is close to that of light, or the
    /// time is large beside a period.
    #[must_use]
    pub fn rounding(&self, flow: &DiscreteFlow<'_>, triple: &Triple) -> f64 {
        let last = |x: f64| x.abs().next_up() - x.abs();
        let next = triple.last(flow.h);
        let legs = [triple.first(), next.any()];
        let of_leg = legs.map(|leg| {
            let here = discrete_form(flow.system(), flow.h, leg);
            let change = |moved: AnyLeg<'_, f64>| {
                let there = discrete_form(flow.system(), flow.h, moved);
                self.relative(&|a, i, b, j| there.blocks[a][b][i][j] - here.blocks[a][b][i][j])
            };
            let t = leg.t + last(leg.t);
            let mut sum = change(AnyLeg { t, ..leg });
            for i in 0..leg.d.len() {
                let moved = |x: &[f64]| plus(x, &along(x.len(), i, last(x[i])));
                let (q, d) = (moved(leg.q), moved(leg.d));
                sum += change(AnyLeg { q: &q, ..leg }) + change(AnyLeg { d: &d, ..leg });
            }
            sum
        });
        larger(of_leg[0], of_leg[1])
    }

    /// The size of `dξ`, relative to the terms: that of rounding if the flow is symplectic.
    #[must_use]
    pub fn change(&self) -> f64 {
        self.relative(&|a, i, b, j| self.d_xi.blocks[a][b][i][j])
    }

    /// The size of `dξ` on given displacements, relative to the terms.
    ///
    /// If there are constraints on positions or velocities, the flow is a map of the pairs of nodes that obey them. The displacements along
    /// these pairs are those of [`pair_displacements`](super::pair_displacements).
    #[must_use]
    pub fn change_on(&self, displacements: &[Displacement]) -> f64 {
        let mut largest = 0.0;
        for (k, u) in displacements.iter().enumerate() {
            for w in &displacements[..k] {
                let terms = self.terms.of(&absolute(u), &absolute(w));
                if terms > 0.0 {
                    largest = larger(largest, self.d_xi.of(u, w).abs() / terms);
                }
            }
        }
        largest
    }

    /// The largest entry over its terms.
    fn relative(&self, entry: &dyn Fn(usize, usize, usize, usize) -> f64) -> f64 {
        let mut largest = 0.0;
        for ([a, i, b, j], terms) in self.terms.entries() {
            let entry = entry(a, i, b, j).abs();
            largest = larger(largest, if entry == 0.0 { 0.0 } else { entry / terms });
        }
        largest
    }
}

/// A displacement with the absolute values of its components.
fn absolute(displacement: &Displacement) -> Displacement {
    let absolute = |x: &[f64]| x.iter().map(|x| x.abs()).collect();
    Displacement {
        first: absolute(&displacement.first),
        second: absolute(&displacement.second),
    }
}

/// A product of matrices, each entry with the sum of its terms' absolute values.
fn chained(left: &[Vec<f64>], right: &[Vec<f64>]) -> Vec<Vec<(f64, f64)>> {
    let mut product = vec![vec![(0.0, 0.0); right.len()]; left.len()];
    for (row, left) in product.iter_mut().zip(left) {
        for (j, (sum, size)) in row.iter_mut().enumerate() {
            for (left, right) in left.iter().zip(right) {
                let term = left * right[j];
                *sum += term;
                *size += term.abs();
            }
        }
    }
    product
}

/// The derivative of the constraint force and the external forces along the flow: `[a][i][j]` of component `j` by coordinate `i` of `q0` (`a = 0`) or
/// `q1`.
fn force_slopes(flow: &DiscreteFlow<'_>, triple: &Triple, tangent: &TangentMap) -> [Vec<Vec<f64>>; 2] {
    let (leg, e) = (triple.leg.any(), &triple.e);
    let units = units(leg);
    let n = units.len();
    let (declaration, h, zero) = (flow.declaration(), Tangent::splat(flow.h), zero(n));
    let mut found = [square(n), square(n)];
    for (i, &unit) in units.iter().enumerate() {
        let own = along(n, i, unit);
        let back = along(n, i, -unit);
        // e = q2 − 2 q1 + q0 along the flow
        let by_first = plus(&column(&tangent.by_first, i), &along(n, i, 1.0));
        let by_second = minus(&column(&tangent.by_second, i), &along(n, i, 2.0));
        let moved = [
            (moving_leg(leg, &zero, &back), by_first),
            (moving_leg(leg, &own, &own), by_second),
        ];
        for (found, (leg, by)) in found.iter_mut().zip(moved) {
            let e = moving(e, &times(unit, &by));
            let mut force = declaration.force(h, leg.any(), &e);
            let external = declaration.external_force(h, leg.any(), &e);
            for (force, external) in force.iter_mut().zip(external) {
                *force = *force + external;
            }
            found[i] = slopes(&force, unit);
        }
    }
    found
}

/// A column of a matrix.
fn column(matrix: &[Vec<f64>], j: usize) -> Vec<f64> {
    matrix.iter().map(|row| row[j]).collect()
}
