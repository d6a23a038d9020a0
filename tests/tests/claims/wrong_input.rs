//! Wrong input gives an error that names the wrong value, and a failed run keeps its nodes.

use dsocs_core::{Real, RunError, SetupError, Start, StepFailure, Stepper};
use dsocs_systems::{Constant, Curvature, CurvedParticle, InertiaWheelPendulum};
use dsocs_tests::declared;
use dsocs_tests::text::{Flow, System};

const GOOD: Start<2> = Start::paper([0.0, 0.0], [1.0, 1.0]);

fn setup(h: f64, start: Start<2>) -> SetupError {
    Flow::new(&CurvedParticle::default(), h, start)
        .map(|_| ())
        .unwrap_err()
}

/// Steps that are zero or not finite are refused, with their value in the message.
#[test]
fn a_step_that_is_none() {
    for h in [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = setup(h, GOOD);
        assert!(matches!(error, SetupError::Step { .. }), "{error:?}");
        assert!(error.to_string().contains(&format!("h = {h}")), "{error}");
    }
}

#[test]
fn a_step_whose_square_is_none() {
    for h in [1e-200, -1e-170, 1e200] {
        let error = setup(h, GOOD);
        assert!(
            matches!(error, SetupError::StepRange { h: found } if found.to_bits() == h.to_bits()),
            "{error:?}"
        );
    }
}

#[test]
fn a_start_that_is_not_finite() {
    for bad in [f64::NAN, f64::INFINITY] {
        for (start, vector, coordinate) in [
            (Start::paper([bad, 0.0], [1.0, 1.0]), "q0", "x"),
            (Start::paper([0.0, bad], [1.0, 1.0]), "q0", "y"),
            (Start::paper([0.0, 0.0], [1.0, bad]), "v0", "y"),
            (Start::second_order([0.0, 0.0], [bad, 1.0]), "v0", "x"),
            (Start::nodes([0.0, 0.0], [0.1, bad]), "q1", "y"),
        ] {
            let error = setup(0.1, start);
            assert!(
                matches!(&error, SetupError::Start { vector: v, coordinate: c, .. } if *v == vector && c == coordinate),
                "{error:?}"
            );
            assert!(
                error.to_string().contains(coordinate) && error.to_string().contains(vector),
                "{error}"
            );
        }
        assert!(matches!(setup(0.1, GOOD.at(bad)), SetupError::StartTime { .. }));
    }
}

#[test]
fn a_parameter_that_is_not_finite() {
    let pendulum = InertiaWheelPendulum {
        rho: f64::NAN,
        ..InertiaWheelPendulum::default()
    };
    let error = Flow::new(&pendulum, 0.1, GOOD).map(|_| ()).unwrap_err();
    assert!(
        matches!(&error, SetupError::Parameter { name, .. } if name == "rho"),
        "{error:?}"
    );
    assert!(
        error.to_string().contains("rho") && error.to_string().contains("NaN"),
        "{error}"
    );
}

#[test]
fn a_particle_at_rest() {
    let rest = Start::second_order([0.0, 0.0], [0.0, 0.0]);
    let error = setup(0.1, rest);
    assert!(matches!(&error, SetupError::Acceleration { .. }), "{error:?}");
    assert!(error.to_string().contains("at rest"), "{error}");

    let particle = CurvedParticle::default();
    let mut flow = Flow::new(&particle, 0.1, Start::paper([0.0, 0.0], [0.0, 0.0])).unwrap();
    let failure = flow.until(1.0).unwrap_err();
    let RunError::Step(step) = &failure.error else {
        panic!("{failure:?}")
    };
    let details = step.details();
    assert_eq!((details.index, details.time, details.h), (1, 0.1, 0.1));
    assert_eq!((&details.q0, &details.q1), (&vec![0.0, 0.0], &vec![0.0, 0.0]));
    assert_eq!(details.cause.reason, StepFailure::Degenerate);
    assert_eq!(failure.trajectory.len(), 1, "node 0 is kept");
    let message = failure.to_string();
    for part in ["step 1", "t = 0.1", "at rest", "q0"] {
        assert!(message.contains(part), "no {part:?} in: {message}");
    }
}

/// A curvature that exists for `x < 1` only.
struct Edge;

impl Curvature for Edge {
    fn at<D: Real>(&self, x: D, _: D) -> D {
        (-x + 1.0).sqrt() * 0.1
    }
}

