//! Equilibria are found from guesses, distinguished from each other, and refused where there are none.

use core::f64::consts::PI;

use dsocs_core::linear::{EquilibriumError, EquilibriumSearch, LinearizationError, Stability};
use dsocs_tests::text::parsed;

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (x, y) in found.iter().zip(expected) {
        assert!((x - y).abs() < 1e-12 * (1.0 + y.abs()), "{found:?} {expected:?}");
    }
}

const DOUBLE_PENDULUM: &str = "
    parameters { gravity = 9.81, shoulder = 0.0, elbow = 0.0 }
    coordinates(a, b);
    lagrangian = dot(a).powi(2) + dot(b).powi(2) / 2 + (a - b).cos() * dot(a) * dot(b) + gravity * (2 * a.cos() + b.cos());
    external_forces = (shoulder - elbow, elbow);
";

#[test]
fn several_guesses_lead_to_several_equilibria() {
    let system = parsed(DOUBLE_PENDULUM);
    let guesses = [
        [0.2, -0.3],
        [3.0, 0.1],
        [-0.1, 3.3],
        [3.2, 3.0],
        [0.1, 0.1],
        [6.2, 0.1],
        [0.0, 0.0],
    ];
    let found = EquilibriumSearch::new(&system).near_all(guesses).unwrap();
    let places: Vec<usize> = found
        .of_guess
        .iter()
        .map(|place| *place.as_ref().unwrap())
        .collect();
    // angles that differ by a full turn are different equilibria
    assert_eq!(places, [0, 1, 2, 3, 0, 4, 0]);
    for (found, expected) in
        found
            .equilibria
            .iter()
            .zip([[0.0, 0.0], [PI, 0.0], [0.0, PI], [PI, PI], [2.0 * PI, 0.0]])
    {
        assert_close(&found.q, &expected);
        assert!(found.is_isolated() && found.force.iter().all(|force| force.abs() < 1e-13));
    }
    // below: ω² = (2 ± √2) g; above the same with the other sign
    let expected: Vec<f64> = [-1.0, 1.0]
        .iter()
        .map(|sign| ((2.0 + sign * 2.0_f64.sqrt()) * 9.81).sqrt())
        .collect();
    let below = found.equilibria[0].eigenvalues().unwrap();
    assert!(below.iter().all(|[re, _]| re.abs() < 1e-13));
    assert_close(
        &below.iter().map(|[_, im]| *im).collect::<Vec<_>>(),
        &[expected[1], -expected[1], expected[0], -expected[0]],
    );
    let above = found.equilibria[3].eigenvalues().unwrap();
    assert_close(
        &above.iter().map(|[re, _]| *re).collect::<Vec<_>>(),
        &[expected[1], expected[0], -expected[0], -expected[1]],
    );
    let stability: Vec<Stability> = found
        .equilibria
        .iter()
        .map(|found| found.stability().unwrap())
        .collect();
    assert_eq!(stability[..2], [Stability::Undecided, Stability::Unstable]);
}

#[test]
fn free_inputs_hold_a_position() {
    let system = parsed(DOUBLE_PENDULUM);
    let found = EquilibriumSearch::new(&system)
        .held(["a", "b"])
        .free(["shoulder", "elbow"])
        .near([0.5, -0.7])
        .unwrap();
    // the torques against gravity: 2 g sin a and g sin b, the elbow's on both
    let elbow = 9.81 * (-0.7_f64).sin();
    assert_close(&found.q, &[0.5, -0.7]);
    assert_close(
        &found.parameters,
        &[9.81, 2.0 * 9.81 * 0.5_f64.sin() + elbow, elbow],
    );
    assert!(found.is_isolated());
    // with one of the two, one angle follows: here elbow = 0, so b hangs
    let found = EquilibriumSearch::new(&system)
        .held(["a"])
        .free(["shoulder"])
        .near([0.5, 0.2])
        .unwrap();
    assert_close(&found.q, &[0.5, 0.0]);
    // with nothing held, equilibria form a continuum: the one nearest to the guess is found
    let found = EquilibriumSearch::new(&system)
        .free(["shoulder", "elbow"])
        .near([0.5, 0.2])
        .unwrap();
    assert_eq!((found.directions.len(), found.directions[0].len()), (2, 4));
    assert!(found.to_string().contains("one of a continuum"));
}

