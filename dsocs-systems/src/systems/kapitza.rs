//! A pendulum whose pivot vibrates: upright it is stable if the vibration is fast enough (Kapitza).

use dsocs_core::dsocs;

/// A pendulum near the upright position, which the vibration holds there.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(Kapitza::default())
        .named("kapitza")
        .described("a pendulum held upright by the vibration of its pivot")
        .source("Kapitza (1951); Landau and Lifshitz, Mechanics, section 30, problem 1")
        .start([0.3], [0.0])
        .step(0.0005)
        .until(10.0)
}

/// A pendulum on a pivot that moves up and down as `a cos ωt`.
///
/// `θ` is the angle from the upright position and obeys `θ̈ = (g − a ω² cos ωt)/l sin θ`. If the vibration is fast and
/// small, the pendulum moves slowly in the effective potential `m g l (cos θ + a² ω²/(4 g l) sin²θ)`. The upright position is stable if the
/// amplitude is larger than [`Kapitza::critical_amplitude`], at which `a² ω² = 2 g l`. About the stable upright position the pendulum swings with
/// [`Kapitza::slow_frequency`].
///
/// The Lagrangian depends on time through the pivot. The reported energy is `E = ⟨∂L/∂v, v⟩ − L`, which is not the
/// mechanical energy. It is not constant, because the pivot's motion does work: `dE/dt = −∂L/∂t`. The momentum depends on time and angle, so the default map is
/// `midpoint`.
#[dsocs {
    coordinates(
        /// The angle from the upright position [rad].
        theta,
    );
    let x = length * theta.sin();
    let y = amplitude * (frequency * t).cos() + length * theta.cos();
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - mass * gravity * y;
    /// The height of the pivot [m].
    let pivot = amplitude * (frequency * t).cos();
    observe = [pivot];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kapitza {
    /// The mass of the bob \[kg\].
    pub mass: f64,
    /// The length of the rod \[m\].
    pub length: f64,
    /// The acceleration of gravity [m/s²].
    pub gravity: f64,
    /// The amplitude `a` of the pivot \[m\].
    pub amplitude: f64,
    /// The angular frequency `ω` of the pivot [rad/s].
    pub frequency: f64,
}

impl Default for Kapitza {
    /// One metre, shaken by 5 cm at 24 Hz: 1.7 times the critical amplitude.
    fn default() -> Self {
        Self {
            mass: 1.0,
            length: 1.0,
            gravity: 9.81,
            amplitude: 0.05,
            frequency: 150.0,
        }
    }
}

impl Kapitza {
    /// The amplitude above which upright is stable, `√(2 g l)/ω`, in m, for a vibration that is fast.
    #[must_use]
    pub fn critical_amplitude(&self) -> f64 {
        (2.0 * self.gravity * self.length).sqrt() / self.frequency
    }

    /// The angular frequency of small slow swings about the upright position, `√(a² ω²/(2 l²) − g/l)`, in rad/s, for a
    /// vibration that is fast; `None` below the critical amplitude.
    #[must_use]
    pub fn slow_frequency(&self) -> Option<f64> {
        let held = (self.amplitude * self.frequency / self.length).powi(2) / 2.0;
        let square = held - self.gravity / self.length;
        (square > 0.0).then(|| square.sqrt())
    }
}
