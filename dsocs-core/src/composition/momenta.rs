//! Legs of different lengths, joined by the momenta at the nodes.
//!
//! A node has the position `q`, the momentum `p` and the constraint force `Q`. A leg of the length `h` leads from it to `q'`, `p'`:
//!
//! ```text
//! p + h/2 Q  = -D₁L_d(q, q') - f⁻_d,    p' = D₂L_d(q, q') + f⁺_d + h/2 Q'
//! ```
//!
//! Here `Q'` is the constraint force of the continuous system at `q'` and `v'`, and `p' = ∂L/∂v(q', v')`
//! gives the velocity `v'`. So a leg consists of half a kick, the discrete flow of `L_d` with the external
//! forces, and another half kick. If `L_d` is symmetric, this map is symmetric in time and of order 2.
//! Without constraints it is the discrete flow of `L_d` itself, which is symplectic.
//!
//! For a rotation, `q` is the attitude and `p` the momentum in the frame of the body at this node: `q` moves
//! by the increment of the leg, and `D₁L_d`, `D₂L_d` and `Q` are momenta in the body frames of their own
//! nodes. Everything else is the same.
//!
//! Everything is evaluated on the tape.

#![allow(clippy::needless_range_loop)] // matrices are filled by row and column

use super::backward::{MANY, is_same, little_by_little};
use crate::error::SetupError;
use crate::number::larger;
use crate::number::point::{AnyLeg, AnyPoint, OwnedLeg, OwnedPoint, map};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::solve::predictor::Predictor;
use crate::solve::rotation;
use crate::solve::sum::Sum;
use crate::solve::{Square, Vector, is_finite};
use crate::start;
use crate::tape::declaration::Declaration;

/// The most iterations of Newton's method for a leg.
const MAX_ITERATIONS: u32 = 25;

/// The iteration ends after an update this small, relative to the unknowns: each iteration doubles the number of correct digits.
const LAST: f64 = 1e-11;

/// Updates below this that no longer become smaller are rounding.
const ROUNDING: f64 = 1e-7;

/// The least scale of a component, relative to the largest one; the updates of smaller components are
/// measured by it.
const LEAST: f64 = 1e-3;

/// A node.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// The time.
    pub(super) t: f64,
    /// The position.
    pub(super) q: Sum,
    /// The momentum.
    pub(super) p: Vector,
    /// The velocity.
    pub(super) v: Vector,
    /// The acceleration.
    pub(super) a: Vector,
    /// The constraint force.
    force: Vector,
    /// The multipliers, if they are unknowns of the equations.
    multipliers: Vector,
}

/// The reason why there is no leg.
#[derive(Clone, Debug)]
pub(super) enum LegFailure {
    /// No solution of its equations was found.
    NotSolved(NewtonFailure),
    /// The leg lies beyond a singularity of its equations.
    Singularity,
    /// Its solution does not continue the motion.
    Jump,
}

/// The legs of a stage in the last steps, from which the next one is extrapolated.
#[derive(Clone, Debug)]
pub(super) struct LegPredictor(Predictor);

impl LegPredictor {
    /// No past, for a number of coordinates.
    pub(super) fn new(coordinates: usize) -> Self {
        Self(Predictor::new(coordinates))
    }

    /// Records the leg of a step.
    pub(super) fn push(&mut self, d: &[f64]) {
        self.0.push(d);
    }
}

/// A system in the form that legs of any length need.
#[derive(Clone, Copy)]
pub(super) struct Momenta<'s> {
    /// Its tape.
    declaration: Declaration<'s>,
    /// Whether constraint forces act.
    constrained: bool,
}

impl<'s> Momenta<'s> {
    /// The legs of a system.
    pub(super) fn of(declaration: Declaration<'s>) -> Self {
        Self {
            constrained: declaration.constraints() != [0; 3],
            declaration,
        }
    }

    /// The node with a position and a velocity. If the equations have several accelerations, the one near a given one is taken.
    pub(super) fn start(
        &self,
        t: f64,
        (q, v): (Sum, Vector),
        near: Option<&[f64]>,
    ) -> Result<Node, SetupError> {
        let p = Vector::of(&start::momentum(&self.declaration, (t, &q.hi, &v)));
        self.node(t, (q, p, v), near)
    }

    /// The node with a position, a momentum and its velocity.
    pub(super) fn node(
        &self,
        t: f64,
        (q, p, v): (Sum, Vector, Vector),
        near: Option<&[f64]>,
    ) -> Result<Node, SetupError> {
        let (a, multipliers) = start::state(&self.declaration, (t, &q.hi, &v), near)?;
        let mut node = Node {
            t,
            q,
            p,
            v,
            a,
            force: Vector::default(),
            multipliers,
        };
        node.force = self.force(&node);
        Ok(node)
    }

