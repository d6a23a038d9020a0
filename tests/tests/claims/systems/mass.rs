//! Lagrangians whose mass matrix depends on the configuration.

use dsocs_core::{Real, dsocs};
use dsocs_tests::independent::{Declaration, Number, map2, rate};

/// The planar double pendulum, free.
#[dsocs {
    coordinates(alpha, beta);
    lagrangian = (1 + ratio) / 2 * dot(alpha).powi(2) + ratio / 2 * dot(beta).powi(2)
        + ratio * dot(alpha) * dot(beta) * (alpha - beta).cos()
        + gravity * ((1 + ratio) * alpha.cos() + ratio * beta.cos());
    phi_lagrangian = paper;
}]
pub struct DoublePendulum {
    pub ratio: f64,
    pub gravity: f64,
}

/// The double pendulum with the midpoint rule.
#[dsocs {
    coordinates(alpha, beta);
    lagrangian = (1 + ratio) / 2 * dot(alpha).powi(2) + ratio / 2 * dot(beta).powi(2)
        + ratio * dot(alpha) * dot(beta) * (alpha - beta).cos()
        + gravity * ((1 + ratio) * alpha.cos() + ratio * beta.cos());
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
}]
pub struct DoublePendulumMidpoint {
    pub ratio: f64,
    pub gravity: f64,
}

/// The double pendulum with a torque at the elbow that lowers its energy.
#[dsocs {
    coordinates(alpha, beta);
    let kinetic = (1 + ratio) / 2 * dot(alpha).powi(2) + ratio / 2 * dot(beta).powi(2)
        + ratio * dot(alpha) * dot(beta) * (alpha - beta).cos();
    let potential = -gravity * ((1 + ratio) * alpha.cos() + ratio * beta.cos());
    lagrangian = kinetic - potential;
    kinematic = dot(kinetic + potential) + (dot(alpha) - dot(beta)).powi(2);
    constraint_forces = [(1, -1)];
    phi_lagrangian = paper;
}]
pub struct Constrained {
    pub ratio: f64,
    pub gravity: f64,
}

fn kinetic<R: Real>(ratio: f64, q: [R; 2], v: [R; 2]) -> R {
    let coupling = v[0] * v[1] * (q[0] - q[1]).cos() * ratio;
    v[0] * v[0] * (0.5 + ratio / 2.0) + v[1] * v[1] * (ratio / 2.0) + coupling
}

fn potential<R: Real>(ratio: f64, gravity: f64, q: [R; 2]) -> R {
    (q[0].cos() * (1.0 + ratio) + q[1].cos() * ratio) * -gravity
}

macro_rules! free {
    () => {
        fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
            kinetic(self.ratio, q, v) - potential(self.ratio, self.gravity, q)
        }

        fn kinematic<R: Number>(&self, _: [R; 2], _: [R; 2], _: [R; 2]) -> Vec<R> {
            Vec::new()
        }

        fn variational<R: Number>(&self, _: [R; 2], _: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
            let (zero, one) = (R::from(0.0), R::from(1.0));
            vec![[one, zero], [zero, one]]
        }
    };
}

impl Declaration<2> for DoublePendulum {
    free!();
}

impl Declaration<2> for DoublePendulumMidpoint {
    free!();

    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; 2], q1: [R; 2]) -> ([R; 2], [R; 2]) {
        (
            map2(q0, q1, |x0, x1| (x0 + x1) / 2.0),
            map2(q0, q1, |x0, x1| (x1 - x0) / h),
        )
    }
}

impl Declaration<2> for Constrained {
    fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
        kinetic(self.ratio, q, v) - potential(self.ratio, self.gravity, q)
    }

    fn kinematic<R: Number>(&self, q: [R; 2], v: [R; 2], a: [R; 2]) -> Vec<R> {
        let power = rate(q, v, a, |q, v| {
            kinetic(self.ratio, q, v) + potential(self.ratio, self.gravity, q)
        });
        let slip = v[0] - v[1];
        vec![power + slip * slip]
    }

    fn variational<R: Number>(&self, _: [R; 2], _: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
        vec![[R::from(1.0); 2]]
    }
}
