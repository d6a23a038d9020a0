//! The sign of an expression in any notation gives the same motion: dry friction on a belt, and a force
//! towards a point.

use dsocs_core::text::Text;
use dsocs_core::{Flow, Start, Stepper, Tolerance};
use dsocs_tests::text::TaylorFlow;
use proptest::prelude::*;

use super::draws;

/// The sign of `s`, in many notations.
const WRITTEN: [&str; 14] = [
    "s.signum()",
    "s.powi(3).signum()",
    "(s * s.abs()).signum()",
    "s.cbrt().signum()",
    "(1e-3 * s.sinh()).signum()",
    "s / s.abs()",
    "s / (s * s).sqrt()",
    "(2 / pi) * s.atan2(0)",
    "(if s >= 0 { 1 } else { -1 })",
    "(if s > 0 { 1 } else if s < 0 { -1 } else { 0 })",
    "(if s < 0 { -1 } else if s > 0 { 1 } else { 0 })",
    "(if s.powi(3) > 0 { 1 } else { -1 })",
    "(if s * s.abs() < 0 { -1 } else { 1 })",
    "(2 / pi) * s.atan2(none)",
];

/// The number of steps to the end.
const STEPS: u32 = 8000;

fn declared(sign: &str, s: &str, force: f64, potential: &str) -> Text {
    let text = format!(
        "parameters {{ none = 0.0 }} coordinates(x); lagrangian = dot(x).powi(2) / 2 - {potential}; let s = {s}; \
         external_forces = -{force:?} * {sign};"
    );
    Text::parse("written", &text).unwrap()
}

/// The errors of the Taylor flow at a tolerance of 1e-10, and of steps of about 1 ms.
fn errors(text: &Text, start: Start<1>, until: f64, expected: [f64; 2]) -> [f64; 2] {
    let error = |q: f64, v: f64| (q - expected[0]).abs().max((v - expected[1]).abs());
    let mut continuous = TaylorFlow::read(&text.system, start, Tolerance::relative(1e-10)).unwrap();
    let reached = continuous.to(until).map(|_| ());
    let node = continuous.node();
    let continuous = if reached.is_ok() {
        error(node.q[0], node.v[0])
    } else {
        f64::NAN
    };
    let mut steps = Flow::of(&text.system, until / f64::from(STEPS), start).unwrap();
    let run = steps.run_mut();
    for _ in 0..STEPS {
        if run.advance().is_err() {
            return [continuous, f64::NAN];
        }
    }
    let mut node = dsocs_core::OwnedNode::new(1);
    node.take(run);
    let node = node.any();
    [continuous, error(node.q[0], node.v[0])]
}

#[test]
fn friction_is_the_same_however_its_sign_is_written() {
    // a block on a spring slips from rest until it is as fast as the belt, sticks until the spring equals the
    // friction, and slips back
    draws::test(6, 91, [0.5..1.5, 0.1..0.45], &|[dry, belt]: [f64; 2]| {
        let sticks = (belt / dry).asin();
        let slips = sticks + dry * (belt / dry).asin().cos() / belt;
        let later = 4.0;
        let expected = [dry + belt * f64::sin(later), belt * f64::cos(later)];
        // the last notation, an `atan2` whose abscissa is zero by a parameter only, does not stick
        for sign in &WRITTEN[..WRITTEN.len() - 1] {
            let text = declared(sign, &format!("dot(x) - {belt:?}"), dry, "x * x / 2");
            let start = Start::second_order([0.0], [0.0]);
            let [continuous, steps] = errors(&text, start, slips + later, expected);
            prop_assert!(continuous < 1e-8, "{sign} {dry} {belt}: {continuous:e}");
            prop_assert!(steps < 3e-3, "{sign} {dry} {belt}: {steps:e}");
        }
        Ok(())
    });
}

