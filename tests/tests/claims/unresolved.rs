//! A force that switches between two nodes leaves no trace in the rows. The flow reports such steps as
//! unresolved, and no others.

use std::f64::consts::PI;

use dsocs_core::text::Text;
use dsocs_core::{
    AnyComposedFlow, Composition, Real, Samples, Start, Stepper, TaylorFlow, Tolerance, Unresolved, dsocs,
};
use dsocs_tests::declared;
use dsocs_tests::text::Flow;

/// A pendulum with dry friction in its joint, a switch of the width `1/k` in the velocity.
#[dsocs {
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + theta.cos();
    external_forces = (-mu * switch(k * dot(theta)),);
}]
struct Joint {
    k: f64,
    mu: f64,
}

/// A switch from −1 to 1.
fn switch<R: Real>(x: R) -> R {
    x.tanh()
}

/// A ball that a stiff wall pushes back.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = (-push * (1 + switch(k * (x - 1))),);
}]
struct Wall {
    k: f64,
    push: f64,
}

/// A mass on a spring under a force by a table of samples.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    external_forces = (blow.at(t),);
}]
struct Blown {
    blow: Samples,
}

const UNTIL: f64 = 8.0;

#[test]
fn a_blow_between_two_nodes_is_told() {
    for (h, is_told) in [(0.01, true), (1e-4, false)] {
        let peak = [(0.0, 0.0), (1.3, 0.0), (1.3012, 300.0), (1.3024, 0.0), (9.0, 0.0)];
        let blown = Blown {
            blow: Samples::monotone(peak).unwrap(),
        };
        let mut flow = Flow::new(&blown, h, Start::second_order([0.1], [1.0])).unwrap();
        flow.to(2.0).unwrap();
        assert_eq!(
            flow.unresolved().is_some(),
            is_told,
            "{h}: {:?}",
            flow.unresolved()
        );
    }
}

/// The number of unresolved steps, and the error of the position at the end.
fn run(joint: &Joint, h: f64) -> (u64, f64) {
    let start = Start::second_order([1.5], [0.0]);
    let exact = TaylorFlow::new(joint, start, Tolerance::relative(1e-10)).unwrap();
    let exact = { exact }.to(UNTIL).unwrap().q[0];
    let mut flow = Flow::new(joint, h, start).unwrap();
    while flow.time() < UNTIL - h / 2.0 {
        flow.advance().unwrap();
    }
    let steps = flow.unresolved().map_or(0, |unresolved| unresolved.steps);
    (steps, (flow.position()[0] - exact).abs())
}

#[test]
fn a_switch_between_two_nodes_is_told() {
    // four times the velocity and the friction change their signs
    for h in [0.1, 0.05, 0.025] {
        let (steep, [resolved, soft]) = (
            run(&Joint { k: 500.0, mu: 0.2 }, h),
            [5.0, 2.0].map(|k| run(&Joint { k, mu: 0.2 }, h)),
        );
        println!("h = {h}: k = 500 {steep:?}, k = 5 {resolved:?}, k = 2 {soft:?}");
        assert!((1..=8).contains(&steep.0), "{steep:?}");
        assert_eq!([resolved.0, soft.0], [0, 0]);
    }
    // steps shorter than the switch keep the order and are not reported
    let (coarse, fine) = (
        run(&Joint { k: 50.0, mu: 0.2 }, 0.1),
        run(&Joint { k: 50.0, mu: 0.2 }, 0.0125),
    );
    assert!(coarse.0 > 0 && fine.0 == 0, "{coarse:?} {fine:?}");
    // a negligible friction is not reported
    assert_eq!(run(&Joint { k: 500.0, mu: 1e-3 }, 0.1).0, 0);
}

#[test]
fn the_first_step_of_a_switch_is_named() {
    let joint = Joint { k: 500.0, mu: 0.2 };
    let mut flow = Flow::new(&joint, 0.1, Start::second_order([1.5], [0.0])).unwrap();
    let mut turned = None;
    while flow.time() < UNTIL {
        let before = flow.leg().d[0];
        flow.advance().unwrap();
        let after = flow.leg().d[0];
        if before * after < 0.0 && flow.index() > 3 {
            turned.get_or_insert((flow.index() - 1) as f64 * 0.1);
        }
    }
    let unresolved = flow.unresolved().unwrap();
    assert!(
        (unresolved.first - turned.unwrap()).abs() < 1e-12,
        "{unresolved:?} {turned:?}"
    );
    assert!(
        unresolved.largest > 0.1 && unresolved.largest <= 1.0,
        "{unresolved:?}"
    );
}

