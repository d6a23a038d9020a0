//! Random scenes: trees of bodies on rods, linkages, trains on wheels, and robots with a motor in one joint.
//! Each is declared with arrays, whose parameters make the topology. The reference is a second formulation in
//! twice the precision, which shares no code with the attribute or the solver ([`dsocs_tests::scenes`]).

use dsocs_core::{Start, Stepper as _, System, dsocs};
use dsocs_tests::declared;
use dsocs_tests::scenes::compare::{Comparison, compare};
use dsocs_tests::scenes::random::{Case, Random, linkage, robot, train, tree};
use dsocs_tests::scenes::scene::{Law, Map, Scene, Spring};
use dsocs_tests::short_or_long;
use dsocs_tests::text;

/// The number of steps of each scene.
const STEPS: usize = 100;

macro_rules! trees {
    ($(#[$meta:meta])* $name:ident; $n:literal, $squared:literal; { $($motor:tt)* } { $($field:ident: $type:ty = $value:expr),* }) => {
        $(#[$meta])*
        #[dsocs {
            coordinates(theta: [$n]);
            let together = |i, j| sum(0..$n, |k| masses[k] * paths[k * $n + i] * paths[k * $n + j]);
            let cosine = |i, j| theta[i].cos() * theta[j].cos() + theta[i].sin() * theta[j].sin();
            let speed = |i| lengths[i] * dot(theta[i]);
            let kinetic = sum(0..$n, |i| {
                together(i, i) * speed(i).powi(2) / 2 + inertias[i] * dot(theta[i]).powi(2) / 2
                    + sum(0..i, |j| together(i, j) * cosine(i, j) * speed(i) * speed(j))
            });
            let hangs = |i| sum(0..$n, |k| masses[k] * paths[k * $n + i]);
            let potential = sum(0..$n, |i| {
                ties[i * $n + i] / 2 * (theta[i] - rests[i * $n + i]).powi(2)
                    + sum(0..i, |j| ties[i * $n + j] / 2 * (theta[i] - theta[j] - rests[i * $n + j]).powi(2))
                    - gravity * hangs(i) * lengths[i] * theta[i].cos()
            });
            lagrangian = kinetic - potential;
            phi_lagrangian = midpoint;
            $($motor)*
        }]
        struct $name {
            masses: [f64; $n],
            lengths: [f64; $n],
            inertias: [f64; $n],
            paths: [f64; $squared],
            ties: [f64; $squared],
            rests: [f64; $squared],
            gravity: f64,
            $($field: $type),*
        }

        impl $name {
            fn new(scene: &Scene) -> Self {
                let mut inertias = [0.0; $n];
                for &(coordinate, inertia) in &scene.inertias {
                    inertias[coordinate] += inertia;
                }
                let (mut ties, mut rests) = ([0.0; $squared], [0.0; $squared]);
                for spring in &scene.springs {
                    let Spring::Twist { ends: (one, other), stiffness, rest } = *spring else {
                        panic!("no angle: {spring:?}");
                    };
                    let place = one * $n + other.unwrap_or(one);
                    (ties[place], rests[place]) = (stiffness, rest);
                }
                $(let $field = $value(scene);)*
                Self {
                    masses: core::array::from_fn(|i| scene.bodies[i].mass),
                    lengths: core::array::from_fn(|i| scene.bodies[i].rod.unwrap().1),
                    inertias,
                    paths: scene.paths(0..$n).try_into().unwrap(),
                    ties,
                    rests,
                    gravity: scene.gravity,
                    $($field),*
                }
            }
        }
    };
}

/// The joint of a motor: 1 and -1 at its two angles.
fn joint<const N: usize>(scene: &Scene) -> [f64; N] {
    let (one, other) = scene.motor.unwrap().joint;
    core::array::from_fn(|i| f64::from(u8::from(i == one)) - f64::from(u8::from(Some(i) == other)))
}

