//! The planar pendulum in Cartesian coordinates: the rod is a holonomic constraint.

use dsocs_core::dsocs;

/// A swing to beyond the level of the pivot.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(PlanarPendulum::default())
        .named("planar-pendulum")
        .described("the planar pendulum in Cartesian coordinates, its rod a constraint")
        .source("textbooks, e.g. Landau and Lifshitz, Mechanics, section 11, problem 1")
        .start([0.6, -0.8], [4.0, 3.0])
        .step(0.01)
        .until(20.0)
        .drawn(|&at: &[f64; 2], _| {
            crate::entry::Drawing::new()
                .trail(at)
                .rod([0.0, 0.0], at)
                .point(at)
        })
}

/// A point mass on a massless rod, in a vertical plane.
///
/// The pivot is the origin and `y` points upwards. The constraint is written such that its form is a unit vector along the rod:
/// `λ_0` is the force of the rod in N, positive where it pushes outwards, and minus [`PlanarPendulum::tension`]. With the angle `θ` from
/// the lowest point, `θ̈ = −(g/l) sin θ`; the energy is invariant, and a swing has the period [`PlanarPendulum::period`].
///
/// With the paper's maps the step is that of Störmer and Verlet with the constraint at every node, known as SHAKE (Ryckaert,
/// Ciccotti and Berendsen 1977).
#[dsocs {
    coordinates(
        /// The horizontal position [m].
        x,
        /// The height above the pivot [m].
        y,
    );
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - mass * gravity * y;
    holonomic = (x.powi(2) + y.powi(2) - length.powi(2)) / (2 * length);
    /// The angle from the lowest point [rad].
    let angle = x.atan2(-y);
    observe = [angle];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarPendulum {
    /// The mass of the bob \[kg\].
    pub mass: f64,
    /// The length of the rod \[m\].
    pub length: f64,
    /// The acceleration of gravity [m/s²].
    pub gravity: f64,
}

impl Default for PlanarPendulum {
    /// One kilogram on one metre.
    fn default() -> Self {
        Self {
            mass: 1.0,
            length: 1.0,
            gravity: 9.81,
        }
    }
}

impl PlanarPendulum {
    /// The tension of the rod, in N, at a position and a velocity that obey the constraint: `m (v² − g y)/l`.
    #[must_use]
    pub fn tension(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        self.mass * (v[0] * v[0] + v[1] * v[1] - self.gravity * q[1]) / self.length
    }

    /// The period, in s, of a swing to the angle `amplitude`, in radians below π: `2π √(l/g) / agm(1, cos(amplitude/2))`.
    #[must_use]
    pub fn period(&self, amplitude: f64) -> f64 {
        let (mut a, mut b) = (1.0_f64, (amplitude / 2.0).cos());
        // the means agree to twice as many digits each time
        for _ in 0..8 {
            (a, b) = (f64::midpoint(a, b), (a * b).sqrt());
        }
        core::f64::consts::TAU * (self.length / self.gravity).sqrt() / a
    }
}
