//! The inertia wheel pendulum with a Lyapunov constraint (paper, section 5.2).

use dsocs_core::{Point, System, dsocs, statements};

/// The paper's example.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::in_lanes(InertiaWheelPendulum::default())
        .named("pendulum")
        .described("the inertia wheel pendulum with a Lyapunov constraint")
        .source("Borda, Fernández and Grillo, section 5.2")
        .start([0.5, 0.0], [0.0, 0.5])
        .step(0.1)
        .until(2000.0)
        .drawn(|&[theta, psi]: &[f64; 2], _| super::wheel_on_a_rod(theta, psi))
        .symmetry("turning the wheel", |_: &[f64; 2]| [0.0, 1.0])
}

statements! {
    /// The inertia wheel pendulum and the Lyapunov function `V` of its control law: what its declarations share.
    ///
    /// `θ` is the pendulum's angle from the upright position, `ψ` the wheel's angle relative to the pendulum.
    pub inertia_wheel_pendulum {
        coordinates(
            /// The angle of the pendulum from the upright [rad].
            theta,
            /// The angle of the wheel relative to the pendulum [rad].
            psi,
        );
        lagrangian = i / 2 * dot(theta).powi(2) + j / 2 * (dot(theta) + dot(psi)).powi(2) - m * (1 + theta.cos());

        // The inverse mass matrix [[a, b], [b, c]], whose determinant is 1 / (i j).
        let a = 1 / i;
        let b = -1 / i;
        let c = 1 / i + 1 / j;
        let g_c = d * (n * a - b) * (i * j);
        let h_c = d * (n * b - c) * (i * j);
        let f = (g_c.powi(2) + e) / h_c;

        // The momenta, and the factor of the constraint.
        let p1 = (i + j) * dot(theta) + j * dot(psi);
        let p2 = j * (dot(theta) + dot(psi));
        /// The factor of the constraint [1/s].
        let w = g_c * p1 + h_c * p2;

        /// The Lyapunov function `V` [J].
        let lyapunov = f / 2 * p1.powi(2) + h_c / 2 * p2.powi(2) + g_c * p1 * p2
            + chi * (1 - (psi - n * theta).cos())
            + m * e / d * (1 - theta.cos());
    }
}

/// The inertia wheel pendulum, stabilised upright by the Lyapunov constraint `dV/dt = −F`.
///
/// `θ` is the pendulum's angle from the upright position, `ψ` the wheel's angle relative to the pendulum, both in
/// radians. The motor turns the wheel: the constraint force acts on `ψ` alone and is the control torque. `V` has the
/// dimension of an energy if `d` and `e` are given in the units below.
///
/// After the variational equation the constraint has a factor `w`; its root `w = 0` is a smooth motion that is not the
/// pendulum's, and is divided out.
#[dsocs {
    use inertia_wheel_pendulum;
    /// The rate `F` at which `V` falls [J/s].
    let dissipation = rho * w * w.tanh();

    kinematic = dot(lyapunov) + dissipation; // dV/dt = −F
    constraint_forces = [(0, 1)];            // the motor turns the wheel
    branch = divide(w);
    observe = [lyapunov, dissipation, w];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaWheelPendulum {
    /// Moment of inertia `I` of the pendulum with the wheel's mass in its axle [kg m²].
    pub i: f64,
    /// Moment of inertia `J` of the wheel [kg m²].
    pub j: f64,
    /// Weight times lever `M`, the largest gravity torque [N m].
    pub m: f64,
    /// Scale `d > 0` of the kinetic part of `V` [1/(kg m²)²].
    pub d: f64,
    /// Coefficient `e > 0` of the square of the first momentum in `V` [1/(kg m²)²].
    pub e: f64,
    /// Coefficient `χ > 0` of `1 − cos(ψ − nθ)` in `V` \[J\].
    pub chi: f64,
    /// Integer `n` with `n b > c`, which couples the wheel to the pendulum in `V` \[1\].
    pub n: f64,
    /// Coefficient `ρ > 0` of the dissipation `F = ρ w tanh w` \[J\].
    pub rho: f64,
}

impl Default for InertiaWheelPendulum {
    /// The paper's parameters.
    fn default() -> Self {
        Self {
            i: 312.5,
            j: 2.0772,
            m: 37.98,
            d: 1.0,
            e: 1000.0,
            chi: 100.0,
            n: -154.0,
            rho: 2.0,
        }
    }
}

impl InertiaWheelPendulum {
    /// The Lyapunov function `V(q, v)`, in J.
    #[must_use]
    pub fn lyapunov(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        self.observed(q, v)[0]
    }

    /// The dissipation `F(q, v) ≥ 0`, in J/s, at which `V` falls.
    #[must_use]
    pub fn dissipation(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        self.observed(q, v)[1]
    }

    /// The factor `w` of the constraint, in 1/s: zero on the spurious branch.
    #[must_use]
    pub fn factor(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        self.observed(q, v)[2]
    }

    /// The observed expressions, none of which depends on the acceleration.
    fn observed(&self, q: [f64; 2], v: [f64; 2]) -> [f64; 3] {
        let mut observed = [0.0; 3];
        self.observe(
            &Point {
                t: 0.0,
                q,
                v,
                a: [0.0; 2],
            },
            &mut observed,
        );
        observed
    }

    /// The momenta `(p₁, p₂)` of a velocity, in kg m²/s.
    #[must_use]
    pub fn momentum(&self, v: [f64; 2]) -> [f64; 2] {
        let p2 = self.j * (v[0] + v[1]);
        [self.i * v[0] + p2, p2]
    }

    /// The velocity that belongs to momenta, in rad/s.
    #[must_use]
    pub fn velocity(&self, p: [f64; 2]) -> [f64; 2] {
        let theta = (p[0] - p[1]) / self.i;
        [theta, p[1] / self.j - theta]
    }

    /// The right-hand side of the continuous system on its proper branch, for the state `(θ, ψ, p₁, p₂)`:
    /// `p₁' = M sin θ`, `p₂' = T(θ, ψ) − ρ tanh w`.
    ///
    /// It is written from the factorisation of the constraint, independently of the declaration.
    #[must_use]
    pub fn proper_branch(&self, state: [f64; 4]) -> [f64; 4] {
        let [theta, psi, p1, p2] = state;
        let Self {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            rho,
        } = *self;
        let b = -1.0 / i;
        let determinant = 1.0 / (i * j);
        let g_c = d * (n + 1.0) / i / determinant;
        let h_c = d * (n * b - (1.0 / i + 1.0 / j)) / determinant;
        let w = g_c * p1 + h_c * p2;
        let torque = chi * (determinant / d) * (psi - n * theta).sin()
            - m * theta.sin() * (g_c / h_c + e * b / (d * h_c));
        let [theta_rate, psi_rate] = self.velocity([p1, p2]);
        [theta_rate, psi_rate, m * theta.sin(), torque - rho * w.tanh()]
    }
}
