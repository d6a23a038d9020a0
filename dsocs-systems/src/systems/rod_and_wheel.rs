//! The paper's pendulum in Cartesian coordinates: its rod is a holonomic constraint beside the Lyapunov constraint.

use dsocs_core::dsocs;

use super::InertiaWheelPendulum;
/// The paper's start, in Cartesian coordinates.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(RodAndWheel::default())
        .named("rod-and-wheel")
        .described("the inertia wheel pendulum with a Lyapunov constraint, its rod a constraint too")
        .source("Borda, Fernández and Grillo, section 5.2, in Cartesian coordinates")
        // the sine and the cosine of 0.5, at rest but for the wheel
        .start(
            [0.479_425_538_604_203, 0.877_582_561_890_372_8, 0.0],
            [0.0, 0.0, 0.5],
        )
        .step(0.001)
        .until(10.0)
        .drawn(|&[x, y, psi]: &[f64; 3], _| super::wheel_on_a_rod(x.atan2(y), psi))
        .symmetry("turning the wheel", |_: &[f64; 3]| [0.0, 0.0, 1.0])
}

/// [`InertiaWheelPendulum`] with the end of its rod at `(x, y)`, in units of the rod's length: constraints of two orders in one
/// declaration, each with its own rule.
///
/// `y` points upwards and `x = sin θ`, `y = cos θ`. The rod's force `λ_0 = M cos θ − I θ̇²` (times the rod's length, positive where it pushes
/// outwards) follows by d'Alembert's principle; the motor turns the wheel with the torque `λ_1`. The discrete Lagrangian is the mean over both
/// nodes, which makes the legs symmetric. With the paper's map, `λ_0` would be of first order only, because the mass matrix depends on the
/// position. As in the paper's pendulum, the Lyapunov constraint gives a step two roots, but here the factor `w` is
/// not divided out.
#[dsocs {
    coordinates(
        /// The horizontal position of the rod's end, in lengths of the rod [1].
        x,
        /// The height of the rod's end above the pivot, in lengths of the rod [1].
        y,
        /// The angle of the wheel relative to the rod [rad].
        psi,
    );
    /// The angle of the rod from the upright [rad].
    let theta = x.atan2(y);
    let theta_rate = (y * dot(x) - x * dot(y)) / (x.powi(2) + y.powi(2));
    lagrangian = i / 2 * (dot(x).powi(2) + dot(y).powi(2)) + j / 2 * (theta_rate + dot(psi)).powi(2) - m * (1 + y);

    let a = 1 / i;
    let b = -1 / i;
    let c = 1 / i + 1 / j;
    let g_c = d * (n * a - b) * (i * j);
    let h_c = d * (n * b - c) * (i * j);
    let f = (g_c.powi(2) + e) / h_c;
    let p1 = (i + j) * theta_rate + j * dot(psi);
    let p2 = j * (theta_rate + dot(psi));
    /// The factor of the constraint [1/s].
    let w = g_c * p1 + h_c * p2;
    /// The Lyapunov function `V` [J].
    let lyapunov = f / 2 * p1.powi(2) + h_c / 2 * p2.powi(2) + g_c * p1 * p2
        + chi * (1 - (psi - n * theta).cos())
        + m * e / d * (1 - y);
    let dissipation = rho * w * w.tanh();

    holonomic = (x.powi(2) + y.powi(2) - 1) / 2;
    kinematic = dot(lyapunov) + dissipation; // dV/dt = −F
    constraint_forces = [(0, 0, 1)];         // the motor turns the wheel
    phi_lagrangian = trapezoid;
    observe = [theta, w, lyapunov];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RodAndWheel {
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

impl Default for RodAndWheel {
    /// The paper's parameters.
    fn default() -> Self {
        InertiaWheelPendulum::default().into()
    }
}

impl From<InertiaWheelPendulum> for RodAndWheel {
    /// The pendulum in Cartesian coordinates, with the parameters of the one in angles.
    fn from(pendulum: InertiaWheelPendulum) -> Self {
        let InertiaWheelPendulum {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            rho,
        } = pendulum;
        Self {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            rho,
        }
    }
}
