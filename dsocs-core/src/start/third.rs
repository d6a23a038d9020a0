//! Starts of systems with constraints of third order: the acceleration is free, and three nodes begin the
//! motion.

mod jerk;
mod leaving;

use core::cmp::Ordering;

pub(crate) use jerk::{deficiency, determined, jerk, lower_acceleration};
pub(crate) use leaving::left_to;

use super::begin::check_vector;
use super::consistency::{self, OBEYED, SETTLED};
use crate::error::{SetupError, Violation};
use crate::number::bounded::Bounded;
use crate::number::point::{AnyLeg, AnyPoint, OwnedPoint, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::multipliers;
use crate::solve::Vector;
use crate::solve::dense::Matrix;
use crate::solve::sum::Sum;
use crate::start::place::Place;
use crate::tape::Number;
use crate::tape::declaration::Declaration;
use leaving::leaving;

/// Largest number of iterations for a nearest point.
const MAX_ITERATIONS: usize = 50;

/// In the search for a nearest point, updates below this part of the point are rounding.
const ROUNDED: f64 = 4.0 * f64::EPSILON;

/// Forms below this part of the largest count as zero.
const NO_FORM: f64 = 1e-12;

/// The quantity that the user gives beside position and velocity.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ThirdOrderDatum {
    /// The acceleration.
    Acceleration(Vector),
    /// The generalized constraint force, which determines the acceleration.
    Force(Vector),
}

/// The beginning of the motion.
pub(crate) struct InitialTriple {
    /// The acceleration.
    pub(super) a0: Vector,
    /// The increment from the first node to the second.
    pub(super) d: Sum,
    /// The second difference of the first three nodes.
    pub(super) e: Sum,
}

/// The first three nodes: `q1 = q0 + h v0 + h²/2 a0 + h³/6 j0`, projected onto constraints of lower order;
/// then a second difference with which all equations of the triple hold except those of third order: the
/// nearest to `h² a0 + h³ j0` in the mass metric. If the start gives the force, and the constraint forms are
/// known, it is the one with the multipliers `λ0 + h λ̇0` of the constraints of third order.
///
/// The jerk `j0` follows from the constraints of third order and the derivatives of the other equations.
/// Without it the whole motion would be of first order: the second difference would belong to another force
/// than that of the motion.
#[expect(
    clippy::needless_pass_by_value,
    reason = "what a start leaves free is used up by it"
)]
pub(super) fn begin(
    declaration: &Declaration<'_>,
    (t0, h): (f64, f64),
    (q0, v0): (&[f64], &[f64]),
    datum: ThirdOrderDatum,
    projected: bool,
) -> Result<InitialTriple, SetupError> {
    let start = Place::of_phase(t0, Vector::of(q0), Vector::of(v0));
    let a0 = match &datum {
        ThirdOrderDatum::Acceleration(a0) => {
            check_vector(declaration, "a0", a0)?;
            a0.clone()
        }
        ThirdOrderDatum::Force(force) => {
            check_vector(declaration, "force", force)?;
            let a0 = Equations::of(declaration, &start).acceleration_of(force)?;
            match leaving(declaration, &start, h, &a0) {
                // on the side of a jump to which the motion leaves
                Some([place, _]) => Vector::of(&Equations::of(declaration, &place).acceleration_of(force)?),
                None => Vector::of(&a0),
            }
        }
    };
    let [place, beyond] = leaving(declaration, &start, h, &a0).unwrap_or_else(|| [start.clone(), start]);
    let equations = Equations::of(declaration, &place);
    let a0 = if projected {
        Vector::of(&equations.projected(&a0)?)
    } else {
        equations.check(&a0, &Equations::of(declaration, &beyond))?;
        a0
    };
    let j0 = Vector::of(&equations.jerk(&a0, &Vector::zero(q0.len()))?);
    let mut d = Sum::exact(Vector::of(v0).map(|v| h * v));
    d.add(&a0.map(|a| h * h / 2.0 * a));
    d.add(&j0.map(|j| h * h * h / 6.0 * j));
    let d = super::begin::onto_pair(declaration, (t0, h), q0, v0, &d)?;
    let q1 = Sum::exact(Vector::of(q0)).plus(&d).hi;
    let leg = AnyLeg {
        t: t0 + h,
        q: &q1,
        d: &d.hi,
    };
    let near = a0.zip(&j0, |a, j| h * h * (a + h * j));
    let multipliers = match datum {
        ThirdOrderDatum::Acceleration(_) => Vec::new(),
        ThirdOrderDatum::Force(_) => equations.multipliers_after(h, &a0, &j0),
    };
    let e = equations.second_difference(h, leg, &near, &multipliers)?;
    let e = Sum::exact(Vector::of(&e));
    Ok(InitialTriple { a0, d, e })
}

