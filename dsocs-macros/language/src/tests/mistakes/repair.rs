//! Error messages for people who write a text for the first time: each mistake once, at its place, in words
//! that need no Rust.

use crate::read;

/// The beginning of a text.
const HEAD: &str = "parameters { length = 1.0, gravity = 9.81 }\ncoordinates(theta);\n";
/// Its Lagrangian.
const LAGRANGIAN: &str = "lagrangian = dot(theta).powi(2) / 2 + gravity / length * theta.cos();\n";
/// Its run.
const RUN: &str = "run { start = ([1.0], [0.0]); step = 0.01; until = 0.1; }\n";

/// The mistakes of a text, as `line:column: message`.
fn told(text: &str) -> Vec<String> {
    match read("slip", text, &[]) {
        Ok(_) => Vec::new(),
        Err(mistakes) => mistakes.iter().map(ToString::to_string).collect(),
    }
}

/// Asserts that a text has these mistakes, in this order, and that no message needs knowledge of Rust.
fn says(text: &str, expected: &[&str]) {
    let told = told(text);
    assert_eq!(told.len(), expected.len(), "{text}\n{told:#?}");
    for (told, expected) in told.iter().zip(expected) {
        let (place, message) = expected.split_once(' ').unwrap();
        assert!(
            told.starts_with(&format!("{place}: ")) && told.contains(message),
            "{text}\n{told}\nexpected: {expected}"
        );
        for word in [
            "f64",
            "Rust",
            "struct",
            "method",
            "tuple",
            "closure",
            "literal",
            "self::",
            "identifier",
            "token",
            "usize",
            "compiler",
            "macro",
        ] {
            assert!(!told.contains(word), "{word}: {told}");
        }
    }
}

#[test]
fn characters_that_mean_nothing() {
    let lagrangian = |of: &str| format!("{HEAD}lagrangian = {of};\n{RUN}");
    for (text, expected) in [
        (
            format!("# a pendulum\n{HEAD}{LAGRANGIAN}{RUN}"),
            &["1:1 a comment begins with `//`"][..],
        ),
        (
            format!("% a pendulum\n{HEAD}{LAGRANGIAN}{RUN}"),
            &["1:1 a comment begins with `//`"],
        ),
        (
            lagrangian("dot(theta).powi(2) # kinetic\n + theta"),
            &["3:33 a comment begins with `//`"],
        ),
        (
            lagrangian("theta'.powi(2)"),
            &["3:19 written `dot(theta)`, without `'`"],
        ),
        (
            lagrangian("theta''*theta′"),
            &["3:19 `ddot(theta)`", "3:27 `dot(theta)`"],
        ),
        (
            lagrangian("dot(theta).powi(2) − theta"),
            &["3:33 `−` looks like `-`"],
        ),
        (
            lagrangian("dot(theta)²/2·length×length"),
            &["3:24 `x.powi(2)`", "3:27 looks like `*`", "3:34 looks like `*`"],
        ),
        (
            lagrangian("if theta ≥ 0 { 1 } else { 0 }"),
            &["3:23 written `>=`"],
        ),
        (
            lagrangian("√theta + ∞"),
            &["3:14 written `x.sqrt()`", "3:23 finite"],
        ),
        (
            lagrangian("dot(theta\\_1)"),
            &["3:23 `\\` has no meaning here", "3:24 "],
        ),
        (
            "coordinates(x₁);\nlagrangian = dot(x₁).powi(2);".to_owned(),
            &["1:14 expected `1`", "2:19 expected `1`"],
        ),
        (
            format!("{HEAD}lagr\u{200b}angian = theta;"),
            &["3:1 did you mean `lagrangian`?", "3:5 U+200B"],
        ),
        (
            "parameters { w = samples('w.csv') } coordinates(x); lagrangian = w.at(x);".to_owned(),
            &["1:26 double quotation marks"],
        ),
        (
            "parameters { w = samples(“w.csv”) } coordinates(x); lagrangian = w.at(x);".to_owned(),
            &["1:26 looks like `\"`"],
        ),
        (
            "parameters { w = samples(\"w.csv) }\ncoordinates(x); lagrangian = w.at(x);".to_owned(),
            &["1:26 no partner in its line"],
        ),
        (
            "parameters { a＝1.0，b = 2 } coordinates(x); lagrangian = a*b*x;".to_owned(),
            &["1:15 `=`", "1:19 `,`"],
        ),
        (
            lagrangian("theta.cos(\u{441}\u{43e}s)"),
            &["3:20 in the parentheses of `cos`"],
        ),
    ] {
        says(&text, expected);
    }
}

