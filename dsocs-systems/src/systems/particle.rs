//! A particle in the plane with prescribed signed curvature (paper, section 5.1).

use dsocs_core::{Real, dsocs};

/// The paper's example.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    let curvature = crate::entry::ExtraParameter {
        name: "curvature",
        doc: "The prescribed curvature, positive to the left [1/m].",
        place: |particle: &mut CurvedParticle<Constant>| &mut particle.curvature.0,
    };
    crate::Entry::with_parameters(CurvedParticle::default(), [curvature])
        .named("particle")
        .described("a particle in the plane with prescribed signed curvature")
        .source("Borda, Fernández and Grillo, section 5.1")
        .start([0.0, 0.0], [1.0, 1.0])
        .step(0.1)
        .until(500.0)
        .symmetry("translation along x", |_: &[f64; 2]| [1.0, 0.0])
        .symmetry("rotation about the origin", |[x, y]| [-y, *x])
}

/// A signed curvature κ, prescribed at every point of the plane.
///
/// ```
/// use dsocs_core::Real;
/// use dsocs_systems::{Curvature, CurvedParticle};
///
/// /// Sharper turns the farther from the origin.
/// struct Funnel;
///
/// impl Curvature for Funnel {
///     fn at<D: Real>(&self, x: D, y: D) -> D {
///         (x * x + y * y + 1.0).sqrt()
///     }
/// }
///
/// let particle = CurvedParticle { mass: 1.0, curvature: Funnel };
/// # let _ = particle;
/// ```
pub trait Curvature: Send + Sync {
    /// The curvature at the point `(x, y)`, in 1/m: positive to the left of the motion.
    fn at<D: Real>(&self, x: D, y: D) -> D;
}

/// A constant curvature, in 1/m. The particle moves on a circle or, for 0, on a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant(pub f64);

impl Curvature for Constant {
    fn at<D: Real>(&self, _: D, _: D) -> D {
        D::from(self.0)
    }
}

/// A curvature that varies over the plane, `κ(x, y) = mean + amplitude · sin(k x) · cos(k y)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavy {
    /// The mean curvature, in 1/m.
    pub mean: f64,
    /// The amplitude of its variation, in 1/m.
    pub amplitude: f64,
    /// The wave number `k`, in 1/m.
    pub wave_number: f64,
}

impl Default for Wavy {
    /// `1 + sin(x) cos(y) / 2`.
    fn default() -> Self {
        Self {
            mean: 1.0,
            amplitude: 0.5,
            wave_number: 1.0,
        }
    }
}

impl Curvature for Wavy {
    fn at<D: Real>(&self, x: D, y: D) -> D {
        (x * self.wave_number).sin() * (y * self.wave_number).cos() * self.amplitude + self.mean
    }
}

/// A particle in the plane that turns with a prescribed signed curvature, by a force orthogonal to its velocity.
#[dsocs {
    coordinates(
        /// The first position in the plane [m].
        x,
        /// The second position in the plane [m].
        y,
    );
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));

    // C_K: the polar angle of the velocity turns by the curvature per unit length.
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature.at(x, y);

    // C_V: the force is orthogonal to the velocity.
    variational = [(dot(x), dot(y))];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvedParticle<K: Curvature> {
    /// The mass of the particle \[kg\].
    pub mass: f64,
    /// The prescribed curvature.
    pub curvature: K,
}

impl Default for CurvedParticle<Constant> {
    /// The paper's example: unit curvature (the mass does not enter the motion).
    fn default() -> Self {
        Self {
            mass: 1.0,
            curvature: Constant(1.0),
        }
    }
}

impl CurvedParticle<Constant> {
    /// The exact position, in m, and velocity, in m/s, a time `t`, in s, after `(q0, v0)`.
    ///
    /// The speed is constant, so the velocity turns by `κ |v0| t`. The displacement is the chord of that arc, written
    /// so that nothing cancels for a small curvature: for κ = 0 it is the straight line.
    #[must_use]
    pub fn exact(&self, q0: [f64; 2], v0: [f64; 2], t: f64) -> ([f64; 2], [f64; 2]) {
        let half = self.curvature.0 * v0[0].hypot(v0[1]) * t / 2.0;
        let ratio = if half == 0.0 { 1.0 } else { half.sin() / half };
        let chord = rotated(v0, half);
        (
            [q0[0] + t * ratio * chord[0], q0[1] + t * ratio * chord[1]],
            rotated(v0, 2.0 * half),
        )
    }
}

/// A plane vector turned to the left by an angle, in rad.
fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}