/// A switch in the position, shorter than a step, and one as long as several steps.
#[test]
fn a_wall_is_a_switch_too() {
    let run = |k: f64| {
        let wall = Wall { k, push: 0.5 };
        let mut flow = Flow::new(&wall, 0.1, Start::second_order([0.0], [1.0])).unwrap();
        while flow.time() < 3.0 {
            flow.advance().unwrap();
        }
        flow.unresolved().map(|unresolved| unresolved.steps)
    };
    assert!(run(1000.0).is_some_and(|steps| steps >= 1));
    assert_eq!(run(2.0), None);
}

declared! {
    /// A mass on a spring with dry friction, which jumps.
    struct Jump {
        dry: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - 20 * x.powi(2);
    external_forces = -dry * dot(x).signum();
}

#[test]
fn jumps_between_two_nodes_are_counted_each_once() {
    // it turns three times up to here
    for h in [0.02, 0.01, 0.003, 0.001] {
        let run = |dry: f64| {
            let jump = Jump { dry };
            let mut flow = Flow::new(&jump, h, Start::second_order([0.2], [0.0])).unwrap();
            flow.to(1.9).unwrap();
            flow.unresolved()
        };
        let found = run(1.0).unwrap();
        assert_eq!(found.steps, 3, "{h}: {found:?}");
        let turn = PI / 40_f64.sqrt();
        assert!((found.first - turn).abs() <= 1.01 * h, "{h}: {found:?}");
        // a jump of a hundredth of the acceleration at a turn is reported, a negligible one is not
        assert_eq!(run(0.1).map(|found| found.steps), Some(3), "{h}");
        assert_eq!(run(0.002), None, "{h}");
    }
}

/// A car on a roller coaster, whose track is a function of the user's; the attribute cannot know that it is
/// smooth.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
    holonomic = y - track(x);
}]
struct Coaster {}

fn track<R: Real>(x: R) -> R {
    (x * 0.7).sin() * (x * x * -0.05).exp() * 3.0
}

/// A particle whose curvature is such a function.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - track(x) - 2;
    variational = [(dot(x), dot(y))];
}]
struct Winding {}

/// A smooth function of the user's is not reported as a jump at any step: the iteration alternates by
/// rounding only.
#[test]
fn smooth_functions_of_the_user_do_not_jump() {
    let coaster = Start::second_order([-4.0, track(-4.0)], [0.0; 2]);
    let winding = Start::second_order([0.0; 2], [0.6, 0.8]);
    for h in [0.02, 0.01, 0.005, 0.0025, 0.001, 1e-4] {
        let until = f64::min(20.0, 2e4 * h);
        let mut flow = Flow::new(&Coaster {}, h, coaster).unwrap();
        flow.to(until).unwrap();
        assert_eq!(flow.unresolved(), None, "h = {h}");
        let mut flow = Flow::new(&Winding {}, h, winding).unwrap();
        flow.to(until).unwrap();
        assert_eq!(flow.unresolved(), None, "h = {h}");
    }
}

declared! {
    /// Masses on a spring with another mass for each direction: the momentum is continuous where they turn,
    /// the acceleration jumps.
    struct Ratchet {
        heavy: f64,
        smooth: f64,
    }
    coordinates(x, y);
    let mass = if dot(x) > 0 { heavy } else { 1 };
    lagrangian = mass * dot(x).powi(2) / 2 - x.powi(2) / 2 + smooth * x.powi(4) + dot(y).powi(2) / 2 - y.powi(2) / 8;
}

/// The exact velocity of such a mass, from rest at 1.
fn ratchet(heavy: f64, t: f64) -> f64 {
    let slow = heavy.sqrt();
    let left = t % (PI + slow * PI);
    if left < PI {
        -left.sin()
    } else {
        ((left - PI) / slow).sin() / slow
    }
}

