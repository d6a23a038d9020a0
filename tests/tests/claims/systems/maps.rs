//! Declarations with each of the maps overridden.

use dsocs_core::{Real, dsocs};
use dsocs_tests::independent::{Declaration, Number, map2};

/// A particle in a potential; the midpoint rule for `φ_{L_d}`.
#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - stiffness * (x * x * y).sin();
    kinematic = dot(x) * ddot(y) - ddot(x) * dot(y) - (1 + x * x);
    variational = [(dot(x), dot(y))];
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
}]
pub struct Midpoint {
    pub mass: f64,
    pub stiffness: f64,
}

impl Declaration<2> for Midpoint {
    fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
        (v[0] * v[0] + v[1] * v[1]) * (self.mass / 2.0) - (q[0] * q[0] * q[1]).sin() * self.stiffness
    }

    fn kinematic<R: Number>(&self, q: [R; 2], v: [R; 2], a: [R; 2]) -> Vec<R> {
        vec![v[0] * a[1] - a[0] * v[1] - (q[0] * q[0] + 1.0)]
    }

    fn variational<R: Number>(&self, _: [R; 2], v: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
        vec![v]
    }

    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; 2], q1: [R; 2]) -> ([R; 2], [R; 2]) {
        (
            map2(q0, q1, |x0, x1| (x0 + x1) / 2.0),
            map2(q0, q1, |x0, x1| (x1 - x0) / h),
        )
    }
}

/// An unconstrained oscillator with a coupling of position and velocity in `L`; a map whose velocity is no plain
/// difference, componentwise and with blocks.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + 2 * dot(y).powi(2)) / 2 + x * y * dot(x) - x.cos() * y.exp();
    phi_lagrangian = |q0, q1| {
        let middle = weight * q0 + (1 - weight) * q1;
        ((q0 + middle.x * 0.1, q1.y), (q1 - q0) / h + 0.05 * middle)
    };
}]
pub struct Weighted {
    pub weight: f64,
}

impl Declaration<2> for Weighted {
    fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
        (v[0] * v[0] + v[1] * v[1] * 2.0) / 2.0 + q[0] * q[1] * v[0] - q[0].cos() * q[1].exp()
    }

    fn kinematic<R: Number>(&self, _: [R; 2], _: [R; 2], _: [R; 2]) -> Vec<R> {
        Vec::new()
    }

    fn variational<R: Number>(&self, _: [R; 2], _: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
        let (zero, one) = (R::from(0.0), R::from(1.0));
        vec![[one, zero], [zero, one]]
    }

    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; 2], q1: [R; 2]) -> ([R; 2], [R; 2]) {
        let middle = map2(q0, q1, |x0, x1| x0 * self.weight + x1 * (1.0 - self.weight));
        let v = core::array::from_fn(|i| (q1[i] - q0[i]) / h + middle[i] * 0.05);
        ([q0[0] + middle[0] * 0.1, q1[1]], v)
    }
}

/// The rows of a particle with constant curvature, multiplied out, and a potential.
macro_rules! curve {
    ($name:ident) => {
        fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
            (v[0] * v[0] + v[1] * v[1]) / 2.0 - q[0] * q[1]
        }

        fn kinematic<R: Number>(&self, q: [R; 2], v: [R; 2], a: [R; 2]) -> Vec<R> {
            let squared = v[0] * v[0] + v[1] * v[1] + 0.5;
            vec![v[0] * a[1] - a[0] * v[1] - squared * squared.sqrt() * self.curvature * q[0].cos()]
        }

        fn variational<R: Number>(&self, q: [R; 2], v: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
            vec![[v[0] + q[1], v[1]]]
        }
    };
}

