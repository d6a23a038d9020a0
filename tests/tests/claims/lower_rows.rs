//! Each discrete row of a system with holonomic and nonholonomic constraints is that of the paper, written by hand: `g(q2) − (1 −
//! 1/1024) g(q1)` of a holonomic constraint, `c(φ⁻¹(q1, q2))` of a nonholonomic one, and `Q − Σ λ α(q1)` for any multipliers.

use dsocs_core::__private::Declaration as Tape;
use dsocs_core::Leg;
use dsocs_systems::{Sleigh, Sphere};
use dsocs_tests::declared;
use dsocs_tests::independent::{self, Declaration, Number, map2};
use dsocs_tests::text::System;
use proptest::prelude::*;

use crate::draws::{self, sized, vector};

/// The part of `g(q1)` that the row `g(q2) - (1 - CORRECTED) g(q1)` removes in a step. On the constraint
/// `g(q1)` is rounding; removed all at once it would appear in the second difference.
const CORRECTED: f64 = 1.0 / 1024.0;

/// The row of a holonomic constraint.
fn holonomic<const N: usize>([_, q1, q2]: [[f64; N]; 3], g: impl Fn([f64; N]) -> f64) -> f64 {
    g(q2) - (1.0 - CORRECTED) * g(q1)
}

/// The rows of constraints of lower order, by hand.
trait Lower<const N: usize>: Declaration<N> {
    /// The constraints on the last leg, with the form of each at the middle node; those of second order come last.
    fn constraints(&self, h: f64, nodes: [[f64; N]; 3]) -> Vec<(f64, [f64; N])>;
}

/// A midpoint, and the velocity there.
fn midpoint<R: Number, const N: usize>(h: R, q0: [R; N], q1: [R; N]) -> ([R; N], [R; N]) {
    (
        map2(q0, q1, |x0, x1| (x0 + x1) * 0.5),
        map2(q0, q1, |x0, x1| (x1 - x0) / h),
    )
}

/// Compares every declared row with the one by hand, at random triples and multipliers, to 1e-11 relative to
/// `1/h²`.
fn compare<S: System<N>, P: Lower<N>, const N: usize>(system: &S, by_hand: &P) {
    let states = (
        0.05..0.5,
        vector::<N>(-2.0..2.0),
        vector::<N>(-2.0..2.0),
        vector::<N>(-3.0..3.0),
        -2.0..2.0,
    );
    draws::test(200, 11, states, &|(h, q, v, a, multiplier)| {
        let [q, v, a]: [[f64; N]; 3] = [q, v, a].map(|x| sized(&x));
        let leg = Leg {
            t: 0.0,
            q,
            d: v.map(|v| h * v),
        };
        let e = a.map(|a| h * h * a);
        let nodes = [
            core::array::from_fn(|i| q[i] - leg.d[i]),
            q,
            core::array::from_fn(|i| q[i] + leg.d[i] + e[i]),
        ];
        let declaration = Tape::of(system.kernel());
        let constraints = by_hand.constraints(h, nodes);
        // all different
        let multipliers: Vec<f64> = (1..=constraints.len()).map(|k| multiplier * k as f64).collect();
        let rows = declaration.declared(h, leg.any(), &e, &multipliers);
        let force = independent::force(by_hand, h, nodes);
        let mut expected: Vec<f64> = constraints.iter().map(|(row, _)| *row).collect();
        expected.extend((0..N).map(|i| {
            let pairs = constraints.iter().zip(&multipliers);
            let held: f64 = pairs.map(|((_, form), multiplier)| multiplier * form[i]).sum();
            force[i] - held
        }));
        prop_assert_eq!(rows.len(), expected.len());
        for (k, (row, expected)) in rows.iter().zip(&expected).enumerate() {
            // differences of nodes lose digits that increments keep
            let tolerance = 1e-11 * (1.0 + expected.abs()) / (h * h);
            prop_assert!(
                (row - expected).abs() <= tolerance,
                "row {k}: generated {row:e}, by hand {expected:e}"
            );
        }
        Ok(())
    });
}

macro_rules! no_rows_of_second_order {
    ($n:literal) => {
        fn kinematic<R: Number>(&self, _: [R; $n], _: [R; $n], _: [R; $n]) -> Vec<R> {
            Vec::new()
        }

        fn variational<R: Number>(&self, _: [R; $n], _: [R; $n], _: [R; $n]) -> Vec<[R; $n]> {
            Vec::new()
        }
    };
}

struct Blade(Sleigh);

impl Declaration<3> for Blade {
    fn lagrangian<R: Number>(&self, q: [R; 3], v: [R; 3]) -> R {
        let along = v[0] * q[2].cos() + v[1] * q[2].sin();
        let across = v[1] * q[2].cos() - v[0] * q[2].sin() + v[2] * self.0.offset;
        (along * along + across * across) * (self.0.mass / 2.0) + v[2] * v[2] * (self.0.inertia / 2.0)
    }

    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; 3], q1: [R; 3]) -> ([R; 3], [R; 3]) {
        midpoint(h, q0, q1)
    }

    no_rows_of_second_order!(3);
}

impl Lower<3> for Blade {
    fn constraints(&self, h: f64, [_, q1, q2]: [[f64; 3]; 3]) -> Vec<(f64, [f64; 3])> {
        let (q, v) = midpoint(h, q1, q2);
        let row = v[1] * q[2].cos() - v[0] * q[2].sin();
        vec![(row, [-q1[2].sin(), q1[2].cos(), 0.0])]
    }
}

#[test]
fn a_nonholonomic_row_stands_on_the_last_leg() {
    let sleigh = Sleigh {
        mass: 1.3,
        inertia: 0.4,
        offset: 0.6,
    };
    compare(&sleigh, &Blade(sleigh));
}

