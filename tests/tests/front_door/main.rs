//! A user's crate outside the workspace works with the whole command line: with a system that is declared
//! nowhere else, and a `main` of one line.
//!
//! The crate is built in the target folder of the workspace, so that crates of others are built once, with
//! the profile of the crates that `dsocs new` writes (`dsocs-systems/tests/new.rs`), so that they share the
//! engine: without optimization, since they take few steps.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// The user's `main.rs`.
const MAIN: &str = include_str!("beads.rs");

/// The folder of the workspace.
fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// The user's crate.
struct Crate {
    /// Its folder.
    folder: TempDir,
    /// The path of its program.
    program: PathBuf,
}

impl Crate {
    /// Writes the crate and builds it.
    fn build() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let member = |name: &str| workspace().canonicalize().unwrap().join(name);
        let manifest = format!(
            "[package]\nname = \"front-door-beads\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
             [dependencies]\ndsocs-core = {{ path = \"{}\" }}\ndsocs-systems = {{ path = \"{}\", default-features = false, features = [\"cli\"] }}\n\n\
             [profile.dev]\ndebug = false\nlto = \"off\"\n\n\
             [workspace]\n",
            member("dsocs-core").display(),
            member("dsocs-systems").display(),
        );
        fs::write(folder.path().join("Cargo.toml"), manifest).unwrap();
        fs::create_dir(folder.path().join("src")).unwrap();
        fs::write(folder.path().join("src/main.rs"), MAIN).unwrap();
        // the versions of the workspace, which are downloaded already
        let lock = workspace().join("Cargo.lock");
        if lock.exists() {
            fs::copy(lock, folder.path().join("Cargo.lock")).unwrap();
        }
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("..");
        let built = Command::new(env!("CARGO"))
            .args(["build", "--offline", "--message-format", "short"])
            .env("CARGO_TARGET_DIR", &target)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(
            built.status.success(),
            "{}",
            String::from_utf8_lossy(&built.stderr)
        );
        let program = folder
            .path()
            .join(format!("beads{}", std::env::consts::EXE_SUFFIX));
        let name = format!("front-door-beads{}", std::env::consts::EXE_SUFFIX);
        fs::copy(target.join("debug").join(name), &program).unwrap();
        Self { folder, program }
    }

    /// The output of the program with these arguments.
    fn output(&self, arguments: &[&str]) -> Output {
        Command::new(&self.program)
            .args(arguments)
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }

    /// Standard output of the program, which has to succeed.
    fn stdout(&self, arguments: &[&str]) -> String {
        let output = self.output(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {error}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Exit status and standard error of the program, which has to refuse.
    fn refused(&self, arguments: &[&str]) -> (i32, String) {
        let output = self.output(arguments);
        assert!(output.stdout.is_empty(), "{arguments:?}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!message.contains("panicked"), "{message}");
        (output.status.code().unwrap(), message)
    }

    /// The content of a file that it has written.
    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.folder.path().join(name)).unwrap()
    }
}

/// A start for the two beads.
const START: [&str; 4] = ["--q0", "1,-0.5", "--v0", "0,0"];

#[test]
fn a_strangers_crate_has_the_whole_command_line() {
    let beads = Crate::build();
    lists(&beads);
    runs(&beads);
    checks(&beads);
    refuses(&beads);
}

/// Names, units and texts are those of the declaration.
fn lists(beads: &Crate) {
    let list = beads.stdout(&["list"]);
    for part in [
        "beads-on-hoop (unconstrained): Two beads on a hoop that turns about its vertical diameter",
        "theta_1",
        "The angle of each bead from the lowest point",
        "rate",
        "rad/s",
        "The acceleration of gravity",
        "N m",
        "The torque that keeps the hoop turning",
        "--step 0.01 --until 10",
    ] {
        assert!(list.contains(part), "{part}: {list}");
    }
    assert_eq!(list, beads.stdout(&["list", "beads-on-hoop"]));
    let json = beads.stdout(&["list", "--format", "json"]);
    assert!(json.contains("\"name\": \"beads-on-hoop\""), "{json}");
}

/// Runs with a table and a figure; the motion conserves its invariants.
fn runs(beads: &Crate) {
    let files = ["--plot", "beads.svg", "--out", "beads.csv"];
    beads.stdout(&[&["run"], &START[..], &files].concat());
    let names = "t,theta_0,theta_1,v_theta_0,v_theta_1,force_theta_0,force_theta_1,energy,torque";
    let csv = beads.read("beads.csv");
    assert_eq!(csv.lines().next(), Some(names));
    let rows: Vec<Vec<f64>> = csv
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 1001);
    let energies = rows.iter().map(|row| row[7]);
    let (least, most) = energies.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), energy| {
        (least.min(energy), most.max(energy))
    });
    assert!(most - least < 1e-3 * most.abs(), "{least} {most}");
    let moved = rows
        .iter()
        .any(|row| (row[1] - 1.0).abs() > 0.5 && row[8].abs() > 0.01);
    assert!(moved, "the beads move and the motor works");
    assert!(beads.read("beads.svg").starts_with("<svg"));

    // at this rate the lowest point is unstable, and a bead stays up
    let fast = [&["run", "--set", "rate=30", "--columns", "theta_0"], &START[..]].concat();
    let fast = beads.stdout(&fast);
    let angles = fast.lines().skip(1).map(|line| line.parse::<f64>().unwrap());
    assert!(angles.into_iter().all(|angle| angle > 0.9));

    let certified = [
        &["run", "--certify", "--estimate-error", "--until", "1"],
        &START[..],
    ]
    .concat();
    let certified = beads.output(&certified);
    assert!(certified.status.success());
    let head = String::from_utf8(certified.stdout).unwrap();
    let head = head.lines().next().unwrap();
    assert!(
        head.ends_with("torque,regularity_forward,regularity_backward,error_theta_0,error_theta_1"),
        "{head}"
    );
    for options in [["--order", "2"], ["--tolerance", "1e-9"]] {
        let run = [&["run", "--until", "1"][..], &options, &START[..]].concat();
        assert_eq!(beads.stdout(&run).lines().count(), 102);
    }
}

