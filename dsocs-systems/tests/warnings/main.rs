//! What the program says of scenes that a mechanician has thought of: warnings where they are due, and none elsewhere; checks that pass, or say why they are
//! open.

mod alternation;
mod checks;
mod dependence;
mod energy;
mod estimates;
mod inputs;
mod jumps;
mod samples;
mod third_order;

use std::fs;
use std::process::Command;

/// Whether a command of the program succeeds with a text, beside which some files lie, and what it writes to standard output and to standard error.
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
    let output = Command::new(env!("CARGO_BIN_EXE_dsocs"))
        .args([command, "scene.dsocs"])
        .args(arguments)
        .current_dir(folder.path())
        .output()
        .unwrap();
    let told = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    (output.status.success(), told)
}

/// The same of a text alone.
fn attempt(text: &str, command: &str, arguments: &[&str]) -> (bool, [String; 2]) {
    attempt_with(&[], text, command, arguments)
}

/// What the program writes to standard error for a text that runs, and the last line that it writes to standard output.
fn run(text: &str, arguments: &[&str]) -> (String, String) {
    let (succeeds, [table, warnings]) = attempt(text, "run", arguments);
    assert!(succeeds, "{text} {arguments:?}: {warnings}");
    (warnings, table.lines().last().unwrap_or_default().to_owned())
}