#[test]
fn a_continuum_is_told_and_its_members_are_one() {
    let cart = parsed(
        "coordinates(x, theta);
         lagrangian = dot(x).powi(2) + theta.cos() * dot(x) * dot(theta) + dot(theta).powi(2) / 2 - theta.cos();",
    );
    let found = EquilibriumSearch::new(&cart)
        .near_all([[0.0, 0.1], [5.0, -0.1], [1.0, 3.0]])
        .unwrap();
    assert_eq!(found.equilibria.len(), 2);
    assert_close(&found.equilibria[0].q, &[0.0, 0.0]);
    assert_eq!(found.equilibria[0].directions, [[1.0, 0.0]]);
    assert_eq!(found.of_guess, [Ok(0), Ok(0), Ok(1)]);
    // a ring of equilibria, on which the nearest to the guess is found
    let ring = parsed(
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - (x.powi(2) + y.powi(2) - 1).powi(2);",
    );
    let found = EquilibriumSearch::new(&ring).near([1.5, 2.0]).unwrap();
    assert_close(
        &[found.q[0].hypot(found.q[1]), found.q[1] / found.q[0]],
        &[1.0, 4.0 / 3.0],
    );
    assert_eq!(found.directions.len(), 1);
    assert_close(
        &[(found.directions[0][0] * found.q[0] + found.directions[0][1] * found.q[1]).abs()],
        &[0.0],
    );
    // a sleigh has an equilibrium at every place
    let sleigh = parsed(
        "coordinates(x, y, theta);
         lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(theta).powi(2)) / 2;
         nonholonomic = dot(y) * theta.cos() - dot(x) * theta.sin();",
    );
    let found = EquilibriumSearch::new(&sleigh).near([1.0, 2.0, 0.3]).unwrap();
    assert_close(&found.q, &[1.0, 2.0, 0.3]);
    assert_eq!(found.directions.len(), 3);
    // at a multiple root the equilibrium is isolated, though the equations are singular
    let flat = parsed("coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(4);");
    let found = EquilibriumSearch::new(&flat).near([0.7]).unwrap();
    assert!(found.q[0].abs() < 1e-8 && found.is_isolated(), "{found:?}");
}

#[test]
fn constraints_on_positions_hold() {
    let rod = parsed(
        "parameters { length = 0.8, gravity = 9.81 }
         coordinates(x, y);
         lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
         holonomic = x.powi(2) + y.powi(2) - length.powi(2);",
    );
    let found = EquilibriumSearch::new(&rod)
        .near_all([[0.3, -0.2], [0.1, 0.5]])
        .unwrap();
    assert_close(&found.equilibria[0].q, &[0.0, -0.8]);
    assert_close(&found.equilibria[1].q, &[0.0, 0.8]);
    // the rod bears the weight
    assert_close(&found.equilibria[0].force, &[0.0, 9.81]);
    let omega = (9.81_f64 / 0.8).sqrt();
    let [below, above] = [0, 1].map(|k| found.equilibria[k].eigenvalues().unwrap());
    assert_close(
        &[below[0][0], below[0][1], above[0][0], above[1][0]],
        &[0.0, omega, omega, -omega],
    );
    assert_eq!(found.equilibria[1].stability().unwrap(), Stability::Unstable);
    // held by a law of second order, at its target
    let law = parsed(
        "parameters { target = 0.4 }
         coordinates(x, theta);
         lagrangian = dot(x).powi(2) + theta.cos() * dot(x) * dot(theta) + dot(theta).powi(2) / 2 - theta.cos() - x.powi(2);
         kinematic = ddot(theta) + 2 * dot(theta) + 5 * theta.sin();
         constraint_forces = [(1, 0)];",
    );
    let found = EquilibriumSearch::new(&law).near([0.3, 0.2]).unwrap();
    assert_close(&found.q[1..], &[0.0]);
    assert_eq!(found.directions.len(), 1);
}