#[test]
fn brackets_without_partners() {
    let lagrangian = |of: &str| format!("{HEAD}lagrangian = {of};\n{RUN}");
    says(
        &lagrangian("(dot(theta).powi(2) / 2"),
        &["3:14 this `(` has no `)` before the end of the statement"],
    );
    says(
        &lagrangian("dot(theta).powi(2))"),
        &["3:32 this `)` closes no bracket"],
    );
    says(
        &lagrangian("dot(theta].powi(2)"),
        &["3:17 this `(` has no `)`", "3:23 this `]` closes no bracket"],
    );
    says(
        "parameters { length = 1.0 \ncoordinates(x);\nlagrangian = x;",
        &["1:12 this `{` has no `}`"],
    );
    says(
        &format!("{HEAD}{LAGRANGIAN}run {{ start = ([1.0], [0.0); }}"),
        &["4:23 this `[` has no `]` before the `)`"],
    );
    says("coordinates(x); /* never ends", &["1:17 this comment has no end"]);
    says(&"{".repeat(200_000), &["1:121 nested at most 120 deep"]);
}

#[test]
fn names_that_cannot_be_used() {
    let of = |name: &str| {
        format!("parameters {{ {name} = 1.0 }} coordinates(x); lagrangian = {name} * dot(x).powi(2);")
    };
    says(
        &of("type"),
        &["1:14 `type` is a reserved word", "1:56 `type` is a reserved word"],
    );
    for name in [
        "in", "move", "box", "final", "loop", "where", "yield", "Self", "super", "for",
    ] {
        let told = told(&of(name));
        assert!(
            told.iter()
                .all(|told| told.contains("is a reserved word; expected another name")),
            "{told:?}"
        );
        assert_eq!(told.len(), 2, "{told:?}");
    }
    // two letters that look the same
    says(
        "parameters { \u{b5} = 1.0 } coordinates(x); lagrangian = \u{3bc} * dot(x).powi(2);",
        &[
            "1:53 it looks like `\u{b5}`, and has another letter: `\u{3bc}` is U+03BC in one and U+00B5 in the other",
        ],
    );
    says(
        "parameters { ma\u{441}s = 1.0 } coordinates(x); lagrangian = macs * dot(x).powi(2);",
        &["1:56 U+0441"],
    );
    says(
        "coordinates(x); lagrangian = x\u{307}.powi(2) + \u{1e8d};",
        &["1:30 did you mean `dot(x)`?", "1:43 did you mean `ddot(x)`?"],
    );
}

#[test]
fn signs_of_other_languages() {
    let lagrangian = |of: &str| format!("{HEAD}lagrangian = {of};\n{RUN}");
    for (of, expected) in [
        ("dot(theta)^2", &["3:24 `^` is no power here"][..]),
        ("dot(theta)**2", &["3:24 `**` is no power here"]),
        (
            "cos(theta) + np.sin(theta)",
            &[
                "3:14 expected `theta.cos()`",
                "3:27 expected `theta.sin()`, without `np`",
            ],
        ),
        ("pow(theta, 2)", &["3:14 expected `theta.powi(2)` or `.powf(a)`"]),
        ("sqrt(theta + 1)", &["3:14 expected `(theta+1).sqrt()`"]),
        (
            "theta.cosine() * theta.squared()",
            &["3:20 expected `.cos()`", "3:37 expected `.powi(2)`"],
        ),
        ("theta.sen()", &["3:20 did you mean `sin`?"]),
        ("square(theta)", &["3:14 expected `theta.powi(2)`"]),
        ("diff(theta, t)", &["3:14 expected `dot(theta)`"]),
        ("theta.powi(0.5)", &["3:25 `x.powf(0.5)`"]),
        (
            "2theta + 3gravity",
            &["3:14 expected `2 * theta`", "3:23 expected `3 * gravity`"],
        ),
        ("2 theta", &["3:16 a product is written with `*`"]),
        (
            "120deg * 3kg",
            &["3:14 `120 * pi / 180`", "3:23 a number has no unit"],
        ),
        ("theta > 0 ? 1 : 0", &["3:26 a choice is written `if"]),
        ("1 if theta > 0 else 0", &["3:16 a choice is written `if"]),
        (
            "if theta > 0 and theta < 1 { 1 } else { 0 }",
            &["3:27 written `&&`"],
        ),
        ("|theta| + 1", &["3:22 `x.abs()`"]),
        ("sum(0..3, i => theta)", &["3:26 `|i| …`"]),
        ("sum(0..m, |i| theta)", &["3:21 a constant, `const n = 3;`"]),
        ("sum(0..3, theta)", &["3:14 what stands for each index"]),
        ("(0,5 * theta)", &["3:14 a decimal has a point"]),
        ("1e999 * theta", &["3:14 too large"]),
        ("nan * theta", &["3:14 expected a finite number"]),
        ("std::cos(theta)", &["3:14 beyond the language"]),
        ("theta.f", &["3:20 a number has no parts"]),
        ("dot(theta) /// speed\n * 2", &["3:25 a comment begins with `//`"]),
        ("dot(theta) +", &["3:26 expected a value here"]),
    ] {
        says(&lagrangian(of), expected);
    }
}

