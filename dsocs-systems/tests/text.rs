//! Systems from text files: every system of the library that can be written as a text runs from its text with
//! the same bits.

mod program;

use std::fs;

use dsocs_core::text::Text;
use tempfile::TempDir;

/// Standard output and standard error of the program, and whether it succeeds.
fn dsocs(folder: &TempDir, arguments: &[&str]) -> (String, String, bool) {
    let output = program::dsocs(folder.path(), arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.success())
}

/// The numbers of a table, line by line, without its head.
fn numbers(table: &str) -> Vec<Vec<f64>> {
    let lines = table.lines().skip(1);
    lines
        .map(|line| line.split(',').map(|number| number.parse().unwrap()).collect())
        .collect()
}

#[test]
fn systems_run_from_their_printed_files_with_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let mut others = Vec::new();
    for entry in dsocs_systems::systems::all() {
        let name = entry.name();
        let Ok(text) = entry.text() else {
            others.push(name.to_owned());
            continue;
        };
        let file = format!("{name}.dsocs");
        fs::write(folder.path().join(&file), &text).unwrap();
        // a text that was read is printed word for word
        assert_eq!(dsocs(&folder, &["text", &file]).0, text, "{name}");
        let until = (1000.0 * entry.default_step()).to_string();
        let run = |of: &str, more: &[&str]| {
            let arguments = [&["run", of, "--until", &until], more].concat();
            dsocs(&folder, &arguments)
        };
        // all columns: positions, velocities, forces, observed expressions, energies
        assert_eq!(run(name, &[]), run(&file, &[]), "{name}");
        let composed = run(name, &["--order", "4"]);
        if composed.2 {
            assert_eq!(composed, run(&file, &["--order", "4"]), "{name}");
        }
        // the series at their own steps, and at nodes on a grid, with the messages that end them
        for taylor in [
            &["--tolerance", "1e-12"][..],
            &["--tolerance", "1e-9", "--every", "7"],
        ] {
            assert_eq!(run(name, taylor), run(&file, taylor), "{name}");
        }
    }
    // its parameter is a function of Rust
    assert_eq!(others, ["particle"]);
}

#[test]
fn systems_that_are_texts_run_from_their_files_too() {
    let folder = tempfile::tempdir().unwrap();
    for shipped in dsocs_systems::systems::texts::TEXTS {
        let (name, file) = (shipped.name, format!("{}.dsocs", shipped.name));
        assert_eq!(dsocs(&folder, &["text", name]).0, shipped.text, "{name}");
        fs::write(folder.path().join(&file), shipped.text).unwrap();
        let run = |of: &str| dsocs(&folder, &["run", of, "--until", "0.1", "--estimate-error"]);
        let (table, stderr, good) = run(name);
        assert!(good, "{name}: {stderr}");
        assert_eq!((table, stderr, good), run(&file), "{name}");
    }
}

#[test]
fn a_table_beside_the_file_is_read_and_its_derivatives_are_those_of_rust() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("pull.csv"), "t,pull\n0,0\n1,1\n2,0.5\n4,2\n").unwrap();
    let text = "parameters { pull = samples(\"pull.csv\") }
        coordinates(x);
        lagrangian = (1 + pull.at(t)) * dot(x).powi(2) / 2 - pull.at(x) * x / 10;
        run { start = ([1.0], [0.2]); step = 0.01; until = 2.0; }";
    fs::write(folder.path().join("pull.dsocs"), text).unwrap();
    // the spline through four points without an interior knot is one cubic polynomial
    let [a, b, c, d] = cubic([0.0, 1.0, 2.0, 4.0], [0.0, 1.0, 0.5, 2.0]);
    let polynomial = format!(
        "let f = |u| (({d} * u + {c}) * u + {b}) * u + {a};
        coordinates(x);
        lagrangian = (1 + f(t)) * dot(x).powi(2) / 2 - f(x) * x / 10;
        run {{ start = ([1.0], [0.2]); step = 0.01; until = 2.0; }}"
    );
    fs::write(folder.path().join("polynomial.dsocs"), polynomial).unwrap();
    for more in [&[][..], &["--tolerance", "1e-11", "--step", "0.01"]] {
        let of = |file: &str| {
            let (out, stderr, good) = dsocs(&folder, &[&["run", file], more].concat());
            assert!(good, "{stderr}");
            numbers(&out)
        };
        let (table, polynomial) = (of("pull.dsocs"), of("polynomial.dsocs"));
        assert_eq!(table.len(), polynomial.len());
        for (table, polynomial) in table.iter().zip(&polynomial) {
            for (x, y) in table.iter().zip(polynomial) {
                assert!(
                    (x - y).abs() <= 1e-8 * (1.0 + y.abs()),
                    "{table:?} {polynomial:?}"
                );
            }
        }
    }
}

