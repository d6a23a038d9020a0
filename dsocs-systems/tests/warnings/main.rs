//! The messages of the program on realistic scenes: warnings where they are due, and none elsewhere; checks
//! that pass, or give the reason why they are not required.

mod alternation;
mod arguments;
mod checks;
mod dependence;
mod energy;
mod estimates;
mod increments;
mod inputs;
mod jumps;
#[path = "../program/mod.rs"]
mod program;
mod samples;
mod third_order;

use std::fs;

/// Whether a command succeeds on a text, with some files beside it; and its standard output and standard
/// error.
fn attempt_with(
    files: &[(&str, String)],
    text: &str,
    command: &str,
    arguments: &[&str],
) -> (bool, [String; 2]) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.dsocs"), text).unwrap();
    for (name, content) in files {
        fs::write(folder.path().join(name), content).unwrap();
    }
    let output = program::dsocs(folder.path(), &[command, "scene.dsocs"])
        .args(arguments)
        .output()
        .unwrap();
    let outputs = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    (output.status.success(), outputs)
}

/// Whether a command succeeds on a text alone; and its standard output and standard error.
fn attempt(text: &str, command: &str, arguments: &[&str]) -> (bool, [String; 2]) {
    attempt_with(&[], text, command, arguments)
}

/// Standard error of a run that succeeds, and the last line of its standard output.
fn run(text: &str, arguments: &[&str]) -> (String, String) {
    let (succeeds, [table, warnings]) = attempt(text, "run", arguments);
    assert!(succeeds, "{text} {arguments:?}: {warnings}");
    (warnings, table.lines().last().unwrap_or_default().to_owned())
}
