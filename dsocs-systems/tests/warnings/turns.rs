//! The warning about angles that turn too far in a step: the nodes may see the same of a rotor in every turn.

use super::run;

/// A rotor whose unbalanced mass shakes its bearing, with a number of turns in a second.
fn rotor(turns: f64, step: f64) -> String {
    format!(
        "coordinates(x, th); lagrangian = dot(x).powi(2) / 2 + 5e-4 * dot(x) * dot(th) * th.cos() + 0.005 * dot(th).powi(2) - 200 * x.powi(2); \
         run {{ start = ([0, 0], [0, {}]); step = {step}; until = 1; }}",
        core::f64::consts::TAU * turns
    )
}

#[test]
fn an_angle_that_turns_too_far_is_told() {
    for (turns, step) in [(100.0, 0.01), (100.0, 0.005), (40.0, 0.0083)] {
        for order in ["2", "4"] {
            let (warnings, _) = run(&rotor(turns, step), &["--order", order]);
            assert!(
                warnings.contains("warning: the angle `th` turns by") && warnings.contains("--step"),
                "{turns} {step} {order}: {warnings}"
            );
        }
    }
}

/// A slow rotor; a fast one on which nothing depends; a coordinate that is no angle.
#[test]
fn what_the_nodes_see_is_not() {
    let texts = [
        rotor(10.0, 0.005),
        "coordinates(x, th); lagrangian = dot(x).powi(2) / 2 + 0.005 * dot(th).powi(2) - 200 * x.powi(2); \
         run { start = ([0.1, 0], [0, 628.3]); step = 0.005; until = 1; }"
            .to_owned(),
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; run { start = ([1], [200]); step = 0.02; until = 5; }"
            .to_owned(),
    ];
    for text in texts {
        let (warnings, _) = run(&text, &[]);
        assert_eq!(warnings, "", "{text}");
    }
}
