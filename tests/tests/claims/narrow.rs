//! A Taylor flow does not step over a narrow push, well or wall far from the expansion point of its series.

use core::f64::consts::PI;

use dsocs_core::text::Text;
use dsocs_core::{Start, Stepper, Tolerance};
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::TaylorFlow;
use dsocs_tests::{declared, short_or_long};
use proptest::prelude::*;

use super::draws;
use dsocs_tests::dop853::integrate_from;

/// A function as text of a declaration, and its value.
type Shape = (&'static str, fn(f64) -> f64);

/// Functions of `u` that are small except near zero, or near several places.
const SHAPES: [Shape; 11] = [
    ("(-u.powi(2)).exp()", |u| (-u * u).exp()),
    ("(-u.powi(4)).exp()", |u| (-u.powi(4)).exp()),
    ("1 / u.min(300.0).max(-300.0).cosh().powi(2)", |u| {
        u.clamp(-300.0, 300.0).cosh().powi(-2)
    }),
    ("1 / (1 + u.powi(8))", |u| 1.0 / (1.0 + u.powi(8))),
    ("(1 + u.powi(2)).powi(-5)", |u| (1.0 + u * u).powi(-5)),
    ("(1 + u.powi(2)).powf(-4.5)", |u| (1.0 + u * u).powf(-4.5)),
    ("(1 - u.tanh()) * (1 + u.tanh())", |u| u.cosh().powi(-2)),
    // for a high power, the base shows where it is large
    ("(u / 5).sin().powi(16)", |u| (u / 5.0).sin().powi(16)),
    ("(u / 20).cos().powi(400)", |u| (u / 20.0).cos().powi(400)),
    ("(u / 63).cos().powi(4000)", |u| (u / 63.0).cos().powi(4000)),
    ("((1.2 + (u / 5).cos()) / 2.2).powf(60.0)", |u| {
        ((1.2 + (u / 5.0).cos()) / 2.2).powf(60.0)
    }),
];

/// The first function that is large at several places.
const FIRST_OF_MANY: usize = 7;

/// The end of the motion of an oscillator of stiffness `k`, with such a force, narrow in space or in time: by
/// DOP853.
fn reference_end(shape: Shape, [height, at, width, k]: [f64; 4], is_in_time: bool) -> [f64; 2] {
    let rate = |t: f64, [x, v]: [f64; 2]| {
        let u = (if is_in_time { t } else { x } - at) / width;
        [v, -k * x + height * (shape.1)(u)]
    };
    // the solver is stopped so often that none of its steps leads over the narrow place
    let (mut state, spans) = ([0.0, 1.0], 2000_u32);
    let at = |place: u32| 5.0 * f64::from(place) / f64::from(spans);
    for span in 0..spans {
        state = integrate_from(rate, (at(span), state), at(span + 1), 1e-13);
    }
    state
}

fn by_series(shape: Shape, [height, at, width, k]: [f64; 4], is_in_time: bool, tolerance: f64) -> [f64; 2] {
    let of = if is_in_time { "t" } else { "x" };
    let text = format!(
        "coordinates(x);
         lagrangian = dot(x).powi(2) / 2 - {k:?} * x.powi(2) / 2;
         let u = ({of} - {at:?}) / {width:?};
         external_forces = ({height:?} * ({}));",
        shape.0
    );
    let text = Text::parse("narrow", &text).unwrap();
    let start = Start::second_order([0.0], [1.0]);
    let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
    flow.to(5.0).unwrap();
    let node = flow.node();
    [node.q[0], node.v[0]]
}

/// 100 random scenes: an oscillator under one of 11 narrow functions of width 1e-3 to 0.3, in time or in
/// space. Position and velocity at the end are those of DOP853 to 300 tolerances, at 1e-6, 1e-9 and 1e-12.
#[test]
fn what_is_narrow_is_met_whatever_the_tolerance() {
    let draws = (0..SHAPES.len(), any::<bool>(), -3.0..-0.5, 0.3..1.0, 0.0..1.0);
    draws::test(100, 28, draws, &|(shape, is_in_time, log_width, at, k)| {
        let width = 10.0_f64.powf(log_width);
        let (at, k) = if is_in_time { (4.0 * at, k) } else { (at, 0.2 * k) };
        // a push of about the momentum 1/5, or a place that changes the energy by about a tenth for a while
        let scene = [if is_in_time { 0.1 / width } else { -0.03 / width }, at, width, k];
        let reference = reference_end(SHAPES[shape], scene, is_in_time);
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let found = by_series(SHAPES[shape], scene, is_in_time, tolerance);
            let error = (found[0] - reference[0])
                .abs()
                .max((found[1] - reference[1]).abs());
            // repeated pushes add up, and may bring the mass nearly to rest in between
            let size = if shape < FIRST_OF_MANY {
                1.0
            } else {
                10.0 * reference[0].hypot(reference[1]).powi(2).max(1.0)
            };
            prop_assert!(
                error < 300.0 * tolerance.max(1e-11) * size,
                "{} in {}, {scene:?}, {tolerance}: {found:?} {reference:?}",
                SHAPES[shape].0,
                if is_in_time { "time" } else { "space" },
            );
        }
        Ok(())
    });
}

