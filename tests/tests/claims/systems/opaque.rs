//! Functions and methods of the user's, of which the macro knows only that they take dual numbers.

use dsocs_core::{Real, dsocs};
use dsocs_tests::independent::{Declaration, Number, rate};

/// A potential of two variables.
fn saddle<R: Real>(x: R, y: R) -> R {
    (x * y).sin() + x * x * 0.3 - y
}

/// A field of a system whose methods the declarations call.
#[derive(Default)]
pub struct Hill {
    /// A shift in the exponent and in the phase.
    shift: f64,
}

impl Hill {
    /// Its height.
    fn height<R: Real>(&self, x: R, y: R) -> R {
        (-(x * x + y * y) * 0.2 + self.shift).exp()
    }

    /// The position-dependent factor of the metric.
    fn stretch<R: Real>(&self, x: R, y: R) -> R {
        (x * 0.7 + self.shift).sin() * y.cos() * 0.3 + 1.5
    }
}

/// A method on numbers themselves.
trait Soft: Real {
    /// A smooth absolute value.
    fn soft(self) -> Self {
        (self * self + 0.25).sqrt()
    }
}

impl<R: Real> Soft for R {}

/// Functions of the position: in the Lagrangian (one derivative) and, through `dot`, in the constraint.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - saddle(x, y) - hill.height(x, 2 * y);
    kinematic = dot(saddle(x, y) + dot(x)) + hill.height(y, x) + x.soft();
    variational = [(dot(y), 1)];
}]
#[derive(Default)]
pub struct Landscape {
    pub hill: Hill,
}

impl Declaration<2> for Landscape {
    fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
        (v[0] * v[0] + v[1] * v[1]) / 2.0 - saddle(q[0], q[1]) - self.hill.height(q[0], q[1] * 2.0)
    }

    fn kinematic<R: Number>(&self, q: [R; 2], v: [R; 2], a: [R; 2]) -> Vec<R> {
        let rate = rate(q, v, a, |q, v| saddle(q[0], q[1]) + v[0]);
        vec![rate + self.hill.height(q[1], q[0]) + q[0].soft()]
    }

    fn variational<R: Number>(&self, _: [R; 2], v: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
        vec![[v[1], R::from(1.0)]]
    }
}

/// A function in the mass matrix at the midpoint: rows need its first derivatives, the Jacobian the second.
#[dsocs {
    coordinates(x, y);
    lagrangian = hill.stretch(x, y) * (dot(x).powi(2) + dot(y).powi(2)) / 2 - saddle(x, y);
    kinematic = dot(dot(x) * hill.stretch(x, y)) - dot(y);
    variational = [(hill.stretch(y, x), dot(x))];
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
}]
#[derive(Default)]
pub struct Metric {
    pub hill: Hill,
}

impl Declaration<2> for Metric {
    fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
        self.hill.stretch(q[0], q[1]) * (v[0] * v[0] + v[1] * v[1]) / 2.0 - saddle(q[0], q[1])
    }

    fn kinematic<R: Number>(&self, q: [R; 2], v: [R; 2], a: [R; 2]) -> Vec<R> {
        vec![rate(q, v, a, |q, v| v[0] * self.hill.stretch(q[0], q[1])) - v[1]]
    }

    fn variational<R: Number>(&self, q: [R; 2], v: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
        vec![[self.hill.stretch(q[1], q[0]), v[0]]]
    }

    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; 2], q1: [R; 2]) -> ([R; 2], [R; 2]) {
        (
            core::array::from_fn(|i| (q0[i] + q1[i]) / 2.0),
            core::array::from_fn(|i| (q1[i] - q0[i]) / h),
        )
    }
}

/// Functions of the velocity: the Lagrangian needs their second derivatives for the row and the third for its Jacobian.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).soft() + dot(x).powi(2) - gain * saddle(x, dot(x));
    phi_lagrangian = paper;
}]
pub struct Speed {
    pub gain: f64,
}

impl Declaration<1> for Speed {
    fn lagrangian<R: Number>(&self, q: [R; 1], v: [R; 1]) -> R {
        v[0].soft() + v[0] * v[0] - saddle(q[0], v[0]) * self.gain
    }

    fn kinematic<R: Number>(&self, _: [R; 1], _: [R; 1], _: [R; 1]) -> Vec<R> {
        Vec::new()
    }

    fn variational<R: Number>(&self, _: [R; 1], _: [R; 1], _: [R; 1]) -> Vec<[R; 1]> {
        vec![[R::from(1.0)]]
    }
}