/// The rate, the damping and the target of a servo.
fn servo(scene: &Scene) -> [f64; 3] {
    match scene.motor.unwrap().law {
        Law::Servo {
            rate,
            damping,
            target,
        } => [rate, damping, target],
        Law::Lyapunov { .. } => panic!("no servo"),
    }
}

/// The coefficient of a Lyapunov constraint.
fn rho(scene: &Scene) -> f64 {
    match scene.motor.unwrap().law {
        Law::Lyapunov { rho } => rho,
        Law::Servo { .. } => panic!("a servo"),
    }
}

trees! {
    /// Four bodies, each on a rod that hangs on an earlier one or on the ground.
    Tree; 4, 16; {} {}
}

trees! {
    /// Three bodies and a servo between the first two.
    Servo; 3, 9; {
        let angle = theta[1] - theta[0];
        kinematic = ddot(angle) + 2 * law[1] * law[0] * dot(angle) + law[0].powi(2) * (angle - law[2]);
        constraint_forces = [(-1, 1, 0)];
    } { law: [f64; 3] = servo }
}

trees! {
    /// Three bodies and a motor between the first two for which the energy is a Lyapunov function.
    Brake; 3, 9; {
        let angle = theta[1] - theta[0];
        kinematic = dot(kinetic + potential) + rho * dot(angle).powi(2);
        constraint_forces = [(-1, 1, 0)];
    } { rho: f64 = rho }
}

trees! {
    /// A servo whose joint is made of parameters.
    AnyServo; 3, 9; {
        let angle = sum(0..3, |i| motor[i] * theta[i]);
        kinematic = ddot(angle) + 2 * law[1] * law[0] * dot(angle) + law[0].powi(2) * (angle - law[2]);
        constraint_forces = [(|i| motor[i])];
    } { motor: [f64; 3] = joint, law: [f64; 3] = servo }
}

trees! {
    /// Four bodies and a servo between the ground and the first.
    Whip; 4, 16; {
        kinematic = ddot(theta[0]) + 2 * law[1] * law[0] * dot(theta[0]) + law[0].powi(2) * (theta[0] - law[2]);
        constraint_forces = [(1, 0, 0, 0)];
    } { law: [f64; 3] = servo }
}

/// Three points with two rods and a spring.
#[dsocs {
    coordinates(x: [3], y: [3]);
    let along = |k| sum(0..3, |j| ends[k * 3 + j] * x[j]);
    let across = |k| sum(0..3, |j| ends[k * 3 + j] * y[j]);
    let square = |k| along(k).powi(2) + across(k).powi(2);
    lagrangian = sum(0..3, |i| masses[i] * ((dot(x[i]).powi(2) + dot(y[i]).powi(2)) / 2 - gravity * y[i]))
        - stiffness / 2 * (square(2).sqrt() - rest).powi(2);
    holonomic = [(square(0) - lengths[0].powi(2)) / 2, (square(1) - lengths[1].powi(2)) / 2];
}]
struct Linkage {
    masses: [f64; 3],
    ends: [f64; 9],
    lengths: [f64; 2],
    stiffness: f64,
    rest: f64,
    gravity: f64,
}

impl Linkage {
    fn new(scene: &Scene) -> Self {
        let mut ends = [0.0; 9];
        let mut put = |row: usize, (one, other): (usize, Option<usize>)| {
            ends[row * 3 + one] = 1.0;
            if let Some(other) = other {
                ends[row * 3 + other] = -1.0;
            }
        };
        for (row, rod) in scene.rods.iter().enumerate() {
            put(row, rod.ends);
        }
        let (mut stiffness, mut rest) = (0.0, 0.0);
        match scene.springs.as_slice() {
            // a spring without stiffness, from the origin
            [] => put(2, (0, None)),
            [
                Spring::Line {
                    ends,
                    stiffness: own,
                    rest: length,
                },
            ] => {
                put(2, *ends);
                (stiffness, rest) = (*own, *length);
            }
            other => panic!("{other:?}"),
        }
        Self {
            masses: core::array::from_fn(|i| scene.bodies[i].mass),
            ends,
            lengths: core::array::from_fn(|i| scene.rods[i].length),
            stiffness,
            rest,
            gravity: scene.gravity,
        }
    }
}

