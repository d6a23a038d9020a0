//! All functions of the language, with their branches.

#![allow(clippy::unused_self)] // some of these systems have no use for their parameter here

use dsocs_core::{Real, dsocs};
use dsocs_tests::independent::{Declaration, Number, rate};

/// The row and the field of all systems of this file.
macro_rules! one_row {
    ($name:ident) => {
        impl Declaration<2> for $name {
            fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
                (v[0] * v[0] + v[1] * v[1]) / 2.0 + self.coupling(q, v)
            }

            fn kinematic<R: Number>(&self, q: [R; 2], v: [R; 2], a: [R; 2]) -> Vec<R> {
                vec![a[0] + rate(q, v, a, |q, v| self.row(q, v))]
            }

            fn variational<R: Number>(&self, _: [R; 2], _: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
                vec![[R::from(1.0), R::from(1.0)]]
            }
        }
    };
}

/// Functions that are defined everywhere, of expressions of position and velocity, in the Lagrangian and under `dot`.
#[dsocs {
    coordinates(x, y);
    let s = x + dot(y) / 2;
    let all = s.sin() + (s + 1).cos() + s.atan() + s.sinh() + s.cosh() / 2 + s.tanh() + s.asinh() + s.exp() + s.exp_m1() / 2
        + s.exp2() + s.powi(3) + s.powi(0) + s.hypot(p) + s.atan2(y + 9) + y.atan2(-x.powi(2) - 1) + s.mul_add(y, x)
        + s.to_radians() + s.to_degrees() / 60 - (-s);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + f64::sin(x * dot(x)) * y;
    kinematic = ddot(x) + dot(all);
    variational = [(1, 1)];
    phi_lagrangian = paper;
}]
pub struct Everywhere {
    pub p: f64,
}

impl Everywhere {
    fn coupling<R: Real>(&self, q: [R; 2], v: [R; 2]) -> R {
        (q[0] * v[0]).sin() * q[1]
    }

    fn row<R: Real>(&self, [x, y]: [R; 2], v: [R; 2]) -> R {
        let s = x + v[1] / 2.0;
        let circular = s.sin() + (s + 1.0).cos() + s.atan();
        let hyperbolic = s.sinh() + s.cosh() / 2.0 + s.tanh() + s.asinh();
        let exponential = s.exp() + s.exp_m1() / 2.0 + s.exp2();
        let powers = s * s * s + 1.0 + (s * s + self.p * self.p).sqrt();
        let angles = s.atan2(y + 9.0) + y.atan2(-(x * x) - 1.0);
        let rest =
            s * y + x + s * (std::f64::consts::PI / 180.0) + s * (180.0 / std::f64::consts::PI) / 60.0 + s;
        circular + hyperbolic + exponential + powers + angles + rest
    }
}

one_row!(Everywhere);

/// Functions that need positive arguments, or arguments above 1.
#[dsocs {
    coordinates(x, y);
    let r = 1.5 + x.powi(2) + dot(y).powi(2);
    let all = r.sqrt() + r.cbrt() + r.ln() + r.ln_1p() + r.log10() + r.log2() + r.log(p) + r.powf(p) + r.powf(y) + r.powi(-2)
        + r.recip() + r.acosh() + p.powf(dot(x)) + 1 / r + r.powf(2.5) + (-r).cbrt();
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + (1 + dot(x).powi(2)).sqrt() * y.exp();
    kinematic = ddot(x) + dot(all);
    variational = [(1, 1)];
    phi_lagrangian = paper;
}]
pub struct Positive {
    pub p: f64,
}

impl Positive {
    fn coupling<R: Real>(&self, q: [R; 2], v: [R; 2]) -> R {
        (v[0] * v[0] + 1.0).sqrt() * q[1].exp()
    }

    fn row<R: Real>(&self, [x, y]: [R; 2], v: [R; 2]) -> R {
        let r = x * x + v[1] * v[1] + 1.5;
        let roots = r.sqrt() + r.cbrt() - r.cbrt();
        let logarithms = r.ln() + (r + 1.0).ln() + r.log10() + r.log2() + r.ln() / self.p.ln();
        let powers = r.powf(self.p) + (y * r.ln()).exp() + r.powi(-2) + r.recip();
        let rest = (r + ((r - 1.0) * (r + 1.0)).sqrt()).ln() + (v[0] * self.p.ln()).exp() + r.recip();
        roots + logarithms + powers + rest + r * r * r.sqrt()
    }
}

one_row!(Positive);

/// Functions of arguments between −1 and 1, or short of a pole.
#[dsocs {
    coordinates(x, y);
    let u = 0.9 * (x + dot(y)).sin();
    let all = u.asin() + u.acos() * 2 + u.atanh() + u.tan() + u.abs() * u + u.signum() * u.powi(2) + u.min(y) + u.max(dot(x));
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + (x * dot(y)).cos() * p;
    kinematic = ddot(x) + dot(all);
    variational = [(1, 1)];
    phi_lagrangian = paper;
}]
pub struct Bounded {
    pub p: f64,
}

impl Bounded {
    fn coupling<R: Real>(&self, q: [R; 2], v: [R; 2]) -> R {
        (q[0] * v[1]).cos() * self.p
    }

    fn row<R: Real>(&self, [x, y]: [R; 2], v: [R; 2]) -> R {
        let u = (x + v[1]).sin() * 0.9;
        let inverse = u.asin() + u.acos() * 2.0 + u.atanh() + u.tan();
        let square = if u < R::from(0.0) { -(u * u) } else { u * u };
        let smaller = if u < y { u } else { y };
        let larger = if u < v[0] { v[0] } else { u };
        inverse + square * 2.0 + smaller + larger
    }
}

one_row!(Bounded);

/// `if` in a Lagrangian and in a constraint, nested and with blocks.
#[dsocs {
    coordinates(x, y);
    let slope = if x < edge { x.powi(2) } else { 2 * edge * x - edge.powi(2) };
    let drag = {
        let fast = dot(x) - dot(y);
        if fast > 0 { if y >= edge { fast.powi(2) } else { fast * y } } else { -fast.powi(3) }
    };
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - slope;
    kinematic = ddot(x) + dot(slope) + drag;
    variational = [(1, 1)];
}]
pub struct Branches {
    pub edge: f64,
}

impl Branches {
    fn slope<R: Real>(&self, x: R) -> R {
        if x < R::from(self.edge) {
            x * x
        } else {
            x * (2.0 * self.edge) - self.edge * self.edge
        }
    }
}

impl Declaration<2> for Branches {
    fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
        (v[0] * v[0] + v[1] * v[1]) / 2.0 - self.slope(q[0])
    }

    fn kinematic<R: Number>(&self, q: [R; 2], v: [R; 2], a: [R; 2]) -> Vec<R> {
        let fast = v[0] - v[1];
        let drag = if fast > R::from(0.0) {
            if q[1] >= R::from(self.edge) {
                fast * fast
            } else {
                fast * q[1]
            }
        } else {
            -(fast * fast * fast)
        };
        vec![a[0] + rate(q, v, a, |q, _| self.slope(q[0])) + drag]
    }

    fn variational<R: Number>(&self, _: [R; 2], _: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
        vec![[R::from(1.0), R::from(1.0)]]
    }
}
