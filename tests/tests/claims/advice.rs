//! Error messages name the true cause: a tolerance that is too large is not called a singularity, the message
//! for a system without a constraint on accelerations does not mention a decrease of energy, and for corners
//! of samples another interpolation is advised.

use dsocs_core::prelude::*;
use dsocs_core::{Composition, Samples};
use dsocs_tests::declared;
use dsocs_tests::text::{ComposedFlow, Flow, TaylorFlow};

declared! {
    /// A particle whose path is a circle.
    struct Circle;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - 1;
    variational = [(dot(x), dot(y))];
}

declared! {
    /// A mass that falls into a centre.
    struct Centre;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -1 / x.powi(2);
}

#[test]
fn a_tolerance_that_is_too_large_is_told() {
    let run = |tolerance: f64| {
        let start = Start::second_order([0.0, 0.0], [1.0, 1.0]);
        let mut flow = TaylorFlow::new(&Circle, start, Tolerance::relative(tolerance)).unwrap();
        flow.to(500.0)
    };
    for tolerance in [0.3, 0.03] {
        let error = run(tolerance).unwrap_err().to_string();
        let expected = format!("the tolerance {tolerance:e} is large");
        assert!(error.contains(&expected) && error.contains("1e-9"), "{error}");
        assert!(
            !error.contains("singularity") && !error.contains("too small"),
            "{error}"
        );
    }
    // as it advises
    let node = run(1e-9).unwrap();
    assert!((node.v[0].hypot(node.v[1]) - 2.0_f64.sqrt()).abs() < 1e-6);
    // at a singularity, a small tolerance is not called large
    let fall = |tolerance: f64| {
        let start = Start::second_order([1.0], [0.0]);
        let mut flow = TaylorFlow::new(&Centre, start, Tolerance::relative(tolerance)).unwrap();
        flow.to(3.0).unwrap_err().to_string()
    };
    let error = fall(1e-9);
    assert!(
        error.contains("singularity") && !error.contains("is large"),
        "{error}"
    );
}

declared! {
    /// Dry friction, in which a mass comes to rest.
    struct Dry;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    external_forces = -0.5 * dot(x).signum();
}

declared! {
    /// A mass that vanishes on the way.
    struct Vanishing;
    coordinates(x);
    lagrangian = x.powi(2) * dot(x).powi(2) / 2 - x;
}

declared! {
    /// A motor that takes energy away, fast.
    struct Brake;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    kinematic = dot(dot(x).powi(2) / 2 + x.powi(2) / 2) + 400 * dot(x).powi(2);
    constraint_forces = [(1,)];
    branch = divide(dot(x));
}

#[test]
fn a_composition_speaks_of_constraints_that_there_are() {
    let fails = |result: Result<Node<1>, RunError>| result.unwrap_err().to_string();
    let run = |h: f64, x: f64| {
        let start = Start::second_order([x], [0.0]);
        ComposedFlow::new(&Dry, h, Composition::SUZUKI_4, start)?.to(30.0)
    };
    // where dry friction stops the mass, a composition continues, as the step of order 2 does
    for (h, x) in [(0.01, 1.0), (0.01, 0.1), (0.1, 1.0)] {
        let composed = run(h, x).unwrap();
        let step = Flow::new(&Dry, h, Start::second_order([x], [0.0]))
            .unwrap()
            .to(30.0)
            .unwrap();
        assert!(composed.v[0].abs() < 1e-12 && step.v[0].abs() < 1e-12);
        assert!((composed.q[0] - step.q[0]).abs() < h * h, "{h} {x}");
    }
    let start = Start::second_order([1.0], [0.0]);
    let error = fails(
        ComposedFlow::new(&Vanishing, 0.01, Composition::SUZUKI_4, start)
            .unwrap()
            .to(30.0),
    );
    assert!(
        !error.contains("energy") && !error.contains("constraint such"),
        "{error}"
    );
    let start = Start::second_order([1.0], [-0.5]);
    let error = fails(
        ComposedFlow::new(&Brake, 0.1, Composition::SUZUKI_4, start)
            .unwrap()
            .to(3.0),
    );
    assert!(
        error.contains("a constraint such as a decrease of energy"),
        "{error}"
    );
}

/// A mass on a rope that a winch winds.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
    holonomic = x.powi(2) + y.powi(2) - winch.at(t).powi(2);
}]
struct Rope {
    winch: Samples,
}

/// A free cart with a pendulum whose length the winch changes, in the pendulum's angle.
#[dsocs {
    coordinates(cart, theta);
    let x = cart + winch.at(t) * theta.sin();
    let y = -winch.at(t) * theta.cos();
    lagrangian = (dot(cart).powi(2) + dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
}]
struct Cable {
    winch: Samples,
}

