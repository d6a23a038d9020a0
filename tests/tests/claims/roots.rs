//! A constraint with two solutions in every step: both are found on request. A run follows its own solution,
//! or ends with the error that it cannot decide; it never changes to the other one without an error.

use dsocs_core::text::Text;
use dsocs_core::{Guess, RunError, Start, StepFailure, Stepper, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::short_or_long;
use dsocs_tests::text::{Flow, TaylorFlow};

use super::draws;

declared! {
    /// An oscillator, or a uniform motion: `(v − drift)(a + x) = 0`.
    ///
    /// With the second difference `e` the discrete solutions are `e = −h² x₁` and `e = 2(h drift − d)`.
    pub(crate) struct Either {
        pub(crate) drift: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (dot(x) - drift) * (ddot(x) + x);
    constraint_forces = [(1,)];
}

const H: f64 = 0.1;

/// The next nodes of the oscillator and of the uniform motion.
fn solutions(system: &Either, flow: &dsocs_core::Flow<'_, 1>) -> [f64; 2] {
    let leg = flow.leg();
    let (q, d) = (leg.q[0], leg.d[0]);
    [q + (d - H * H * q), q + (2.0 * H * system.drift - d)]
}

#[test]
fn both_solutions_are_found_on_request() {
    let system = Either { drift: 0.3 };
    let mut flow = Flow::new(&system, H, Start::second_order([1.0], [0.0])).unwrap();
    for _ in 0..200 {
        let wanted = solutions(&system, &flow);
        let roots = flow.roots().unwrap();
        let other = roots.other.expect("the other solution");
        let near = |x: f64, y: f64| (x - y).abs() <= 1e-9;
        let found = roots.found[0];
        assert!(
            (near(found, wanted[0]) && near(other[0], wanted[1]))
                || (near(found, wanted[1]) && near(other[0], wanted[0])),
            "{roots:?} {wanted:?}"
        );
        let report = flow.advance_to(&[wanted[0]]).unwrap();
        assert_eq!(report.guess, Guess::Given);
        assert!((flow.position()[0] - wanted[0]).abs() < 1e-12);
    }
}

#[test]
fn a_run_follows_its_motion_or_says_that_it_cannot_tell() {
    // the velocity of the oscillator passes through the drift twice a period
    for drift in [0.3, 0.71, -0.5, 0.99] {
        let system = Either { drift };
        let mut flow = Flow::new(&system, H, Start::second_order([1.0], [0.0])).unwrap();
        let (mut refused, mut crossed) = (0, 0);
        let mut side = true;
        for _ in 0..5000 {
            let [oscillator, uniform] = solutions(&system, &flow);
            crossed += u32::from((oscillator > uniform) != side);
            side = oscillator > uniform;
            match flow.advance() {
                Ok(_) => {
                    let found = flow.position()[0];
                    assert!(
                        (found - oscillator).abs() <= 0.5 * (oscillator - uniform).abs() + 1e-8,
                        "step {}: {found}, not {oscillator}; the other is {uniform}",
                        flow.index()
                    );
                }
                Err(error) => {
                    let details = error.failed_step().unwrap();
                    assert_eq!(details.cause.reason, StepFailure::AmbiguousRoot);
                    let pair = [details.q2[0], details.other[0]];
                    let near = |wanted: f64| pair.iter().any(|q| (q - wanted).abs() < 1e-8);
                    assert!(near(oscillator) && near(uniform), "{pair:?}");
                    refused += 1;
                    flow.advance_to(&[oscillator]).unwrap();
                }
            }
        }
        println!("drift {drift}: {crossed} crossings, {refused} steps refused");
        assert!(crossed > 100 && refused < 2 * crossed);
    }
}

#[test]
fn the_error_tells_both_solutions_and_what_to_do() {
    // near its largest velocity the oscillator stays close to the uniform motion
    let system = Either { drift: 0.99 };
    let start = Start::second_order([1.0], [0.0]);
    let mut flow = Flow::new(&system, H, start).unwrap();
    match flow.until(500.0) {
        Err(failure) => {
            let RunError::Step(error) = &failure.error else {
                panic!("{failure:?}")
            };
            let message = error.to_string();
            for part in [
                "no unique solution",
                " or [",
                "branch = divide(factor)",
                "advance_to",
                "condition",
            ] {
                assert!(message.contains(part), "no {part:?} in: {message}");
            }
            assert!(!failure.trajectory.is_empty(), "what was computed is kept");
        }
        Ok(_) => panic!("two roots, and never a refusal"),
    }
}

#[test]
fn without_a_past_the_continuous_acceleration_tells() {
    // both roots are a hundredth from a straight line, and the continuous system has one acceleration
    let system = Either { drift: 0.31 };
    let mut flow = Flow::new(&system, H, Start::nodes([0.97], [1.0])).unwrap();
    let [oscillator, uniform] = solutions(&system, &flow);
    flow.advance().unwrap();
    assert!((oscillator - uniform).abs() > 1e-3);
    assert!((flow.position()[0] - oscillator).abs() < 1e-12);
}

/// Starts at which the oscillator's velocity at the second node is the drift, to the last bit: the row does
/// not determine the acceleration there, and a straight line is a root to which no update leads.
#[test]
fn a_start_whose_second_node_is_on_the_other_motion() {
    let (mut runs, mut on_it) = (0, 0_usize);
    let every = short_or_long(4, 1);
    for place in (-20..=20).step_by(every) {
        for speed in -20..=20 {
            for drift in [0.3, -0.3, 0.5, 0.8, -0.1, 0.0] {
                for h in [0.2, H, 0.05] {
                    let (x, v) = (f64::from(place) * 0.1, f64::from(speed) * 0.05);
                    runs += 1;
                    on_it += usize::from(follows(&Either { drift }, h, Start::second_order([x], [v])));
                }
            }
        }
    }
    println!("{runs} runs, {on_it} of which begin on the other motion");
    assert!(on_it > 30 / every);
    // with nodes alone, such a start has no acceleration to decide by
    let mut flow = Flow::new(&Either { drift: 0.25 }, 0.125, Start::nodes([-1.03125], [-1.0])).unwrap();
    let error = flow.advance().unwrap_err();
    assert_eq!(
        error.failed_step().unwrap().cause.reason,
        StepFailure::AmbiguousRoot
    );
}

/// Checks a run against the oscillator's solutions; returns whether its start makes the row vanish for every
/// acceleration.
fn follows(system: &Either, h: f64, start: Start<1>) -> bool {
    // on the drift the start has no acceleration
    let Ok(mut flow) = Flow::new(system, h, start) else {
        return false;
    };
    let on_it = (flow.leg().d[0] / h).to_bits() == system.drift.to_bits();
    for _ in 0..40 {
        let leg = flow.leg();
        let (q, d) = (leg.q[0], leg.d[0]);
        let [oscillator, uniform] = [-h * h * q, 2.0 * (h * system.drift - d)];
        if flow.advance().is_err() {
            flow.advance_to(&[q + (d + oscillator)]).unwrap();
            continue;
        }
        let found = flow.position()[0] - q - d;
        let apart = (oscillator - uniform).abs();
        assert!(
            (found - oscillator).abs() <= 0.5 * apart || apart < 1e-6 * (d.abs() + oscillator.abs()),
            "{start:?}, drift {}, h = {h}, step {}: {found}, not {oscillator}; the other is {uniform}",
            system.drift,
            flow.index() - 1
        );
    }
    on_it
}

declared! {
    /// The magnitude of the acceleration is given, as on a fairground ride.
    struct Felt {}
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
    kinematic = ddot(x).powi(2) + ddot(y).powi(2) - 12_f64.powi(2);
    constraint_forces = [(1, 0)];
}

/// The first step continues with the solution that the start found near the given acceleration, however far
/// from it this solution is: for guesses from -1000 to 1000 m/s² the position after 1 s is exact to 1e-9.
#[test]
fn what_is_near_to_a_solution_need_not_be_it() {
    let square = 12.0_f64.powi(2) - 9.81_f64.powi(2);
    for said in [-1e3, -20.0, -1.0, 0.5, 3.0, 1e3] {
        let start = Start::second_order([0.0; 2], [0.0; 2]).near_acceleration([said, 0.0]);
        let mut flow = Flow::new(&Felt {}, 0.01, start).unwrap();
        let end = flow.to(1.0).unwrap();
        let expected = 0.5 * square.sqrt().copysign(said);
        assert!((end.q[0] - expected).abs() < 1e-9, "{said}: {end:?}");
    }
}

/// Two accelerations that a row allows, `-w² x` and `-f`, are the same at one place: a motion to a tolerance keeps to its own, wherever
/// it ends. It begins at rest.
#[test]
fn a_series_passes_the_place_where_two_accelerations_cross() {
    draws::test(80, 33, (1.1..2.5, 0.5..2.0, 0.1..1.5), &|(q0, w, beyond): (
        f64,
        f64,
        f64,
    )| {
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; kinematic = (ddot(x) + {w:?} * {w:?} * x) * (ddot(x) + {w:?} * {w:?}); \
             constraint_forces = [(1,)];"
        );
        let text = Text::parse("crossing", &text).unwrap();
        let start = Start::second_order([q0], [0.0]).near_acceleration([-w * w * q0]);
        let until = ((1.0 / q0).acos() + beyond) / w;
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
            flow.to(until).unwrap();
            let error = (flow.node().q[0] - q0 * (w * until).cos()).abs();
            assert!(
                error < 100.0 * tolerance.max(1e-11),
                "{q0} {w} {until} {tolerance}: {error}"
            );
        }
        Ok(())
    });
}

/// At zero acceleration a row need not depend on the acceleration: series begin at the root that steps find.
#[test]
fn a_series_begins_where_a_row_does_not_depend_on_a_zero_acceleration() {
    draws::test(40, 34, (0.5..3.0, 0.2..0.9), &|(size, until): (f64, f64)| {
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; kinematic = ddot(x).powi(3) + {:?} * (1 - t); constraint_forces = [(1,)];",
            size.powi(3)
        );
        let text = Text::parse("cubic", &text).unwrap();
        let start = Start::second_order([0.0], [0.0]);
        let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(1e-12)).unwrap();
        flow.to(until).unwrap();
        let exact = -size * 0.75 * (1.0 - (1.0 - until).powf(4.0 / 3.0));
        assert!((flow.node().v[0] - exact).abs() < 1e-10, "{size} {until}");
        Ok(())
    });
}