    /// The constraint force at a node.
    fn force(&self, node: &Node) -> Vector {
        if self.constrained {
            Vector::of(&self.declaration.continuous_force(node.point()))
        } else {
            Vector::zero(node.v.len())
        }
    }

    /// Computes velocity and acceleration of a node without constraint forces: legs do not need them there.
    pub(super) fn complete(&self, node: &mut Node) -> Result<(), NewtonFailure> {
        if !self.constrained {
            let at = (node.t, &node.q.hi[..]);
            node.v = Vector::of(&start::velocity_of(&self.declaration, at, &node.p, &node.v));
            let at = (node.t, &node.q.hi[..], &node.v[..]);
            node.a = start::acceleration(&self.declaration, at, Some(&node.a))?.0;
        }
        Ok(())
    }

    /// The leg of the length `h` from a node to the time `t`. Returns the next node, the increment and the number of evaluations.
    pub(super) fn leg(
        &self,
        from: &Node,
        (h, t): (f64, f64),
        past: &LegPredictor,
    ) -> Result<(Node, Vector, u32), LegFailure> {
        let guess = match past.0.predict() {
            Some(d) if d.is_finite() => d,
            _ => from.ahead(h),
        };
        let found = self.leg_from(from, (h, t), guess, from);
        match found {
            Ok((node, d, iterations)) if iterations >= MANY => match self.lengthened(from, (h, t)) {
                Some(other) if is_same(&d, &other) => Ok((node, d, iterations)),
                _ => Err(LegFailure::Jump),
            },
            other => other,
        }
    }

    /// The increment of a leg, found by following the solution while the length grows from zero to `h`.
    fn lengthened(&self, from: &Node, (h, t): (f64, f64)) -> Option<Vector> {
        let (mut last, mut increment) = (from.clone(), Vector::zero(from.v.len()));
        let is_passable = little_by_little(|reached, next| {
            let time = if next < 1.0 { from.t + next * h } else { t };
            let beyond = last.ahead((next - reached) * h);
            let guess = increment.zip(&beyond, |increment, beyond| increment + beyond);
            match self.leg_from(from, (next * h, time), guess, &last) {
                Ok((node, d, iterations)) if iterations < MANY => {
                    (last, increment) = (node, d);
                    true
                }
                _ => false,
            }
        });
        is_passable.then_some(increment)
    }

    /// The leg, from a guess of its increment. Acceleration and multipliers at its end are searched near
    /// those of `near`.
    fn leg_from(
        &self,
        from: &Node,
        (h, t): (f64, f64),
        guess: Vector,
        near: &Node,
    ) -> Result<(Node, Vector, u32), LegFailure> {
        let leaving = from.p.zip(&from.force, |p, force| p + 0.5 * h * force);
        let (d, mut iterations) = self.increment(from, h, &leaving, guess)?;
        let rotations = &self.declaration.shape().rotations;
        if rotation::turns_too_far(rotations, &d).is_some() {
            return Err(not_solved(StepFailure::TurnsTooFar, &d, Vec::new(), Vec::new()));
        }
        let q = rotation::moved_sum(rotations, &from.q, &Sum::exact(d.clone()));
        let leg = AnyLeg { t, q: &q.hi, d: &d };
        let arriving = Vector::of(&self.declaration.arriving(h, leg)).map(|p| h * p);
        let mut node = Node {
            t,
            q,
            p: arriving.clone(),
            ..near.clone()
        };
        // the slope of the leg is the velocity at its middle
        node.v = d.zip(&near.a, |d, a| d / h + 0.5 * h * a);
        if self.constrained {
            iterations = iterations.max(self.kicked(&mut node, h, &arriving)?);
        }
        if !node.q.hi.is_finite() || !node.p.is_finite() {
            return Err(not_solved(StepFailure::NotFinite, &d, Vec::new(), Vec::new()));
        }
        Ok((node, d, iterations))
    }

