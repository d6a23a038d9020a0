//! The problems: each is declared for this library, and written as a right-hand side for the others.

use dsocs_core::dsocs;
use dsocs_systems::{Constant, CurvedParticle, InertiaWheelPendulum, PlanarChain8, Wavy};

/// A motion, and the number of its components whose errors are measured.
pub trait Problem: Copy + 'static {
    /// Its name in the report.
    const NAME: &'static str;
    /// The number of measured components: the first ones, which are positions.
    const MEASURED: usize;
    /// The time of the end, in s. The start is 0, and the output is at every [`INTERVAL`].
    const END: u32;
}

/// A problem as an initial value problem `y' = f(y)` with `D` components.
pub trait Equations<const D: usize>: Problem {
    /// The state at the start.
    fn start(&self) -> [f64; D];

    /// The right-hand side.
    fn rate(&self, state: &[f64; D]) -> [f64; D];

    /// The right-hand side in the syntax of Python, in `y0`, `y1`, …; for `heyoka`.
    fn equations(&self) -> Option<[String; D]> {
        None
    }
}

/// The grid of the output, in s.
pub const INTERVAL: f64 = 0.1;

/// The number of intervals in the grid of a problem.
pub const fn intervals(end: u32) -> u32 {
    10 * end
}

/// The times of the grid.
pub fn grid(end: u32) -> Vec<f64> {
    (0..=intervals(end)).map(|k| f64::from(k) * INTERVAL).collect()
}

/// A problem as it is declared.
pub trait Declared<const N: usize> {
    /// The system.
    type System;

    /// The declared system.
    fn system(&self) -> Self::System;

    /// Position and velocity at the start.
    fn begin(&self) -> ([f64; N], [f64; N]);
}

/// The particle whose curvature is a number.
#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
    variational = [(dot(x), dot(y))];
}]
pub struct Circle {
    mass: f64,
    curvature: f64,
}

/// The particle whose curvature is an expression.
#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    let curvature = mean + amplitude * x.sin() * y.cos();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
    variational = [(dot(x), dot(y))];
}]
pub struct Field {
    mass: f64,
    mean: f64,
    amplitude: f64,
}

/// The particle with the curvature 1 over some hundred turns.
#[derive(Clone, Copy)]
pub struct Particle;

impl Problem for Particle {
    const NAME: &'static str = "particle";
    const MEASURED: usize = 1;
    const END: u32 = 500;
}

impl Equations<4> for Particle {
    fn start(&self) -> [f64; 4] {
        [0.0, 0.0, 1.0, 1.0]
    }

    #[inline]
    fn rate(&self, &[_, _, vx, vy]: &[f64; 4]) -> [f64; 4] {
        let speed = (vx * vx + vy * vy).sqrt();
        [vx, vy, -speed * vy, speed * vx]
    }

    fn equations(&self) -> Option<[String; 4]> {
        let speed = "sqrt(y2**2 + y3**2)";
        Some([
            "y2".to_owned(),
            "y3".to_owned(),
            format!("-{speed} * y3"),
            format!("{speed} * y2"),
        ])
    }
}

impl Declared<2> for Particle {
    type System = Circle;

    fn system(&self) -> Self::System {
        Circle {
            mass: 1.0,
            curvature: 1.0,
        }
    }

    fn begin(&self) -> ([f64; 2], [f64; 2]) {
        ([0.0, 0.0], [1.0, 1.0])
    }
}

/// The particle in a curvature that varies over the plane.
#[derive(Clone, Copy)]
pub struct ParticleField;

impl Problem for ParticleField {
    const NAME: &'static str = "particle_field";
    const MEASURED: usize = 1;
    const END: u32 = 200;
}

impl Equations<4> for ParticleField {
    fn start(&self) -> [f64; 4] {
        [0.0, 0.0, 1.0, 1.0]
    }

