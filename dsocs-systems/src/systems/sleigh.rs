//! The Chaplygin sleigh.

use dsocs_core::dsocs;

/// A sleigh that is pushed backwards and turns round.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(Sleigh::default())
        .named("sleigh")
        .described("the Chaplygin sleigh: a body on a plane, with a blade behind its centre of mass")
        .source("Bloch, Nonholonomic Mechanics and Control, section 1.7; Neimark and Fufaev, Dynamics of Nonholonomic Systems")
        .start([0.0, 0.0, 0.0], [-1.0, 0.0, 0.3])
        .step(0.05)
        .until(40.0)
        .drawn(|&[x, y, theta]: &[f64; 3], parameters| {
            let offset = parameters.get("offset");
            let centre = [x + offset * theta.cos(), y + offset * theta.sin()];
            super::blade([x, y], theta, offset).rod([x, y], centre).point(centre)
        })
        .symmetry("translation along x", |_: &[f64; 3]| [1.0, 0.0, 0.0])
        .symmetry("rotation about the origin", |[x, y, _]| [-y, *x, 1.0])
}

/// A body that slides on a horizontal plane, with a blade at the distance `a` behind its centre of mass.
///
/// `(x, y)` is the blade's point of contact and `θ` its direction, across which it cannot move. With the speed `u` along the blade and the
/// rate `ω = θ̇`: `u̇ = a ω²`, `ω̇ = −(a/k²) u ω` with `k² = (I + m a²)/m`. The energy `m (u² + k² ω²)/2` is
/// conserved. Still, every motion that turns tends to a straight one, with `u = V = √(u² + k² ω²)`, because volume in phase space is not
/// conserved. The motion in closed form is
/// `u = V tanh s`, `ω = ± (V/k) sech s`, `s = (a V/k²)(t − t₀)` ([`Sleigh::exact`]).
#[dsocs {
    coordinates(
        /// The first position of the blade's point of contact [m].
        x,
        /// The second position of the blade's point of contact [m].
        y,
        /// The direction of the blade [rad].
        theta,
    );
    /// The speed along the blade [m/s].
    let speed = dot(x) * theta.cos() + dot(y) * theta.sin();
    let across = dot(y) * theta.cos() - dot(x) * theta.sin();
    lagrangian = mass / 2 * (speed.powi(2) + (across + offset * dot(theta)).powi(2))
        + inertia / 2 * dot(theta).powi(2);
    nonholonomic = across;
    observe = [speed];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sleigh {
    /// The mass \[kg\].
    pub mass: f64,
    /// The moment of inertia `I` about the centre of mass [kg m²].
    pub inertia: f64,
    /// The distance `a` of the centre of mass before the blade \[m\].
    pub offset: f64,
}

impl Default for Sleigh {
    /// One kilogram, half a metre before the blade.
    fn default() -> Self {
        Self {
            mass: 1.0,
            inertia: 0.25,
            offset: 0.5,
        }
    }
}

impl Sleigh {
    /// `k²`, in m²: the square of the radius of gyration about the blade.
    fn gyration(&self) -> f64 {
        self.inertia / self.mass + self.offset * self.offset
    }

    /// The exact direction `θ`, speed `u` along the blade and rate `ω`, in rad, m/s and rad/s, a time `t`, in s, after others;
    /// for a motion that turns (`ω ≠ 0`) and `a ≠ 0`.
    ///
    /// From `θ̇ = ω`, `θ` changes by `k/a` times the change of the Gudermannian `2 arctan tanh(s/2)`.
    #[must_use]
    pub fn exact(&self, [theta, speed, rate]: [f64; 3], t: f64) -> [f64; 3] {
        let k = self.gyration().sqrt();
        let end = speed.hypot(k * rate);
        let s0 = (speed / (k * rate.abs())).asinh();
        let s = s0 + self.offset * end / (k * k) * t;
        let gudermannian = |s: f64| 2.0 * (s / 2.0).tanh().atan();
        [
            theta + rate.signum() * k / self.offset * (gudermannian(s) - gudermannian(s0)),
            end * s.tanh(),
            rate.signum() * end / (k * s.cosh()),
        ]
    }
}
