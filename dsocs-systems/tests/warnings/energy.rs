//! The warning about a growing energy: it comes with steps that are too long, and not where a force drives
//! the system.

use super::{attempt, run};

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

/// A ball that falls onto a stiff floor: a contact lasts about 3e-3.
const CONTACTS: [&str; 5] = [
    // in the potential, beside a weak drag; as the external force itself; with a potential that depends on time
    "lagrangian = dot(x).powi(2) / 2 - 9.81 * x - 1e6 * (-x).max(0).powi(2) / 2; external_forces = -1e-6 * dot(x);",
    "lagrangian = dot(x).powi(2) / 2 - 9.81 * x; external_forces = 1e6 * (-x).max(0);",
    "lagrangian = dot(x).powi(2) / 2 - 9.81 * x; external_forces = if x < 0 { -1e6 * x } else { 0 };",
    "lagrangian = dot(x).powi(2) / 2 - (9.81 + 1e-9 * t) * x - 1e6 * (-x).max(0).powi(2) / 2;",
    // without a corner
    "lagrangian = dot(x).powi(2) / 2 - 9.81 * x; external_forces = (-1000 * x).exp();",
];

/// The largest energy of a ball in a run, and its warnings.
fn fall(contact: &str, step: f64, order: &str) -> (f64, String) {
    let text = format!("coordinates(x); {contact} run {{ start = ([1], [0]); step = {step}; until = 3; }}");
    let (succeeds, [table, warnings]) = attempt(&text, "run", &["--order", order, "--columns", "x,v_x"]);
    let energy = |row: &str| {
        let (x, v) = row.split_once(',').unwrap();
        let [x, v]: [f64; 2] = [x, v].map(|number| number.parse().unwrap());
        // in flight
        if x > 0.0 { v * v / 2.0 + 9.81 * x } else { 0.0 }
    };
    let largest = table.lines().skip(1).map(energy).fold(0.0, f64::max);
    (if succeeds { largest } else { f64::INFINITY }, warnings)
}

#[test]
fn a_leap_into_a_stiff_contact_is_told() {
    for contact in CONTACTS {
        let mut told = 0;
        for step in [0.01, 0.0031, 1e-4] {
            for order in ["2", "4", "6"] {
                let (energy, warnings) = fall(contact, step, order);
                // it falls with the energy 9.81, and cannot have more
                if energy > 5.0 * 9.81 {
                    told += 1;
                    let words = ["the energy changes from", "the energy grows", "error:"];
                    let is_told = words.iter().any(|words| warnings.contains(words));
                    assert!(is_told, "{contact} {step} {order}: {energy} {warnings}");
                } else if step < 1e-3 {
                    assert!(energy < 9.9);
                    assert!(!warnings.contains("the energy changes from"), "{warnings}");
                }
            }
        }
        assert!(told >= 3, "{contact}: {told}");
    }
}

#[test]
fn forces_that_steps_resolve_are_not_told() {
    for forces in [
        // a stop of ten steps, relaxation in ten, a push of five, drag that grows with the cube of the speed
        "-1e3 * (x - 0.4).max(0) - 0.1 * dot(x)",
        "1 - 10 * dot(x)",
        "50 * (-((t - 1) / 0.05).powi(2)).exp()",
        "-dot(x).powi(3) - 4 * x",
        "if t < 1 { 0 } else { 3 }",
        "-0.8 * dot(x).signum() + 1.5 * (2 * t).sin()",
        "(t - 0.1).max(0).powi(3) - x",
        "-9 * x + 0.1 * (3 * t).sin()",
    ] {
        for start in ["0], [0", "1e-9], [0", "0.3], [-1"] {
            for order in ["2", "4", "6"] {
                let text = format!(
                    "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = {forces}; \
                     run {{ start = ([{start}]); step = 0.01; until = 5; }}"
                );
                let (warnings, _) = run(&text, &["--order", order]);
                assert!(!warnings.contains("the energy"), "{text}: {warnings}");
            }
        }
    }
}

/// A hill between the nodes gives a free mass a third of its energy: no force changes that.
#[test]
fn a_hill_between_the_nodes_is_told() {
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 0.4 * (1 - ((x - 0.5) / 0.012).powi(2)).max(0).powi(3); \
                run { start = ([0], [1]); step = 0.01; until = 1; }";
    let (warnings, _) = run(text, &[]);
    assert!(warnings.contains("warning: the energy is 6.523e-1"), "{warnings}");
    let (warnings, _) = run(text, &["--step", "0.001"]);
    assert_eq!(warnings, "", "{warnings}");
}