#[test]
fn a_mass_that_jumps_with_the_velocity_is_told_at_each_turn() {
    for heavy in [0.5, 1.3, 2.0, 8.0_f64] {
        let period = PI * (1.0 + heavy.sqrt());
        let until = 2.2 * period;
        for h in [0.02, 0.0071, 0.003] {
            let system = Ratchet { heavy, smooth: 0.0 };
            let start = Start::second_order([1.0, 0.3], [0.0, 0.2]);
            let mut flow = Flow::new(&system, h, start).unwrap();
            let (mut off, mut beside) = (0.0_f64, 0.0_f64);
            for node in &flow.until(until).unwrap() {
                let error = (node.v[0] - ratchet(heavy, node.t)).abs();
                let to_turn = [0.0, PI].map(|turn| {
                    let apart = (node.t - turn).rem_euclid(period);
                    apart.min(period - apart)
                });
                if to_turn.into_iter().fold(f64::INFINITY, f64::min) < 1.01 * h && node.t > h {
                    beside = beside.max(error);
                } else {
                    off = off.max(error);
                }
            }
            // errors of first order occur at turns only, which are reported
            assert!(off < 20.0 * h * h * heavy.max(1.0), "{heavy}, {h}: {off:e}");
            assert!(beside > 10.0 * h * h * 0.1, "{heavy}, {h}: {beside:e}");
            let mut flow = Flow::new(&system, h, start).unwrap();
            flow.to(until).unwrap();
            let Unresolved { steps, first, .. } = flow.unresolved().unwrap();
            assert!((first - PI).abs() <= 1.01 * h, "{heavy}, {h}: {first}");
            // four turns, each in one step or in two that share it
            assert!((4..=8).contains(&steps), "{heavy}, {h}: {steps}");
        }
    }
    // equal masses in both directions
    let system = Ratchet {
        heavy: 1.0,
        smooth: 0.05,
    };
    let mut flow = Flow::new(&system, 0.01, Start::second_order([1.0, 0.3], [0.0, 0.2])).unwrap();
    flow.to(20.0).unwrap();
    assert_eq!(flow.unresolved(), None);
}

/// Beads in a row between two walls: each force is zero up to a contact and grows with a power of the depth.
fn beads(power: f64) -> Text {
    let text = format!(
        "coordinates(x: [3]);
        lagrangian = dot(x).norm_squared() / 2;
        let p = |d| 1e4 * d.max(0).powf({power:?});
        let a = p(-x[0]); let b = p(x[0] - x[1]); let c = p(x[1] - x[2]); let d = p(x[2] - 0.3);
        external_forces = (a - b, b - c, c - d);"
    );
    Text::parse("beads", &text).unwrap()
}

/// The unresolved steps of a run of order 2 or 4, or 6, up to a time.
fn counted<const N: usize>(
    text: &Text,
    start: Start<N>,
    h: f64,
    order: u32,
    until: f64,
) -> Option<Unresolved> {
    let composition = match order {
        2 => {
            let mut flow = dsocs_core::Flow::of(&text.system, h, start).unwrap();
            flow.to(until).unwrap();
            return flow.unresolved();
        }
        4 => Composition::SUZUKI_4,
        _ => Composition::KAHAN_LI_6,
    };
    let mut flow = AnyComposedFlow::new(&text.system, h, composition, &start.into()).unwrap();
    flow.run_mut().to(until).unwrap();
    flow.run().unresolved()
}