    #[inline]
    fn rate(&self, &[x, y, vx, vy]: &[f64; 4]) -> [f64; 4] {
        let turn = (1.0 + 0.5 * x.sin() * y.cos()) * (vx * vx + vy * vy).sqrt();
        [vx, vy, -turn * vy, turn * vx]
    }

    fn equations(&self) -> Option<[String; 4]> {
        let turn = "(1.0 + 0.5 * sin(y0) * cos(y1)) * sqrt(y2**2 + y3**2)";
        Some([
            "y2".to_owned(),
            "y3".to_owned(),
            format!("-{turn} * y3"),
            format!("{turn} * y2"),
        ])
    }
}

impl Declared<2> for ParticleField {
    type System = Field;

    fn system(&self) -> Self::System {
        Field {
            mass: 2.0,
            mean: 1.0,
            amplitude: 0.5,
        }
    }

    fn begin(&self) -> ([f64; 2], [f64; 2]) {
        ([0.0, 0.0], [1.0, 1.0])
    }
}

/// A particle whose curvature is a user's function, which the generated code calls with jets.
#[derive(Clone, Copy)]
pub struct Called<P>(pub P);

impl<P: Problem> Problem for Called<P> {
    const NAME: &'static str = P::NAME;
    const MEASURED: usize = P::MEASURED;
    const END: u32 = P::END;
}

impl<P: Equations<4>> Equations<4> for Called<P> {
    fn start(&self) -> [f64; 4] {
        self.0.start()
    }

    fn rate(&self, state: &[f64; 4]) -> [f64; 4] {
        self.0.rate(state)
    }
}

impl Declared<2> for Called<Particle> {
    type System = CurvedParticle<Constant>;

    fn system(&self) -> Self::System {
        CurvedParticle::default()
    }

    fn begin(&self) -> ([f64; 2], [f64; 2]) {
        self.0.begin()
    }
}

impl Declared<2> for Called<ParticleField> {
    type System = CurvedParticle<Wavy>;

    fn system(&self) -> Self::System {
        CurvedParticle {
            mass: 2.0,
            curvature: Wavy::default(),
        }
    }

    fn begin(&self) -> ([f64; 2], [f64; 2]) {
        self.0.begin()
    }
}

/// The inertia wheel pendulum over the paper's time, in positions and momenta, with precomputed constants.
#[derive(Clone, Copy)]
pub struct Pendulum {
    inverse_i: f64,
    inverse_j: f64,
    m: f64,
    n: f64,
    rho: f64,
    w: [f64; 2],
    spring: f64,
    weight: f64,
}

impl Default for Pendulum {
    fn default() -> Self {
        let InertiaWheelPendulum {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            rho,
        } = InertiaWheelPendulum::default();
        let g_c = d * (n + 1.0) * j;
        let h_c = -d * (i + (n + 1.0) * j);
        Self {
            inverse_i: 1.0 / i,
            inverse_j: 1.0 / j,
            m,
            n,
            rho,
            w: [g_c, h_c],
            spring: chi / (i * j * d),
            weight: m * (g_c / h_c - e / (i * d * h_c)),
        }
    }
}

impl Problem for Pendulum {
    const NAME: &'static str = "pendulum";
    const MEASURED: usize = 1;
    const END: u32 = 2000;
}

impl Equations<4> for Pendulum {
    fn start(&self) -> [f64; 4] {
        let [p1, p2] = InertiaWheelPendulum::default().momentum([0.0, 0.5]);
        [0.5, 0.0, p1, p2]
    }

    #[inline]
    fn rate(&self, &[theta, psi, p1, p2]: &[f64; 4]) -> [f64; 4] {
        let theta_rate = (p1 - p2) * self.inverse_i;
        let sine = theta.sin();
        let w = self.w[0] * p1 + self.w[1] * p2;
        let torque = self.spring * (psi - self.n * theta).sin() - self.weight * sine;
        [
            theta_rate,
            p2 * self.inverse_j - theta_rate,
            self.m * sine,
            torque - self.rho * w.tanh(),
        ]
    }