#[test]
fn no_wall_is_tunnelled() {
    // from afar against the wall of the Lennard-Jones potential, and back at the same speed
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 4 * (x.powi(-12) - x.powi(-6));";
    let text = Text::parse("wall", text).unwrap();
    let start = Start::second_order([100.0], [-1.0]);
    for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
        let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
        flow.to(200.0).unwrap();
        let node = flow.node();
        let (q, v) = (node.q[0], node.v[0]);
        assert!(
            q > 0.0 && (v - 1.0).abs() < 100.0 * tolerance,
            "{tolerance}: {q} {v}"
        );
    }
}

#[test]
fn a_sphere_meets_the_floor_as_hertz_says_and_leaves_it() {
    // no energy is lost; the time of contact is 2.94 of depth over speed
    let text = "coordinates(z);
        lagrangian = dot(z).powi(2) / 2 - 9.81 * z - 1e6 / 2.5 * (-z).max(0.0).powf(2.5);";
    let text = Text::parse("sphere", text).unwrap();
    let start = Start::second_order([0.3], [0.0]);
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
        flow.to(3.0).unwrap();
        let energy = flow.node().energy;
        assert!(
            (energy / 2.943 - 1.0).abs() < 100.0 * tolerance.max(1e-11),
            "{tolerance}: {energy}"
        );
    }
}

/// Hills of the height 1 at `u = 0`, with exponents that are no integers and such that are.
const HILLS: [&str; 16] = [
    "1 / (1 + u.powi(2))",
    "1 / (0.25 + (u / 2).powi(2)) / 4",
    "1 / (1 + u.powi(2)).sqrt().powi(3)",
    "(1 + u.powi(2)).powf(-1.5)",
    "(1 + u.powi(2)).powf(-2.25)",
    "(1 + u.powi(2)).powf(-2.5)",
    "(1 + u.powi(2)).powf(-3.7)",
    "1 / (1 + u.powi(2)).powf(6.5)",
    "1 / (1 + u.powi(2)).sqrt().powi(5)",
    "1 / ((1 + u.powi(2)).powi(4) * (1 + u.powi(2)).sqrt())",
    "(1 + u.powi(4)).powf(-1.5)",
    "1 / (1 + u.powi(2)).powi(6)",
    "1 / (1 + u.powi(8))",
    "1 / u.min(40.0).max(-40.0).cosh().powi(6)",
    "(1 - u.powi(2)).max(0.0).powf(3.5)",
    "(1 - u.powi(2)).max(0.0).powf(2.5)",
];