/// A force that begins or ends at a contact is continuous there, wherever the place lies in a step, and whether another one
/// begins in the same step.
#[test]
fn contacts_do_not_jump() {
    for power in [1.5, 2.0, 2.5] {
        let text = beads(power);
        for speed in [0.3, 0.37] {
            let start = Start::second_order([0.05, 0.1, 0.15], [speed, 0.0, 0.0]);
            for h in [0.004, 0.003, 0.002, 0.001, 0.0005] {
                for order in [2, 4, 6] {
                    let found = counted(&text, start, h, order, 2.0);
                    assert_eq!(found, None, "{power} {speed} {h} {order}");
                }
            }
        }
    }
    for text in [
        "lagrangian = dot(x).powi(2) / 2 - 9.81 * x; external_forces = 1e6 * (-x).max(0);",
        "lagrangian = dot(x).powi(2) / 2 - 9.81 * x - 1e6 * (-x).max(0).powi(2) / 2; external_forces = -0.01 * dot(x);",
    ] {
        let text = Text::parse("ball", &format!("coordinates(x); {text}")).unwrap();
        for h in [5e-4, 3e-4, 1e-4] {
            for order in [2, 4, 6] {
                let found = counted(&text, Start::second_order([1.0], [0.0]), h, order, 4.0);
                assert_eq!(found, None, "{h} {order}");
            }
        }
    }
}

/// Where forces have found their balance, what is left of them is rounding.
#[test]
fn a_balance_that_is_found_does_not_jump() {
    for (force, steps) in [
        ("1 - 1000 * dot(x)", [0.01, 0.005, 0.003, 0.02, 1e-3]),
        ("0.3 - 30 * dot(x)", [0.1, 0.07, 0.05, 0.01, 0.2]),
    ] {
        let text = format!("coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = {force};");
        let text = Text::parse("relaxation", &text).unwrap();
        for h in steps {
            let found = counted(&text, Start::second_order([0.0], [0.0]), h, 2, 200.0 * h);
            assert_eq!(found, None, "{force} {h}");
        }
        if force.starts_with('1') {
            for h in [0.0015, 1e-3, 5e-4] {
                for v in [0.0, 1.0] {
                    let found = counted(&text, Start::second_order([0.0], [v]), h, 4, 200.0 * h);
                    assert_eq!(found, None, "{force} {h}, order 4, from {v}");
                }
            }
        }
    }
}

/// A quotient loses its digits towards a zero of its divisor, where it has a limit and does not jump.
#[test]
fn a_quotient_with_few_digits_does_not_jump() {
    for force in [
        "0.3 * (1 - x.cos()) / x.powi(2)",
        "x.sin() / x",
        "(x - x.sin()) / x.powi(3)",
        "(x.exp() - 1) / x - 1",
        "(x.exp() - 1 - x) / x.powi(2)",
        "x.ln_1p() / x",
        "(1 - (1 - x.powi(2)).sqrt()) / x.powi(2)",
    ] {
        let text = format!("coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = {force};");
        let text = Text::parse("quotient", &text).unwrap();
        for (at, h) in [
            (0.5, 0.125),
            (0.47, 0.03),
            (0.3, 0.011),
            (0.013, 1e-3),
            (0.002, 1e-4),
        ] {
            for order in [2, 4] {
                let start = Start::second_order([-at], [1.0]);
                let found = counted(&text, start, h, order, (1.4 * at / h).floor() * h);
                assert_eq!(found, None, "{force}, from {at}, {h}, order {order}");
            }
        }
    }
}

/// A force jumps at x = 1, and later the potential at x = 2, where the velocity has to jump: the time of the worst step is its own.
#[test]
fn the_largest_jump_has_its_own_time() {
    let text = Text::parse(
        "jumps",
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 0.1 * (x - 2).signum(); external_forces = 0.05 * (x - 1).signum();",
    )
    .unwrap();
    // at constant forces: t = 1.0263 at x = 1, and with v = 0.9487 there, one more unit in 1.0266
    let v1 = (1.0_f64 - 0.1).sqrt();
    let first = (1.0 - v1) / 0.05;
    let second = first + ((v1 * v1 + 0.1).sqrt() - v1) / 0.05;
    for h in [0.01, 0.003] {
        let start = dsocs_core::AnyStart::second_order(&[0.0], &[1.0]);
        let mut flow = dsocs_core::AnyFlow::new(&text.system, h, &start).unwrap();
        flow.run_mut().to(2.5).unwrap();
        let found = flow.run().unresolved().unwrap();
        assert_eq!((found.steps, found.largest), (2, f64::INFINITY), "{found:?}");
        assert!((found.first - first).abs() < 2.0 * h, "{found:?} {first}");
        assert!((found.largest_at - second).abs() < 2.0 * h, "{found:?} {second}");
    }
}
