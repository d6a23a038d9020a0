//! Places on the path of a motion, and the solution of the equations there: the acceleration or, in third
//! order, the jerk.

use super::{Determined, determined, third};
use crate::number::point::{AnyLeg, AnyPoint};
use crate::regularity::deficiency::{self, Deficiency};
use crate::solve::{Square, Vector, rotation};
use crate::tape::declaration::{Declaration, Steep, TableAt};

/// A place on the path of a step.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    /// The time.
    pub t: f64,
    /// The position.
    pub q: Vector,
    /// The velocity.
    pub v: Vector,
    /// In third order, the acceleration, which the equations leave free; else empty.
    pub a: Vector,
}

/// A path: the place at a part of it, from 0 to 1 and slightly beyond.
pub(crate) type MotionPath<'a> = dyn Fn(f64) -> Place + 'a;

impl Place {
    /// A place on a motion of second order, without an acceleration.
    pub fn of_phase(t: f64, q: Vector, v: Vector) -> Self {
        Self {
            t,
            q,
            v,
            a: Vector::zero(0),
        }
    }

    /// The place on the cubic polynomial through four nodes, `steps` steps `h` after the third: from the
    /// increment and the second difference that end there, and the third difference `e` to the fourth.
    pub fn on_cubic(h: f64, leg: AnyLeg<'_, f64>, second: &[f64], e: &[f64], steps: f64) -> Self {
        let s = steps;
        let of = |i: usize| (leg.d[i], second[i] + e[i], e[i]);
        let n = e.len();
        Self {
            t: leg.t + s * h,
            q: Vector::from_fn(n, |i| {
                let (d, c, e) = of(i);
                leg.q[i] + s * (d + 0.5 * (s + 1.0) * (c + (s - 1.0) / 3.0 * e))
            }),
            v: Vector::from_fn(n, |i| {
                let (d, c, e) = of(i);
                (d + (s + 0.5) * c + (0.5 * s * s - 1.0 / 6.0) * e) / h
            }),
            a: Vector::from_fn(n, |i| {
                let (_, c, e) = of(i);
                (c + s * e) / (h * h)
            }),
        }
    }

    /// The place at a part `x` of the way between two points: on the cubic polynomial with the positions and velocities of
    /// both. For a rotation, one for its quaternion and one for its angular velocity, with the accelerations.
    pub fn on_hermite(rotations: &[usize], [from, to]: [AnyPoint<'_, f64>; 2], x: f64) -> Self {
        let h = to.t - from.t;
        let along = |i: usize| cubic([from.q[i], to.q[i]], [from.v[i], to.v[i]].map(|v| h * v), x);
        let n = from.q.len();
        let (mut q, mut v) = (Vector::zero(n), Vector::zero(n));
        for i in 0..n {
            let [place, rate] = along(i);
            (q[i], v[i]) = (place, rate / h);
        }
        for &first in rotations {
            let ends = [from, to].map(|point| rotation::rates(first, [point.q, point.v, point.a]));
            let [[start, begins, _], [end, arrives, _]] = ends;
            for k in 0..rotation::SLOTS {
                let i = first + k;
                q[i] = cubic([start[k], end[k]], [h * begins[k], h * arrives[k]], x)[0];
                v[i] = cubic([from.v[i], to.v[i]], [h * from.a[i], h * to.a[i]], x)[0];
            }
        }
        rotation::keep_norm(rotations, [&mut q, &mut Vector::zero(n)]);
        Self::of_phase(from.t + x * h, q, v)
    }

    /// A place between this one and another, or beyond it, by linear interpolation; quaternions are
    /// normalised.
    pub fn towards(&self, rotations: &[usize], other: &Self, part: f64) -> Self {
        let between = |from: &Vector, to: &Vector| from.zip(to, |from, to| from + part * (to - from));
        let mut q = between(&self.q, &other.q);
        rotation::unit(rotations, &mut q);
        Self {
            t: self.t + part * (other.t - self.t),
            q,
            v: between(&self.v, &other.v),
            a: between(&self.a, &other.a),
        }
    }

    /// The acceleration here (in third order the jerk), searched near another one, then the multipliers or
    /// their rates; `None` if there is none.
    pub fn solve(&self, declaration: &Declaration<'_>, near: &[f64]) -> Option<Determined> {
        if declaration.shape().is_of_third_order() {
            third::determined(declaration, self.t, [&self.q, &self.v, &self.a], near)
        } else {
            determined(declaration, (self.t, &self.q, &self.v), near)
        }
    }

    /// The point with an acceleration that was found here, and the multipliers behind it.
    pub fn with<'p>(&'p self, motion: &'p [f64]) -> (AnyPoint<'p, f64>, &'p [f64]) {
        let (a, multipliers) = motion.split_at(self.q.len().min(motion.len()));
        let (t, q, v) = (self.t, &self.q[..], &self.v[..]);
        (AnyPoint { t, q, v, a }, multipliers)
    }

