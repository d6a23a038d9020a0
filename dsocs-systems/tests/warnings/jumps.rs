//! Jumps, corners and singularities in runs: a warning or an error where one is due, and none elsewhere.

use std::fs;

use super::{attempt, run};

/// A text with one coordinate, run to t = 9.
fn scene(statements: &str) -> String {
    format!("coordinates(x); {statements} run {{ start = ([1], [0]); step = 0.01; until = 9; }}")
}

/// The position in a row.
fn position(line: &str) -> f64 {
    line.split(',').nth(1).unwrap().parse().unwrap()
}

#[test]
fn a_jump_is_told_by_every_step_that_crosses_it() {
    let jumps = [
        "lagrangian = dot(x).powi(2) / 2 - x.abs(); external_forces = 0.3 * t.sin();",
        "lagrangian = dot(x).powi(2) / 2 - x.abs();",
        "lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = (t - 1.2345).signum();",
        "lagrangian = dot(x).powi(2) / 2 - x.powi(2); external_forces = if x > 0.3 { 1 } else { 0 };",
        "lagrangian = dot(x).powi(2) / 2 - x.powi(2); external_forces = (3000 * (x - 0.3)).tanh();",
    ];
    for statements in jumps {
        for order in ["2", "4", "6", "8"] {
            let (warnings, _) = run(&scene(statements), &["--order", order]);
            assert!(
                warnings.contains("of the first order"),
                "{statements} {order}: {warnings}"
            );
        }
        let (warnings, _) = run(&scene(statements), &["--tolerance", "1e-9"]);
        assert_eq!(warnings, "", "{statements}");
    }
    let smooth = [
        "lagrangian = dot(x).powi(2) / 2 + x.cos(); external_forces = 0.3 * t.sin();",
        "lagrangian = dot(x).powi(2) / 2 - x.powi(4); external_forces = -0.4 * dot(x).powi(3);",
        "lagrangian = dot(x).powi(2) / 2 - x.powi(2); external_forces = -dot(x) * dot(x).abs();",
        "lagrangian = dot(x).powi(2) / 2 - x.powi(2); external_forces = (x / 0.3).tanh();",
    ];
    for statements in smooth {
        for order in ["2", "4", "6", "8"] {
            let (warnings, _) = run(&scene(statements), &["--order", order]);
            assert_eq!(warnings, "", "{statements} {order}");
        }
    }
}

#[test]
fn stops_and_releases_are_no_reason_for_a_warning_and_crossings_are() {
    for statements in [
        "lagrangian = dot(x).powi(2) / 2; external_forces = -0.5 * (dot(x) - 1).signum();",
        "lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = -0.6 * (dot(x) - 0.1).signum();",
    ] {
        assert_eq!(run(&scene(statements), &[]).0, "", "{statements}");
    }
    let crosses =
        "lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = -0.15 * dot(x).signum();";
    let (warnings, end) = run(&scene(crosses), &[]);
    assert!(warnings.contains("within 2 steps"), "{warnings}");
    // a run to a tolerance has no warning; after two half-swings the mass is at 0.4, and swings about 0.15
    let (warnings, exact) = run(&scene(crosses), &["--tolerance", "1e-10"]);
    assert_eq!(warnings, "");
    let there = 0.15 + 0.25 * (9.0 - 2.0 * std::f64::consts::PI).cos();
    let apart = [&exact, &end].map(|line| (position(line) - there).abs());
    assert!(apart[0] < 1e-9 && apart[1] < 0.01, "{apart:?}");
}

#[test]
fn a_force_with_a_multiple_zero_does_not_jump() {
    let text = "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 1.3 * y; \
        external_forces = (-0.4 * dot(y).powi(3), 0); run { start = ([0, 0], [-0.4, -0.1]); step = 0.01; until = 0.3; }";
    for step in ["0.002", "0.005", "0.01", "0.017", "0.02", "0.04"] {
        assert_eq!(run(text, &["--step", step]).0, "", "{step}");
    }
}

#[test]
fn a_start_beside_a_singularity_is_told() {
    // the determinant is dot(x) + 0.6 dot(y), which is small at the start
    let text = |speed: f64| {
        format!(
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; \
             let V = dot(x).powi(2) / 2 + 0.6 * dot(x) * dot(y) + x.powi(2); kinematic = dot(V) + 0.5 * dot(x).powi(2); \
             constraint_forces = [(1, 0)]; run {{ start = ([0.621, -0.316], [{speed}, 1.52]); step = 0.01; until = 0.5; }}"
        )
    };
    for speed in [-0.911, -0.91, -0.9, -0.87] {
        let (warnings, end) = run(&text(speed), &[]);
        let (silent, exact) = run(&text(speed), &["--tolerance", "1e-10"]);
        let apart = (position(&end) - position(&exact)).abs();
        assert!(
            warnings.contains("nearly singular in 1 step, first about t = 0.01"),
            "{speed}: {apart:e} {warnings}"
        );
        assert_eq!(silent, "");
    }
    for speed in [-0.4, 0.0, 0.5] {
        let (warnings, end) = run(&text(speed), &[]);
        let exact = run(&text(speed), &["--tolerance", "1e-10"]).1;
        assert_eq!(warnings, "", "{speed}");
        assert!(
            (position(&end) - position(&exact)).abs() < 1e-3,
            "{speed}: {end} {exact}"
        );
    }
}

