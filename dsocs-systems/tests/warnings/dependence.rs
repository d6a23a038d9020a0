//! The warning about constraints that nearly depend on each other, in runs to a tolerance.

use super::attempt;

/// The warnings of a run of a ball on a sphere whose second constraint differs from the first one by the part
/// `beside`.
fn warnings_of(beside: f64, tolerance: &str) -> String {
    let text = format!(
        "coordinates(x, y, z); lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - 9.81 * z + 0.3 * x * y; let ball = x.powi(2) + y.powi(2) + z.powi(2) - 1; \
         holonomic = [ball, ball + {beside:?} * (z - 0.3 * x)]; \
         run {{ start = ([0.95782628522115132, 0.0, 0.28734788556634538], [0.0, 1.0, 0.0]); step = 0.01; until = 2; }}"
    );
    let (succeeds, [_, warnings]) = attempt(&text, "run", &["--tolerance", tolerance]);
    assert!(succeeds, "{beside} {tolerance}: {warnings}");
    warnings
}

#[test]
fn a_tolerance_that_rounding_does_not_allow_is_told() {
    for (beside, tolerance) in [(1e-12, "1e-9"), (1e-9, "1e-12")] {
        let warnings = warnings_of(beside, tolerance);
        assert!(
            warnings.contains("holonomic constraint 2 says nothing beside those before it but for a part of"),
            "{beside} {tolerance}: {warnings}"
        );
    }
}

/// Constraints whose independent part allows the tolerance give no warning.
#[test]
fn what_is_independent_enough_is_not() {
    for (beside, tolerance) in [(1.0, "1e-14"), (1e-3, "1e-12"), (1e-6, "1e-9")] {
        assert_eq!(warnings_of(beside, tolerance), "", "{beside} {tolerance}");
    }
}

/// Two rods are independent; what makes their forces alike is the light mass between them, and the advice says so.
#[test]
fn a_light_mass_is_no_reason_to_leave_a_constraint_out() {
    let text = "coordinates(a: [2], b: [2]); lagrangian = 1e-9 * dot(a).norm_squared() / 2 + dot(b).norm_squared() / 2 - 9.81 * (1e-9 * a[1] + b[1]); \
                holonomic = [a.norm() - 1, (a - b).norm() - 1]; run { start = ([0.6, -0.8, 1.2, -1.6], [0, 0, 0, 0]); step = 0.01; until = 0.05; }";
    let (succeeds, [_, warnings]) = attempt(text, "run", &["--tolerance", "1e-12"]);
    assert!(
        succeeds
            && warnings.contains("as the masses weigh directions")
            && warnings.contains("a light mass only, make it heavier"),
        "{warnings}"
    );
}
