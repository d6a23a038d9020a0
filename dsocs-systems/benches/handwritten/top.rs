//! A heavy top, written by hand: a rigid body about a fixed point. Its attitude is a unit quaternion, which
//! increments of three numbers move.
//!
//! With `P = I x` and `T(±x)ᵀP = c P ± P×x/2 + d (x·P) x` the row is the change of `T` from the last leg to
//! the next. It is written in differences, since all of its terms are small: `Δc P₁ + c₀ I e - (P₁×x₁ +
//! P₀×x₀)/2 + Δd (x₁·P₁) x₁ + d₀ Δ(x·P) x₁ + d₀ (x₀·P₀) e = -h² a×Γ`, where `Γ` is the vertical in the frame
//! of the body.

use super::{History, SECOND_DIFFERENCE, fast_two_sum, solve, two_sum};

/// The moments of inertia.
pub const INERTIA: [f64; 3] = [2.0, 1.5, 1.0];

/// The centre of mass, times the weight.
pub const ARM: [f64; 3] = [0.2, 0.1, 1.0];

/// `P×x = (k₀ y z, k₁ z x, k₂ x y)`.
const GYRATION: [f64; 3] = [
    INERTIA[1] - INERTIA[2],
    INERTIA[2] - INERTIA[0],
    INERTIA[0] - INERTIA[1],
];

/// An increment with the quantities computed from it.
#[derive(Clone, Copy, Debug)]
struct Leg {
    x: [f64; 3],
    momentum: [f64; 3],
    /// `x·P`
    along: f64,
    gyration: [f64; 3],
    /// `a = 1 - |x|²/48`, `1/a` and `1/(2 - a)`.
    fractions: [f64; 3],
}

impl Leg {
    #[inline(always)]
    fn new(x: [f64; 3]) -> Self {
        let momentum = [INERTIA[0] * x[0], INERTIA[1] * x[1], INERTIA[2] * x[2]];
        let part = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) / 48.0;
        let a = 1.0 - part;
        Self {
            x,
            momentum,
            along: dot(x, momentum),
            gyration: [
                GYRATION[0] * x[1] * x[2],
                GYRATION[1] * x[2] * x[0],
                GYRATION[2] * x[0] * x[1],
            ],
            fractions: [a, 1.0 / a, 1.0 / (1.0 + part)],
        }
    }

    #[inline(always)]
    fn c(&self) -> f64 {
        self.fractions[0] + 3.0 - 3.0 * self.fractions[1]
    }

    #[inline(always)]
    fn d(&self) -> f64 {
        1.0 / 24.0 + self.fractions[1] / 16.0 - self.fractions[2] / 48.0
    }
}

/// The top with its current attitude and history.
#[derive(Clone, Copy, Debug)]
pub struct Top {
    h: f64,
    q: [f64; 4],
    q_low: [f64; 4],
    x: [f64; 3],
    x_low: [f64; 3],
    history: History<3>,
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn product(p: [f64; 4], q: [f64; 4]) -> [f64; 4] {
    [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
        p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
    ]
}

/// The solution of three equations.
#[inline(always)]
fn solved(m: [[f64; 3]; 3], r: [f64; 3]) -> [f64; 3] {
    let minor = |i: usize, j: usize| m[1][i] * m[2][j] - m[1][j] * m[2][i];
    let first = [minor(1, 2), minor(2, 0), minor(0, 1)];
    let inverse = 1.0 / dot(m[0], first);
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let (second, third) = (cross(m[2], m[0]), cross(m[0], m[1]));
    [0, 1, 2].map(|i| (first[i] * r[0] + second[i] * r[1] + third[i] * r[2]) * inverse)
}

impl Top {
    pub fn new(h: f64, q0: [f64; 4], x: [f64; 3]) -> Self {
        let mut top = Self {
            h,
            q: q0,
            q_low: [0.0; 4],
            x,
            x_low: [0.0; 3],
            history: History::new(),
        };
        top.turn();
        top
    }

    pub fn position(&self) -> &[f64] {
        &self.q
    }

