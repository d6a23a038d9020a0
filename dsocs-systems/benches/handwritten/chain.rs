//! The planar chain, written by hand.
//!
//! With `z_j = (sin θ_j, cos θ_j)` and `c_ij = μ_max(i,j) l_i l_j` the sums `Σ_j c_ij cos(θ_i−θ_j) u_j` are
//! scalar products of `z_i` with sums that run along the chain, so the rows cost a number of products
//! proportional to `n`. Only the Jacobian needs every pair of links once. A step of the increment `d` turns
//! `z` by `δ = d + e/2`: one sine and cosine a link, and differences that do not cancel.

use super::{History, Path, SECOND_DIFFERENCE, solve};

/// Constants of a run: products of masses, lengths, gravity and the step.
#[derive(Clone, Copy, Debug)]
pub struct Constants<const N: usize> {
    /// `μ_i`.
    beyond: [f64; N],
    /// `l_i`.
    lengths: [f64; N],
    /// `c_ij`.
    inertia: [[f64; N]; N],
    /// `h² g μ_i l_i / 2`.
    weight: [f64; N],
}

/// Quantities of a step that do not depend on its unknown: the increment, and everything at the first leg.
#[derive(Clone, Copy, Debug)]
pub struct Known<const N: usize> {
    d: [f64; N],
    /// The sine and cosine of the angle in the middle of the first leg.
    before: [[f64; 2]; N],
    /// The sums along the chain, at the same angle.
    sums: [[f64; 2]; N],
    /// The first leg's part of the rows.
    rows: [f64; N],
}

/// A chain with its current position and history.
#[derive(Clone, Copy, Debug)]
pub struct Chain<const N: usize> {
    constants: Constants<N>,
    path: Path<N>,
    history: History<N>,
}

impl<const N: usize> Constants<N> {
    pub fn new(masses: [f64; N], lengths: [f64; N], gravity: f64, h: f64) -> Self {
        let beyond: [f64; N] = std::array::from_fn(|i| masses[i..].iter().sum());
        let inertia = std::array::from_fn(|i| {
            std::array::from_fn(|j: usize| beyond[i.max(j)] * lengths[i] * lengths[j])
        });
        Self {
            beyond,
            lengths,
            inertia,
            weight: std::array::from_fn(|i| h * h * gravity * beyond[i] * lengths[i] / 2.0),
        }
    }

    /// `Σ_j μ_max(i,j) l_j u_j` for every `i`.
    #[inline(always)]
    fn along(&self, u: [[f64; 2]; N]) -> [[f64; 2]; N] {
        let mut sums = [[0.0; 2]; N];
        let mut tail = [0.0; 2];
        for i in (0..N).rev() {
            sums[i] = tail;
            for k in 0..2 {
                tail[k] += self.beyond[i] * (self.lengths[i] * u[i][k]);
            }
        }
        let mut head = [0.0; 2];
        for i in 0..N {
            for k in 0..2 {
                head[k] += self.lengths[i] * u[i][k];
                sums[i][k] += self.beyond[i] * head[k];
            }
        }
        sums
    }

    #[inline(always)]
    pub fn known(&self, q: [f64; N], d: [f64; N]) -> Known<N> {
        let before: [[f64; 2]; N] = std::array::from_fn(|i| {
            let (sine, cosine) = (q[i] - 0.5 * d[i]).sin_cos();
            [sine, cosine]
        });
        let sums = self.along(std::array::from_fn(|i| before[i].map(|z| z * d[i])));
        let rows = std::array::from_fn(|i| {
            let ([sine, cosine], [x, y]) = (before[i], sums[i]);
            0.5 * self.lengths[i] * d[i] * (sine * y - cosine * x) + self.weight[i] * sine
        });
        Known {
            d,
            before,
            sums,
            rows,
        }
    }