/// A crank and a connecting rod of the same length: where the slider meets the crank's axis, the gradient of
/// the row vanishes.
#[test]
fn a_change_point_of_one_row_ends_a_motion_to_every_tolerance() {
    let text = "parameters { r = 1.0, l = 1.0 } coordinates(a, s); lagrangian = dot(a).powi(2) / 2 + 0.5 * dot(s).powi(2) / 2; \
        holonomic = (s - r * a.cos()).powi(2) + (r * a.sin()).powi(2) - l.powi(2); \
        run { start = ([0.5, 1.7551651237807455], [1.0, -0.958851077208406]); step = 0.01; until = 4.0; }";
    for digits in 4..=14 {
        let (succeeds, [_, words]) = attempt(text, "run", &["--tolerance", &format!("1e-{digits}")]);
        let expected = "the rank of the constraints is lost at t = 1.3633";
        assert!(!succeeds && words.contains(expected), "{digits}: {words}");
    }
}

#[test]
fn a_change_point_is_told_and_no_factor_is_named_where_there_is_none() {
    let text = "parameters { l = 1.0 } coordinates(x, y, s); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 0.3 * dot(s).powi(2); \
        holonomic = [x.powi(2) + y.powi(2) - 1, (s - x).powi(2) + y.powi(2) - l.powi(2)]; \
        run { start = ([0.6, 0.8, 1.2], [-0.8, 0.6, -1.6]); step = 0.01; until = 3.0; }";
    let (warnings, _) = run(text, &[]);
    assert!(
        warnings.contains("nearly singular") && !warnings.contains("divide"),
        "{warnings}"
    );
    let (succeeds, [table, words]) = attempt(text, "check", &[]);
    assert!(succeeds && !table.contains("FAILED"), "{table}{words}");
    let output = table + &words;
    assert!(
        output.contains("since the continuous motion ends: the rank of the constraints is lost"),
        "{output}"
    );
}

#[test]
fn composed_steps_do_not_pass_the_singularity_of_a_law() {
    let text = "parameters { g = 9.81, k = 1.0 } coordinates(x, th); \
        lagrangian = dot(x).powi(2) + dot(x) * dot(th) * th.cos() + dot(th).powi(2) / 2 - g * th.cos(); \
        let V = dot(th).powi(2) / 2 + 5 * (1 - th.cos()); kinematic = dot(V) + k * dot(th).powi(2); constraint_forces = [(1, 0)]; \
        branch = divide(dot(th)); run { start = ([0.0, 1.2], [0.0, 3.0]); step = 0.01; until = 1.0; }";
    for order in ["2", "4", "6", "8"] {
        for step in ["0.01", "0.003", "0.001"] {
            let (succeeds, [_, stderr]) = attempt(text, "run", &["--order", order, "--step", step]);
            assert!(
                !succeeds && stderr.contains("singular"),
                "{order} {step}: {stderr}"
            );
        }
    }
}

#[test]
fn a_start_at_a_singularity_is_refused_by_every_method() {
    // the constraint determines theta; only its equation of motion determines the cart, with the factor
    // cos(theta)
    let text = |start: &str| {
        format!(
            "parameters {{ g = 9.81, k = 1.0 }} coordinates(x, th); \
             lagrangian = dot(x).powi(2) + dot(x) * dot(th) * th.cos() + dot(th).powi(2) / 2 - g * th.cos(); \
             let V = dot(th).powi(2) / 2 + 5 * (1 - th.cos()); kinematic = dot(V) + k * dot(th).powi(2); \
             constraint_forces = [(1, 0)]; branch = divide(dot(th)); run {{ start = ({start}); step = 0.001; until = 0.01; }}"
        )
    };
    let methods = [
        ["--order", "2"],
        ["--order", "4"],
        ["--order", "8"],
        ["--tolerance", "1e-9"],
    ];
    for start in [
        "[0, pi / 2], [0, 0]",
        "[0, -pi / 2], [0.3, 0]",
        "[0, 3 * pi / 2], [0, 0.2]",
    ] {
        for method in &methods {
            let (succeeds, [_, stderr]) = attempt(&text(start), "run", method);
            assert!(
                !succeeds && stderr.contains("the equations are singular at the start"),
                "{start} {method:?}: {stderr}"
            );
        }
    }
    // far from the singularity, in any unit
    for start in [
        "[0, 1.2], [0, 0]",
        "[1e9, 0], [1e-9, 0]",
        "[1e-150, 1], [1e150, 0]",
    ] {
        let (_, [_, stderr]) = attempt(&text(start), "run", &methods[3]);
        assert!(!stderr.contains("singular at the start"), "{start}: {stderr}");
    }
}