/// A lead whose wheel rolls, and two trailers, one behind the other.
#[dsocs {
    coordinates(x, y, theta: [3], roll);
    let along = |i| dot(x) + sum(1..=i, |j| lengths[j] * dot(theta[j]) * theta[j].cos());
    let across = |i| dot(y) + sum(1..=i, |j| lengths[j] * dot(theta[j]) * theta[j].sin());
    let height = |i| y - sum(1..=i, |j| lengths[j] * theta[j].cos());
    lagrangian = sum(0..3, |i| masses[i] * ((along(i).powi(2) + across(i).powi(2)) / 2 - gravity * height(i)))
        + sum(0..3, |i| inertias[i] * dot(theta[i]).powi(2) / 2) + inertias[3] * dot(roll).powi(2) / 2
        - sum(1..3, |i| sum(0..i, |j| ties[i * 3 + j] / 2 * (theta[i] - theta[j] - rests[i * 3 + j]).powi(2)));
    let slip = |i| theta[i].cos() * along(i) + theta[i].sin() * across(i);
    nonholonomic = [
        slip(0),
        theta[0].sin() * dot(x) - theta[0].cos() * dot(y) - radius * dot(roll),
        slip(1),
        slip(2),
    ];
    phi_lagrangian = midpoint;
}]
struct Train {
    masses: [f64; 3],
    lengths: [f64; 3],
    inertias: [f64; 4],
    ties: [f64; 9],
    rests: [f64; 9],
    radius: f64,
    gravity: f64,
}

impl Train {
    fn new(scene: &Scene) -> Self {
        let mut inertias = [0.0; 4];
        for &(coordinate, inertia) in &scene.inertias {
            inertias[coordinate - 2] += inertia;
        }
        let (mut ties, mut rests) = ([0.0; 9], [0.0; 9]);
        for spring in &scene.springs {
            let Spring::Twist {
                ends: (one, Some(other)),
                stiffness,
                rest,
            } = *spring
            else {
                panic!("no angle: {spring:?}");
            };
            let place = (one - 2) * 3 + (other - 2);
            (ties[place], rests[place]) = (stiffness, rest);
        }
        Self {
            masses: core::array::from_fn(|i| scene.bodies[i].mass),
            lengths: core::array::from_fn(|i| scene.bodies[i].rod.map_or(0.0, |(_, length)| length)),
            inertias,
            ties,
            rests,
            radius: scene.wheels[0].rolls.unwrap().1,
            gravity: scene.gravity,
        }
    }
}

/// A generator of scenes.
type Draw = fn(&mut Random) -> Option<Case>;

/// At most one scene in this number may be refused for two roots of a Lyapunov constraint, which nothing
/// distinguishes where they meet.
const AMBIGUOUS: u64 = 4;

/// A scene in angles; `None` where no state was found.
fn angles(scene: &Scene, random: &mut Random) -> Option<Case> {
    Case::new(scene, None, random)
}

/// Draws scenes of one kind, `few` of them or 60, and compares a declaration with the reference in each.
fn all<S: System<N>, const N: usize>(name: &str, few: u64, draw: Draw, declared: fn(&Scene) -> S) {
    let count = short_or_long(few, 60);
    let mut defects = Vec::new();
    let mut worst = Comparison::default();
    let (mut held, mut ambiguous) = (0, 0);
    for seed in 0..count {
        let mut random = Random::new(seed + 1);
        let Some(case) = draw(&mut random) else { continue };
        held += 1;
        let found = compare(&declared(&case.scene), &case, STEPS, seed);
        println!("{name} {seed}: {found:?}");
        worst.join(&found);
        ambiguous += u64::from(found.is_ambiguous());
        let wrong = found.wrong();
        if !wrong.is_empty() {
            defects.push(format!("{name} {seed}: {wrong:#?}\n{case:?}"));
        }
    }
    println!("{name}: {held} scenes, {ambiguous} refused as ambiguous, {worst:?}");
    assert!(
        2 * held > count,
        "{name}: states were found for {held} of {count} scenes"
    );
    assert!(
        AMBIGUOUS * ambiguous <= held,
        "{name}: {ambiguous} of {held} scenes are refused as ambiguous"
    );
    assert!(defects.is_empty(), "{}", defects.join("\n\n"));
}

