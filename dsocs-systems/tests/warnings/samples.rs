//! Samples that lie closer to each other than the nodes of a run.

use super::attempt_with;

/// What a run with a table of samples says, which is to succeed.
fn said(table: &[[f64; 2]], text: &str, arguments: &[&str]) -> String {
    let lines = table.iter().map(|[place, value]| format!("{place},{value}\n"));
    let (succeeds, [_, warnings]) = attempt_with(&[("table.csv", lines.collect())], text, "run", arguments);
    assert!(succeeds, "{text} {arguments:?}: {warnings}");
    warnings
}

/// A mass on a spring, and what the samples do to it.
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
    // where the mass passes with a velocity of about one
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
                let warnings = said(&pulse, &text, &["--order", order]);
                // a node within the pulse throws the mass back
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
            // a Lagrangian takes a derivative of its samples, and that of straight lines jumps
            if curve == "linear" && !statements.contains("external_forces") {
                continue;
            }
            for order in ["2", "4"] {
                for step in ["0.1", "0.03", "0.01", "0.001"] {
                    let warnings = said(
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
