//! Systems in text files: what is read, and the messages for wrong ones.

use proptest::prelude::*;

use crate::{Call, Curve, Place, Table, Text, read};

const PENDULUM: &str =
    "coordinates(theta); lagrangian = dot(theta).powi(2) / 2 + 9.81 / length * theta.cos();";

fn text(text: &str) -> Text {
    match read("swing", text, &[]) {
        Ok(read) => read,
        Err(mistakes) => panic!("{text}\n{mistakes:?}"),
    }
}

/// The mistakes of a text, as `line:column: message`.
fn mistakes(text: &str) -> Vec<String> {
    match read("swing", text, &[]) {
        Ok(_) => Vec::new(),
        Err(mistakes) => mistakes.iter().map(ToString::to_string).collect(),
    }
}

#[test]
fn an_array_is_no_function() {
    let text = "parameters { dry: [2] = [1.0; 2] } coordinates(x, y); lagrangian = dot(x).powi(2) + dot(y).powi(2) - dry(x);";
    let mistakes = read("array", text, &[]).unwrap_err();
    assert!(
        mistakes[0].message.contains("`dry` is an array of numbers"),
        "{mistakes:?}"
    );
}

/// The mistake of a text, with what it underlines.
#[track_caller]
fn underlined(text: &str, constants: &[(String, f64)], at: &str, message: &str) {
    let mistakes = read("swing", text, constants).map(drop).expect_err(text);
    let [mistake] = &mistakes[..] else {
        panic!("{text}: {mistakes:?}")
    };
    assert!(mistake.message.contains(message), "{text}: {mistakes:?}");
    let line = text.lines().nth(mistake.line - 1).unwrap();
    let found = line.get(mistake.column - 1..mistake.end_column - 1);
    assert_eq!(
        (mistake.line, found),
        (mistake.end_line, Some(at)),
        "{text}: {mistakes:?}"
    );
}

#[test]
fn parameters_have_no_name_of_a_column() {
    for (parameters, coordinates, at, message) in [
        (
            "v_x = 1",
            "x",
            "v_x",
            "`v_x` is the column of the velocity of `x`",
        ),
        (
            "a_x = 1",
            "x",
            "a_x",
            "`a_x` is the column of the acceleration of `x`",
        ),
        ("m = 1, force_y = 1", "x, y", "force_y", "the force of `y`"),
        ("error_x = 1", "x", "error_x", "the error of `x`"),
        ("energy = 1", "x", "energy", "the energy"),
        ("lambda_0 = 1", "x", "lambda_0", "a multiplier"),
        // elements of arrays, told once
        (
            "lambda = [1, 2]",
            "x",
            "lambda",
            "`lambda_0` is the column of a multiplier",
        ),
        (
            "v_x = [1, 2]",
            "x: [2]",
            "v_x",
            "`v_x_0` is the column of the velocity of `x_0`",
        ),
        (
            "v_r = [1, 2]",
            "r_1",
            "v_r",
            "`v_r_1` is the column of the velocity of `r_1`",
        ),
        // of another coordinate, or none
        ("v_y = 1, a = 2, v = 3, lambda = 4, force = 5", "x", "", ""),
    ] {
        let mass = if coordinates.contains('[') {
            "x[0]"
        } else {
            coordinates.split(',').next().unwrap()
        };
        let text = format!(
            "parameters {{ {parameters} }}\ncoordinates({coordinates});\nlagrangian = dot({mass}).powi(2);"
        );
        if message.is_empty() {
            assert!(read("swing", &text, &[]).is_ok());
        } else {
            underlined(&text, &[], at, message);
        }
    }
}

#[test]
fn unknown_constants_are_shown_where_they_are() {
    let rest = "coordinates(x: [n]);\nlagrangian = sum(0..n, |i| dot(x[i]).powi(2));";
    for (constant, at, message) in [
        (
            "const n = k + 1;",
            "k",
            "no constant `k` is declared before this one",
        ),
        (
            "const number = 2;\nconst n = 2 * (nunber + 1);",
            "nunber",
            "did you mean `number`?",
        ),
        ("const n = 2 % 3;", "2 % 3", "expected a number, `const n = 3;`"),
    ] {
        underlined(&format!("{constant}\n{rest}"), &[], at, message);
    }
    // given from outside
    let given = [("m".to_owned(), 2.0)];
    underlined(
        &format!("const n = 3;\n{rest}"),
        &given,
        "n",
        "no constant of the text is called `m`; these are `n`",
    );
    underlined(
        "//! A mass.\ncoordinates(x); lagrangian = dot(x).powi(2);\n",
        &given,
        "coordinates",
        "no constant of the text is called `m`; it has none",
    );
}

