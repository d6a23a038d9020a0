//! Mostly zero Jacobians are eliminated in an order that is chosen when the code is generated.
//!
//! `dsocs-core/src/solve/sparse/tests.rs` tests the elimination itself on random matrices.

use dsocs_core::__private::Compiled;
use dsocs_core::prelude::*;
use dsocs_core::{Leg, StepFailure, System as _};
use dsocs_tests::rods::Rods;
use dsocs_tests::tape;

/// Positions of rods that lean more and more to the right.
fn leaning(by: f64) -> [f64; 28] {
    let mut q = [0.0; 28];
    let (mut x, mut y) = (0.0, 0.0);
    for i in 0..14 {
        let angle = by * (1.0 + 0.1 * i as f64);
        x += 0.5 * angle.sin();
        y -= 0.5 * angle.cos();
        (q[i], q[14 + i]) = (x, y);
    }
    q
}

#[test]
fn code_and_tape_of_a_sparse_step_agree() {
    const { assert!(<Rods as Compiled<28>>::SPARSE) };
    let leg = Leg {
        t: 0.0,
        q: leaning(0.3),
        d: core::array::from_fn(|i| 1e-3 * (i as f64).sin()),
    };
    let e = core::array::from_fn(|i| 1e-5 * (i as f64).cos());
    let multipliers: [f64; 14] = core::array::from_fn(|i| 1.0 + i as f64);
    tape::same_bits(&Rods::default(), 1e-2, &leg, &e, &multipliers).unwrap();
}

#[test]
fn rods_keep_their_lengths_and_the_chain_its_energy() {
    let rods = Rods::default();
    let mut flow = Flow::new(&rods, 1e-3, Start::second_order(leaning(0.2), [0.0; 28])).unwrap();
    let start = flow.node().energy;
    let lowest = rods.energy(0.0, &leaning(0.0), &[0.0; 28]);
    let (mut energy, mut length): (f64, f64) = (0.0, 0.0);
    let mut evaluations = 0;
    for _ in 0..3000 {
        flow.advance().unwrap();
        let node = flow.node();
        evaluations += node.iterations;
        energy = energy.max((node.energy - start).abs());
        for i in 1..14 {
            let rod = (node.q[i] - node.q[i - 1]).hypot(node.q[14 + i] - node.q[13 + i]);
            length = length.max((rod - 0.5).abs());
        }
    }
    println!("energy {energy:e} of {}, lengths {length:e}", start - lowest);
    assert!(
        energy < 1e-4 * (start - lowest) && length < 1e-14,
        "{energy:e} {length:e}"
    );
    // the first update is so accurate that the second is nearly always the last
    assert!(evaluations < 6100, "{evaluations}");
}

#[test]
fn lanes_make_the_same_steps() {
    let rods = Rods::default();
    let starts = [0.1, 0.2, 0.25, 0.3].map(|by| Start::second_order(leaning(by), [0.0; 28]));
    let together = Ensemble::new(&rods, 1e-3).unwrap().starts(starts).to(0.2);
    for (start, end) in starts.into_iter().zip(together) {
        let alone = Flow::new(&rods, 1e-3, start).unwrap().to(0.2).unwrap();
        assert_eq!(end.unwrap().q.map(f64::to_bits), alone.q.map(f64::to_bits));
    }
}

/// Pairs of uncoupled oscillators `a`, `b`, with two rows each that mix both. The coefficients of `ddot(a)`
/// in the first row and of `ddot(b)` in the second are `a`, so that these pivots vanish at times.
#[dsocs {
    coordinates(a: [7], b: [7]);
    lagrangian = 0;
    let left = |i| ddot(a[i]) + a[i];
    let right = |i| ddot(b[i]) + b[i];
    kinematic = [
        each(0..7, |i| (a[i] * left(i) + (2 + b[i].sin()) * right(i)) * gain),
        each(0..7, |i| ((2 + b[i].cos()) * left(i) + a[i] * right(i)) * gain * b[i]),
    ];
    variational = [];
}]
#[derive(Clone, Debug)]
struct Mixed {
    gain: f64,
}

#[test]
fn pivots_that_turn_bad_are_searched_for() {
    const { assert!(<Mixed as Compiled<14>>::SPARSE) };
    let h = 0.05_f64;
    // every `a` is zero at the first middle node, and small again after each half period
    let [q0, q1]: [[f64; 14]; 2] = [-1.0, 0.0].map(|k: f64| {
        core::array::from_fn(|i| {
            if i < 7 {
                0.8 * (h * k).sin()
            } else {
                (0.3 + h * k).cos() * (1.0 + 0.01 * i as f64)
            }
        })
    });
    let mixed = Mixed { gain: 1.0 };
    let mut flow = Flow::new(&mixed, h, Start::nodes(q0, q1)).unwrap();
    let (mut before, mut now) = (q0, q1);
    let mut worst: f64 = 0.0;
    for _ in 0..400 {
        flow.advance().unwrap();
        // leapfrog for each coordinate
        let next = core::array::from_fn(|i| 2.0 * now[i] - before[i] - h * h * now[i]);
        (before, now) = (now, next);
        for (found, expected) in flow.position().iter().zip(now) {
            worst = worst.max((found - expected).abs());
        }
    }
    assert!(worst < 1e-11, "{worst:e}");
}

#[test]
fn singular_rows_are_told() {
    // without a gain all rows are zero
    let q = core::array::from_fn(|i| 0.5 + 0.01 * i as f64);
    let nodes = Start::nodes(q, q.map(|q| q + 1e-3));
    match Flow::new(&Mixed { gain: 0.0 }, 0.05, nodes).unwrap().advance() {
        Err(RunError::Step(error)) => assert_eq!(error.details().cause.reason, StepFailure::Singular),
        other => panic!("{other:?}"),
    }
}