/// The coefficients of the cubic polynomial through four points, by Newton's divided differences.
fn cubic(x: [f64; 4], mut y: [f64; 4]) -> [f64; 4] {
    for order in 1..4 {
        for i in (order..4).rev() {
            y[i] = (y[i] - y[i - 1]) / (x[i] - x[i - order]);
        }
    }
    // (((y3) (u - x2) + y2) (u - x1) + y1) (u - x0) + y0
    let mut p = [y[3], 0.0, 0.0, 0.0];
    for k in (0..3).rev() {
        let mut next = [0.0; 4];
        for (i, &c) in p.iter().enumerate() {
            if i < 3 {
                next[i + 1] += c;
            }
            next[i] -= x[k] * c;
        }
        next[0] += y[k];
        p = next;
    }
    p
}

#[test]
fn every_verb_takes_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let swing = "//! A pendulum.
        parameters {
            /// The length of the rod [m]
            length = 1.0,
        }
        coordinates(
            /// The angle from below [rad]
            theta
        );
        lagrangian = dot(theta).powi(2) / 2 + 9.81 / length * theta.cos();
        run { start = ([pi / 4], [0]); step = 0.01; until = 2.0; }
        run far { start = ([3], [0]); until = 1.0; }";
    fs::write(folder.path().join("swing.dsocs"), swing).unwrap();
    for arguments in [
        &["list", "swing.dsocs"][..],
        &["list", "swing.dsocs", "--format", "json"],
        &["check", "swing.dsocs"],
        &[
            "run",
            "swing.dsocs",
            "--plot",
            "swing.svg",
            "--report",
            "swing.html",
        ],
        &["run", "swing.dsocs", "--set", "length=2", "--estimate-error"],
        &["run", "swing.dsocs:far"],
        &["stability", "swing.dsocs"],
    ] {
        let (out, stderr, good) = dsocs(&folder, arguments);
        assert!(good, "{arguments:?}\n{out}\n{stderr}");
    }
    let last = |of: &str| numbers(&dsocs(&folder, &["run", of]).0).pop().unwrap()[0];
    assert_eq!(
        [last("swing.dsocs"), last("swing.dsocs:far")].map(f64::to_bits),
        [2.0_f64, 1.0].map(f64::to_bits)
    );
}