/// The checks of the paper's theorems and the hard cases pass for it.
fn checks(beads: &Crate) {
    let checks = beads.stdout(&[&["check"], &START[..]].concat());
    for check in ["regularity", "symplectic law", "reversibility", "order"] {
        assert!(checks.contains(check), "{checks}");
    }
    assert!(checks.contains(" ok") && !checks.contains("FAILED"), "{checks}");
    let cases = beads.stdout(&[&["stability", "--quick"], &START[..]].concat());
    assert!(
        cases.contains("0 of which do not meet their limit") && cases.contains("cold starts"),
        "{cases}"
    );
    assert!(beads.read("results/stability.json").contains("6 garbage: "));
}

/// Wrong arguments are refused, with the nearest name and the option that helps.
fn refuses(beads: &Crate) {
    for (arguments, parts) in [
        (
            &["run", "--set", "lenght=2"][..],
            &["no parameter `lenght`", "did you mean `length`?"][..],
        ),
        (
            &["run", "beads-on-hop"],
            &["no system `beads-on-hop`", "did you mean `beads-on-hoop`?"],
        ),
        (
            &["run", "--q0", "1,0", "--v0", "0,0", "--columns", "t,theta_2"],
            &["no column `theta_2`", "did you mean `theta_"],
        ),
        (
            &["run"],
            &[
                "`beads-on-hoop` has no start of its own",
                "`--q0 …,… --v0 …,…`",
                "theta_0, theta_1",
            ],
        ),
        (&["check", "--q0", "1,0"], &["`--v0 …,…`"]),
        (
            &["run", "--q0", "1", "--v0", "0,0"],
            &["q0 has 1 component, but there are 2 coordinates: theta_0, theta_1"],
        ),
        (&["paper"], &["paper"]),
    ] {
        let (status, message) = beads.refused(arguments);
        assert_eq!(status, 2, "{arguments:?}: {message}");
        for part in parts {
            assert!(message.contains(part), "{arguments:?}: {message}");
        }
    }
}
