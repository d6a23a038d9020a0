//! A rolling vehicle with two axles. Its steering is an input.

use dsocs_core::dsocs;

/// The path is a circle unless the steering changes, such as by `--input steering=plan.csv`.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    let vehicle = Vehicle::default();
    let start = vehicle.rolling([0.0, 0.0, 0.0], 10.0);
    crate::Entry::new(vehicle)
        .named("vehicle")
        .described("a vehicle with a steered front axle: an input that is held, such as at 20 Hz")
        .source(
            "LaValle, Planning Algorithms (2006), section 13.1.2; the impulse of the steering in closed form",
        )
        .start([0.0, 0.0, 0.0], start)
        .step(0.01)
        .until(20.0)
        .drawn(|&[x, y, theta]: &[f64; 3], parameters| {
            let base = parameters.get("base");
            let front = [x + base * theta.cos(), y + base * theta.sin()];
            crate::entry::Drawing::new().trail([x, y]).rod([x, y], front)
        })
        .symmetry("translation along x", |_: &[f64; 3]| [1.0, 0.0, 0.0])
        .symmetry("translation along y", |_: &[f64; 3]| [0.0, 1.0, 0.0])
}

/// A vehicle in the plane with a rear and a front axle. Its wheels roll without slipping.
///
/// `(x, y)` is the middle of the rear axle and the centre of mass; `θ` is the direction of the vehicle. The rear wheels can only move along `θ`.
/// The front wheels, a length `base` ahead, can only move along `θ + steering`. There is no driving force. While the steering is constant, the
/// vehicle moves on a circle with constant speed ([`Vehicle::held`]).
///
/// The steering is an input ([`dsocs_core::Inputs`]), for example of a controller at 20 Hz. When its value jumps, the angular velocity of the
/// vehicle jumps, too: the constraint forces have an impulse, which also changes the speed ([`Vehicle::steered`]).
#[dsocs {
    coordinates(
        /// The position of the rear axle along the first axis [m].
        x,
        /// The position of the rear axle along the second axis [m].
        y,
        /// The direction [rad].
        theta,
    );
    /// The speed of the rear axle [m/s].
    let speed = dot(x) * theta.cos() + dot(y) * theta.sin();
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) + inertia / 2 * dot(theta).powi(2);
    let front = theta + steering;
    nonholonomic = [
        dot(x) * theta.sin() - dot(y) * theta.cos(),
        dot(x) * front.sin() - dot(y) * front.cos() - base * dot(theta) * steering.cos(),
    ];
    observe = [speed];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vehicle {
    /// The mass \[kg\].
    pub mass: f64,
    /// The moment of inertia about the rear axle [kg m²].
    pub inertia: f64,
    /// The distance between the axles \[m\].
    pub base: f64,
    /// The angle between the front wheels and the vehicle \[rad\].
    pub steering: f64,
}

impl Default for Vehicle {
    /// A car on a circle with a radius of 25 m.
    fn default() -> Self {
        Self {
            mass: 1200.0,
            inertia: 2500.0,
            base: 2.5,
            steering: 0.1,
        }
    }
}

impl Vehicle {
    /// The velocity `(ẋ, ẏ, θ̇)` at the position `(x, y, θ)` [m, m, rad], if the rear axle has the speed `speed` [m/s].
    #[must_use]
    pub fn rolling(&self, [_, _, theta]: [f64; 3], speed: f64) -> [f64; 3] {
        let rate = speed * self.steering.tan() / self.base;
        [speed * theta.cos(), speed * theta.sin(), rate]
    }

    /// The position `(x, y, θ)` after the time `t` \[s\] with constant steering. The path is an arc of a circle.
    #[must_use]
    pub fn held(&self, [x, y, theta]: [f64; 3], speed: f64, t: f64) -> [f64; 3] {
        let turned = t * self.rolling([x, y, theta], speed)[2];
        // the chord has the direction that the vehicle has at the middle of the arc
        let half = 0.5 * turned;
        let chord = speed * t * if half == 0.0 { 1.0 } else { half.sin() / half };
        let middle = theta + half;
        [x + chord * middle.cos(), y + chord * middle.sin(), theta + turned]
    }

    /// The speed [m/s] after the steering of a vehicle has jumped from `from` \[rad\] to `self.steering`; `speed` is the speed before.
    ///
    /// Let `k = tan(steering)/base`. Before the jump, the velocity along the vehicle and the angular velocity are `s (1, k₀)`. After it, they are
    /// a multiple of `(1, k)`: the one nearest to `s (1, k₀)` in the metric of the kinetic energy. Its speed is `s (m + I k₀ k)/(m + I k²)`.
    #[must_use]
    pub fn steered(&self, from: f64, speed: f64) -> f64 {
        let [before, after] = [from, self.steering].map(|angle| angle.tan() / self.base);
        speed * (self.mass + self.inertia * before * after) / (self.mass + self.inertia * after * after)
    }
}