#[test]
fn mistakes_are_underlined_in_the_text() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[u8], &str); 6] = [
        (
            b"coordinates(x);\nlagrangian = dot(y).powi(2);\nholonomic = x * dot(x);",
            "no name `y` is known here",
        ),
        (b"\xff\xfe", "is saved as UTF-16"),
        (b"", "the text declares nothing"),
        (
            b"parameters { w = samples(\"nowhere.csv\") } coordinates(x); lagrangian = w.at(x);",
            "cannot read nowhere.csv: there is no such file\n --> wrong.dsocs:1:26",
        ),
        (
            b"parameters { w = samples(\"/dev/zero\") } coordinates(x); lagrangian = w.at(x);",
            "it is no file, but a device or a pipe\n --> wrong.dsocs:1:26",
        ),
        (b"coordinates(x); lagrangian = x\x1b[31m;", "out of place"),
    ];
    for (bytes, message) in cases {
        fs::write(folder.path().join("wrong.dsocs"), bytes).unwrap();
        let (out, stderr, good) = dsocs(&folder, &["run", "wrong.dsocs"]);
        assert!(
            !good && out.is_empty() && stderr.starts_with("error: "),
            "{stderr}"
        );
        assert!(stderr.contains(message), "{stderr}");
        assert!(!stderr.contains('\u{1b}'), "{stderr:?}");
    }
    fs::write(folder.path().join("wrong.dsocs"), cases[0].0).unwrap();
    let stderr = dsocs(&folder, &["run", "wrong.dsocs"]).1;
    for line in [
        "--> wrong.dsocs:2:18",
        "lagrangian = dot(y).powi(2);",
        "  |                  ^",
        "--> wrong.dsocs:3:",
    ] {
        assert!(stderr.contains(line), "{stderr}");
    }
    // a missing file
    let stderr = dsocs(&folder, &["run", "missing.dsocs"]).1;
    assert!(stderr.contains("cannot read missing.dsocs"), "{stderr}");
    let stderr = dsocs(&folder, &["run", "swing.dsocs:fast", "--const", "n"]).1;
    assert!(stderr.contains("expected a name and a number"), "{stderr}");
}

/// One mistake at two places of a text gives one message that underlines both.
#[test]
fn what_is_said_of_several_places_is_said_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = "coordinates(x);\nlagrangian = dot(x).powi(2) * mass\n    - mass * x;";
    fs::write(folder.path().join("wrong.dsocs"), text).unwrap();
    let stderr = dsocs(&folder, &["run", "wrong.dsocs"]).1;
    assert_eq!(
        stderr.matches("no name `mass` is known here").count(),
        1,
        "{stderr}"
    );
    assert_eq!(stderr.matches("^^^^").count(), 2, "{stderr}");
    assert!(stderr.contains("wrong.dsocs:2:31"), "{stderr}");
}

#[test]
fn files_that_are_no_text_are_told_how_to_be_saved() {
    let folder = tempfile::tempdir().unwrap();
    for (bytes, message) in [
        (
            &b"//! P.\n//! Pendel f\xfcr mich.\n"[..],
            "line 2 has a character in another encoding; save the file as UTF-8",
        ),
        (b"\xff\xfe/\0/\0", "is saved as UTF-16; save the file as UTF-8"),
        (b"\xfe\xff\0/\0/", "is saved as UTF-16; save the file as UTF-8"),
    ] {
        fs::write(folder.path().join("wrong.dsocs"), bytes).unwrap();
        let (_, stderr, good) = dsocs(&folder, &["list", "wrong.dsocs"]);
        assert!(!good && stderr.contains(message), "{stderr}");
    }
    let marked = b"\xef\xbb\xbfcoordinates(x);\nlagrangian = dot(x).powi(2);";
    fs::write(folder.path().join("marked.dsocs"), marked).unwrap();
    assert!(dsocs(&folder, &["list", "marked.dsocs"]).2);
}

#[test]
fn names_that_are_none_of_a_text_file_are_told() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("runs")).unwrap();
    fs::write(folder.path().join("swing.txt"), "").unwrap();
    fs::write(folder.path().join("swing.dsocs"), SWING).unwrap();
    fs::create_dir(folder.path().join("folder.dsocs")).unwrap();
    for (name, message) in [
        (
            "runs",
            "it is a folder; expected a system, or a text file whose name ends in `.dsocs`",
        ),
        ("./runs", "it is a folder"),
        (
            "swing.txt",
            "the name of a text file with a system ends in `.dsocs`",
        ),
        ("swing", "did you mean the file `swing.dsocs`?"),
        ("swing:far", "did you mean the file `swing.dsocs:far`?"),
        (
            "swang.txt",
            "no file of this name; that of a text file with a system ends in `.dsocs`",
        ),
        (
            "missing.dsocs",
            "cannot read missing.dsocs: there is no such file\n",
        ),
        ("folder.dsocs", "cannot read folder.dsocs: it is a folder\n"),
        ("swing.dsocs:fur", "there is no run `fur` (did you mean `far`?)"),
        ("pendulm", "did you mean `pendulum`?"),
    ] {
        let (_, stderr, good) = dsocs(&folder, &["run", name]);
        assert!(!good && stderr.contains(message), "{name}: {stderr}");
        assert!(!stderr.contains("os error"), "{stderr}");
    }
    let stderr = dsocs(&folder, &["run", "swing.dsocs", "--out", "swing.txt/a.csv"]).1;
    assert!(
        stderr.contains("cannot write") && !stderr.contains("os error"),
        "{stderr}"
    );
}