#[test]
fn corners_of_samples_ask_for_a_smooth_interpolation() {
    let samples = [(0.0, 1.0), (1.0, 1.2), (2.0, 1.0), (3.0, 1.1)];
    let tolerance = Tolerance::relative(1e-9);
    let hangs = Start::second_order([0.0, -1.0], [0.0, 0.0]).projected();
    let moves = Start::second_order([0.0, 1.0], [0.0, -0.2]);
    let rope = |winch: Samples| TaylorFlow::new(&Rope { winch }, hangs, tolerance)?.to(2.5);
    let cable = |winch: Samples| TaylorFlow::new(&Cable { winch }, moves, tolerance)?.to(2.5);
    let corners = || Samples::linear(samples).unwrap();
    for error in [rope(corners()).unwrap_err(), cable(corners()).unwrap_err()] {
        let error = error.to_string();
        assert!(
            error.contains("`winch.at` has a corner or a jump there"),
            "{error}"
        );
        assert!(
            error.contains("Use a smooth interpolation") && error.contains("`Samples::monotone`"),
            "{error}"
        );
        assert!(
            !error.contains("a comparison in") && !error.contains("energy is lost"),
            "{error}"
        );
        assert!(error.len() < 560, "{}: {error}", error.len());
    }
    // as it advises
    for smooth in [
        Samples::monotone(samples).unwrap(),
        Samples::cubic(samples).unwrap(),
    ] {
        let length = smooth.at(2.5);
        let node = rope(smooth.clone()).unwrap();
        assert!((node.q[0].hypot(node.q[1]) - length).abs() < 1e-12);
        cable(smooth).unwrap();
    }
}

/// With any interpolation, a table that ends with a slope has its corner at the last sample: the error says so, and its advice helps.
#[test]
fn samples_that_end_with_a_slope_have_a_corner_there() {
    let rising = [(0.0, 1.0), (0.5, 1.1), (1.0, 1.4)];
    let level = [
        (0.0, 1.0),
        (0.5, 1.1),
        (1.0, 1.4),
        (1.25, 1.5),
        (1.5, 1.5),
        (1.75, 1.5),
    ];
    let hangs = Start::second_order([0.0, -1.0], [0.0, 0.0]).projected();
    let rope = |winch: Samples| TaylorFlow::new(&Rope { winch }, hangs, Tolerance::relative(1e-9))?.to(2.5);
    for error in
        [Samples::monotone(rising), Samples::cubic(rising)].map(|winch| rope(winch.unwrap()).unwrap_err())
    {
        let error = error.to_string();
        assert!(
            error.contains("at t = 1") && error.contains("at the end of a table: add level samples"),
            "{error}"
        );
        assert!(error.len() < 660, "{}: {error}", error.len());
    }
    rope(Samples::monotone(level).unwrap()).unwrap();
}

/// A potential whose exponential overflows although its quotient does not: the error names the overflowing
/// part, and the bounded expression in its place can be run.
#[test]
fn what_overflows_is_told_with_what_to_write_instead() {
    use dsocs_core::text::Text;
    let start = Start::second_order([-2.0], [1.0]);
    for (expression, large) in [
        ("1 / (300 * x).cosh()", "`(x * 300).cosh()`"),
        ("1 / (1 + (-300 * x).exp())", ".exp()`"),
    ] {
        let text = format!("coordinates(x); lagrangian = dot(x).powi(2) / 2 - {expression};");
        let system = Text::parse("well", &text).unwrap().system;
        let any = dsocs_core::AnyStart::from(start);
        let tolerance = Tolerance::relative(1e-9);
        let error = dsocs_core::taylor::AnyTaylorFlow::of_tape(&system, &any, tolerance).unwrap_err();
        let error = error.to_string();
        assert!(
            error.contains(large) && error.contains("its derivatives overflow"),
            "{error}"
        );
        assert!(error.contains("write what is bounded without it"), "{error}");
        // the expression that the message advises can be run
        let bounded = match expression {
            "1 / (300 * x).cosh()" => "2 * (-(300 * x).abs()).exp() / (1 + (-2 * (300 * x).abs()).exp())",
            _ => "(1 + (150 * x).tanh()) / 2",
        };
        let text = format!("coordinates(x); lagrangian = dot(x).powi(2) / 2 - {bounded};");
        let system = Text::parse("well", &text).unwrap().system;
        let mut flow = dsocs_core::taylor::AnyTaylorFlow::of_tape(&system, &any, tolerance).unwrap();
        let run: &mut dyn dsocs_core::Run = &mut flow;
        run.to(1.0).unwrap();
    }
}

#[test]
fn at_a_divisor_that_vanishes_no_smaller_step_is_advised() {
    use dsocs_core::text::Text;
    let text = "coordinates(x); lagrangian = (1 - t).sqrt() * dot(x).powi(2) / 2 - x;";
    let system = Text::parse("rocket", text).unwrap().system;
    let start = Start::second_order([0.0], [0.0]);
    let mut flow = dsocs_core::Flow::<1>::of(&system, 0.01, start).unwrap();
    let error = flow.to(2.0).unwrap_err().to_string();
    assert!(error.contains("the divisor `1 - t` is zero there"), "{error}");
    assert!(
        error.contains("the motion ends here") && !error.contains("smaller h"),
        "{error}"
    );
}
