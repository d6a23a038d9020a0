//! A planar scene as data, and its mechanics in Cartesian terms: positions and velocities of bodies,
//! energies, constraints.

use super::number::{Dual, Number};
use super::random::Random;

/// The point at which the discrete Lagrangian evaluates the Lagrangian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    /// At the first node.
    Paper,
    /// In the middle.
    Midpoint,
    /// At both nodes, half each.
    Trapezoid,
}

/// The base from which a body hangs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Base {
    /// The origin.
    Ground,
    /// An earlier body.
    Body(usize),
    /// None: its position is two coordinates.
    Free(usize, usize),
}

/// A point mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Its base.
    pub base: Base,
    /// The massless rod between base and body: the coordinate that is its angle from the downward vertical, and its length.
    pub rod: Option<(usize, f64)>,
    /// The mass \[kg\].
    pub mass: f64,
}

/// A spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spring {
    /// Between two angles, or an angle and the ground: `k/2 (a - b - rest)²`.
    Twist {
        /// The coordinates.
        ends: (usize, Option<usize>),
        /// The stiffness [N m].
        stiffness: f64,
        /// The angle at rest \[rad\].
        rest: f64,
    },
    /// Between two bodies, or a body and the origin: `k/2 (distance - rest)²`.
    Line {
        /// The bodies.
        ends: (usize, Option<usize>),
        /// The stiffness [N/m].
        stiffness: f64,
        /// The length at rest \[m\].
        rest: f64,
    },
}

/// A massless rod as a holonomic constraint, `(distance² - length²)/2 = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rod {
    /// The bodies; the origin where the second is missing.
    pub ends: (usize, Option<usize>),
    /// The length \[m\].
    pub length: f64,
}

/// A wheel at a body; it does not slip sideways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheel {
    /// The body.
    pub body: usize,
    /// The coordinate that is its direction, `(sin, -cos)`.
    pub angle: usize,
    /// For a wheel that does not slip forward either: the coordinate of its rotation, and its radius.
    pub rolls: Option<(usize, f64)>,
}

/// A constraint of second order on one joint, enforced by a motor between the two angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// The coordinates: an angle, and the one against which the motor pushes.
    pub joint: (usize, Option<usize>),
    /// Its control law.
    pub law: Law,
}

/// The control law of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// `w' + 2 c r w + r² (angle - target) = 0` with the joint's rate `w`.
    Servo {
        /// The rate `r` [1/s].
        rate: f64,
        /// The damping `c`.
        damping: f64,
        /// The target angle \[rad\].
        target: f64,
    },
    /// The energy of the scene is its Lyapunov function: `dE/dt + ρ w² = 0`.
    Lyapunov {
        /// The coefficient `ρ` [N m s].
        rho: f64,
    },
}

/// A planar scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The number of coordinates.
    pub coordinates: usize,
    /// The map.
    pub map: Map,
    /// The acceleration of gravity, along `-y` [m/s²].
    pub gravity: f64,
    /// The bodies; a base precedes the bodies that hang from it.
    pub bodies: Vec<Body>,
    /// Moments of inertia, each with the coordinate of its rotation.
    pub inertias: Vec<(usize, f64)>,
    /// The springs.
    pub springs: Vec<Spring>,
    /// Rods that are constraints.
    pub rods: Vec<Rod>,
    /// Wheels.
    pub wheels: Vec<Wheel>,
    /// The motor, if there is one.
    pub motor: Option<Motor>,
}

/// A point and its velocity.
#[derive(Clone, Copy, Debug)]
pub struct Moving<T> {
    /// The point.
    pub at: [T; 2],
    /// The velocity.
    pub rate: [T; 2],
}

impl Scene {
    /// The number of constraints on pairs of nodes: rods, then wheels.
    #[must_use]
    pub fn lower(&self) -> usize {
        let rolling = self.wheels.iter().filter(|wheel| wheel.rolls.is_some()).count();
        self.rods.len() + self.wheels.len() + rolling
    }

    /// The number of constraints.
    #[must_use]
    pub fn constraints(&self) -> usize {
        self.lower() + usize::from(self.motor.is_some())
    }

