//! `dsocs new`: the crate that it writes builds without warnings, runs, and gives the bits of the text or
//! system it was made from.
//!
//! It is built in the target folder of the workspace, so that crates of others are built once; without
//! optimization, since it takes few steps. The user's crate of the tests (`front_door`) has the same profile,
//! so both share the engine.

mod program;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use program::dsocs;

/// The folder of the workspace.
fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Builds a crate without a warning, and returns the path of its program.
fn build(crate_folder: &Path, name: &str) -> PathBuf {
    // the versions of the workspace, which are downloaded already
    let lock = workspace().join("Cargo.lock");
    if lock.exists() {
        fs::copy(lock, crate_folder.join("Cargo.lock")).unwrap();
    }
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("..");
    let built = Command::new(env!("CARGO"))
        .args(["build", "--offline", "--message-format", "short"])
        .args(["--config", "profile.dev.debug=false"])
        .args(["--config", "profile.dev.lto='off'"])
        .env("CARGO_TARGET_DIR", &target)
        .current_dir(crate_folder)
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "{stderr}");
    assert!(!stderr.contains("warning"), "{stderr}");
    let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    target.join("debug").join(file)
}

#[test]
fn a_new_crate_builds_runs_and_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let output = dsocs(folder.path(), &["new", "my-swing"]).output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(String::from_utf8(output.stdout).unwrap().contains("cd my-swing"));
    let crate_folder = folder.path().join("my-swing");
    let program = build(&crate_folder, "my-swing");
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

/// Two beads on a wire that moves, as a text with a constant, an array, samples, documentation and a second run.
const BEADS: &str = "//! Two beads on a wire. It moves.
const n = 2;
parameters {
    /// The mass of each bead [kg]
    masses: [n] = [0.1, 0.2],
    stiffness = 40.0,
    push = samples(\"push.csv\", monotone),
}
coordinates(
    /// The place of each bead [m]
    x: [n]
);
let pull = stiffness / 2 * (x[1] - x[0]).powi(2);
lagrangian = sum(0..n, |i| masses[i] / 2 * dot(x[i]).powi(2)) - pull;
external_forces = (push.at(t), -0.1 * dot(x[1]));
/// What the spring holds [J]
let held = pull;
observe = [held];
run { start = ([0.0, 0.1], [0.0; n]); step = 0.01; until = 2.0; }
run fast { start = ([0.0, 0.1], [1.0; n]); step = 0.005; until = 1.0; }
";

#[test]
fn a_crate_of_a_text_file_says_the_same_word_for_word_and_gives_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("beads.dsocs"), BEADS).unwrap();
    fs::write(folder.path().join("push.csv"), "0,0\n1,1\n2,0.5\n").unwrap();
    let output = dsocs(folder.path(), &["new", "--from", "beads.dsocs:fast", "my-beads"])
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let crate_folder = folder.path().join("my-beads");
    let main = fs::read_to_string(crate_folder.join("src/main.rs")).unwrap();
    let words = |text: &str| text.split_whitespace().collect::<String>();
    // constants are written as numbers in Rust
    let declared = BEADS.replace("[n]", "[2]").replace("0..n", "0..2");
    let from = declared.find("coordinates(").unwrap();
    let declared = &declared[from..declared.find("run {").unwrap()];
    assert!(words(&main).contains(&words(declared)), "{main}");
    for line in [
        "//! Two beads on a wire",
        "/// Two beads on a wire. It moves.",
        "/// The mass of each bead [kg]",
        "masses: [f64; 2],",
        "push: Samples,",
    ] {
        assert!(main.lines().any(|found| found.trim() == line), "{line}: {main}");
    }
    assert!(crate_folder.join("push.csv").is_file());
    let program = build(&crate_folder, "my-beads");
    let own = Command::new(program)
        .arg("run")
        .current_dir(&crate_folder)
        .output()
        .unwrap();
    let text = dsocs(folder.path(), &["run", "beads.dsocs:fast"])
        .output()
        .unwrap();
    assert!(own.status.success() && text.status.success());
    assert!(own.stdout == text.stdout, "the same bits");
}

/// Documentation in a text that tries to close its comment and to add functions stays documentation in the
/// Rust of the new crate.
#[test]
fn what_a_text_says_is_no_code_of_the_crate() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = "#![doc = \"One.\\nfn main() { one }\"]\nparameters {\n#[doc = \"two\\n} fn two() {}\"]\nlength = 1.0 }\n\
                   coordinates(#[doc = \"three\\n} fn three() {}\"] x);\nlagrangian = length * dot(x).powi(2);\nrun { start = ([1], [0]); }";
    fs::write(folder.path().join("hostile.dsocs"), hostile).unwrap();
    let output = dsocs(folder.path(), &["new", "--from", "hostile.dsocs", "mine"])
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let main = fs::read_to_string(folder.path().join("mine/src/main.rs")).unwrap();
    for line in main.lines().filter(|line| line.contains("fn ")) {
        let line = line.trim();
        let is_comment = line.starts_with("//") || line.contains("#[doc = ");
        assert!(is_comment || line == "fn main() -> ExitCode {", "{main}");
    }
    // a missing file, an unknown name, and a system that cannot be written as a text
    for (from, part) in [
        ("nowhere.dsocs", "cannot read nowhere.dsocs"),
        ("nothing", "no system"),
        ("particle", "more than a text can say"),
    ] {
        let output = dsocs(folder.path(), &["new", "--from", from, "other"])
            .output()
            .unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && message.contains(part), "{message}");
        assert!(!folder.path().join("other").exists());
    }
}

/// A folder with content, names that no crate may have and a folder that is no checkout are refused.
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
        let output = dsocs(folder.path(), arguments).output().unwrap();
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
