//! Random smooth scenes, from rest and in motion, give no warning: no unresolved step, and no singularity
//! nearby.

use dsocs_core::{Composition, Start, Stepper};
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::short_or_long;
use dsocs_tests::text::{ComposedFlow, Flow, System};

declared! {
    /// Three coupled coordinates under smooth forces, some of which grow from zero, and with pieces that no
    /// motion reaches.
    struct Scene {
        mass: [f64; 3],
        coupling: f64,
        spring: [f64; 3],
        quartic: [f64; 3],
        torque: [f64; 3],
        drag: [f64; 3],
        bend: [f64; 9],
        square: [f64; 9],
        cube: [f64; 9],
        beat: [f64; 9],
        rate: f64,
    }
    coordinates(q: [3]);
    let kinetic = sum(0..3, |i| mass[i] / 2 * dot(q[i]).powi(2)) + coupling * dot(q[0]) * dot(q[1]) * (q[0] - q[2]).cos();
    let potential = sum(0..3, |i| spring[i] / 2 * q[i].powi(2) + quartic[i] * q[i].powi(4));
    lagrangian = kinetic - potential;
    phi_lagrangian = midpoint;
    external_forces = (|i| torque[i] - drag[i] * dot(q[i]) + sum(0..3, |j| {
        bend[3 * i + j] * q[j].sin() + square[3 * i + j] * q[j].powi(2) + cube[3 * i + j] * dot(q[j]).powi(3)
            + beat[3 * i + j] * (rate * t).sin() * q[j].cos()
    }));
}

declared! {
    /// Two uncoupled coordinates with the paper's maps; the stop is far away.
    struct Driven {
        spring: f64,
        bend: f64,
        square: f64,
        cube: f64,
        drag: f64,
        torque: f64,
        spin: f64,
    }
    coordinates(x, phi);
    let far = if x > 1e3 { 1 } else { 0 };
    lagrangian = dot(x).powi(2) / 2 + dot(phi).powi(2) / 2 - spring / 2 * x.powi(2) - far * (x - 1e3).powi(2);
    external_forces = (-bend * phi.sin() + square * phi.powi(2) + cube * phi.powi(3) - drag * dot(x), torque - spin * (dot(phi) + 1e3).abs());
}

/// Zero with probability 1/2, else a number up to `size`.
fn some(random: &mut Random, size: f64) -> f64 {
    if random.chance(0.5) {
        0.0
    } else {
        random.between(-size, size)
    }
}

fn many<const N: usize>(random: &mut Random, size: f64) -> [f64; N] {
    core::array::from_fn(|_| some(random, size))
}

fn is_silent<S: System<N>, const N: usize>(system: &S, start: Start<N>, h: f64) {
    let mut flow = Flow::new(system, h, start).unwrap();
    let ran = flow.to(1.0);
    assert!(ran.is_ok(), "{}", ran.unwrap_err());
    assert_eq!(flow.unresolved(), None, "h {h}: {:?}", flow.node());
    assert_eq!(flow.nearly_singular(), None, "h {h}");
    // with twice the step
    let mut flow = ComposedFlow::new(system, 2.0 * h, Composition::SUZUKI_4, start).unwrap();
    flow.to(1.0).unwrap();
    assert_eq!(flow.unresolved(), None, "composed, h {h}");
    assert_eq!(flow.nearly_singular(), None, "composed, h {h}");
}

fn scenes(seeds: core::ops::Range<u64>) {
    for seed in seeds {
        let random = &mut Random::new(seed);
        let scene = Scene {
            mass: core::array::from_fn(|_| random.between(0.5, 2.0)),
            coupling: some(random, 0.3),
            spring: core::array::from_fn(|_| random.between(0.0, 4.0)),
            quartic: core::array::from_fn(|_| random.between(0.0, 1.0)),
            torque: many(random, 1.0),
            drag: core::array::from_fn(|_| random.between(0.0, 1.0)),
            bend: many(random, 1.0),
            square: many(random, 0.3),
            cube: core::array::from_fn(|place| {
                if place % 4 == 0 {
                    -random.between(0.0, 0.3)
                } else {
                    // the cube of a velocity through zero has a triple zero there
                    some(random, 0.1)
                }
            }),
            beat: many(random, 1.0),
            rate: random.between(0.1, 5.0),
        };
        let driven = Driven {
            spring: random.between(0.0, 4.0).max(1e-3),
            bend: random.between(-2.0, 2.0),
            square: some(random, 1.0),
            cube: some(random, 1.0),
            drag: random.between(0.0, 1.0),
            torque: random.between(-2.0, 2.0),
            spin: random.decades(1e-6, 1e-4),
        };
        let h = random.decades(1e-3, 0.05);
        for is_moving in [false, true] {
            let mut v = || if is_moving { random.between(-1.0, 1.0) } else { 0.0 };
            let (three, two) = ([v(), v(), v()], [v(), v()]);
            let q = many(random, 1.0);
            is_silent(&scene, Start::second_order(q, three), h);
            let q = many(random, 1.0);
            is_silent(&driven, Start::second_order(q, two), h);
        }
    }
}

#[test]
fn smooth_scenes_are_not_warned_of() {
    scenes(0..short_or_long(15, 500));
}

/// A force that grows from zero with a power of the time gives no warning.
#[test]
fn a_force_that_grows_from_nothing_is_not_warned_of() {
    for [bend, square, cube] in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        let driven = Driven {
            spring: 0.0,
            bend,
            square,
            cube,
            drag: 0.0,
            torque: 1.0,
            spin: 0.0,
        };
        for h in [0.1, 0.01, 0.001] {
            is_silent(&driven, Start::second_order([0.0; 2], [0.0; 2]), h);
        }
    }
}
