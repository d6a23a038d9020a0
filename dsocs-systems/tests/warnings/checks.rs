//! Checks of realistic scenes: correct systems never show FAILED, and a check that is not required gives its
//! reason.

use std::fs;

use super::{attempt, program};

/// Whether all checks of a text pass or are excused, and the output.
fn check(text: &str, arguments: &[&str]) -> (bool, String) {
    let (succeeds, outputs) = attempt(text, "check", arguments);
    (succeeds, outputs.concat())
}

/// Asserts that a text passes, and returns the table.
#[track_caller]
fn passes(text: &str, arguments: &[&str]) -> String {
    let (passes, table) = check(text, arguments);
    assert!(
        passes && !table.contains("FAILED"),
        "{text} {arguments:?}: {table}"
    );
    table
}

/// Asserts that a text passes, and that no check of it is excused.
#[track_caller]
fn holds(text: &str) {
    let table = passes(text, &[]);
    assert!(!table.contains("open"), "{text}: {table}");
}

/// Systems that rest in equilibrium pass all checks without an excuse.
#[test]
fn what_rests_is_reversible() {
    holds(
        "coordinates(x); lagrangian = 1.4 * dot(x).powi(2) / 2 - 0.87 * x.powi(2) / 2; \
         external_forces = -0.024 * dot(x) * dot(x).abs(); run { start = ([0], [0]); step = 0.01; until = 2; }",
    );
    holds(
        "coordinates(x, theta); lagrangian = dot(x).powi(2) + dot(x) * dot(theta) * theta.cos() + dot(theta).powi(2) / 2 + 9.81 * theta.cos(); \
         run { start = ([0, 0], [0, 0]); step = 0.01; until = 1; }",
    );
}

#[test]
fn units_do_not_matter() {
    // two masses on springs in several units of length and time
    for [length, time] in [[1.0, 1.0], [1e-10, 1e4], [1e-6, 1e8], [1e5, 1e-3]] {
        holds(&format!(
            "parameters {{ length = {length:e}, time = {time:e} }} coordinates(x, y); \
             let a = x / length; let b = y / length; let u = dot(a) * time; let v = dot(b) * time; \
             lagrangian = 0.63 * u.powi(2) / 2 + 1.8 * v.powi(2) / 2 + 0.2 * u * v * (a - b).cos() \
                - 3.4 * (1 + a.powi(2)).sqrt() + 0.49 * b.cos() - 0.44 * (a - b).powi(2) / 2; \
             external_forces = (0.3 * (3.3 * t / time).cos() / length, -0.08 * b.sin() / length); \
             run {{ start = ([{:e}, {:e}], [{:e}, {:e}]); step = {:e}; until = {:e}; }}",
            -0.14 * length,
            0.2 * length,
            -1.1 * length / time,
            0.4 * length / time,
            0.1 * time,
            6.0 * time
        ));
    }
}

#[test]
fn springs_between_masses_are_no_pivots() {
    // the row of the spring is linear in one of the two unknowns, with a coefficient that vanishes with the
    // step
    for step in ["0.2", "0.01", "0.0001"] {
        let text = format!(
            "coordinates(x, y); lagrangian = 0.75 * dot(x).powi(2) / 2 + 1.9 * dot(y).powi(2) / 2 \
             - 4 * (1 + x.powi(2)).sqrt() - 1.8 * (x - y).powi(2) / 2; external_forces = (0, -0.9 * y.sin()); \
             run {{ start = ([-0.5, 0.6], [-1, -0.8]); step = {step}; until = {}; }}",
            40.0 * step.parse::<f64>().unwrap()
        );
        let table = passes(&text, &[]);
        let row = table
            .lines()
            .find(|line| line.contains("rows at the nodes"))
            .unwrap();
        let figure = row.split('┆').nth(1).unwrap().trim();
        assert!(figure.parse::<f64>().unwrap() <= 1.0, "{step}: {table}");
    }
}

/// A straight road with a distant bend: at first its curvature, and the distance of the motion from the line,
/// are below 1e-100.
const BEND: &str = "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; \
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt(); \
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - 5 * (-((x - 2) / 0.1).powi(2)).exp(); \
    variational = [(dot(x), dot(y))]; run { start = ([0, 0], [1, 0]); step = 0.005; until = 4; }";

