//! A train of masses with springs and dampers between them, moved to and fro at one end.

use dsocs_core::dsocs;

/// A train at rest that is set moving. Its transient motion dies out.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(Train::default())
        .named("train")
        .described("a train of five masses with springs and dampers, drawn to and fro at one end")
        .source("textbooks on vibrations; the steady motion as in a ladder of impedances")
        .start([0.0; 5], [0.0; 5])
        .step(0.02)
        .until(40.0)
}

/// Five equal masses on a line, joined by equal springs and dampers, the last one joined to a wall; the point to which the
/// first is joined moves as `a cos Ωt`.
///
/// The springs and the moving point are in the Lagrangian, so it depends on time. The dampers are external forces, linear in the velocities.
/// With the complex wave number `2 (1 − cos μ)(k + i c Ω) = m Ω²` the steady motion is `x_j = Re a sin((6 − j) μ)/sin(6 μ)
/// e^{iΩt}`, `j = 1, …, 5` ([`Train::amplitudes`]); every other motion tends to it.
#[dsocs {
    coordinates(
        /// The displacement of each mass, from the driven end [m].
        x: [5],
    );
    let drive = amplitude * (frequency * t).cos();
    let first = x[0] - drive;
    let stretch = |i| x[i + 1] - x[i];
    let springs = first.powi(2) + sum(0..4, |i| stretch(i).powi(2)) + x[4].powi(2);
    lagrangian = mass / 2 * sum(0..5, |i| dot(x[i]).powi(2)) - stiffness / 2 * springs;
    let pull = |i| damping * dot(stretch(i));
    external_forces = ([
        pull(0) - damping * dot(first),
        pull(1) - pull(0),
        pull(2) - pull(1),
        pull(3) - pull(2),
        -damping * dot(x[4]) - pull(3),
    ],);
    /// The displacement of the driven end [m].
    let end = drive;
    observe = [end];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Train {
    /// Each mass \[kg\].
    pub mass: f64,
    /// The stiffness of each spring [N/m].
    pub stiffness: f64,
    /// The coefficient of each damper [N s/m].
    pub damping: f64,
    /// The amplitude `a` of the driven end \[m\].
    pub amplitude: f64,
    /// The angular frequency `Ω` of the drive [rad/s].
    pub frequency: f64,
}

impl Default for Train {
    /// Driven between its second and its third resonance.
    fn default() -> Self {
        Self {
            mass: 1.0,
            stiffness: 4.0,
            damping: 0.3,
            amplitude: 0.1,
            frequency: 2.4,
        }
    }
}

impl Train {
    /// The complex amplitudes of the steady motion, real and imaginary parts, in m: `x_j = Re (A_j e^{iΩt})`.
    ///
    /// `sin(n μ)/sin μ` are the Chebyshev polynomials of the second kind of `cos μ`, so no complex sine is needed: `A_j =
    /// a U_{5−j}/U_5`.
    #[must_use]
    pub fn amplitudes(&self) -> [[f64; 2]; 5] {
        let Self {
            mass: m,
            stiffness: k,
            damping: c,
            amplitude,
            frequency,
        } = *self;
        let times = |[a, b]: [f64; 2], [u, v]: [f64; 2]| [a * u - b * v, a * v + b * u];
        let over = |[a, b]: [f64; 2], [u, v]: [f64; 2]| {
            let square = u * u + v * v;
            [(a * u + b * v) / square, (b * u - a * v) / square]
        };
        // 2 cos μ = 2 − m Ω²/(k + i c Ω)
        let [re, im] = over([m * frequency * frequency, 0.0], [k, c * frequency]);
        let double = [2.0 - re, -im];
        // U_0 = 1, U_1 = 2 cos μ, U_{n+1} = 2 cos μ U_n − U_{n−1}
        let mut u = [[1.0, 0.0], double, [0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]];
        for n in 1..5 {
            let next = times(double, u[n]);
            u[n + 1] = [next[0] - u[n - 1][0], next[1] - u[n - 1][1]];
        }
        core::array::from_fn(|j| times([amplitude, 0.0], over(u[4 - j], u[5])))
    }

    /// Position and velocity of the steady motion at a time.
    #[must_use]
    pub fn steady(&self, t: f64) -> ([f64; 5], [f64; 5]) {
        let (sin, cos) = (self.frequency * t).sin_cos();
        let amplitudes = self.amplitudes();
        (
            amplitudes.map(|[re, im]| re * cos - im * sin),
            amplitudes.map(|[re, im]| -self.frequency * (re * sin + im * cos)),
        )
    }
}
