//! The command line: exit status, messages and files of every command.

mod program;

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Output, Stdio};

use dsocs_systems::systems;
use serde_json::Value;

use program::dsocs;

/// The output of the command with these arguments, in an empty folder.
fn output(arguments: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    dsocs(folder.path(), arguments).output().unwrap()
}

/// Standard output of a command that succeeds.
fn stdout(arguments: &[&str]) -> String {
    let output = output(arguments);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(
        output.stderr.is_empty(),
        "no progress where standard error is no terminal"
    );
    String::from_utf8(output.stdout).unwrap()
}

/// Exit status and standard error of a command that fails without writing rows.
fn refused(arguments: &[&str]) -> (i32, String) {
    let output = output(arguments);
    assert!(output.stdout.is_empty(), "{arguments:?}");
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(!message.contains("panicked"), "{message}");
    (output.status.code().unwrap(), message)
}

/// The rows of a table on standard output, without the names.
fn rows(csv: &str) -> Vec<Vec<f64>> {
    let number = |field: &str| {
        if field.is_empty() {
            f64::NAN
        } else {
            field.parse().unwrap()
        }
    };
    csv.lines()
        .skip(1)
        .map(|line| line.split(',').map(number).collect())
        .collect()
}

#[test]
fn run_writes_the_columns_in_short_numbers_that_read_back_the_same() {
    let run = ["run", "particle", "--step", "0.1", "--until", "1"];
    let csv = stdout(&run);
    assert_eq!(csv.lines().next(), Some("t,x,y,v_x,v_y,force_x,force_y,energy"));
    assert_eq!(csv.lines().count(), 12);
    assert_eq!(
        csv.lines().nth(2).and_then(|line| line.split(',').next()),
        Some("0.1")
    );
    let json = stdout(&[&run[..], &["--format", "json"]].concat());
    // field by field as text: serde_json reads numbers to the last bit only with a feature
    let lines = json.lines().skip(1).filter_map(|line| line.strip_prefix('['));
    let all = lines.flat_map(|line| line.trim_end_matches([',', ']']).split(','));
    let fields = csv.lines().skip(1).flat_map(|line| line.split(','));
    assert_eq!(all.clone().count(), 11 * 8);
    for (value, field) in all.zip(fields) {
        let [value, number]: [f64; 2] = [value, field].map(|text| text.parse().unwrap());
        assert_eq!(number.to_bits(), value.to_bits());
        assert!(field.len() <= format!("{value}").len(), "{field}");
    }

    let csv = stdout(&["run", "pendulum", "--until", "0.2"]);
    let names = "t,theta,psi,v_theta,v_psi,force_theta,force_psi,energy,lyapunov,dissipation,w,lambda_0";
    assert_eq!(csv.lines().next(), Some(names));
    let first = &rows(&csv)[0];
    assert!((first[8] - 14_770.162_450_804_23).abs() < 1e-9);
}

#[test]
fn starts_parameters_and_intervals_are_what_was_asked_for() {
    let second = |arguments: &[&str]| {
        rows(&stdout(
            &[&["run", "particle", "--until", "0.4"], arguments].concat(),
        ))[1]
            .clone()
    };
    let paper = second(&["--start", "paper", "--v0", "1,-2"]);
    assert_eq!(paper[1..3], [0.1, -0.2]);
    let nodes = second(&["--q0", "-1,-1", "--q1", "-0.9,-1.1"]);
    assert_eq!(nodes[1..3], [-0.9, -1.1]);
    let curved = second(&["--set", "curvature=2", "--set", "mass=3"]);
    assert!(
        (curved[7] - 3.0 * second(&[])[7]).abs() < 1e-12,
        "the energy of a mass of 3"
    );
    assert!(curved[3] < second(&[])[3]);
    let every = second(&["--every", "2"]);
    assert_eq!(every[..1], [0.2]);

    let backwards = rows(&stdout(&[
        "run",
        "particle",
        "--step",
        "-0.1",
        "--until",
        "-0.3",
        "--columns",
        "x,t",
    ]));
    let times: Vec<f64> = backwards.iter().map(|row| row[1]).collect();
    assert_eq!(times, [0.0, -0.1, -0.2, -0.1 * 3.0]);
}

/// The last row of a run of the particle to t = 10, whose motion is a circle: `x` and its exact value.
fn last_x(options: &[&str]) -> [f64; 2] {
    let csv = stdout(&[&["run", "particle", "--until", "10"], options].concat());
    let rows = rows(&csv);
    assert_eq!(rows.len(), 101);
    let last = &rows[100];
    let angle = std::f64::consts::SQRT_2 * last[0] - std::f64::consts::FRAC_PI_4;
    [last[1], angle.cos() - std::f64::consts::FRAC_1_SQRT_2]
}