    /// The coordinates that are directions of rods or wheels.
    #[must_use]
    pub fn angles(&self) -> Vec<usize> {
        let rods = self.bodies.iter().filter_map(|body| Some(body.rod?.0));
        rods.chain(self.wheels.iter().map(|wheel| wheel.angle)).collect()
    }

    /// The rods between the origin, or a free position, and each body: 1 or 0 for every body and every one of
    /// `angles`.
    #[must_use]
    pub fn paths(&self, angles: core::ops::Range<usize>) -> Vec<f64> {
        let width = angles.len();
        let mut paths: Vec<f64> = Vec::new();
        for (k, body) in self.bodies.iter().enumerate() {
            let mut path = match body.base {
                Base::Body(base) => paths[base * width..(base + 1) * width].to_vec(),
                _ => vec![0.0; width],
            };
            if let Some((angle, _)) = body.rod {
                path[angle - angles.start] = 1.0;
            }
            debug_assert_eq!(paths.len(), k * width);
            paths.extend(path);
        }
        paths
    }

    /// A scene with every number changed by a random relative amount up to `size`.
    #[must_use]
    pub fn perturbed(&self, size: f64, random: &mut Random) -> Self {
        let mut other = self.clone();
        let mut change = |x: &mut f64| *x += *x * size * random.between(-1.0, 1.0);
        change(&mut other.gravity);
        for body in &mut other.bodies {
            change(&mut body.mass);
            if let Some((_, length)) = &mut body.rod {
                change(length);
            }
        }
        for (_, inertia) in &mut other.inertias {
            change(inertia);
        }
        for spring in &mut other.springs {
            let (Spring::Twist { stiffness, rest, .. } | Spring::Line { stiffness, rest, .. }) = spring;
            change(stiffness);
            change(rest);
        }
        for rod in &mut other.rods {
            change(&mut rod.length);
        }
        for wheel in &mut other.wheels {
            if let Some((_, radius)) = &mut wheel.rolls {
                change(radius);
            }
        }
        match other.motor.as_mut().map(|motor| &mut motor.law) {
            Some(Law::Servo {
                rate,
                damping,
                target,
            }) => [rate, damping, target].into_iter().for_each(change),
            Some(Law::Lyapunov { rho }) => change(rho),
            None => {}
        }
        other
    }

    /// The positions and velocities of the bodies.
    pub fn places<T: Number>(&self, q: &[T], v: &[T]) -> Vec<Moving<T>> {
        let mut places: Vec<Moving<T>> = Vec::with_capacity(self.bodies.len());
        for body in &self.bodies {
            let mut place = match body.base {
                Base::Ground => Moving {
                    at: [T::of(0.0); 2],
                    rate: [T::of(0.0); 2],
                },
                Base::Body(base) => places[base],
                Base::Free(x, y) => Moving {
                    at: [q[x], q[y]],
                    rate: [v[x], v[y]],
                },
            };
            if let Some((angle, length)) = body.rod {
                let ((sine, cosine), length) = (q[angle].sine_cosine(), T::of(length));
                place.at = [place.at[0] + length * sine, place.at[1] - length * cosine];
                let speed = length * v[angle];
                place.rate = [place.rate[0] + speed * cosine, place.rate[1] + speed * sine];
            }
            places.push(place);
        }
        places
    }

    /// The kinetic and the potential energy.
    pub fn energies<T: Number>(&self, q: &[T], v: &[T]) -> [T; 2] {
        let places = self.places(q, v);
        let (mut kinetic, mut potential) = (T::of(0.0), T::of(0.0));
        for (body, place) in self.bodies.iter().zip(&places) {
            let mass = T::of(body.mass);
            kinetic = kinetic + mass * square(place.rate);
            potential = potential + mass * T::of(self.gravity) * place.at[1];
        }
        for &(coordinate, inertia) in &self.inertias {
            kinetic = kinetic + T::of(inertia) * v[coordinate] * v[coordinate];
        }
        for spring in &self.springs {
            let (stretch, stiffness) = match *spring {
                Spring::Twist {
                    ends,
                    stiffness,
                    rest,
                } => (joint(ends, q) - T::of(rest), stiffness),
                Spring::Line {
                    ends,
                    stiffness,
                    rest,
                } => (
                    square(vector_between(ends, &places)).root() - T::of(rest),
                    stiffness,
                ),
            };
            potential = potential + T::of(stiffness / 2.0) * stretch * stretch;
        }
        [kinetic * T::of(0.5), potential]
    }

