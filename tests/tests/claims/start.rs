//! The second node of both starts: that of the paper, and that with its correction of second order.

#![allow(clippy::float_cmp)] // the same numbers, to the last bit

use std::f64::consts::SQRT_2;

use dsocs_core::{SetupError, Start, Stepper};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum, Wavy};
use dsocs_tests::closed_form::pendulum::{self, START};
use dsocs_tests::declared;
use dsocs_tests::text::Flow;

fn assert_close(found: [f64; 2], expected: [f64; 2], tolerance: f64) {
    for i in 0..2 {
        assert!(
            (found[i] - expected[i]).abs() <= tolerance * expected[i].abs(),
            "{found:?} instead of {expected:?}"
        );
    }
}

#[test]
fn of_the_particle() {
    let particle = CurvedParticle::default();
    let (q0, v0, h) = ([0.0, 0.0], [1.0, 1.0], 0.1);
    let paper = Flow::new(&particle, h, Start::paper(q0, v0)).unwrap();
    assert_close(*paper.position(), [0.1, 0.1], 0.0);

    // a0 is κ |v| times the velocity, turned to the left
    let mut second = Flow::new(&particle, h, Start::second_order(q0, v0)).unwrap();
    assert_close(
        *second.position(),
        [h - h * h / SQRT_2, h + h * h / SQRT_2],
        4e-16,
    );
    let node = second.next().unwrap().unwrap();
    assert_close(node.a, [-SQRT_2, SQRT_2], 1e-15);
    assert_close(node.force, [-SQRT_2, SQRT_2], 1e-15);
}

#[test]
fn of_the_particle_with_mass_and_curvature() {
    let wavy = Wavy {
        mean: -0.5,
        amplitude: 0.25,
        wave_number: 2.0,
    };
    let particle = CurvedParticle {
        mass: 3.0,
        curvature: wavy,
    };
    let (q0, v0, h) = ([0.3, -0.7], [2.0, -1.0], 1e-3);
    let curvature = -0.5 + 0.25 * (0.6_f64).sin() * (-1.4_f64).cos();
    let speed = 5.0_f64.sqrt();
    let a0 = [curvature * speed, 2.0 * curvature * speed];
    let mut flow = Flow::new(&particle, h, Start::second_order(q0, v0)).unwrap();
    assert_close(
        *flow.position(),
        [
            q0[0] + h * v0[0] + h * h / 2.0 * a0[0],
            q0[1] + h * v0[1] + h * h / 2.0 * a0[1],
        ],
        4e-16,
    );
    let node = flow.next().unwrap().unwrap();
    assert_close(node.a, a0, 1e-14);
    assert_close(node.force, [3.0 * a0[0], 3.0 * a0[1]], 1e-14);
}

#[test]
fn of_the_pendulum() {
    let system = InertiaWheelPendulum::default();
    let ((q0, v0), h) = (START, 0.1);
    let paper = Flow::new(&system, h, Start::paper(q0, v0)).unwrap();
    assert_close(*paper.position(), [0.5, 0.05], 4e-16);

    let a0 = pendulum::acceleration(q0, v0);
    let second = Flow::new(&system, h, Start::second_order(q0, v0)).unwrap();
    assert_close(
        *second.position(),
        [0.5 + h * h / 2.0 * a0[0], 0.05 + h * h / 2.0 * a0[1]],
        1e-13,
    );
}

#[test]
fn nodes_are_taken_as_they_are() {
    let particle = CurvedParticle::default();
    let flow = Flow::new(&particle, 0.1, Start::nodes([1e9, 0.0], [1e9 + 0.1, 0.1])).unwrap();
    assert_close(*flow.position(), [1e9 + 0.1, 0.1], 0.0);
    assert_close(flow.leg().d, [(1e9 + 0.1) - 1e9, 0.1], 0.0);
}

#[test]
fn the_clock_may_begin_anywhere() {
    let particle = CurvedParticle::default();
    let start = Start::paper([0.0, 0.0], [1.0, 1.0]);
    let plain = Flow::new(&particle, 0.1, start).unwrap().until(5.0).unwrap();
    let later = Flow::new(&particle, 0.1, start.at(100.0))
        .unwrap()
        .until(105.0)
        .unwrap();
    assert_eq!((plain.len(), later.len()), (51, 51));
    for (plain, later) in plain.iter().zip(&later) {
        assert!((later.t - plain.t - 100.0).abs() < 1e-13);
        assert_eq!(plain.q, later.q);
    }
}

