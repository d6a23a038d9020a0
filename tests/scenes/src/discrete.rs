//! The second formulation of a step: the discrete action of three nodes is stationary at the middle one, up
//! to the constraint forces.
//!
//! Nothing here comes from the attribute or from the solver. All numbers have twice the precision of `f64`.
//! Derivatives of the action are exact; those of Newton's iteration are difference quotients.

use super::double::Double;
use super::elimination::Decomposed;
use super::number::{Dual, Number};
use super::scene::{Map, Scene};

/// The step of difference quotients, relative to the number: half of the digits of a [`Double`].
const NUDGE: f64 = 1e-14;

/// An update below this part of the nodes is rounding.
const ROUNDING: f64 = 1e-27;

/// The short step of `continuous`, relative to the step, where constraints bind pairs of nodes: short enough
/// for the continuous motion, and long enough for the rounding of the nodes in these constraints.
const SHORT: f64 = 1e-2;

/// The short step of `continuous` without such constraints. A Lyapunov constraint on a joint that hardly
/// moves has two solutions in a step, which only a very short step separates.
const VERY_SHORT: f64 = 1e-4;

/// A step is resolved if the second update of Newton's iteration, begun at the continuous motion, is at most
/// this part of the first.
const RESOLVED: f64 = 0.05;

/// The largest change of an angle in a resolved step [rad].
const TURN: f64 = 0.5;

/// The largest number of updates.
const UPDATES: usize = 60;

/// A leg: a node and the increment that led to it.
#[derive(Clone, Debug)]
pub struct Leg {
    /// The node.
    pub q: Vec<Double>,
    /// The increment.
    pub d: Vec<Double>,
}

impl Leg {
    /// The leg between two nodes.
    #[must_use]
    pub fn between(q0: &[f64], q1: &[f64]) -> Self {
        let q: Vec<Double> = q1.iter().copied().map(Double::exact).collect();
        let d = q.iter().zip(q0).map(|(q, q0)| *q - Double::exact(*q0));
        Self {
            d: d.collect(),
            q: q.clone(),
        }
    }

    /// The leg after a step with the second difference `e`.
    #[must_use]
    pub fn next(&self, e: &[Double]) -> Self {
        let d = add(&self.d, e);
        Self {
            q: add(&self.q, &d),
            d,
        }
    }
}

/// The sum of two vectors.
#[must_use]
pub fn add(x: &[Double], y: &[Double]) -> Vec<Double> {
    x.iter().zip(y).map(|(x, y)| *x + *y).collect()
}

/// A vector times a number.
fn times(x: &[Double], by: f64) -> Vec<Double> {
    x.iter().map(|x| *x * Double::exact(by)).collect()
}

/// The difference of two nodes over the step.
fn velocity<T: Number>(q0: &[T], q1: &[T], h: f64) -> Vec<T> {
    let pairs = q0.iter().zip(q1);
    pairs.map(|(q0, q1)| (*q1 - *q0) / T::of(h)).collect()
}

/// The mean of two nodes.
fn middle<T: Number>(q0: &[T], q1: &[T]) -> Vec<T> {
    let pairs = q0.iter().zip(q1);
    pairs.map(|(q0, q1)| (*q0 + *q1) * T::of(0.5)).collect()
}

/// The equations of a step.
#[derive(Clone, Debug)]
pub struct Step<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The step.
    pub h: f64,
    /// The leg that it begins with.
    pub leg: &'a Leg,
}

