//! A contact oscillator that is not reversible.

use dsocs_core::dsocs;

/// A motion whose energy drifts in a long run.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(ContactOscillator::default())
        .named("contact-oscillator")
        .described("an oscillator with the constraint z' = y x', made irreversible by a magnetic field")
        .source(
            "after McLachlan and Perlmutter, Integrators for nonholonomic mechanical systems (2006); \
             Modin and Verdier, What makes nonholonomic integrators work? (2020)",
        )
        .start([1.0, 0.5, 0.3], [0.4, 0.2, 0.2])
        .step(0.1)
        .until(100.0)
}

/// A particle in a quadratic potential and a constant magnetic field, under the nonholonomic constraint `ż = y ẋ` (a contact structure).
///
/// The energy is the only known invariant. Without the field the system is reversible. According to the second source this is
/// the reason why nonholonomic methods keep the energy well. On irreversible problems the source finds no method that always keeps it.
/// With a field of three nonzero components, no reflection of the coordinates reverses the motion. The steps are still
/// symmetric in time, and yet **the energy drifts**, in no particular direction. From the default start with `h = 0.1`, the mean
/// of the energy over successive intervals of 10 000 units of time differs from the true energy by +0.6, +0.2, −4.6, −8.0, −6.7, −5.1, −7.5, −9.2, −9.7 and −9.6 % up to `t = 100 000`;
/// with `h = 0.05` by +0.5 % in the first interval and +6.0 % in the last. Without the field it stays at −0.27 % for `h = 0.1`, and at
/// −0.07 % for `h = 0.05`.
#[dsocs {
    coordinates(
        /// The first position [1].
        x,
        /// The second position [1].
        y,
        /// The position that the constraint ties to the others [1].
        z,
    );
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2
        - (x.powi(2) + stiffness_y * y.powi(2) + stiffness_z * z.powi(2)) / 2
        + field / 2 * ((x * dot(y) - y * dot(x)) + (y * dot(z) - z * dot(y)) + (z * dot(x) - x * dot(z)));
    nonholonomic = dot(z) - y * dot(x);
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactOscillator {
    /// The stiffness along `y`, relative to that along `x` \[1\].
    pub stiffness_y: f64,
    /// The stiffness along `z`, relative to that along `x` \[1\].
    pub stiffness_z: f64,
    /// Each component of the magnetic field, as a frequency \[1\].
    pub field: f64,
}

impl Default for ContactOscillator {
    /// Stiffnesses without a small ratio, and a field of half the frequency.
    fn default() -> Self {
        Self {
            stiffness_y: 2.0,
            stiffness_z: 3.0,
            field: 0.5,
        }
    }
}
