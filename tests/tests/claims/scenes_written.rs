//! Random scenes written out as declarations, with their topology in the text. A generated crate declares
//! them, and is built and run. The test is the long form of [`super::scenes`]: the kinds and maps are those
//! of that file, with 2 to 16 bodies.

use std::fs;
use std::path::Path;
use std::process::Command;

use dsocs_tests::scenes::text::program;

/// The number of scenes that are declared.
const SCENES: u64 = 24;

/// Runs of each declaration, with other parameters and another state each time.
const VARIATIONS: u64 = 10;

/// The number of steps of each run.
const STEPS: usize = 100;

#[test]
#[ignore = "long: 24 declarations are built and 240 scenes run in some minutes"]
fn written_scenes_are_those_of_a_second_formulation() {
    let folder = tempfile::tempdir().unwrap();
    let workspace = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let workspace = workspace.canonicalize().unwrap();
    // packages of the workspace are dependencies here and get their own opt-level: unoptimized, the second
    // formulation would take half an hour
    let manifest = format!(
        "[package]\nname = \"random-scenes\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[dependencies]\n\
         dsocs-core = {{ path = \"{}\", features = [\"num-dual\"] }}\ndsocs-tests = {{ path = \"{}\" }}\n\n\
         [profile.dev]\nopt-level = 1\ndebug = \"line-tables-only\"\n\n\
         [profile.dev.package.\"*\"]\nopt-level = 0\ndebug = false\n\n\
         [profile.dev.package.dsocs-core]\nopt-level = 1\n\n[profile.dev.package.dsocs-tests]\nopt-level = 1\n\n[workspace]\n",
        workspace.join("dsocs-core").display(),
        workspace.join("tests").display(),
    );
    fs::write(folder.path().join("Cargo.toml"), manifest).unwrap();
    fs::create_dir(folder.path().join("src")).unwrap();
    fs::write(
        folder.path().join("src/main.rs"),
        program(0..SCENES, VARIATIONS, STEPS),
    )
    .unwrap();
    // the versions of the workspace, which are on the machine already
    let lock = workspace.join("Cargo.lock");
    if lock.exists() {
        fs::copy(lock, folder.path().join("Cargo.lock")).unwrap();
    }
    let ran = Command::new(env!("CARGO"))
        .args(["run", "--offline", "--message-format", "short"])
        .env(
            "CARGO_TARGET_DIR",
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(".."),
        )
        .current_dir(folder.path())
        .output()
        .unwrap();
    println!("{}", String::from_utf8_lossy(&ran.stdout));
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
}