#[test]
fn dry_friction_is_zero_at_rest_and_has_no_eigenvalues() {
    let block = parsed(
        "coordinates(x);
         lagrangian = dot(x).powi(2) / 2 - 2 * (x - 1).powi(2);
         external_forces = (-3 * dot(x).signum());",
    );
    let found = EquilibriumSearch::new(&block).near([1.7]).unwrap();
    assert_close(&found.q, &[1.0]);
    assert!(
        matches!(found.model, Err(LinearizationError::Corner { .. })),
        "{:?}",
        found.model
    );
    assert!(found.eigenvalues().is_err() && found.stability().is_err());
}

#[test]
fn a_force_that_jumps_at_another_velocity_has_the_side_of_rest() {
    // forces, and their values at rest; the potential x² has the force −2 x
    for (force, at_rest) in [
        ("-0.5 * (dot(x) - 0.4).signum()", 0.5),
        ("if dot(x) < 0.4 { 0.5 } else { -0.5 }", 0.5),
        ("(0.5 * (dot(x) - 0.4)).min(0.1).max(-0.1)", -0.1),
        ("0.5 * (dot(x) + 3).signum()", 0.5),
        ("0.5 * (dot(x) + 3).abs()", 1.5),
        ("(3 - 2 * dot(x)).min(1.0)", 1.0),
        (
            "-(0.5 + 0.3 * (-(dot(x) - 0.4).abs() / 0.2).exp()) * (dot(x) - 0.4).signum()",
            0.5 + 0.3 * (-2.0_f64).exp(),
        ),
    ] {
        let system = parsed(&format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2); external_forces = {force};"
        ));
        let found = EquilibriumSearch::new(&system).near([0.5]).unwrap();
        assert_close(&found.q, &[at_rest / 2.0]);
        assert!(
            found.model.is_ok() && !found.is_held_by_friction() && found.frozen_at.is_none(),
            "{force}"
        );
    }
    // a drive whose limit is another speed: y = 2 is where the run goes
    let cruise = parsed(
        "coordinates(y); lagrangian = dot(y).powi(2) / 2 - y.powi(2) / 2;
         external_forces = if dot(y) > 1 { 0 } else { 2 } - dot(y);",
    );
    let found = EquilibriumSearch::new(&cruise).near([0.0]).unwrap();
    assert_close(&found.q, &[2.0]);
    assert_eq!(found.stability().unwrap(), Stability::Stable);
    // the force of a constraint has the side, too: the belt carries the block against a stop
    let stop = parsed(
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y.powi(2);
         holonomic = x - 1; external_forces = (-0.5 * (dot(x) - 0.4).signum(), 0);",
    );
    assert_close(
        &EquilibriumSearch::new(&stop).near([1.0, 0.2]).unwrap().force,
        &[-0.5, 0.0],
    );
}