#[test]
fn statements_of_other_languages() {
    for (statement, expected) in [
        (
            "kinetic minus potential\n",
            &["3:1 no statement begins with `kinetic`"][..],
        ),
        (
            "hello\n",
            &["3:1 no statement begins with `hello`: expected a statement"],
        ),
        (
            "import numpy as np\n",
            &["3:1 functions and `pi` are known without it"],
        ),
        ("def f(x): return x\n", &["3:1 `let f = |x| …;`"]),
        ("fn f(x: f64) -> f64 { x }\n", &["3:1 `let f = |x| …;`"]),
        ("f(x) = x.sin();\n", &["3:1 `let f = |x| …;`"]),
        ("let f(x) = x.sin();\n", &["3:5 `let f = |x| …;`"]),
        ("for i in 0..3 { }\n", &["3:1 there are no loops"]),
        (
            "T = dot(theta).powi(2)\nexternal_forces = -T * theta\n",
            &["3:1 `let T = …;`", "4:24 expected `;` behind this"],
        ),
        (
            "v = length * dot(theta);\n",
            &["3:1 `let v = …;` gives an expression a name"],
        ),
        ("let v := length * dot(theta);\n", &["3:7 without `:`"]),
        ("step = 0.01;\n", &["3:1 `run { step = …; }`"]),
        ("force(theta) = -theta;\n", &["3:1 `external_forces = (f1, f2);`"]),
        (
            "external_forces = -dot(theta), 3;\n",
            &["3:30 several values stand in parentheses"],
        ),
        (
            "external_forces : -dot(theta);\n",
            &["3:17 expected `external_forces = …;`"],
        ),
        (
            "external_forces == -dot(theta);\n",
            &["3:17 expected `external_forces = …;`"],
        ),
        (
            "external_forces = -dot(theta)\n",
            &["3:29 expected `;` behind this"],
        ),
        (
            "external_forces = [-dot(theta)];\n",
            &["3:19 expected parentheses"],
        ),
    ] {
        says(&format!("{HEAD}{statement}{LAGRANGIAN}{RUN}"), expected);
    }
    says(
        &format!("{HEAD}lagrangian : theta;\n{RUN}"),
        &["3:12 expected `lagrangian = …;`, with `=`"],
    );
    says(
        &format!("{HEAD}Lagrangian = theta;\n{RUN}"),
        &["3:1 did you mean `lagrangian`?"],
    );
    says(
        &format!("{HEAD}{RUN}"),
        &["3:58 expected the statement `lagrangian = …;`"],
    );
    says("", &["1:1 the text declares nothing"]);
    says("// nothing\n", &["1:1 the text declares nothing"]);
    says("coordinates { x }; lagrangian = x;", &["1:1 in parentheses"]);
    says(
        "coordinates(x)\n/// Of rest\nlagrangian = x;",
        &["1:14 expected `;` behind this"],
    );
}

