//! The paper's pendulum with a Lyapunov function that decreases by exactly `h F` in every step.

use dsocs_core::dsocs;

use super::InertiaWheelPendulum;
/// The paper's example.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(ExactDecrease::default())
        .named("exact-decrease")
        .described(
            "the inertia wheel pendulum, with a discrete constraint by which V falls exactly in every step",
        )
        .source("Borda, Fernández and Grillo, section 5.2, with another discretization of the constraint")
        .start([0.5, 0.0], [0.0, 0.5])
        .step(0.001)
        .until(100.0)
        .drawn(|&[theta, psi]: &[f64; 2], _| super::wheel_on_a_rod(theta, psi))
        .symmetry("turning the wheel", |_: &[f64; 2]| [0.0, 1.0])
}

/// [`InertiaWheelPendulum`] with the discrete constraint `V(q1, q2) − V(q0, q1) = −h F(q0, q1, q2)` in the place of the paper's
/// `dV/dt = −F` at a triple: `V` falls in every step by exactly what it should, at any `h`.
///
/// `V` is evaluated at the middle of each leg, `F` at the triple. Then the constraint is nearly a product of `w` and a factor with the motor's force,
/// while the paper's constraint is exactly such a product; the remainder at `w = 0` is of third order in `h`. So `branch = divide(w)` keeps the root
/// `w ≈ 0` away. But where `w` passes through zero, first at about `t = 29`, because of this remainder the equation may have no real solution: `V`
/// cannot decrease by that much. Then the run ends with an error. From the paper's start it ends at `t = 29.3` with `h = 0.1` to `0.01`, at 48.6 with
/// 0.005 and at 41.5 with 0.002; with 0.001, 0.0005 and 0.0002 it goes on to `t = 500` at least, where `V` is 262.939 (263 on the continuous motion).
/// Without the factor two roots come too close to tell them apart, for `h = 0.001` at `t = 64.0`.
#[dsocs {
    use super::pendulum::inertia_wheel_pendulum;
    /// The rate `F` at which `V` falls [J/s].
    let dissipation = rho * w * w.tanh();

    kinematic = dot(lyapunov) + dissipation; // dV/dt = −F
    discrete_kinematic = leg(lyapunov, 1) - leg(lyapunov, 0) + h * node(dissipation);
    phi_lagrangian = midpoint;
    branch = divide(w);
    constraint_forces = [(0, 1)]; // the motor turns the wheel
    observe = [lyapunov, dissipation, w];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactDecrease {
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

impl Default for ExactDecrease {
    /// The paper's parameters.
    fn default() -> Self {
        let InertiaWheelPendulum {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            rho,
        } = InertiaWheelPendulum::default();
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
