//! The inverse of the discrete flow, `(q1, q2) ↦ (q0, q1)`.

use super::array::{along, minus, moving_leg, times, zero};
use super::error::GeometryError;
use super::map::{DiscreteFlow, Triple, moved};
use super::solvable::{self, WantedSolution};
use super::units;
use crate::number::point::{AnyLeg, OwnedLeg};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::lengths::lengths;
use crate::regularity::multipliers;
use crate::regularity::stacked::of_first_pair;
use crate::solve::dense::Matrix;

/// Largest number of iterations for the first node.
const MAX_ITERATIONS: u32 = 60;

/// An update below this part of a leg is the last: the error after it is about its square.
const LAST_UPDATE: f64 = 1e-9;

/// Updates below this part of a leg that no longer shrink are rounding.
const ROUNDING: f64 = 1e-7;

/// A singular value below this part of the largest is zero: the first node is not determined.
const RANK: f64 = 1e-14;

/// A Newton update with the unknowns after it.
struct Update {
    /// The change of the leg.
    d: Vec<f64>,
    /// The unknowns after it.
    z: Vec<f64>,
}

impl DiscreteFlow<'_> {
    /// The inverse flow `F⁻¹`: the trajectory `(q0, q1, q2)` that ends with a pair `(q1, q2)`.
    ///
    /// The first guess is the solution of the generated step with `−h`. If the declaration is symmetric in time, it is also the result
    /// ([`DiscreteFlow::irreversibility`]). Otherwise the equations of the step are solved for `q0` by Newton's iteration. The flow is a map of
    /// the pairs that obey holonomic and nonholonomic constraints, but the equations of the step impose these constraints only on `q2`. So
    /// here they are also imposed on `q0` and on the leg `(q0, q1)`.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Inverse`] if no first node is found, [`GeometryError::Length`] if the pair has another number of coordinates,
    /// [`GeometryError::Setup`] if a coordinate is a rotation.
    pub fn backward(&self, last: AnyLeg<'_, f64>) -> Result<Triple, GeometryError> {
        self.without_rotations(
            "the inverse of the flow of pairs of nodes (geometry::DiscreteFlow::backward)",
        )?;
        self.check(&[last.q, last.d])?;
        self.backward_near(last, &self.reversed(last).unwrap_or(zero(last.d.len())))
    }

    /// [`DiscreteFlow::backward`] near a second difference. Several first nodes may lead to one pair, as
    /// several last nodes may follow one: the theorem makes the flow a diffeomorphism only near each of its
    /// trajectories.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Inverse`] if no first node is found, [`GeometryError::Length`] if the pair has another number of coordinates,
    /// [`GeometryError::Setup`] if a coordinate is a rotation.
    pub fn backward_near(&self, last: AnyLeg<'_, f64>, near: &[f64]) -> Result<Triple, GeometryError> {
        self.without_rotations(
            "the inverse of the flow of pairs of nodes (geometry::DiscreteFlow::backward)",
        )?;
        self.check(&[last.q, last.d, near])?;
        let mut e = near.to_vec();
        let q1 = minus(last.q, last.d);
        let t = last.t - self.h;
        let at = |e: &[f64]| OwnedLeg {
            t,
            q: q1.clone(),
            d: minus(last.d, e),
        };
        let still = zero(last.d.len());
        let lengths = lengths(&self.declaration(), self.h, last, &still);
        let mut z = if let Ok(solution) = self.solved(at(&e).any(), WantedSolution::Near(&e)) {
            solution.z
        } else {
            let declaration = self.declaration();
            let multipliers = multipliers::of_step(&declaration, self.h, at(&e).any(), &e);
            declaration.unknown(&e, &multipliers)
        };
        let mut before = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let Some(update) = self.update(last, at(&e).any(), &z) else {
                break;
            };
            let size = update.d.iter().zip(&lengths);
            let size = size.map(|(d, length)| (d / length).abs()).fold(0.0, f64::max);
            e = minus(&e, &update.d);
            z = update.z;
            if size < LAST_UPDATE || (size < ROUNDING && size > before / 2.0) {
                return Ok(Triple { leg: at(&e), e });
            }
            before = size;
        }
        Err(GeometryError::Inverse {
            q1,
            q2: last.q.to_vec(),
            update: before,
        })
    }

    /// The distance between the first node of a trajectory and the node that the step with `−h` gives, relative to the longer of the legs: zero
    /// up to rounding if the declaration is symmetric in time.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the step with `−h` has no solution.
    pub fn irreversibility(&self, triple: &Triple) -> Result<f64, GeometryError> {
        let back = self.with_step(-self.h)?;
        let last = triple.last_of(&self.system.shape().rotations, self.h);
        let turned = AnyLeg {
            t: triple.leg.t,
            q: &triple.leg.q,
            d: &times(-1.0, &last.d),
        };
        let found = back.forward_near(turned, &triple.e)?;
        let norm = |x: &[f64]| x.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
        let apart = norm(&minus(&found.e, &triple.e));
        Ok(apart / norm(&triple.leg.d).max(norm(&last.d)))
    }

    /// The second difference of the step with `−h` from `(q2, q1)`.
    fn reversed(&self, last: AnyLeg<'_, f64>) -> Option<Vec<f64>> {
        let turned = AnyLeg {
            t: last.t - self.h,
            q: &minus(last.q, last.d),
            d: &times(-1.0, last.d),
        };
        let solution = solvable::step(self.system, -self.h, turned, WantedSolution::First).ok()?;
        Some(solution.e)
    }

    /// Newton's update of the first leg and the unknowns. The equations are the rows of the step,
    /// `d + S(d, z) = q2 − q1`, and the constraints of lower order on the first pair, since those on the last
    /// pair hold. So there may be more equations than unknowns, some of them dependent.
    fn update(&self, last: AnyLeg<'_, f64>, leg: AnyLeg<'_, f64>, z: &[f64]) -> Option<Update> {
        let declaration = self.declaration();
        let (n, count) = (leg.d.len(), z.len());
        let (all, bound) = (count + n, declaration.lower());
        let (units, h) = (units(last), Tangent::splat(self.h));
        // the step removes the rounding error of a constraint on positions over many steps, so it is the same at all three nodes
        let mut left = declaration.pair(self.h, leg);
        left.truncate(declaration.holonomic());
        let mut matrix = Matrix::zeros(all + bound, all);
        let mut right = vec![0.0; all + bound];
        for column in 0..all {
            let part = |k: usize| if k == column { 1.0 } else { 0.0 };
            let unit = units.get(column).copied().unwrap_or(0.0);
            let moving = moving_leg(leg, &zero(n), &along(n, column, unit));
            let z = moved(z, |k| part(n + k));
            let rows = declaration.rows(h, moving.any(), &z);
            let e = declaration.second_difference(h, moving.any(), &z);
            for (i, row) in rows.iter().enumerate() {
                matrix[(i, column)] = row.derivative();
                right[i] = -row.value();
            }
            for i in 0..n {
                let sum = moving.d[i] + e[i];
                matrix[(count + i, column)] = sum.derivative();
                right[count + i] = (last.d[i] - leg.d[i]) - e[i].value();
            }
            for (i, row) in of_first_pair(&declaration, h, moving.any())
                .into_iter()
                .enumerate()
            {
                matrix[(all + i, column)] = row.derivative();
                right[all + i] = left.get(i).copied().unwrap_or(0.0) - row.value();
            }
        }
        let change = solved(matrix, right)?;
        let mut z = z.to_vec();
        for (k, z) in z.iter_mut().enumerate() {
            *z += change[n + k];
        }
        let mut d = units;
        for (d, change) in d.iter_mut().zip(&change) {
            *d *= change;
        }
        Some(Update { d, z })
    }
}

/// The least-squares solution of equations of full rank, with scaled rows and unknowns; `None` if the rank is
/// not full.
fn solved(mut matrix: Matrix, mut right: Vec<f64>) -> Option<Vec<f64>> {
    for (i, right) in right.iter_mut().enumerate() {
        let size = matrix.row(i).fold(0.0_f64, |size, x| size.max(x.abs()));
        if size > 0.0 {
            matrix.divide_row(i, size);
            *right /= size;
        }
    }
    let sizes = matrix.normalize_columns();
    if !matrix.is_finite() || right.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let decomposed = matrix.decomposed();
    let [smallest, largest] = decomposed.extremes();
    if smallest <= RANK * largest {
        return None;
    }
    let mut change = decomposed.solve(&right, 0.0);
    for (change, size) in change.iter_mut().zip(&sizes) {
        *change /= size;
    }
    change.iter().all(|x| x.is_finite()).then_some(change)
}