    /// Moves the attitude by the increment, and normalises it.
    #[inline(always)]
    fn turn(&mut self) {
        let [x, y, z] = self.x;
        let square = x * x + y * y + z * z;
        let (a, b) = (1.0 - square / 48.0, square / 16.0);
        let inverse = 1.0 / (a * a + b);
        let half = 0.5 * a * inverse;
        let by = [-2.0 * b * inverse, half * x, half * y, half * z];
        let low = [0.0, 0.5 * self.x_low[0], 0.5 * self.x_low[1], 0.5 * self.x_low[2]];
        let (moves, small, of_low) = (product(self.q, by), product(self.q_low, by), product(self.q, low));
        let mut excess = -1.0;
        for k in 0..4 {
            let (sum, error) = two_sum(self.q[k], moves[k]);
            (self.q[k], self.q_low[k]) = fast_two_sum(sum, error + (self.q_low[k] + (small[k] + of_low[k])));
            excess += self.q[k] * (self.q[k] + 2.0 * self.q_low[k]);
        }
        for k in 0..4 {
            let (sum, error) = two_sum(self.q[k], -0.5 * excess * self.q[k]);
            (self.q[k], self.q_low[k]) = fast_two_sum(sum, error + self.q_low[k]);
        }
    }

    /// The part of the row that is due to the weight.
    #[inline(always)]
    fn weight(&self) -> [f64; 3] {
        let [w, x, y, z] = self.q;
        let up = [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            w * w - x * x - y * y + z * z,
        ];
        let square = self.h * self.h;
        [
            square * (ARM[1] * up[2] - ARM[2] * up[1]),
            square * (ARM[2] * up[0] - ARM[0] * up[2]),
            square * (ARM[0] * up[1] - ARM[1] * up[0]),
        ]
    }

    /// Takes a step; `None` if Newton's iteration does not converge.
    #[inline]
    pub fn advance(&mut self) -> Option<u32> {
        let last = Leg::new(self.x);
        let (c, d, weight) = (last.c(), last.d(), self.weight());
        let update = |e: [f64; 3]| {
            let x = [0, 1, 2].map(|i| last.x[i] + e[i]);
            let next = Leg::new(x);
            let moved = [0, 1, 2].map(|i| INERTIA[i] * e[i]);
            let both = [0, 1, 2].map(|i| x[i] + last.x[i]);
            let [_, inverse, other] = next.fractions;
            let (products, others) = (last.fractions[1] * inverse, last.fractions[2] * other);
            let change = -dot(both, e) / 48.0;
            let c_change = change * (1.0 + 3.0 * products);
            let d_change = -change * (products / 16.0 + others / 48.0);
            let straight = d_change * next.along + d * dot(both, moved);
            let row = [0, 1, 2].map(|i| {
                c_change * next.momentum[i] + c * moved[i] - 0.5 * (next.gyration[i] + last.gyration[i])
                    + straight * x[i]
                    + d * last.along * e[i]
                    + weight[i]
            });
            let (inverse, other) = (inverse * inverse, other * other);
            let c_slope = -(1.0 + 3.0 * inverse) / 24.0;
            let d_slope = (inverse / 16.0 + other / 48.0) / 24.0 * next.along;
            let (c, d) = (next.c(), next.d());
            let along = [0, 1, 2].map(|j| d_slope * x[j] + 2.0 * d * next.momentum[j]);
            let slope = x.map(|x| c_slope * x);
            let mut matrix =
                [0, 1, 2].map(|i| [0, 1, 2].map(|j| slope[j] * next.momentum[i] + along[j] * x[i]));
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                matrix[i][i] += c * INERTIA[i] + d * next.along;
                matrix[i][j] -= 0.5 * GYRATION[i] * x[k];
                matrix[i][k] -= 0.5 * GYRATION[i] * x[j];
            }
            solved(matrix, row.map(|row| -row))
        };
        let mut size = self.history.size;
        for i in 0..3 {
            size[i] = size[i].max(SECOND_DIFFERENCE * self.x[i].abs());
        }
        let guess = self.history.predict().map(|e| if e.is_nan() { 0.0 } else { e });
        let (e, iterations) = solve(update, guess, size)?;
        for i in 0..3 {
            let (sum, error) = two_sum(self.x[i], e[i]);
            (self.x[i], self.x_low[i]) = fast_two_sum(sum, error + self.x_low[i]);
        }
        self.turn();
        if !(self.q[0].is_finite() && self.q[1].is_finite() && self.q[2].is_finite() && self.q[3].is_finite())
        {
            return None;
        }
        self.history.push(e);
        Some(iterations)
    }
}
