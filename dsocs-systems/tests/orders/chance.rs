//! Random systems: the order that follows from the parts is the order of the errors.

use std::fmt::Write as _;

use dsocs_scenes::random::Random;
use dsocs_scenes::short_or_long;
use dsocs_systems::check::orders::{Order, Part};

use super::{assert_order, of_text};

/// A coefficient, which may be zero.
fn coefficient(random: &mut Random) -> String {
    let is_zero = random.chance(0.25);
    let size = random.between(0.3, 0.9);
    format!("{:?}", if is_zero { 0.0 } else { size })
}

/// The Lagrangian, constraints and maps of a random system, and whether its `D_K` and its `D_V` are of order
/// 1 by their maps.
fn drawn(random: &mut Random) -> (String, [bool; 2]) {
    let [a, b, c, d, f] = core::array::from_fn(|_| coefficient(random));
    let mut text = format!(
        "coordinates(x, y);
        lagrangian = (2 + {a} * x.sin()) / 2 * dot(x).powi(2) + (1 + {b} * x.powi(2)) / 2 * dot(y).powi(2) + {c} / 2 * dot(x) * dot(y)
            + {d} * y.powi(2) * dot(x) - x.powi(2) / 2 - y.powi(2) - x * y / 3 - x.powi(3) / 5;
        external_forces = (-{f} * dot(x) * (1 + y.powi(2)), {f} * t.sin());\n"
    );
    let mut one = |of: &[&'static str]| of[random.below(of.len())];
    let place = one(&[
        "q0",
        "q0 / 4 + 3 * q1 / 4",
        "(q0 + q1) / 2",
        "(q0 + q1) / 2",
        "q1",
    ]);
    let _ = writeln!(text, "phi_lagrangian = |q0, q1| ({place}, (q1 - q0) / h);");
    if random.chance(0.3) {
        return (text, [false; 2]);
    }
    let mut low = [false; 2];
    for (low, statement) in low.iter_mut().zip(["phi_kinematic", "phi_variational"]) {
        let mut one = |of: &[&'static str]| of[random.below(of.len())];
        let place = one(&["q1", "q1", "(q0 + 2 * q1 + q2) / 4", "q1 + (q2 - q0) / 8"]);
        let velocity = one(&[
            "(q2 - q0) / (2 * h)",
            "(q2 - q0) / (2 * h)",
            "(q2 - q1) / h",
            "(3 * q2 - 2 * q1 - q0) / (4 * h)",
        ]);
        let _ = writeln!(
            text,
            "{statement} = |q0, q1, q2| ({place}, {velocity}, (q2 - 2 * q1 + q0) / (h * h));"
        );
        *low = place.contains("/ 8") || !velocity.contains("- q0) / (2");
    }
    text +=
        "kinematic = ddot(y) + dot(x) * dot(y) / 3 + y + x.powi(2) / 4 + dot(y).powi(2) / 5 - x * dot(x) / 4;
        variational = [(1 + dot(y) / 3 + x / 5, x / 2 + dot(x) / 4)];\n";
    (text, low)
}

/// The order that follows is measured, and rows and fields have the orders of their maps.
#[test]
fn the_order_that_follows_is_seen_of_systems_by_chance() {
    let draws = short_or_long(12, 1000);
    let mut counts = [0; 3];
    for draw in 0..draws {
        let (text, low) = drawn(&mut Random::new(draw));
        let found = of_text(&text, "", (&[0.4, -0.3], &[0.5, 0.8]), 0.02);
        assert!(
            matches!(found.follows, Order::Power { .. }),
            "{draw}: {text}{found:?}"
        );
        assert_eq!(
            found.follows.number(),
            found.seen.number(),
            "{draw}: {text}{found:?}"
        );
        for (part, low) in [Part::Accelerations, Part::Displacements].into_iter().zip(low) {
            if found.of(part).is_some() {
                assert_order(&found, part, if low { 1.0 } else { 2.0 });
            }
        }
        for (count, order) in counts.iter_mut().zip([0.0, 1.0, 2.0]) {
            *count += u64::from(found.seen.number() == Some(order));
        }
    }
    println!("{draws} systems: {counts:?} of order 0, 1, 2");
    let [none, first, second] = counts;
    assert!(none == 0 && first > draws / 10 && second > draws / 10 && first + second == draws);
}