#[test]
fn a_jump_that_meets_what_rests_is_told_and_a_smooth_release_is_not() {
    // a jump of the push in time, one that another coordinate triggers, and one of the friction; and masses
    // that move beside one that rests
    let jumps = [
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
         external_forces = (if t > 1.2345 { 2.0 } else { 0.5 }) - dot(x).signum();",
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
         external_forces = (if t > 1.3 { 2.0 } else { 0.5 }) + 0.3 * t.sin() - dot(x).signum();",
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
         external_forces = 0.8 - (if (2 * t).cos() > -0.7 { 1.0 } else { 0.3 }) * dot(x).signum();",
        "coordinates(x, y); lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2 - y; \
         external_forces = ((if y < -0.7 { 2.0 } else { 0.5 }) - dot(x).signum(), 0);",
        "coordinates(x, y); lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2; \
         external_forces = (0.5 - dot(x).signum(), if t > 1.03 { 2.0 } else { 0.5 });",
        "coordinates(x, y); lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2; \
         external_forces = (5 - dot(x).signum(), if t > 1.03 { 2.0 } else { 0.5 });",
    ];
    for statements in jumps {
        let start = if statements.contains('y') { "[0, 0]" } else { "[0]" };
        let text = format!("{statements} run {{ start = ({start}, {start}); step = 0.01; until = 2.5; }}");
        for (order, steps) in [
            ("2", &["0.01", "0.013", "0.0037"][..]),
            ("4", &["0.01", "0.013"]),
            ("8", &["0.01"]),
        ] {
            for step in steps {
                let (warnings, _) = run(&text, &["--order", order, "--step", step]);
                assert!(
                    warnings.contains("of the first order"),
                    "{statements} {order} {step}: {warnings}"
                );
            }
        }
        assert_eq!(run(&text, &["--tolerance", "1e-9"]).0, "", "{statements}");
    }
    let smooth = [
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
         external_forces = 2 * (1.3 * t).sin().powi(3) - dot(x).signum();",
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = t.powi(4) - dot(x).signum();",
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
         external_forces = 0.4 * t + 0.5 * (4 * t).sin() - (dot(x) - 0.2 * (2 * t).sin()).signum();",
        "coordinates(x, y); lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2 + y.cos() + (x - y).cos(); \
         external_forces = (t - dot(x).signum() - 0.3 * (dot(x) - dot(y)).signum(), 0.7 * (1.7 * t).sin() + 0.3 * (dot(x) - dot(y)).signum());",
    ];
    for statements in smooth {
        let start = if statements.contains('y') { "[0, 0]" } else { "[0]" };
        let text = format!("{statements} run {{ start = ({start}, {start}); step = 0.01; until = 2.5; }}");
        for order in ["2", "4"] {
            for step in ["0.01", "0.013", "0.0037"] {
                let (warnings, _) = run(&text, &["--order", order, "--step", step]);
                assert_eq!(warnings, "", "{statements} {order} {step}");
            }
        }
    }
}

#[test]
fn friction_that_grows_towards_rest_is_met_by_any_step() {
    let text = "parameters { k = 4.0, vb = 0.3 } coordinates(x, y); \
        let slip = dot(x) - vb * (1 + 0.5 * (0.37 * t).sin()); let slip2 = dot(y) - dot(x); \
        lagrangian = (dot(x).powi(2) + 0.3 * dot(y).powi(2)) / 2 - k * x.powi(2) / 2 - 2 * (y - x).powi(2) / 2; \
        external_forces = (-(1.0 + 0.8 * (-slip.abs() / 0.1).exp()) * slip.signum() + 0.2 * slip2.signum(), -0.2 * slip2.signum()); \
        run { start = ([0.0, 0.1], [0.3, 0.3]); step = 0.1; until = 12.6; }";
    let there = position(&run(text, &["--tolerance", "1e-10"]).1);
    let mut apart: Vec<f64> = Vec::new();
    for step in ["0.12", "0.1", "0.09", "0.07", "0.05", "0.03", "0.02", "0.01"] {
        let h: f64 = step.parse().unwrap();
        let (_, end) = run(text, &["--step", step, "--until", "12.6"]);
        let t: f64 = end.split(',').next().unwrap().parse().unwrap();
        if (t - 12.6).abs() < 1e-9 {
            apart.push((position(&end) - there).abs() / (h * h));
        }
    }
    assert!(
        apart.len() >= 5 && apart.iter().all(|apart| *apart < 6.0),
        "{apart:?}"
    );
}

/// Steps to a time, none of which is half of another.
fn steps(until: f64, counts: &[u32]) -> Vec<String> {
    counts
        .iter()
        .map(|&count| format!("{:e}", until / f64::from(count)))
        .collect()
}

/// A text, the duration of its run, and numbers of steps.
type Scene = (&'static str, f64, &'static [u32]);

/// Runs the scenes by every order and every step, and asserts that the warnings are right.
fn assert_warnings(scenes: &[Scene], is_right: impl Fn(&str) -> bool) {
    for &(statements, until, counts) in scenes {
        for order in ["2", "4", "6", "8"] {
            for step in steps(until, counts) {
                let text = format!("{statements} step = {step}; until = {until}; }}");
                let (warnings, _) = run(&text, &["--order", order]);
                assert!(is_right(&warnings), "{statements} {order} {step}: {warnings}");
            }
        }
    }
}