    /// The rows, multiplied by `h²`, and their derivatives by `e`.
    #[inline(always)]
    pub fn rows(&self, known: &Known<N>, e: [f64; N]) -> ([f64; N], [[f64; N]; N]) {
        let mut turned = [[0.0; 2]; N];
        let mut after = [[0.0; 2]; N];
        let mut w = [0.0; N];
        for i in 0..N {
            let (s, c) = (0.5 * known.d[i] + 0.25 * e[i]).sin_cos();
            let [sine, cosine] = known.before[i];
            let (across, along) = (2.0 * s * c, 2.0 * s * s);
            turned[i] = [cosine * across - sine * along, -sine * across - cosine * along];
            after[i] = [sine + turned[i][0], cosine + turned[i][1]];
            w[i] = known.d[i] + e[i];
        }
        let changes = self.along(std::array::from_fn(|i| {
            [0, 1].map(|k| after[i][k] * e[i] + turned[i][k] * known.d[i])
        }));
        let mut rows = [0.0; N];
        let mut jacobian = [[0.0; N]; N];
        for i in 0..N {
            let ([x, y], [dx, dy]) = (known.sums[i], changes[i]);
            let ([sine, cosine], [turned_sine, turned_cosine]) = (after[i], turned[i]);
            let (sx, sy) = (x + dx, y + dy);
            let length = self.lengths[i];
            let momentum = sine * dx + cosine * dy + turned_sine * x + turned_cosine * y;
            let bend = sine * sy - cosine * sx;
            rows[i] = known.rows[i] + length * (momentum + 0.5 * w[i] * bend) + self.weight[i] * sine;
            let inertia = self.inertia[i][i];
            let others = length * (sine * sx + cosine * sy) - inertia * w[i];
            jacobian[i][i] = inertia + 0.25 * w[i] * others + 0.5 * self.weight[i] * cosine;
            for j in 0..i {
                let [other_sine, other_cosine] = after[j];
                let c = self.inertia[i][j];
                let even = c * (sine * other_sine + cosine * other_cosine) * (1.0 - 0.25 * w[i] * w[j]);
                let odd = c * (sine * other_cosine - cosine * other_sine) * (0.5 * (w[i] + w[j]));
                jacobian[i][j] = even + odd;
                jacobian[j][i] = even - odd;
            }
        }
        (rows, jacobian)
    }

    #[inline(always)]
    fn update(&self, known: &Known<N>, e: [f64; N]) -> [f64; N] {
        let (rows, jacobian) = self.rows(known, e);
        eliminate(jacobian, rows.map(|row| -row))
    }
}

/// Gauss elimination with partial pivoting.
#[inline(always)]
fn eliminate<const N: usize>(mut a: [[f64; N]; N], mut x: [f64; N]) -> [f64; N] {
    let mut inverse = [0.0; N];
    for k in 0..N {
        let mut pivot = k;
        for i in k + 1..N {
            if a[i][k].abs() > a[pivot][k].abs() {
                pivot = i;
            }
        }
        a.swap(k, pivot);
        x.swap(k, pivot);
        inverse[k] = 1.0 / a[k][k];
        for i in k + 1..N {
            let factor = a[i][k] * inverse[k];
            for j in k + 1..N {
                a[i][j] -= factor * a[k][j];
            }
            x[i] -= factor * x[k];
        }
    }
    for k in (0..N).rev() {
        for j in k + 1..N {
            x[k] -= a[k][j] * x[j];
        }
        x[k] *= inverse[k];
    }
    x
}

impl<const N: usize> Chain<N> {
    pub fn new(constants: Constants<N>, q0: [f64; N], d: [f64; N]) -> Self {
        Self {
            constants,
            path: Path::new(q0, d),
            history: History::new(),
        }
    }

    pub fn position(&self) -> &[f64] {
        &self.path.q
    }

    /// Takes a step; `None` if Newton's iteration does not converge.
    #[inline]
    pub fn advance(&mut self) -> Option<u32> {
        let (constants, d) = (&self.constants, self.path.d);
        let known = constants.known(self.path.q, d);
        let size = std::array::from_fn(|i| self.history.size[i].max(SECOND_DIFFERENCE * d[i].abs()));
        let guess = self.history.predict();
        let guess = if guess[0].is_nan() { [0.0; N] } else { guess };
        let (e, iterations) = solve(|e| constants.update(&known, e), guess, size)?;
        self.path.advance(e);
        if !self.path.q.iter().all(|q| q.is_finite()) {
            return None;
        }
        self.history.push(e);
        Some(iterations)
    }
}