    /// The Lagrangian.
    pub fn lagrangian<T: Number>(&self, q: &[T], v: &[T]) -> T {
        let [kinetic, potential] = self.energies(q, v);
        kinetic - potential
    }

    /// The holonomic constraints.
    pub fn holonomic<T: Number>(&self, q: &[T]) -> Vec<T> {
        if self.rods.is_empty() {
            return Vec::new();
        }
        let places = self.places(q, q);
        let rods = self.rods.iter();
        rods.map(|rod| {
            let length = T::of(rod.length);
            (square(vector_between(rod.ends, &places)) - length * length) * T::of(0.5)
        })
        .collect()
    }

    /// The nonholonomic constraints.
    pub fn nonholonomic<T: Number>(&self, q: &[T], v: &[T]) -> Vec<T> {
        if self.wheels.is_empty() {
            return Vec::new();
        }
        let places = self.places(q, v);
        let mut rows = Vec::new();
        for wheel in &self.wheels {
            let [x, y] = places[wheel.body].rate;
            let (sine, cosine) = q[wheel.angle].sine_cosine();
            rows.push(cosine * x + sine * y);
            if let Some((roll, radius)) = wheel.rolls {
                rows.push(sine * x - cosine * y - T::of(radius) * v[roll]);
            }
        }
        rows
    }

    /// The constraint of second order.
    pub fn kinematic<T: Number>(&self, q: &[T], v: &[T], a: &[T]) -> Option<T> {
        let motor = self.motor?;
        let w = joint(motor.joint, v);
        Some(match motor.law {
            Law::Servo {
                rate,
                damping,
                target,
            } => {
                let (rate, damping) = (T::of(rate), T::of(2.0) * T::of(damping));
                joint(motor.joint, a)
                    + damping * rate * w
                    + rate * rate * (joint(motor.joint, q) - T::of(target))
            }
            Law::Lyapunov { rho } => {
                let [kinetic, potential] = self.energies(&Dual::along(q, v), &Dual::along(v, a));
                (kinetic + potential).slope + T::of(rho) * w * w
            }
        })
    }

    /// The directions of the constraint forces, one for each constraint: by d'Alembert's rule, and along the
    /// motor's joint.
    pub fn forms<T: Number>(&self, q: &[T], v: &[T]) -> Vec<Vec<T>> {
        let zero = T::of(0.0);
        let mut forms = vec![vec![zero; self.coordinates]; self.constraints()];
        for i in 0..self.coordinates {
            let by_position = self.holonomic(&Dual::at(q, i));
            let by_velocity = self.nonholonomic(&Dual::fixed(q), &Dual::at(v, i));
            for (form, row) in forms.iter_mut().zip(by_position.iter().chain(&by_velocity)) {
                form[i] = row.slope;
            }
        }
        if let (Some(motor), Some(form)) = (self.motor, forms.last_mut()) {
            form[motor.joint.0] = T::of(1.0);
            if let Some(against) = motor.joint.1 {
                form[against] = T::of(-1.0);
            }
        }
        forms
    }
}

/// The difference of two coordinates, or the coordinate alone.
fn joint<T: Number>((one, other): (usize, Option<usize>), q: &[T]) -> T {
    match other {
        Some(other) => q[one] - q[other],
        None => q[one],
    }
}

/// The vector to one body from another, or from the origin.
fn vector_between<T: Number>((one, other): (usize, Option<usize>), places: &[Moving<T>]) -> [T; 2] {
    let [x, y] = places[one].at;
    match other {
        Some(other) => [x - places[other].at[0], y - places[other].at[1]],
        None => [x, y],
    }
}

/// The square of a vector's length.
fn square<T: Number>([x, y]: [T; 2]) -> T {
    x * x + y * y
}
