//! Two accelerations that the equations allow come close to each other. A Taylor flow keeps to its own at
//! every tolerance, although a long step could arrive at the other. The reference is the closed form.

use dsocs_core::prelude::*;
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::System;

declared! {
    /// The acceleration is `mean ± √(slope² (t - at)² + gap²)`.
    #[derive(Debug)]
    struct ByTime { mean: f64, slope: f64, at: f64, gap: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (ddot(x) - mean).powi(2) - (slope * (t - at)).powi(2) - gap.powi(2);
    constraint_forces = [1];
}

declared! {
    /// The same two accelerations, at a place `y` that moves uniformly instead of the time.
    #[derive(Debug)]
    struct ByPlace { mean: f64, slope: f64, at: f64, gap: f64 };
    coordinates(x, y);
    lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2;
    kinematic = (ddot(x) - mean).powi(2) - (slope * (y - at)).powi(2) - gap.powi(2);
    constraint_forces = [(1, 0)];
}

/// The first and the second integral of `√(slope² s² + gap²)`.
fn integrals(slope: f64, gap: f64, s: f64) -> [f64; 2] {
    let (u, root) = (slope * s, (slope * s).hypot(gap));
    let log = (u / gap).asinh();
    // ∫ √(u² + g²) du = (u √ + g² asinh(u/g)) / 2, and once more
    let first = f64::midpoint(u * root, gap * gap * log);
    let second = root.powi(3) / 6.0 + gap * gap / 2.0 * (u * log - root);
    [first / slope, second / (slope * slope)]
}

/// Position and velocity at the time `t` from rest, for the root with this sign.
fn expected([mean, slope, at, gap]: [f64; 4], sign: f64, t: f64) -> [f64; 2] {
    let [first, second] = [0.0, t].map(|t| integrals(slope, gap, t - at));
    let v = mean * t + sign * (second[0] - first[0]);
    let x = mean * t * t / 2.0 + sign * (second[1] - first[1] - first[0] * t);
    [x, v]
}

fn runs<S: System<N>, const N: usize>(system: &S, start: Start<N>, end: [f64; 2], tolerance: f64) -> f64 {
    let mut flow = system.series(start, Tolerance::relative(tolerance)).unwrap();
    let node = flow.to(3.0).unwrap();
    (node.q[0] - end[0]).abs().max((node.v[0] - end[1]).abs())
}

#[test]
fn a_root_is_kept_where_another_comes_close() {
    for draw in 0..300 {
        let mut random = Random::new(4200 + draw);
        let mean = random.between(-1.0, 1.0);
        let slope = random.decades(0.3, 3.0);
        let at = random.between(0.4, 2.5);
        let gap = random.decades(3e-5, 0.3);
        let sign = if random.chance(0.5) { 1.0 } else { -1.0 };
        let tolerance = random.decades(1e-12, 3e-4);
        let a0 = mean + sign * (slope * at).hypot(gap);
        let end = expected([mean, slope, at, gap], sign, 3.0);
        let by_time = ByTime { mean, slope, at, gap };
        let start = Start::second_order([0.0], [0.0]).near_acceleration([a0]);
        let first = runs(&by_time, start, end, tolerance);
        let by_place = ByPlace { mean, slope, at, gap };
        let start = Start::second_order([0.0, 0.0], [0.0, 1.0]).near_acceleration([a0, 0.0]);
        let second = runs(&by_place, start, end, tolerance);
        // the tolerance is relative to the velocity; the bend of the acceleration is seen by its effect. The
        // other root ends about 1 away
        let allowed = 1000.0 * tolerance * end[1].abs().max(1.0) + 1e-10;
        assert!(
            first < allowed && second < allowed,
            "{draw}: {by_time:?} {sign} {tolerance:e}: {first:e} {second:e}"
        );
    }
}

declared! {
    /// Two roots that are functions of time and cross: each is continued.
    #[derive(Debug)]
    struct Cross { rate: f64, slope: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (ddot(x) - (rate * t).cos()) * (ddot(x) - slope * t);
    constraint_forces = [1];
}

#[test]
fn roots_that_cross_go_straight_on() {
    for draw in 0..60 {
        let mut random = Random::new(4800 + draw);
        let rate = random.between(0.5, 2.0);
        let slope = random.between(0.2, 1.5);
        let tolerance = random.decades(1e-10, 1e-4);
        let law = Cross { rate, slope };
        let start = Start::second_order([0.0], [0.0]).near_acceleration([1.0]);
        let end = [
            (1.0 - (3.0 * rate).cos()) / (rate * rate),
            (3.0 * rate).sin() / rate,
        ];
        let error = runs(&law, start, end, tolerance);
        assert!(
            error < 300.0 * tolerance + 1e-7,
            "{draw}: {law:?} {tolerance:e}: {error:e}"
        );
    }
}
