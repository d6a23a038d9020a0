//! The inertia wheel pendulum with a Lyapunov constraint, written by hand.
//!
//! The variational equation `(I+J) θ'' + J ψ'' = M sin θ` is linear and gives `ψ₂`. The constraint then has
//! the factor `w`, which is divided out with pencil and paper: `M sin θ − T − I θ'' + ρ tanh w = 0`, where
//! `w` is affine in `θ''`.

use super::{History, Path, SECOND_DIFFERENCE, solve};

/// Constants of a run: combinations of the parameters and the step.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    n: f64,
    rho: f64,
    /// The coefficient of `sin θ` in the row: `M (1 + g/k + e b/(d k))` with `b = −1/I`.
    gravity: f64,
    /// The coefficient of `sin(ψ − nθ)` in the row.
    coupling: f64,
    /// The coefficients of `w` by `dθ`, `dψ` and `sin θ`.
    w: [f64; 3],
    /// `∂w/∂z`.
    w_slope: f64,
    /// `I/h²`.
    inertia: f64,
    /// `ρ ∂w/∂z`.
    damping: f64,
    /// `e_ψ = wheel[0] sin θ − wheel[1] z`.
    wheel: [f64; 2],
}

/// Quantities of a step that do not depend on its unknown, all at the middle node.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    torque: f64,
    w: f64,
    sine: f64,
}

/// The pendulum with its current position and history.
#[derive(Clone, Copy, Debug)]
pub struct Pendulum {
    constants: Constants,
    path: Path<2>,
    history: History<1>,
}

impl Constants {
    /// With the paper's parameters.
    pub fn new(h: f64) -> Self {
        let [i, j, m, d, e, chi, n, rho] = [312.5, 2.0772, 37.98, 1.0, 1000.0, 100.0, -154.0, 2.0];
        let determinant = 1.0 / (i * j);
        let (g, k) = (d * (n + 1.0) * j, -d * (i + (n + 1.0) * j));
        let w_slope = -k * i / (2.0 * h);
        Self {
            n,
            rho,
            gravity: m * (1.0 + g / k - e / i / (d * k)),
            coupling: -chi * determinant / d,
            w: [(g * (i + j) + k * j) / h, (g + k) * j / h, (g + k) * m * h / 2.0],
            w_slope,
            inertia: i / (h * h),
            damping: rho * w_slope,
            wheel: [h * h * m / j, (i + j) / j],
        }
    }

    #[inline(always)]
    pub fn known(&self, q: [f64; 2], d: [f64; 2]) -> Known {
        let sine = q[0].sin();
        Known {
            torque: self.gravity * sine + self.coupling * (q[1] - self.n * q[0]).sin(),
            w: self.w[0] * d[0] + self.w[1] * d[1] + self.w[2] * sine,
            sine,
        }
    }

    /// The row and its derivative by the second difference `z` of `θ`.
    #[inline(always)]
    pub fn row(&self, known: &Known, z: f64) -> (f64, f64) {
        let tanh = (known.w + self.w_slope * z).tanh();
        let row = known.torque + self.rho * tanh - self.inertia * z;
        (row, self.damping * (1.0 - tanh) * (1.0 + tanh) - self.inertia)
    }

    #[inline(always)]
    fn update(&self, known: &Known, z: f64) -> f64 {
        let (row, slope) = self.row(known, z);
        -row / slope
    }
}

impl Pendulum {
    pub fn new(h: f64, q0: [f64; 2], d: [f64; 2]) -> Self {
        Self {
            constants: Constants::new(h),
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
        let constants = &self.constants;
        let known = constants.known(self.path.q, self.path.d);
        let size = self.history.size[0].max(SECOND_DIFFERENCE * self.path.d[0].abs());
        let [guess] = self.history.predict();
        let guess = if guess.is_nan() { 0.0 } else { guess };
        let ([z], iterations) = solve(|[z]| [constants.update(&known, z)], [guess], [size])?;
        self.path
            .advance([z, constants.wheel[0] * known.sine - constants.wheel[1] * z]);
        if !(self.path.q[0].is_finite() && self.path.q[1].is_finite()) {
            return None;
        }
        self.history.push([z]);
        Some(iterations)
    }
}
