//! Tests of the advice in error messages: each option that an error names is tried and helps; and no message
//! shows NaN as a number.

use std::f64::consts::FRAC_PI_2;

use clap::{CommandFactory, Parser};

use super::systems::{LAW, RUBBED, WEIGHT, entries, entry, execute};
use crate::check::{Begin, Settings};
use crate::cli::{Arguments, Program};
use crate::entry::{Drawing, Entry};

/// The options that an error names.
fn options(error: &str) -> Vec<&str> {
    error
        .split(|c: char| !c.is_ascii_alphanumeric() && c != '-')
        .filter(|word| word.starts_with("--"))
        .collect()
}

/// Commands that are refused, the options that the error names, and for each of them a command that follows it.
const ADVICE: &[(&str, &[(&str, &str)])] = &[
    ("run weight --set mass=0", &[("--set", "run weight --set mass=2")]),
    (
        "check weight --set mass=0",
        &[("--set", "check weight --set mass=2")],
    ),
    (
        "run cone",
        &[("--q0", "run cone --q0 1,0"), ("--set", "run cone --set tip=0.1")],
    ),
    ("run squared", &[]),
    (
        "run rubbed --set smoothing=0",
        &[("--set", "run rubbed --set smoothing=0.01")],
    ),
    (
        "run rubbed --set smoothing=0 --tolerance 1e-9",
        &[("--set", "run rubbed --set smoothing=0.01 --tolerance 1e-9")],
    ),
    (
        "check rubbed --set smoothing=0",
        &[("--set", "check rubbed --set smoothing=0.1")],
    ),
    (
        "run law --v0 0 --start paper",
        &[("--v0", "run law --v0 1 --start paper")],
    ),
    ("run servo --set gain=0", &[("--set", "run servo --set gain=2")]),
    ("run turn --v0 0,0", &[("--v0", "run turn --v0 0,1")]),
    ("run either --v0 0.3", &[("--v0", "run either --v0 0.4")]),
    (
        "run unsigned",
        &[("--near-a0", "run unsigned --near-a0=-2 --until 0.1")],
    ),
    (
        "check unsigned",
        &[("--near-a0", "run unsigned --near-a0 1 --tolerance 1e-9")],
    ),
    (
        "run rod --order 4",
        &[
            ("--order", "run rod --order 2"),
            ("--tolerance", "run rod --tolerance 1e-9"),
        ],
    ),
    (
        "run bend",
        &[("--a0", "run bend --a0 0,0.1"), ("--f0", "run bend --f0 0,0.1")],
    ),
    (
        "check bend",
        &[
            ("--a0", "check bend --a0 0,0.1"),
            ("--f0", "check bend --f0 0,0.1"),
        ],
    ),
    (
        "run weight --a0 1",
        &[("--a0", "run weight"), ("--f0", "run weight")],
    ),
    (
        "run bend --a0 0,0.1 --tolerance 1e-9",
        &[
            ("--tolerance", "run bend --a0 0,0.1"),
            ("--order", "run bend --a0 0,0.1"),
            ("--estimate-error", "run bend --a0 0,0.1"),
        ],
    ),
    (
        "run rod --q0 0.6,-0.7",
        &[("--project", "run rod --q0 0.6,-0.7 --project")],
    ),
    (
        "check rod --q0 0.6,-0.7",
        &[("--project", "check rod --q0 0.6,-0.7 --project")],
    ),
    (
        "run weight --until -1",
        &[
            ("--until", "run weight --until 1"),
            ("--step", "run weight --until -1 --step -0.01"),
        ],
    ),
];

#[test]
fn advice_is_followed_to_the_letter() {
    let folder = tempfile::tempdir().unwrap();
    let syntax = Arguments::command();
    for (refused, advice) in ADVICE {
        let error = match execute(folder.path(), refused) {
            Err(error) => error.to_string(),
            Ok(()) => panic!("{refused}: not refused"),
        };
        let named = options(&error);
        let expected: Vec<&str> = advice.iter().map(|(option, _)| *option).collect();
        assert_eq!(named, expected, "{refused}: {error}");
        let command = refused
            .split(' ')
            .next()
            .and_then(|name| syntax.find_subcommand(name))
            .unwrap();
        for (option, followed) in *advice {
            let known = command.get_arguments().filter_map(|argument| argument.get_long());
            assert!(
                known.into_iter().any(|long| option[2..] == *long),
                "{refused}: {option}"
            );
            if let Err(error) = execute(folder.path(), followed) {
                panic!("{refused}: {option}, as in `{followed}`: {error}");
            }
        }
    }
}