/// A motion whose curvature is below 1e-100 at first passes all checks, and no step of it is reported as
/// irregular.
#[test]
fn what_hardly_moves_loses_no_regularity() {
    holds(BEND);
    let certified = |scene: &str| {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("bend.dsocs"), BEND).unwrap();
        let run = program::dsocs(folder.path(), &["run", scene, "--certify", "--until", "2"])
            .output()
            .unwrap();
        assert!(run.status.success());
        String::from_utf8(run.stderr).unwrap()
    };
    // the step of the start, which is not of the declaration, is not reported as irregular either
    for scene in ["bend.dsocs", "clothoid", "crane"] {
        assert_eq!(certified(scene), "", "{scene}");
    }
}

#[test]
fn an_order_that_scatters_over_corners_is_open_and_says_why() {
    let springs = "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
        external_forces = -50 * (x - 0.2).max(0) - 30 * (x + 0.3).min(0) - 0.05 * dot(x); \
        run { start = ([0], [1]); step = 0.01; until = 5; }";
    let mut open = 0;
    for step in ["0.025", "0.02", "0.01", "0.005"] {
        let table = passes(springs, &["--step", step]);
        open += u32::from(table.contains("open"));
        assert!(
            !table.contains("open") || table.contains("it passes"),
            "{step}: {table}"
        );
    }
    assert!(open > 0);
    // an order that is lower by one is not excused by corners
    let (right, table) = check(
        "coordinates(x); lagrangian = (1 + x.powi(2)) * dot(x).powi(2) / 2 - x.powi(2); phi_lagrangian = paper; \
         external_forces = -0.3 * x.max(0); run { start = ([0.5], [1]); step = 0.01; until = 4; }",
        &[],
    );
    assert!(!right && table.contains("FAILED"), "{table}");
}

/// The force is continuous, but its rate has no bound where the motion passes its zero: the order is between 1 and 2, and the reason is named.
#[test]
fn a_root_that_passes_its_zero_is_no_failure() {
    for power in [0.05, 0.1, 0.3, 0.5, 0.8] {
        for force in [
            format!("-x.abs().powf({power:?}) * x.signum()"),
            format!("-2 * x.signum() * x.abs().powf({power:?}) - 0.1 * dot(x)"),
            format!("-x + 0.4 * x.abs().powf({power:?})"),
            format!("-x - 0.3 * dot(x).abs().powf({power:?}) * dot(x).signum()"),
        ] {
            let text = format!(
                "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = {force}; run {{ start = ([1], [0.1]); step = 0.01; until = 6; }}"
            );
            let table = passes(&text, &[]);
            assert!(
                !table.contains("not required") || table.contains("no bound on its rate"),
                "{force}: {table}"
            );
        }
    }
}

/// A motion that begins at rest, with tiny first legs, passes the comparison of its tangent map with
/// difference quotients.
#[test]
fn what_begins_at_rest_has_differences_that_tell_its_tangent_map() {
    holds(
        "coordinates(x); lagrangian = 1.612 * dot(x).powi(2) / 2 - 0.7423 * x.powi(4) / 4; external_forces = -0.008387 * dot(x); \
         run { start = ([-0.06628], [0]); step = 0.002; until = 6; }",
    );
}

#[test]
fn what_is_missed_by_rounding_is_no_failure() {
    passes(
        "coordinates(x, y, th); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + dot(th).powi(2) / 6 + 3 * x; \
         nonholonomic = dot(x) * th.sin() - dot(y) * th.cos(); let v = dot(x) * th.cos() + dot(y) * th.sin(); \
         external_forces = (-0.8 * v.signum() * th.cos(), -0.8 * v.signum() * th.sin(), -0.02 * dot(th).signum()); \
         run { start = ([0, 0, 0], [0.1, 0, 1.5]); step = 0.025; until = 5; }",
        &[],
    );
}

/// Asserts that a text passes with an excuse that contains `why`.
#[track_caller]
fn is_open(text: &str, why: &str) {
    let table = passes(text, &[]);
    assert!(table.contains("open") && table.contains(why), "{text}: {table}");
}

#[test]
fn beside_a_singularity_orders_are_open() {
    // a prescribed curvature of a motion that comes to rest, and a velocity that is infinite at t = 1/2
    is_open(
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y; \
         let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt(); \
         kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - 1; variational = [(dot(x), dot(y))]; \
         run { start = ([0, 0], [2, 0]); step = 0.01; until = 1.5; }",
        "about t = 0.53 it passes through rest",
    );
    is_open(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = dot(x).powi(3); \
         run { start = ([0], [1]); step = 0.01; until = 1; }",
        "near to a singularity, first about t = 0.4",
    );
}