#[test]
fn messages_are_for_people_who_know_no_rust() {
    for (lagrangian, run, part) in [
        ("x ^ 2", "", "`^` is no power here"),
        ("x ** 2", "", "`**` is no power here"),
        (
            "sin(x)",
            "",
            "a function stands behind what it is of: expected `x.sin()`",
        ),
        ("y", "", "expected a coordinate, a parameter or an earlier `let`"),
        ("x", "until = -1.0;", "this run ends before it begins"),
        ("x", "step = -0.1; until = 1.0;", "this run ends before it begins"),
    ] {
        let text = format!("coordinates(x); lagrangian = dot(x).powi(2) - {lagrangian}; run {{ {run} }}");
        let mistakes = read("rust", &text, &[]).unwrap_err();
        assert!(mistakes[0].message.contains(part), "{mistakes:?}");
    }
    let back = "coordinates(x); lagrangian = dot(x).powi(2); run { step = -0.1; until = -1.0; }";
    assert!(read("back", back, &[]).is_ok());
}

#[test]
fn what_a_terminal_would_obey_is_refused() {
    for (text, place) in [
        ("//! a\n//! b\u{1b}[31m", (2, 6)),
        ("coordinates(x); // \u{202e}", (1, 20)),
        ("#[doc = \"\\u{7}\"] coordinates(x);", (1, 9)),
        ("parameters { w = samples(\"\\u{9b}31m\") }", (1, 26)),
        ("coordinates(x);\r lagrangian = x;", (1, 16)),
    ] {
        let mistakes = read("hidden", text, &[]).unwrap_err();
        let hidden = |mistake: &&crate::Mistake| mistake.message.contains("which is not seen");
        let hidden = mistakes.iter().find(hidden).unwrap();
        assert_eq!((hidden.line, hidden.column), place);
    }
    let good = "//! Two\r\n//! lines\t\r\ncoordinates(x);\r\nlagrangian = dot(x).powi(2) / 2;";
    assert!(read("good", good, &[]).is_ok());
}