#[test]
fn order_and_tolerance_choose_the_method() {
    let error = |options: &[&str]| {
        let [x, exact] = last_x(options);
        (x - exact).abs()
    };
    let two = error(&[]);
    assert!(two > 1e-3);
    assert_eq!(
        last_x(&["--order", "2"]).map(f64::to_bits),
        last_x(&[]).map(f64::to_bits)
    );
    for (order, bar) in [("4", 1e-4), ("6", 1e-6), ("8", 1e-9)] {
        assert!(error(&["--order", order]) < bar, "order {order}");
    }
    assert!(error(&["--tolerance", "1e-4"]) < 1e-2);
    assert!(error(&["--tolerance", "1e-12"]) < 1e-10);
    // the columns do not change, and times before the start are allowed
    let head = |options: &[&str]| {
        let csv = stdout(&[&["run", "pendulum", "--until", "-1", "--step", "-0.1"], options].concat());
        assert_eq!(csv.lines().count(), 12);
        csv.lines().next().map(str::to_owned)
    };
    assert_eq!(head(&["--order", "6"]), head(&[]));
    assert_eq!(head(&["--tolerance", "1e-9"]), head(&[]));
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "run", "particle", "--until", "1", "--order", "8", "--out", "a.json", "--plot", "a.svg",
    ];
    assert!(
        dsocs(folder.path(), &arguments)
            .output()
            .unwrap()
            .status
            .success()
    );
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    assert_eq!(json["accuracy"]["order"], 8);
}

#[test]
fn the_error_is_estimated_with_every_method() {
    for options in [
        &[][..],
        &["--start", "paper"],
        &["--order", "4"],
        &["--order", "8", "--every", "7"],
        &["--tolerance", "1e-6"],
    ] {
        let output = output(&[&["run", "particle", "--until", "20", "--estimate-error"], options].concat());
        assert!(output.status.success());
        let csv = String::from_utf8(output.stdout).unwrap();
        assert!(csv.lines().next().unwrap().ends_with("energy,error_x,error_y"));
        for row in rows(&csv) {
            let angle = std::f64::consts::SQRT_2 * row[0] - std::f64::consts::FRAC_PI_4;
            let error = (row[1] - (angle.cos() - std::f64::consts::FRAC_1_SQRT_2)).abs();
            assert!(
                (row[8] - error).abs() < 1e-13 + 1e-3 * error,
                "{options:?}: {row:?}"
            );
        }
        let note = String::from_utf8(output.stderr).unwrap();
        assert!(
            note.contains("largest errors are x ") && note.contains("known to"),
            "{note}"
        );
    }
}

#[test]
fn options_that_do_not_go_together_are_refused_with_a_sentence() {
    for (options, expected) in [
        (
            &["particle", "--order", "4", "--tolerance", "1e-6"][..],
            "cannot be used with",
        ),
        (&["particle", "--order", "3"], "its compositions 4, 6 and 8"),
        (
            &["particle", "--order", "4", "--q1", "0.1,0.1"],
            "begins with a position and a velocity",
        ),
        (
            &["particle", "--tolerance", "1e-6", "--q1", "0.1,0.1"],
            "`--q1` does not go with `--tolerance`",
        ),
        (
            &["particle", "--order", "6", "--start", "paper"],
            "only the step of order 2 needs a second node",
        ),
        (
            &["particle", "--order", "8", "--certify"],
            "`--certify` does not go with `--order 8`",
        ),
        (
            &["particle", "--tolerance", "1e-6", "--certify"],
            "three nodes at equal distances",
        ),
        (
            &["particle", "--estimate-error", "--q1", "0.1,0.1"],
            "begins with a velocity",
        ),
        (&["particle", "--tolerance", "0"], "between 0 and 1"),
        (&["particle", "--tolerance", "nan"], "between 0 and 1"),
        (
            &["particle", "--tolerance", "1e-6", "--until", "-5"],
            "the other way",
        ),
        (&["particle", "--order", "4", "--until", "-5"], "the other way"),
        (&["particle", "--order", "4", "--v0", "0,0"], "at rest"),
        (&["sphere", "--order", "4"], "--tolerance"),
    ] {
        let (code, message) = refused(&[&["run"], options].concat());
        assert_eq!(code, 2, "{options:?}: {message}");
        assert!(message.contains(expected), "{options:?}: {message}");
    }
    // legs that go back too far for the pendulum's switch: the rows before the error are kept
    let output = output(&["run", "pendulum", "--order", "4", "--step", "0.4"]);
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    for part in [
        "back in time",
        "--order 2",
        "--tolerance",
        "what was computed before",
    ] {
        assert!(message.contains(part), "{message}");
    }
    assert!(rows(&String::from_utf8(output.stdout).unwrap()).len() > 10);
}

