//! Nested pieces: a limited force that follows a set point which jumps. Where one piece jumps, the arguments
//! of others jump with it, and a Taylor flow goes on in the pieces that these reach. The reference is a
//! Runge–Kutta method with steps halved at each change of sides.

use dsocs_core::text::Text;
use dsocs_core::{Start, Stepper, Tolerance};
use dsocs_tests::text::TaylorFlow;
use proptest::prelude::*;

use super::draws;

/// The sides of zero of an evaluation's comparisons, in their order.
type Sides = Vec<bool>;

/// A value by time, position and velocity, which records the sides of its comparisons.
type Value = Box<dyn Fn([f64; 3], &mut Sides) -> f64>;

/// An expression: its text, and its value.
struct Expression {
    text: String,
    value: Value,
}

/// Whether a number is above zero, with a record in `sides`.
fn above(x: f64, sides: &mut Sides) -> bool {
    sides.push(x > 0.0);
    x > 0.0
}

/// The larger of two numbers.
fn larger(x: f64, y: f64, sides: &mut Sides) -> f64 {
    if above(x - y, sides) { x } else { y }
}

impl Expression {
    fn new(text: String, value: impl Fn([f64; 3], &mut Sides) -> f64 + 'static) -> Self {
        Self {
            text,
            value: Box::new(value),
        }
    }
}

/// A function that jumps in time or space, or is smooth.
fn piece(kind: usize, [a, b]: [f64; 2]) -> Expression {
    match kind {
        0 => Expression::new(
            format!("(if ({a:?} * t + {b:?}).sin() > 0 {{ 1.0 }} else {{ -0.6 }})"),
            move |[t, ..], sides| {
                if above((a * t + b).sin(), sides) {
                    1.0
                } else {
                    -0.6
                }
            },
        ),
        1 => Expression::new(
            format!("(x - {:?}).signum()", 0.3 * b),
            move |[_, x, _], sides| if above(x - 0.3 * b, sides) { 1.0 } else { -1.0 },
        ),
        2 => Expression::new(
            format!("(if x > {:?} {{ 0.8 }} else {{ -0.4 }})", 0.2 * b),
            move |[_, x, _], sides| if above(x - 0.2 * b, sides) { 0.8 } else { -0.4 },
        ),
        _ => Expression::new(format!("({a:?} * t + {b:?}).sin()"), move |[t, ..], _| {
            (a * t + b).sin()
        }),
    }
}

/// A limit, an absolute value, a comparison or a maximum of two expressions.
fn piece_of_pieces(kind: usize, one: Expression, other: Expression, [c, d]: [f64; 2]) -> Expression {
    let (text, also) = (one.text, other.text);
    let (one, other) = (one.value, other.value);
    match kind {
        0 => Expression::new(
            format!("({text} - 2 * dot(x) - 4 * x).max(-{c:?}).min({d:?})"),
            move |at, sides| {
                let [_, x, v] = at;
                let asked = one(at, sides) - 2.0 * v - 4.0 * x;
                -larger(-larger(asked, -c, sides), -d, sides)
            },
        ),
        1 => Expression::new(format!("({text} + {also} - x).abs()"), move |at, sides| {
            let sum = one(at, sides) + other(at, sides) - at[1];
            larger(sum, -sum, sides)
        }),
        2 => Expression::new(
            format!("(if {text} - x > 0.4 * {also} {{ {c:?} }} else {{ -{d:?} }})"),
            move |at, sides| {
                let apart = one(at, sides) - at[1] - 0.4 * other(at, sides);
                if above(apart, sides) { c } else { -d }
            },
        ),
        _ => Expression::new(format!("({text}).max({also} * x - 0.1)"), move |at, sides| {
            let line = other(at, sides) * at[1] - 0.1;
            larger(one(at, sides), line, sides)
        }),
    }
}

/// A Runge–Kutta step, and whether all of its evaluations had the same sides.
fn step(force: &Expression, t: f64, [x, v]: [f64; 2], h: f64) -> ([f64; 2], bool) {
    let mut all: Vec<Sides> = Vec::new();
    let mut rate = |t: f64, [x, v]: [f64; 2]| {
        let mut sides = Sides::new();
        let a = -x - 0.3 * v + (force.value)([t, x, v], &mut sides);
        all.push(sides);
        [v, a]
    };
    let along = |[k, l]: [f64; 2], h: f64| [x + h * k, v + h * l];
    let k1 = rate(t, [x, v]);
    let k2 = rate(t + h / 2.0, along(k1, h / 2.0));
    let k3 = rate(t + h / 2.0, along(k2, h / 2.0));
    let k4 = rate(t + h, along(k3, h));
    let mean = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
    let end = along([mean(0), mean(1)], h);
    rate(t + h, end);
    (end, all.windows(2).all(|pair| pair[0] == pair[1]))
}

/// The end of the motion, with steps halved until only steps shorter than rounding cross a change of sides;
/// `None` where it slides along one.
fn reference_end(force: &Expression) -> Option<[f64; 2]> {
    let (mut t, mut state, mut h, mut steps) = (0.0, [0.5, 0.2], 1e-3_f64, 0);
    while t < 4.0 {
        steps += 1;
        if steps > 30_000 {
            return None;
        }
        h = h.min(4.0 - t);
        let (end, is_smooth) = step(force, t, state, h);
        if is_smooth || h < 1e-13 {
            (t, state) = (t + h, end);
            h = (2.0 * h).min(1e-3);
        } else {
            h *= 0.5;
        }
    }
    Some(state)
}

/// 60 random forces of nested limits, comparisons and maxima: the position and velocity of a Taylor flow are
/// those of the Runge–Kutta reference, or the motion ends since it slides along a jump.
#[test]
fn pieces_within_pieces_are_those_of_their_arguments() {
    let numbers = || [0.7..3.5, -1.0..1.0];
    let outers = || (0..4_usize, [0.3..2.0, 0.3..2.0]);
    let inners = || (0..4_usize, numbers());
    let draws = (outers(), outers(), inners(), inners(), inners());
    draws::test(60, 32, draws, &|(first, second, one, other, third)| {
        let within = piece_of_pieces(first.0, piece(one.0, one.1), piece(other.0, other.1), first.1);
        let force = piece_of_pieces(second.0, within, piece(third.0, third.1), second.1);
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = {} - 0.3 * dot(x);",
            force.text
        );
        let Some(reference) = reference_end(&force) else {
            return Ok(());
        };
        let text_of = Text::parse("nested", &text).unwrap();
        for tolerance in [1e-7, 1e-10] {
            let start = Start::second_order([0.5], [0.2]);
            let mut flow = TaylorFlow::read(&text_of.system, start, Tolerance::relative(tolerance)).unwrap();
            if let Err(error) = flow.to(4.0) {
                // where both sides lead back, the motion slides or ends
                prop_assert!(error.to_string().contains("sticks"), "{text}: {error}");
                continue;
            }
            let node = flow.node();
            let apart = (node.q[0] - reference[0])
                .abs()
                .max((node.v[0] - reference[1]).abs());
            prop_assert!(
                apart < 1e3 * tolerance.max(1e-9),
                "{text} {tolerance:e}: {:?} {:?} {reference:?}",
                node.q,
                node.v
            );
        }
        Ok(())
    });
}
