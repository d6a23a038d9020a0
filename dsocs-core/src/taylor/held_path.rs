//! A motion at rest on surfaces, as a polynomial through Chebyshev points.

use crate::number::fours::on_doubles;
use crate::number::larger;
use crate::regularity::resting::Held;
use crate::solve::Vector;
use crate::solve::rotation::{self, SLOTS};

/// The degree of the acceleration.
pub(super) const DEGREE: usize = 14;

/// The number of its coefficients, and of points.
pub(super) const COUNT: usize = DEGREE + 1;

/// The number of coefficients of a quaternion, as of a position.
pub(super) const TURNS: usize = COUNT + 2;

/// A polynomial motion from the current point on. The attitude of a body is a polynomial, too, as far as the
/// series of its quaternion goes: it follows from the angular velocity by `q' = ½ q∘(0, ω)`.
pub(super) struct HeldPath {
    /// Its length.
    pub(super) h: f64,
    /// The coefficients of the acceleration of each coordinate, in powers of the part of the path.
    pub(super) accelerations: Vec<[f64; COUNT]>,
    /// The coefficients of the quaternions of rotations, each with the first place of the rotation.
    pub(super) quaternions: Vec<(usize, [[f64; SLOTS]; TURNS])>,
    /// The coefficients of each side.
    pub(super) sides: Vec<[f64; COUNT]>,
    /// The error, in units of the allowed error.
    pub(super) error: f64,
    /// The motion at the end.
    pub(super) end: Held,
}

/// The Chebyshev points from 0 to 1.
pub(super) fn place(j: usize) -> f64 {
    let angle = core::f64::consts::PI * j as f64 / DEGREE as f64;
    // as a square, which is accurate near both ends
    let half = (0.5 * angle).sin();
    half * half
}

/// The coefficients of the polynomial with given values at the Chebyshev points: in powers of the place, and
/// the size of the last two in Chebyshev polynomials.
pub(super) fn coefficients(values: &[f64; COUNT]) -> ([f64; COUNT], f64) {
    let mut powers = [0.0; COUNT];
    // Chebyshev's polynomials of 2x - 1 by powers of x, one after the other
    let (mut before, mut polynomial) = ([0.0; COUNT], [0.0; COUNT]);
    polynomial[0] = 1.0;
    let mut tail = 0.0;
    for k in 0..COUNT {
        let end = |j: usize| if j == 0 || j == DEGREE { 0.5 } else { 1.0 };
        let terms = values.iter().enumerate().map(|(j, value)| {
            let turns = (k * (DEGREE - j)) % (2 * DEGREE);
            end(j) * value * (core::f64::consts::PI * turns as f64 / DEGREE as f64).cos()
        });
        let c = end(k) * 2.0 / DEGREE as f64 * terms.sum::<f64>();
        if k + 2 > DEGREE {
            tail += c.abs();
        }
        for (power, p) in powers.iter_mut().zip(&polynomial) {
            *power += c * p;
        }
        let mut next = [0.0; COUNT];
        for i in 0..COUNT {
            let shifted = if i > 0 { polynomial[i - 1] } else { 0.0 };
            next[i] = if k == 0 {
                2.0 * shifted - polynomial[i]
            } else {
                4.0 * shifted - 2.0 * polynomial[i] - before[i]
            };
        }
        (before, polynomial) = (polynomial, next);
    }
    (powers, tail)
}

impl HeldPath {
    /// The coefficients of a velocity in powers of the part of the path.
    pub(super) fn velocity(&self, i: usize, v: f64) -> [f64; COUNT + 1] {
        let mut velocity = [v; COUNT + 1];
        for (k, (to, a)) in velocity
            .iter_mut()
            .skip(1)
            .zip(&self.accelerations[i])
            .enumerate()
        {
            *to = self.h * a / (k as f64 + 1.0);
        }
        velocity
    }

    /// Computes the attitudes from a position and a velocity.
    pub(super) fn turn(&mut self, rotations: &[usize], q: &[f64], v: &[f64]) {
        self.quaternions.clear();
        for &first in rotations {
            let spin: [[f64; COUNT + 1]; SLOTS] =
                core::array::from_fn(|k| self.velocity(first + k, v[first + k]));
            let mut quaternion = [[0.0; SLOTS]; TURNS];
            quaternion[0] = core::array::from_fn(|k| q[first + k]);
            for k in 1..TURNS {
                let known = quaternion;
                let term = |j: usize| [known[j], spin.map(|component| component[k - 1 - j])];
                let next = rotation::Coefficient {
                    scale: self.h / k as f64,
                    pairs: (0..k / 2).map(|j| [term(2 * j), term(2 * j + 1)]),
                    last: (k % 2 == 1).then(|| term(k - 1)),
                };
                quaternion[k] = on_doubles::<false, _>(next);
            }
            self.quaternions.push((first, quaternion));
        }
    }

    /// The truncation error of the series of quaternions, relative to their norm.
    pub(super) fn truncated(&self) -> f64 {
        let last = self
            .quaternions
            .iter()
            .flat_map(|(_, series)| &series[TURNS - 2..]);
        last.flatten().fold(0.0, |most, c| larger(most, c.abs()))
    }

    /// The series of the quaternion that contains a place, and the component of the place.
    pub(super) fn quaternion(&self, i: usize) -> Option<(&[[f64; SLOTS]; TURNS], usize)> {
        let mut all = self.quaternions.iter();
        all.find_map(|(first, series)| {
            let k = i.checked_sub(*first)?;
            (k < SLOTS).then_some((series, k))
        })
    }

    /// The displacements of position and velocity in a part `x` of the path from the velocity `v`, in one
    /// coordinate.
    pub(super) fn moves(&self, i: usize, v: f64, x: f64) -> [f64; 2] {
        let (mut q, mut dv) = (0.0, 0.0);
        for (k, a) in self.accelerations[i].iter().enumerate().rev() {
            let k = k as f64;
            q = q * x + a / ((k + 1.0) * (k + 2.0));
            dv = dv * x + a / (k + 1.0);
        }
        let s = x * self.h;
        if let Some((series, k)) = self.quaternion(i) {
            let turned = series[1..].iter().rev().fold(0.0, |sum, c| (sum + c[k]) * x);
            return [turned, s * dv];
        }
        [s * (v + s * q), s * dv]
    }

    /// Position and velocity at a part `x` of the path.
    pub(super) fn at(&self, (q, v): (&[f64], &[f64]), x: f64) -> (Vector, Vector) {
        let moves: Vec<[f64; 2]> = (0..q.len()).map(|i| self.moves(i, v[i], x)).collect();
        (
            Vector::from_fn(q.len(), |i| q[i] + moves[i][0]),
            Vector::from_fn(q.len(), |i| v[i] + moves[i][1]),
        )
    }
}
