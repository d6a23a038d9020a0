//! Correct systems fail no check where a motion begins from rest, passes through rest, or hits a stiff
//! spring: each line of the table holds, or is not required, with the reason.

use dsocs_core::text::Text;
use dsocs_systems::Entry;
use dsocs_systems::check::Finding;

use crate::{found, missed, settings};

/// The findings of a text along its own run.
fn findings(text: &str) -> Vec<Finding> {
    let text = Text::parse("text", text).unwrap();
    let entry = Entry::of_text("text", &text, text.runs.first());
    let mut settings = settings(&entry);
    settings.until = Some(entry.checked_end());
    entry.check(&settings).unwrap()
}

/// A sleigh, in terms of the rest of its declaration.
fn sleigh(lagrangian: &str, forces: &str, until: f64) -> String {
    format!(
        "coordinates(x, y, th); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 0.15 * dot(th).powi(2) + {lagrangian};
         nonholonomic = dot(y) * th.cos() - dot(x) * th.sin(); external_forces = {forces};
         run {{ start = ([0, 0, 0], [0, 0, 0]); step = 0.01; until = {until:?}; }}"
    )
}

#[test]
fn rows_from_rest_are_open_where_their_legs_are_rounding_of_others() {
    let aside = "0.3 * dot(th) * (dot(y) * th.cos() - dot(x) * th.sin())";
    for forces in ["(0, 0, 0.3)", "(0, 0, 0.3 * (3 * t).sin())", "(0.01 * t, 0, 0.2)"] {
        let findings = findings(&sleigh(aside, forces, 5.0));
        assert_eq!(missed(&findings), [], "{forces}");
        let rows = found(&findings, "rows at the nodes as written");
        if let Some(excuse) = &rows.excuse {
            assert!(excuse.contains("begins from rest"), "{excuse}");
        }
    }
    // from motion the line is required, and holds
    let moving = sleigh(aside, "(0, 0, 0.3)", 5.0).replace("[0, 0, 0]); step", "[1, 0, 0.4]); step");
    let findings = findings(&moving);
    assert!(found(&findings, "rows at the nodes as written").holds());
}

#[test]
fn a_root_that_is_found_from_far_away_is_no_second_one() {
    for forces in ["(th.cos() * t, th.sin() * t, 0.3 * t)", "(t, 0.2 * t, 0.3 * t)"] {
        let findings = findings(&sleigh("0", forces, 10.0));
        assert_eq!(missed(&findings), [], "{forces}");
        let second = findings
            .iter()
            .find(|finding| finding.what.starts_with("distance of the nearest"));
        assert!(second.is_none_or(Finding::holds), "{second:?}");
    }
}

#[test]
fn a_law_of_the_direction_has_no_order_through_rest() {
    for curvature in ["0.3", "-0.4", "0.1 + 0.1 * t"] {
        let findings = findings(&format!(
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
             let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
             kinematic = (dot(x) * ddot(y) - dot(y) * ddot(x)) / speed.powi(3) - ({curvature});
             variational = [(dot(x), dot(y))];
             run {{ start = ([0, 0], [2, 0]); step = 0.01; until = 3.0; }}"
        ));
        assert_eq!(missed(&findings), [], "{curvature}");
        for finding in findings.iter().filter(|finding| finding.excuse.is_some()) {
            let excuse = finding.excuse.as_ref().unwrap();
            assert!(
                excuse.contains("through rest") || excuse.contains("smooth"),
                "{excuse}"
            );
        }
    }
    // a smooth law through rest is still required to have its order
    let smooth = "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
        external_forces = (-0.2 * dot(x), -0.2 * dot(y));
        run { start = ([0, 0], [0, 2]); step = 0.01; until = 1.0; }";
    let findings = findings(smooth);
    assert!(findings.iter().all(Finding::holds), "{findings:#?}");
}

#[test]
fn an_order_above_the_required_one_is_open_where_a_stiff_spring_is_struck() {
    for stiffness in ["1e8", "1e7"] {
        let findings = findings(&format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 9.81 * x - {stiffness} / 2 * (-x).max(0).powi(2);
             run {{ start = ([1.0], [0.0]); step = 0.001; until = 1.0; }}"
        ));
        assert_eq!(missed(&findings), [], "{stiffness}");
    }
}