/// Commands that are refused or end early, and the words that their messages contain.
const WORDS: &[(&str, &[&str])] = &[
    (
        "run rubbed --set smoothing=0",
        &[
            "the divisor `smoothing` is zero there",
            "its parameters need other values",
        ],
    ),
    (
        "run turn --v0 0,0",
        &[
            "the divisor `",
            "dot(x).powi(2) + dot(y).powi(2)",
            "start with a velocity",
        ],
    ),
    ("run edge --q0 0", &["the divisor `x` is zero"]),
    (
        "run law --v0 0 --start paper",
        &[
            "would stay at rest for ever",
            "kinematic constraint 1 says nothing",
            "branch = divide",
        ],
    ),
    ("run law --q1 1", &["would stay at rest for ever"]),
    (
        "run forgotten --tolerance 1e-9 --until 20",
        &["gets no further", "branch = divide", "friction that it forgets"],
    ),
    (
        "run idle --set gain=0",
        &["kinematic constraint 1 and equation of motion 1 without constraint forces"],
    ),
];

#[test]
fn errors_say_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    for (refused, words) in WORDS {
        let message = match execute(folder.path(), refused) {
            Err(error) => error.to_string(),
            Ok(()) => panic!("{refused}: not refused"),
        };
        for word in *words {
            assert!(message.contains(word), "{refused}: {word}: {message}");
        }
        assert!(!message.contains("virtual displacement"), "{refused}: {message}");
    }
}

#[test]
fn a_mistake_in_an_entry_is_that_of_its_system_alone() {
    let entries = || {
        vec![
            entry("rubbed", RUBBED).start([1.0], [0.0]),
            entry("weight", WEIGHT)
                .start([1.0], [0.0])
                .drawn(|&[x]: &[f64; 1], parameters| Drawing::new().point([x, parameters.get("mas")])),
            entry("law", LAW).named("twice"),
            entry("law", LAW).named("twice"),
        ]
    };
    let folder = tempfile::tempdir().unwrap();
    let execute = |words: &str| {
        let out = folder.path().join("a.csv").display().to_string();
        let words = words.replace("OUT", &out);
        let Arguments { command, .. } =
            Arguments::try_parse_from(core::iter::once("dsocs").chain(words.split(' '))).unwrap();
        command.execute(&mut Program::new(entries(), &[]).verified()?)
    };
    for good in [
        "run rubbed --until 0.1 --out OUT",
        "check rubbed --until 0.5",
        "list",
    ] {
        assert!(execute(good).is_ok(), "{good}");
    }
    for (refused, words) in [
        ("run weight --out OUT", "did you mean `mass`?"),
        ("list weight", "did you mean `mass`?"),
        ("check rubbed --out a.csv", "has to end in .json"),
        ("run rubbed --out a.txt", "`--format csv`"),
        ("run twice --out OUT", "two of this name"),
    ] {
        let message = execute(refused).unwrap_err().to_string();
        assert!(message.contains(words), "{refused}: {message}");
    }
}

/// The output of a check and of the hard cases of a system.
fn printed(entry: &Entry, until: f64, h: f64) -> String {
    let [q0, v0] = entry.default_start().unwrap();
    let settings = Settings {
        h,
        until: Some(until),
        t0: 0.0,
        q0,
        v0,
        a0: None,
        begin: Begin::default(),
    };
    let mut text = match entry.check(&settings) {
        Ok(findings) => {
            for finding in &findings {
                assert!(
                    finding.failure.is_some() || finding.figure.is_finite(),
                    "{finding:?}"
                );
            }
            crate::cli::commands::check::text(&findings)
        }
        Err(error) => error.to_string(),
    };
    for case in crate::stability::any::CASES
        .iter()
        .filter(|case| case.number != 1)
    {
        let rows = case.run(entry, &settings, true, &mut |_| ());
        text += &crate::cli::commands::stability::table(&rows).to_string();
    }
    text
}

