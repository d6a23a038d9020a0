//! Error messages in the terms of the declaration: the coordinate, the rows, the distance of two solutions.

use dsocs_core::{DependentRow, RunError, SetupError, Start, StepFailure, Stepper, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::text::{Flow, System, TaylorFlow};

use crate::roots::Either;

declared! {
    /// Two coordinates with one mass for their sum.
    struct OneMass;
    coordinates(x, y, z);
    lagrangian = (dot(x) + dot(y)).powi(2) / 2 + dot(z).powi(2) / 2 - x.powi(2);
}

declared! {
    /// A mass, and two massless coordinates: the second enters the potential only.
    struct Massless;
    coordinates(x, y, z);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 + x * y - z;
    holonomic = z - x.powi(2);
}

declared! {
    /// Two rods of equal length between the same ends.
    struct TwoRods {
        lengths: [f64; 2],
    }
    coordinates(x: [5]);
    lagrangian = sum(0..5, |i| dot(x[i]).powi(2)) / 2;
    holonomic = [
        x[4] - x[0] * x[1],
        (x[0] - x[2]).powi(2) + (x[1] - x[3]).powi(2) - lengths[0].powi(2),
        (x[2] - x[0]).powi(2) + (x[3] - x[1]).powi(2) - lengths[1].powi(2),
    ];
}

const TWO_RODS: TwoRods = TwoRods { lengths: [1.0; 2] };

declared! {
    /// A wall given by a square.
    struct Square;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
    holonomic = x.powi(2);
}

declared! {
    /// A squared law for two accelerations.
    struct Squared;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)).powi(2) - (dot(x).powi(2) + dot(y).powi(2)).powi(3);
    variational = [(dot(x), dot(y))];
}

declared! {
    /// A mass beside a pendulum with a motor, whose energy falls in proportion to itself, or with the power of the motor.
    struct Falling { own: f64, power: f64 }
    coordinates(x, theta);
    lagrangian = (dot(x).powi(2) + dot(theta).powi(2)) / 2 + theta.cos();
    let energy = (dot(x).powi(2) + dot(theta).powi(2)) / 2 + 1 - theta.cos();
    kinematic = dot(energy) + own * energy + power * dot(theta).powi(2);
    constraint_forces = [(0, 1)];
}

/// The message of a second-order start that is refused.
fn refused<S: System<N>, const N: usize>(system: &S, q0: [f64; N], v0: [f64; N]) -> (SetupError, String) {
    let error = Flow::new(system, 0.1, Start::second_order(q0, v0))
        .map(|_| ())
        .unwrap_err();
    // a Taylor series gives the same message
    let series = TaylorFlow::new(system, Start::second_order(q0, v0), Tolerance::relative(1e-9));
    assert_eq!(series.map(|_| ()).unwrap_err().to_string(), error.to_string());
    let message = error.to_string();
    (error, message)
}

/// The message of a failed first step.
fn fails<S: System<N>, const N: usize>(system: &S, q0: [f64; N], v0: [f64; N]) -> String {
    let mut flow = Flow::new(system, 0.1, Start::paper(q0, v0)).unwrap();
    flow.until(10.0).unwrap_err().error.to_string()
}

#[test]
fn a_coordinate_without_a_mass_is_named() {
    let (error, message) = refused(&Massless, [1.0, 0.3, 1.0], [0.0, 1.0, 0.0]);
    let expected = "coordinate `y` has no mass and no row determines it";
    assert!(message.contains(expected), "{message}");
    assert!(message.contains("give it a mass"), "{message}");
    let SetupError::Acceleration {
        deficiency: Some(deficiency),
        ..
    } = error
    else {
        panic!("{message}")
    };
    assert_eq!(deficiency.coordinates, ["y"]);
    assert!(deficiency.massless && !deficiency.combined);
    let message = fails(&Massless, [1.0, 0.3, 1.0], [0.0, 1.0, 0.0]);
    assert!(message.contains(expected), "{message}");
}

#[test]
fn a_combination_without_a_mass_is_named() {
    let (_, message) = refused(&OneMass, [1.0, 0.3, 0.0], [0.0, 1.0, 0.0]);
    let expected = "a combination of the coordinates `x` and `y` has no mass and no row determines it";
    assert!(message.contains(expected), "{message}");
    assert!(!message.contains("`z`"), "{message}");
    let message = fails(&OneMass, [1.0, 0.3, 0.0], [0.0, 1.0, 0.0]);
    assert!(message.contains(expected), "{message}");
}

#[test]
fn constraints_that_repeat_each_other_are_named() {
    // the rods turn
    let (q0, v0) = ([0.0, 0.5, 0.6, 1.3, 0.0], [0.8, -0.6, 0.0, 0.0, 0.4]);
    let mut flow = Flow::new(&TWO_RODS, 0.1, Start::paper(q0, v0)).unwrap();
    let RunError::Step(error) = flow.until(10.0).unwrap_err().error else {
        panic!("no step failed")
    };
    let deficiency = error.details().deficiency.as_ref().unwrap();
    assert_eq!(
        deficiency.rows,
        [DependentRow::Holonomic(1), DependentRow::Holonomic(2)]
    );
    let message = error.to_string();
    let expected = "holonomic constraints 2 and 3 depend on each other here";
    assert!(message.contains(expected), "{message}");
    assert!(message.contains("leave out the one that repeats"), "{message}");
    let (_, message) = refused(&TWO_RODS, q0, v0);
    assert!(message.contains(expected), "{message}");
}

