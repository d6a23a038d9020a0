//! The warning about arguments of sines that change too far in a step: the nodes may see the same of a rotor in every turn.

use core::f64::consts::TAU;

use super::run;

/// A rotor whose unbalanced mass shakes its bearing, with a number of turns in a second.
fn rotor(turns: f64, step: f64) -> String {
    format!(
        "coordinates(x, th); lagrangian = dot(x).powi(2) / 2 + 5e-4 * dot(x) * dot(th) * th.cos() + 0.005 * dot(th).powi(2) - 200 * x.powi(2); \
         run {{ start = ([0, 0], [0, {}]); step = {step}; until = 1; }}",
        TAU * turns
    )
}

/// The warnings of a run of a text, by steps of order 2 or by a composition.
fn warnings(text: &str, order: &str) -> String {
    run(text, &["--order", order]).0
}

#[test]
fn an_angle_that_turns_too_far_is_told() {
    for (turns, step) in [(100.0, 0.01), (100.0, 0.005), (40.0, 0.0083)] {
        for order in ["2", "4"] {
            let told = warnings(&rotor(turns, step), order);
            assert!(
                told.contains("warning: `th` changes by") && told.contains("--step"),
                "{turns} {step} {order}: {told}"
            );
        }
    }
}

/// A washboard with a parameter as wave number, a gear, a rotor that becomes fast, one in a kinematic constraint, one in a force.
#[test]
fn so_are_other_arguments() {
    let until_one = |start: &str| format!("run {{ start = {start}; step = 0.01; until = 1; }}");
    let texts = [
        (
            "x * k",
            "parameters { k = 314.159265358979 } coordinates(x, y); lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2; \
             external_forces = (0, (k * x).cos() - y);"
                .to_owned()
                + &until_one("([0, 0], [2, 0])"),
        ),
        (
            "th * 3.5",
            "coordinates(th, y); lagrangian = dot(th).powi(2) / 2 + dot(y).powi(2) / 2; external_forces = (0, (3.5 * th).sin() - y);".to_owned()
                + &until_one("([0, 0], [180, 0])"),
        ),
        (
            "th",
            "coordinates(x, th); lagrangian = dot(x).powi(2) / 2 + 5e-4 * dot(x) * dot(th) * th.cos() + 0.005 * dot(th).powi(2) - 200 * x.powi(2); \
             external_forces = (0, 3);"
                .to_owned()
                + &until_one("([0, 0], [0, 0])"),
        ),
        (
            "th",
            "coordinates(x, th); lagrangian = dot(x).powi(2) / 2 + dot(th).powi(2) / 2; nonholonomic = dot(x) - th.cos();".to_owned()
                + &until_one("([0, 0], [1, 628.4])"),
        ),
    ];
    for (argument, text) in texts {
        let told = warnings(&text, "2");
        assert!(
            told.contains(&format!("warning: `{argument}` changes by")),
            "{text}: {told}"
        );
    }
}

/// A slow rotor; a fast one on which nothing depends; one whose sine and cosine make one; a coordinate that is no angle.
#[test]
fn what_the_nodes_see_is_not() {
    let texts = [
        rotor(10.0, 0.005),
        "coordinates(x, th); lagrangian = dot(x).powi(2) / 2 + 0.005 * dot(th).powi(2) - 200 * x.powi(2); \
         run { start = ([0.1, 0], [0, 628.3]); step = 0.005; until = 1; }"
            .to_owned(),
        "coordinates(x, th); let a = th.cos(); let b = th.sin(); \
         lagrangian = dot(a).powi(2) / 2 + dot(b).powi(2) / 2 + dot(x).powi(2) / 2 - 200 * x.powi(2); \
         run { start = ([0.1, 0], [0, 300]); step = 0.01; until = 1; }"
            .to_owned(),
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; run { start = ([1], [200]); step = 0.02; until = 5; }"
            .to_owned(),
    ];
    for text in texts {
        let (warnings, _) = run(&text, &[]);
        assert_eq!(warnings, "", "{text}");
    }
}