#[test]
fn no_number_is_shown_where_there_is_none() {
    for entry in entries() {
        // the dry mass sticks after 1.4 s, the edge is met backward
        let until = if entry.name() == "dry" { 4.0 } else { 0.3 };
        for h in [0.01, -0.01] {
            let text = printed(&entry, until * f64::signum(h), h);
            // the hard cases substitute NaN for a parameter and say so
            let text = text.replace("set to NaN", "");
            assert!(!text.contains("NaN"), "{}: {text}", entry.name());
        }
    }
}

/// The message for arguments that cannot be read.
fn refused(words: &str) -> String {
    let given = || core::iter::once("dsocs").chain(words.split(' '));
    let error = Arguments::try_parse_from(given()).unwrap_err();
    let given = given().map(ToOwned::to_owned);
    crate::cli::with_option_hint(error, &Arguments::command(), given).to_string()
}

#[test]
fn options_by_their_names_elsewhere_lead_to_those_here() {
    for (words, meant) in [
        ("run dry --dt 0.1", "--step"),
        ("run dry --h 0.1", "--step"),
        ("run dry --dt=0.1", "--step"),
        ("check dry --h 0.1", "--step"),
        ("stability dry --dt 0.1", "--step"),
        ("run dry --tend 5", "--until"),
        ("run dry --tol 1e-9", "--tolerance"),
        ("run dry --x0 1", "--q0"),
        ("run dry --output a.csv", "--out"),
    ] {
        let text = refused(words);
        assert!(
            text.contains(&format!("a similar argument exists: '{meant}'")),
            "{words}: {text}"
        );
        assert!(!text.contains("-- --"), "{words}: {text}");
    }
    // a command without that option gets no hint
    let text = refused("list --dt 0.1");
    assert!(!text.contains("--step"), "{text}");
    // a misspelt option is corrected by clap itself
    let text = refused("run dry --untill 1");
    assert!(text.contains("'--until'"), "{text}");
    let text = refused("check dry --input dry=a.csv");
    assert!(
        text.contains("--set NAME=VALUE") && text.contains("run --input"),
        "{text}"
    );
}

#[test]
fn starts_by_the_names_of_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let first = |start: &str| {
        let words = format!("run forgotten --until 0.02 {start}");
        execute(folder.path(), words.trim_end()).map(|()| {
            let table = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
            let row = table.lines().nth(1).unwrap();
            row.split(',')
                .skip(1)
                .take(4)
                .map(|field| field.parse::<f64>().unwrap())
                .collect::<Vec<_>>()
        })
    };
    // the system's own start is (0.3, -0.2), (0, 0.5)
    for (start, expected) in [
        ("", [0.3, -0.2, 0.0, 0.5]),
        ("--q0 y=0.4", [0.3, 0.4, 0.0, 0.5]),
        ("--q0 y=0.4,x=-0.1", [-0.1, 0.4, 0.0, 0.5]),
        ("--q0 x=90deg --v0 x=-pi/2", [FRAC_PI_2, -0.2, -FRAC_PI_2, 0.5]),
        ("--q0 1,2 --v0 3,4", [1.0, 2.0, 3.0, 4.0]),
    ] {
        assert_eq!(first(start).unwrap(), expected, "{start}");
    }
    for (start, message) in [
        (
            "--q0 x=1,2",
            "`--q0`: some numbers have the names of coordinates and others have not",
        ),
        ("--q0 x=1,x=2", "the coordinate `x` is given twice"),
        ("--v0 z=1", "there is no coordinate `z`; known: x, y"),
        ("--near-a0 x=1", "the coordinate `y` has no value"),
        ("--q1 y=1", "`--q1`: the coordinate `x` has no value"),
    ] {
        let error = first(start).unwrap_err().to_string();
        assert!(error.contains(message), "{start}: {error}");
    }
}

#[test]
fn a_field_that_is_no_parameter_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for words in ["run springs --set springs=3", "run springs --input springs=a.csv"] {
        let error = execute(folder.path(), words).unwrap_err().to_string();
        assert!(
            error.contains("is of type `u32`, and parameters are fields of type `f64`"),
            "{words}: {error}"
        );
    }
    let error = execute(folder.path(), "run springs --set sprigs=3")
        .unwrap_err()
        .to_string();
    assert!(!error.contains("u32"), "{error}");
}
