//! The particle with prescribed curvature, written by hand.
//!
//! With `s = d₀ + d₁ = 2d + e` the velocity at the middle node is `s/2h` and the acceleration `e/h²`. So the curvature is
//! `8 d×e/|s|³`, and the variational equation `s·e = 0`. The first row is multiplied by `|s|³`, which saves a division.

use super::{History, Path, SECOND_DIFFERENCE, solve};

/// A particle with its current position and history.
#[derive(Clone, Copy, Debug)]
pub struct Particle<K> {
    curvature: K,
    path: Path<2>,
    history: History<2>,
}

/// Quantities of a step that do not depend on its unknown: the increment, and the curvature at the middle
/// node.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    d: [f64; 2],
    curvature: f64,
}

/// The rows, and their derivatives by `e`.
pub type Rows = ([f64; 2], [[f64; 2]; 2]);

impl Known {
    #[inline(always)]
    pub fn new(d: [f64; 2], curvature: f64) -> Self {
        Self { d, curvature }
    }

    #[inline(always)]
    pub fn rows(&self, e: [f64; 2]) -> Rows {
        let [dx, dy] = [8.0 * self.d[0], 8.0 * self.d[1]];
        let s = [2.0 * self.d[0] + e[0], 2.0 * self.d[1] + e[1]];
        let squared = s[0] * s[0] + s[1] * s[1];
        let length = squared.sqrt();
        let pull = self.curvature * length;
        let bend = dx * e[1] - dy * e[0] - pull * squared;
        let work = s[0] * e[0] + s[1] * e[1];
        let slope = 3.0 * pull;
        (
            [bend, work],
            [
                [-dy - slope * s[0], dx - slope * s[1]],
                [s[0] + e[0], s[1] + e[1]],
            ],
        )
    }

    /// Newton's update, by Cramer's rule.
    #[inline(always)]
    fn update(&self, e: [f64; 2]) -> [f64; 2] {
        let (r, [[a, b], [c, d]]) = self.rows(e);
        let scale = (b * c - a * d).recip();
        [(r[0] * d - b * r[1]) * scale, (a * r[1] - c * r[0]) * scale]
    }
}

impl<K: Fn(f64, f64) -> f64> Particle<K> {
    pub fn new(curvature: K, q0: [f64; 2], d: [f64; 2]) -> Self {
        Self {
            curvature,
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
        let d = self.path.d;
        let known = Known::new(d, (self.curvature)(self.path.q[0], self.path.q[1]));
        let size = [0, 1].map(|i| self.history.size[i].max(SECOND_DIFFERENCE * d[i].abs()));
        let guess = self.history.predict();
        let guess = if guess[0].is_nan() { [0.0; 2] } else { guess };
        let (e, iterations) = solve(|e| known.update(e), guess, size)?;
        self.path.advance(e);
        if !(self.path.q[0].is_finite() && self.path.q[1].is_finite()) {
            return None;
        }
        self.history.push(e);
        Some(iterations)
    }
}
