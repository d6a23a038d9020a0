//! The heavy top, with a quaternion of unit length as its attitude.

use dsocs_core::dsocs;

/// A fast top that nods while it precesses.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    let top = QuaternionTop::default();
    let (q, v) = QuaternionTop::state([0.5, 0.0, 0.0], [0.0, 0.0, 30.0]);
    crate::Entry::new(top)
        .named("quaternion-top")
        .described("the heavy symmetric top, its attitude a quaternion under a constraint of unit length")
        .source("textbooks, e.g. Landau and Lifshitz, Mechanics, section 35, problem 1")
        .start(q, v)
        .step(0.002)
        .until(5.0)
        .symmetry("rotation about the vertical", |[w, x, y, z]| {
            [-z / 2.0, -y / 2.0, x / 2.0, w / 2.0]
        })
        .symmetry("rotation about the axis of the top", |[w, x, y, z]| {
            [-z / 2.0, y / 2.0, -x / 2.0, w / 2.0]
        })
}

/// A symmetric top with a fixed point on its axis, in gravity.
///
/// The quaternion `q = w + x i + y j + z k` turns the body's axes into those of space. The angular velocity in the body is the imaginary part
/// of `2 q̄ q̇`. The third axis of space points upwards, and the top's axis is the third axis of the body. The unit length of `q` is a holonomic
/// constraint, because the kinetic energy does not depend on changes of the length. Its multiplier belongs only to this description; it is
/// not a force on the real top.
///
/// Invariants are the energy and the angular momenta about the vertical and about the top's axis. Rotations act on `q` by
/// multiplication, which is linear. So with the midpoint map `L_d` has the same symmetries as `L`, and the discrete motion keeps both
/// momenta exactly. A top that precesses steadily at the angle `θ` obeys `I₁ cos θ φ̇² − I₃ ω₃ φ̇ + m g l = 0`
/// ([`QuaternionTop::spin_of_precession`]).
#[dsocs {
    coordinates(
        /// The real part of the quaternion [1].
        w,
        /// The component of `i` [1].
        x,
        /// The component of `j` [1].
        y,
        /// The component of `k` [1].
        z,
    );
    // the angular velocity in the body
    let rate_1 = 2 * (w * dot(x) - x * dot(w) - y * dot(z) + z * dot(y));
    let rate_2 = 2 * (w * dot(y) - y * dot(w) - z * dot(x) + x * dot(z));
    let rate_3 = 2 * (w * dot(z) - z * dot(w) - x * dot(y) + y * dot(x));
    // the vertical in the body
    let up_1 = 2 * (x * z - w * y);
    let up_2 = 2 * (y * z + w * x);
    /// The cosine of the angle between the top's axis and the vertical [1].
    let up_3 = w.powi(2) - x.powi(2) - y.powi(2) + z.powi(2);
    lagrangian = inertia_1 / 2 * (rate_1.powi(2) + rate_2.powi(2)) + inertia_3 / 2 * rate_3.powi(2) - weight * lever * up_3;
    holonomic = (w.powi(2) + x.powi(2) + y.powi(2) + z.powi(2) - 1) / 2;
    /// The angular momentum about the vertical [kg m²/s].
    let vertical_momentum = inertia_1 * (rate_1 * up_1 + rate_2 * up_2) + inertia_3 * rate_3 * up_3;
    /// The angular momentum about the top's axis [kg m²/s].
    let axial_momentum = inertia_3 * rate_3;
    observe = [up_3, vertical_momentum, axial_momentum];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuaternionTop {
    /// The moment of inertia `I₁` about axes across the top through the fixed point [kg m²].
    pub inertia_1: f64,
    /// The moment of inertia `I₃` about the top's axis [kg m²].
    pub inertia_3: f64,
    /// The weight `m g` \[N\].
    pub weight: f64,
    /// The distance `l` of the centre of mass from the fixed point \[m\].
    pub lever: f64,
}

impl Default for QuaternionTop {
    /// A top of two kilograms.
    fn default() -> Self {
        Self {
            inertia_1: 0.05,
            inertia_3: 0.02,
            weight: 19.62,
            lever: 0.1,
        }
    }
}

impl QuaternionTop {
    /// The quaternion and its rate for given Euler angles `(θ, φ, ψ)`, in rad, and their rates, in rad/s. `θ` is the tilt of the top's axis from
    /// the vertical, `φ` the rotation of this axis about the vertical, and `ψ` the rotation of the top about its axis.
    #[must_use]
    pub fn state([theta, phi, psi]: [f64; 3], rates: [f64; 3]) -> ([f64; 4], [f64; 4]) {
        let (sin, cos) = (theta / 2.0).sin_cos();
        let ((far, near), (aside, along)) =
            (f64::midpoint(phi, psi).sin_cos(), ((phi - psi) / 2.0).sin_cos());
        let q = [cos * near, sin * along, sin * aside, cos * far];
        let [tilt, turn, spin] = rates.map(|rate| rate / 2.0);
        let v = [
            -sin * near * tilt - cos * far * (turn + spin),
            cos * along * tilt - sin * aside * (turn - spin),
            cos * aside * tilt + sin * along * (turn - spin),
            -sin * far * tilt + cos * near * (turn + spin),
        ];
        (q, v)
    }

    /// The rate `ψ̇`, in rad/s, with which a top at the tilt `θ` spins about its axis if it precesses steadily with the rate
    /// `φ̇`, which is not zero: `I₃ (ψ̇ + φ̇ cos θ) = I₁ cos θ φ̇ + m g l/φ̇`.
    #[must_use]
    pub fn spin_of_precession(&self, theta: f64, precession: f64) -> f64 {
        let axial = self.inertia_1 * theta.cos() * precession + self.weight * self.lever / precession;
        axial / self.inertia_3 - precession * theta.cos()
    }
}