#[test]
fn files_are_written_in_the_format_of_their_name() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = dsocs(
            folder.path(),
            &[&["run", "pendulum", "--until", "5"], arguments].concat(),
        )
        .output()
        .unwrap();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        output
    };
    let output = run(&["--out", "new/folder/a.json", "--plot", "a.svg"]);
    assert!(output.stdout.is_empty());
    let json: Value =
        serde_json::from_slice(&fs::read(folder.path().join("new/folder/a.json")).unwrap()).unwrap();
    assert_eq!(json["system"], "pendulum");
    assert_eq!(json["step"], 0.1);
    assert_eq!(json["start"]["rule"], "second_order");
    assert_eq!(json["parameters"]["chi"], 100.0);
    assert_eq!(json["columns"][10], "w");
    assert_eq!(json["rows"].as_array().map(Vec::len), Some(51));
    let svg = fs::read_to_string(folder.path().join("a.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains(">θ [rad]<") && svg.contains("</svg>"));

    if cfg!(feature = "png") {
        run(&["--out", "a.csv", "--plot", "a.png"]);
        assert!(is_png(&folder.path().join("a.png")));
    } else {
        run(&["--out", "a.csv"]);
        let (code, message) = refused(&["run", "pendulum", "--plot", "a.png"]);
        assert_eq!(code, 2, "{message}");
        assert!(message.contains("--features png"), "{message}");
    }
    assert_eq!(
        fs::read_to_string(folder.path().join("a.csv")).unwrap(),
        stdout(&["run", "pendulum", "--until", "5"])
    );
    let leftover = fs::read_dir(folder.path()).unwrap().filter(|entry| {
        entry
            .as_ref()
            .unwrap()
            .file_name()
            .to_string_lossy()
            .starts_with('.')
    });
    assert_eq!(leftover.count(), 0, "no temporary file stays");
}

#[test]
fn names_that_do_not_exist_are_told_with_the_nearest() {
    for (arguments, kind, nearest) in [
        (&["run", "pendulm"][..], "system `pendulm`", "`pendulum`"),
        (&["run", "pendulum", "--set", "chj=1"], "parameter `chj`", "`chi`"),
        (
            &["run", "particle", "--columns", "t,forc_x"],
            "column `forc_x`",
            "`force_x`",
        ),
    ] {
        let (code, message) = refused(arguments);
        assert_eq!(code, 2);
        assert!(
            message.contains(kind) && message.contains(&format!("did you mean {nearest}")),
            "{message}"
        );
    }
}

#[test]
fn bad_input_is_refused_with_status_2() {
    for (options, expected) in [
        (&["--step", "0"][..], "finite and not zero"),
        (&["--step", "NaN"], "finite and not zero"),
        (&["--step", "inf"], "finite and not zero"),
        (&["--step", "-0.1", "--until", "5"], "the other way"),
        (&["--until", "-1"], "the other way"),
        (&["--until", "nan"], "NaN"),
        (&["--until", "inf"], "inf"),
        (
            &["--q0", "1,2,3"],
            "q0 has 3 components, but there are 2 coordinates: x, y",
        ),
        (&["--v0", "1"], "v0 has 1 component,"),
        (&["--q0", "0,nan"], "component `y` of the start's q0 is NaN"),
        (&["--v0", "inf,0"], "component `x` of the start's v0 is inf"),
        (&["--set", "mass=inf"], "parameter `mass` is inf"),
        (&["--set", "curvature=nan"], "parameter `curvature` is NaN"),
        (&["--set", "mass"], "NAME=VALUE"),
        (&["--set", "mass=heavy"], "`heavy` is not a number"),
        (&["--v0", "0,0"], "at rest"),
        (&["--q1", "0.1,0.1", "--v0", "1,1"], "cannot be used with"),
        (&["--q1", "0.1,0.1", "--start", "paper"], "cannot be used with"),
        (&["--every", "0"], "--every"),
        (&["--out", "table.txt"], ".csv or .json"),
        (&["--plot", "figure.jpg"], ".svg or .png"),
    ] {
        let (code, message) = refused(&[&["run", "particle"], options].concat());
        assert_eq!(code, 2, "{options:?}: {message}");
        assert!(message.contains(expected), "{options:?}: {message}");
    }
}

#[test]
fn numbers_may_be_expressions() {
    let run = ["run", "pendulum", "--step", "0.01", "--until", "0.1"];
    let with = |options: &[&str]| stdout(&[&run, options].concat());
    let half = std::f64::consts::FRAC_PI_2;
    let plain = with(&[
        "--q0",
        &format!("{half},{}", -half),
        "--v0",
        "0.5,2",
        "--set",
        "rho=1.5",
    ]);
    let written = with(&[
        "--q0",
        "pi/2,-pi/2",
        "--v0",
        "1/2,sqrt(4)",
        "--set",
        "rho = (1 + 2)/2",
    ]);
    assert_eq!(plain, written);
    let steps = |step, until| stdout(&["run", "particle", "--step", step, "--until", until]);
    assert_eq!(steps("1/8", "2*2"), steps("0.125", "4"));
    for (value, reason) in [
        ("pie/2,0", "operator before `e/2`"),
        ("2pi,0", "operator before `pi`"),
        (
            "theta,0",
            "`theta` is not a number; numbers, pi, sqrt(…), 30deg, + - * / and parentheses can be written",
        ),
    ] {
        let (code, message) = refused(&["run", "pendulum", "--q0", value]);
        assert_eq!(code, 2);
        assert!(message.contains(reason) && message.contains("--q0"), "{message}");
    }
    let (code, message) = refused(&["run", "pendulum", "--q0", "1/0,0"]);
    assert_eq!(code, 2);
    assert!(
        message.contains("component `theta` of the start's q0 is inf"),
        "{message}"
    );
}

#[test]
fn a_figure_alone_prints_no_rows() {
    let folder = tempfile::tempdir().unwrap();
    let run = |options: &[&str]| {
        let arguments = [&["run", "particle", "--until", "1", "--plot", "a.svg"], options].concat();
        dsocs(folder.path(), &arguments).output().unwrap()
    };
    let alone = run(&[]);
    assert!(alone.status.success() && alone.stdout.is_empty());
    assert!(folder.path().join("a.svg").exists());
    let both = run(&["--out", "-"]);
    assert!(both.status.success() && both.stdout.starts_with(b"t,x,y,"));
}

#[test]
fn a_path_is_drawn_and_needs_two_columns() {
    let folder = tempfile::tempdir().unwrap();
    let run = [
        "run", "particle", "--until", "5", "--plot", "path.svg", "--path", "x,y",
    ];
    assert!(dsocs(folder.path(), &run).status().unwrap().success());
    let svg = fs::read_to_string(folder.path().join("path.svg")).unwrap();
    assert!(svg.contains(">x [m]<") && svg.contains(">y [m]<") && !svg.contains(">t [s]<"));
    for (path, part) in [
        ("x", "two columns"),
        ("x,z", "no column `z`"),
        ("x,y,t", "two columns"),
    ] {
        let (status, message) = refused(&["run", "particle", "--plot", "path.svg", "--path", path]);
        assert!(status == 2 && message.contains(part), "{message}");
    }
    assert_eq!(
        refused(&["run", "particle", "--path", "x,y"]).0,
        2,
        "without a figure"
    );
}

#[test]
fn a_page_has_the_name_of_one_and_is_refused_before_the_run() {
    for arguments in [
        &["run", "particle", "--report", "page.svg"][..],
        &["report", "--out", "page.txt"],
    ] {
        let (status, message) = refused(arguments);
        assert!(status == 2 && message.contains("ends in .html"), "{message}");
    }
    assert_eq!(refused(&["report", "--cases", "99"]).0, 2);
    assert_eq!(refused(&["report", "--speed", "nowhere.csv"]).0, 2);
}

#[test]
fn a_tolerance_below_rounding_is_told() {
    let run = |tolerance: &str| {
        output(&[
            "run",
            "particle",
            "--until",
            "5",
            "--step",
            "0.5",
            "--tolerance",
            tolerance,
        ])
    };
    let fine = run("1e-30");
    let note = String::from_utf8(fine.stderr).unwrap();
    assert!(fine.status.success());
    assert!(
        note.contains("1e-30 cannot be reached") && note.contains("1.1e-16"),
        "{note}"
    );
    assert_eq!(fine.stdout, run(&format!("{:e}", f64::EPSILON / 2.0)).stdout);
    assert!(run("1e-15").stderr.is_empty());
    let (code, message) = refused(&["run", "particle", "--tolerance", "0"]);
    assert_eq!(code, 2);
    assert!(message.contains("1.1e-16"), "{message}");
}

#[test]
fn an_energy_that_explodes_is_told() {
    // springs, with a step of many of their periods
    let exploding = output(&["run", "snakeboard", "--step", "100", "--until", "200"]);
    let warning = String::from_utf8(exploding.stderr).unwrap();
    for part in [
        "warning: the energy grows from 0.145",
        "at t = 200",
        "h = 100 is too long",
    ] {
        assert!(warning.contains(part), "no {part:?} in: {warning}");
    }
    assert!(output(&["run", "snakeboard"]).stderr.is_empty());
}

#[test]
fn a_failed_step_leaves_what_was_computed() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "run", "particle", "--start", "paper", "--v0", "0,0", "--out", "rest.csv", "--plot", "rest.svg",
    ];
    let output = dsocs(folder.path(), &arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        message.contains("step 1") && message.contains("at rest") && message.contains("rest.csv"),
        "{message}"
    );
    let csv = fs::read_to_string(folder.path().join("rest.csv")).unwrap();
    assert_eq!(rows(&csv).len(), 1);
    assert!(
        csv.lines().nth(1).unwrap().contains(",,"),
        "what is not a number is empty: {csv}"
    );
    assert!(folder.path().join("rest.svg").exists());
}