struct Ball(Sphere);

impl Declaration<3> for Ball {
    fn lagrangian<R: Number>(&self, q: [R; 3], v: [R; 3]) -> R {
        let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        square * (self.0.mass / 2.0) - q[2] * (self.0.mass * self.0.gravity)
    }

    no_rows_of_second_order!(3);
}

impl Lower<3> for Ball {
    fn constraints(&self, _: f64, nodes: [[f64; 3]; 3]) -> Vec<(f64, [f64; 3])> {
        let length = self.0.length;
        let g = |q: [f64; 3]| (q.iter().map(|x| x * x).sum::<f64>() - length * length) / (2.0 * length);
        vec![(holonomic(nodes, g), nodes[1].map(|x| x / length))]
    }
}

#[test]
fn a_holonomic_row_stands_at_the_last_node() {
    let sphere = Sphere {
        mass: 0.7,
        length: 1.9,
        gravity: 9.81,
    };
    compare(&sphere, &Ball(sphere));
}

declared! {
    /// A disk that rolls, with constraints along its heading and across it: no coefficient is nowhere zero.
    struct Disk {
        mass: f64,
        inertia: f64,
        turning: f64,
    }
    coordinates(x, y, theta, phi);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) + inertia / 2 * dot(theta).powi(2) + turning / 2 * dot(phi).powi(2);
    nonholonomic = [
        phi.cos() * dot(x) + phi.sin() * dot(y) - phi * dot(theta),
        phi.sin() * dot(x) - phi.cos() * dot(y) - x * dot(theta),
    ];
}

impl Declaration<4> for Disk {
    fn lagrangian<R: Number>(&self, _: [R; 4], v: [R; 4]) -> R {
        (v[0] * v[0] + v[1] * v[1]) * (self.mass / 2.0)
            + v[2] * v[2] * (self.inertia / 2.0)
            + v[3] * v[3] * (self.turning / 2.0)
    }

    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; 4], q1: [R; 4]) -> ([R; 4], [R; 4]) {
        midpoint(h, q0, q1)
    }

    no_rows_of_second_order!(4);
}

impl Lower<4> for Disk {
    fn constraints(&self, h: f64, [_, q1, q2]: [[f64; 4]; 3]) -> Vec<(f64, [f64; 4])> {
        let (q, v) = midpoint(h, q1, q2);
        let forms = |q: [f64; 4]| {
            let (sine, cosine) = q[3].sin_cos();
            [[cosine, sine, -q[3], 0.0], [sine, -cosine, -q[0], 0.0]]
        };
        let pairs = forms(q).into_iter().zip(forms(q1));
        pairs
            .map(|(row, form)| (row.iter().zip(v).map(|(x, v)| x * v).sum(), form))
            .collect()
    }
}

#[test]
fn several_nonholonomic_rows_have_their_own_forms() {
    let disk = || Disk {
        mass: 1.4,
        inertia: 0.3,
        turning: 0.2,
    };
    compare(&disk(), &disk());
}

declared! {
    /// Constraints of all three orders in one declaration.
    struct Orders {
        mass: f64,
    }
    coordinates(x, y, z, w, u);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + (1 + x.powi(2)) * dot(z).powi(2)) + dot(w).powi(2) / 3 - 2 * y + x * w + dot(u).powi(2) - u * z;
    holonomic = x.powi(2) + y.powi(3) - 1;
    nonholonomic = x * dot(z) - y * dot(x) + u * dot(u) + w.sin();
    kinematic = ddot(w) + 0.3 * dot(w) + w - x * ddot(y);
    constraint_forces = [(0, x, 0, y, 0)];
    phi_lagrangian = midpoint;
}

struct ByHand(f64);

impl Declaration<5> for ByHand {
    fn lagrangian<R: Number>(&self, q: [R; 5], v: [R; 5]) -> R {
        (v[0] * v[0] + v[1] * v[1] + (q[0] * q[0] + 1.0) * v[2] * v[2]) * (self.0 / 2.0) + v[3] * v[3] / 3.0
            - q[1] * 2.0
            + q[0] * q[3]
            + v[4] * v[4]
            - q[4] * q[2]
    }

    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; 5], q1: [R; 5]) -> ([R; 5], [R; 5]) {
        midpoint(h, q0, q1)
    }

    no_rows_of_second_order!(5);
}

impl Lower<5> for ByHand {
    fn constraints(&self, h: f64, nodes: [[f64; 5]; 3]) -> Vec<(f64, [f64; 5])> {
        let [q0, q1, q2] = nodes;
        let (q, v) = midpoint(h, q1, q2);
        let central: [f64; 5] = core::array::from_fn(|i| (q2[i] - q0[i]) / (2.0 * h));
        let a: [f64; 5] = core::array::from_fn(|i| (q2[i] - 2.0 * q1[i] + q0[i]) / (h * h));
        vec![
            (
                holonomic(nodes, |q| q[0] * q[0] + q[1].powi(3) - 1.0),
                [2.0 * q1[0], 3.0 * q1[1] * q1[1], 0.0, 0.0, 0.0],
            ),
            (
                q[0] * v[2] - q[1] * v[0] + q[4] * v[4] + q[3].sin(),
                [-q1[1], 0.0, q1[0], 0.0, q1[4]],
            ),
            (
                a[3] + 0.3 * central[3] + q1[3] - q1[0] * a[1],
                [0.0, q1[0], 0.0, q1[1], 0.0],
            ),
        ]
    }
}

#[test]
fn constraints_of_all_orders_stand_side_by_side() {
    compare(&Orders { mass: 1.2 }, &ByHand(1.2));
}
