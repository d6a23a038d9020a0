//! Samples with spacings below the step, and bodies on sampled surfaces.

use super::attempt_with;

/// The warnings of a run with a table of samples, which has to succeed.
fn warnings_of(table: &[[f64; 2]], text: &str, arguments: &[&str]) -> String {
    let lines = table.iter().map(|[place, value]| format!("{place},{value}\n"));
    let (succeeds, [_, warnings]) = attempt_with(&[("table.csv", lines.collect())], text, "run", arguments);
    assert!(succeeds, "{text} {arguments:?}: {warnings}");
    warnings
}

/// A mass on a spring, with a statement that contains the samples.
fn scene(curve: &str, samples: &str) -> String {
    format!(
        "parameters {{ f = samples(\"table.csv\", {curve}) }} coordinates(x); {samples} \
         run {{ start = ([0.1], [1.0]); step = 0.01; until = 3; }}"
    )
}

#[test]
fn a_pulse_between_two_nodes_is_told() {
    let force = "lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = f.at(t);";
    let held = "lagrangian = dot(x).powi(2) / 2 - (1 + f.at(t)) * x.powi(2) / 2;";
    let carried = "lagrangian = (dot(x) + 0.003 * f.at(t)).powi(2) / 2 - x.powi(2) / 2;";
    // at the start of the motion the velocity is about one
    let bump = "lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 - 0.001 * f.at(x);";
    for (place, statements) in [(1.3, force), (1.3, held), (1.3, carried), (0.5, bump)] {
        for shift in [0.0, 0.0007, 0.0031, 0.0052, 0.0069, 0.0096] {
            let from = place + shift;
            let pulse = [
                [0.0, 0.0],
                [from, 0.0],
                [from + 0.0012, 300.0],
                [from + 0.0024, 0.0],
                [9.0, 0.0],
            ];
            for order in ["2", "4", "6"] {
                let text = scene("linear", statements);
                let warnings = warnings_of(&pulse, &text, &["--order", order]);
                // a pulse with a node in it reverses the mass
                assert!(
                    warnings.contains("of the first order") || warnings.contains("the energy is"),
                    "{statements} {from} {order}: {warnings}"
                );
            }
        }
    }
}

#[test]
fn close_samples_on_a_smooth_curve_are_no_reason_for_a_warning() {
    let table: Vec<[f64; 2]> = (0..3000)
        .map(|k| {
            let t = 0.002 * f64::from(k);
            [t, (3.0 * t).sin() + 0.3 * (7.0 * t).cos()]
        })
        .collect();
    let statements = [
        "lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = f.at(t);",
        "lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 - 0.2 * f.at(x + 2);",
        "lagrangian = (dot(x) + 0.1 * f.at(t)).powi(2) / 2 - x.powi(2) / 2;",
    ];
    for statements in statements {
        for curve in ["linear", "cubic", "monotone"] {
            // a Lagrangian needs the derivative of its samples, and that of straight lines jumps
            if curve == "linear" && !statements.contains("external_forces") {
                continue;
            }
            for order in ["2", "4"] {
                for step in ["0.1", "0.03", "0.01", "0.001"] {
                    let warnings = warnings_of(
                        &table,
                        &scene(curve, statements),
                        &["--order", order, "--step", step],
                    );
                    assert_eq!(warnings, "", "{statements} {curve} {order} {step}");
                }
            }
        }
    }
}