/// A bead turns back at each of 16 hills that are higher than its energy, and passes lower ones, for six
/// widths from 3e-5 to 0.3 and tolerances from 1e-4 to 1e-12.
#[test]
fn no_hill_is_tunnelled_whatever_its_exponent() {
    for (hill, width) in HILLS
        .iter()
        .flat_map(|hill| [0.3, 0.05, 1e-2, 1e-3, 1e-4, 3e-5].map(|width| (hill, width)))
    {
        // a bead turns back at a hill that is higher than its energy, and passes one that is not
        for (height, v, loosest) in [(1.0, -1.0, 1e-4), (0.3, 1.0, 1e-6)] {
            let text = format!(
                "coordinates(x);
                 let u = x / {width:?};
                 lagrangian = dot(x).powi(2) / 2 - {height:?} * {hill};"
            );
            let text = Text::parse("hill", &text).unwrap();
            let tolerances = [1e-4, 1e-6, 1e-9, 1e-12].into_iter();
            for tolerance in tolerances.filter(|tolerance| *tolerance <= loosest) {
                let start = Start::second_order([-2.0], [1.0]);
                let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
                let first = flow.node().energy;
                flow.to(6.0).unwrap();
                let node = flow.node();
                // far from the hill, whose value there is small
                let rest = if width > 0.1 { 0.03 } else { 1e-3 };
                assert!(
                    (node.v[0] - v).abs() < rest && node.q[0] * v > 1.0,
                    "{hill}, {width}, height {height}, {tolerance}: {} {}",
                    node.q[0],
                    node.v[0]
                );
                let error = node.energy - first;
                assert!(
                    error.abs() < 1000.0 * tolerance,
                    "{hill}, {width}, height {height}, {tolerance}: {error}"
                );
            }
        }
    }
}

#[test]
fn no_pulse_is_missed_however_slowly_it_decays() {
    // ∫ (1 + u²)⁻ᵖ du over all u
    for (p, integral) in [
        (1.0_f64, PI),
        (1.5, 2.0),
        (2.5, 4.0 / 3.0),
        (3.5, 16.0 / 15.0),
        (4.5, 32.0 / 35.0),
        (5.5, 256.0 / 315.0),
    ] {
        for width in [1e-2_f64, 1e-3, 1e-4, 1e-5, 1e-6] {
            let text = format!(
                "coordinates(x);
                 lagrangian = dot(x).powi(2) / 2;
                 external_forces = {:?} / (1 + ((t - 5) / {width:?}).powi(2)).powf({p:?});",
                0.1 / width
            );
            let text = Text::parse("pulse", &text).unwrap();
            for tolerance in [1e-4, 1e-6, 1e-9, 1e-12] {
                let start = Start::second_order([0.0], [0.1]);
                let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
                flow.to(10.0).unwrap();
                let v = flow.node().v[0];
                // both tails are cut off
                let tails = (5.0 / width).powf(1.0 - 2.0 * p);
                assert!(
                    (v - 0.1 - 0.1 * integral).abs() < 30.0 * tolerance.max(1e-11) + tails,
                    "{p} {width} {tolerance}: {v}"
                );
            }
        }
    }
}

/// Bumps that are zero outside of `|u| < 1`, in many notations, and their integrals.
const BUMPS: [(&str, f64); 10] = [
    (
        "(if u > -1 && u < 1 { 1 - u * u } else { 0 }).powf(1.5)",
        0.375 * PI,
    ),
    ("(1 - u * u).max(0).powf(1.5)", 0.375 * PI),
    ("(1 - u * u).max(0).sqrt().powi(3)", 0.375 * PI),
    ("(1 - u * u).max(0) * (1 - u * u).max(0).sqrt()", 0.375 * PI),
    (
        "(if u.abs() < 1 { (1 - u * u) * (1 - u * u).abs().sqrt() } else { 0 })",
        0.375 * PI,
    ),
    ("((1 - u * u + (1 - u * u).abs()) / 2).powf(1.5)", 0.375 * PI),
    (
        "(if u > -1 && u < 1 { (1 - u).powf(1.5) * (1 + u).powf(1.5) } else { 0 })",
        0.375 * PI,
    ),
    ("(1 - u.abs()).max(0).powf(1.5)", 0.8),
    ("(1 - u * u).max(0).cbrt().powi(4)", 1.223_722_564_647_669_5),
    ("(1 - u * u).max(0).powf(2.5)", 0.312_5 * PI),
];