/// A pendulum with two runs.
const SWING: &str = "//! A pendulum.
parameters {
    /// The length of the rod [m]
    length = 1.0,
}
coordinates(theta);
lagrangian = dot(theta).powi(2) / 2 + 9.81 / length * theta.cos();
run { start = ([1], [0]); step = 0.01; until = 1.0; }
run far { start = ([3], [0]); step = 0.01; until = 1.0; }
";

#[test]
fn runs_of_a_file_are_told() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("swing.dsocs"), SWING).unwrap();
    let list = dsocs(&folder, &["list", "swing.dsocs"]).0;
    assert!(
        list.contains("other runs of this file: swing.dsocs:far\n"),
        "{list}"
    );
    let list = dsocs(&folder, &["list", "swing.dsocs:far"]).0;
    assert!(
        list.contains("--q0 3 ") && list.contains("other runs of this file: swing.dsocs\n"),
        "{list}"
    );
    for command in ["run", "check"] {
        let help = dsocs(&folder, &[command, "--help"]).0;
        assert!(help.contains("swing.dsocs:fast"), "{help}");
    }
    // a long run is announced before it begins
    let stderr = dsocs(&folder, &["run", "swing.dsocs", "--until", "1e12", "--out", "."]).1;
    assert!(stderr.starts_with("note: this run has 1.0e14 steps"), "{stderr}");
}

#[test]
fn a_file_is_printed_word_for_word() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("// by hand\nconst n = 2;\n{SWING}").replace("length * theta", "length * n * theta");
    fs::write(folder.path().join("swing.dsocs"), &text).unwrap();
    assert_eq!(dsocs(&folder, &["text", "swing.dsocs"]).0, text);
    // with another constant it is another text, with the same motion
    let other = dsocs(&folder, &["text", "swing.dsocs", "--const", "n=4"]).0;
    fs::write(folder.path().join("other.dsocs"), &other).unwrap();
    let run = |arguments: &[&str]| dsocs(&folder, &[&["run"], arguments].concat()).0;
    assert_eq!(run(&["other.dsocs"]), run(&["swing.dsocs", "--const", "n=4"]));
    // the texts of the library are readable
    for entry in dsocs_systems::systems::all() {
        let Ok(text) = entry.text() else { continue };
        for noise in ["use {", "\\[", "\n ;", "\n\n"] {
            assert!(!text.contains(noise), "{noise:?}\n{text}");
        }
    }
    let chain = dsocs(&folder, &["text", "chain"]).0;
    assert!(
        chain.contains("    theta: [8],\n);\nlet beyond = |i| sum(i..8, |k| masses[k]);\n"),
        "{chain}"
    );
}