/// A step has no derivative where a node lies on the edge of a contact: a ball that touches a wall at the top of its path, and a mass that
/// lies on the edge of a free play.
#[test]
fn at_an_edge_the_tangent_map_is_not_compared() {
    let table = passes(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 8 * x; external_forces = -50 * (x - 1).max(0); \
         run { start = ([0], [4]); step = 0.1; until = 1; }",
        &[],
    );
    assert!(table.contains("1 of 5 steps are left out"), "{table}");
    is_open(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = -10 * (x - 1).max(0) - 10 * (x + 1).min(0); \
         run { start = ([1], [0]); step = 0.1; until = 2; }",
        "10 of 10 steps are left out",
    );
}

#[test]
fn what_cannot_be_measured_is_open() {
    let bodies = "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2";
    // the root of time has no series at 0
    is_open(
        &format!(
            "{bodies}; holonomic = x - t.powf(2.5); run {{ start = ([0, 0], [0, 1]); step = 0.01; until = 2; }}"
        ),
        "not measured",
    );
    // a corner of the path's curvature lies at a node
    is_open(
        &format!(
            "{bodies}; holonomic = x - 0.5 * (t - 1).abs().powf(1.5); run {{ start = ([0.5, 0], [-0.75, 1]); step = 0.01; until = 2; }}"
        ),
        "these places are left out",
    );
    // a light bead on a dashpot forgets its velocity in 10 μs
    is_open(
        "coordinates(x); lagrangian = 1e-5 * dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = -dot(x); \
         run { start = ([1], [-1]); step = 0.01; until = 3; }",
        "too stiff for the quadrature",
    );
}

#[test]
fn an_energy_that_jumps_without_a_force_is_open() {
    for turn in [
        "0.4 * y.atan2(x)",
        "0.4 * y.atan2(x) + x.powi(2)",
        "0.4 * (y - 0.2).atan2(x - 0.1)",
    ] {
        is_open(
            &format!(
                "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - {turn}; \
                 run {{ start = ([-1, 0.5], [0, -1]); step = 0.01; until = 2; }}"
            ),
            "the energy jumps",
        );
    }
}

/// Quotients 0/0 at a node are passed by their limit; the theorems need derivatives there.
#[test]
fn a_quotient_without_a_value_at_a_node_is_open() {
    for force in ["(t - 1).sin() / (t - 1)", "(1 - (t - 1).cos()) / (t - 1).powi(2)"] {
        is_open(
            &format!(
                "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = {force}; \
                 run {{ start = ([0], [0]); step = 0.125; until = 2; }}"
            ),
            "has no value at a state",
        );
    }
}

/// A jump exactly at a node, which the middles of legs do not see: the velocity at that node is the mean of those on both sides.
#[test]
fn a_jump_at_a_node_costs_the_velocity_there_an_order() {
    for force in ["if x < 1 { 0 } else { -2 }", "if t < 1 { 1 } else { -1 }"] {
        is_open(
            &format!(
                "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = ({force}); phi_lagrangian = midpoint; \
                 run {{ start = ([0], [1]); step = 0.125; until = 2.5; }}"
            ),
            "at a node beside it",
        );
    }
}

/// Where a mass rests in the whole window, no triple can be tested, and nothing has failed.
#[test]
fn a_motion_that_rests_all_the_time_passes() {
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = -3.0 * (dot(x) - 0.4).signum(); \
        run { start = ([0.0], [0.4]); step = 0.01; until = 2.0; }";
    let (succeeds, [table, words]) = attempt(text, "check", &[]);
    assert!(succeeds && !table.contains("FAILED"), "{table}{words}");
    assert!((table + &words).contains("no triple is left"), "{words}");
}

/// A constraint force with a part across the constraint, proportional to it: friction on a curve.
#[test]
fn forces_that_are_not_ideal_need_not_keep_the_symplectic_form() {
    let text = "parameters { mu = 0.2 } coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; \
                holonomic = (x.powi(2) + y.powi(2) - 1) / 2; \
                constraint_forces = [(x + mu * y, y - mu * x)]; \
                run { start = ([1.0, 0.0], [0.0, 1.0]); step = 0.01; until = 2.0; }";
    let (succeeds, [table, words]) = attempt(text, "check", &[]);
    assert!(succeeds, "{table} {words}");
}

