//! A crane whose trolley is moved with a limited jerk.

use std::f64::consts::TAU;

use dsocs_core::dsocs;

/// The number of steps in each phase of the jerk. It is a whole number, so the jerk jumps at nodes.
#[cfg(feature = "dsocs")]
const STEPS: f64 = 120.0;

/// Moves a load by some metres, from rest to rest.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    let crane = Crane::default();
    crate::Entry::new(crane)
        .named("crane")
        .described("a crane: a load on a rope, under a trolley that is moved with a limited jerk")
        .source("textbooks on crane control; phases of a period of the load that leave no sway: Singhose and Seering, Command Generation for Dynamic Systems")
        .start_with_acceleration([0.0, 0.0], [0.0, 0.0], [0.0, 0.0])
        .step(crane.phase / STEPS)
        .until(6.0 * crane.phase)
        .drawn(|&[x, theta]: &[f64; 2], parameters| {
            let length = parameters.get("length");
            let load = [x + length * theta.sin(), -length * theta.cos()];
            crate::entry::Drawing::new()
                .trail(load)
                .rod([x - 0.3, 0.0], [x + 0.3, 0.0])
                .rod([x, 0.0], load)
                .point(load)
        })
}

/// A trolley with a load on a massless rope of fixed length. The jerk of the trolley (the third derivative of its position) is prescribed, as by
/// drives that limit the jerk. It is `J`, `−J`, zero, `−J`, `J` in five phases. A phase lasts `T`, the one with zero jerk `2T`. A force on the
/// trolley enforces this motion.
///
/// The load swings freely, `l θ̈ + g sin θ + ẍ cos θ = 0`. In each phase `x(t)` is a polynomial of third degree ([`Crane::trolley`]). If a phase
/// lasts as long as the load's period, `T = 2π √(l/g)`, no sway is left in the linear approximation. The small sway that is left here comes from
/// the nonlinearity of the pendulum.
///
/// Each leg takes the jerk at its middle. If a phase has a whole number of steps, the jerk jumps at nodes, and the method keeps its second order.
/// Within a phase the trolley's path is exact.
#[dsocs {
    coordinates(
        /// The position of the trolley [m].
        x,
        /// The angle of the rope against the downward vertical [rad].
        theta,
    );
    let across = dot(x) + length * dot(theta) * theta.cos();
    let up = length * dot(theta) * theta.sin();
    lagrangian = trolley / 2 * dot(x).powi(2) + load / 2 * (across.powi(2) + up.powi(2))
        + load * gravity * length * theta.cos();
    let part = t / phase;
    let asked = if part < 1 { jerk } else if part < 2 { -jerk } else if part < 4 { 0 } else if part < 5 { -jerk }
        else if part < 6 { jerk } else { 0 };
    kinematic = dddot(x) - asked;
    constraint_forces = [(1, 0)];
    /// The acceleration of the trolley [m/s²].
    let acceleration = ddot(x);
    observe = [acceleration];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crane {
    /// The mass of the trolley \[kg\].
    pub trolley: f64,
    /// The mass of the load \[kg\].
    pub load: f64,
    /// The length `l` of the rope \[m\].
    pub length: f64,
    /// The gravitational acceleration `g` [m/s²].
    pub gravity: f64,
    /// The jerk `J` of the trolley [m/s³].
    pub jerk: f64,
    /// The length `T` of a phase \[s\].
    pub phase: f64,
}

impl Default for Crane {
    /// A rope of 1.5 m, and phases as long as the load's period.
    fn default() -> Self {
        let (length, gravity) = (1.5_f64, 9.81);
        Self {
            trolley: 2.0,
            load: 0.7,
            length,
            gravity,
            jerk: 0.4,
            phase: TAU * (length / gravity).sqrt(),
        }
    }
}

impl Crane {
    /// The exact position, velocity and acceleration of the trolley, in m, m/s and m/s², at the time `t`, in s. It starts at rest at the
    /// origin.
    #[must_use]
    pub fn trolley(&self, t: f64) -> [f64; 3] {
        let phases = [
            (1.0, self.jerk),
            (1.0, -self.jerk),
            (2.0, 0.0),
            (1.0, -self.jerk),
            (1.0, self.jerk),
            (f64::INFINITY, 0.0),
        ];
        let ([mut x, mut v, mut a], mut left) = ([0.0; 3], t);
        for (length, jerk) in phases {
            let s = left.min(length * self.phase);
            x += s * (v + s * (a / 2.0 + s * jerk / 6.0));
            v += s * (a + s * jerk / 2.0);
            a += s * jerk;
            left -= s;
            if left <= 0.0 {
                break;
            }
        }
        [x, v, a]
    }
}