#[test]
fn parameters_and_runs_have_their_values() {
    let read = text(&format!(
        "//! A pendulum.
         //! Second line.
         const n = 3;
         parameters {{
             /// The length [m]
             length = 2.0,
             half = length / 2,
             masses: [n] = [1.0; n],
             others = [half, 2 * pi, -0.0],
             /// The gust [m/s²]
             gust = samples(\"gust.csv\", monotone),
         }}
         {PENDULUM}
         external_forces = gust.at(t) * masses[1] * others[0];
         run {{ start = ([pi / 4], [0]); step = 1e-3; until = n; project = true; }}
         run fast {{ start = ([1; 1], [each(0..1, |i| 0.5 + i)]); }}"
    ));
    assert_eq!(read.model.name(), "Swing");
    assert_eq!(
        read.model.parameters(),
        [
            "length", "half", "masses_0", "masses_1", "masses_2", "others_0", "others_1", "others_2"
        ]
    );
    let tau = core::f64::consts::TAU;
    assert_eq!(read.values, [2.0, 1.0, 1.0, 1.0, 1.0, 1.0, tau, 0.0]);
    assert!(read.values[7].is_sign_negative());
    let gust = Table {
        name: "gust".to_owned(),
        file: "gust.csv".to_owned(),
        curve: Curve::Monotone,
        doc: "The gust [m/s²]".to_owned(),
        place: read.tables[0].place,
    };
    assert_eq!(read.tables, [gust]);
    assert_eq!((gust_at(&read).line, gust_at(&read).column), (11, 29));
    let [run, fast] = &read.runs[..] else {
        panic!("{:?}", read.runs)
    };
    assert_eq!(
        (run.name.as_deref(), run.step, run.until),
        (None, Some(1e-3), Some(3.0))
    );
    assert_eq!(run.start, Some([vec![core::f64::consts::FRAC_PI_4], vec![0.0]]));
    assert_eq!(fast.name.as_deref(), Some("fast"));
    assert_eq!([run.project, fast.project], [true, false]);
    assert_eq!(fast.start, Some([vec![1.0], vec![0.5]]));
    let data = read.model.data();
    assert_eq!(data.itself.doc, "A pendulum. Second line.");
    assert_eq!(data.others[0].name, "gust");
    let table = Call::Samples {
        name: "gust".to_owned(),
        derivative: 0,
    };
    assert!(data.calls.contains(&table), "{:?}", data.calls);
}

/// The place where a text names its first file.
fn gust_at(text: &Text) -> Place {
    text.tables[0].place
}

#[test]
fn a_run_may_set_a_constant() {
    let chain = "const n = 3; coordinates(q: [n]); lagrangian = sum(0..n, |i| dot(q[i]).powi(2)) / 2;";
    assert_eq!(text(chain).model.coordinates().len(), 3);
    let five = read("chain", chain, &[("n".to_owned(), 5.0)]).unwrap();
    assert_eq!(five.model.coordinates().len(), 5);
    let wrong = read("chain", chain, &[("m".to_owned(), 5.0)]).unwrap_err();
    assert!(
        wrong[0].message.contains("no constant of the text is called `m`"),
        "{wrong:?}"
    );
}

#[test]
fn the_text_of_a_declaration_declares_the_same() {
    for statements in [
        PENDULUM,
        "coordinates(\n    /// The angle [rad]\n    theta,\n);\nlet w = -dot(theta) / (1 + theta.powi(2));\nlagrangian = w.powi(2) / length;",
    ] {
        let first = text(&format!("parameters {{ length = 1 }} {statements}"))
            .model
            .data();
        let again = text(&format!("parameters {{ length = 1 }} {}", first.declaration))
            .model
            .data();
        assert_eq!(first, again);
    }
}

/// Statements before a declaration, the line and column of the mistake, and a part of its message.
const MISTAKES: &[(&str, &str, &str)] = &[
    (
        "parameters { length = 1, length2 = lenght }",
        "1:36",
        "did you mean `length`?",
    ),
    (
        "parameters { a = b, b = 1, length = 1 }",
        "1:18",
        "expected it before this use",
    ),
    (
        "parameters { length = 1 / 0 }",
        "1:23",
        "worked out, this is infinite",
    ),
    (
        "parameters { length = 1, masses: [3] = [1, 2] }",
        "1:40",
        "expected 3 values",
    ),
    (
        "parameters { length = samples(3) }",
        "1:23",
        "expected the name of a file",
    ),
    (
        "parameters { length 1 }",
        "1:21",
        "expected `length = …`, with `=`",
    ),
    ("parameters length = 1;", "1:1", "expected `parameters {"),
    (
        "parameters { length = 1 } parameters { m = 1 }",
        "1:27",
        "a second time",
    ),
    ("parameters { length = 1 } const length = 2;", "1:14", ""),
    ("const t = 2; parameters { length = 1 }", "1:7", "`t` is time"),
    (
        "const n = x; parameters { length = 1 }",
        "1:11",
        "expected a number",
    ),
    (
        "const n = 2; let n = 3; parameters { length = 1 }",
        "1:18",
        "is a constant of this text",
    ),
    (
        "parameters { length = 1 } run { start = ([1, 2], [0]); }",
        "1:42",
        "a number for each coordinate",
    ),
    (
        "parameters { length = 1 } run { start = [1]; }",
        "1:41",
        "position and velocity",
    ),
    (
        "parameters { length = 1 } run { stepp = 1; }",
        "1:33",
        "did you mean `step`?",
    ),
    ("parameters { length = 1 } run { step = 0; }", "1:40", "not zero"),
    (
        "parameters { length = 1 } run { step = 1; step = 2; }",
        "1:43",
        "a second time",
    ),
    (
        "parameters { length = 1 } run { } run { }",
        "1:35",
        "a second run needs a name",
    ),
    (
        "parameters { length = 1 } run a { } run a { }",
        "1:41",
        "called `a` already",
    ),
    (
        "parameters { length = 1 } external_forces = drag(theta);",
        "1:45",
        "no function `drag` is known here",
    ),
    (
        "parameters { length = 1 } external_forces = Drag::at(theta);",
        "1:45",
        "beyond the language",
    ),
    (
        "parameters { length = 1 } external_forces = LENGTH * theta;",
        "1:45",
        "no name `LENGTH` is known here",
    ),
    (
        "parameters { length = 1 } external_forces = theta.sen();",
        "1:51",
        "did you mean `sin`?",
    ),
    (
        "parameters { length = 1, w = samples(\"w.csv\") } external_forces = w.value(t);",
        "1:69",
        "`w.at(t)`",
    ),
    (
        "parameters { length = 1, w = samples(\"w.csv\") } external_forces = w(t);",
        "1:67",
        "`w.at(t)`",
    ),
    (
        "parameters { length = 1, w = samples(\"w.csv\") } external_forces = w * t;",
        "1:67",
        "",
    ),
];

#[test]
fn every_mistake_is_reported_at_its_place() {
    for (statements, place, message) in MISTAKES {
        let told = mistakes(&format!("{statements} {PENDULUM}"));
        let found = told
            .iter()
            .any(|told| told.starts_with(&format!("{place}:")) && told.contains(message));
        assert!(
            found,
            "{statements}
{told:#?}"
        );
    }
    // mistakes in all statements are reported at once
    let all = mistakes(
        "parameters { length = lenght }\nrun { stepp = 1; }\ncoordinates(theta);\nlagrangian = thta;",
    );
    assert!(all.len() >= 2, "{all:?}");
}

#[test]
fn what_is_too_large_is_refused() {
    let deep = format!("{}1{}", "(".repeat(100_000), ")".repeat(100_000));
    let most = "x".repeat(crate::MOST_BYTES + 1);
    let repeated = |first: &str, again: &str| {
        let lagrangian = format!("{first}{}", again.repeat(200_000 / again.len()));
        (
            format!("coordinates(x); lagrangian = {lagrangian};"),
            "nested at most",
        )
    };
    for (text, message) in [
        (format!("coordinates(x); lagrangian = {deep};"), "nested at most"),
        repeated("x", " + x"),
        repeated("x", " * x"),
        repeated("x", ".sin()"),
        repeated("x", ".x"),
        repeated("x", "[0]"),
        repeated("x", " as f64"),
        repeated("x", "(x)"),
        repeated("x", " < x"),
        repeated("x", " = x"),
        repeated("", "|a| "),
        repeated("", "-"),
        repeated("", "!"),
        repeated("", "&"),
        repeated("x", "?"),
        repeated("x", ".powi(2)"),
        repeated("", "return "),
        repeated("", "if x < 0 { 1 } else "),
        (format!("parameters {{ a = {deep} }}"), "nested at most"),
        (most, "expected at most"),
        (
            "coordinates(x); lagrangian = sum(0..1000000000, |i| i * x);".to_owned(),
            "200000",
        ),
        (
            "coordinates(x: [1000000000]); lagrangian = 1;".to_owned(),
            "expected",
        ),
        (
            "parameters { m: [1000000000] = [1; 1000000000] } coordinates(x); lagrangian = x;".to_owned(),
            "at most",
        ),
        (
            "let f = |u| f(u); coordinates(x); lagrangian = f(x);".to_owned(),
            "`f`",
        ),
        ("coordinates(x); lagrangian = 1e999 * x;".to_owned(), ""),
    ] {
        let told = mistakes(&text);
        assert!(
            told.iter().any(|told| told.contains(message)),
            "{:.80}\n{:.300}",
            text,
            format!("{told:?}")
        );
    }
}

/// A text of the greatest allowed length is read on the stack that texts have.
#[test]
fn a_long_sum_is_read() {
    let terms = crate::parse::LONGEST / 2 - 10;
    let text = format!(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2{};",
        " - x".repeat(terms)
    );
    let reads = move || read("long", &text, &[]).map(|read| read.model.data().unknowns);
    let read = std::thread::Builder::new()
        .stack_size(64 << 20)
        .spawn(reads)
        .unwrap();
    assert_eq!(read.join().unwrap().unwrap(), 0);
}

/// `let`s that use the previous one several times share their nodes, and take time in proportion to their
/// number. A walk without a memory of visited nodes would take billions of steps for each of these texts.
#[test]
fn chained_lets_are_shared() {
    const COUNT: usize = 30;
    let uses = [
        "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + #;",
        "lagrangian = (dot(x).powi(2) * (2 + #.sin()) + dot(y).powi(2)) / 2; observe = [#];",
        "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; external_forces = (#, 0);",
        "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; holonomic = # - y;",
        "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; nonholonomic = dot(#) + y;",
        "lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; kinematic = dot(dot(x) * #) + dot(x); constraint_forces = [(0, 1)]; branch = divide(dot(x));",
    ];
    let forms = [
        "# * #.sin() + #",
        "#.sin() + #.cos()",
        "(# + 1) * (# + 2)",
        "#.powi(2) + #",
        "# / (1 + #.powi(2))",
        "if # < 1 { # * x } else { # + 1 }",
        "#.abs() * # + #.signum()",
        "#.atan2(# + 1)",
    ];
    for (at, form) in forms.into_iter().enumerate() {
        let lets = (0..COUNT).map(|i| {
            let value = form.replace('#', &format!("e{i}"));
            format!("let e{} = {value};", i + 1)
        });
        let lets = lets.collect::<String>();
        // each form in two uses, each use with two or three forms
        for used in [at, at + 3].map(|at| uses[at % uses.len()]) {
            let used = used.replace('#', &format!("e{COUNT}"));
            let text = format!("coordinates(x, y); let e0 = x; {lets} {used}");
            let data = read("lets", &text, &[]).unwrap().model.data();
            assert!(data.tape.len() > COUNT, "{form}: {used}");
        }
    }
    // the graph grows by the new nodes only
    let chain = |count: usize| {
        let lets = (0..count).map(|i| format!("let e{} = e{i} * e{i}.sin() + e{i};", i + 1));
        let lets = lets.collect::<String>();
        let text = format!("coordinates(x); let e0 = x; {lets} lagrangian = dot(x).powi(2) / 2 + e{count};");
        read("lets", &text, &[]).unwrap().model.data().tape.len()
    };
    assert!(chain(40) < 3 * chain(20));
}

/// Words from which random texts are made.
const WORDS: [&str; 40] = [
    "parameters",
    "run",
    "const",
    "coordinates",
    "lagrangian",
    "kinematic",
    "holonomic",
    "let",
    "dot",
    "sum",
    "each",
    "x",
    "y",
    "n",
    "t",
    "h",
    "pi",
    "samples",
    "\"a.csv\"",
    "(",
    ")",
    "{",
    "}",
    "[",
    "]",
    "=",
    ";",
    ",",
    ":",
    ".",
    "|",
    "+",
    "-",
    "*",
    "/",
    "1",
    "2.5",
    "0..3",
    "//! doc\n",
    "/// doc\n",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn bytes_end_in_a_message_or_a_system(text in ".{0,200}") {
        let _ = read("any", &text, &[]).map(|read| read.model.data());
    }

    #[test]
    fn words_end_in_a_message_or_a_system(words in prop::collection::vec(prop::sample::select(&WORDS[..]), 0..60)) {
        let _ = read("any", &words.join(" "), &[]).map(|read| read.model.data());
    }

    #[test]
    fn what_is_cut_off_ends_in_a_message_or_a_system(from in 0..400_usize, to in 0..400_usize) {
        let whole = format!(
            "//! Docs\nconst n = 2; parameters {{ /// m\n m: [n] = [1; n], length = 2.0 }} {PENDULUM} \
             external_forces = -m[0] * dot(theta).signum(); observe = [w]; let w = theta; run {{ start = ([1], [0]); step = 0.1; until = 1; }}"
        );
        let keep = |place: &usize| *place < from.min(to) || *place >= from.max(to);
        let text: String = whole.char_indices().filter(|(at, _)| keep(at)).map(|(_, c)| c).collect();
        let _ = read("any", &text, &[]).map(|read| read.model.data());
    }
}