#[test]
fn tables_of_samples_are_listed_and_belong_to_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let text = SWING.replace(
        "}\ncoordinates",
        "    /// The wind [m/s²]\n    wind = samples(\"wind.csv\"),\n    gust = samples(\"wind.csv\", linear),\n}\ncoordinates",
    );
    let text = text.replace(
        "theta.cos();",
        "theta.cos() + (wind.at(t) + gust.at(t)) * theta.sin();",
    );
    fs::write(folder.path().join("swing.dsocs"), &text).unwrap();
    fs::write(folder.path().join("wind.csv"), "t,wind\n0,0\n1,2\n2,1\n").unwrap();
    let list = dsocs(&folder, &["list", "swing.dsocs"]).0;
    for line in [
        "wind        wind.csv (cubic)   m/s²  The wind\n",
        "gust        wind.csv (linear)\n",
    ] {
        assert!(list.contains(line), "{list}");
    }
    let json = dsocs(&folder, &["list", "swing.dsocs", "--format", "json"]).0;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["samples"][0]["interpolation"], "cubic");
    for option in [["--set", "wind=0"], ["--input", "wind=wind.csv"]] {
        let stderr = dsocs(&folder, &[&["run", "swing.dsocs"], &option[..]].concat()).1;
        let words = "`wind` is a table of samples, which stands in the file `wind.csv`; edit that file";
        assert!(stderr.contains(words) && !stderr.contains("f64"), "{stderr}");
    }
    // the content of a file that is no table is not shown in messages
    for (table, message) in [
        ("0,secret\n1,2\n", "line 1 of wind.csv has no number in column 2"),
        ("0,1\n1,2,secret\n", "line 2 of wind.csv has 3 columns"),
        ("0,1\nsecret\n", "line 2 of wind.csv has one column"),
        (
            "0;1\n0,5;1,5\n",
            "line 2 of wind.csv has 4 columns (a decimal has a point)",
        ),
        ("1,1\n0,2\n", "expected places in ascending order"),
        ("", "expected at least one sample"),
    ] {
        fs::write(folder.path().join("wind.csv"), table).unwrap();
        let stderr = dsocs(&folder, &["run", "swing.dsocs"]).1;
        assert!(
            stderr.contains(message) && stderr.contains("--> swing.dsocs:6:20"),
            "{stderr}"
        );
        assert!(!stderr.contains("secret"), "{stderr}");
    }
}

/// A parameter that nothing uses gives a warning with its place, and the run succeeds.
#[test]
fn what_has_no_effect_is_underlined() {
    let folder = tempfile::tempdir().unwrap();
    let text = SWING.replace("length = 1.0,", "length = 1.0, mass = 2.0,");
    fs::write(folder.path().join("swing.dsocs"), text).unwrap();
    let (out, stderr, good) = dsocs(&folder, &["run", "swing.dsocs"]);
    assert!(good && !out.is_empty());
    for line in [
        "warning: nothing uses this parameter",
        "--> swing.dsocs:4:19",
        "^^^^",
    ] {
        assert!(stderr.contains(line), "{stderr}");
    }
}

#[test]
fn a_run_may_move_its_start_onto_the_constraints() {
    let folder = tempfile::tempdir().unwrap();
    let rod = "coordinates(x, y);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
        holonomic = x.powi(2) + y.powi(2) - 1;
        run { start = ([0.6, -0.7], [0.1, 0]); until = 1; }";
    let projected = rod.replace("until = 1;", "until = 1; project = true;");
    fs::write(folder.path().join("rod.dsocs"), rod).unwrap();
    fs::write(folder.path().join("projected.dsocs"), projected).unwrap();
    let stderr = dsocs(&folder, &["run", "rod.dsocs"]).1;
    assert!(
        stderr.contains("`--project`") && !stderr.contains("Start::"),
        "{stderr}"
    );
    let (table, stderr, good) = dsocs(&folder, &["run", "projected.dsocs"]);
    assert!(good && stderr.is_empty(), "{stderr}");
    assert_eq!(table, dsocs(&folder, &["run", "rod.dsocs", "--project"]).0);
    for command in ["check", "stability"] {
        let (_, stderr, good) = dsocs(&folder, &[command, "projected.dsocs"]);
        assert!(good, "{stderr}");
    }
    let printed = dsocs(&folder, &["text", "projected.dsocs", "--const", "n=1"]).1;
    assert!(
        printed.contains("no constant of the text is called `n`"),
        "{printed}"
    );
    let list = dsocs(&folder, &["list", "projected.dsocs"]).0;
    assert!(list.contains(" --project\n"), "{list}");
}

#[test]
fn readers_that_go_away_end_a_program_quietly() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, code) in [
        (&["list"][..], 0),
        (&["text", "pendulum"], 0),
        (&["run", "pendulum"], 0),
        (&["run", "pendulm"], 2),
        (&["list", "pendulm"], 2),
        (&["--help"], 0),
        (&["run", "--no-such-option"], 2),
    ] {
        let mut child = program::dsocs(folder.path(), arguments)
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        drop((child.stdout.take(), child.stderr.take()));
        assert_eq!(child.wait().unwrap().code(), Some(code), "{arguments:?}");
    }
}