#[test]
fn friction_that_holds_a_range_and_a_time_that_stands_are_told() {
    let block = parsed(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2); external_forces = 0.5 - 0.1 * dot(x).signum();",
    );
    let found = EquilibriumSearch::new(&block).near([0.5]).unwrap();
    assert_close(&found.q, &[0.25]);
    assert!(found.is_held_by_friction());
    assert!(
        found.to_string().contains("in a range that friction holds"),
        "{found}"
    );
    // drag by |v| v has a sign and holds nothing
    let drag = parsed(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2); external_forces = -dot(x).abs() * dot(x);",
    );
    assert!(
        !EquilibriumSearch::new(&drag)
            .near([0.5])
            .unwrap()
            .is_held_by_friction()
    );
    let belt = parsed(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2);
         external_forces = -0.5 * (dot(x) - 0.4 * t.cos()).signum();",
    );
    for (t, place) in [(0.0, 0.25), (3.0, -0.25)] {
        let found = EquilibriumSearch::new(&belt).at(t).near([0.5]).unwrap();
        assert_close(&found.q, &[place]);
        assert_eq!(found.frozen_at, Some(t));
        assert!(found.to_string().contains("frozen at t"), "{found}");
    }
}

/// Systems without an equilibrium near the guess give the reason: a force that nothing balances, a constraint
/// that does not allow rest, a constraint that moves in time, and others.
#[test]
fn where_there_is_none_it_says_why() {
    let search = |text: &str, guess: &[f64]| EquilibriumSearch::new(&parsed(text)).near(guess).unwrap_err();
    let falls = search(
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y - x.powi(2);",
        &[0.4, 1.0],
    );
    assert!(matches!(falls, EquilibriumError::NotFound { .. }), "{falls}");
    assert!(falls.to_string().contains("let an input be free"), "{falls}");
    let belt = search(
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; nonholonomic = dot(x) - 2;",
        &[0.0, 0.0],
    );
    assert_eq!(
        belt.to_string(),
        "nonholonomic constraint 1 does not allow rest: with v = 0 it is -2 at q = [0, 0]"
    );
    let lift = search(
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y; holonomic = y - t.sin();",
        &[0.0, 0.0],
    );
    assert!(
        matches!(
            lift,
            EquilibriumError::Moving {
                constraint: "holonomic constraint",
                ..
            }
        ),
        "{lift}"
    );
    let shaken = "coordinates(x); lagrangian = dot(x).powi(2) / 2 - (x - t.sin()).powi(2);";
    let shaken = search(shaken, &[0.3]);
    assert!(
        matches!(shaken, EquilibriumError::TimeDependent { t: 0.0, .. }),
        "{shaken}"
    );
    // an explicit time without effect at the place does not prevent an equilibrium
    let swing = parsed("coordinates(x); lagrangian = dot(x).powi(2) / 2 - (1 + t.sin() / 2) * x.powi(2);");
    assert_close(
        &EquilibriumSearch::new(&swing).at(0.5).near([0.3]).unwrap().q,
        &[0.0],
    );
    let root = search(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.sqrt();",
        &[-1.0],
    );
    assert!(
        matches!(
            &root,
            EquilibriumError::Undefined {
                undefined: Some(_),
                ..
            }
        ),
        "{root}"
    );

    let system = parsed(DOUBLE_PENDULUM);
    let message = |search: EquilibriumSearch<'_>| search.near([0.0, 0.0]).unwrap_err().to_string();
    assert_eq!(
        message(EquilibriumSearch::new(&system).free(["knee"])),
        "no parameter is called `knee`; expected `gravity`, `shoulder` or `elbow`"
    );
    assert_eq!(
        message(EquilibriumSearch::new(&system).held(["c"])),
        "no coordinate is called `c`; expected `a` or `b`"
    );
    let short = EquilibriumSearch::new(&system).near([0.0]).unwrap_err();
    assert_eq!(
        short.to_string(),
        "a guess has 1 component, but there are 2 coordinates: a, b"
    );
    let nan = EquilibriumSearch::new(&system).near([0.0, f64::NAN]).unwrap_err();
    assert_eq!(
        nan.to_string(),
        "component `b` of a guess is NaN; it must be finite"
    );
    // a guess without an equilibrium does not spoil the others
    let hill = parsed("coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) * (-x.powi(2)).exp();");
    let both = EquilibriumSearch::new(&hill).near_all([[0.2], [30.0]]).unwrap();
    assert!(both.of_guess[0].is_ok());
}
