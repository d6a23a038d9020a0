//! The spherical pendulum in Cartesian coordinates: a point on a sphere.

use dsocs_core::dsocs;

/// A bob that swings out of the plane, through the level of the pivot.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(Sphere::default())
        .named("sphere")
        .described("the spherical pendulum in Cartesian coordinates, its rod a constraint")
        .source("textbooks, e.g. Landau and Lifshitz, Mechanics, section 14, problem 1")
        .start([0.6, 0.0, -0.8], [2.0, 2.5, 1.5])
        .step(0.01)
        .until(20.0)
        .symmetry("rotation about the vertical", |[x, y, _]| [-y, *x, 0.0])
}

/// A point mass on a massless rod that may swing in any direction.
///
/// The pivot is the origin and `z` points upwards. Every vector field on the sphere has a zero, so there is no global basis of the virtual
/// displacements. So the multiplier is an unknown of the step. `λ_0` is the force of the rod in N, positive where it pushes outwards. Invariants are
/// the energy and the angular momentum about the vertical, `m (x ẏ − y ẋ)`. The discrete motion keeps the second one exactly, because the rotation is a
/// virtual displacement. [`SphericalPendulum`](crate::SphericalPendulum) is the same motion in angles, which have no value on the vertical.
#[dsocs {
    coordinates(
        /// The first horizontal position [m].
        x,
        /// The second horizontal position [m].
        y,
        /// The height above the pivot [m].
        z,
    );
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) - mass * gravity * z;
    holonomic = (x.powi(2) + y.powi(2) + z.powi(2) - length.powi(2)) / (2 * length);
    /// The angular momentum about the vertical [kg m²/s].
    let angular_momentum = mass * (x * dot(y) - y * dot(x));
    observe = [angular_momentum];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The mass of the bob \[kg\].
    pub mass: f64,
    /// The length of the rod \[m\].
    pub length: f64,
    /// The acceleration of gravity [m/s²].
    pub gravity: f64,
}

impl Default for Sphere {
    /// One kilogram on one metre.
    fn default() -> Self {
        Self {
            mass: 1.0,
            length: 1.0,
            gravity: 9.81,
        }
    }
}

impl Sphere {
    /// Position and velocity for given angles `(θ, φ)` and their rates: `θ` from the downward vertical, `φ` about it.
    #[must_use]
    pub fn of_angles(
        &self,
        [theta, phi]: [f64; 2],
        [theta_rate, phi_rate]: [f64; 2],
    ) -> ([f64; 3], [f64; 3]) {
        let ((sin, cos), (aside, along)) = (theta.sin_cos(), phi.sin_cos());
        let l = self.length;
        let out = l * cos * theta_rate;
        let about = l * sin * phi_rate;
        (
            [l * sin * along, l * sin * aside, -l * cos],
            [
                out * along - about * aside,
                out * aside + about * along,
                l * sin * theta_rate,
            ],
        )
    }
}