impl Step<'_> {
    /// The number of unknowns: the second difference, then a multiplier for each constraint.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.scene.coordinates + self.scene.constraints()
    }

    /// The discrete Lagrangian.
    fn discrete_lagrangian<T: Number>(&self, q0: &[T], q1: &[T]) -> T {
        let v = velocity(q0, q1, self.h);
        match self.scene.map {
            Map::Paper => self.scene.lagrangian(q0, &v),
            Map::Midpoint => self.scene.lagrangian(&middle(q0, q1), &v),
            Map::Trapezoid => (self.scene.lagrangian(q0, &v) + self.scene.lagrangian(q1, &v)) * T::of(0.5),
        }
    }

    /// The residuals of the constraints on positions and velocities at the pair of nodes `q1`, `q2`.
    #[must_use]
    pub fn pair(&self, q1: &[Double], q2: &[Double]) -> Vec<Double> {
        let mut rows = self.scene.holonomic(q2);
        let v = velocity(q1, q2, self.h);
        rows.extend(match self.scene.map {
            Map::Paper => self.scene.nonholonomic(q1, &v),
            Map::Midpoint => self.scene.nonholonomic(&middle(q1, q2), &v),
            Map::Trapezoid => times(
                &add(&self.scene.nonholonomic(q1, &v), &self.scene.nonholonomic(q2, &v)),
                0.5,
            ),
        });
        rows
    }

    /// The first and the third node.
    fn outer(&self, e: &[Double]) -> [Vec<Double>; 2] {
        let back = times(&self.leg.d, -1.0);
        [add(&self.leg.q, &back), self.leg.next(e).q]
    }

    /// `D₁L_d(q1, q2) + D₂L_d(q0, q1)`: the derivative of the action by the middle node.
    #[must_use]
    pub fn action(&self, e: &[Double]) -> Vec<Double> {
        let [q0, q2] = self.outer(e).map(|q| Dual::fixed(&q));
        let by = |i| {
            let q1 = Dual::at(&self.leg.q, i);
            (self.discrete_lagrangian(&q0, &q1) + self.discrete_lagrangian(&q1, &q2)).slope
        };
        (0..self.scene.coordinates).map(by).collect()
    }

    /// The constraints: rods and wheels, then the motor.
    #[must_use]
    pub fn constraints(&self, e: &[Double]) -> Vec<Double> {
        let next = self.leg.next(e);
        let mut rows = self.pair(&self.leg.q, &next.q);
        let square = Double::exact(self.h) * Double::exact(self.h);
        let a: Vec<Double> = e.iter().map(|e| *e / square).collect();
        rows.extend(self.scene.kinematic(&self.leg.q, &self.central(e), &a));
        rows
    }

    /// The velocity at the middle node.
    fn central(&self, e: &[Double]) -> Vec<Double> {
        let sums = self.leg.d.iter().zip(e);
        sums.map(|(d, e)| (*d + *d + *e) / (Double::exact(2.0) * Double::exact(self.h)))
            .collect()
    }

    /// The directions of the constraint forces, one for each constraint: by d'Alembert's rule, and along the
    /// motor's joint.
    #[must_use]
    pub fn forms(&self, e: &[Double]) -> Vec<Vec<Double>> {
        self.scene.forms(&self.leg.q, &self.central(e))
    }

    /// The residuals at a second difference and multipliers: the balance of forces, then the constraints.
    #[must_use]
    pub fn rows(&self, z: &[Double]) -> Vec<Double> {
        let (e, multipliers) = z.split_at(self.scene.coordinates);
        let mut rows = self.action(e);
        for (form, &multiplier) in self.forms(e).iter().zip(multipliers) {
            for (row, &form) in rows.iter_mut().zip(form) {
                *row = *row + multiplier * form;
            }
        }
        rows.extend(self.constraints(e));
        rows
    }

    /// The scales of the second differences.
    fn sizes(&self, z: &[Double]) -> Vec<f64> {
        let n = self.scene.coordinates;
        let longest = self
            .leg
            .d
            .iter()
            .fold(0.0_f64, |longest, d| longest.max(d.high.abs()));
        let size = |i: usize| {
            let own = z[i].high.abs();
            if i < n {
                own.max(self.leg.d[i].high.abs()).max(1e-6 * longest)
            } else {
                own.max(1e-300)
            }
        };
        (0..z.len()).map(size).collect()
    }

    /// The derivatives of the rows by the unknowns, row by row.
    #[must_use]
    pub fn jacobian(&self, z: &[Double], rows: &[Double]) -> Vec<Vec<Double>> {
        let n = self.scene.coordinates;
        let mut jacobian = vec![vec![Double::ZERO; z.len()]; z.len()];
        let e = &z[..n];
        for (j, size) in self.sizes(z).into_iter().enumerate().take(n) {
            let nudge = Double::exact(NUDGE * if size > 0.0 { size } else { 1.0 });
            let mut moved = z.to_vec();
            moved[j] = moved[j] + nudge;
            for (i, row) in self.rows(&moved).into_iter().enumerate() {
                jacobian[i][j] = (row - rows[i]) / nudge;
            }
        }
        for (j, form) in self.forms(e).into_iter().enumerate() {
            for (i, form) in form.into_iter().enumerate() {
                jacobian[i][n + j] = form;
            }
        }
        jacobian
    }

    /// The sizes of the terms of each row on which rounding acts: the effects of a unit relative error in the
    /// node, the increment, the second difference and the multipliers.
    #[must_use]
    pub fn terms(&self, z: &[Double], jacobian: &[Vec<Double>]) -> Vec<f64> {
        let rows = self.rows(z);
        let mut terms: Vec<f64> = jacobian
            .iter()
            .map(|row| row.iter().zip(z).map(|(x, z)| (x.high * z.high).abs()).sum())
            .collect();
        for by_node in [true, false] {
            for j in 0..self.scene.coordinates {
                let mut leg = self.leg.clone();
                let part = if by_node { &mut leg.q[j] } else { &mut leg.d[j] };
                let nudge = Double::exact(NUDGE) * *part;
                *part = *part + nudge;
                let moved = Step { leg: &leg, ..*self }.rows(z);
                for (term, (moved, row)) in terms.iter_mut().zip(moved.iter().zip(&rows)) {
                    *term += ((*moved - *row).high / NUDGE).abs();
                }
            }
        }
        terms
    }

    /// Plain Newton iteration from `z`; `None` if it does not converge.
    #[must_use]
    pub fn solve(&self, z: &[Double]) -> Option<Solution> {
        let mut z = z.to_vec();
        let mut before = f64::INFINITY;
        for _ in 0..UPDATES {
            let rows = self.rows(&z);
            let decomposed = Decomposed::new(self.jacobian(&z, &rows))?;
            let update = decomposed.solve(&rows);
            let size = self.relative(&update, &z);
            for (z, update) in z.iter_mut().zip(&update) {
                *z = *z - *update;
            }
            if size < ROUNDING || (size < 1e-20 && size > 0.1 * before) {
                let jacobian = self.jacobian(&z, &self.rows(&z));
                let decomposed = Decomposed::new(jacobian.clone())?;
                return Some(Solution {
                    z,
                    jacobian,
                    decomposed,
                });
            }
            if !size.is_finite() {
                return None;
            }
            before = size;
        }
        None
    }

    /// The size of an update of the second difference, relative to the legs.
    fn relative(&self, update: &[Double], z: &[Double]) -> f64 {
        let n = self.scene.coordinates;
        let sizes = self.leg.d.iter().chain(&z[..n]);
        let longest = sizes.fold(0.0_f64, |longest, x| longest.max(x.high.abs()));
        (0..n).fold(0.0, |largest, i| {
            let size =
                self.leg.d[i].high.abs() + z[i].high.abs() + 1e-3 * longest + 1e-9 * self.leg.q[i].high.abs();
            let ratio = update[i].high.abs() / size.max(1e-300);
            if ratio <= largest { largest } else { ratio }
        })
    }

    /// The approximate unknowns of the continuous motion, its acceleration and forces: those of a much
    /// shorter step.
    #[must_use]
    pub fn continuous(&self) -> Option<Vec<Double>> {
        let n = self.scene.coordinates;
        let part = if self.scene.lower() > 0 { SHORT } else { VERY_SHORT };
        let leg = Leg {
            q: self.leg.q.clone(),
            d: times(&self.leg.d, part),
        };
        let short = Step {
            leg: &leg,
            h: self.h * part,
            ..*self
        };
        let mut z = short.solve(&vec![Double::ZERO; self.unknowns()])?.z;
        for e in &mut z[..n] {
            *e = *e / Double::exact(part * part);
        }
        Some(z)
    }

    /// Whether the step is short enough to have one solution nearby: Newton's iteration from the continuous
    /// motion, `guess`, nearly ends with its first update, and no angle changes by more than `TURN`.
    #[must_use]
    pub fn is_resolved(&self, guess: &[Double]) -> bool {
        let turns = self.scene.angles().into_iter().all(|angle| {
            let d = self.leg.d[angle].high;
            d.abs() < TURN && (d + guess[angle].high).abs() < TURN
        });
        turns && self.contraction(guess) < RESOLVED
    }

    /// The size of the second update of a plain Newton iteration relative to the first: small where the
    /// equations are nearly linear between `z` and their root.
    fn contraction(&self, z: &[Double]) -> f64 {
        let mut z = z.to_vec();
        let mut sizes = [0.0; 2];
        for size in &mut sizes {
            let rows = self.rows(&z);
            let Some(decomposed) = Decomposed::new(self.jacobian(&z, &rows)) else {
                return f64::INFINITY;
            };
            let update = decomposed.solve(&rows);
            for (z, update) in z.iter_mut().zip(&update) {
                *z = *z - *update;
            }
            *size = self.relative(&update, &z);
        }
        if sizes[1] == 0.0 { 0.0 } else { sizes[1] / sizes[0] }
    }
}

/// A solution of a step.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The second difference and the multipliers.
    pub z: Vec<Double>,
    /// The derivatives of the rows there.
    pub jacobian: Vec<Vec<Double>>,
    /// The decomposition of these derivatives.
    pub decomposed: Decomposed<Double>,
}
