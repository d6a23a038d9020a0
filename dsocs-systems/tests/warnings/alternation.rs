//! The warning about coordinates that alternate from step to step: it comes where a motion is too fast for
//! the step, and not elsewhere.

use super::attempt;

/// The warnings of a run that succeeds.
fn warnings_of(text: &str, arguments: &[&str]) -> String {
    let (succeeds, [_, warnings]) = attempt(text, "run", arguments);
    assert!(succeeds, "{text} {arguments:?}: {warnings}");
    warnings
}

/// A spring with a very small mass, in a damper.
const STIFF: &str = "coordinates(x, y); lagrangian = dot(x).powi(2) / 2 + 1e-9 * dot(y).powi(2) / 2 - 5 * (x - y).powi(2) / 2 - x.powi(2) / 2; \
                     external_forces = (0, -2 * dot(y)); run { start = ([1.0, 0.0], [0.0, 2.5]); step = 0.01; until = 5.0; }";

#[test]
fn a_parasitic_mode_is_told() {
    for step in ["0.1", "0.03", "0.01", "0.001"] {
        let warnings = warnings_of(STIFF, &["--step", step]);
        assert!(
            warnings.contains("goes to and fro from step to step"),
            "{step}: {warnings}"
        );
    }
}

/// Rounding about an equilibrium, an oscillation of nine steps a period and a damper that the step resolves
/// give no warning.
#[test]
fn what_rests_and_what_is_followed_is_not() {
    let texts = [
        // rounding about an equilibrium
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 300 * (x - 0.1).powi(2) - (x * y - 0.3).powi(2); \
         external_forces = (-3 * dot(x), -dot(y)); run { start = ([0.3, 0.2], [0.0, 0.0]); step = 0.02; until = 40; }",
        // nine steps a period
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 0.5 * x.powi(2); run { start = ([1.0], [0.0]); step = 0.7; until = 200; }",
        // a fast damper that the step resolves until rest
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; external_forces = -150 * dot(x); \
         run { start = ([1.0], [1.0]); step = 0.01; until = 5; }",
    ];
    for text in texts {
        assert_eq!(warnings_of(text, &[]), "", "{text}");
    }
}
