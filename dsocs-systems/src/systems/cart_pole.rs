//! The cart-pole, swung up by its energy: a Lyapunov constraint of second order.

use dsocs_core::dsocs;

/// A pole that swings up from near the bottom.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(CartPole::default())
        .named("cart-pole")
        .described("a cart-pole that a Lyapunov constraint on the pole's energy swings up")
        .source("the law: Åström and Furuta, Swinging up a pendulum by energy control, Automatica 36 (2000)")
        .start([0.0, 2.8], [0.0, 0.0])
        .step(0.01)
        .until(10.0)
        .drawn(|&[x, theta]: &[f64; 2], parameters| {
            let length = parameters.get("length");
            let end = [x + length * theta.sin(), length * theta.cos()];
            let cart = crate::entry::Drawing::new()
                .trail(end)
                .rod([x - length / 3.0, 0.0], [x + length / 3.0, 0.0]);
            cart.rod([x, 0.0], end).point(end)
        })
        .symmetry("translation of the cart", |_: &[f64; 2]| [1.0, 0.0])
}

/// A pole on a cart, whose motor makes the pole's energy that of the upright position.
///
/// `x` is the cart's position and `θ` the pole's angle from the upright. Åström and Furuta take the pole's energy
/// `E = J θ̇²/2 + m g l (cos θ − 1)`, which is zero upright at rest, and accelerate the pivot by `ẍ = k E θ̇ cos θ`. Since
/// `Ė = −m l θ̇ cos θ ẍ`, the function `V = E²/2` then falls at the rate `F = k m l (E θ̇ cos θ)²`.
///
/// Their law prescribes the acceleration of the pivot. Here the law is the Lyapunov constraint `dV/dt = −F` of the whole system, cart and
/// pole, and the constraint force is the motor's force on the cart. So a run computes the force that the law needs. `V̇ + F` has the factor
/// `−m l E θ̇ cos θ`, which vanishes whenever the pole is level or at rest. The constraint is declared with this factor divided out, which
/// leaves the law itself. There is no saturation, and nothing brings the cart back. Near the upright position the pole slows down along its
/// separatrix; another control law has to catch it there.
#[dsocs {
    coordinates(
        /// The position of the cart [m].
        x,
        /// The angle of the pole from the upright [rad].
        theta,
    );
    let arm = mass * length;
    let kinetic = (cart + mass) / 2 * dot(x).powi(2) + arm * theta.cos() * dot(x) * dot(theta)
        + inertia / 2 * dot(theta).powi(2);
    lagrangian = kinetic - arm * gravity * theta.cos();
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);

    let energy = inertia / 2 * dot(theta).powi(2) + arm * gravity * (theta.cos() - 1);
    /// The Lyapunov function `V`, half the square of the energy `E` [J²].
    let lyapunov = energy.powi(2) / 2;
    /// The rate `F` at which `V` falls [J²/s].
    let dissipation = gain * arm * (energy * dot(theta) * theta.cos()).powi(2);
    kinematic = ddot(x) - gain * energy * dot(theta) * theta.cos(); // (dV/dt + F) / (−m l E θ̇ cos θ)
    constraint_forces = [(1, 0)];                                   // the motor drives the cart
    observe = [lyapunov, dissipation];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CartPole {
    /// The mass of the cart \[kg\].
    pub cart: f64,
    /// The mass of the pole \[kg\].
    pub mass: f64,
    /// The distance of the pole's centre of mass from the pivot \[m\].
    pub length: f64,
    /// The pole's moment of inertia about the pivot [kg m²].
    pub inertia: f64,
    /// The acceleration of gravity [m/s²].
    pub gravity: f64,
    /// The gain `k` of the law [m/(J s)].
    pub gain: f64,
}

impl Default for CartPole {
    /// A point mass of 0.2 kg on half a metre, on a cart of 1 kg.
    fn default() -> Self {
        Self {
            cart: 1.0,
            mass: 0.2,
            length: 0.5,
            inertia: 0.05,
            gravity: 9.81,
            gain: 2.0,
        }
    }
}

impl CartPole {
    /// The right-hand side of the motion under the law, for the state `(x, θ, ẋ, θ̇)`, and the motor's force, in N. The pole
    /// moves with its pivot. The force accelerates the cart against the pull of the pole.
    ///
    /// It is written from the law, independently of the declaration.
    #[must_use]
    pub fn law(&self, [_, theta, speed, rate]: [f64; 4]) -> ([f64; 4], f64) {
        let (sin, cos) = theta.sin_cos();
        let arm = self.mass * self.length;
        let energy = self.inertia / 2.0 * rate * rate + arm * self.gravity * (cos - 1.0);
        let pivot = self.gain * energy * rate * cos;
        let turn = arm * (self.gravity * sin - cos * pivot) / self.inertia;
        let force = (self.cart + self.mass) * pivot + arm * (cos * turn - sin * rate * rate);
        ([speed, rate, pivot, turn], force)
    }
}