#[test]
fn a_constraint_without_a_derivative_is_named() {
    let (_, message) = refused(&Square, [0.0, 0.3], [0.0, 1.0]);
    assert!(
        message.contains("holonomic constraint 1 says nothing about the acceleration here"),
        "{message}"
    );
    assert!(message.contains("derivatives are zero"), "{message}");
}

/// Where the force has no power, a rate of decrease that is not zero is no factor: the two are told apart by what is left of the row.
#[test]
fn a_row_that_no_acceleration_meets_is_no_factor() {
    let (own, with_power) = (Falling { own: 1.0, power: 0.0 }, Falling { own: 0.0, power: 1.0 });
    // at rest, and where the mass moves alone
    for v0 in [[0.0, 0.0], [0.3, 0.0]] {
        let (error, message) = refused(&own, [0.0, 1.0], v0);
        assert!(
            matches!(&error, SetupError::Acceleration { deficiency: Some(deficiency), .. } if deficiency.unmet),
            "{error:?}"
        );
        assert!(message.contains("no acceleration meets"), "{message}");
        assert!(message.contains("start with another velocity"), "{message}");
        assert!(!message.contains("divide"), "{message}");
    }
    // as it advises
    Flow::new(&own, 0.1, Start::second_order([0.0, 1.0], [0.0, 0.4])).unwrap();
    for (v0, is_factor) in [([0.0, 0.0], true), ([0.3, 0.0], false)] {
        let (_, message) = refused(&with_power, [0.0, 1.0], v0);
        assert!(!message.contains("no acceleration meets"), "{message}");
        assert_eq!(message.contains("divide it out"), is_factor, "{message}");
    }
    // in equilibrium the energy is zero, and so is the row
    let (_, message) = refused(&own, [0.7, 0.0], [0.0, 0.0]);
    assert!(message.contains("divide it out"), "{message}");
}

declared! {
    /// A particle with a constraint between the sizes of two velocities, whose gradient vanishes at rest (Appell and Hamel), in a frame that moves along.
    struct AppellHamel { drift: f64 }
    coordinates(x, y, z);
    let v = [dot(x) - drift, dot(y), dot(z)];
    lagrangian = (v[0].powi(2) + v[1].powi(2) + v[2].powi(2)) / 2 - 0.981 * z - 0.3 * (x - drift * t) * y;
    nonholonomic = v[0].powi(2) + v[1].powi(2) - v[2].powi(2) / 4;
}

declared! {
    /// A particle whose speed in the plane is constant: its gradient vanishes at rest, where the row does not hold.
    struct Speed;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
    nonholonomic = dot(x).powi(2) + dot(y).powi(2) - 1;
}

/// A smaller step does not help where the gradient of a constraint on velocities vanishes.
#[test]
fn a_constraint_on_velocities_without_a_gradient_is_named() {
    for drift in [0.0, 0.7] {
        for h in [0.01, 0.001] {
            let start = Start::second_order([0.0, 0.0, 0.0], [0.3 + drift, 0.4, 1.0]);
            let error = Flow::new(&AppellHamel { drift }, h, start)
                .unwrap()
                .until(3.0)
                .unwrap_err()
                .error;
            let step = error.failed_step().unwrap();
            assert_eq!(step.without_gradient, Some(DependentRow::Nonholonomic(0)));
            let message = error.to_string();
            assert!(
                message.contains("nonholonomic constraint 1 has no gradient")
                    && message.contains("a smaller h does not help"),
                "{message}"
            );
            assert!(!message.contains("try a smaller h"), "{message}");
        }
    }
    let mut flow = Flow::new(&Speed, 0.01, Start::second_order([0.0, 0.0], [1.0, 0.0])).unwrap();
    flow.until(3.0).unwrap();
}

/// Where only the guess is singular, the message advises `Start::near_acceleration`.
#[test]
fn two_accelerations_are_no_dependent_rows() {
    let (error, message) = refused(&Squared, [0.0, 0.0], [1.0, 0.3]);
    assert!(message.contains("Start::near_acceleration"), "{message}");
    assert!(
        matches!(&error, SetupError::Acceleration { deficiency: Some(deficiency), .. } if deficiency.at_guess_alone),
        "{error:?}"
    );
}

