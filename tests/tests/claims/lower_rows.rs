//! Discrete rows of nonholonomic constraints, one by one, are those of the paper written by hand: `c(φ⁻¹(q1, q2))`, then
//! `Q − Σ λ α(q1)` for any multipliers.

use dsocs_core::__private::Declaration as Tape;
use dsocs_core::{Leg, System};
use dsocs_systems::Sleigh;
use dsocs_tests::independent::{self, Declaration, Number, map2};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};

/// What a declaration with constraints of lower order says, by hand.
trait Lower<const N: usize>: Declaration<N> {
    /// The constraints on the last leg, with the form of each at the middle node.
    fn constraints(&self, h: f64, nodes: [[f64; N]; 3]) -> Vec<(f64, [f64; N])>;
}

/// A midpoint, and the velocity there.
fn midpoint<R: Number, const N: usize>(h: R, q0: [R; N], q1: [R; N]) -> ([R; N], [R; N]) {
    (
        map2(q0, q1, |x0, x1| (x0 + x1) * 0.5),
        map2(q0, q1, |x0, x1| (x1 - x0) / h),
    )
}

/// Holds every declared row against the one by hand, at random triples and multipliers.
fn compare<S: System<N>, P: Lower<N>, const N: usize>(system: &S, by_hand: &P) {
    let config = Config {
        cases: 200,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(11),
        ..Config::default()
    };
    let vector = |size: f64| prop::array::uniform::<_, N>(-size..size);
    let states = (0.05..0.5, vector(2.0), vector(2.0), vector(3.0), -2.0..2.0);
    let result = TestRunner::new(config).run(&states, |(h, q, v, a, multiplier)| {
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
        let declaration = Tape::of(system);
        let constraints = by_hand.constraints(h, nodes);
        let multipliers = vec![multiplier; constraints.len()];
        let rows = declaration.declared(h, &leg, &e, &multipliers);
        let force = independent::force(by_hand, h, nodes);
        let mut expected: Vec<f64> = constraints.iter().map(|(row, _)| *row).collect();
        expected.extend((0..N).map(|i| {
            let held: f64 = constraints.iter().map(|(_, form)| multiplier * form[i]).sum();
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
    if let Err(error) = result {
        panic!("{error}");
    }
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
