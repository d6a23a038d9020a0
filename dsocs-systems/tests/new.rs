//! `dsocs new`: the crate that it writes builds, runs, and is checked.
//!
//! It is built in the target folder of the workspace and with its profile, so that dependencies are built once.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The command with these arguments, in this folder.
fn dsocs(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dsocs"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// The folder of the workspace.
fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[test]
fn a_new_crate_builds_runs_and_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let told = dsocs(folder.path(), &["new", "my-swing"]);
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    assert!(String::from_utf8(told.stdout).unwrap().contains("cd my-swing"));
    let crate_folder = folder.path().join("my-swing");
    // the versions that the workspace was built with, which are here already
    let lock = workspace().join("Cargo.lock");
    if lock.exists() {
        fs::copy(lock, crate_folder.join("Cargo.lock")).unwrap();
    }
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("..");
    let built = Command::new(env!("CARGO"))
        .args(["build", "--offline", "--message-format", "short"])
        .args(["--config", "profile.dev.opt-level=1"])
        .args(["--config", "profile.dev.debug='line-tables-only'"])
        .args(["--config", "profile.dev.lto='off'"])
        .args(["--config", "profile.dev.package.'*'.opt-level=0"])
        .args(["--config", "profile.dev.package.'*'.debug=false"])
        .env("CARGO_TARGET_DIR", &target)
        .current_dir(&crate_folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "{said}");
    assert!(!said.contains("warning"), "{said}");

    let program = target
        .join("debug")
        .join(format!("my-swing{}", std::env::consts::EXE_SUFFIX));
    let answer = |arguments: &[&str]| {
        let output = Command::new(&program)
            .args(arguments)
            .current_dir(&crate_folder)
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8(output.stdout).unwrap()
    };
    let list = answer(&["list"]);
    for part in [
        "spring-pendulum (unconstrained): A mass that swings on a spring, in a vertical plane",
        "The pull of the spring",
        "--q0 1.2,0.8",
    ] {
        assert!(list.contains(part), "{part}: {list}");
    }
    let rows = answer(&["run"]);
    assert_eq!(rows.lines().count(), 1002);
    answer(&["run", "--report", "motion.html"]);
    let page = fs::read_to_string(crate_folder.join("motion.html")).unwrap();
    assert!(page.contains("data-kind=\"rod\""));
    let check = answer(&["check"]);
    assert!(check.contains(" ok") && !check.contains("FAILED"), "{check}");
}

#[test]
fn what_is_no_place_or_no_name_for_a_crate_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("full")).unwrap();
    fs::write(folder.path().join("full/notes"), "mine").unwrap();
    for (arguments, part) in [
        (&["new", "full"][..], "not empty"),
        (&["new", "2fast"], "is no name for a new crate"),
        (&["new", "dsocs-core"], "is no name for a new crate"),
        (&["new", "mine", "--checkout", "full"], "no checkout of dsocs"),
    ] {
        let output = dsocs(folder.path(), arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(part), "{message}");
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        1,
        "nothing was written"
    );
}