    /// The increment `d` with `-D₁L_d(q, q + d) - f⁻_d = p`, by Newton's iteration, and the number of evaluations.
    fn increment(&self, from: &Node, h: f64, p: &[f64], mut d: Vector) -> Result<(Vector, u32), LegFailure> {
        let n = d.len();
        let mut progress = Progress::new();
        let scale = from.q.hi.map(|q| f64::EPSILON * q.abs());
        for iteration in 1..=MAX_ITERATIONS {
            let mut matrix = Square::zero(n);
            let mut left = Vector::nan(n);
            for j in 0..n {
                // the momentum at the beginning of a leg is minus that at the end of the reversed leg
                let back = OwnedLeg {
                    t: Tangent::splat(from.t),
                    q: map(&from.q.hi, Tangent::splat),
                    d: (0..n)
                        .map(|i| Tangent::new(-d[i], if i == j { -1.0 } else { 0.0 }))
                        .collect(),
                };
                let arriving = self.declaration.arriving(Tangent::splat(-h), back.any());
                for i in 0..n {
                    matrix.entries_mut()[i * n + j] = -h * arriving[i].derivative();
                    left[i] = -h * arriving[i].value() - p[i];
                }
            }
            let Some(update) = matrix.solve(&left) else {
                return Err(not_solved(
                    reason(matrix.entries(), &left),
                    &d,
                    left.to_vec(),
                    progress.updates,
                ));
            };
            let largest = relative(&update, &d, &scale);
            for (d, update) in d.iter_mut().zip(update.iter()) {
                *d -= update;
            }
            if progress.ends(largest) {
                return Ok((d, iteration));
            }
            if iteration == MAX_ITERATIONS {
                let left = left.to_vec();
                return Err(not_solved(StepFailure::NotConverged, &d, left, progress.updates));
            }
        }
        Err(not_solved(StepFailure::NotConverged, &d, Vec::new(), Vec::new()))
    }

    /// Computes momentum, velocity, acceleration and force at the end of a leg from its discrete momentum
    /// there, by one Newton iteration for all of them. Returns the number of evaluations.
    fn kicked(&self, node: &mut Node, h: f64, arriving: &Vector) -> Result<u32, LegFailure> {
        let n = arriving.len();
        let mut progress = Progress::new();
        for iteration in 1..=MAX_ITERATIONS {
            let at = node.clone();
            let point = at.point();
            let count = n + node.multipliers.len();
            let values = self
                .declaration
                .continuous_with_jacobian(point, &node.multipliers[..]);
            let (rows, jacobian) = values.split_at_checked(count).unwrap_or((&values, &[]));
            let jacobian = Square::from_fn(count, |i, j| {
                jacobian.get(i * count + j).copied().unwrap_or(f64::NAN)
            });
            let solve = |right: &[f64]| jacobian.solve(right);
            let force = self.declaration.continuous_force(point);
            let momentum = start::momentum(&self.declaration, (node.t, &node.q.hi, &node.v));
            let left = Vector::from_fn(n, |i| momentum[i] - arriving[i] - 0.5 * h * force[i]);
            let velocity = node.v.clone();
            let unsolved = |reason, progress: Progress| {
                let residual = left.iter().chain(rows).copied().collect();
                not_solved(reason, &velocity, residual, progress.updates)
            };
            let Some(straight) = solve(rows) else {
                return Err(unsolved(reason(&[], rows), progress));
            };
            // the effect of a change of the velocity on accelerations and multipliers, and on the residual of
            // the momentum
            let mass = start::mass_matrix(&self.declaration, node.t, &node.q.hi, &node.v);
            let mass = Square::from_fn(n, |i, j| mass[(i, j)]);
            let mut matrix = mass.clone();
            let mut columns = Vec::with_capacity(n);
            for j in 0..n {
                let moved = moving(point, |k| if k == j { 1.0 } else { 0.0 }, |_| 0.0);
                let multipliers: Vec<_> = node.multipliers.iter().map(|&x| Tangent::splat(x)).collect();
                let slopes: Vec<f64> = (self.declaration.continuous(moved.any(), &multipliers).iter())
                    .map(|row| row.derivative())
                    .collect();
                let Some(column) = solve(&slopes) else {
                    return Err(unsolved(StepFailure::Singular, progress));
                };
                // the velocity changes by the unit vector `j`, acceleration and multipliers as the constraints require
                let along = moving(
                    point,
                    |k| if k == j { 1.0 } else { 0.0 },
                    |k| -column.get(k).copied().unwrap_or(f64::NAN),
                );
                let force = self.declaration.continuous_force(along.any());
                for i in 0..n {
                    matrix.entries_mut()[i * n + j] -= 0.5 * h * force[i].derivative();
                }
                columns.push(column);
            }
            let toward = moving(point, |_| 0.0, |k| -straight.get(k).copied().unwrap_or(f64::NAN));
            let toward = self.declaration.continuous_force(toward.any());
            let right = Vector::from_fn(n, |i| -left[i] + 0.5 * h * toward[i].derivative());
            let Some(dv) = matrix.solve(&right) else {
                return Err(unsolved(reason(matrix.entries(), &right), progress));
            };
            let dz: Vec<f64> = (0..count)
                .map(|k| {
                    let through = columns.iter().zip(dv.iter());
                    through.fold(-straight[k], |sum, (column, dv)| sum - column[k] * dv)
                })
                .collect();
            let of_rounding = node.q.hi.map(|q| f64::EPSILON * (q / h).abs());
            let da = Vector::of(&dz[..n]);
            let of_velocity = node.v.map(|v| f64::EPSILON * (v / h).abs());
            let largest = relative(&dv, &node.v, &of_rounding).max(relative(&da, &node.a, &of_velocity));
            for i in 0..n {
                node.v[i] += dv[i];
                node.a[i] += da[i];
            }
            for (multiplier, change) in node.multipliers.iter_mut().zip(&dz[n..]) {
                *multiplier += change;
            }
            if progress.ends(largest) {
                // a determinant with another sign than that of the mass matrix, which is the limit for short legs, shows a singularity on the
                // leg
                let turns = |matrix: &Square| matrix.determinant().value < 0.0;
                if turns(&matrix) != turns(&mass) {
                    return Err(LegFailure::Singularity);
                }
                node.force = self.force(node);
                node.p = arriving.zip(&node.force, |arriving, force| arriving + 0.5 * h * force);
                return Ok(iteration);
            }
            if iteration == MAX_ITERATIONS {
                return Err(unsolved(StepFailure::NotConverged, progress));
            }
        }
        Err(not_solved(
            StepFailure::NotConverged,
            &node.v,
            Vec::new(),
            Vec::new(),
        ))
    }
}