/// The equations of the continuous system at a position and a velocity, and those of the first triple.
struct Equations<'a> {
    /// The places of the constraints of third order.
    third: &'a [usize],
    declaration: &'a Declaration<'a>,
    t: f64,
    q: &'a [f64],
    v: &'a [f64],
}

impl<'a> Equations<'a> {
    /// The equations at a place.
    fn of(declaration: &'a Declaration<'a>, place: &'a Place) -> Self {
        Self::at(declaration, place.t, &place.q, &place.v)
    }

    /// The equations at a position and a velocity.
    fn at(declaration: &'a Declaration<'a>, t: f64, q: &'a [f64], v: &'a [f64]) -> Self {
        Self {
            third: &declaration.shape().third_order,
            declaration,
            t,
            q,
            v,
        }
    }
}

impl Equations<'_> {
    /// The number of constraints.
    fn constraints(&self) -> usize {
        self.declaration.constraints().iter().sum()
    }

    /// The point with an acceleration.
    fn point<'b>(&'b self, a: &'b [f64]) -> AnyPoint<'b, f64> {
        AnyPoint {
            t: self.t,
            q: self.q,
            v: self.v,
            a,
        }
    }

    /// The point in another type of number, with its own acceleration.
    fn moving<T: Number>(&self, a: &[T]) -> OwnedPoint<T> {
        let mut values = map(self.q, T::splat);
        values.extend(map(self.v, T::splat));
        values.extend(a);
        values.push(T::splat(self.t));
        OwnedPoint::new(self.q.len(), values)
    }

    /// The point with its derivative in time, for an acceleration and a jerk.
    fn going_on(&self, a: &[f64], j: &[f64]) -> OwnedPoint<Tangent> {
        let along = |x: &[f64], by: &[f64]| -> Vec<Tangent> {
            let pairs = x.iter().zip(by);
            pairs.map(|(&x, &by)| Tangent::new(x, by)).collect()
        };
        let mut values = along(self.q, self.v);
        values.extend(along(self.v, a));
        values.extend(along(a, j));
        values.push(Tangent::new(self.t, 1.0));
        OwnedPoint::new(self.q.len(), values)
    }

    /// The acceleration for a given constraint force, which is affine in it.
    fn acceleration_of(&self, force: &[f64]) -> Result<Vec<f64>, SetupError> {
        let inverse = consistency::inverse_mass(self.declaration, self.t, self.q, self.v);
        let mut a = vec![0.0; force.len()];
        // a second iteration removes rounding
        for _ in 0..2 {
            let found = self.declaration.continuous_force(self.point(&a));
            let missing: Vec<f64> = force
                .iter()
                .zip(&found)
                .map(|(force, found)| force - found)
                .collect();
            for (a, update) in a.iter_mut().zip(inverse.times_vector(&missing)) {
                *a += update;
            }
        }
        let found = self.declaration.continuous_force(self.point(&a));
        // relative to its terms: a force of zero may be the sum of large ones
        let terms = self
            .declaration
            .continuous_force(self.moving(&map(&a, Bounded::splat)).any());
        let terms = terms.into_iter().map(|term| term.error() / (f64::EPSILON / 2.0));
        let size = terms.fold(0.0_f64, f64::max);
        let missing = force.iter().zip(&found);
        let left = missing.fold(0.0_f64, |left, (force, found)| left.max((force - found).abs()));
        // otherwise the mass matrix is singular
        if left <= 1e-8 * size && a.iter().all(|a| a.is_finite()) {
            Ok(a)
        } else {
            Err(SetupError::StartForce { left })
        }
    }

    /// The equations without jerks as `[constraints, others]`: those of third order are left out, and in
    /// place of the equations with multipliers there are works along a basis of the directions in which no
    /// form acts.
    fn below<T: Number>(
        &self,
        rows: Vec<T>,
        force: impl FnOnce() -> Vec<T>,
        forms: impl FnOnce() -> Vec<Vec<T>>,
    ) -> Vec<T> {
        let count = self.constraints();
        let third = self.third;
        let mut below = Vec::with_capacity(rows.len());
        let multiplied = self.declaration.has_multipliers();
        for (place, row) in rows.into_iter().enumerate() {
            let is_kept = if place < count {
                !third.contains(&place)
            } else {
                !multiplied
            };
            if is_kept {
                below.push(row);
            }
        }
        if multiplied {
            let (forms, force) = (forms(), force());
            let known: Vec<Vec<f64>> = forms.iter().map(|form| map(form, |x| x.lane(0))).collect();
            let acting = multipliers::multipliers(&map(&force, |x| x.lane(0)), &known);
            // the basis depends on the forms: where the force is a sum of forms, their changes do not count
            let left = |i: usize| {
                let parts = forms.iter().zip(&known).zip(&acting);
                let changes =
                    parts.map(|((form, known), acting)| T::splat(*acting) * (form[i] - T::splat(known[i])));
                force[i] - changes.fold(T::splat(0.0), |sum, change| sum + change)
            };
            let left: Vec<T> = (0..force.len()).map(left).collect();
            below.extend(free_directions(force.len(), &known).iter().map(|u| {
                let works = u.iter().zip(&left).map(|(&u, &left)| T::splat(u) * left);
                works.fold(T::splat(0.0), |sum, work| sum + work)
            }));
        }
        below
    }

    /// The constraints below third order, and the force minus that of the third-order constraints, in the
    /// directions in which the forms of the others do not act.
    fn with_multipliers(
        &self,
        rows: Vec<Tangent>,
        force: &[Tangent],
        forms: &[Vec<Tangent>],
        multipliers: &[f64],
    ) -> Vec<Tangent> {
        let third = self.third;
        let constraints = rows.into_iter().take(self.constraints()).enumerate();
        let constraints = constraints.filter(|(place, _)| !third.contains(place));
        let mut all: Vec<_> = constraints.map(|(_, row)| row).collect();
        let (own, others): (Vec<_>, Vec<_>) = forms
            .iter()
            .zip(multipliers)
            .enumerate()
            .partition(|(place, _)| third.contains(place));
        let left = |i: usize| {
            let known = own
                .iter()
                .map(|(_, (form, multiplier))| Tangent::splat(**multiplier) * form[i]);
            force[i] - known.fold(Tangent::splat(0.0), |sum, part| sum + part)
        };
        let left: Vec<Tangent> = (0..force.len()).map(left).collect();
        let others: Vec<Vec<f64>> = others
            .iter()
            .map(|(_, (form, _))| map(form, Tangent::value))
            .collect();
        all.extend(free_directions(force.len(), &others).iter().map(|u| {
            let works = u.iter().zip(&left).map(|(&u, &left)| Tangent::splat(u) * left);
            works.fold(Tangent::splat(0.0), |sum, work| sum + work)
        }));
        all
    }

    /// The equations without jerks of the continuous system, at an acceleration.
    fn of_acceleration<T: Number>(&self, point: AnyPoint<'_, T>) -> Vec<T> {
        self.below(
            self.declaration
                .continuous_of_third(point, &map(self.q, |_| T::splat(0.0)), &[]),
            || self.declaration.continuous_force(point),
            || self.declaration.continuous_forms(point),
        )
    }

    /// The sizes of these equations' terms.
    fn sizes(&self, a: &[f64]) -> Vec<f64> {
        let point = self.moving(&map(a, Bounded::splat));
        let rows = self.of_acceleration(point.any());
        rows.into_iter()
            .map(|row| row.error() / (f64::EPSILON / 2.0))
            .collect()
    }

    /// Checks that an acceleration obeys the equations, up to their change to the place `beyond`.
    fn check(&self, a: &[f64], beyond: &Self) -> Result<(), SetupError> {
        let rows = self.of_acceleration(self.point(a));
        let change = beyond.of_acceleration(beyond.point(a));
        let changes = change.iter().zip(&rows).map(|(x, y)| 2.0 * (x - y).abs());
        let sizes = self.sizes(a);
        let count = self.constraints() - self.third.len();
        let violations = rows.iter().zip(sizes).zip(changes).enumerate();
        let wrong = violations
            // true also for a NaN
            .filter(|(_, ((row, size), change))| {
                row.abs()
                    .partial_cmp(&(OBEYED * size + change))
                    .is_none_or(Ordering::is_gt)
            });
        let violations: Vec<_> = wrong
            .map(|(place, ((&value, size), _))| Violation {
                constraint: if place < count {
                    "constraint of lower order, in accelerations,"
                } else if self.declaration.forms_count() > 0 {
                    "equation of motion without constraint forces"
                } else {
                    "virtual displacement (the force does work on it)"
                },
                index: if place < count { place } else { place - count },
                at: "(q0, v0, a0)",
                value,
                size,
            })
            .collect();
        if violations.is_empty() {
            Ok(())
        } else {
            Err(SetupError::Inconsistent { violations })
        }
    }

    /// The nearest acceleration that obeys the equations.
    fn projected(&self, a: &[f64]) -> Result<Vec<f64>, SetupError> {
        let inverse = consistency::inverse_mass(self.declaration, self.t, self.q, self.v);
        nearest(&inverse, a, 0.0, &|a| self.of_acceleration(self.moving(a).any()))
    }

    /// The multipliers of all forms a step later, `λ0 + h λ̇0`; empty if no forms are known.
    fn multipliers_after(&self, h: f64, a: &[f64], j: &[f64]) -> Vec<f64> {
        let point = self.going_on(a, j);
        let force = self.declaration.continuous_force(point.any());
        let forms = self.declaration.continuous_forms(point.any());
        let now: Vec<_> = forms.iter().map(|form| map(form, Tangent::value)).collect();
        let known = multipliers::multipliers(&map(&force, Tangent::value), &now);
        // d/dt Q = Σ λ̇ α + Σ λ dα/dt
        let by_rate = |i: usize| {
            let turned = known
                .iter()
                .zip(&forms)
                .map(|(known, form)| known * form[i].derivative());
            force[i].derivative() - turned.sum::<f64>()
        };
        let by_rates: Vec<f64> = (0..force.len()).map(by_rate).collect();
        let rates = multipliers::multipliers(&by_rates, &now);
        known
            .iter()
            .zip(rates)
            .map(|(known, rate)| known + h * rate)
            .collect()
    }

    /// The second difference of the first triple that obeys the equations below third order, with the given
    /// multipliers of third order or, without them, nearest to a given one.
    fn second_difference(
        &self,
        h: f64,
        leg: AnyLeg<'_, f64>,
        near: &[f64],
        multipliers: &[f64],
    ) -> Result<Vec<f64>, SetupError> {
        let inverse = consistency::inverse_mass(self.declaration, self.t, self.q, self.v);
        let fixed = leg.map(Tangent::splat);
        let step = Tangent::splat(h);
        // without an earlier second difference, the third difference equals the second
        let rows = |e: &[Tangent]| {
            let rows = self.declaration.declared(step, fixed.any(), e, &[]);
            let force = || self.declaration.force(step, fixed.any(), e);
            if multipliers.is_empty() {
                self.below(rows, force, || self.declaration.forms(step, fixed.any(), e))
            } else {
                let forms = self.declaration.forms(step, fixed.any(), e);
                self.with_multipliers(rows, &force(), &forms, multipliers)
            }
        };
        // the second difference has only the digits of the nodes if rows depend on these
        let around = leg
            .q
            .iter()
            .chain(leg.d)
            .fold(0.0_f64, |most, x| most.max(x.abs()));
        nearest(&inverse, near, around, &rows)
    }
}