    /// The effect of the equations' rounding errors on accelerations and multipliers that were found here; `None` if the equations are singular.
    pub fn rounding(&self, declaration: &Declaration<'_>, motion: &[f64]) -> Option<Vector> {
        let (point, multipliers) = self.with(motion);
        let size = motion.len();
        let (mut bounds, mut rows, mut jacobian) =
            (Vector::zero(size), Vector::nan(size), Square::zero(size));
        declaration.continuous_bounds(point, multipliers, &mut bounds);
        declaration.linearize_continuous(point, multipliers, &mut rows, jacobian.entries_mut());
        let mut rounding = Vector::zero(size);
        for (row, bound) in bounds.iter().enumerate() {
            let one = Vector::from_fn(size, |i| if i == row { *bound } else { 0.0 });
            rounding = rounding.zip(&jacobian.solve(&one)?, |rounding, by| rounding + by.abs());
        }
        Some(rounding)
    }

    /// The deficiency or near-deficiency of the equations at a solution that was found here.
    pub fn deficiency(&self, declaration: &Declaration<'_>, found: &Determined) -> Option<Deficiency> {
        if declaration.shape().is_of_third_order() {
            return third::deficiency(declaration, self.t, [&self.q, &self.v, &self.a], &found.motion);
        }
        deficiency::near_point(declaration, self.with(&found.motion).0)
    }

    /// The arguments of piecewise functions.
    pub fn arguments(&self, declaration: &Declaration<'_>) -> Vec<f64> {
        declaration.switch_arguments(self.t, &self.q, &self.v, &self.a)
    }

    /// The functions that may be flat but for a narrow feature.
    pub fn steep(&self, declaration: &Declaration<'_>) -> Vec<Steep> {
        declaration.steep(self.t, &self.q, &self.v, &self.a)
    }

    /// The tables of samples, with their arguments here.
    pub fn tables<'d>(&self, declaration: &Declaration<'d>) -> Vec<TableAt<'d>> {
        declaration.tables(self.t, &self.q, &self.v, &self.a)
    }
}

/// The cubic polynomial with values and slopes at both ends, at a part `x` of the path, and its slope there.
pub(crate) fn cubic([from, to]: [f64; 2], [begins, arrives]: [f64; 2], x: f64) -> [f64; 2] {
    let (d, y) = (to - from, 1.0 - x);
    [
        from + (x * x * (3.0 - 2.0 * x) * d + x * y * y * begins - x * x * y * arrives),
        6.0 * x * y * d + y * (1.0 - 3.0 * x) * begins + x * (3.0 * x - 2.0) * arrives,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cubic_has_its_nodes_and_their_differences() {
        // x = 2 - 3 s + s² - s³/2 at s = -2, -1, 0, 1
        let x = |s: f64| 2.0 - 3.0 * s + s * s - 0.5 * s * s * s;
        let d = x(0.0) - x(-1.0);
        let second = d - (x(-1.0) - x(-2.0));
        let e = (x(1.0) - x(0.0) - d) - second;
        let leg = AnyLeg {
            t: 7.0,
            q: &[x(0.0)],
            d: &[d],
        };
        let h = 0.5;
        for s in [-2.0, -1.3, -0.5, 0.0, 0.4, 1.0] {
            let place = Place::on_cubic(h, leg, &[second], &[e], s);
            let v = (-3.0 + 2.0 * s - 1.5 * s * s) / h;
            let a = (2.0 - 3.0 * s) / (h * h);
            assert!((place.t - 7.0 - s * h).abs() < 1e-12);
            assert!((place.q[0] - x(s)).abs() < 1e-12, "{s}");
            assert!((place.v[0] - v).abs() < 1e-12, "{s}");
            assert!((place.a[0] - a).abs() < 1e-12, "{s}");
        }
    }
}