#[test]
fn the_exact_start_is_on_the_continuous_motion() {
    let particle = CurvedParticle::default();
    for h in [0.5, 0.1, 1e-3, -0.2] {
        let start = Start::second_order([0.3, -0.2], [1.0, 1.0])
            .exact(&particle, h)
            .unwrap();
        let flow = Flow::new(&particle, h, start).unwrap();
        let (q, _) = particle.exact([0.3, -0.2], [1.0, 1.0], h);
        for (found, exact) in flow.position().iter().zip(q) {
            assert!((found - exact).abs() < 5e-16, "h = {h}: {found} {exact}");
        }
        assert!(Flow::new(&particle, 2.0 * h, start).is_err());
    }
}

declared! {
    /// A body on a spring, driven by a second one, under a law that is zero for any acceleration at rest.
    struct Driven {
        body: f64,
        wheel: f64,
        ratio: f64,
    }
    coordinates(x, y);
    lagrangian = body / 2 * dot(x).powi(2) + wheel / 2 * (dot(x) + ratio * dot(y)).powi(2);
    kinematic = dot(dot(x).powi(2) / 2 + x.powi(2) / 2) + dot(x).powi(2);
    constraint_forces = [(0, 1)];
}

#[test]
fn a_law_that_says_nothing_at_rest_is_refused_whatever_the_other_rows_are() {
    // at rest the rows vanish for zero acceleration, and along a direction that mixes the coordinates by the
    // masses
    for (body, wheel, ratio) in [
        (1.0, 0.1, 1.0),
        (3.0, 0.7, -0.3),
        (1e-3, 17.0, 0.9),
        (0.2, 1e-4, 1e3),
        (7e5, 3.0, 1e-3),
    ] {
        let driven = Driven { body, wheel, ratio };
        for x in [1.0, -0.3, 1e-6, 4e3] {
            let start = Start::second_order([x, 0.0], [0.0, 0.0]);
            let refused = Flow::new(&driven, 0.01, start).unwrap_err().to_string();
            for words in ["kinematic constraint 1 says nothing", "branch = divide"] {
                assert!(refused.contains(words), "{body} {wheel} {ratio} {x}: {refused}");
            }
            // with a velocity the start is accepted
            assert!(Flow::new(&driven, 0.01, Start::second_order([x, 0.0], [x, 0.0])).is_ok());
        }
    }
}

declared! {
    /// The law divided by its velocity, which determines the acceleration at rest too.
    struct Divided {}
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x * y;
    kinematic = ddot(x) + x + dot(x);
    constraint_forces = [(1, 0)];
}

#[test]
fn a_step_of_first_order_does_not_rest_where_a_law_says_nothing() {
    let driven = Driven {
        body: 1.0,
        wheel: 0.1,
        ratio: 1.0,
    };
    for h in [0.1, 1e-3, -0.02] {
        for start in [
            Start::paper([1.0, 0.3], [0.0; 2]),
            Start::nodes([1.0, 0.3], [1.0, 0.3]),
            Start::paper([1.0, 0.3], [0.0; 2]).at(2.0),
        ] {
            let refused = Flow::new(&driven, h, start).unwrap_err();
            assert!(matches!(refused, SetupError::Rest { .. }), "{refused}");
            let message = refused.to_string();
            for words in [
                "rest for ever",
                "kinematic constraint 1 says nothing",
                "branch = divide",
            ] {
                assert!(message.contains(words), "{message}");
            }
        }
        // in equilibrium it rests, although the law does not determine the acceleration
        let mut flow = Flow::new(&driven, h, Start::paper([0.0, 0.3], [0.0; 2])).unwrap();
        flow.advance().unwrap();
        assert_eq!(*flow.position(), [0.0, 0.3]);
        // with a velocity it starts, and a law that determines the acceleration at rest moves it
        assert!(Flow::new(&driven, h, Start::paper([1.0, 0.3], [0.5, 0.0])).is_ok());
        let mut flow = Flow::new(&Divided {}, h, Start::paper([1.0, 0.3], [0.0; 2])).unwrap();
        flow.advance().unwrap();
        assert!(flow.position()[0] < 1.0);
    }
}

declared! {
    /// A law whose derivative vanishes at zero acceleration.
    struct Cubed { value: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x).powi(3) - value;
    constraint_forces = [(1,)];
}

declared! {
    /// A law with two solutions.
    struct Squared { value: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x).powi(2) - value;
    constraint_forces = [(1,)];
}

#[test]
fn the_only_acceleration_is_found_where_newton_fails_from_zero() {
    let start = Start::second_order([0.3], [0.1]);
    for value in [8.0, -27.0, 1e-9, 1e9] {
        let end = Flow::new(&Cubed { value }, 0.01, start).unwrap().to(0.1).unwrap();
        assert!((end.a[0] / value.cbrt() - 1.0).abs() < 1e-9, "{value}: {end:?}");
    }
    // of two solutions one has to be chosen
    assert!(Flow::new(&Squared { value: 4.0 }, 0.01, start).is_err());
}
