//! A particle with prescribed tangential acceleration, in a uniform field: a gravity turn.

use dsocs_core::dsocs;

/// A climb that bends over while the speed grows.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(GravityTurn::default())
        .named("gravity-turn")
        .described("a particle with prescribed tangential acceleration under gravity, by Chetaev's rule")
        .source("constraints of this kind: Swaczyna (cited in the paper, section 2); the exact solution is elementary")
        .start([0.0, 0.0], [1.0, 3.0])
        .step(0.05)
        .until(20.0)
        .symmetry("translation along x", |_: &[f64; 2]| [1.0, 0.0])
}

/// A particle in the plane whose speed grows at a prescribed rate, whatever gravity does: thrust or brake along the path.
///
/// The constraint is of second order. By Chetaev's rule its virtual displacements are `ker ∂c/∂q̈`: those orthogonal to the velocity. The
/// declaration writes them out. So the force is along the velocity, and only gravity bends the path. The speed is exactly
/// `s = s₀ + τ t`, and with the path's angle `γ` the quantity `artanh(sin γ) + (g/τ) ln s` is invariant.
#[dsocs {
    coordinates(
        /// The position along the ground [m].
        x,
        /// The height [m].
        y,
    );
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - mass * gravity * y;

    /// The speed [m/s].
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(x) + dot(y) * ddot(y)) / speed - acceleration;
    variational = [(-dot(y), dot(x))]; // ker ∂c/∂q̈
    observe = [speed];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GravityTurn {
    /// The mass of the particle \[kg\].
    pub mass: f64,
    /// The acceleration of gravity [m/s²].
    pub gravity: f64,
    /// The prescribed rate `τ` of the speed [m/s²].
    pub acceleration: f64,
}

impl Default for GravityTurn {
    /// A thrust that adds half a metre per second to the speed, every second, under a weak gravity.
    fn default() -> Self {
        Self {
            mass: 1.0,
            gravity: 1.0,
            acceleration: 0.5,
        }
    }
}

impl GravityTurn {
    /// The exact velocity, in m/s, a time `t`, in s, after the velocity `v0`, as long as the speed has not become zero.
    ///
    /// From `s γ' = −g cos γ` with `s = s₀ + τ t`: `artanh(sin γ)` falls by `(g/τ) ln(s/s₀)`, and by `g t/s₀` for `τ = 0`.
    #[must_use]
    pub fn exact_velocity(&self, v0: [f64; 2], t: f64) -> [f64; 2] {
        let speed0 = v0[0].hypot(v0[1]);
        let growth = self.acceleration * t / speed0;
        let ratio = if growth == 0.0 {
            1.0
        } else {
            growth.ln_1p() / growth
        };
        let fallen = self.gravity * t / speed0 * ratio;
        // asinh(tan γ) = artanh(sin γ) for a path that goes to the right, and mirrored for one to the left
        let direction = v0[0].signum();
        let u = (v0[1] / v0[0].abs()).asinh() - fallen;
        let speed = speed0 + self.acceleration * t;
        [direction * speed / u.cosh(), speed * u.tanh()]
    }
}
