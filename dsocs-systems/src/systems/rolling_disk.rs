//! The vertical rolling disk.

use dsocs_core::dsocs;

/// A disk that rolls on a circle.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(RollingDisk::default())
        .named("rolling-disk")
        .described("a vertical disk that rolls on a plane without slipping")
        .source("Bloch, Nonholonomic Mechanics and Control, section 1.4")
        // on the constraint: x' = R θ' cos φ, y' = R θ' sin φ
        .start(
            [0.0, 0.0, 0.0, 0.3],
            [0.955_336_489_125_606, 0.295_520_206_661_339_55, 2.0, 0.7],
        )
        .step(0.1)
        .until(50.0)
        .drawn(|&[x, y, _, phi]: &[f64; 4], parameters| {
            super::blade([x, y], phi, 2.0 * parameters.get("radius"))
        })
        .symmetry("turning the heading", |_: &[f64; 4]| [0.0, 0.0, 0.0, 1.0])
        .symmetry("rolling without moving on", |_: &[f64; 4]| [0.0, 0.0, 1.0, 0.0])
}

/// A disk that stays upright on a horizontal plane and rolls without slipping.
///
/// `(x, y)` is the point of contact, `θ` the angle by which the disk has rolled and `φ` its heading: `ẋ = R θ̇ cos φ`,
/// `ẏ = R θ̇ sin φ`. Both angles change at constant rates, and the point of contact moves on a circle of the radius `R θ̇/φ̇`
/// ([`RollingDisk::exact`]). The discrete motion is also on a circle. For the same rates its radius is larger by the factor
/// `(h φ̇/2) / sin(h φ̇/2)`.
#[dsocs {
    coordinates(
        /// The first position of the point of contact [m].
        x,
        /// The second position of the point of contact [m].
        y,
        /// The angle by which the disk has rolled [rad].
        theta,
        /// The heading [rad].
        phi,
    );
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2))
        + inertia / 2 * dot(theta).powi(2) + turning / 2 * dot(phi).powi(2);
    nonholonomic = [dot(x) - radius * phi.cos() * dot(theta), dot(y) - radius * phi.sin() * dot(theta)];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingDisk {
    /// The mass \[kg\].
    pub mass: f64,
    /// The moment of inertia about the axle [kg m²].
    pub inertia: f64,
    /// The moment of inertia about the vertical [kg m²].
    pub turning: f64,
    /// The radius `R` \[m\].
    pub radius: f64,
}

impl Default for RollingDisk {
    /// A uniform disk of one kilogram and half a metre.
    fn default() -> Self {
        Self {
            mass: 1.0,
            inertia: 0.125,
            turning: 0.0625,
            radius: 0.5,
        }
    }
}

impl RollingDisk {
    /// The exact position `(x, y, θ, φ)` a time `t`, in s, after `(q0, v0)`, which obeys the constraints.
    #[must_use]
    pub fn exact(&self, q0: [f64; 4], v0: [f64; 4], t: f64) -> [f64; 4] {
        let ([x, y, theta, phi], [_, _, roll, turn]) = (q0, v0);
        // the chord of the arc, in the direction of its middle
        let half = turn * t / 2.0;
        let chord = self.radius * roll * t * if half == 0.0 { 1.0 } else { half.sin() / half };
        let (sin, cos) = (phi + half).sin_cos();
        [x + chord * cos, y + chord * sin, theta + roll * t, phi + turn * t]
    }
}