/// Asserts that a check fails.
#[track_caller]
fn fails(text: &str, arguments: &[&str], what: &str) {
    let (passes, table) = check(text, arguments);
    let failed = table
        .lines()
        .any(|line| line.contains(what) && line.contains("FAILED"));
    assert!(!passes && failed, "{text} {arguments:?}: {table}");
}

#[test]
fn a_start_that_rounding_decides_is_open() {
    let scenes = [
        "coordinates(theta); lagrangian = dot(theta).powi(2) / 2 + 9.81 * theta.cos(); run { start = ([pi], [0]); step = 0.01; until = 20; }",
        "coordinates(x, theta); lagrangian = dot(x).powi(2) + dot(x) * dot(theta) * theta.cos() + dot(theta).powi(2) / 2 + 9.81 * theta.cos(); \
         run { start = ([0, pi], [0, 0]); step = 0.01; until = 15; }",
    ];
    for scene in scenes {
        is_open(scene, "beside an unstable equilibrium");
    }
    // beside the equilibrium no check is excused
    holds(
        "coordinates(theta); lagrangian = dot(theta).powi(2) / 2 + 9.81 * theta.cos(); run { start = ([3.1], [0]); step = 0.01; until = 4; }",
    );
}

#[test]
fn a_motion_that_changes_too_quickly_for_a_fit_is_open() {
    for small in ["1e-3", "3e-4"] {
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(4) / 4 + {small} * dot(x).powi(2) / 2 - x.powi(2) / 2; \
             run {{ start = ([1], [0]); step = 0.01; until = 1; }}"
        );
        is_open(&text, "a small part of the window only");
    }
}

#[test]
fn constraints_that_nearly_depend_on_each_other_are_open() {
    let scenes = [
        (
            "holonomic = [x.powi(2) + y.powi(2) + z.powi(2) - 1, x.powi(2) + y.powi(2) + z.powi(2) - 1 + eps * (z - 0.3 * x)]",
            "([0.9, 0.3, 0.27], [0, 0.5, 0])",
        ),
        (
            "holonomic = [z - 0.3 * x, z - 0.3 * x + eps * (y - x.powi(2))]",
            "([1, 1, 0.3], [0, 0, 0])",
        ),
        (
            "nonholonomic = [dot(z) - y * dot(x), dot(z) - y * dot(x) + eps * (dot(y) - z * dot(x))]",
            "([1, 1, 0.3], [1, 0.3, 1])",
        ),
    ];
    for (rows, start) in scenes {
        for eps in ["1e-6", "1e-8", "1e-9"] {
            let text = format!(
                "parameters {{ eps = {eps} }} coordinates(x, y, z); lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - 9.81 * y; \
                 {rows}; run {{ start = {start}; project = true; step = 0.01; until = 1; }}"
            );
            let table = passes(&text, &[]);
            assert!(
                eps == "1e-6" || table.contains("says nothing beside those before it"),
                "{text}: {table}"
            );
        }
    }
}

#[test]
fn a_motion_that_ends_by_itself_is_open_and_one_that_a_step_loses_fails() {
    let ends = [
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 + x.sqrt(); run { start = ([1], [-2.5]); step = 0.01; until = 5; }",
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 2 * x * x.sqrt() / 3; run { start = ([1], [-2.5]); step = 0.01; until = 5; }",
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - (1 - x.powi(2)).sqrt() - y.powi(2); \
         run { start = ([0, 1], [0.7, 0]); step = 0.01; until = 5; }",
    ];
    for text in ends {
        for arguments in [&[][..], &["--until", "3"]] {
            let table = passes(text, arguments);
            assert!(
                table.contains("the continuous motion ends, too"),
                "{text} {arguments:?}: {table}"
            );
        }
    }
    // a potential wall that reflects the motion, and a step that crosses it
    let wall = "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 1 / x.sqrt(); run { start = ([9], [-20]); step = 0.1; until = 2; }";
    for arguments in [&[][..], &["--until", "1"]] {
        fails(wall, arguments, "time that the motion reaches");
    }
}

