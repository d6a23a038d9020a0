//! `linearize` and `equilibrium` on the command line, against models by hand.

mod program;

use serde_json::Value;

use program::dsocs;

/// Standard output of a command that succeeds.
fn stdout(arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let output = dsocs(folder.path(), arguments).output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

/// Exit status and standard error of a command that fails.
fn refused(arguments: &[&str]) -> (i32, String) {
    let folder = tempfile::tempdir().unwrap();
    let output = dsocs(folder.path(), arguments).output().unwrap();
    assert!(output.stdout.is_empty(), "{arguments:?}");
    (
        output.status.code().unwrap(),
        String::from_utf8(output.stderr).unwrap(),
    )
}

/// A matrix in JSON.
fn matrix(value: &Value) -> Vec<Vec<f64>> {
    serde_json::from_value(value.clone()).unwrap()
}

#[test]
fn a_model_is_written_as_tables_and_as_json() {
    let about = [
        "linearize",
        "cart-pole",
        "--q0",
        "0,pi",
        "--inputs",
        "mass,gravity",
        "--outputs",
        "theta,force_x",
    ];
    let text = stdout(&about);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[0],
        "cart-pole (second-order): the continuous motion, z' = A z + B u, y = C z + D u"
    );
    assert_eq!(
        lines[1],
        format!("about t = 0, q = 0,{}, v = 0,0", std::f64::consts::PI)
    );
    for name in [" A ", " B ", " C ", " eigenvalues of A"] {
        assert!(lines.iter().any(|line| line.starts_with(name)), "{name}: {text}");
    }
    assert!(!lines.iter().any(|line| line.ends_with(' ')), "{text}");
    let json = stdout(&[&about[..], &["--format", "json"]].concat());
    let printed: Value = serde_json::from_str(&json).unwrap();
    // x″ = k E θ′ cos θ with E = −2 m g l below, and J θ″ = m l (g sin θ − cos θ x″)
    let [energy, arm, inertia, gain] = [-2.0 * 0.1 * 9.81, 0.1, 0.05, 2.0];
    let law = -gain * energy;
    let expected = [
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0, law],
        [0.0, -arm * 9.81 / inertia, 0.0, arm * law / inertia],
    ];
    for (found, expected) in matrix(&printed["A"])
        .iter()
        .flatten()
        .zip(expected.iter().flatten())
    {
        assert!((found - expected).abs() < 1e-13, "{printed:#}");
    }
    assert_eq!(printed["states"][3]["unit"], "rad/s");
    assert_eq!(printed["inputs"][1]["name"], "gravity");
    assert_eq!(
        (&printed["step"], &printed["kind"]),
        (&Value::Null, &Value::from("second-order"))
    );
    assert_eq!(printed["eigenvalues"].as_array().unwrap().len(), 4);
    let step: Value = serde_json::from_str(&stdout(
        &[&about[..], &["--step", "1e-3", "--format", "json"]].concat(),
    ))
    .unwrap();
    assert_eq!(step["step"], 1e-3);
    assert!((matrix(&step["A"])[1][3] - 1e-3).abs() < 1e-5);
}

#[test]
fn equilibria_are_written_once() {
    let text = stdout(&[
        "equilibrium",
        "planar-pendulum",
        "--guess",
        "0.1,-1",
        "--guess",
        "x=-0.2,y=-0.9",
        "--guess",
        "0.1,0.9",
    ]);
    assert_eq!(text.matches("eigenvalues").count(), 2, "{text}");
    assert!(text.contains("unstable; eigenvalues 3.13209, -3.13209"), "{text}");
    assert!(
        text.contains("undecided by the linear model; eigenvalues 0 + 3.13209i, 0 - 3.13209i"),
        "{text}"
    );
    // without another guess the search begins at the system's own start
    let printed: Value = serde_json::from_str(&stdout(&[
        "equilibrium",
        "planar-pendulum",
        "--set",
        "length=2",
        "--format",
        "json",
    ]))
    .unwrap();
    assert_eq!(
        (&printed["of_guess"], &printed["coordinates"]),
        (&serde_json::json!([0]), &serde_json::json!(["x", "y"]))
    );
    assert!(
        (printed["equilibria"][0]["q"][1].as_f64().unwrap() + 2.0).abs() < 1e-12,
        "{printed:#}"
    );
    assert_eq!(printed["equilibria"][0]["isolated"], true);
}

#[test]
fn a_text_file_has_them_too_and_a_failing_guess_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let text = "parameters { push = 0.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2 + x.tanh(); external_forces = push;";
    std::fs::write(folder.path().join("hill.dsocs"), text).unwrap();
    let held = dsocs(
        folder.path(),
        &[
            "equilibrium",
            "hill.dsocs",
            "--guess",
            "0",
            "--hold",
            "x",
            "--free",
            "push",
        ],
    )
    .output()
    .unwrap();
    let table = String::from_utf8(held.stdout).unwrap();
    assert!(held.status.success() && table.contains(" push  -1"), "{table}");
    let none = dsocs(folder.path(), &["equilibrium", "hill.dsocs"])
        .output()
        .unwrap();
    let stderr = String::from_utf8(none.stderr).unwrap();
    assert_eq!(none.status.code(), Some(1));
    assert!(
        stderr.contains("no equilibrium is found from the guess [0]"),
        "{stderr}"
    );
    let model = dsocs(folder.path(), &["linearize", "hill.dsocs", "--q0", "0.5"])
        .output()
        .unwrap();
    assert!(
        String::from_utf8(model.stdout)
            .unwrap()
            .contains("no equilibrium: at the state itself z' =")
    );
}

/// Unknown inputs, systems of third order, states off their constraints and wrong guesses are refused, each
/// with its reason, the exit status and an option that helps.
#[test]
fn what_cannot_be_had_says_why() {
    let (status, message) = refused(&["linearize", "cart-pole", "--inputs", "force"]);
    assert_eq!(status, 2);
    assert!(
        message.contains("no parameter is called `force`, so it is no input; expected `cart`"),
        "{message}"
    );
    let (status, message) = refused(&["linearize", "crane"]);
    assert_eq!(status, 2);
    assert!(
        message.contains("a linear model knows constraints of up to second order")
            && !message.contains("--tolerance"),
        "{message}"
    );
    let (_, message) = refused(&["linearize", "planar-pendulum", "--q0", "0,-2"]);
    assert!(
        message.contains("(on the command line: `--project`)"),
        "{message}"
    );
    assert!(stdout(&["linearize", "planar-pendulum", "--q0", "0,-2", "--project"]).contains("q = 0,-1"));
    let (status, message) = refused(&["equilibrium", "cart-pole", "--guess", "0"]);
    assert_eq!(status, 2);
    assert!(
        message.contains("a guess has 1 component, but there are 2 coordinates"),
        "{message}"
    );
    let (status, message) = refused(&["equilibrium", "arm"]);
    assert_eq!(status, 1);
    assert!(message.contains("does not allow rest"), "{message}");
    let (status, message) = refused(&["equilibrium", "cart-pole", "--guess", "angle=1"]);
    assert_eq!(status, 2);
    assert!(message.contains("angle"), "{message}");
}
