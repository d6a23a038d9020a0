//! Starts of systems with constraints of third order: an acceleration is free there, and three nodes begin the motion.

use super::check_vector;
use core::cmp::Ordering;

use super::consistency::{self, OBEYED};
use crate::any::AnySystem;
use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::deficiency;
use crate::dense::Matrix;
use crate::error::{SetupError, Violation};
use crate::multipliers;
use crate::rounding::Bounded;
use crate::scalar::Scalar as _;
use crate::system::{Leg, Point, System};
use crate::tangent::Tangent;
use crate::tape::Number;

/// How often the jerk at the start is improved.
const MAX_ITERATIONS: usize = 50;

/// Updates of this part are rounding, where a system of equations is solved.
const SETTLED: f64 = 64.0 * f64::EPSILON;

/// The same where a nearest point is looked for.
const ROUNDED: f64 = 4.0 * f64::EPSILON;

/// Forms below this part of the largest count as zero.
const NO_FORM: f64 = 1e-12;

/// What is said of the start beside position and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Free<const N: usize> {
    /// The acceleration.
    Acceleration([f64; N]),
    /// The generalized constraint force, from which it follows.
    Force([f64; N]),
}

/// How the motion begins.
pub(crate) struct Began<const N: usize> {
    /// The acceleration.
    pub(super) a0: [f64; N],
    /// The increment from the first node to the second.
    pub(super) d: Compensated<N>,
    /// The second difference of the first three nodes.
    pub(super) e: Compensated<N>,
}

/// What is done with constraints of third order at the start of a motion.
pub(crate) trait OfThirdOrder<const N: usize> {
    /// See [`begin`].
    fn begin(
        &self,
        at: (f64, f64),
        state: (&[f64; N], &[f64; N]),
        free: Free<N>,
        projected: bool,
    ) -> Result<Began<N>, SetupError>;

    /// The third derivative of the continuous motion at `[q, v, a]`, looked for near another; `None` where it cannot be solved for.
    fn jerk(&self, t: f64, point: [&[f64; N]; 3], near: &[f64; N]) -> Option<[f64; N]>;
}

impl<S: System<N>, const N: usize> OfThirdOrder<N> for S {
    fn begin(
        &self,
        at: (f64, f64),
        state: (&[f64; N], &[f64; N]),
        free: Free<N>,
        projected: bool,
    ) -> Result<Began<N>, SetupError> {
        begin(self, at, state, free, projected)
    }

    fn jerk(&self, t: f64, point: [&[f64; N]; 3], near: &[f64; N]) -> Option<[f64; N]> {
        jerk(self, t, point, near)
    }
}

/// The first three nodes: `q1 = q0 + h v0 + h²/2 a0 + h³/6 j0`, moved onto constraints of lower order; then the second difference with
/// which all equations of the triple hold but those of third order: the nearest to `h² a0 + h³ j0`, by the mass matrix. Where the start says
/// the force, and the forms of the constraint forces are known, it is that with the multipliers `λ0 + h λ̇0` of the constraints of third order.
///
/// The jerk `j0` comes from the constraints of third order and from the other equations, differentiated. Without it the whole motion would
/// be of first order: the second difference would be that of another force than the one that the motion has arrived at.
fn begin<const N: usize>(
    system: &dyn AnySystem<N>,
    (t0, h): (f64, f64),
    (q0, v0): (&[f64; N], &[f64; N]),
    free: Free<N>,
    projected: bool,
) -> Result<Began<N>, SetupError> {
    let declaration = system.declaration();
    let equations = Equations {
        system,
        declaration: &declaration,
        t: t0,
        q: q0,
        v: v0,
    };
    let a0 = match free {
        Free::Acceleration(a0) => {
            check_vector(system, "a0", &a0)?;
            a0
        }
        Free::Force(force) => {
            check_vector(system, "force", &force)?;
            equations.acceleration_of(&force)?
        }
    };
    let a0 = if projected {
        equations.projected(a0)?
    } else {
        equations.check(&a0)?;
        a0
    };
    let j0 = equations.jerk(&a0, &[0.0; N])?;
    let mut d = Compensated::exact(v0.map(|v| h * v));
    d.add(&a0.map(|a| h * h / 2.0 * a));
    d.add(&j0.map(|j| h * h * h / 6.0 * j));
    let d = consistency::onto_pair(&declaration, (t0, h), q0, v0, d)?;
    let leg = Leg {
        t: t0 + h,
        q: Compensated::exact(*q0).plus(&d).hi,
        d: d.hi,
    };
    let near = core::array::from_fn(|i| h * h * (a0[i] + h * j0[i]));
    let multipliers = match free {
        Free::Acceleration(_) => Vec::new(),
        Free::Force(_) => equations.multipliers_after(h, &a0, &j0),
    };
    let e = equations.second_difference(h, &leg, near, &multipliers)?;
    Ok(Began { a0, d, e })
}