/// A tree.
fn hanging(random: &mut Random) -> Option<Case> {
    angles(&tree(4, Map::Midpoint, random), random)
}

#[test]
fn trees() {
    all("tree", 3, hanging, Tree::new);
}

/// A tree of three with a motor between the first two angles.
fn moved(lyapunov: bool, random: &mut Random) -> Option<Case> {
    let scene = tree(3, Map::Midpoint, random);
    angles(&robot(scene, (1, Some(0)), lyapunov, random), random)
}

#[test]
fn servos() {
    all("servo", 3, |random| moved(false, random), Servo::new);
}

/// Two angles are tied, and one arm is hundreds of times as heavy as the other: the small second difference
/// needs its own relative accuracy.
#[test]
fn servos_between_a_heavy_and_a_light_arm() {
    for seed in [21, 43] {
        let case = moved(false, &mut Random::new(seed + 1)).unwrap();
        let found = compare(&Servo::new(&case.scene), &case, STEPS, seed);
        println!("{found:?}");
        assert!(found.wrong().is_empty(), "{found:?}");
    }
}

#[test]
fn brakes() {
    all("brake", 3, |random| moved(true, random), Brake::new);
}

#[test]
fn joints_that_are_parameters() {
    let draw = |random: &mut Random| {
        let scene = tree(3, Map::Midpoint, random);
        let joint = dsocs_tests::scenes::random::joint(&scene, random);
        angles(&robot(scene, joint, false, random), random)
    };
    all("any servo", 3, draw, AnyServo::new);
}

/// In one step of this chain the prediction leads to a root dozens of legs away, and the next candidate does
/// too.
#[test]
fn a_far_root_is_not_taken_where_the_determinant_departs() {
    let case = dsocs_tests::scenes::text::case(14, 9).unwrap();
    let found = compare(&Whip::new(&case.scene), &case, STEPS, 9);
    println!("{found:?}");
    assert!(found.wrong().is_empty() && found.steps > 68, "{found:?}");
}

declared! {
    /// Two masses with a spring between them, and one of them on a pendulum's potential.
    struct Tied {
        stiffness: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + y.cos() - stiffness / 2 * (x - y).powi(2);
    phi_lagrangian = midpoint;
}

/// The row of `x` is linear in both second differences; the shorter coefficient is that of `y`, and zero without the spring.
#[test]
fn a_spring_without_stiffness() {
    for stiffness in [1.0, 1e-8, 0.0] {
        let tied = Tied { stiffness };
        let start = Start::second_order([0.5, 0.3], [0.2, -0.1]);
        let mut flow = text::Flow::new(&tied, 0.01, start).unwrap();
        let last = flow.to(1.0).unwrap();
        println!("stiffness {stiffness}: {:?}", last.q);
        if stiffness < 1e-3 {
            assert!((last.q[0] - 0.7).abs() < 1e-7, "{:?}", last.q);
        }
    }
}

#[test]
fn linkages() {
    all("linkage", 3, linked, Linkage::new);
}

/// A linkage.
fn linked(random: &mut Random) -> Option<Case> {
    let (scene, place) = linkage(3, 2, Map::Paper, random);
    Case::new(&scene, Some(&place), random)
}

/// A train.
fn rolling(random: &mut Random) -> Option<Case> {
    angles(&train(3, true, Map::Midpoint, random), random)
}

#[test]
fn trains() {
    all("train", 2, rolling, Train::new);
}
