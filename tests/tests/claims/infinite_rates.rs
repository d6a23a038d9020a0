//! Forces whose rate has no bound where they are zero: powers below one of a position or a velocity. The references are closed forms.

use std::f64::consts::FRAC_PI_2;

use dsocs_core::text::Text;
use dsocs_core::{AnyComposedFlow, Composition, Flow, Start, Stepper as _, Tolerance};
use dsocs_tests::dop853::integrate_from;
use dsocs_tests::text::TaylorFlow;
use proptest::prelude::*;

use super::draws;

/// The end of runs that are compared with those of DOP853.
const UNTIL: f64 = 4.0;

const TOLERANCES: [f64; 2] = [1e-6, 1e-9];

fn declared(force: &str) -> Text {
    let text = format!("coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = {force};");
    Text::parse("root", &text).unwrap()
}

/// The spellings of `-k |u|^p sgn u`.
fn power(which: usize, u: &str, [k, p]: [f64; 2]) -> String {
    match which {
        0 => format!("-{k:?} * {u}.abs().powf({p:?}) * {u}.signum()"),
        _ => format!("-{k:?} * {u}.signum() * {u}.abs().powf({:?}).sqrt()", 2.0 * p),
    }
}

/// A quarter of the period of a motion with the force `-k |x|^p sgn x` between `-a` and `a`.
fn quarter([k, p]: [f64; 2], a: f64) -> f64 {
    let exponent = 2.0 / (1.0 + p) - 1.0;
    // ∫ sin^exponent from 0 to π/2, by Simpson's rule in a variable in which the integrand is smooth at 0
    let parts = 20_000;
    let value = |k: u32| {
        let y = f64::from(k) / f64::from(parts);
        (FRAC_PI_2 * y.powi(8)).sin().powf(exponent) * FRAC_PI_2 * 8.0 * y.powi(7)
    };
    let weight = |k: u32| match k {
        0 => 1.0,
        k if k == parts => 1.0,
        k if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let integral = (0..=parts).map(|k| weight(k) * value(k)).sum::<f64>() / (3.0 * f64::from(parts));
    ((1.0 + p) / (2.0 * k)).sqrt() * a.powf(0.5 * (1.0 - p)) * 2.0 / (1.0 + p) * integral
}

/// The position and the velocity at a time of a run by a tolerance.
fn by_tolerance(text: &Text, start: Start<1>, tolerance: f64, until: f64) -> Result<[f64; 2], String> {
    let mut flow =
        TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).map_err(|e| e.to_string())?;
    flow.to(until).map_err(|error| error.to_string())?;
    Ok([flow.node().q[0], flow.node().v[0]])
}

#[test]
fn a_series_passes_the_zero_of_a_root_and_begins_there() {
    let scenes = (0_usize..2, [0.5..3.0, 0.25..0.9], 0.3..2.0, any::<bool>());
    draws::test(80, 91, scenes, &|(which, law, a, at_zero): (
        usize,
        [f64; 2],
        f64,
        bool,
    )| {
        let text = declared(&power(which, "x", law));
        let [k, p] = law;
        let (quarter, speed) = (quarter(law, a), (2.0 * k * a.powf(1.0 + p) / (1.0 + p)).sqrt());
        for tolerance in TOLERANCES {
            let (start, quarters) = if at_zero {
                (Start::second_order([0.0], [speed]), 4.0)
            } else {
                (Start::second_order([a], [0.0]), 5.0)
            };
            let found = by_tolerance(&text, start, tolerance, quarters * quarter);
            prop_assert!(found.is_ok(), "{which} {law:?} {a} {tolerance}: {found:?}");
            let sign = if at_zero { 1.0 } else { -1.0 };
            let [x, v] = found.unwrap_or_default();
            let error = x.abs().max((v - sign * speed).abs());
            prop_assert!(
                error < 1e3 * tolerance,
                "{which} {law:?} {a} {at_zero} {tolerance}: {x} {v} {speed}"
            );
        }
        Ok(())
    });
}

/// The unresolved steps of runs of the orders 2 and 4.
fn counted(text: &Text, start: Start<1>, h: f64, until: f64) -> [u64; 2] {
    let mut order_2 = Flow::of(&text.system, h, start).unwrap();
    order_2.to(until).unwrap();
    let mut order_4 = AnyComposedFlow::new(&text.system, h, Composition::SUZUKI_4, &start.into()).unwrap();
    order_4.run_mut().to(until).unwrap();
    [order_2.unresolved(), order_4.run().unresolved()].map(|found| found.map_or(0, |found| found.steps))
}

#[test]
fn steps_tell_of_the_zero_of_a_root() {
    draws::test(
        60,
        94,
        (0_usize..2, [0.5..3.0, 0.1..0.8], 0.3..2.0),
        &|(which, law, a): (usize, [f64; 2], f64)| {
            let text = declared(&power(which, "x", law));
            let quarter = quarter(law, a);
            for parts in [40.0, 110.0] {
                let h = quarter / parts;
                // it passes zero twice
                for steps in counted(
                    &text,
                    Start::second_order([a], [0.0]),
                    h,
                    (3.5 * parts).floor() * h,
                ) {
                    prop_assert!((2..=5).contains(&steps), "{which} {law:?} {a} {h}: {steps}");
                }
            }
            Ok(())
        },
    );
}