/// A belt with sampled speed carries a block: the block has the velocity of the belt, to the tolerance, and
/// no constraint force. It slides where the belt slows down too fast; its release at a corner of the samples
/// gives a warning with steps of a fixed length.
#[test]
fn what_rests_on_a_sampled_belt_has_its_velocity() {
    let table = |name: &str, lines: &[(f64, f64)]| {
        let lines = lines.iter().map(|(t, speed)| format!("{t},{speed}\n"));
        vec![(name.to_owned(), lines.collect::<String>())]
    };
    let text = |curve: &str, dry: f64, start: f64| {
        format!(
            "parameters {{ s = samples(\"belt.csv\", {curve}) }} coordinates(x); lagrangian = dot(x).powi(2) / 2; \
             external_forces = -{dry} * (dot(x) - s.at(t)).signum(); let speed = s.at(t); observe = [speed]; \
             run {{ start = ([0.0], [{start}]); step = 0.01; until = 3.5; }}"
        )
    };
    let attempt = |files: &[(String, String)], text: &str, arguments: &[&str]| {
        let files: Vec<(&str, String)> = files.iter().map(|(name, all)| (&**name, all.clone())).collect();
        let (succeeds, [table, words]) = attempt_with(&files, text, "run", arguments);
        assert!(succeeds, "{text} {arguments:?}: {words}");
        let rows = table
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect());
        (rows.collect::<Vec<Vec<f64>>>(), words)
    };
    let belt: Vec<(f64, f64)> = (0..9)
        .map(|k| (0.5 * f64::from(k), 0.4 + 0.05 * (0.25 * f64::from(k)).sin()))
        .collect();
    let files = table("belt.csv", &belt);
    for curve in ["cubic", "monotone", "linear"] {
        for (tolerance, bound) in [("1e-6", 1e-6_f64), ("1e-10", 1e-10), ("1e-12", 1e-11)] {
            let (rows, words) = attempt(&files, &text(curve, 3.0, 0.4), &["--tolerance", tolerance]);
            assert_eq!(words, "", "{curve} {tolerance}");
            for row in rows {
                let [t, _, v, force, _, speed] = row[..] else {
                    panic!("{row:?}")
                };
                // at a sample the acceleration is that of either side
                let is_between = ((2.0 * t).round() - 2.0 * t).abs() > 1e-9;
                let is_free = force.abs() < f64::max(1e-6, 100.0 * bound);
                let holds = (v - speed).abs() < bound && (is_free || !is_between);
                assert!(holds, "{curve} {tolerance}: {row:?}");
            }
        }
    }
    // release at a corner: reported for steps of a fixed length, whose order it lowers
    let files = table("belt.csv", &[(0.0, 0.6), (2.0, 0.6), (3.0, -0.4), (6.0, -0.4)]);
    let text = text("linear", 0.75, 0.6);
    for arguments in [&["--step", "0.01"][..], &["--step", "0.01", "--order", "4"]] {
        let (_, words) = attempt(&files, &text, arguments);
        assert!(words.contains("jumps"), "{arguments:?}: {words}");
    }
    let (rows, words) = attempt(&files, &text, &["--tolerance", "1e-10", "--until", "3"]);
    let end = rows.last().unwrap();
    assert!(
        words.is_empty() && (end[1] - 1.425).abs() < 1e-9,
        "{words}{end:?}"
    );
}

/// No method has a constraint force where there is no constraint.
#[test]
fn the_first_row_of_what_rests_has_no_constraint_force() {
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = -3.0 * (dot(x) - 0.4).signum(); \
        run { start = ([0.0], [0.4]); step = 0.01; until = 0.1; }";
    for arguments in [&[][..], &["--order", "4"], &["--tolerance", "1e-9"]] {
        let (succeeds, [table, words]) = attempt_with(&[], text, "run", arguments);
        assert!(succeeds, "{words}");
        for line in table.lines().skip(1) {
            let force: f64 = line.split(',').nth(3).unwrap().parse().unwrap();
            assert!(force.abs() < 1e-12, "{arguments:?}: {line}");
        }
    }
}

/// The rounding of a constraint is removed over many steps. Samples leave more of it than a formula, at all
/// nodes.
#[test]
fn a_constraint_with_samples_passes_the_checks() {
    let table = [[-1.0, -1.0], [0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [5.0, 5.0]];
    let lines = table.iter().map(|[place, value]| format!("{place},{value}\n"));
    let text = "parameters { s = samples(\"table.csv\", cubic) } coordinates(x, y); \
                lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2 - 2 * x.powi(2); holonomic = y - x - s.at(t); \
                run { start = ([0.1, 0.1], [0.0, 1.0]); step = 0.01; until = 3.9; }";
    let (succeeds, [table, _]) = attempt_with(&[("table.csv", lines.collect())], text, "check", &[]);
    assert!(succeeds, "{table}");
}