#[test]
fn a_run_that_fails_keeps_its_nodes() {
    let particle = CurvedParticle {
        mass: 1.0,
        curvature: Edge,
    };
    let mut flow = Flow::new(&particle, 0.1, Start::paper([0.0, 0.0], [1.0, 0.0])).unwrap();
    let failure = flow.until(5.0).unwrap_err();
    let RunError::Step(step) = &failure.error else {
        panic!("{failure:?}")
    };
    let details = step.details();
    assert_eq!(details.cause.reason, StepFailure::NotFinite);
    assert!(details.q1[0] > 1.0 && details.q0[0] < 1.0, "{details:?}");
    let nodes = &failure.trajectory.nodes;
    assert_eq!(
        nodes.len() as u64,
        details.index,
        "all nodes before the step's middle one"
    );
    assert!(nodes.iter().all(|node| node.q[0] < 1.0 && node.v[0].is_finite()));
    // as an iterator: the error once, then the end
    let mut flow = Flow::new(&particle, 0.1, Start::paper([0.0, 0.0], [1.0, 0.0])).unwrap();
    assert_eq!(flow.by_ref().filter(Result::is_err).count(), 1);
    assert!(flow.next().is_none());
}

#[test]
fn a_curvature_that_is_not_a_number() {
    let particle = CurvedParticle {
        mass: 1.0,
        curvature: Constant(f64::NAN),
    };
    assert!(matches!(
        Flow::new(&particle, 0.1, Start::second_order([0.0, 0.0], [1.0, 1.0])).map(|_| ()),
        Err(SetupError::Acceleration { .. })
    ));
    let mut flow = Flow::new(&particle, 0.1, GOOD).unwrap();
    let error = flow.advance().unwrap_err();
    assert_eq!(error.step_failure(), Some(StepFailure::NotFinite));
    assert_eq!(flow.index(), 1, "the flow stays where it was");
}

/// Legs of the particle cannot turn by more than π, so a chord with a curvature that requires nearly as much is hard,
/// but has a root: `sin(α/2) = K/(1 + √(1 + K²))` with `K = κ s`.
#[test]
fn sharp_turns_have_a_root_and_it_is_found_or_failure_is_admitted() {
    for curvature in [1.0, 10.0, 100.0, 1e4] {
        let particle = CurvedParticle {
            mass: 1.0,
            curvature: Constant(curvature),
        };
        let mut flow = Flow::new(&particle, 0.1, GOOD).unwrap();
        let before = flow.leg().d;
        match flow.advance() {
            Ok(_) => {
                let after = flow.leg().d;
                let k = curvature * before[0].hypot(before[1]);
                let half = (k / (1.0 + 1.0_f64.hypot(k))).asin();
                let turn = (before[0] * after[1] - before[1] * after[0])
                    .atan2(before[0] * after[0] + before[1] * after[1]);
                assert!(
                    (turn - 2.0 * half).abs() < 1e-9,
                    "κ = {curvature}: turned by {turn}, not {}",
                    2.0 * half
                );
            }
            Err(error) => println!("κ = {curvature}: {error}"),
        }
    }
}

declared! {
    /// One mass for two coordinates: there is no factor to divide out.
    struct OneMass;
    coordinates(x, y);
    lagrangian = (dot(x) + dot(y)).powi(2) / 2;
}

declared! {
    /// A constraint after which the other equation determines nothing.
    struct Whole;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = ddot(x) + ddot(y) - 1;
    variational = [(1, 1)];
}

declared! {
    /// The constraint of `Whole`, with a factor that is divided out.
    struct Divided;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = (dot(x) - 5) * (ddot(x) + ddot(y) - 1);
    variational = [(1, 1)];
    branch = divide(dot(x) - 5);
}

/// The message advises to divide out a factor only where a constraint may have one and none is declared.
#[test]
fn advice_is_for_the_system() {
    fn text<S: System<2>>(system: &S) -> String {
        let mut flow = Flow::new(system, 0.1, Start::nodes([0.0, 0.0], [0.1, 0.2])).unwrap();
        let Err(error) = flow.advance() else {
            panic!("{} has a step", system.name())
        };
        let step = error.failed_step().unwrap();
        assert_eq!(step.cause.reason, StepFailure::Singular, "{error}");
        error.to_string()
    }
    let (free, whole, divided) = (text(&OneMass), text(&Whole), text(&Divided));
    for (without, advice) in [(&free, "give it a mass"), (&divided, "repeats another one")] {
        assert!(!without.contains("branch"), "{without}");
        assert!(without.contains(advice), "{without}");
    }
    assert!(whole.contains("branch = divide(factor)"), "{whole}");
}
