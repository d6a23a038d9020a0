//! The paper's pendulum with friction: in the motor, in the pivot with compensation, and in the pivot without compensation.

use dsocs_core::dsocs;

use super::InertiaWheelPendulum;

/// The paper's example with friction in the motor.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn motor_entry() -> crate::Entry {
    crate::Entry::new(FrictionPendulum {
        pivot: 0.0,
        ..FrictionPendulum::default()
    })
    .named("motor-friction")
    .described("the inertia wheel pendulum with a Lyapunov constraint and friction in its motor")
    .source("Borda, Fernández and Grillo, section 5.2, with friction")
    .start([0.5, 0.0], [0.0, 0.5])
    .step(0.05)
    .until(200.0)
    .symmetry("turning the wheel", |_: &[f64; 2]| [0.0, 1.0])
}

/// The paper's example with friction in the motor and in the pivot.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn pivot_entry() -> crate::Entry {
    crate::Entry::new(FrictionPendulum::default())
        .named("pivot-friction")
        .described("the inertia wheel pendulum with friction in its pivot, for which its Lyapunov constraint makes up")
        .source("Borda, Fernández and Grillo, section 5.2, with friction")
        .start([0.5, 0.0], [0.0, 0.5])
        .step(0.05)
        .until(200.0)
        .symmetry("turning the wheel", |_: &[f64; 2]| [0.0, 1.0])
}

/// The paper's example with friction in the pivot that is not compensated, before its motion ends.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn stalled_entry() -> crate::Entry {
    crate::Entry::new(StalledPendulum::default())
        .named("stalled-friction")
        .described("the inertia wheel pendulum with friction in its pivot that its Lyapunov constraint does not know of")
        .source("Borda, Fernández and Grillo, section 5.2, with friction")
        .start([0.5, 0.0], [0.0, 0.5])
        .step(0.05)
        .until(20.0)
        .symmetry("turning the wheel", |_: &[f64; 2]| [0.0, 1.0])
}

/// Declares the inertia wheel pendulum with friction. The argument `made_up_for` is the part of the pivot's
/// friction that the constraint compensates; the `branch` is left to each declaration.
macro_rules! pendulum {
    ($(#[$doc:meta])* $name:ident, $made_up_for:literal, $($branch:tt)*) => {
        $(#[$doc])*
        #[dsocs {
            use super::pendulum::inertia_wheel_pendulum;
            external_forces = (-pivot * dot(theta), -motor * dot(psi));

            /// The rate at which the pivot's friction changes `V` [J/s].
            let by_friction = -pivot * dot(theta) * (f * p1 + g_c * p2);
            /// The rate `F` at which `V` is to fall [J/s].
            let dissipation = rho * w * w.tanh() - $made_up_for * by_friction;

            kinematic = dot(lyapunov) + dissipation; // dV/dt = −F
            constraint_forces = [(0, 1)];            // the motor turns the wheel
            $($branch)*
            observe = [lyapunov, dissipation, by_friction, w];
        }]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
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
            /// Coefficient `ρ > 0` of the dissipation \[J\].
            pub rho: f64,
            /// Coefficient of the friction in the pivot, which acts against `θ̇` [N m s].
            pub pivot: f64,
            /// Coefficient of the friction in the motor, which acts against `ψ̇` [N m s].
            pub motor: f64,
        }

        impl Default for $name {
            /// The paper's parameters, and little friction.
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
                    pivot: 0.001,
                    motor: 0.05,
                }
            }
        }
    };
}

pendulum! {
    /// [`InertiaWheelPendulum`] with friction in the motor and in the pivot; the constraint compensates for that in the pivot.
    ///
    /// Friction in the motor changes only the motor's torque; the motion is the same as without it. Friction in the pivot acts on the
    /// pendulum, where the motor does not act, and changes `V` at the rate `−c θ̇ ∂V/∂p₁`. Here `F` contains this rate,
    /// `dV/dt = −ρ w tanh w − c θ̇ ∂V/∂p₁`. So the constraint still has the factor `w`. Without this factor it is the motor's law of the
    /// case without friction, `ṗ₂ = T(θ, ψ) − ρ tanh w`, beside `ṗ₁ = M sin θ − c θ̇`. `V` may increase because of the friction.
    /// [`StalledPendulum`] shows what happens if the constraint does not compensate for it.
    FrictionPendulum, 1, branch = divide(w);
}

pendulum! {
    /// [`InertiaWheelPendulum`] with friction in the pivot that the constraint `dV/dt = −ρ w tanh w` does not contain: its motion ends.
    ///
    /// Where `w = 0` the motor cannot change `V`, but friction does. There the constraint is `c e p₁²/(d (I + (n+1) J)²) =
    /// 0`, which cannot be met. On the way there the torque grows like `1/w`, and `w` becomes zero after a finite time, beyond
    /// which no motion obeys the constraint, not even a continuous one. A discrete run ends there with an error that says so.
    StalledPendulum, 0,
}

impl FrictionPendulum {
    /// The right-hand side of the continuous system, for the state `(θ, ψ, p₁, p₂)`: `ṗ₁ = M sin θ − c θ̇`, `ṗ₂ = T(θ, ψ) − ρ
    /// tanh w`, where the second is that of the pendulum without friction.
    #[must_use]
    pub fn proper_branch(&self, state: [f64; 4]) -> [f64; 4] {
        let Self {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            rho,
            pivot,
            ..
        } = *self;
        let free = InertiaWheelPendulum {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            rho,
        };
        let [theta, psi, p1, p2] = free.proper_branch(state);
        [theta, psi, p1 - pivot * theta, p2]
    }
}