#[test]
fn a_jump_is_told_however_small_and_wherever_it_lies_in_a_step() {
    let jumps: [Scene; 9] = [
        // pulses within a step, from a single argument, in time and in position
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; \
             external_forces = if (t - 3.0031).abs() < 0.0007 { 50 } else { 0 }; run { start = ([-1], [0]);",
            6.0,
            &[145, 210, 395],
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; \
             external_forces = if (x - 0.3).abs() < 0.0007 { 50 } else { 0 }; run { start = ([-1], [0]);",
            6.0,
            &[110, 325],
        ),
        // an argument that passes zero late and then quickly
        (
            "coordinates(x); lagrangian = 1.521 * dot(x).powi(2) / 2 - 1.215 * x.powi(2) / 2; \
             external_forces = 0.0308 * (-1.599 * (2.782 * t + 0.119).sin() / (1.941 + (x.powi(2) + 0.409 * x * t - 0.2).signum())) \
             + (0.906 * (1.621 * t + 1.174).sin()).tanh() - 0.254 * dot(x); run { start = ([-0.203], [-0.872]);",
            6.0,
            &[171, 290, 300, 350],
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = -1 + if t > 0.364 { 0.01 } else { 0 }; run { start = ([0], [3]);",
            2.0,
            &[53, 151, 367, 887],
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = -0.02 * dot(x).signum(); run { start = ([1], [0]);",
            8.0,
            &[83, 367, 1301],
        ),
        (
            "coordinates(y); lagrangian = dot(y).powi(2) / 2 - 9.81 * y; \
             external_forces = if y < 1 { -200 * (y - 1) - 0.3 * dot(y) } else { 0 }; run { start = ([1.4], [0]);",
            2.5,
            &[151, 571, 1301],
        ),
        // a side that is reached for less than a step
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = if x > 0.999999 { -20 } else { 0 }; \
             run { start = ([-1], [0]);",
            5.0,
            &[311, 500],
        ),
        // a pulse within a step
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = if t > 1.0001 && t < 1.0009 { 30 } else { 0 }; \
             run { start = ([-1], [0]);",
            3.0,
            &[97, 301],
        ),
        // the declared argument is a multiple of the time, and its zero is no double
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = if 3 * t > 0.9 { 1 } else { 0.5 }; run { start = ([0], [0]);",
            1.0,
            &[10, 100, 64],
        ),
    ];
    assert_warnings(&jumps, |warnings| warnings.contains("of the first order"));
}

#[test]
fn a_corner_is_no_jump() {
    let corners: [Scene; 8] = [
        // a very small jump, where the acceleration passes zero
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = 1e-9 * x.signum(); run { start = ([1], [-1]);",
            6.0,
            &[100, 400, 1075],
        ),
        // a branch that is never taken
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 4.7 * x.powi(2) / 2; \
             external_forces = if x > 5 { (x + 0.274 * dot(x) + 0.294).signum() } else { 0 }; run { start = ([-0.266], [-0.127]);",
            0.6,
            &[12, 13, 14, 15],
        ),
        // a quotient that loses its digits at 0 / 0
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = 0.1 * (x.exp() - 1) / x; run { start = ([1], [-1]);",
            6.0,
            &[100, 400, 1075],
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = if x > 0.3 { -1000 * (x - 0.3) } else { 0 }; \
             run { start = ([0], [1]);",
            2.0,
            &[99, 397, 1604],
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = -dot(x).signum() * dot(x).abs().sqrt(); run { start = ([0], [1]);",
            3.0,
            &[300, 1001],
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2); external_forces = (3 * t.sin()).max(dot(x)) - x.abs(); \
             run { start = ([1], [0]);",
            5.0,
            &[211, 500],
        ),
        // a stop where the holding force is near its limit
        (
            "coordinates(y); lagrangian = dot(y).powi(2) / 2; let c = 0.8 * (1 + 0.7 * (-dot(y).abs() / 0.2).exp()); \
             external_forces = 1.3 - c * dot(y).signum(); run { start = ([0], [-0.42]);",
            0.4,
            &[21, 23, 32],
        ),
        // a quotient that is 0 / 0 at a point, and one whose denominator is never zero
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = 0.1 * (2 + x.sin()).recip() - x.powi(3) / (1 + x.powi(2)); \
             run { start = ([1], [0.3]);",
            5.0,
            &[101, 400],
        ),
    ];
    assert_warnings(&corners, str::is_empty);
}

#[test]
fn a_jump_of_the_curvature_of_a_constraint_costs_no_order_and_is_none_of_a_force() {
    for statements in [
        "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y; holonomic = y - 0.3 * x.max(0).powi(2);",
        "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 2 * x.powi(2); nonholonomic = dot(y) - 0.3 * x.abs() * dot(x);",
        "lagrangian = (1 + (t - 0.7).abs()) * dot(x).powi(2) / 2 - 2 * x.powi(2) + dot(y).powi(2) / 2;",
    ] {
        for step in steps(1.5, &[151, 397, 2003]) {
            let text = format!(
                "coordinates(x, y); {statements} run {{ start = ([-1, 0], [2, {}]); step = {step}; until = 1.5; }}",
                if statements.contains("nonholonomic") {
                    "0.6"
                } else {
                    "0"
                }
            );
            assert_eq!(run(&text, &[]).0, "", "{statements} {step}");
        }
    }
}

/// Infinite forces, and jumps that require a jump of the velocity, in seven scenes by the orders 2, 4, 6 and
/// 8 with several steps: the run ends, or a warning names an infinite value; at the corner of a wire a
/// warning names the first order.
#[test]
fn what_is_infinite_and_what_makes_a_velocity_jump_is_told_as_such() {
    let ends: [Scene; 7] = [
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 - 0.1 * x.powi(2).ln(); run { start = ([1], [-1]);",
            2.0,
            &[61, 151, 401],
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 * if t > 1 { 2 } else { 1 } - x.powi(2) / 2; run { start = ([1], [0]);",
            2.0,
            &[97, 133],
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = -1 / (x - 0.5); run { start = ([0], [3]);",
            1.6,
            &[173, 400],
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = 0.01 / (t - 0.5); run { start = ([0], [0]);",
            1.6,
            &[97, 133, 401],
        ),
        // a step of the potential, a mass that jumps, and a wire with a corner
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 0.1 * x.signum(); run { start = ([-1], [1]);",
            2.0,
            &[97, 133, 401],
        ),
        (
            "coordinates(x); let m = if x > 0.1 { 2 } else { 1 }; lagrangian = m * dot(x).powi(2) / 2; run { start = ([-1], [1]);",
            2.0,
            &[97, 133, 401],
        ),
        (
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; holonomic = [y - 0.5 * x.abs()]; \
             run { start = ([-1, 0.5], [1, -0.5]);",
            2.0,
            &[97, 133],
        ),
    ];
    for &(statements, until, counts) in &ends {
        for order in ["2", "4", "6", "8"] {
            for step in steps(until, counts) {
                let text = format!("{statements} step = {step}; until = {until}; }}");
                let (succeeds, [_, words]) = attempt(&text, "run", &["--order", order]);
                let corner = statements.contains("holonomic");
                assert!(
                    !succeeds
                        || words.contains("is infinite")
                        || corner && words.contains("of the first order"),
                    "{statements} {order} {step}: {words}"
                );
            }
        }
    }
}

#[test]
fn an_input_may_change_where_a_mass_turns() {
    // it slides with 0.02 when the push reverses, stops after 0.02 / 1.3, and slides back with the
    // acceleration 0.3
    let text = "parameters { p = 0.2 } coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = p - 0.5 * dot(x).signum(); \
        run { start = ([0], [0.32]); step = 0.1; until = 2; }";
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("p.csv");
    fs::write(&input, "1,-0.8\n").unwrap();
    let input = format!("p={}", input.display());
    let stop = 0.02 / 1.3;
    let right = 0.32 - 0.15 + 0.5 * 0.02 * stop - 0.15 * (1.0 - stop) * (1.0 - stop);
    for step in [0.2, 0.1, 0.05, 0.04, 0.025, 0.02, 0.01, 0.005] {
        let (warnings, end) = run(text, &["--input", &input, "--step", &step.to_string()]);
        assert!(warnings.contains("of the first order"), "{step}: {warnings}");
        assert!(
            // the error of half a step with a force that is wrong by 1
            (position(&end) - right).abs() < 0.5 * step,
            "{step}: {end} {right}"
        );
    }
}

#[test]
fn a_text_that_goes_back_in_time_goes_nowhere_else_by_itself() {
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2; run { start = ([0], [1]); step = -0.5; until = -2; }";
    assert!((position(&run(text, &[]).1) + 2.0).abs() < 1e-12);
    let (succeeds, [_, words]) = attempt(text, "run", &["--step", "0.5"]);
    assert!(!succeeds && words.contains("of one sign"), "{words}");
    assert!((position(&run(text, &["--step", "0.5", "--until", "2"]).1) - 2.0).abs() < 1e-12);
}

#[test]
fn a_mass_that_falls_is_no_singularity() {
    // a rocket that burns its mass, and a relativistic particle that slows down
    let regular = [
        "coordinates(z); let m = 0.05 + 0.5 * (1 - ((t - 1) / 0.1).tanh()); lagrangian = m * dot(z).powi(2) / 2; \
         external_forces = 3; run { start = ([0], [0]); step = 0.02; until = 4; }",
        "coordinates(x); lagrangian = -(1 - dot(x).powi(2)).sqrt() - x.powi(2) * 2; \
         run { start = ([0], [0.9]); step = 0.06; until = 6; }",
    ];
    for text in regular {
        for step in ["0.01", "0.02", "0.03", "0.05", "0.06"] {
            assert_eq!(run(text, &["--step", step]).0, "", "{text} {step}");
        }
    }
    // a mass that vanishes at a point, with and without a change of its sign
    for mass in ["x", "x.powi(2)"] {
        let text = format!(
            "coordinates(x); lagrangian = {mass} * dot(x).powi(2) / 2; run {{ start = ([1], [-1]); step = 0.01; until = 1.2; }}"
        );
        let (succeeds, [_, stderr]) = attempt(&text, "run", &[]);
        assert!(!succeeds || stderr.contains("singular"), "{text}: {stderr}");
    }
}

#[test]
fn a_velocity_without_a_bound_is_told_as_such() {
    // v = 1 / sqrt(1 - 2 t)
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = dot(x).powi(3); \
        run { start = ([0], [1]); step = 0.01; until = 1; }";
    let mut warned = 0;
    for parts in 40..100 {
        let step = (1.0 / f64::from(parts)).to_string();
        let (succeeds, [_, warnings]) = attempt(text, "run", &["--step", &step]);
        if succeeds {
            assert!(warnings.contains("grows beyond all bounds"), "{step}: {warnings}");
            warned += 1;
        }
    }
    assert!(warned > 0);
    let (succeeds, [_, error]) = attempt(text, "run", &["--tolerance", "1e-9"]);
    assert!(!succeeds, "{error}");
}

/// Jumps that are declared, and at which the motion sticks, end a Taylor flow without the advice to declare
/// them.
#[test]
fn what_is_declared_and_sticks_is_not_asked_to_be_declared() {
    let declared = [
        // the square root of the speed, and infinitely many switches in a finite time
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = -dot(x).signum() * dot(x).abs().sqrt(); \
         run { start = ([0], [1]); step = 0.01; until = 3; }",
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = -x.signum() - 0.5 * dot(x).signum(); \
         run { start = ([1], [0]); step = 0.01; until = 12; }",
    ];
    for text in declared {
        let (succeeds, [_, stderr]) = attempt(text, "run", &["--tolerance", "1e-9"]);
        assert!(
            !succeeds && stderr.contains("the motion sticks"),
            "{text}: {stderr}"
        );
        assert!(!stderr.contains("Declare it so"), "{text}: {stderr}");
    }
}

#[test]
fn what_is_led_away_from_rest_on_both_sides_asks_which() {
    let methods: [&[&str]; 3] = [&[], &["--order", "4"], &["--tolerance", "1e-9"]];
    // a force along the velocity; friction that becomes one while a mass rests; the same on a belt, and
    // beside another mass
    let scenes = [
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = 0.5 * dot(x).signum();",
            "([0], [0])",
            0.0,
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = 0.3 + 0.5 * dot(x).signum();",
            "([0], [0])",
            0.0,
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = (t - 1) * dot(x).signum();",
            "([0], [0.1])",
            1.0,
        ),
        (
            "coordinates(x); lagrangian = 1.7 * dot(x).powi(2) / 2; external_forces = (t.powi(2) - 1) * (dot(x) - 0.4).signum();",
            "([0], [0.3])",
            1.0,
        ),
        (
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + 2 * dot(y).powi(2)) / 2 - y.powi(2) / 2; \
             external_forces = (3 * (t - 1) * dot(x).signum(), -0.1 * dot(y));",
            "([0, 0.1], [0, 0])",
            1.0,
        ),
    ];
    for (scene, start, _) in scenes {
        for method in methods {
            let text = format!("{scene} run {{ start = {start}; step = 0.01; until = 3; }}");
            let (succeeds, output) = attempt(&text, "run", method);
            assert!(
                !succeeds && output[1].contains("what is at rest may leave in more than one way, or stay"),
                "{text} {method:?}: {output:?}"
            );
        }
    }
    // Taylor's method ends at the exact time
    for (scene, start, time) in &scenes[2..4] {
        let text = format!("{scene} run {{ start = {start}; step = 0.01; until = 3; }}");
        let (_, [_, stderr]) = attempt(&text, "run", &["--tolerance", "1e-9"]);
        let (_, after) = stderr.split_once("not unique beyond t = ").unwrap();
        let found: f64 = after.split_once(',').unwrap().0.parse().unwrap();
        assert!((found - time).abs() < 1e-6, "{text}: {stderr}");
    }
    // a force that pushes one way only, a mass that is held, and friction from rest have unique motions
    for scene in [
        "external_forces = 0.6 + 0.5 * dot(x).signum();",
        "external_forces = (t - 1) * dot(x).signum() + 0.01;",
        "external_forces = 0.4 * t - 0.5 * dot(x).signum();",
        "external_forces = -dot(x) - 0.5 * (dot(x) - 0.2 * t).signum();",
        "external_forces = 0.5 * dot(x) * dot(x).abs();",
    ] {
        for method in methods {
            let text = format!(
                "coordinates(x); lagrangian = dot(x).powi(2) / 2; {scene} run {{ start = ([0], [0]); step = 0.01; until = 3; }}"
            );
            let (succeeds, output) = attempt(&text, "run", method);
            assert!(succeeds, "{text} {method:?}: {output:?}");
        }
    }
}

/// Painlevé's rod with 42 steps from 2e-4 to 2e-3: every run ends, or warns of a nearly singular step.
#[test]
fn a_step_that_is_solved_with_sides_does_not_lead_over_a_singularity() {
    // a sliding rod whose friction is proportional to its normal force (Painlevé): the determinant vanishes
    // at t = 0.0658418, where the motion ends
    let text = "parameters { mu = 1.8, g = 9.81 } coordinates(x, y, th); \
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + dot(th).powi(2) / 6 - g * y; let slip = dot(x - th.cos()); \
        holonomic = y - th.sin(); let s = mu * slip.signum(); constraint_forces = [(-s, 1, -th.cos() - s * th.sin())]; \
        run { start = ([0.0, 0.74570521217672026, 2.3], [3.0, 0.0, 0.0]); step = 0.001; until = 0.2; }";
    for k in 0..40 {
        let h = 2e-4 * 10_f64.powf(0.025 * f64::from(k) + 0.0017);
        let (succeeds, output) = attempt(text, "run", &["--step", &format!("{h:.9}")]);
        // a step so near to the singularity that the acceleration stays finite has a warning
        assert!(
            !succeeds || output[1].contains("nearly singular"),
            "{h}: {}",
            output[1]
        );
    }
    for step in ["0.0005", "0.000279236"] {
        let (succeeds, output) = attempt(text, "run", &["--step", step]);
        assert!(
            !succeeds && output[1].contains("the acceleration grows without bound"),
            "{step}: {}",
            output[1]
        );
    }
}

#[test]
fn nothing_is_said_of_functions_that_a_text_cannot_have() {
    let text = "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - (x.powi(2) + y.powi(2)) / 2; \
        let phi = y.atan2(x); external_forces = (0.1 * phi.cos(), 0.1 * phi.sin()); \
        run { start = ([0.5, 0.0], [0.0, 0.0]); step = 0.01; until = 6.0; }";
    let (succeeds, output) = attempt(text, "run", &["--tolerance", "1e-9"]);
    assert!(
        !succeeds && output[1].contains("not smooth") && !output[1].contains("a function of your own"),
        "{output:?}"
    );
}

/// `Si(1)`, of which the motions below are multiples.
const SINE_INTEGRAL: f64 = 0.946_083_070_367_183;

#[test]
fn a_quotient_with_a_limit_at_a_node_is_not_singular() {
    let versine = SINE_INTEGRAL - (1.0 - 1_f64.cos());
    for (force, end) in [
        ("(t - 1).sin() / (t - 1)", 2.0 * SINE_INTEGRAL),
        ("(1 - (t - 1).cos()) / (t - 1).powi(2)", 2.0 * versine),
        // as a constraint, and beside a motion of another coordinate
        ("0.5 * (2 * t - 2).sin() / (t - 1)", 2.0 * 0.802_706_488_401_347_2),
    ] {
        for text in [
            format!("coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = {force};"),
            format!(
                "coordinates(x); lagrangian = dot(x).powi(2) / 2; kinematic = ddot(x) - {force}; constraint_forces = [(1)];"
            ),
        ] {
            for step in ["0.01", "0.02", "0.05"] {
                let text = format!("{text} run {{ start = ([0], [0]); step = {step}; until = 2; }}");
                let (warnings, line) = run(&text, &[]);
                assert_eq!(warnings, "", "{text}");
                let h: f64 = step.parse().unwrap();
                // where the force is even about the node, position and velocity at the end are the same number
                let (apart, bound) = ((position(&line) - end).abs(), h * h);
                assert!(apart < bound, "{text}: {apart:e}");
            }
        }
    }
    // a determinant that vanishes at a node is told
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2; kinematic = (t - 1) * ddot(x) - (t - 1.3).sin(); constraint_forces = [(1)]; \
        run { start = ([0], [0]); step = 0.01; until = 2; }";
    let (_, [_, words]) = attempt(text, "run", &[]);
    assert!(words.contains("nearly singular"), "{words}");
}

/// A force that is 1 up to the time or the place at which the mass is at 1/2, then -1: it comes back to rest at x = 1 and t = 2.
#[test]
fn a_jump_at_a_node_is_told_where_the_step_is_evaluated_there() {
    let scene = |map: &str, force: &str, step: &str| {
        format!(
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + 2 * dot(y).powi(2)) / 2; {map} external_forces = ({force}, 0.3); \
             run {{ start = ([0, 0], [0, 0]); step = {step}; until = 2; }}"
        )
    };
    let velocity = |line: &str| line.split(',').nth(3).unwrap().parse::<f64>().unwrap();
    for force in [
        "if t < 1 { 1 } else { -1 }",
        "(1 - t).signum()",
        "if x < 0.5 { 1 } else { -1 }",
    ] {
        for step in ["0.25", "0.125", "0.0625"] {
            let h: f64 = step.parse().unwrap();
            // within the legs alone: each leg has its own side
            let (warnings, line) = run(&scene("phi_lagrangian = midpoint;", force, step), &[]);
            assert_eq!(warnings, "", "{force} {step}");
            let apart = [position(&line) - 1.0, velocity(&line)];
            assert!(
                apart.iter().all(|apart| apart.abs() < 1e-12),
                "{force} {step}: {apart:?}"
            );
            // at the node itself: the force of one side acts for half a step too long
            for map in ["", "phi_lagrangian = paper;", "phi_lagrangian = trapezoid;"] {
                let (warnings, line) = run(&scene(map, force, step), &[]);
                assert!(
                    warnings.contains("within 1 step, first about t = 1"),
                    "{map} {force} {step}: {warnings}"
                );
                let apart = (position(&line) - 1.0).abs();
                assert!((apart - h).abs() < 1e-9, "{map} {force} {step}: {apart}");
            }
        }
        // beside a node the middle of its leg is on one side
        let (warnings, _) = run(
            &scene("phi_lagrangian = midpoint;", force, "0.12"),
            &["--until", "1.92"],
        );
        assert!(warnings.contains("within 1 step"), "{force}: {warnings}");
    }
}

/// Pseudo-random numbers between -1 and 1 (D. H. Lehmer's generator).
fn random(state: &mut u64) -> f64 {
    *state = *state * 48_271 % 2_147_483_647;
    *state as f64 / 1_073_741_823.5 - 1.0
}

/// Motions from rest, or along the place of a jump: both sides lead away where the accelerations across it point away from it on both.
#[test]
fn what_is_led_away_from_a_place_on_both_sides_asks_which() {
    let methods: [&[&str]; 3] = [&[], &["--order", "4"], &["--tolerance", "1e-9"]];
    let (mut state, mut counts) = (20_261, [0; 2]);
    let mut number = || (100.0 * random(&mut state)).round() / 100.0;
    for kind in 0..48 {
        let [mass, place, jump, push, along] = [1.5 + number(), number(), 2.0 * number(), number(), number()];
        // the direction across, with the components 3/5 and 4/5 or none of the second coordinate
        let [n, m] = [[1.0, 0.0], [0.6, 0.8]][kind % 2];
        let across = if kind % 2 == 0 {
            format!("(x - {place})")
        } else {
            format!("(0.6 * x + 0.8 * y - {place})")
        };
        // the force along the direction on the side of positive values, and on the other
        let (potential, force, [after, before]) = match kind / 2 % 4 {
            0 => (
                format!("+ {jump} * {across}.abs() + {push} * {across}"),
                String::new(),
                [jump + push, push - jump],
            ),
            1 => (
                String::new(),
                format!("{jump} * {across}.signum() + {push}"),
                [jump + push, push - jump],
            ),
            2 => (
                String::new(),
                format!("(if {across} > 0 {{ {jump} }} else {{ {push} }})"),
                [jump, push],
            ),
            // a corner of the force is no jump
            _ => (
                String::new(),
                format!("{jump} * {across}.abs() + {push} * {across} * {across}.abs()"),
                [0.0, 0.0],
            ),
        };
        // the part of the force that is off the place, and a velocity along it, or across
        let crosses = kind % 12 == 5;
        let v = [
            -m * along + if crosses { n } else { 0.0 },
            n * along + if crosses { m } else { 0.0 },
        ];
        let force = if force.is_empty() { "0".to_owned() } else { force };
        let text = format!(
            "coordinates(x, y); lagrangian = {mass} * (dot(x).powi(2) + dot(y).powi(2)) / 2 {potential}; \
             external_forces = ({n} * ({force}), {m} * ({force})); \
             run {{ start = ([{}, {}], [{}, {}]); step = 0.01; until = 0.5; }}",
            n * place,
            m * place,
            v[0],
            v[1]
        );
        if kind / 2 % 4 < 3 && (after.abs() < 0.02 || before.abs() < 0.02) {
            continue;
        }
        let forks = after > 0.0 && before < 0.0 && !crosses;
        counts[usize::from(forks)] += 1;
        for method in methods {
            let (succeeds, [_, words]) = attempt(&text, "run", method);
            let asks = words.contains("what is at rest may leave in more than one way, or stay");
            assert_eq!(asks, forks, "{text} {method:?}: {words}");
            assert!(!(succeeds && forks), "{text} {method:?}");
        }
    }
    assert!(counts[0] > 10 && counts[1] > 8, "{counts:?}");
    // several places at once, a force of which nothing depends, and one that vanishes with the distance
    for (statements, forks) in [
        (
            "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.abs() - y.abs();",
            false,
        ),
        (
            "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + x.abs() + (x + y).abs();",
            true,
        ),
        (
            "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; external_forces = (x.signum() * x, 0 * x.signum());",
            false,
        ),
        (
            "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; external_forces = (x.max(0), 1 + x.signum());",
            false,
        ),
    ] {
        let text = format!(
            "coordinates(x, y); {statements} run {{ start = ([0, 0], [0, 0]); step = 0.01; until = 0.5; }}"
        );
        for method in methods {
            let (_, [_, words]) = attempt(&text, "run", method);
            let asks = words.contains("what is at rest may leave in more than one way, or stay");
            assert_eq!(asks, forks, "{text} {method:?}: {words}");
        }
    }
}