#[test]
fn blocks_are_read_part_by_part() {
    let rest = "\ncoordinates(theta);\nlagrangian = dot(theta).powi(2) / 2 + a / b * theta.cos();";
    for (parameters, expected) in [
        (
            "parameters { a = 1,0, b = 2 }",
            &["1:18 a decimal has a point: expected `1.0`"][..],
        ),
        (
            "parameters { a: 1.0, b = 2 }",
            &["1:15 expected `a = …`, with `=`"],
        ),
        ("parameters { a = 1.0; b = 2; }", &["1:21 expected `,` here"]),
        (
            "parameters {\na = 1.0\nb = 2 }",
            &["2:5 expected `,` behind this"],
        ),
        (
            "parameters {\na = 1.0\n/// B\nb = 2 }",
            &["2:5 expected `,` behind this"],
        ),
        ("parameters = { a = 1.0, b = 2 };", &["1:12 without `=`"]),
        ("parameters(a = 1.0, b = 2)", &["1:1 in braces"]),
        (
            "parameters { a = , b }",
            &["1:14 expected a value", "1:20 expected a value"],
        ),
        ("parameters { 3, a = 1, b = 2 }", &["1:14 expected a name"]),
        (
            "parameters { a = 1 N/m, b = 2 }",
            &["1:20 a product is written with `*`, and a number has no unit"],
        ),
        (
            "parameters { a = 1 2, b = 2 }",
            &["1:20 a product is written with `*`"],
        ),
        (
            "parameters { a = nan, b = 0 / 0 }",
            &["1:18 finite", "1:27 not a number"],
        ),
    ] {
        says(&format!("{parameters}{rest}"), expected);
    }
    for (run, expected) in [
        (
            "step = 0,01; until = 1,5;",
            &["4:14 expected `0.01`", "4:28 expected `1.5`"][..],
        ),
        ("step: 0.01; until: 1;", &["4:11 `step = …`", "4:24 `until = …`"]),
        ("step = 0.01, until = 1", &["4:18 expected `;` here"]),
        ("step = 0.01\nuntil = 1", &["4:14 expected `;` behind this"]),
        (
            "dt = 0.01; tend = 3;",
            &["4:7 expected `step = …`", "4:18 expected `until = …`"],
        ),
        (
            "start = [1.0], [0.0];",
            &["4:20 several values stand in parentheses"],
        ),
        ("start = ([1,0], [0]);", &["4:16 found 2; a decimal has a point"]),
        ("until = inf;", &["4:15 finite"]),
    ] {
        says(&format!("{HEAD}{LAGRANGIAN}run {{ {run} }}"), expected);
    }
}

#[test]
fn numbers_that_are_none() {
    let squares = format!("(2 * theta){}", ".powi(2)".repeat(25));
    for (of, message) in [
        ("1e200 * 1e200 * theta", "infinite"),
        ("1e200 * theta * 1e200", "infinite"),
        (&squares, "infinite"),
        ("theta / 0", "infinite"),
        ("1e308 * theta + 1e308 * theta", "infinite"),
        ("theta * (-1.0).sqrt()", "not a number"),
        ("theta * (0 / 0)", "not a number"),
        ("gravity * 1e308 * 10 * theta", "infinite"),
    ] {
        let text = format!("{HEAD}lagrangian = {of};\n{RUN}");
        let told = told(&text);
        assert!(
            told.len() == 1 && told[0].starts_with("3:") && told[0].contains(message),
            "{told:?}"
        );
        // the same hint in a declaration in Rust
        let rust =
            format!("#[dsocs {{ coordinates(theta); lagrangian = {of}; }}] struct S {{ gravity: f64 }}");
        let told = crate::analyze(rust.as_str()).unwrap_err();
        assert!(told[0].message.contains(message), "{told:?}");
    }
}

#[test]
fn of_very_many_mistakes_the_first_are_reported() {
    let told = told(&format!("{HEAD}{}", "x y;\n".repeat(50_000)));
    assert_eq!(told.len(), 101);
    assert!(
        told[0].starts_with("3:1: ") && told[100].contains("more mistakes"),
        "{told:?}"
    );
    // an invalid long name takes no time
    let long = "a".repeat(500_000);
    assert!(!self::told(&format!("{HEAD}{long} = 1; lagrangian = {long}b;")).is_empty());
}

#[test]
fn what_nothing_uses_is_warned_of() {
    let text = "const n = 3;
        parameters { length = 1.0, half = length / 2, wind = samples(\"wind.csv\"), pi = 3.0, _spare = 1.0, first = 0.1, masses: [2] = [1, 2] }
        coordinates(theta);
        lagrangian = dot(theta).powi(2) / 2 + half * theta.cos();
        run { start = ([first], [0]); }";
    let read = read("unused", text, &[]).unwrap();
    let warnings: Vec<String> = read.model.warnings().iter().map(ToString::to_string).collect();
    let expected = [
        "1:7: nothing uses this constant; `_n` says that it is meant so",
        "2:22: only the values of other parameters use `length`, and they are worked out once: a run that sets `length` changes nothing; what follows it is \
         written `let … = …;` in their place",
        "2:55: nothing uses this parameter; `_wind` says that it is meant so",
        "2:83: nothing uses this parameter; `_pi` says that it is meant so",
        "2:83: `pi` is also the number 3.14159…; here it means this parameter",
        "2:120: nothing uses this parameter; `_masses` says that it is meant so",
    ];
    assert_eq!(warnings, expected);
}