#[test]
fn a_force_to_a_place_is_the_same_however_its_sign_is_written() {
    // parts of parabolas
    draws::test(6, 92, [0.5..2.0, -0.5..0.5, 5.0..9.0], &|[
        force,
        place,
        until,
    ]: [f64; 3]| {
        let quarter = f64::sqrt(2.0 / force);
        // the second half period mirrors the first, which mirrors itself in time
        let (half, within) = (until % (4.0 * quarter) >= 2.0 * quarter, until % (2.0 * quarter));
        let side = if half { -1.0 } else { 1.0 };
        let left = 2.0 * quarter - within;
        let way = if within < quarter {
            [1.0 - force * within * within / 2.0, -force * within]
        } else {
            [force * left * left / 2.0 - 1.0, -force * left]
        };
        let way = way.map(|x| side * x);
        for sign in WRITTEN {
            let text = declared(sign, &format!("x - {place:?}"), force, "0 * x");
            let start = Start::second_order([place + 1.0], [0.0]);
            let [continuous, steps] = errors(&text, start, until, [place + way[0], way[1]]);
            prop_assert!(
                continuous < 1e-8,
                "{sign} {force} {place} {until}: {continuous:e}"
            );
            prop_assert!(steps < 3e-2, "{sign} {force} {place} {until}: {steps:e}");
        }
        Ok(())
    });
}

/// 1 where `s` is positive and 0 elsewhere: signs of expressions that rest at zero.
const ONE_SIDED: [&str; 12] = [
    "(if s > 0 { 1 } else { 0 })",
    "s.max(0).signum()",
    "s.max(0).powi(2).signum()",
    "(3 * s.max(0).sqrt()).signum()",
    "-(-s).min(0).signum()",
    "(s + s.abs()).signum()",
    "(s.powi(3) + s * s * s.abs()).signum()",
    "(s.max(0) * (2 + x.cos())).signum()",
    "s.max(0).min(1).signum()",
    "(if s > 0 { s } else { 0 }).signum()",
    "(if s.max(0) > 0 { 1 } else { 0 })",
    "(if s + s.abs() <= 0 { 0 } else { 1 })",
];

#[test]
fn a_sign_that_rests_at_zero_is_zero_there() {
    draws::test(6, 93, [0.5..1.5, 0.2..2.0], &|[force, push]: [f64; 2]| {
        for sign in ONE_SIDED {
            // a push turns a velocity of -1 to rest, where a friction that acts forwards only holds the mass if
            // it is larger than the push
            let text = declared(sign, "dot(x)", force * push, &format!("({push:?} * -x)"));
            let start = Start::second_order([0.0], [-1.0]);
            let [rests, later] = [1.0 / push, 1.5];
            let speed = push * (1.0 - force).max(0.0) * later;
            let expected = [0.5 * (speed * later - rests), speed];
            let [continuous, steps] = errors(&text, start, rests + later, expected);
            prop_assert!(continuous < 1e-8, "{sign} {force} {push}: {continuous:e}");
            prop_assert!(steps < 3e-3, "{sign} {force} {push}: {steps:e}");
            // into a field that begins at a place, and back
            let text = declared(sign, "x - 0.25", force, "0 * x");
            let start = Start::second_order([-0.75], [1.0]);
            let until = 1.5 + 2.0 / force;
            let [continuous, steps] = errors(&text, start, until, [-0.25, -1.0]);
            prop_assert!(continuous < 1e-8, "{sign} {force}: {continuous:e}");
            prop_assert!(steps < 3e-2, "{sign} {force}: {steps:e}");
            // nothing moves a mass at the beginning of the field, or at rest
            for s in ["x", "dot(x)"] {
                let text = declared(sign, s, force, "0 * x");
                let [continuous, steps] = errors(&text, Start::second_order([0.0], [0.0]), 1.0, [0.0; 2]);
                prop_assert!(
                    continuous < 1e-30 && steps < 1e-30,
                    "{sign} of {s}: {continuous:e} {steps:e}"
                );
            }
        }
        Ok(())
    });
}

#[test]
fn a_force_outside_of_a_dead_band_is_none_within() {
    // a relay with a dead band: thrust towards the middle from outside
    for sign in [
        "x.signum() * (x.abs() - 0.5).max(0).signum()",
        "((x - 0.5).max(0) + (x + 0.5).min(0)).signum()",
        "(if (x.abs() - 0.5).max(0) > 0 { x.signum() } else { 0 })",
    ] {
        let text = declared(sign, "x", 2.0, "0 * x");
        // from 1.5 at rest: 1 s with acceleration -2, ½ s free, 1 s back to rest
        for (until, expected) in [(1.0, [0.5, -2.0]), (1.25, [0.0, -2.0]), (2.5, [-1.5, 0.0])] {
            let [continuous, steps] = errors(&text, Start::second_order([1.5], [0.0]), until, expected);
            assert!(continuous < 1e-8, "{sign} {until}: {continuous:e}");
            assert!(steps < 3e-2, "{sign} {until}: {steps:e}");
        }
    }
}