#[test]
fn a_text_without_a_folder_reads_no_file() {
    let text = "parameters { w = samples(\"w.csv\") } coordinates(x); lagrangian = w.at(x);";
    let error = Text::parse("w", text).unwrap_err().to_string();
    assert!(error.contains("has no folder"), "{error}");
}

/// The listings of a page that are text files.
fn listings(page: &str) -> Vec<&str> {
    let blocks = page.split("```text\n").skip(1);
    blocks
        .filter_map(|block| block.split_once("```").map(|(block, _)| block))
        .collect()
}

#[test]
fn the_listings_of_the_book_run() {
    let book = include_str!("../src/guide/text_files.md");
    let readme = include_str!("../../README.md");
    let others = [
        include_str!("../src/guide/constraints.md"),
        include_str!("../src/guide/control.md"),
        include_str!("../src/guide/declaration.md"),
        include_str!("../src/guide/maps.md"),
        include_str!("../src/guide/rotations.md"),
        include_str!("../src/guide/symmetry.md"),
        include_str!("../src/guide/the_paper.md"),
        include_str!("../src/guide/time_forces_inputs.md"),
        include_str!("../src/guide/two_roots.md"),
    ];
    let others = others.into_iter().flat_map(listings);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("motor.csv"), "0, 0\n1, 2\n2, 0\n").unwrap();
    let mut count = 0;
    for listing in listings(book).into_iter().chain(listings(readme)).chain(others) {
        if !listing.starts_with("//!") {
            continue;
        }
        count += 1;
        fs::write(folder.path().join("swing.dsocs"), listing).unwrap();
        let (out, stderr, good) = dsocs(&folder, &["run", "swing.dsocs"]);
        assert!(
            good && stderr.is_empty() && out.lines().count() > 100,
            "{listing}{stderr}"
        );
        // the library reads it, too
        assert!(Text::read(folder.path().join("swing.dsocs")).is_ok());
    }
    assert_eq!(count, 23);
    // a named run, and the mistake as the message shows it
    let all = listings(book);
    fs::write(folder.path().join("swing.dsocs"), all[0]).unwrap();
    assert!(dsocs(&folder, &["run", "swing.dsocs:far"]).2);
    let wrong = all[0].replace("-friction * length.powi(2) * dot(theta)", "-friction * dot(thet)");
    fs::write(folder.path().join("swing.dsocs"), wrong).unwrap();
    let stderr = dsocs(&folder, &["run", "swing.dsocs"]).1;
    let shown = all.iter().find(|listing| listing.starts_with("error")).unwrap();
    assert!(stderr.starts_with(shown.trim_end()), "{stderr}");
}

#[test]
fn what_a_text_says_is_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let text = "//! A <script>alert(1)</script> & \"swing\".
        parameters {
            /// The <i>length</i> [m</svg>]
            length = 1.0,
        }
        coordinates(
            /// The <b>angle</b> [rad<\"&>]
            theta
        );
        lagrangian = dot(theta).powi(2) / 2 + 9.81 / length * theta.cos();
        /// The <u>height</u>, =1+1 [m,\"]
        let height = 1 - theta.cos();
        observe = [height];
        run { start = ([1], [0]); until = 1.0; }";
    fs::write(folder.path().join("odd <b>.dsocs"), text).unwrap();
    let arguments = [
        "run",
        "odd <b>.dsocs",
        "--report",
        "odd.html",
        "--plot",
        "odd.svg",
        "--out",
        "odd.csv",
    ];
    let (_, stderr, good) = dsocs(&folder, &arguments);
    assert!(good, "{stderr}");
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    for name in ["odd.html", "odd.svg"] {
        let page = read(name);
        for tag in ["<script>alert", "<b>", "<i>", "<u>", "</svg>]", "rad<"] {
            assert!(!page.contains(tag), "{tag} in {name}");
        }
    }
    assert!(read("odd.html").contains("&lt;script&gt;alert(1)"));
    // the head of a table has the names alone
    let table = read("odd.csv");
    let head = table.lines().next().unwrap();
    assert_eq!(head, "t,theta,v_theta,force_theta,energy,height");
    let (list, _, good) = dsocs(&folder, &["list", "odd <b>.dsocs"]);
    assert!(good && !list.contains('\u{1b}'), "{list}");
    let (json, _, good) = dsocs(&folder, &["list", "odd <b>.dsocs", "--format", "json"]);
    assert!(good && serde_json::from_str::<serde_json::Value>(&json).is_ok());
}

