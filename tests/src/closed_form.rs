//! Closed forms for the two systems of the paper, without any code of this workspace.
//!
//! Sources: sections 1 and 2 of the README beside the reference data.

use std::f64::consts::{FRAC_PI_4, SQRT_2};

/// The nodes of the particle's discrete motion for constant curvature 1, from the origin.
///
/// All chords have one length `s`, and each is the one before, turned by `α` with
/// `sin(α/2) = s/(1 + √(1 + s²))`. So the nodes lie on a circle, and the sum of the chords is a geometric series.
#[derive(Clone, Copy, Debug)]
pub struct Polygon {
    chord: [f64; 2],
    half_angle: f64,
}

impl Polygon {
    /// The polygon whose first chord is `chord`.
    #[must_use]
    pub fn new(chord: [f64; 2]) -> Self {
        let length = chord[0].hypot(chord[1]);
        Self {
            chord,
            half_angle: (length / (1.0 + 1.0_f64.hypot(length))).asin(),
        }
    }

    /// The polygon of the paper's start from the origin with the velocity (1, 1).
    #[must_use]
    pub fn paper(h: f64) -> Self {
        Self::new([h, h])
    }

    /// Node number `k`.
    #[must_use]
    pub fn node(&self, k: u64) -> [f64; 2] {
        if k == 0 {
            return [0.0; 2];
        }
        // d (1 + r + … + rᵏ⁻¹) with r = exp(iα)
        let angle = k as f64 * self.half_angle;
        let stretch = angle.sin() / self.half_angle.sin();
        let (sin, cos) = (angle - self.half_angle).sin_cos();
        let [x, y] = self.chord;
        [stretch * (cos * x - sin * y), stretch * (sin * x + cos * y)]
    }
}

/// The particle's exact motion for curvature 1 from the origin with the velocity (1, 1).
#[must_use]
pub fn particle(t: f64) -> [f64; 2] {
    let (sin, cos) = (SQRT_2 * t - FRAC_PI_4).sin_cos();
    [cos - SQRT_2 / 2.0, sin + SQRT_2 / 2.0]
}

/// The pendulum with the paper's parameters, factored by hand: `w (r₂ − T(θ, ψ) + ρ tanh w) = 0`.
pub mod pendulum {
    /// Moment of inertia of the pendulum.
    pub const I: f64 = 312.5;
    /// Moment of inertia of the wheel.
    pub const J: f64 = 2.0772;
    /// Weight times distance.
    pub const M: f64 = 37.98;
    const D: f64 = 1.0;
    const E: f64 = 1000.0;
    const CHI: f64 = 100.0;
    const N: f64 = -154.0;
    /// The strength of the dissipation.
    pub const RHO: f64 = 2.0;

    /// The entries `a = −b` and `c` of the inverse mass matrix.
    const A: f64 = 1.0 / I;
    const B: f64 = -1.0 / I;
    const C: f64 = 1.0 / I + 1.0 / J;
    const DETERMINANT: f64 = 1.0 / (I * J);

    /// The first coefficient of `w = g p₁ + k p₂`.
    const G: f64 = D * (N * A - B) / DETERMINANT;
    /// The second coefficient of `w = g p₁ + k p₂`.
    pub const K: f64 = D * (N * B - C) / DETERMINANT;

    /// The start of the paper.
    pub const START: ([f64; 2], [f64; 2]) = ([0.5, 0.0], [0.0, 0.5]);

    /// `w` at a velocity.
    #[must_use]
    pub fn w(v: [f64; 2]) -> f64 {
        G * ((I + J) * v[0] + J * v[1]) + K * J * (v[0] + v[1])
    }

    /// `T(θ, ψ)`.
    #[must_use]
    pub fn t(q: [f64; 2]) -> f64 {
        CHI * (DETERMINANT / D) * (q[1] - N * q[0]).sin() - M * q[0].sin() * (G / K + E * B / (D * K))
    }

    /// The Lyapunov function.
    #[must_use]
    pub fn lyapunov(q: [f64; 2], v: [f64; 2]) -> f64 {
        let (p1, p2) = ((I + J) * v[0] + J * v[1], J * (v[0] + v[1]));
        let f = (G * G + E) / K;
        f * p1 * p1 / 2.0
            + K * p2 * p2 / 2.0
            + G * p1 * p2
            + CHI * (1.0 - (q[1] - N * q[0]).cos())
            + M * E / D * (1.0 - q[0].cos())
    }

    /// The acceleration of the continuous system on the proper branch.
    #[must_use]
    pub fn acceleration(q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        let (r1, r2) = (M * q[0].sin(), t(q) - RHO * w(v).tanh());
        [A * r1 + B * r2, B * r1 + C * r2]
    }

    /// The proper root of a step from the leg that ends at `q` with the increment `d`: the second difference,
    /// and `w`.
    ///
    /// # Panics
    ///
    /// If the monotone equation for `w` is not solved, which cannot happen.
    #[must_use]
    pub fn step(h: f64, q: [f64; 2], d: [f64; 2]) -> ([f64; 2], f64) {
        let (r1, torque) = (M * q[0].sin(), t(q));
        let p1 = ((I + J) * d[0] + J * d[1]) / h + h / 2.0 * r1;
        let k = K * h / 2.0;
        // w + kρ tanh w = right
        let right = G * p1 + K * J * (d[0] + d[1]) / h + k * torque;
        let mut w = if right.abs() < 1.0 + k * RHO {
            right / (1.0 + k * RHO)
        } else {
            right - (k * RHO).copysign(right)
        };
        for _ in 0..60 {
            let tanh = w.tanh();
            let update = (w + k * RHO * tanh - right) / (1.0 + k * RHO * (1.0 - tanh * tanh));
            w -= update;
            if update.abs() <= 4.0 * f64::EPSILON * (w.abs() + right.abs()) {
                let r2 = torque - RHO * w.tanh();
                return ([h * h * (A * r1 + B * r2), h * h * (B * r1 + C * r2)], w);
            }
        }
        panic!("w + kρ tanh w = {right} has not been solved: w = {w}");
    }
}