/// One-sided kinematic map, which the variational one follows.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x * y;
    let squared = dot(x).powi(2) + dot(y).powi(2) + 0.5;
    kinematic = dot(x) * ddot(y) - ddot(x) * dot(y) - curvature * squared.powf(1.5) * x.cos();
    variational = [(dot(x) + y, dot(y))];
    phi_kinematic = |q0, q1, q2| (q2, (q2 - q1) / h, (q2 - 2 * q1 + q0) / h.powi(2));
}]
pub struct Forward {
    pub curvature: f64,
}

impl Declaration<2> for Forward {
    curve!(Forward);

    fn phi_kinematic<R: Number>(&self, h: R, [q0, q1, q2]: [[R; 2]; 3]) -> [[R; 2]; 3] {
        let a = core::array::from_fn(|i| (q2[i] - q1[i] * 2.0 + q0[i]) / (h * h));
        [q2, map2(q1, q2, |x1, x2| (x2 - x1) / h), a]
    }
}

/// Different maps for `C_K` (by default) and `C_V`.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x * y;
    let squared = dot(x).powi(2) + dot(y).powi(2) + 0.5;
    kinematic = dot(x) * ddot(y) - ddot(x) * dot(y) - curvature * squared.powf(1.5) * x.cos();
    variational = [(dot(x) + y, dot(y))];
    phi_variational = |q0, q1, q2| ((q0 + q1) / 2, (q1 - q0) / h, (q2 - 2 * q1 + q0) / (h * h));
}]
pub struct Mixed {
    pub curvature: f64,
}

impl Declaration<2> for Mixed {
    curve!(Mixed);

    fn phi_variational<R: Number>(&self, h: R, [q0, q1, q2]: [[R; 2]; 3]) -> [[R; 2]; 3] {
        let a = core::array::from_fn(|i| (q2[i] - q1[i] * 2.0 + q0[i]) / (h * h));
        [
            map2(q0, q1, |x0, x1| (x0 + x1) / 2.0),
            map2(q0, q1, |x0, x1| (x1 - x0) / h),
            a,
        ]
    }
}

/// All three maps: an average of three nodes, and tuples of components.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x * y;
    let squared = dot(x).powi(2) + dot(y).powi(2) + 0.5;
    kinematic = dot(x) * ddot(y) - ddot(x) * dot(y) - curvature * squared.powf(1.5) * x.cos();
    variational = [(dot(x) + y, dot(y))];
    phi_lagrangian = |q0, q1| (q1, (q1 - q0) / h);
    phi_kinematic = |q0, q1, q2| (
        (q0 + q1 + q2) / 3,
        ((q2.x - q0.x) / (2 * h), (q2 - q1) / h),
        (q2 - 2 * q1 + q0) / (h * h),
    );
    phi_variational = |q0, q1, q2| (q1, (q2 - q0) / (2 * h), (q0.0 - q1 + q2 - q1.x) / h);
}]
pub struct Averaged {
    pub curvature: f64,
}

impl Declaration<2> for Averaged {
    curve!(Averaged);

    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; 2], q1: [R; 2]) -> ([R; 2], [R; 2]) {
        (q1, map2(q0, q1, |x0, x1| (x1 - x0) / h))
    }

    fn phi_kinematic<R: Number>(&self, h: R, [q0, q1, q2]: [[R; 2]; 3]) -> [[R; 2]; 3] {
        let q = core::array::from_fn(|i| (q0[i] + q1[i] + q2[i]) / 3.0);
        let v = [(q2[0] - q0[0]) / (h * 2.0), (q2[1] - q1[1]) / h];
        [
            q,
            v,
            core::array::from_fn(|i| (q2[i] - q1[i] * 2.0 + q0[i]) / (h * h)),
        ]
    }

    fn phi_variational<R: Number>(&self, h: R, [q0, q1, q2]: [[R; 2]; 3]) -> [[R; 2]; 3] {
        let a = core::array::from_fn(|i| (q0[0] - q1[i] + q2[i] - q1[0]) / h);
        [q1, map2(q0, q2, |x0, x2| (x2 - x0) / (h * 2.0)), a]
    }
}
