//! Tests of systems with rotations on the command line: the number of components of each vector, and the
//! messages where it is wrong.

use clap::Parser;
use dsocs_core::text::Text;

use crate::cli::{Arguments, CliError, Program};
use crate::entry::Entry;

/// A top beside a mass.
const TOP: &str = "
    coordinates(r: rotation, x);
    let w = r.angular_velocity();
    lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - (r * [0.2, 0.1, 1])[2] + dot(x).powi(2) / 2;
";

/// The file that a command with these words writes for a system.
fn written(text: &str, words: &str, ending: &str) -> Result<String, CliError> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join(ending).display().to_string();
    let words = format!("dsocs {words} --out {out}");
    let words: Vec<_> = words.split_whitespace().collect();
    let Arguments { command, .. } = Arguments::try_parse_from(words).unwrap();
    let entry = Entry::of_text("top", &Text::parse("top", text).unwrap(), None);
    let done = command.execute(&mut Program::new(vec![entry.step(0.1)], &[]).verified()?);
    done.map(|()| std::fs::read_to_string(out).unwrap())
}

/// The table that a run writes, with these options.
fn table(options: &str) -> Result<String, CliError> {
    written(TOP, &format!("run top --until 0.2 {options}"), "a.csv")
}

#[test]
fn a_table_has_four_numbers_of_position_and_three_of_velocity_and_force() {
    let table = table("--q0 1,0,0,0,0.5 --v0 0.6,-0.3,3,2 --estimate-error").unwrap();
    let mut lines = table.lines();
    assert_eq!(
        lines.next().unwrap(),
        "t,r_w,r_x,r_y,r_z,x,v_r_x,v_r_y,v_r_z,v_x,force_r_x,force_r_y,force_r_z,force_x,energy,error_r_w,error_r_x,error_r_y,error_r_z,error_x"
    );
    let first = lines.next().unwrap();
    assert!(first.starts_with("0,1,0,0,0,0.5,0.6,-0.3,3,2,"), "{first}");
    assert!(lines.all(|line| line.split(',').count() == 20));
}

#[test]
fn velocities_have_names_of_three() {
    let by_place = table("--q0 1,0,0,0,0.5 --v0 0.6,-0.3,3,2").unwrap();
    let by_name = table("--q0 1,0,0,0,0.5 --v0 r_y=-0.3,r_x=0.6,x=2,r_z=3").unwrap();
    assert_eq!(by_place, by_name);
    let with_zero = table("--q0 r_w=1,r_x=0,r_y=0,r_z=0,x=0.5 --v0 0,0.6,-0.3,3,2").unwrap();
    assert_eq!(by_place, with_zero);
}

#[test]
fn numbers_that_are_too_many_or_no_quaternion_are_told() {
    for (options, messages) in [
        (
            "",
            &[
                "`--q0 …,…,…,…,… --v0 …,…,…,…`",
                "four numbers of a unit quaternion",
                "three of velocity",
            ][..],
        ),
        (
            "--q0 1,0,0,0 --v0 1,2,3,4",
            &["q0 has 4 components", "5 numbers", "r_w, r_x, r_y, r_z, x;"],
        ),
        (
            "--q0 1,0,0,0,0 --v0 1,2,3",
            &["v0 has 3 components", "4 numbers: r_x, r_y, r_z, x;"],
        ),
        (
            "--q0 r_x=0.5 --v0 1,2,3,4",
            &["r_x alone", "--q0 r_w=0.8,r_x=0,r_y=0.6,r_z=0"],
        ),
        (
            "--q0 1,0.5,0,0,0 --v0 1,2,3,4",
            &["the norm 1.118", "`--q0`, all four numbers"],
        ),
        (
            "--q0 1,0,0,0,0 --v0 1,1,2,3,4",
            &["begins with 1", "`--v0`, three numbers"],
        ),
        ("--q0 1,0,0,0,0 --v0 1,2,60,0", &["turns by", "`--step`"]),
    ] {
        let error = table(options).unwrap_err().to_string();
        for message in messages {
            assert!(error.contains(message), "{options}: {error}");
        }
    }
}

#[test]
fn checks_measure_the_order_the_power_and_the_way_back() {
    let bound = format!("{TOP} nonholonomic = w[2]; phi_lagrangian = trapezoid;");
    let damped = format!("{TOP} external_forces = (-0.2 * w, -0.1 * dot(x));");
    for (text, start) in [
        (TOP, "--q0 1,0,0,0,0 --v0 0.6,-0.3,3,1"),
        (&*bound, "--q0 0.6,0.8,0,0,0 --v0 0.6,-0.3,0,1"),
        (&*damped, "--q0 0.6,0,0.8,0,0 --v0 0.6,-0.3,2,1"),
    ] {
        let findings = written(
            text,
            &format!("check top --step 0.05 --until 4 {start}"),
            "a.json",
        );
        let findings = findings.unwrap_or_else(|error| panic!("{error}"));
        for figure in [
            "errors of position",
            "the step with −h",
            "norms from 1",
            "between nodes",
        ] {
            assert!(findings.contains(figure), "{findings}");
        }
    }
    // where dry friction holds the body, the motion cannot be reversed, and the check gives the reason why
    // that is not required
    let held = format!(
        "{TOP} let turn = r.inverse() * [0, 0, 1]; external_forces = (-0.8 * w.inner(turn).signum() * turn, 0);"
    );
    let findings = written(
        &held,
        "check top --step 0.05 --until 4 --q0 1,0,0,0,0 --v0 0.6,-0.3,2,1",
        "a.json",
    );
    let findings = findings.unwrap_or_else(|error| panic!("{error}"));
    assert!(findings.contains("not required here"), "{findings}");
}

#[test]
fn momenta_are_measured_along_what_is_reduced() {
    let body = "coordinates(r: rotation, x);
        let w = r.angular_velocity();
        lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 + dot(x).powi(2) / 2;";
    let bound = format!("{body} nonholonomic = w[2] - dot(x);");
    for (text, conserved) in [(body, true), (&*bound, false)] {
        let findings = written(
            text,
            "check top --step 0.05 --until 4 --q0 0.6,0.8,0,0,0 --v0 0.6,-0.3,0.2,0.2",
            "a.json",
        );
        let findings = findings.unwrap_or_else(|error| panic!("{error}"));
        let figures: serde_json::Value = serde_json::from_str(&findings).unwrap();
        let checks = figures["systems"][0]["checks"].as_array().unwrap();
        for name in [
            "`r` turned about the first axis of space",
            "`r` turned about the second axis of space",
            "`r` turned about the third axis of space",
            "`x` moved",
        ] {
            let of = |what: &str| {
                let own = format!("{name}: {what}");
                let mut named = checks.iter();
                let found = named.find(|check| check["what"].as_str().unwrap().starts_with(&own));
                found.unwrap_or_else(|| panic!("{own}\n{findings}"))
            };
            let (equation, variation) = (of("ΔJ − h⟨Q + f, ξ⟩"), of("variation of J"));
            assert_eq!(equation["relation"], "<=");
            assert_eq!(equation["ok"], true, "{equation}");
            // where the constraint acts along the symmetry, the momentum is only reported
            assert_eq!(variation["relation"].is_null(), !conserved, "{variation}");
            assert_eq!(variation["ok"], true, "{variation}");
            assert_eq!(
                variation["figure"].as_f64().unwrap() > 1e-3,
                !conserved,
                "{variation}"
            );
        }
    }
}