    fn equations(&self) -> Option<[String; 4]> {
        let Self {
            inverse_i,
            inverse_j,
            m,
            n,
            rho,
            w: [w0, w1],
            spring,
            weight,
        } = *self;
        let theta_rate = format!("(y2 - y3) * {inverse_i:e}");
        Some([
            theta_rate.clone(),
            format!("y3 * {inverse_j:e} - {theta_rate}"),
            format!("{m:e} * sin(y0)"),
            format!(
                "{spring:e} * sin(y1 - {n:e} * y0) - ({weight:e}) * sin(y0) \
                 - {rho:e} * tanh(({w0:e}) * y2 + ({w1:e}) * y3)"
            ),
        ])
    }
}

impl Declared<2> for Pendulum {
    type System = InertiaWheelPendulum;

    fn system(&self) -> Self::System {
        InertiaWheelPendulum::default()
    }

    fn begin(&self) -> ([f64; 2], [f64; 2]) {
        ([0.5, 0.0], [0.0, 0.5])
    }
}

/// The chain of eight links, released at an angle.
#[derive(Clone, Copy)]
pub struct Chain;

/// The number of links.
const LINKS: usize = 8;

impl Problem for Chain {
    const NAME: &'static str = "chain8";
    const MEASURED: usize = LINKS;
    const END: u32 = 10;
}

impl Equations<16> for Chain {
    fn start(&self) -> [f64; 16] {
        core::array::from_fn(|i| if i < LINKS { self.begin().0[i] } else { 0.0 })
    }

    #[inline]
    #[allow(clippy::needless_range_loop)] // a triangle of a matrix, by index, as in textbooks
    fn rate(&self, state: &[f64; 16]) -> [f64; 16] {
        let (angles, rates) = state.split_at(LINKS);
        // equal links of the mass 1/8 and the length 1/8, all divided by both: Σ_j min(…) cos(θi - θj) aⱼ l = …
        let length = 1.0 / LINKS as f64;
        let (mut sine, mut cosine) = ([0.0; LINKS], [0.0; LINKS]);
        for i in 0..LINKS {
            (sine[i], cosine[i]) = angles[i].sin_cos();
        }
        let mut matrix = [[0.0; LINKS]; LINKS];
        let mut a = [0.0; LINKS];
        for i in 0..LINKS {
            a[i] = -9.81 * (LINKS - i) as f64 * sine[i];
            for j in 0..LINKS {
                let beyond = (LINKS - i.max(j)) as f64 * length;
                a[i] -= beyond * (sine[i] * cosine[j] - cosine[i] * sine[j]) * rates[j] * rates[j];
                if j <= i {
                    matrix[i][j] = beyond * (cosine[i] * cosine[j] + sine[i] * sine[j]);
                }
            }
        }
        // Cholesky's decomposition
        for i in 0..LINKS {
            for j in 0..=i {
                let mut sum = matrix[i][j];
                for k in 0..j {
                    sum -= matrix[i][k] * matrix[j][k];
                }
                matrix[i][j] = if i == j {
                    1.0 / sum.sqrt()
                } else {
                    sum * matrix[j][j]
                };
            }
            for k in 0..i {
                a[i] -= matrix[i][k] * a[k];
            }
            a[i] *= matrix[i][i];
        }
        for i in (0..LINKS).rev() {
            for k in i + 1..LINKS {
                a[i] -= matrix[k][i] * a[k];
            }
            a[i] *= matrix[i][i];
        }
        core::array::from_fn(|i| if i < LINKS { rates[i] } else { a[i - LINKS] })
    }
}

impl Declared<8> for Chain {
    type System = PlanarChain8;

    fn system(&self) -> Self::System {
        PlanarChain8::default()
    }

    fn begin(&self) -> ([f64; 8], [f64; 8]) {
        ([0.5; 8], [0.0; 8])
    }
}