#[test]
fn roundings_of_a_late_time_and_of_a_far_place_are_no_failures() {
    let hoop = "parameters { w = 2.0 } coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y; \
        holonomic = x * (w * t).sin() - y * (w * t).cos(); \
        run { start = ([0.5, 0.0], [0.0, 1.0]); step = 0.01; until = 1.0; project = true; }";
    let oscillator = "parameters { w = 2.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; \
        external_forces = (w * t).cos() - 0.1 * dot(x); run { start = ([1.0], [0.0]); step = 0.01; until = 10.0; }";
    let shaken = "parameters { a = 0.05, w = 100.0 } coordinates(th); let y = a * (w * t).cos(); \
        lagrangian = ((dot(th) * th.cos()).powi(2) + (dot(th) * th.sin() + dot(y)).powi(2)) / 2 + 9.81 * (th.cos() - y); \
        run { start = ([3.0], [0.0]); step = 0.001; until = 2.0; }";
    let belt = "parameters { w = 3.0, T0 = 1000000.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; \
        external_forces = (w * (t - T0)).cos() - 0.3 * (dot(x) - 0.5 + 0.1 * (t - T0)).signum(); \
        run { start = ([0.0], [0.0]); step = 0.01; until = 2.0; }";
    for (text, times) in [
        (hoop, &["1000", "10000", "1000000"][..]),
        (oscillator, &["-1000000", "100000000"]),
        (shaken, &["10000", "1000000"]),
        (belt, &["1000000"]),
    ] {
        for t0 in times {
            passes(text, &["--t0", t0]);
        }
    }
    // the message names the rounding
    let table = passes(hoop, &["--t0", "1000000"]);
    assert!(
        table.contains("the rounding of the time at 1.0e6 is 1e-10, 1e-8 of a step"),
        "{table}"
    );
    let far = "parameters { X = 4500000.0, Y = 600000.0, l = 2.0 } coordinates(x, y); \
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y; holonomic = (x - X).powi(2) + (y - Y).powi(2) - l.powi(2); \
        run { start = ([4500002.0, 600000.0], [0.0, 0.0]); step = 0.01; until = 5.0; }";
    let table = passes(far, &[]);
    assert!(
        table.contains("the rounding of the positions at 4.5e6 is 5e-10"),
        "{table}"
    );
    // near the speed of light the terms of the law change with the last digit of the velocity
    passes(
        "parameters { c = 299792458.0, m = 9.109e-31, q = 1.602e-19, E = 1e9 } coordinates(x); \
         lagrangian = -m * c.powi(2) * (1 - dot(x).powi(2) / c.powi(2)).sqrt() + q * E * x; \
         run { start = ([0.0], [0.0]); step = 1e-13; until = 1e-10; }",
        &[],
    );
}

#[test]
fn growth_does_not_depend_on_units() {
    // a comet in metres and seconds: as numbers its speed is 1e-8 of its distance, and so are their changes
    let comet = "parameters { GM = 1.32712440018e20, m = 5.972e24 } coordinates(x, y); \
        lagrangian = m / 2 * (dot(x).powi(2) + dot(y).powi(2)) + GM * m / (x.powi(2) + y.powi(2)).sqrt(); \
        run { start = ([1.471e11, 0.0], [0.0, 3000.0]); step = 86400.0; until = 3.2e7; }";
    let table = passes(comet, &[]);
    assert!(
        table.contains("a small change of the start has grown") && !table.contains("that is chaos"),
        "{table}"
    );
}

#[test]
fn figures_whose_assumption_is_missing_are_open() {
    let scene = |declaration: &str| {
        format!("coordinates(x); {declaration} run {{ start = ([0], [0]); step = 0.01; until = 1; }}")
    };
    let force = |force: &str| {
        scene(&format!(
            "lagrangian = dot(x).powi(2) / 2; external_forces = ({force});"
        ))
    };
    for (text, why) in [
        // every jump lies at a node, and the rounding of the time decides its side
        (
            force("(2 * PI * t / 0.01).sin().signum()"),
            "rounding decides on which side the node lies",
        ),
        (
            force("-3 * x.signum() - dot(x).signum()"),
            "rounding decides on which side the node lies",
        ),
        // no series leads through the start
        (
            scene("lagrangian = dot(x).powi(2) / 2 - x.abs();"),
            "not measured",
        ),
        // no derivative along the whole motion
        (force("x.abs().sqrt()"), "have a value, but no derivatives"),
        // a force that every node sees with the same value
        (
            force("3 * (2 * PI * (t / 0.01 + 0.25)).sin()"),
            "the slope of at least three errors",
        ),
    ] {
        is_open(&text, why);
    }
}
