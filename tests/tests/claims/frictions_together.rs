//! Several frictions at one contact stick together and give the motion of one friction, which is their sum.

use dsocs_core::prelude::*;
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::{Flow, System, TaylorFlow};

declared! {
    /// A mass on a spring and on a belt that swings, with the friction in three parts, whose arguments are multiples of the slip.
    struct Split { parts: [f64; 3], factors: [f64; 3] };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - 3 * x.powi(2) / 2;
    let slip = dot(x) - 0.4 * (1.3 * t).sin();
    external_forces = ((2 * t).sin() / 2 - sum(0..3, |i| parts[i] * (factors[i] * slip).signum()));
}

declared! {
    /// The three frictions with the constant factors 1, 7 and -0.3 of the slip.
    struct Constant { parts: [f64; 3] };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - 3 * x.powi(2) / 2;
    let slip = dot(x) - 0.4 * (1.3 * t).sin();
    external_forces = ((2 * t).sin() / 2 - parts[0] * slip.signum() - parts[1] * (7 * slip).signum() + parts[2] * (-0.3 * slip).signum());
}

declared! {
    /// One friction with the sum of the magnitudes.
    struct Single { dry: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - 3 * x.powi(2) / 2;
    let slip = dot(x) - 0.4 * (1.3 * t).sin();
    external_forces = ((2 * t).sin() / 2 - dry * slip.signum());
}

const UNTIL: f64 = 6.0;

/// Position and velocity at the end, by the continuous motion and by steps.
fn ends<S: System<1>>(system: &S, x: f64, v: f64) -> [[f64; 2]; 2] {
    let start = Start::second_order([x], [v]);
    let mut flow = TaylorFlow::new(system, start, Tolerance::relative(1e-10)).unwrap();
    let exact = flow.to(UNTIL).unwrap();
    let mut flow = Flow::new(system, 0.01, start).unwrap();
    let node = flow.to(UNTIL).unwrap();
    [[exact.q[0], exact.v[0]], [node.q[0], node.v[0]]]
}

#[test]
fn frictions_at_one_contact_are_one() {
    let mut random = Random::new(77);
    for draw in 0..12 {
        let parts = [0.0; 3].map(|_| random.between(0.05, 0.4));
        let factors = [0.0; 3].map(|_| random.decades(1e-3, 1e3));
        let (x, v) = (random.between(-0.6, 0.6), random.between(-1.0, 1.0));
        let single = ends(
            &Single {
                dry: parts.iter().sum(),
            },
            x,
            v,
        );
        for found in [
            ends(&Split { parts, factors }, x, v),
            ends(&Constant { parts }, x, v),
        ] {
            for (one, other) in single.as_flattened().iter().zip(found.as_flattened()) {
                assert!((one - other).abs() < 1e-8, "{draw}: {single:?} {found:?}");
            }
        }
    }
}

declared! {
    /// A blade that is drawn along by a belt that swings; its turning comes to rest by friction in the ground.
    struct DrawnBlade { grip: f64, pivot: f64 };
    coordinates(x, y, heading);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 0.2 * dot(heading).powi(2) / 2;
    let along = dot(x) * heading.cos() + dot(y) * heading.sin();
    let pull = -grip * (along - (0.5 + 0.4 * (1.3 * t).sin())).signum();
    external_forces = (pull * heading.cos(), pull * heading.sin(), -pivot * dot(heading).signum());
    nonholonomic = dot(x) * heading.sin() - dot(y) * heading.cos();
}

/// Where the turning stops nothing acts across the blade: the multiplier is rounding, and rounding decides nothing.
#[test]
fn a_blade_stops_turning_while_it_is_drawn_along() {
    let drawn = DrawnBlade {
        grip: 0.35,
        pivot: 0.05,
    };
    for spin in [0.4, 0.7, 0.97, 1.0, 1.2] {
        let start = Start::second_order([0.0; 3], [0.1, 0.0, spin]);
        let mut flow = TaylorFlow::new(&drawn, start, Tolerance::relative(1e-10)).unwrap();
        let end = flow.to(5.9).unwrap();
        let steps = Flow::new(&drawn, 0.002, start).unwrap().to(5.9).unwrap();
        // at the constant rate 0.05 / 0.2
        let heading = spin * spin / 0.5;
        assert!(
            (end.q[2] - heading).abs() < 1e-9 && end.v[2].abs() < 1e-9,
            "{spin}: {end:?}"
        );
        for (one, other) in end.q.iter().zip(&steps.q) {
            assert!((one - other).abs() < 1e-4, "{spin}: {end:?} {steps:?}");
        }
    }
}
