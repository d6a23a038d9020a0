//! The snakeboard, driven by springs.

use dsocs_core::dsocs;

/// A board at rest whose springs are wound up, both at the same frequency: it drives off.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(Snakeboard::default())
        .named("snakeboard")
        .described("the snakeboard, with springs on its rotor and its axles")
        .source(
            "Bloch, Krishnaprasad, Marsden and Murray, Nonholonomic mechanical systems with symmetry (1996); \
             controlled there, driven by springs here",
        )
        .start([0.0, 0.0, 0.0, 1.0, 0.5], [0.0, 0.0, 0.0, 0.0, 0.0])
        .step(0.02)
        .until(40.0)
        .drawn(|&[x, y, theta, psi, phi]: &[f64; 5], parameters| {
            // axles at both ends of the board, turned in opposite directions; the rotor in its middle
            let length = parameters.get("length");
            let end = |sign: f64| [x + sign * length * theta.cos(), y + sign * length * theta.sin()];
            let axle = |sign: f64| {
                let ([a, b], across) = (end(sign), theta + sign * phi + std::f64::consts::FRAC_PI_2);
                let half = [length / 3.0 * across.cos(), length / 3.0 * across.sin()];
                [[a - half[0], b - half[1]], [a + half[0], b + half[1]]]
            };
            let [front, back] = [axle(1.0), axle(-1.0)];
            crate::entry::Drawing::new()
                .trail([x, y])
                .rod(end(-1.0), end(1.0))
                .rod(front[0], front[1])
                .rod(back[0], back[1])
                .wheel([x, y], length / 3.0, theta + psi)
        })
        .symmetry("translation along x", |_: &[f64; 5]| [1.0, 0.0, 0.0, 0.0, 0.0])
        .symmetry("rotation about the origin", |[x, y, ..]: &[f64; 5]| {
            [-y, *x, 1.0, 0.0, 0.0]
        })
}

/// A board on two axles with wheels, which turn by `φ` in front and `−φ` behind, and a rotor on top.
///
/// `(x, y)` is the middle of the board and `θ` its direction; `ψ` is the rotor's angle relative to the board. The wheels do not slip sideways. The
/// front wheels are at the distance `l` before the middle, and the rear wheels at the same distance behind it. So
///
/// `−sin(θ ± φ) ẋ + cos(θ ± φ) ẏ ± l cos φ θ̇ = 0`.
///
/// In the source `ψ` and `φ` are controlled. Here torsional springs drive them, so the system is closed and its
/// energy is an invariant. If both swing at about the same frequency, the board gains speed. The constraints leave only
/// a speed `u` along the board, with `θ̇ = u tan φ / l`, which gives the equations of [`Snakeboard::reduced`].
#[dsocs {
    coordinates(
        /// The first position of the middle of the board [m].
        x,
        /// The second position of the middle of the board [m].
        y,
        /// The direction of the board [rad].
        theta,
        /// The angle of the rotor relative to the board [rad].
        psi,
        /// The angle of the front axle relative to the board [rad].
        phi,
    );
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2))
        + inertia / 2 * dot(theta).powi(2)
        + rotor / 2 * (dot(theta) + dot(psi)).powi(2)
        + axle / 2 * ((dot(theta) + dot(phi)).powi(2) + (dot(theta) - dot(phi)).powi(2))
        - rotor_spring / 2 * psi.powi(2)
        - axle_spring / 2 * phi.powi(2);
    nonholonomic = [
        -(theta + phi).sin() * dot(x) + (theta + phi).cos() * dot(y) + length * phi.cos() * dot(theta),
        -(theta - phi).sin() * dot(x) + (theta - phi).cos() * dot(y) - length * phi.cos() * dot(theta),
    ];
    /// The speed along the board [m/s].
    let speed = dot(x) * theta.cos() + dot(y) * theta.sin();
    observe = [speed];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snakeboard {
    /// The mass of all parts \[kg\].
    pub mass: f64,
    /// The moment of inertia of the board [kg m²].
    pub inertia: f64,
    /// The moment of inertia of the rotor [kg m²].
    pub rotor: f64,
    /// The moment of inertia of each axle [kg m²].
    pub axle: f64,
    /// The distance `l` of each axle from the middle \[m\].
    pub length: f64,
    /// The stiffness of the rotor's spring [N m].
    pub rotor_spring: f64,
    /// The stiffness of the spring of both axles together [N m].
    pub axle_spring: f64,
}

impl Default for Snakeboard {
    /// Six kilograms on a board of 40 cm; both springs swing at about 2 rad/s.
    fn default() -> Self {
        Self {
            mass: 6.0,
            inertia: 0.016,
            rotor: 0.072,
            axle: 0.0013,
            length: 0.2,
            rotor_spring: 0.288,
            axle_spring: 0.0104,
        }
    }
}

impl Snakeboard {
    /// The right-hand side of the motion for the state `(x, y, θ, ψ, φ, u, ψ̇, φ̇)`.
    ///
    /// It is derived from d'Alembert's principle by hand, without multipliers and independently of the declaration. The work along
    /// `(cos θ, sin θ, tan φ / l, 0, 0)` gives
    /// `(m + K tan²φ / l²) u̇ = (tan φ / l)(k_ψ ψ − K u φ̇ / (l cos²φ))`, where `K` is the inertia of the board and its axles.
    #[must_use]
    pub fn reduced(&self, state: [f64; 8]) -> [f64; 8] {
        let [_, _, theta, psi, phi, speed, psi_rate, phi_rate] = state;
        let steer = phi.tan() / self.length;
        let steering = phi_rate / (self.length * phi.cos().powi(2));
        let board = self.inertia + 2.0 * self.axle;
        let gain = steer * (self.rotor_spring * psi - board * speed * steering)
            / (self.mass + board * steer * steer);
        let turn = gain * steer + speed * steering;
        [
            speed * theta.cos(),
            speed * theta.sin(),
            speed * steer,
            psi_rate,
            phi_rate,
            gain,
            -self.rotor_spring * psi / self.rotor - turn,
            -self.axle_spring * phi / (2.0 * self.axle),
        ]
    }
}
