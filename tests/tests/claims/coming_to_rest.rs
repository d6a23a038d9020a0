//! A Taylor flow follows damped motions to rest in a bounded number of steps, at every tolerance: finally the
//! mass moves by less than a rounding of its position.

use dsocs_core::prelude::*;
use dsocs_core::text::Text;
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::short_or_long;
use dsocs_tests::text::{System, TaylorFlow};

declared! {
    /// Two masses on springs, one of which bends the other.
    #[derive(Debug)]
    struct Springs { k: f64, c: f64, at: f64, bend: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - k / 2 * (x - at).powi(2) - (y - bend * x.sin()).powi(2) / 2;
    external_forces = (-c * dot(x), -c * dot(y));
}

declared! {
    /// A pendulum at the end of a cart that a spring holds.
    #[derive(Debug)]
    struct Cart { k: f64, c: f64, at: f64, length: f64 };
    coordinates(s, theta);
    let x = s + length * theta.sin();
    let y = -length * theta.cos();
    lagrangian = dot(s).powi(2) / 2 + (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y - k / 2 * (s - at).powi(2);
    external_forces = (-c * dot(s), -c * dot(theta));
}

declared! {
    /// A law that is not affine in the acceleration.
    #[derive(Debug)]
    struct Law { k: f64, c: f64, at: f64, cubic: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + cubic * ddot(x).powi(3) + c * dot(x) + k * (x - at).sin();
    constraint_forces = [1];
}

declared! {
    /// A bead on a wire, in the plane.
    #[derive(Debug)]
    struct Bead { k: f64, c: f64, at: f64, bend: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y - k / 2 * (x - at).powi(2);
    external_forces = (-c * dot(x), -c * dot(y));
    holonomic = y - bend * x.powi(2);
}

/// The number of steps to the time 120, and the largest velocity component there.
fn comes_to_rest<S: System<N>, const N: usize>(system: &S, q0: [f64; N], tolerance: f64) -> (u64, f64) {
    let start = Start::second_order(q0, [0.0; N]);
    let mut flow = TaylorFlow::new(system, start, Tolerance::relative(tolerance)).unwrap();
    let end = flow.to(120.0).unwrap();
    let fastest = end.v.iter().fold(0.0_f64, |fastest, v| fastest.max(v.abs()));
    (flow.steps(), fastest)
}

#[test]
fn rest_is_reached_in_some_steps_at_every_tolerance() {
    let mut most = 0;
    for draw in 0..short_or_long(10, 40) {
        let mut random = Random::new(9100 + draw);
        let k = random.between(0.5, 5.0);
        let c = random.between(0.3, 3.0);
        let at = random.between(-1.5, 1.5);
        let other = random.between(0.2, 1.0);
        for tolerance in [1e-4, 1e-8, 1e-11, 1e-14] {
            let (bend, length, cubic) = (other, other, 0.1 * other);
            let found = [
                comes_to_rest(&Springs { k, c, at, bend }, [0.4, 0.1], tolerance),
                comes_to_rest(&Cart { k, c, at, length }, [0.4, 0.7], tolerance),
                comes_to_rest(&Law { k, c, at, cubic }, [at + 0.7], tolerance),
                comes_to_rest(&Bead { k, c, at, bend }, [0.5, bend * 0.25], tolerance),
            ];
            for (scene, (steps, fastest)) in found.into_iter().enumerate() {
                most = most.max(steps);
                assert!(
                    steps < 10_000 && fastest < 1e-4,
                    "{draw}, {scene}: k = {k}, c = {c}, at = {at}, {other}, {tolerance:e}: {steps} steps, velocity {fastest:e}"
                );
            }
        }
    }
    println!("at most {most} steps");
}

declared! {
    /// A damped mass at a large position, which enters no force.
    #[derive(Debug)]
    struct Far;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -dot(x) * (2 + t.sin());
}

/// Rounding of a position that enters no force does not relax the tolerance of the velocity.
#[test]
fn a_velocity_is_as_accurate_far_away() {
    let start = Start::second_order([1e9], [1.0]);
    let mut flow = TaylorFlow::new(&Far, start, Tolerance::relative(1e-12)).unwrap();
    let end = flow.to(15.0).unwrap();
    let expected = (-2.0 * 15.0 - (1.0 - 15.0_f64.cos())).exp();
    assert!(
        (end.v[0] / expected - 1.0).abs() < 1e-10,
        "{} {expected}",
        end.v[0]
    );
}

/// Forces on a mass at rest, by `u = (t - at) / width`: far from `at` they are rounding, or underflow.
const FORCES: [&str; 6] = [
    "(1 + u.tanh()) / 2",
    "(-u.powi(2)).exp() / width",
    "(-u.powi(8)).exp() / width",
    "(t - at).max(0).powf(1.5)",
    "two.powf(-u.powi(2)) / width",
    "(t - at).max(0).sqrt()",
];

/// The exact velocity at the time 2.
fn exact_velocity(at: f64, width: f64, kind: usize) -> f64 {
    let over = 2.0 - at;
    match kind {
        // ∫ (1 + tanh u) / 2 = width ln(1 + exp 2u) / 2
        0 => {
            let from = 0.5 * width * (-2.0 * at / width).exp().ln_1p();
            over + 0.5 * width * (-2.0 * over / width).exp().ln_1p() - from
        }
        1 => core::f64::consts::PI.sqrt(),
        // 2 Γ(9/8)
        2 => 1.883_485_399_7,
        3 => over.powf(2.5) / 2.5,
        4 => (core::f64::consts::PI / core::f64::consts::LN_2).sqrt(),
        _ => over.powf(1.5) / 1.5,
    }
}

/// A mass that waits at rest is pushed by each of the six forces, with a random time and width: its velocity
/// at t = 2 is the closed form to 300 tolerances, after less than 5000 steps, at tolerances from 1e-4 to
/// 1e-12.
#[test]
fn what_waits_at_rest_is_pushed_at_every_tolerance() {
    for draw in 0..short_or_long(15, 60) {
        let mut random = Random::new(9300 + draw);
        let at = random.between(0.5, 1.5);
        let width = random.decades(1e-4, 3e-2);
        for (kind, force) in FORCES.into_iter().enumerate() {
            let text = format!(
                "parameters {{ at = {at:?}, width = {width:?}, two = 2.0 }}
                 coordinates(x);
                 lagrangian = dot(x).powi(2) / 2;
                 let u = (t - at) / width;
                 external_forces = {force};"
            );
            let system = Text::parse("waits", &text).unwrap().system;
            let expected = exact_velocity(at, width, kind);
            for tolerance in [1e-4, 1e-6, 1e-9, 1e-12] {
                let start = Start::second_order([0.0], [0.0]);
                let mut flow = TaylorFlow::read(&system, start, Tolerance::relative(tolerance)).unwrap();
                let end = flow
                    .to(2.0)
                    .unwrap_or_else(|error| panic!("{force}, {at}, {width}, {tolerance:e}: {error}"));
                let error = (end.v[0] - expected).abs();
                assert!(
                    error < 300.0 * tolerance + 1e-10 && flow.steps() < 5000,
                    "{force}, {at}, {width}, {tolerance:e}: {} for {expected}, {} steps",
                    end.v[0],
                    flow.steps()
                );
            }
        }
    }
}
