//! The warning about a growing energy: it comes with steps that are too long, and not where a force drives
//! the system.

use super::run;

#[test]
fn an_energy_that_forces_give_is_no_explosion() {
    // driven from rest: by a pivot that begins to move, and by a push
    let driven = [
        "coordinates(th); let u = 0.2 * (-((t - 4.0) / 0.5).powi(2)).exp(); \
         lagrangian = (dot(u + th.sin()).powi(2) + dot(th.cos()).powi(2)) / 2 + 9.81 * (th.cos() - 1); \
         run { start = ([0], [0]); step = 0.01; until = 8; }",
        "coordinates(x); lagrangian = 1.7 * dot(x).powi(2) / 2 - 2.8 * x.powi(4) / 4; \
         external_forces = 0.6 * (-(t - 3).powi(2) * 9.4).exp(); run { start = ([0], [0]); step = 0.002; until = 6; }",
    ];
    for text in driven {
        for order in ["2", "4"] {
            assert_eq!(run(text, &["--order", order]).0, "", "{text}");
        }
    }
    // a spring declared as an external force, with a step that is too long for it
    for (start, step) in [("1", "0.21"), ("0", "0.21"), ("1e-6", "0.3"), ("0", "0.6")] {
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = -100 * x + (3 * t).sin(); \
             run {{ start = ([{start}], [0]); step = {step}; until = 40; }}"
        );
        let (warnings, _) = run(&text, &[]);
        assert!(warnings.contains("the energy grows"), "{text}: {warnings}");
    }
}