#[test]
fn a_bump_that_begins_and_ends_is_passed_however_it_is_written() {
    let end = |text: &str, v: f64, tolerance: f64| {
        let text = Text::parse("bump", text).unwrap();
        let start = Start::second_order([0.0], [v]);
        let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
        flow.to(3.0).unwrap_or_else(|error| panic!("{error}"));
        flow.node().v[0]
    };
    for ((bump, integral), k) in BUMPS
        .iter()
        .flat_map(|bump| [1.0, 10.0, 100.0, 1000.0].map(|k| (bump, k)))
    {
        for place in [1.5, 1.25, 1.333_014_999_763_821_1] {
            for tolerance in [1e-4, 1e-6, 1e-9, 1e-12] {
                // a blow in time, and a hill
                let blow = format!(
                    "coordinates(x); let u = {k:?} * (t - {place:?}); lagrangian = dot(x).powi(2) / 2;
                     external_forces = 0.1 * {k:?} * {bump};"
                );
                let hill = format!(
                    "coordinates(x); let u = {k:?} * (x - {place:?}); lagrangian = dot(x).powi(2) / 2 - 0.2 * {bump};"
                );
                for (text, v, expected) in [(&blow, 0.1, 0.1 + 0.1 * integral), (&hill, 1.1, 1.1)] {
                    let found = end(text, v, tolerance);
                    assert!(
                        (found - expected).abs() < 100.0 * tolerance.max(1e-11),
                        "{text}, {tolerance}: {found} {expected}"
                    );
                }
            }
        }
    }
}

declared! {
    /// A force that is a difference of two steep signs, of which one is later: it acts while one has changed and the other has not.
    #[derive(Debug)]
    struct Pulse { push: f64, at: f64, delay: f64, width: f64 };
    coordinates(x);
    lagrangian = (dot(x).powi(2) - x.powi(2)) / 2;
    let first = x - at;
    let second = x - at - delay * dot(x);
    external_forces = push * (first / (first.powi(2) + width).sqrt() - second / (second.powi(2) + width).sqrt());
}

#[test]
fn no_difference_of_steep_signs_is_missed() {
    for draw in 0..short_or_long(6, 60) {
        let mut random = Random::new(13_100 + draw);
        let law = Pulse {
            push: random.between(20.0, 200.0),
            at: random.between(0.2, 0.7),
            delay: random.between(1e-3, 4e-3),
            width: random.decades(1e-9, 1e-7),
        };
        let sign = |u: f64| u / (u * u + law.width).sqrt();
        let rate = |_: f64, [x, v]: [f64; 2]| {
            let first = x - law.at;
            [v, -x + law.push * (sign(first) - sign(first - law.delay * v))]
        };
        let (mut state, spans) = ([0.0, 1.2], 4000_u32);
        let at = |place: u32| 2.0 * f64::from(place) / f64::from(spans);
        for span in 0..spans {
            state = integrate_from(rate, (at(span), state), at(span + 1), 1e-12);
        }
        for tolerance in [1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-11] {
            let start = Start::second_order([0.0], [1.2]);
            let mut flow = TaylorFlow::new(&law, start, Tolerance::relative(tolerance)).unwrap();
            let node = flow.to(2.0).unwrap();
            let apart = (node.q[0] - state[0]).abs();
            assert!(
                apart < 100.0 * tolerance + 1e-9,
                "{draw} {law:?} {tolerance} {apart}"
            );
        }
    }
}