impl Node {
    /// The point of the continuous system.
    pub(super) fn point(&self) -> AnyPoint<'_, f64> {
        AnyPoint {
            t: self.t,
            q: &self.q.hi,
            v: &self.v,
            a: &self.a,
        }
    }

    /// The displacement of the node in the time `h`, by its velocity and acceleration.
    fn ahead(&self, h: f64) -> Vector {
        self.v.zip(&self.a, |v, a| h * (v + 0.5 * h * a))
    }
}

/// The progress of Newton's iteration.
struct Progress {
    /// The updates, relative to the unknowns.
    updates: Vec<f64>,
}

impl Progress {
    fn new() -> Self {
        Self { updates: Vec::new() }
    }

    /// Whether the iteration ends with this update.
    fn ends(&mut self, update: f64) -> bool {
        let last = self.updates.last().copied().unwrap_or(f64::INFINITY);
        self.updates.push(update);
        update <= LAST || update <= ROUNDING && update >= 0.5 * last
    }
}

/// The largest component of an update, relative to the size of its unknown, which is at least a part of the
/// largest unknown and the rounding.
fn relative(update: &[f64], unknown: &[f64], rounding: &[f64]) -> f64 {
    let most = unknown.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let parts = (0..update.len()).map(|i| match update[i].abs() {
        0.0 => 0.0,
        update => update / unknown[i].abs().max(LEAST * most).max(rounding[i] / LAST),
    });
    parts.fold(0.0, larger)
}

/// A point whose time stays fixed, with rates of position, velocity and acceleration.
fn moving(
    point: AnyPoint<'_, f64>,
    v: impl Fn(usize) -> f64,
    a: impl Fn(usize) -> f64,
) -> OwnedPoint<Tangent> {
    let along = |x: &[f64], by: &dyn Fn(usize) -> f64| -> Vec<Tangent> {
        let numbers = x.iter().enumerate();
        numbers.map(|(k, &x)| Tangent::new(x, by(k))).collect()
    };
    let mut values = map(point.q, Tangent::splat);
    values.extend(along(point.v, &v));
    values.extend(along(point.a, &a));
    values.push(Tangent::splat(point.t));
    OwnedPoint::new(point.q.len(), values)
}

/// The reason why linear equations have no solution.
fn reason(matrix: &[f64], right: &[f64]) -> StepFailure {
    if is_finite(matrix) && is_finite(right) {
        StepFailure::Singular
    } else {
        StepFailure::NotFinite
    }
}

/// The failure of an iteration.
fn not_solved(reason: StepFailure, unknowns: &[f64], residual: Vec<f64>, updates: Vec<f64>) -> LegFailure {
    LegFailure::NotSolved(NewtonFailure {
        reason,
        unknowns: unknowns.to_vec(),
        residual,
        updates,
        other: Vec::new(),
    })
}