/// The point nearest to another, in the metric with the given inverse, at which rows vanish: each update is
/// the shortest way to the zeros of the linearized rows. The result is rounded like a number of the size
/// `around`, at most.
fn nearest(
    inverse: &Matrix,
    near: &[f64],
    around: f64,
    rows: &dyn Fn(&[Tangent]) -> Vec<Tangent>,
) -> Result<Vec<f64>, SetupError> {
    let n = near.len();
    let mut correction = vec![0.0; n];
    let mut last = f64::INFINITY;
    let mut left = Vec::new();
    for _ in 0..MAX_ITERATIONS {
        let reached: Vec<f64> = near
            .iter()
            .zip(&correction)
            .map(|(near, correction)| near + correction)
            .collect();
        let columns: Vec<Vec<Tangent>> = (0..n).map(|j| rows(&moved(&reached, j))).collect();
        left = columns
            .first()
            .map_or_else(Vec::new, |column| column.iter().map(|row| row.value()).collect());
        if left.iter().all(|left| *left == 0.0) {
            return Ok(reached);
        }
        let slope = Matrix::from_fn(left.len(), n, |i, j| columns[j][i].derivative());
        let forces = inverse.times(&slope.transposed());
        let metric = slope.times(&forces);
        let there = slope.times_vector(&correction);
        let wanted: Vec<f64> = there
            .iter()
            .zip(&left)
            .map(|(there, left)| there - left)
            .collect();
        if !metric.is_finite() || wanted.iter().any(|x| !x.is_finite()) {
            break;
        }
        let next = forces.times_vector(&metric.solve_metric(&wanted));
        let (mut step, mut size) = (0.0_f64, 0.0_f64);
        for i in 0..n {
            step = step.max((next[i] - correction[i]).abs());
            size = size.max(near[i].abs()).max(next[i].abs());
            correction[i] = next[i];
        }
        let allowed = (ROUNDED * size).max(f64::EPSILON * around);
        let at_last = (OBEYED * size).max(SETTLED * around);
        if step <= allowed || step >= last && step <= at_last {
            return Ok(near
                .iter()
                .zip(&correction)
                .map(|(near, correction)| near + correction)
                .collect());
        }
        last = step;
    }
    Err(SetupError::Projection { residual: left })
}

/// A basis of the directions of `n` coordinates on which forms vanish.
fn free_directions(n: usize, forms: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let scaled = |form: &Vec<f64>| {
        let size = form.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        map(form, |x| if size > 0.0 { x / size } else { x })
    };
    let rows: Vec<Vec<f64>> = forms.iter().map(scaled).collect();
    let matrix = Matrix::from_fn(n, n, |i, j| rows.get(i).map_or(0.0, |row| row[j]));
    if !matrix.is_finite() {
        return vec![vec![f64::NAN; n]; n - forms.len().min(n)];
    }
    let singular = matrix.decomposed();
    let vectors = singular.values.iter().zip(&singular.right);
    let free = vectors.filter(|(value, _)| **value <= NO_FORM);
    free.map(|(_, vector)| vector.clone()).collect()
}