/// See [`OfThirdOrder::jerk`].
fn jerk<const N: usize>(
    system: &dyn AnySystem<N>,
    t: f64,
    [q, v, a]: [&[f64; N]; 3],
    near: &[f64; N],
) -> Option<[f64; N]> {
    let declaration = system.declaration();
    let equations = Equations {
        system,
        declaration: &declaration,
        t,
        q,
        v,
    };
    equations.jerk(a, near).ok()
}

/// The equations of the continuous system at a position and a velocity, and those of the first triple.
struct Equations<'a, const N: usize> {
    system: &'a dyn AnySystem<N>,
    declaration: &'a Declaration<'a, N>,
    t: f64,
    q: &'a [f64; N],
    v: &'a [f64; N],
}

impl<const N: usize> Equations<'_, N> {
    /// How many constraints there are.
    fn constraints(&self) -> usize {
        self.system.constraints().iter().sum()
    }

    /// The point with an acceleration.
    fn point(&self, a: &[f64; N]) -> Point<f64, N> {
        Point {
            t: self.t,
            q: *self.q,
            v: *self.v,
            a: *a,
        }
    }

    /// The same, where the acceleration alone may move.
    fn moving(&self, a: &[Tangent; N]) -> Point<Tangent, N> {
        Point {
            t: Tangent::splat(self.t),
            q: self.q.map(Tangent::splat),
            v: self.v.map(Tangent::splat),
            a: *a,
        }
    }

    /// The acceleration that a constraint force belongs to; the force is affine in it.
    fn acceleration_of(&self, force: &[f64; N]) -> Result<[f64; N], SetupError> {
        let inverse = consistency::inverse_mass(self.declaration, self.t, self.q, self.v);
        let mut a = [0.0; N];
        // once more for what rounding has left
        for _ in 0..2 {
            let found = self.declaration.continuous_force(&self.point(&a));
            let missing: [f64; N] = core::array::from_fn(|i| force[i] - found[i]);
            for (a, update) in a.iter_mut().zip(inverse.times_vector(&missing)) {
                *a += update;
            }
        }
        let found = self.declaration.continuous_force(&self.point(&a));
        let size = force
            .iter()
            .chain(&found)
            .fold(0.0_f64, |size, x| size.max(x.abs()));
        let left = (0..N).fold(0.0_f64, |left, i| left.max((force[i] - found[i]).abs()));
        // the mass matrix is singular
        if left <= 1e-8 * size && a.iter().all(|a| a.is_finite()) {
            Ok(a)
        } else {
            Err(SetupError::StartForce { left })
        }
    }

    /// The equations without jerks as `[constraints, the rest]`: those of third order are left out, and in place of multipliers there are
    /// works along a basis of the directions in which no form acts.
    fn below<T: Number>(
        &self,
        rows: Vec<T>,
        force: impl FnOnce() -> [T; N],
        forms: impl FnOnce() -> Vec<[T; N]>,
    ) -> Vec<T> {
        let count = self.constraints();
        let third = self.system.third_order();
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
            let known: Vec<[f64; N]> = forms.iter().map(|form| form.map(|x| x.lane(0))).collect();
            let acting = multipliers::multipliers(&force.map(|x| x.lane(0)), &known);
            // a direction turns with the forms: where the force is a sum of them, their changes do not count
            let left: [T; N] = core::array::from_fn(|i| {
                let parts = forms.iter().zip(&known).zip(&acting);
                let changes =
                    parts.map(|((form, known), acting)| T::splat(*acting) * (form[i] - T::splat(known[i])));
                force[i] - changes.fold(T::splat(0.0), |sum, change| sum + change)
            });
            below.extend(free_directions(&known).iter().map(|u| {
                let works = u.iter().zip(left).map(|(&u, left)| T::splat(u) * left);
                works.fold(T::splat(0.0), |sum, work| sum + work)
            }));
        }
        below
    }

    /// The constraints that are not of third order, and what the force of those that are leaves of the force, in the directions in which the
    /// forms of the others do not act.
    fn with_multipliers(
        &self,
        rows: Vec<Tangent>,
        force: &[Tangent; N],
        forms: &[[Tangent; N]],
        multipliers: &[f64],
    ) -> Vec<Tangent> {
        let third = self.system.third_order();
        let constraints = rows.into_iter().take(self.constraints()).enumerate();
        let constraints = constraints.filter(|(place, _)| !third.contains(place));
        let mut all: Vec<_> = constraints.map(|(_, row)| row).collect();
        let (own, others): (Vec<_>, Vec<_>) = forms
            .iter()
            .zip(multipliers)
            .enumerate()
            .partition(|(place, _)| third.contains(place));
        let left: [Tangent; N] = core::array::from_fn(|i| {
            let known = own
                .iter()
                .map(|(_, (form, multiplier))| Tangent::splat(**multiplier) * form[i]);
            force[i] - known.fold(Tangent::splat(0.0), |sum, part| sum + part)
        });
        let others: Vec<[f64; N]> = others
            .iter()
            .map(|(_, (form, _))| form.map(Tangent::value))
            .collect();
        all.extend(free_directions(&others).iter().map(|u| {
            let works = u.iter().zip(left).map(|(&u, left)| Tangent::splat(u) * left);
            works.fold(Tangent::splat(0.0), |sum, work| sum + work)
        }));
        all
    }

    /// The equations without jerks of the continuous system, at an acceleration.
    fn of_acceleration<T: Number>(&self, point: &Point<T, N>) -> Vec<T> {
        self.below(
            self.declaration
                .continuous_of_third(point, &[T::splat(0.0); N], &[]),
            || self.declaration.continuous_force(point),
            || self.declaration.continuous_forms(point),
        )
    }

    /// How large the terms of these equations are.
    fn sizes(&self, a: &[f64; N]) -> Vec<f64> {
        let point = Point {
            t: Bounded::splat(self.t),
            q: self.q.map(Bounded::splat),
            v: self.v.map(Bounded::splat),
            a: a.map(Bounded::splat),
        };
        let rows = self.of_acceleration(&point);
        rows.into_iter()
            .map(|row| row.error() / (f64::EPSILON / 2.0))
            .collect()
    }

    /// Checks that an acceleration obeys them.
    fn check(&self, a: &[f64; N]) -> Result<(), SetupError> {
        let rows = self.of_acceleration(&self.point(a));
        let sizes = self.sizes(a);
        let count = self.constraints() - self.system.third_order().len();
        let violations = rows.iter().zip(sizes).enumerate();
        let wrong = violations
            .into_iter()
            // also where one of them is no number
            .filter(|(_, (row, size))| {
                row.abs()
                    .partial_cmp(&(OBEYED * size))
                    .is_none_or(Ordering::is_gt)
            });
        let violations: Vec<_> = wrong
            .map(|(place, (&value, size))| Violation {
                constraint: if place < count {
                    "constraint of lower order, in accelerations,"
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

    /// The nearest acceleration that obeys them.
    fn projected(&self, a: [f64; N]) -> Result<[f64; N], SetupError> {
        let inverse = consistency::inverse_mass(self.declaration, self.t, self.q, self.v);
        let rows = |a: &[Tangent; N]| self.of_acceleration(&self.moving(a));
        nearest(&inverse, &a, rows)
    }

    /// The jerk, from the constraints of third order and from the other equations, differentiated.
    ///
    /// Where multipliers are unknown, those that act are known from the acceleration, and their rates are unknown beside the jerk.
    fn jerk(&self, a: &[f64; N], near: &[f64; N]) -> Result<[f64; N], SetupError> {
        let multipliers = if self.declaration.has_multipliers() {
            multipliers::of_point(self.declaration, &self.point(a))
        } else {
            Vec::new()
        };
        let size = N + multipliers.len();
        let third = self.system.third_order();
        let value = |x: &[f64], moved: Option<usize>| -> Vec<Tangent> {
            let along = |x: &[f64; N], by: &[f64; N]| -> [Tangent; N] {
                core::array::from_fn(|i| Tangent::new(x[i], by[i]))
            };
            let j = core::array::from_fn(|i| x[i]);
            let point = Point {
                t: Tangent::new(self.t, 1.0),
                q: along(self.q, self.v),
                v: along(self.v, a),
                a: along(a, &j),
            };
            let rates = x[N..].iter().zip(&multipliers);
            let rates: Vec<_> = rates.map(|(&rate, &known)| Tangent::new(known, rate)).collect();
            let differentiated =
                self.declaration
                    .continuous_of_third(&point, &[Tangent::splat(0.0); N], &rates);
            let fixed: [Tangent; N] =
                core::array::from_fn(|i| Tangent::new(x[i], if moved == Some(i) { 1.0 } else { 0.0 }));
            let own = self
                .declaration
                .continuous_of_third(&self.moving(&a.map(Tangent::splat)), &fixed, &[]);
            let rows = differentiated.iter().zip(own).enumerate();
            rows.map(|(place, (row, own))| {
                if third.contains(&place) {
                    own
                } else {
                    Tangent::splat(row.derivative())
                }
            })
            .collect()
        };
        let mut x = near.to_vec();
        x.resize(size, 0.0);
        let failed = |columns: &[Vec<Tangent>]| {
            let deficiency = deficiency::of_columns(self.system, columns, &self.point(a));
            Err(SetupError::Jerk {
                deficiency: deficiency.map(Box::new),
            })
        };
        let mut columns = Vec::new();
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let rows: Vec<f64> = value(&x, None).into_iter().map(Tangent::value).collect();
            columns = (0..size)
                .map(|k| {
                    // what is differentiated is affine
                    let mut beside = x.clone();
                    beside[k] += 1.0;
                    let (slopes, beside) = (value(&x, Some(k)), value(&beside, None));
                    let entries = slopes.into_iter().zip(beside).zip(&rows).enumerate();
                    entries
                        .map(|(place, ((slope, beside), row))| {
                            if third.contains(&place) {
                                slope
                            } else {
                                Tangent::new(*row, beside.value() - row)
                            }
                        })
                        .collect::<Vec<_>>()
                })
                .collect();
            if rows.len() != size || rows.iter().any(|row| !row.is_finite()) {
                break;
            }
            let Some(update) = solved(&columns, &rows) else {
                return failed(&columns);
            };
            let mut step = 0.0_f64;
            for (x, update) in x.iter_mut().zip(&update) {
                *x -= update;
            }
            let largest = x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            for update in &update {
                step = step.max(update.abs());
            }
            if step <= SETTLED * largest || step == 0.0 || (step >= last && step <= 1e-9 * largest) {
                return Ok(core::array::from_fn(|i| x[i]));
            }
            last = step;
        }
        failed(&columns)
    }

    /// The multipliers of all forms a step later, `λ0 + h λ̇0`; none where no forms are known.
    fn multipliers_after(&self, h: f64, a: &[f64; N], j: &[f64; N]) -> Vec<f64> {
        let along = |x: &[f64; N], by: &[f64; N]| -> [Tangent; N] {
            core::array::from_fn(|i| Tangent::new(x[i], by[i]))
        };
        let point = Point {
            t: Tangent::new(self.t, 1.0),
            q: along(self.q, self.v),
            v: along(self.v, a),
            a: along(a, j),
        };
        let force = self.declaration.continuous_force(&point);
        let forms = self.declaration.continuous_forms(&point);
        let now: Vec<_> = forms.iter().map(|form| form.map(Tangent::value)).collect();
        let known = multipliers::multipliers(&force.map(Tangent::value), &now);
        // d/dt Q = Σ λ̇ α + Σ λ dα/dt
        let by_rates = core::array::from_fn(|i| {
            let turned = known
                .iter()
                .zip(&forms)
                .map(|(known, form)| known * form[i].derivative());
            force[i].derivative() - turned.sum::<f64>()
        });
        let rates = multipliers::multipliers(&by_rates, &now);
        known
            .iter()
            .zip(rates)
            .map(|(known, rate)| known + h * rate)
            .collect()
    }

    /// The second difference of the first triple that obeys what is not of third order, with the multipliers of what is, or the nearest
    /// to another one.
    fn second_difference(
        &self,
        h: f64,
        leg: &Leg<f64, N>,
        near: [f64; N],
        multipliers: &[f64],
    ) -> Result<Compensated<N>, SetupError> {
        let inverse = consistency::inverse_mass(self.declaration, self.t, self.q, self.v);
        let fixed = Leg {
            t: Tangent::splat(leg.t),
            q: leg.q.map(Tangent::splat),
            d: leg.d.map(Tangent::splat),
        };
        let step = Tangent::splat(h);
        // after no second difference the third is the second
        let rows = |e: &[Tangent; N]| {
            let rows = self.declaration.declared(step, &fixed, e, &[]);
            let force = || self.declaration.force(step, &fixed, e);
            if multipliers.is_empty() {
                self.below(rows, force, || self.declaration.forms(step, &fixed, e))
            } else {
                let forms = self.declaration.forms(step, &fixed, e);
                self.with_multipliers(rows, &force(), &forms, multipliers)
            }
        };
        Ok(Compensated::exact(nearest(&inverse, &near, rows)?))
    }
}

/// The point nearest to another, by the inverse of a metric, at which rows vanish: each update is the shortest way from there to where the rows
/// vanish as they are linearized.
fn nearest<const N: usize>(
    inverse: &Matrix,
    near: &[f64; N],
    rows: impl Fn(&[Tangent; N]) -> Vec<Tangent>,
) -> Result<[f64; N], SetupError> {
    let mut correction = [0.0; N];
    let mut last = f64::INFINITY;
    let mut left = Vec::new();
    for _ in 0..MAX_ITERATIONS {
        let moved = |j: usize| {
            core::array::from_fn(|i| Tangent::new(near[i] + correction[i], if i == j { 1.0 } else { 0.0 }))
        };
        let columns: Vec<Vec<Tangent>> = (0..N).map(|j| rows(&moved(j))).collect();
        left = columns
            .first()
            .map_or_else(Vec::new, |column| column.iter().map(|row| row.value()).collect());
        if left.iter().all(|left| *left == 0.0) {
            return Ok(core::array::from_fn(|i| near[i] + correction[i]));
        }
        let slope = Matrix::from_fn(left.len(), N, |i, j| columns[j][i].derivative());
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
        let next = forces.times_vector(&metric.decomposed().solve(&wanted, f64::EPSILON));
        let (mut step, mut size) = (0.0_f64, 0.0_f64);
        for i in 0..N {
            step = step.max((next[i] - correction[i]).abs());
            size = size.max(near[i].abs()).max(next[i].abs());
            correction[i] = next[i];
        }
        if step <= ROUNDED * size || step >= last && step <= OBEYED * size {
            return Ok(core::array::from_fn(|i| near[i] + correction[i]));
        }
        last = step;
    }
    Err(SetupError::Projection { residual: left })
}

/// A basis of the directions on which forms vanish.
fn free_directions<const N: usize>(forms: &[[f64; N]]) -> Vec<[f64; N]> {
    let largest = |form: &[f64; N]| form.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let rows: Vec<[f64; N]> = forms
        .iter()
        .map(|form| {
            let size = largest(form);
            if size > 0.0 { form.map(|x| x / size) } else { *form }
        })
        .collect();
    let matrix = Matrix::from_fn(N, N, |i, j| rows.get(i).map_or(0.0, |row| row[j]));
    if !matrix.is_finite() {
        return vec![[f64::NAN; N]; N - forms.len().min(N)];
    }
    let singular = matrix.decomposed();
    let vectors = singular.values.iter().zip(&singular.right);
    let free = vectors.filter(|(value, _)| **value <= NO_FORM);
    free.map(|(_, vector)| core::array::from_fn(|i| vector[i]))
        .collect()
}

/// The solution of linear equations that are given by their columns; `None` where they are singular.
fn solved(columns: &[Vec<Tangent>], right: &[f64]) -> Option<Vec<f64>> {
    let size = right.len();
    let matrix = Matrix::from_fn(size, size, |i, j| columns[j][i].derivative());
    let mut right = right.to_vec();
    let (singular, lengths) = matrix.equilibrated(&mut right)?;
    let [smallest, largest] = singular.extremes();
    if smallest <= NO_FORM * largest || smallest.is_nan() {
        return None;
    }
    let solution = singular.solve(&right, 0.0);
    Some(
        solution
            .iter()
            .zip(lengths)
            .map(|(x, length)| x / length)
            .collect(),
    )
}