#[test]
fn a_factor_divides_rows_with_decimals_too() {
    let folder = tempfile::tempdir().unwrap();
    // products of these numbers have rounding; the law is u = -0.5 x - 0.9 v_x, also where v_x changes its
    // sign
    fs::write(
        folder.path().join("law.dsocs"),
        "coordinates(x, y);
        let kin = 0.6*dot(x).powi(2) + 0.1*y.cos()*dot(x)*dot(y) + 0.1*dot(y).powi(2);
        lagrangian = kin - 2*y.cos();
        let V = kin + 2*y.cos() + 0.25*x.powi(2);
        kinematic = dot(V) + 0.9*dot(x).powi(2);
        constraint_forces = [(1, 0)];
        branch = divide(dot(x));
        run { start = ([0, 0.3], [0.2, 2]); until = 2; }",
    )
    .unwrap();
    for h in [0.01, 0.0071, 0.003] {
        let (table, stderr, done) = dsocs(&folder, &["run", "law.dsocs", "--step", &h.to_string()]);
        assert!(done && stderr.is_empty(), "{stderr}");
        let nodes = numbers(&table);
        let errors = nodes[1..].iter().map(|row| {
            let [x, v, force] = [row[1], row[3], row[5]];
            (force + 0.5 * x + 0.9 * v).abs()
        });
        let largest = errors.fold(0.0, f64::max);
        assert!(largest <= 30.0 * h * h, "{h}: {largest}");
    }
}

#[test]
fn vectors_and_matrices_are_printed_as_they_are_declared() {
    let folder = tempfile::tempdir().unwrap();
    let text = "const heavy = 2;
        parameters { drag = [[0.1, 0.0, 0.0], [0.0, 0.2 * heavy, 0.0], [0.0, 0.0, 0.3]], field = [0.0, 0.5, 1.0], field_0_0 = 4.0 }
        coordinates(x: [3]);
        lagrangian = heavy * dot(x).norm_squared() / 2 - field_0_0 * x.norm_squared() / 2;
        external_forces = dot(x).cross(field) - drag * dot(x);
        run { start = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.5]); step = 0.01; until = 1.0; }";
    fs::write(folder.path().join("charge.dsocs"), text).unwrap();
    let (printed, _, _) = dsocs(&folder, &["text", "charge.dsocs", "--const", "heavy=3"]);
    for line in [
        "    drag = [[0.1, 0.0, 0.0], [0.0, 0.6000000000000001, 0.0], [0.0, 0.0, 0.3]],\n",
        "    field: [3] = [0.0, 0.5, 1.0],\n",
        "    field_0_0 = 4.0,\n",
    ] {
        assert!(printed.contains(line), "{printed}");
    }
    fs::write(folder.path().join("printed.dsocs"), &printed).unwrap();
    let (run, _, succeeded) = dsocs(&folder, &["run", "printed.dsocs"]);
    assert!(succeeded);
    let with = dsocs(&folder, &["run", "charge.dsocs", "--const", "heavy=3"]);
    assert_eq!(run, with.0);
    let (_, _, made) = dsocs(&folder, &["new", "--from", "printed.dsocs", "crate"]);
    assert!(made);
    let rust = fs::read_to_string(folder.path().join("crate/src/main.rs")).unwrap();
    for line in [
        "    drag: [[f64; 3]; 3],\n",
        "    field: [f64; 3],\n",
        "    field_0_0: f64,\n",
    ] {
        assert!(rust.contains(line), "{rust}");
    }
}
