//! The spherical pendulum, in angles.

use dsocs_core::dsocs;

/// A bob that swings out of the plane.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(SphericalPendulum::default())
        .named("spherical-pendulum")
        .described("the spherical pendulum, by its angles from and about the vertical")
        .source("textbooks, e.g. Landau and Lifshitz, Mechanics, section 14, problem 1")
        .start([1.0, 0.0], [0.0, 2.0])
        .step(0.02)
        .until(50.0)
        .symmetry("rotation about the vertical", |_: &[f64; 2]| [0.0, 1.0])
}

/// A point mass on a rod that may swing in any direction.
///
/// `θ` is the angle from the downward vertical and `φ` the angle about it. The mass matrix depends on `θ`, so the discrete
/// Lagrangian is taken at the midpoint, which is of order 2. Invariants are the energy and the angular momentum about the
/// vertical, `m l² sin²θ φ̇`; the discrete motion keeps the second one exactly, in the form of its discrete momentum.
/// The angles have no value at `θ = 0`.
#[dsocs {
    coordinates(
        /// The angle from the downward vertical [rad].
        theta,
        /// The angle about the vertical [rad].
        phi,
    );
    let kinetic = mass * length.powi(2) / 2 * (dot(theta).powi(2) + theta.sin().powi(2) * dot(phi).powi(2));
    lagrangian = kinetic + mass * gravity * length * theta.cos();
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
    /// The angular momentum about the vertical [kg m²/s].
    let angular_momentum = mass * length.powi(2) * theta.sin().powi(2) * dot(phi);
    observe = [angular_momentum];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalPendulum {
    /// The mass of the bob \[kg\].
    pub mass: f64,
    /// The length of the rod \[m\].
    pub length: f64,
    /// The acceleration of gravity [m/s²].
    pub gravity: f64,
}

impl Default for SphericalPendulum {
    /// One kilogram on one metre.
    fn default() -> Self {
        Self {
            mass: 1.0,
            length: 1.0,
            gravity: 9.81,
        }
    }
}