/// The error of an ambiguous step contains the distance of both solutions, and does not call distant
/// solutions close.
#[test]
fn two_solutions_are_told_with_their_distance() {
    let mut flow = Flow::new(&Either { drift: 0.8 }, 0.5, Start::second_order([1.8], [1.36])).unwrap();
    let error = flow.until(8.0).unwrap_err().error;
    assert_eq!(error.step_failure(), Some(StepFailure::AmbiguousRoot));
    let step = error.failed_step().unwrap();
    let apart = (step.q2[0] - step.other[0]).abs();
    let leg = (step.q1[0] - step.q0[0]).abs();
    assert!(apart > 5.0 * leg, "{apart} is many legs of {leg}");
    let message = error.to_string();
    for part in [
        "there are two solutions, and the nodes before do not decide which of them continues the motion"
            .to_owned(),
        format!("farthest apart in `x`, by {apart:.1e}"),
    ] {
        assert!(message.contains(&part), "no {part:?} in: {message}");
    }
    assert!(!message.contains("close"), "{message}");
}

/// Two roots of a constraint of power that come close to each other, where nothing can be divided out: the error names a smaller step among what
/// to try, and it helps.
#[test]
fn a_smaller_step_is_among_what_two_solutions_ask_for() {
    let text = dsocs_core::text::Text::parse(
        "two",
        "parameters { delta = 1e-6 } coordinates(x, th); lagrangian = dot(x).powi(2) / 2 + dot(th).powi(2) / 2; \
         let V = dot(x).powi(2) / 2; kinematic = dot(V) + 0.25 * (1 - delta) * t.sin(); constraint_forces = [(1, 0)];",
    )
    .unwrap();
    let start = dsocs_core::AnyStart::second_order(&[0.0, 0.5], &[1.0, 0.0]);
    let run = |h: f64| {
        let mut flow = dsocs_core::AnyFlow::new(&text.system, h, &start).unwrap();
        flow.run_mut().to(5.0)
    };
    let error = run(0.01).unwrap_err();
    assert_eq!(error.step_failure(), Some(StepFailure::AmbiguousRoot));
    assert!(error.to_string().contains("try a smaller h"), "{error}");
    run(0.001).unwrap();
}

declared! {
    /// A mass on a cone, without a slope at the tip.
    struct Cone;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - (x.powi(2) + y.powi(2)).sqrt();
}

declared! {
    /// A squared law.
    struct SquaredLaw;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (ddot(x) + x).powi(2);
    constraint_forces = [(1,)];
}

declared! {
    /// A mass that vanishes on the way.
    struct Vanishing;
    coordinates(x, y);
    lagrangian = (x.powi(2) * dot(x).powi(2) + dot(y).powi(2)) / 2 + x * y / 10 - x;
}

#[test]
fn advice_is_about_what_is_so() {
    let tip = Start::second_order([0.0; 2], [0.0; 2]);
    let error = Flow::new(&Cone, 0.01, tip).map(|_| ()).unwrap_err();
    let SetupError::Acceleration {
        at_any_velocity: true,
        ..
    } = error
    else {
        panic!("{error:?}");
    };
    let message = error.to_string();
    assert!(
        message.contains("the divisor `x.powi(2) + y.powi(2)` is zero there (x = 0, y = 0)"),
        "{message}"
    );
    assert!(
        !message.contains("start with a velocity") && message.contains("begin elsewhere"),
        "{message}"
    );
    // as the message advises: at another place; a velocity does not help
    assert!(Flow::new(&Cone, 0.01, Start::second_order([0.0; 2], [1.0, 0.3])).is_err());
    Flow::new(&Cone, 0.01, Start::second_order([0.1, 0.0], [0.0; 2])).unwrap();

    for v in [0.0, 0.1] {
        let error = Flow::new(&SquaredLaw, 0.01, Start::second_order([1.0], [v]))
            .map(|_| ())
            .unwrap_err();
        let SetupError::Acceleration { cause, .. } = &error else {
            panic!("{error:?}");
        };
        assert!(
            cause.is_at_multiple_root() && error.to_string().contains("write the root itself"),
            "{error}"
        );
    }

    let start = Start::second_order([1.0, 0.0], [0.0; 2]);
    let error = Flow::new(&Vanishing, 0.01, start)
        .unwrap()
        .to(3.0)
        .unwrap_err()
        .to_string();
    assert!(!error.contains("constraint forces"), "{error}");
}

declared! {
    /// A smooth switch of a force, whose exponential overflows long before the switch.
    struct Switched { steep: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = 1.0 / (1.0 + (-steep * (t - 1.0)).exp());
}

declared! {
    /// The force as the message advises to write it.
    struct Bounded { steep: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = (1 + (steep * (t - 1.0) / 2).tanh()) / 2;
}

/// A switch whose exponential overflows is refused with a bounded formula; with this formula the velocity at
/// t = 2 is exact to 1e-6.
#[test]
fn what_overflows_though_its_quotient_does_not_is_written_otherwise() {
    let start = Start::second_order([0.0], [0.0]);
    let steep = 1e3;
    let error = TaylorFlow::new(&Switched { steep }, start, Tolerance::relative(1e-9)).unwrap_err();
    let message = error.to_string();
    assert!(message.contains("(1 + (u / 2).tanh()) / 2"), "{message}");
    let bounded = Bounded { steep };
    let mut flow = TaylorFlow::new(&bounded, start, Tolerance::relative(1e-9)).unwrap();
    let end = flow.to(2.0).unwrap();
    assert!((end.v[0] - 1.0).abs() < 1e-6, "{end:?}");
}
