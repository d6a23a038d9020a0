//! Rows that jump with the next node: each node solves its row, or is reported as a jump over which the row
//! has no root.

#![allow(clippy::float_cmp)] // the same numbers, to the last bit

use dsocs_core::{AnyPath, DerivativeError, Ensemble, Path, Real, Start, Stepper, Stop, Tolerance, dsocs};
use dsocs_tests::declared;
use dsocs_tests::short_or_long;
use dsocs_tests::text::{Flow, System, TaylorFlow, read};
use proptest::prelude::*;

/// A prescribed motion with dry friction, by the sign of the velocity.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + k * x + dry * dot(x).signum();
    constraint_forces = [1];
}]
struct Sign {
    k: f64,
    dry: f64,
}

declared! {
    /// The friction by a comparison.
    struct Compared {
        k: f64,
        dry: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + k * x + if dot(x) > 0 { dry } else { -dry };
    constraint_forces = [1];
}

/// The friction by a function of the user's, whose jump the attribute does not see.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + k * x + dry * side(dot(x));
    constraint_forces = [1];
}]
struct Called {
    k: f64,
    dry: f64,
}

declared! {
    /// A row that is not affine in the velocity on either side.
    struct Bent {
        k: f64,
        dry: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + k * x + dry * dot(x).signum() * (1 + dot(x).powi(2));
    constraint_forces = [1];
}

fn side<R: Real>(v: R) -> R {
    if v > R::from(0.0) {
        R::from(1.0)
    } else {
        R::from(-1.0)
    }
}

/// The prescribed law: stiffness, friction, and the growth of the friction with the squared velocity.
#[derive(Clone, Copy, Debug)]
struct Law {
    k: f64,
    dry: f64,
    square: f64,
}

/// Runs to `until` and checks the row at every node by differences of its neighbours. Returns the numbers of
/// jumps and of steps that the flow reports as unresolved.
fn nodes_hold<S: System<1>>(system: &S, law: Law, x: f64, h: f64, until: f64) -> (u64, u64) {
    let mut flow = Flow::new(system, h, Start::second_order([x], [0.0])).unwrap();
    let mut jumps = 0;
    while flow.time() < until {
        let before = flow.leg();
        let report = flow.advance().unwrap();
        let after = flow.leg();
        let a = (after.d[0] - before.d[0]) / (h * h);
        let v = (after.d[0] + before.d[0]) / (2.0 * h);
        let friction = law.dry * (1.0 + law.square * v * v);
        let rest = a + law.k * before.q[0];
        let scale = a.abs() + (law.k * before.q[0]).abs() + friction;
        if matches!(report.stop, Stop::Jump | Stop::Sticks) {
            jumps += u64::from(report.stop == Stop::Jump);
            // at a jump the velocity is zero, or the mass rests from here on, and a friction between the two
            // signs' solves the row
            let rests = |d: f64| d.abs() <= 1e-12 * h * h * scale;
            let turns = v.abs() <= 1e-9 * h * scale && report.stop == Stop::Jump;
            let arrives = rests(after.d[0]) && (report.stop == Stop::Jump || rests(before.d[0]));
            assert!(turns || arrives, "{law:?} {h} {v:e}");
            assert!(
                rest.abs() <= friction * (1.0 + 1e-9),
                "{law:?} {h} {rest} {friction}"
            );
        } else {
            // rounding is that of the difference of two increments. After the last update no row is
            // evaluated, and this update may be some roundings long, of the increments or of the row's
            // terms, which nearly cancel at rest: a velocity below it has either sign
            let increments = after.d[0].abs() + before.d[0].abs();
            let rounding = 4.0 * f64::EPSILON * increments / (h * h);
            let either = v.abs() <= 64.0 * f64::EPSILON * (increments / h + h * scale);
            let left = |side: f64| (rest + friction * side).abs();
            let left = if either {
                left(1.0).min(left(-1.0))
            } else {
                left(v.signum())
            };
            assert!(left <= 1e-11 * scale + rounding, "{law:?} {h}: {left:e} {v:e}");
        }
    }
    (jumps, flow.unresolved().map_or(0, |unresolved| unresolved.steps))
}

#[test]
fn a_step_across_a_jump_is_solved_or_told() {
    let law = Law {
        k: 1.0,
        dry: 0.5,
        square: 0.0,
    };
    let (k, dry) = (law.k, law.dry);
    for h in [0.1, 0.01, 0.001] {
        // it turns at x = 3, -2 and 1, and rests there, between the frictions of both signs
        let found = [
            nodes_hold(&Sign { k, dry }, law, 3.0, h, 8.0),
            nodes_hold(&Compared { k, dry }, law, 3.0, h, 8.0),
            nodes_hold(&Called { k, dry }, law, 3.0, h, 8.0),
            nodes_hold(&Bent { k, dry }, Law { square: 1.0, ..law }, 3.0, h, 8.0),
        ];
        println!("{h}: {found:?}");
        // both turns are reported, wherever the nodes lie
        assert!(found[0].1 >= 2 && found[1].1 >= 2, "{h}: {found:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(short_or_long(16, 64)))]

    #[test]
    fn whatever_the_numbers_are(
        k in 0.05_f64..40.0, part in 0.01_f64..1.5, x in 0.1_f64..20.0, h in 0.0005_f64..0.05, square in prop::bool::ANY,
    ) {
        let dry = part * k * x;
        let until = 3.0 * std::f64::consts::TAU / k.sqrt();
        let until = until.min(2000.0 * h);
        if square {
            // keeps friction small enough for these steps to resolve
            let dry = dry / (1.0 + k * x * x);
            nodes_hold(&Bent { k, dry }, Law { k, dry, square: 1.0 }, x, h, until);
        } else {
            let law = Law { k, dry, square: 0.0 };
            nodes_hold(&Sign { k, dry }, law, x, h, until);
            nodes_hold(&Compared { k, dry }, law, x, h, until);
            nodes_hold(&Called { k, dry }, law, x, h, until);
        }
    }
}

/// From rest at a turn, the first steps are even in time; the next turn is nevertheless recognised.
#[test]
fn a_turn_long_after_an_even_start_has_its_sign() {
    let (k, x, h) = (
        0.265_708_914_163_951_1,
        17.764_411_719_061_886,
        0.047_575_530_560_012_014,
    );
    let dry = 0.304_460_917_930_102_44 * k * x / (1.0 + k * x * x);
    let law = Law { k, dry, square: 1.0 };
    nodes_hold(&Bent { k, dry }, law, x, h, 36.0);
}

/// At a start at rest where friction and spring nearly balance.
#[test]
fn friction_that_hardly_exceeds_the_spring_holds() {
    let (k, x, h) = (36.829_985_495_710_325, 0.1, 0.0005);
    let dry = 1.000_057_005_147_064_3 * k * x;
    let law = Law { k, dry, square: 0.0 };
    nodes_hold(&Sign { k, dry }, law, x, h, 1.0);
    nodes_hold(&Compared { k, dry }, law, x, h, 1.0);
    nodes_hold(&Called { k, dry }, law, x, h, 1.0);
}

/// For a motion through its turns, the error is of first order in the step.
#[test]
fn the_motion_is_that_of_the_declaration() {
    let sign = Sign { k: 1.0, dry: 0.1 };
    let start = Start::second_order([3.0], [0.0]);
    // half turns about 0.1 and -0.1 in turn
    let exact = |t: f64| {
        let turn = (t / std::f64::consts::PI).floor();
        let centre = if turn % 2.0 == 0.0 { 0.1 } else { -0.1 };
        let amplitude = 3.0 - 0.1 - 0.2 * turn;
        centre + amplitude * t.cos()
    };
    let until = 10.0;
    let series = TaylorFlow::new(&sign, start, Tolerance::relative(1e-12)).unwrap();
    assert!(({ series }.to(until).unwrap().q[0] - exact(until)).abs() < 1e-10);
    let error = |h: f64| {
        let mut flow = Flow::new(&sign, h, start).unwrap();
        (flow.to(until).unwrap().q[0] - exact(until)).abs()
    };
    for h in [0.02, 0.01, 0.005, 0.0025] {
        let error = error(h);
        println!("{h}: {error:e}");
        assert!(error < 0.2 * h, "{h}: {error:e}");
    }
}

declared! {
    /// A Lyapunov constraint by which the energy falls as under dry friction; its factor stands in an absolute value.
    struct Falling {
        dry: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    let energy = dot(x).powi(2) / 2 + x.powi(2) / 2;
    kinematic = dot(energy) + dry * dot(x).abs();
    constraint_forces = [1];
    branch = divide(dot(x));
}

/// The force that such a constraint determines is that of dry friction, on both sides of a turn.
#[test]
fn a_factor_in_an_absolute_value_keeps_its_sign() {
    let falling = Falling { dry: 0.05 };
    let start = Start::second_order([1.0], [0.0]);
    // three half turns, about 0.05, -0.05 and 0.05, and a part of one about -0.05
    let exact = -0.05 - 0.65 * (12.0 - 3.0 * std::f64::consts::PI).cos();
    let mut series = TaylorFlow::new(&falling, start, Tolerance::relative(1e-10)).unwrap();
    assert!((series.to(12.0).unwrap().q[0] - exact).abs() < 1e-8);
    for h in [0.01, 0.005] {
        let mut flow = Flow::new(&falling, h, start).unwrap();
        assert!((flow.to(12.0).unwrap().q[0] - exact).abs() < 0.2 * h);
    }
}

/// Two masses in a row on springs, the second of which is damped: by a Lyapunov constraint whose dissipation has a corner where its factor
/// vanishes, and by the force that follows from it.
#[test]
fn a_factor_in_the_pieces_of_a_choice_is_divided_piece_by_piece() {
    let laws = [
        ("0.3 * w.max(0).powi(2)", "0.3 * w.max(0)"),
        (
            "(0.3 * w.powi(2)).min(0.05 * w.abs())",
            "(0.3 * w.abs()).min(0.05) * w.signum()",
        ),
        (
            "if w > 0 { 0.3 * w.powi(2) } else { 0.6 * w.powi(2) }",
            "if w > 0 { 0.3 * w } else { 0.6 * w }",
        ),
        ("0.05 * w.max(-w)", "0.05 * w.signum()"),
    ];
    let of = |law: &str| {
        let text = format!(
            "coordinates(x, y); let w = dot(y); \
             lagrangian = (dot(x).powi(2) + w.powi(2)) / 2 - (x.powi(2) + (y - x).powi(2)) / 2; {law}"
        );
        dsocs_core::text::Text::parse("two", &text).unwrap().system
    };
    let start = dsocs_core::AnyStart::second_order(&[0.3, -0.2], &[0.0, 0.5]);
    for (dissipation, force) in laws {
        let declared = of(&format!(
            "let energy = (dot(x).powi(2) + w.powi(2)) / 2 + (x.powi(2) + (y - x).powi(2)) / 2; \
             kinematic = dot(energy) + {dissipation}; constraint_forces = [(0, 1)]; branch = divide(w);"
        ));
        let forced = of(&format!("external_forces = (0, -({force}));"));
        let ends = [&declared, &forced].map(|system| {
            let mut series =
                dsocs_core::taylor::AnyTaylorFlow::of_tape(system, &start, Tolerance::relative(1e-10))
                    .unwrap();
            let run: &mut dyn dsocs_core::Run = &mut series;
            run.to(10.0)
                .unwrap_or_else(|error| panic!("{dissipation}: {error}"));
            let mut node = dsocs_core::OwnedNode::new(2);
            node.take(run);
            node.any().q.to_vec()
        });
        for (x, exact) in ends[0].iter().zip(&ends[1]) {
            assert!((x - exact).abs() < 1e-7, "{dissipation}: {ends:?}");
        }
    }
}

declared! {
    /// Two masses on a floor with dry friction, coupled by a spring and by their inertia.
    struct Two {
        inertia: f64,
        stiff: f64,
        dry: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + inertia * dot(x) * dot(y) - (x - y).powi(2) / 2 - stiff * y.powi(2) / 2;
    external_forces = (-dry * dot(x).signum(), -0.7 * dry * dot(y).signum());
}

declared! {
    /// A pendulum with dry friction: its rows are nonlinear.
    struct Pivot {
        dry: f64,
    }
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + 9.81 * theta.cos();
    external_forces = -dry * dot(theta).signum();
}

#[test]
fn friction_that_jumps_ends_no_run() {
    for h in [0.05, 0.01, 0.002] {
        for start in [[1.0, -0.5], [0.3, 2.0], [-1.0, -1.1]] {
            let two = Two {
                inertia: 0.3,
                stiff: 4.0,
                dry: 0.6,
            };
            let mut flow = Flow::new(&two, h, Start::second_order(start, [0.0; 2])).unwrap();
            let energy = |flow: &dsocs_core::Flow<'_, 2>| flow.node().energy;
            let mut highest = f64::INFINITY;
            while flow.time() < 20.0 {
                flow.advance().unwrap();
                if flow.index().is_multiple_of(100) {
                    // friction removes energy, except for chatter about rest
                    assert!(
                        energy(&flow) < highest + 0.1 * h,
                        "{h} {start:?}: {}",
                        energy(&flow)
                    );
                    highest = energy(&flow);
                }
            }
            assert!(highest < 0.1, "{highest}");
            assert!(flow.unresolved().is_some());
        }
        let pivot = Pivot { dry: 0.5 };
        let mut flow = Flow::new(&pivot, h, Start::second_order([1.5], [0.0])).unwrap();
        let mut most = 1.5_f64;
        while flow.time() < 30.0 {
            flow.advance().unwrap();
            most = if flow.time() > 25.0 {
                most.min(flow.position()[0].abs())
            } else {
                most
            };
        }
        // it sticks where friction balances the weight
        assert!(9.81 * most.sin() <= 0.5 + 10.0 * h, "{h}: {most}");
        assert!(flow.unresolved().is_some());
    }
}

#[test]
fn lanes_do_the_same() {
    let sign = Sign { k: 2.0, dry: 0.3 };
    let starts: Vec<_> = (1..20)
        .map(|i| Start::second_order([0.2 * f64::from(i)], [0.1]))
        .collect();
    let ends = Ensemble::new(&sign, 0.01)
        .unwrap()
        .starts(starts.iter().copied())
        .to(9.0);
    for (start, end) in starts.iter().zip(ends) {
        let mut flow = Flow::new(&sign, 0.01, *start).unwrap();
        assert_eq!(end.unwrap().q, flow.to(9.0).unwrap().q);
    }
}

#[test]
fn a_jump_has_no_derivative() {
    let two = Two {
        inertia: 0.3,
        stiff: 4.0,
        dry: 0.6,
    };
    // friction changes its direction
    let start = Start::second_order([1.0, -0.5], [0.0; 2]);
    let failed = AnyPath::new(read(&two), 0.01, &start.into(), 10.0).unwrap_err();
    let DerivativeError::MovingJump {
        argument,
        index,
        time,
        ..
    } = failed
    else {
        panic!("{failed}");
    };
    assert!(["dot(x)", "dot(y)"].contains(&&*argument), "{argument}");
    let mut flow = Flow::new(&two, 0.01, start).unwrap();
    while flow.unresolved().is_none() {
        assert!(flow.advance().unwrap().stop != Stop::Jump);
    }
    assert_eq!(
        (index as u64, time),
        (flow.index() - 1, flow.unresolved().unwrap().first)
    );
    assert!(AnyPath::new(read(&two), 0.01, &start.into(), time - 0.02).is_ok());
    // friction brings a mass to rest
    let sign = Sign { k: 2.0, dry: 3.0 };
    let start = Start::second_order([0.3], [1.0]);
    let failed = Path::new(&sign, 0.01, start, 10.0).unwrap_err();
    let DerivativeError::Jump { index, time } = failed else {
        panic!("{failed}");
    };
    let mut flow = Flow::new(&sign, 0.01, start).unwrap();
    while flow.advance().unwrap().stop != Stop::Jump {}
    assert_eq!((index as u64, time), (flow.index() - 1, flow.node().t));
    assert!(Path::new(&sign, 0.01, start, time - 0.02).is_ok());
}