#[test]
fn steps_tell_of_no_root_where_there_is_none() {
    for force in [
        "-x.abs().powf(1.5) * x.signum()",
        "-x.abs().powf(1.1) * x.signum()",
        "-x * (1 + x.powi(2)).sqrt()",
        "-x * x.hypot(0.1)",
        "-x * (3 - x).sqrt()",
        "-x - 0.3 * dot(x).abs().powf(1.5) * dot(x).signum()",
    ] {
        for h in [0.02, 0.0071, 0.002] {
            let found = counted(
                &declared(force),
                Start::second_order([1.0], [0.1]),
                h,
                (9.0_f64 / h).floor() * h,
            );
            assert_eq!(found, [0, 0], "{force} {h}");
        }
    }
    // what a root leads to rest keeps its order
    for p in [0.3, 0.5, 0.7] {
        for h in [0.02, 0.0071, 0.002] {
            let text = declared(&power(0, "dot(x)", [0.7, p]));
            let found = counted(
                &text,
                Start::second_order([0.0], [1.0]),
                h,
                (9.0_f64 / h).floor() * h,
            );
            assert_eq!(found, [0, 0], "{p} {h}");
        }
    }
}

/// Two masses on springs, the first of which has a force that is a root of its position or its velocity: neither ends the motion of the other.
#[test]
fn a_root_is_passed_beside_another_motion() {
    let scenes = (0_usize..8, [0.1..0.6, 0.25..0.9], -0.4..0.4, 0.3..1.0);
    draws::test(60, 94, scenes, &|(which, [k, p], coupling, v): (
        usize,
        [f64; 2],
        f64,
        f64,
    )| {
        let of_velocity = which % 2 == 0;
        let u = if of_velocity { "dot(x)" } else { "x" };
        let (force, p) = match which / 2 {
            0 => (format!("-{k:?} * {u}.cbrt()"), 1.0 / 3.0),
            1 => (format!("-{k:?} * {u}.abs().sqrt() * {u}.signum()"), 0.5),
            spelling => (power(spelling - 2, u, [k, p]), p),
        };
        let text = format!(
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - (x.powi(2) + 1.7 * y.powi(2)) / 2 - {coupling:?} * x * y;
             external_forces = ({force}, 0);"
        );
        let text = Text::parse("root", &text).unwrap();
        let rate = |_: f64, [x, y, vx, vy]: [f64; 4]| {
            let u = if of_velocity { vx } else { x };
            let root = -k * u.abs().powf(p) * u.signum();
            [vx, vy, -x - coupling * y + root, -1.7 * y - coupling * x]
        };
        let first = [1.0, 0.3, 0.2, v];
        let expected = integrate_from(rate, (0.0, first), UNTIL, 1e-13);
        for tolerance in [1e-6, 1e-8, 1e-10] {
            let start = Start::second_order([first[0], first[1]], [first[2], first[3]]);
            let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
            if let Err(error) = flow.to(UNTIL) {
                prop_assert!(false, "{force} {coupling} {v} {tolerance}: {error}");
            }
            let node = flow.node();
            let found = [node.q[0], node.q[1], node.v[0], node.v[1]];
            for (found, expected) in found.iter().zip(expected) {
                prop_assert!(
                    (found - expected).abs() < 1000.0 * tolerance.max(1e-11),
                    "{force} {coupling} {v} {tolerance}: {found} for {expected}"
                );
            }
        }
        Ok(())
    });
}

/// Where an inverse cosine or sine comes to its end and turns back, its argument is 1 to rounding for a while, and shows no derivative.
#[test]
fn an_angle_passes_its_end_wherever_a_step_ends() {
    type Force = fn(f64, f64) -> f64;
    let laws: [(&str, Force); 3] = [
        ("-x.cos().acos()", |_, x| -x.cos().acos()),
        ("-x.sin().asin()", |_, x| -x.sin().asin()),
        ("0.3 * (3 * t).sin().asin()", |t, _| 0.3 * (3.0 * t).sin().asin()),
    ];
    for (law, force) in laws {
        let text = declared(&format!("({law})"));
        for k in 0..26 {
            let v = 0.5 + 0.1 * f64::from(k);
            let found = by_tolerance(&text, Start::second_order([0.4], [v]), 1e-10, 30.0);
            let expected = integrate_from(
                |t, [x, v]: [f64; 2]| [v, force(t, x)],
                (0.0, [0.4, v]),
                30.0,
                1e-12,
            );
            let is_near = |found: [f64; 2]| {
                let apart = (0..2).map(|i| (found[i] - expected[i]).abs() / (1.0 + expected[i].abs()));
                apart.fold(0.0, f64::max) < 1e-6
            };
            assert!(
                found.as_ref().is_ok_and(|found| is_near(*found)),
                "{law} {v}: {found:?} {expected:?}"
            );
        }
    }
}
