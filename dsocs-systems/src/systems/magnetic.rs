//! A charged particle in a magnetic field: the particle of prescribed curvature without a constraint.

use dsocs_core::dsocs;

/// A particle that drifts about the centre of a field that grows outwards.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(MagneticParticle::default())
        .named("magnetic")
        .described("a charged particle in a magnetic field, the unconstrained twin of `particle`")
        .source("textbooks, e.g. Landau and Lifshitz, The Classical Theory of Fields, section 21")
        .start([1.0, 0.0], [0.3, 0.8])
        .step(0.05)
        .until(200.0)
        .symmetry("rotation about the origin", |[x, y]| [-y, *x])
}

/// A charged particle in the plane, in a magnetic field `B(r) = B (1 + g r²)` across it.
///
/// The Lagrangian is `m v²/2 + c A · v` with the vector potential `A = (−y, x) B/2 (1 + g r²/2)`. The force is orthogonal to the
/// velocity, so the speed is constant and the path has the signed curvature `−c B(r)/(m |v|)`: it is the path of
/// [`CurvedParticle`](crate::CurvedParticle) with that curvature. There the force is a constraint force; here it comes from the Lagrangian. So
/// here the flow is symplectic, and by the rotational symmetry `m (x ẏ − y ẋ) + c B/2 (1 + g r²/2) r²` is invariant. Neither needs to hold for
/// the constrained particle.
/// With `g = 0` the path is a circle, at the cyclotron frequency `c B/m` ([`MagneticParticle::exact`]).
///
/// Beside the kinetic energy, `L` has terms that are linear in `v`, with coefficients that depend on the position. So the discrete Lagrangian is
/// taken at the midpoint.
#[dsocs {
    coordinates(
        /// The first position in the plane [m].
        x,
        /// The second position in the plane [m].
        y,
    );
    let potential = charge * field / 2 * (1 + gradient / 2 * (x.powi(2) + y.powi(2)));
    let turning = x * dot(y) - y * dot(x);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) + potential * turning;
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
    /// The invariant that belongs to the rotation [kg m²/s].
    let angular_momentum = mass * turning + potential * (x.powi(2) + y.powi(2));
    observe = [angular_momentum];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagneticParticle {
    /// The mass of the particle \[kg\].
    pub mass: f64,
    /// The charge \[C\].
    pub charge: f64,
    /// The magnetic field in the centre \[T\].
    pub field: f64,
    /// How the field grows outwards, relative to the centre [1/m²].
    pub gradient: f64,
}

impl Default for MagneticParticle {
    /// A field that is twice as strong two metres from the centre.
    fn default() -> Self {
        Self {
            mass: 1.0,
            charge: 1.0,
            field: 1.0,
            gradient: 0.25,
        }
    }
}

impl MagneticParticle {
    /// The signed curvature of the path at a distance from the centre, in 1/m, of a particle of speed `speed`, in m/s.
    #[must_use]
    pub fn curvature(&self, speed: f64, r: f64) -> f64 {
        -self.charge * self.field * (1.0 + self.gradient * r * r) / (self.mass * speed)
    }

    /// The exact position, in m, in a uniform field (`gradient = 0`), a time `t`, in s, after `(q0, v0)`.
    #[must_use]
    pub fn exact(&self, q0: [f64; 2], v0: [f64; 2], t: f64) -> [f64; 2] {
        let frequency = self.charge * self.field / self.mass;
        let (sin, cos) = (frequency * t).sin_cos();
        // ∫ of the velocity, which turns to the right at the cyclotron frequency
        let [along, aside] = [sin / frequency, (1.0 - cos) / frequency];
        [
            q0[0] + along * v0[0] + aside * v0[1],
            q0[1] + along * v0[1] - aside * v0[0],
        ]
    }
}