#[test]
fn a_place_that_cannot_be_written_is_told_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    for arguments in [
        &["paper", "--out", "file"][..],
        &["--out", "file/results"],
        &["run", "particle", "--out", "file/a.csv", "--until", "1e9"],
        &["run", "particle", "--plot", "file/a.svg", "--until", "1e9"],
    ] {
        let output = dsocs(folder.path(), arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(
            message.contains("cannot write") && message.contains("file"),
            "{message}"
        );
    }
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = dsocs(folder.path(), &["run", "particle", "--until", "1e9"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut some = [0; 1000];
    child.stdout.take().unwrap().read_exact(&mut some).unwrap(); // and close
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(output.stderr.is_empty());
}

#[test]
fn list_names_systems_coordinates_and_parameters() {
    let json: Value = serde_json::from_str(&stdout(&["list", "--format", "json"])).unwrap();
    let named = |name: &str| {
        let mut systems = json.as_array().unwrap().iter();
        systems.find(|system| system["name"] == name).unwrap()
    };
    for (name, kind) in [
        ("chain", "unconstrained"),
        ("sphere", "holonomic"),
        ("sleigh", "nonholonomic"),
        ("particle", "second-order"),
        ("rod-and-wheel", "mixed"),
    ] {
        assert_eq!(named(name)["kind"], kind);
    }
    let pendulum = named("pendulum");
    assert_eq!(pendulum["coordinates"], serde_json::json!(["theta", "psi"]));
    let i = &pendulum["parameters"][0];
    assert_eq!(
        (i["name"].as_str(), i["default"].as_f64(), i["unit"].as_str()),
        (Some("i"), Some(312.5), Some("kg m²"))
    );
    let text = stdout(&["list"]);
    assert!(systems::all().iter().all(|entry| text.contains(entry.name())));
    assert!(
        systems::texts::TEXTS
            .iter()
            .all(|shipped| text.contains(shipped.name))
    );
    assert!(text.contains("\nnonholonomic\n"), "kind by kind: {text}");
    // no text is parsed for the list: a text would refuse a constant that it does not have
    assert_eq!(stdout(&["list", "--const", "nothing=1"]), text);
    let text = stdout(&["list", "pendulum"]);
    assert!(text.contains("pendulum (second-order)") && text.contains("rho"));
}

#[test]
fn every_system_runs() {
    let shipped = systems::texts::TEXTS
        .iter()
        .map(|shipped| shipped.entry(&[]).unwrap());
    for entry in systems::all().into_iter().chain(shipped) {
        let until = (20.0 * entry.default_step()).to_string();
        let csv = stdout(&["run", entry.name(), "--until", &until]);
        assert_eq!(csv.lines().count(), 22, "{}", entry.name());
        let rows = rows(&csv);
        assert!(
            rows.iter().flatten().all(|value| value.is_finite()),
            "{}: {csv}",
            entry.name()
        );
    }
}

#[test]
fn a_picture_shows_bodies_in_space() {
    let folder = tempfile::tempdir().unwrap();
    let drawn = |arguments: &[&str]| {
        let done = dsocs(folder.path(), &[&["run"], arguments].concat())
            .output()
            .unwrap();
        let stderr = String::from_utf8(done.stderr).unwrap();
        (
            fs::read_to_string(folder.path().join("a.svg")).unwrap_or_default(),
            stderr,
        )
    };
    // four moments, each of a disc of 24 sides and 4 quarters, some of which are visible, and the lines of
    // the ground
    let (svg, stderr) = drawn(&["coin", "--until", "1", "--picture", "a.svg"]);
    assert!(stderr.is_empty() && svg.starts_with("<svg xmlns="), "{stderr}");
    let moments: Vec<&str> = svg.split("<g opacity=").skip(1).collect();
    assert_eq!(moments.len(), 4);
    for moment in &moments {
        let faces = moment.matches("class=\"face\"").count();
        assert!((14..=20).contains(&faces), "{faces}");
        assert_eq!(moment.matches("class=\"edge ground\"").count(), 22);
    }
    assert_ne!(moments[0], moments[3]);
    assert_eq!(svg.matches("class=\"trail\"").count(), 1);
    // a body that rotates is drawn without a declared drawing, and the page has the data for its script
    let text = "coordinates(r: rotation, x: [3]); lagrangian = r.angular_velocity().norm_squared() + dot(x).norm_squared();
        run { start = ([1, 0, 0, 0, 0, 0, 0], [0, 0, 1, 1, 0, 0]); until = 1.0; }";
    fs::write(folder.path().join("free.dsocs"), text).unwrap();
    let (svg, stderr) = drawn(&["free.dsocs", "--picture", "a.svg", "--report", "a.html"]);
    assert!(stderr.is_empty(), "{stderr}");
    assert_eq!(svg.matches("class=\"face\"").count(), 4 * 3);
    let page = fs::read_to_string(folder.path().join("a.html")).unwrap();
    assert!(page.contains("\"space\":{\"centre\":") && page.contains("The mechanism"));
    // after v_r_x comes v_r_y: a velocity has no scalar component
    assert!(page.contains("<h2>Velocities</h2>"));
    let velocities = page.split("<h2>Velocities</h2>").nth(1).unwrap();
    let velocities = velocities.split("<h2>").next().unwrap();
    assert_eq!(velocities.matches("data-column=\"v_").count(), 6, "{velocities}");
    let (_, stderr) = drawn(&["train", "--picture", "b.svg"]);
    assert!(
        stderr.contains("nothing says how `train` is drawn") && stderr.contains("--plot"),
        "{stderr}"
    );
}

#[test]
fn an_input_is_held_from_time_to_time() {
    let folder = tempfile::tempdir().unwrap();
    let written = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).unwrap();
        format!("gravity={name}")
    };
    let run = |options: &[&str]| {
        let common = ["run", "knife-edge", "--until", "2", "--columns", "t,x,y"];
        let output = dsocs(folder.path(), &[&common, options].concat())
            .output()
            .unwrap();
        (
            output.status.code().unwrap(),
            String::from_utf8(output.stdout).unwrap(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let last = |options: &[&str]| rows(&run(options).1).pop().unwrap();
    // a constant plan gives the run without an input
    let constant = written("constant.csv", "0,1.5\n");
    let plain = run(&["--step", "0.01", "--set", "gravity=1.5"]);
    assert_eq!(run(&["--step", "0.01", "--input", &constant]), plain);
    // with every method the motion with a change is that of two successive motions, to the order of the
    // method
    let change = written("change.csv", "t, gravity\n0, 1.5\n1, -0.5\n");
    let exact = last(&["--step", "0.1", "--tolerance", "1e-14", "--input", &change]);
    let apart = |options: &[&str]| {
        let found = last(&[options, &["--input", &change]].concat());
        assert_eq!(found[0].to_bits(), 2.0_f64.to_bits());
        (found[1] - exact[1]).hypot(found[2] - exact[2])
    };
    let (coarse, fine) = (apart(&["--step", "0.02"]), apart(&["--step", "0.01"]));
    let order = (coarse / fine).log2();
    assert!((order - 2.0).abs() < 0.1, "{order}: {coarse}, {fine}");
    // errors are against the continuous motion under the same inputs
    let path = written("change.csv", "t, gravity\n0, 1.5\n1, -0.5\n");
    let common = [
        "run",
        "knife-edge",
        "--until",
        "2",
        "--step",
        "0.02",
        "--input",
        &path,
    ];
    let output = dsocs(folder.path(), &[&common[..], &["--estimate-error"]].concat())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let table = String::from_utf8(output.stdout).unwrap();
    let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let end = rows(&table).pop().unwrap();
    let of = |name: &str| end[names.iter().position(|known| *known == name).unwrap()];
    let estimated = of("error_x").hypot(of("error_y"));
    assert!((estimated - coarse).abs() < 1e-9, "{estimated}, {coarse}");
    // before the first time of an input the parameter has its own value
    let late = written("late.csv", "1, -0.5\n");
    assert_eq!(
        last(&["--step", "0.01", "--set", "gravity=1.5", "--input", &late]),
        last(&["--step", "0.01", "--input", &change])
    );

    for (options, words) in [
        (
            vec!["--input".to_owned(), "gravty=constant.csv".to_owned()],
            "did you mean `gravity`",
        ),
        (vec!["--input".to_owned(), "gravity".to_owned()], "NAME=FILE"),
        (
            vec!["--input".to_owned(), "gravity=none.csv".to_owned()],
            "none.csv is no plan of an input",
        ),
        (
            vec!["--input".to_owned(), written("soon.csv", "0,1\nsoon,2\n")],
            "line 2 of soon.csv has no number in column 1; expected a place and a value",
        ),
        (
            vec!["--input".to_owned(), written("back.csv", "0,1\n0,2\n")],
            "times that ascend",
        ),
        (
            vec!["--input".to_owned(), written("empty.csv", "")],
            "it has no rows",
        ),
        (
            vec!["--input".to_owned(), constant, "--certify".to_owned()],
            "cannot be used with",
        ),
    ] {
        let options: Vec<_> = options.iter().map(String::as_str).collect();
        let (status, rows, message) = run(&options);
        assert!(
            status == 2 && rows.is_empty() && message.contains(words),
            "{options:?}: {message}"
        );
    }
}

#[test]
fn an_inconsistent_start_is_refused_or_projected() {
    let start = [
        "run",
        "sphere",
        "--until",
        "0.1",
        "--q0",
        "0.6,0,-0.7",
        "--v0",
        "2,2.5,1.5",
    ];
    let (code, message) = refused(&start);
    assert_eq!(code, 2);
    assert!(
        message.contains("violates holonomic constraint 1 at q0 by -0.075,") && message.contains("--project"),
        "{message}"
    );
    for method in [&[][..], &["--tolerance", "1e-10"]] {
        let csv = stdout(&[&start[..], &["--project"], method].concat());
        assert!(csv.lines().next().unwrap().ends_with("angular_momentum,lambda_0"));
        for row in rows(&csv) {
            let [x, y, z] = [row[1], row[2], row[3]];
            assert!((x.hypot(y).hypot(z) - 1.0).abs() < 1e-9, "{method:?}: {row:?}");
        }
    }
    let projected = stdout(&[&start[..], &["--project"]].concat());
    let first = &rows(&projected)[0];
    let work = first[1] * first[4] + first[2] * first[5] + first[3] * first[6];
    assert!(work.abs() < 1e-15, "the velocity is tangent: {work:e}");
    // both nodes by name
    let nodes = [
        "run",
        "planar-pendulum",
        "--until",
        "0.1",
        "--q0",
        "0,-1",
        "--q1",
        "0.01,-1",
    ];
    assert!(refused(&nodes).1.contains("--project"));
    assert_eq!(rows(&stdout(&[&nodes[..], &["--project"]].concat())).len(), 11);
}

#[test]
fn a_check_begins_as_a_run_does() {
    let off = [
        "check",
        "sphere",
        "--until",
        "1",
        "--q0",
        "0.6,0,-0.7",
        "--v0",
        "2,2.5,1.5",
    ];
    let (code, message) = refused(&off);
    assert_eq!(code, 2);
    assert!(
        message.contains("violates holonomic constraint 1") && message.contains("--project"),
        "{message}"
    );
    let projected = stdout(&[&off[..], &["--project"]].concat());
    assert!(
        projected.contains("slope of the errors of position"),
        "{projected}"
    );
    // the paper's second node is of first order, and so is the motion: no order is required
    let paper = stdout(&["check", "particle", "--until", "2", "--start", "paper"]);
    assert!(
        paper.contains("the paper's start has an error of order 1"),
        "{paper}"
    );
    assert!(!paper.contains("distance of that from 2"), "{paper}");
}

#[test]
fn the_papers_figures_and_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let output = dsocs(folder.path(), &[]).output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(output.stderr.is_empty());
    let results = folder.path().join("results");
    for figure in [
        "particle-path",
        "particle-xy",
        "particle-error",
        "pendulum-motion",
        "pendulum-error",
    ] {
        let svg = fs::read_to_string(results.join(format!("{figure}.svg"))).unwrap();
        assert!(
            svg.contains("<text") && svg.ends_with("</svg>\n") && svg.len() < 500_000,
            "{figure}: {} bytes",
            svg.len()
        );
        let png = results.join(format!("{figure}.png"));
        assert_eq!(
            png.exists() && is_png(&png),
            cfg!(feature = "png"),
            "PNG is asked for by a feature"
        );
    }
    let summary: Value = serde_json::from_slice(&fs::read(results.join("summary.json")).unwrap()).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    assert_eq!(summary["particle"]["errors"].as_array().map(Vec::len), Some(14));
    assert_eq!(summary["pendulum"]["errors"].as_array().map(Vec::len), Some(10));
    for (row, expected) in [
        (&summary["particle"]["errors"][0]["max_error_x"], 2.044_112_3),
        (&summary["particle"]["errors"][13]["max_error_x"], 1.175_092_3e-4),
        (
            &summary["pendulum"]["errors"][0]["max_error_theta"],
            3.287_090_7e-1,
        ),
        (
            &summary["pendulum"]["errors"][9]["max_error_theta"],
            1.613_679_1e-3,
        ),
    ] {
        assert!((number(row) / expected - 1.0).abs() < 1e-6, "{row} {expected}");
    }
    assert!((number(&summary["particle"]["slope"]["paper"]) - 1.61).abs() < 0.01);
    assert!((number(&summary["pendulum"]["reference_lyapunov_2000"]) - 195.472_779_467).abs() < 1e-6);
    let lyapunov = summary["pendulum"]["lyapunov"].as_array().unwrap();
    assert_eq!(lyapunov.len(), 20_001);
    assert_eq!(lyapunov[20_000]["t"].to_string(), "2000.0");
    let table = String::from_utf8(output.stdout).unwrap();
    for part in [
        "2.0441123e0",
        "1.6136791e-3",
        // steps smaller than the paper's, and the slopes that explain its 1.3
        "0.003125",
        "0.0015625",
        "1.59 over h = 0.1 … 0.00625, 1.34 over 0.1 … 0.0016, 1.25 over 0.05 … 0.003",
        "1.00 over the last halving",
    ] {
        assert!(table.contains(part), "no {part:?} in: {table}");
    }
}

#[test]
fn check_prints_the_theorems_and_fails_with_them() {
    let folder = tempfile::tempdir().unwrap();
    let done = dsocs(
        folder.path(),
        &["check", "particle", "magnetic", "--out", "checks.json"],
    )
    .output()
    .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = String::from_utf8(done.stdout).unwrap();
    for check in [
        "regularity",
        "symplectic law",
        "momentum law",
        "reversibility",
        "order",
    ] {
        assert!(text.contains(check), "{check}");
    }
    assert!(!text.contains("FAILED"), "{text}");
    let json: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("checks.json")).unwrap()).unwrap();
    let names: Vec<_> = json["systems"]
        .as_array()
        .unwrap()
        .iter()
        .map(|system| &system["system"])
        .collect();
    assert_eq!(names, ["particle", "magnetic"]);
    let checks = json["systems"][0]["checks"].as_array().unwrap();
    assert!(
        checks
            .iter()
            .all(|check| check["ok"] == true && check["figure"].is_number())
    );

    // steps that turn the particle many times
    let failed = output(&["check", "magnetic", "--step", "10", "--until", "400"]);
    assert_eq!(failed.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&failed.stdout).contains("FAILED"));
    let (status, message) = refused(&["check", "magnetik"]);
    assert!(status == 2 && message.contains("magnetic"), "{message}");
    let (status, message) = refused(&["check", "magnetic", "--out", "checks.txt"]);
    assert!(status == 2 && message.contains("checks.txt"), "{message}");
}

