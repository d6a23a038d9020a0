//! The command line under adverse conditions: full disks, signals, partial files, wrong arguments.
#![cfg(target_os = "linux")]

mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use program::dsocs;

fn output(folder: &Path, arguments: &[&str]) -> (Output, String) {
    let output = dsocs(folder, arguments).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!message.contains("panicked"), "{arguments:?}: {message}");
    (output, message)
}

#[test]
fn a_full_disk_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        ["run", "particle", "--until", "100", "--out", "/dev/full"],
        ["run", "particle", "--until", "1", "--out", "/dev/full"],
    ] {
        let (output, message) = output(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(
            message.contains("/dev/full") && message.contains("No space left"),
            "{message}"
        );
    }
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = dsocs(folder.path(), &["run", "particle", "--until", "100"])
        .stdout(full)
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("cannot write standard output"), "{message}");
}

/// A run that is interrupted completes its table with the rows it has.
#[test]
fn an_interrupted_run_keeps_its_rows() {
    for signal in ["-INT", "-TERM"] {
        let folder = tempfile::tempdir().unwrap();
        let arguments = [
            "run", "pendulum", "--until", "1e9", "--every", "1000", "--out", "long.csv",
        ];
        let child = dsocs(folder.path(), &arguments)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        sleep(Duration::from_millis(500));
        let id = child.id().to_string();
        assert!(
            Command::new("kill")
                .args([signal, &id])
                .status()
                .unwrap()
                .success()
        );
        let output = child.wait_with_output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{message}");
        assert!(message.contains("interrupted"), "{message}");
        let table = fs::read_to_string(folder.path().join("long.csv")).unwrap();
        assert!(
            table.lines().count() > 2 && table.ends_with('\n'),
            "{} bytes",
            table.len()
        );
        let names: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
        assert_eq!(names.len(), 1, "no half file is left: {names:?}");
    }
}

/// A run that is killed leaves its temporary file; the next one reports it, and the target is unchanged.
#[test]
fn a_killed_run_leaves_a_marked_half() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("long.csv");
    fs::write(&target, "old").unwrap();
    let arguments = [
        "run", "pendulum", "--until", "1e9", "--every", "1000", "--out", "long.csv",
    ];
    let mut child = dsocs(folder.path(), &arguments).spawn().unwrap();
    sleep(Duration::from_millis(500));
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(fs::read_to_string(&target).unwrap(), "old");
    let (output, message) = output(
        folder.path(),
        &["run", "particle", "--until", "1", "--out", "short.csv"],
    );
    assert!(
        output.status.success() && message.contains("half a file"),
        "{message}"
    );
}

#[test]
fn damaged_arguments_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let long = "9".repeat(5000);
    for arguments in [
        &["run", "particle", "--step", "1e-320"][..],
        &["run", "particle", "--step", "1e300"],
        &["run", "particle", "--step", "nan"],
        &["run", "particle", "--until", "inf"],
        &["run", "particle", "--until", "--", "-inf"],
        &["run", "particle", "--q0", "1,2,3"],
        &["run", "particle", "--q0", ""],
        &["run", "particle", "--q0", "1,,2"],
        &["run", "particle", "--set", "mass"],
        &["run", "particle", "--set", "mass=\u{1F600}"],
        &["run", "particle", "--set", "=1"],
        &["run", "particle", "--v0", &long],
        &["run", "particle", "--every", "0"],
        &["run", "particle", "--every", "-1"],
        &["run", "particle", "--out", ""],
        &["run", "particle", "--out", "a.txt"],
        &["run", "particle", "--columns", ""],
        &["run", ""],
        &["stability", "--cases", "x"],
        &["stability", "--cases", "99"],
        &["stability", "--out", "/dev/null"],
    ] {
        let (output, message) = output(folder.path(), arguments);
        assert!(!output.status.success() && !message.is_empty(), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing is left behind"
    );
}

#[test]
fn a_certified_run_tells_where_regularity_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let (output, message) = output(
        folder.path(),
        &[
            "run",
            "pendulum",
            "--until",
            "1",
            "--certify",
            "--columns",
            "t,regularity_forward,regularity_backward",
        ],
    );
    assert!(output.status.success() && message.is_empty(), "{message}");
    let table = String::from_utf8(output.stdout).unwrap();
    for line in table.lines().skip(2) {
        let numbers: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        assert!(numbers[1] > 1e-4 && numbers[2] > 1e-4, "{line}");
    }
    // without mass only the curvature binds the particle: its acceleration cannot be solved for
    let arguments = ["run", "particle", "--until", "1", "--certify", "--set", "mass=0"];
    let (refused, message) = self::output(folder.path(), &arguments);
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(refused.stdout.is_empty());
    assert!(
        message.contains("has no mass and no row determines it (the Jacobian is singular)"),
        "{message}"
    );
    // with a start that needs no acceleration, the step's own row has no mass
    let arguments = [&arguments[..], &["--start", "paper"]].concat();
    let (refused, message) = self::output(folder.path(), &arguments);
    assert_eq!(refused.status.code(), Some(1), "{message}");
    assert!(
        message.contains("a denominator or a factor of a declared equation is zero"),
        "{message}"
    );
}
