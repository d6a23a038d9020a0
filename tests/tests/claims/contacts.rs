//! A Taylor flow through contacts of several bodies, at different times or at once, with forces that grow
//! with any power of the depth.

use std::fmt::Write as _;

use dsocs_core::text::Text;
use dsocs_core::{Start, Stepper, Tolerance};
use dsocs_tests::text::TaylorFlow;
use proptest::prelude::*;

use super::draws;

/// The tolerances, which are no powers of ten.
const TOLERANCES: [f64; 3] = [3e-7, 2e-9, 1e-11];

/// Position and velocity at the end of a motion, and the largest change of its energy.
fn end<const N: usize>(
    text: &str,
    (q, v): ([f64; N], [f64; N]),
    until: f64,
    tolerance: f64,
) -> (Vec<f64>, f64) {
    let text = Text::parse("contacts", text).unwrap();
    let start = Start::second_order(q, v);
    let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
    let first = flow.node().energy;
    let mut most = 0.0_f64;
    for part in 1..=30 {
        flow.to(until * f64::from(part) / 30.0).unwrap();
        let energy = flow.node().energy;
        assert!(energy.is_finite());
        most = most.max((energy - first).abs());
    }
    let node = flow.node();
    (node.q.iter().chain(&node.v).copied().collect(), most)
}

/// The potential of a contact force `stiffness · depth^(exponent - 1)`.
fn power(depth: &str, exponent: f64, stiffness: f64) -> String {
    format!("{stiffness:?} / {exponent:?} * ({depth}).max(0.0).powf({exponent:?})")
}

/// Three falling balls: each onto its own floor, onto each other, or each onto the floor with the first two
/// on a cable.
fn balls(kind: usize, [a, b, c]: [f64; 3], exponent: f64, stiffness: f64) -> String {
    let mut lagrangian = String::new();
    for (mass, x) in [(a, "x"), (b, "y"), (c, "z")] {
        write!(lagrangian, "{mass:?} * (dot({x}).powi(2) / 2 - 9.81 * {x}) + ").unwrap();
    }
    let depths: &[&str] = match kind {
        0 => &["-x", "-y", "-z"],
        1 => &["0.1 - x", "x - y + 0.5", "y - z + 0.5"],
        _ => &["-0.3 - x", "-0.3 - y", "-0.3 - z", "(x - y).abs() - 0.8"],
    };
    let potentials = depths.iter().map(|depth| power(depth, exponent, stiffness));
    let potentials: Vec<_> = potentials.collect();
    format!(
        "coordinates(x, y, z); lagrangian = {lagrangian} 0 - ({});",
        potentials.join(" + ")
    )
}

#[test]
fn contacts_conserve_the_energy_to_the_tolerance() {
    let masses = [0.5..3.0, 0.5..3.0, 0.5..3.0];
    let draws = (
        0..3_usize,
        masses,
        0..6_usize,
        3.0..5.0,
        [0.05..1.0, 0.05..1.0, 0.05..1.0],
        [-1.0..1.0, -1.0..1.0, -1.0..1.0],
    );
    draws::test(40, 58, draws, &|(kind, masses, exponent, stiffness, q, v)| {
        let exponent = [1.5, 2.0, 2.2, 2.5, 3.0, 3.5][exponent];
        let text = balls(kind, masses, exponent, 10.0_f64.powf(stiffness));
        let apart = if kind == 1 { 1.2 } else { 0.0 };
        let q = [q[0] + 0.1, q[1] + 0.1 + apart, q[2] + 0.1 + 2.0 * apart];
        let size = masses.iter().zip(q).map(|(m, q)| 9.81 * m * q).sum::<f64>() + 1.0;
        for tolerance in TOLERANCES {
            let (_, most) = end(&text, (q, v), 3.0, tolerance);
            prop_assert!(
                most < 3e3 * tolerance * size,
                "{text} {q:?} {v:?} {tolerance:e}: {most:e}"
            );
        }
        Ok(())
    });
}

#[test]
fn contacts_of_other_bodies_change_nothing() {
    let together = "coordinates(x, y); lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) - 9.81 * x - 19.62 * y \
        - 4000 * ((-x).max(0.0).powf(2.5) + (-y).max(0.0).powf(2.5));";
    let alone =
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 9.81 * x - 4000 * (-x).max(0.0).powf(2.5);";
    for tolerance in TOLERANCES {
        let (both, _) = end(together, ([0.25, 1.0], [-1.0, 0.0]), 3.0, tolerance);
        let (one, _) = end(alone, ([0.25], [-1.0]), 3.0, tolerance);
        for (both, one) in [both[0], both[2]].iter().zip(&one) {
            assert!(
                (both - one).abs() < 3e3 * tolerance,
                "{tolerance:e}: {both} {one}"
            );
        }
    }
    // a ball that lies on the floor sinks in, and comes up again
    for tolerance in TOLERANCES {
        let (lying, most) = end(together, ([0.0, 1.0], [0.0, 0.0]), 3.0, tolerance);
        assert!(
            lying[0] < 0.0 && most < 1e3 * tolerance,
            "{tolerance:e}: {lying:?} {most:e}"
        );
    }
}

#[test]
fn balls_of_a_cradle_meet_at_the_same_time() {
    let text = "coordinates(a, b, c, d); \
        lagrangian = (dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2) + dot(d).powi(2)) / 2 \
            - 9.81 * (a.powi(2) + b.powi(2) + c.powi(2) + d.powi(2)) / 2 \
            - 4000 * ((a - b).max(0.0).powf(2.5) + (b - c).max(0.0).powf(2.5) + (c - d).max(0.0).powf(2.5));";
    // those that hang apart come back to the middle together; those that hang at rest touch each other
    for second in [0.01, 0.0] {
        let start = ([-0.5, 0.0, second, 2.0 * second], [0.0; 4]);
        let (reference, _) = end(text, start, 3.0, 1e-13);
        for tolerance in [1e-5, 1e-6, 1e-7, 5e-8, 3e-8, 1e-8, 3e-9, 1e-9, 1e-10, 1e-12] {
            let (found, most) = end(text, start, 3.0, tolerance);
            assert!(most < 1e3 * tolerance, "{second} {tolerance:e}: {most:e}");
            for (found, reference) in found.iter().zip(&reference) {
                assert!(
                    (found - reference).abs() < 1e4 * tolerance,
                    "{second} {tolerance:e}: {found} {reference}"
                );
            }
        }
    }
}