#[test]
fn stability_is_measured_on_any_system() {
    let folder = tempfile::tempdir().unwrap();
    let entries = systems::all();
    let names: Vec<&str> = entries.iter().map(dsocs_systems::Entry::name).collect();
    let arguments = [&["stability", "--quick"], &names[..]].concat();
    let done = dsocs(folder.path(), &arguments).output().unwrap();
    let text = String::from_utf8(done.stdout).unwrap();
    assert!(
        done.status.success(),
        "{text}{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let json: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("results/stability.json")).unwrap())
            .unwrap();
    for (system, name) in json["systems"].as_array().unwrap().iter().zip(names) {
        assert_eq!(system["system"], name);
        let cases = system["cases"].as_array().unwrap();
        assert!(
            cases.len() >= 12 && cases.iter().all(|case| case["ok"] == true),
            "{name}: {system}"
        );
    }
    // steps over many turns of a chaotic motion: the errors do not fall with the order
    let failed = output(&["stability", "double-pendulum", "--cases", "3", "--step", "5"]);
    assert_eq!(
        failed.status.code(),
        Some(1),
        "{}",
        String::from_utf8_lossy(&failed.stdout)
    );
    assert!(String::from_utf8_lossy(&failed.stderr).contains("not meet the limit"));

    for (arguments, expected) in [
        (
            &["stability", "--cases", "99"][..],
            "no case 99; the cases are 1, 2",
        ),
        (
            &["stability", "particle", "--cases", "7"],
            "no case 7; the cases are 1, 2, 3, 4, 5, 6",
        ),
        (&["stability", "partical"], "`particle`"),
        (&["stability", "--q0", "1,2"], "`--q0` is for one system"),
        (
            &["check", "particle", "magnetic", "--set", "mass=2"],
            "`--set` is for one system",
        ),
        (&["run"], "which system? known: chain, double-pendulum"),
    ] {
        let (status, message) = refused(arguments);
        assert!(
            status == 2 && message.contains(expected),
            "{arguments:?}: {message}"
        );
    }
}

#[test]
fn a_check_takes_another_start_and_other_parameters() {
    let text = stdout(&[
        "check",
        "magnetic",
        "--q0",
        "2,0",
        "--v0",
        "0,1",
        "--set",
        "field=0.5",
    ]);
    assert!(!text.contains("FAILED"), "{text}");
    let (status, message) = refused(&["check", "magnetic", "--q0", "2,0,0"]);
    assert!(
        status == 2 && message.contains("q0 has 3 components"),
        "{message}"
    );
}

#[test]
fn shells_and_manuals_know_every_command_and_option() {
    let help = stdout(&["run", "--help"]);
    let options: Vec<&str> = help
        .split_whitespace()
        .filter(|word| {
            word.starts_with("--")
                && word.len() > 2
                && word.bytes().skip(2).all(|c| c.is_ascii_lowercase() || c == b'-')
        })
        .collect();
    assert!(options.len() > 10, "{options:?}");
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = stdout(&["completions", shell]);
        for option in &options {
            let (long, bare) = (option, option.trim_start_matches('-'));
            assert!(
                script.contains(*long) || script.contains(&format!("-l {bare}")),
                "{shell}: {option}"
            );
        }
    }
    let page = stdout(&["man", "run"]);
    assert!(page.contains(".TH dsocs-run 1"), "{page}");
    for option in options {
        assert!(page.contains(&option.replace('-', "\\-")), "{option}: {page}");
    }
    let folder = tempfile::tempdir().unwrap();
    assert!(
        dsocs(folder.path(), &["man", "--out", "pages"])
            .status()
            .unwrap()
            .success()
    );
    for page in ["dsocs.1", "dsocs-run.1", "dsocs-check.1", "dsocs-new.1"] {
        let text = fs::read_to_string(folder.path().join("pages").join(page)).unwrap();
        assert!(text.contains(".SH NAME"), "{page}");
    }
    assert_eq!(refused(&["man", "rum"]).0, 2);
}

/// Whether a file is a picture in PNG.
fn is_png(path: &Path) -> bool {
    fs::read(path).unwrap().starts_with(b"\x89PNG")
}
