//! Every kind of mistake: its place and its message.

mod arrays;
mod constraints;
mod hints;
mod repair;
mod several;
mod time;
mod vectors;

use crate::tests::{ITEM, analyzed};

/// The tokens and the message of each mistake.
pub(crate) fn mistakes_on(declaration: &str, item: &str) -> Vec<(String, String)> {
    let Err(mistakes) = analyzed(declaration, item) else {
        return Vec::new();
    };
    assert!(
        !mistakes.errors.is_empty(),
        "a wrong declaration without a message"
    );
    let tell = |error: &syn::Error| (error.span().source_text().unwrap_or_default(), error.to_string());
    mistakes.errors.iter().map(tell).collect()
}

/// Asserts that a declaration has one mistake, at `place`, whose message contains `message`.
#[track_caller]
pub(crate) fn one(declaration: &str, place: &str, message: &str) {
    one_on(declaration, ITEM, place, message);
}

#[track_caller]
pub(crate) fn one_on(declaration: &str, item: &str, place: &str, message: &str) {
    let found = mistakes_on(declaration, item);
    let right = found.len() == 1 && found[0].0 == place && found[0].1.contains(message);
    assert!(right, "expected `{message}` at `{place}`, found {found:#?}");
}

/// A mistake in an expression of the motion.
#[track_caller]
pub(crate) fn expression(expression: &str, place: &str, message: &str) {
    one(
        &format!("coordinates(x, y); let e = {expression}; lagrangian = e * e;"),
        place,
        message,
    );
}

/// A mistake in the map `phi_lagrangian`.
#[track_caller]
fn map(closure: &str, place: &str, message: &str) {
    one(
        &format!("coordinates(x, y); let e = dot(x); lagrangian = e * e; phi_lagrangian = {closure};"),
        place,
        message,
    );
}

/// A mistake in statements after the coordinates and the Lagrangian.
#[track_caller]
pub(crate) fn statement(statements: &str, place: &str, message: &str) {
    one(
        &format!("coordinates(x, y); lagrangian = dot(x) * dot(y); {statements}"),
        place,
        message,
    );
}

#[test]
fn statements() {
    statement("kinematics = 1;", "kinematics", "did you mean `kinematic`?");
    statement(
        "energy = 1;",
        "energy",
        "expected a statement: `let`, `coordinates`",
    );
    statement(
        "kinematic = ddot(x); forces = [(1, 0)];",
        "forces",
        "`forces` is called `constraint_forces`",
    );
    statement("lagrangian = 1;", "lagrangian", "a second time");
    statement("coordinates(z);", "coordinates", "a second time");
    statement("observe(x);", "observe", "expected `observe = …;`");
    statement("x.y = 1;", "x.y", "expected a statement");
    statement("dot(x);", "dot", "expected a statement");
    statement("let (a, b) = 1;", "(a, b)", "plain name");
    statement("let mut a = 1;", "mut a", "plain name");
    statement("let a: f64 = 1;", "f64", "no type");
    statement("let a;", "a", "expected a value");
    statement("let a = 1 else { 2 };", "else", "`let … else`");
    statement("let a = ;", ";", "expected an expression");
    statement("let a = 3 x;", "x", "expected `;`");
    statement("#[cfg(test)] let a = 1;", "#[cfg(test)]", "attributes");
    statement("kinematic = (dot(x), dot(y));", "(dot(x), dot(y))", "in brackets");
    statement("kinematic = [];", "[]", "at least one");
    statement(
        "variational = (dot(x), dot(y));",
        "(dot(x), dot(y))",
        "list of tuples",
    );
    statement("phi_lagrangian = (1, 2);", "(1, 2)", "|q0, q1| (q, v)");
    statement("phi_kinematic = 1;", "1", "|q0, q1, q2| (q, v, a)");
    statement("struct A;", "struct A;", "expected a statement");
    one(
        "lagrangian = 1; coordinates = (x, y);",
        "(x, y)",
        "expected `coordinates(x, y);`",
    );
    one("coordinates(); lagrangian = 1;", "coordinates", "at least one");
    one(
        "coordinates(x, 2); lagrangian = 1;",
        "2",
        "the name of a coordinate",
    );
}

#[test]
fn missing_statements() {
    one("lagrangian = dot(x);", "", "`coordinates(x, y);`");
    one("coordinates(x);", "", "`lagrangian = …;`");
    // a statement that could not be read is not missing
    one("coordinates(x); lagrangian = ;", ";", "expected an expression");
    one("coordinates(x y); lagrangian = dot(x);", "y", "expected");
}

#[test]
fn doc_comments_are_welcome() {
    assert_eq!(
        mistakes_on(
            "/// The place.\ncoordinates(x); /** L */ lagrangian = dot(x).powi(2);",
            ITEM
        ),
        []
    );
}

#[test]
fn other_attributes_are_refused() {
    one(
        "coordinates(#[serde(skip)] x); lagrangian = dot(x);",
        "#[serde(skip)]",
        "no meaning in a declaration",
    );
    one(
        "coordinates(x); #[inline] let a = x; lagrangian = a * dot(x);",
        "#[inline]",
        "no meaning in a declaration",
    );
    one(
        "coordinates(x, /// nothing\n); lagrangian = dot(x);",
        ")",
        "expected an expression",
    );
}

#[test]
fn the_last_semicolon_may_be_left_out() {
    assert_eq!(
        mistakes_on("coordinates(x);; lagrangian = dot(x).powi(2)", ITEM),
        []
    );
}

#[test]
fn names() {
    expression(
        "thta * dot(x)",
        "thta",
        "expected a coordinate, a field of the struct or an earlier `let`",
    );
    expression("mas * dot(x)", "mas", "did you mean `mass`?");
    expression("cruvature.at(x)", "cruvature", "did you mean `curvature`?");
    expression("self.mass * x", "self", "expected `mass`");
    expression("h * x", "h", "in the maps and in discrete expressions only");
    expression("dot * x", "dot", "`dot(…)`");
    expression(
        "{ let mass = x; mass }",
        "mass",
        "the name of a parameter already",
    );
    expression("{ let ddot = x; x }", "ddot", "expected another name");
    one(
        "coordinates(x); lagrangian = b * dot(x); let b = 2;",
        "b",
        "defined further down",
    );
    one(
        "coordinates(x, x); lagrangian = dot(x);",
        "x",
        "the name of a coordinate already",
    );
    one(
        "coordinates(x, h); lagrangian = dot(x);",
        "h",
        "`h` means the step",
    );
    one(
        "coordinates(x); let x = 1; lagrangian = dot(x);",
        "x",
        "the name of a coordinate already",
    );
    one(
        "let x = 1; coordinates(x); lagrangian = dot(x);",
        "x",
        "the name of a `let` already",
    );
    one(
        "coordinates(mass); lagrangian = dot(mass);",
        "mass",
        "the name of a coordinate already",
    );
    one_on(
        "coordinates(x); lagrangian = dot(x);",
        "struct A { dot: f64 }",
        "dot",
        "the time derivative",
    );
    map("|x, q1| (q1, q1)", "x", "the name of a coordinate already");
    map("|q0, q0| (q0, q0)", "q0", "the name of a node already");
}

#[test]
fn expressions() {
    expression("x + \"a\"", "\"a\"", "expected a number");
    expression("2u32 * x", "2u32", "without the suffix `u32`");
    expression("1f32 * x", "1f32", "without the suffix `f32`");
    expression("x ^ 2", "^", "`.powi(2)`");
    expression("x % 2", "%", "one of the operators");
    expression("x < y", "<", "in the condition of `if");
    expression("!x", "!x", "is `-`");
    expression("(x, y)", "(x, y)", "found a tuple");
    expression("x.atan2([x, y])", "[x, y]", "found a vector of 2 components");
    expression("2 * |a| x", "|a| x", "found a closure");
    expression("format!(\"x\")", "format!(\"x\")", "macro");
    expression("table.at(format!(\"x\"))", "format!(\"x\")", "macro");
    expression("match x { _ => y }", "match x { _ => y }", "if … { … } else");
    expression("x as f64", "x as f64", "without `as`");
    expression("masses[x]", "masses[x]", "`table.at(x)`");
    expression("x.y", "y", "`dot(x)`");
    expression("if x < y { 1 }", "if", "expected `else`");
    expression("if x == y { 1 } else { 2 }", "x == y", "`<`, `<=`, `>` or `>=`");
    expression(
        "if let a = x { 1 } else { 2 }",
        "let a = x",
        "expected a comparison",
    );
    expression("{ x; y }", "x;", "expected `let name = …;`");
    expression("{ let a = x; }", "{ let a = x; }", "ends with an expression");
    expression("{}", "{}", "ends with an expression");
    expression("big * x", "big", "of type `usize`");
    expression("flag * x", "flag", "of type `bool`");
    expression("curvature * x", "curvature", "`curvature.at(…)`");
}

#[test]
fn calls() {
    expression("x.powi(y)", "y", "integer literal");
    expression("x.powi(2147483647)", "2147483647", "at most 10000");
    let deep = format!("{}x{}", "(".repeat(300), ")".repeat(300));
    expression(&deep, &deep[100..501], "nested at most 100 deep");
    expression(&format!("{}x", "-".repeat(300)), "-", "nested at most 100 deep");
    expression("x.powi(2.0)", "2.0", "`powf`");
    expression("x.powi()", "powi", "expected 1 argument");
    expression("x.sin(2)", "sin", "expected no argument");
    expression("x.mul_add(2)", "mul_add", "expected 2 arguments");
    expression("f64::sqrt(x, y)", "sqrt", "expected no argument");
    expression("f64::sqr(x)", "sqr", "did you mean `sqrt`?");
    expression("sin(x)", "sin", "`f64::sin(…)`");
    expression("x.floor()", "floor", "no derivative");
    expression("x(y)", "x", "`x` is a coordinate");
    expression("(x)(y)", "(x)", "the name of a function");
    expression("interpolate(&table, x)", "&table", "`data.function(x)`");
    expression("x.cast::<f32>()", "::<f32>", "no type arguments");
    expression("dot(x, y)", "dot(x, y)", "one argument");
    expression("dot()", "dot()", "one argument");
}

#[test]
fn orders() {
    statement("let a = ddot(ddot(x));", "ddot(ddot(x))", "of order 4");
    statement("let a = dddot(dot(x));", "dddot(dot(x))", "of order 4");
    statement(
        "let a = dddot(x); let b = x + dot(y + a);",
        "dot(y + a)",
        "of order 4",
    );
    one(
        "coordinates(x); lagrangian = x * ddot(x);",
        "ddot(x)",
        "positions and velocities",
    );
    one(
        "coordinates(x); lagrangian = x * dot(2 * dot(x));",
        "dot(2 * dot(x))",
        "positions and velocities",
    );
    one(
        "coordinates(x); let acc = ddot(x); lagrangian = x + acc;",
        "acc",
        "positions and velocities",
    );
    one(
        "coordinates(x); lagrangian = { let a = ddot(x); a };",
        "ddot(x)",
        "positions and velocities",
    );
    let rest = "variational = [(1, 0)];";
    statement(
        &format!("{rest} kinematic = x * y;"),
        "x * y",
        "one of positions alone is written `holonomic = …;`",
    );
    statement(
        &format!("{rest} kinematic = mass;"),
        "mass",
        "does not depend on the motion",
    );
    statement(
        &format!("{rest} kinematic = ddot(x); branch = divide(y + ddot(x));"),
        "ddot(x)",
        "acceleration",
    );
    statement(
        &format!("{rest} kinematic = ddot(x); branch = divide(mass);"),
        "mass",
        "changes no root",
    );
}

#[test]
fn counts() {
    statement(
        "kinematic = ddot(x);",
        "kinematic",
        "expected `variational = […];`, `variational = chetaev;` or `constraint_forces = […];`",
    );
    statement(
        "kinematic = [ddot(x), ddot(y)]; variational = [(1, 0)];",
        "variational",
        "2 kinematic constraints and 1 variational field make 3 equations, for 2 coordinates",
    );
    statement(
        "variational = [(1, 0)];",
        "variational",
        "0 constraints and 1 variational field make 1 equation,",
    );
    statement(
        "kinematic = [ddot(x), ddot(y)]; constraint_forces = [(1, 0)];",
        "constraint_forces",
        "expected as many forces as kinematic constraints: found 1 force and 2 kinematic constraints",
    );
    statement(
        "kinematic = ddot(x); variational = [(1, 0, 0)];",
        "(1, 0, 0)",
        "`x`, `y`: 2 components, found 3",
    );
    statement(
        "kinematic = ddot(x); variational = [dot(x)];",
        "dot(x)",
        "found 1",
    );
    statement(
        "kinematic = ddot(x); variational = [(1, 0)]; constraint_forces = [(1, 0)];",
        "constraint_forces",
        "either",
    );
    statement(
        "kinematic = ddot(x); variational = [(1, 0)]; variational = [(1, 0)];",
        "variational",
        "a second time",
    );
    // the number of rows is unknown if they could not be read
    statement(
        "kinematic = ; variational = [(1, 0)];",
        ";",
        "expected an expression",
    );
    statement("kinematic = ddot(x); variational = 3;", "3", "list of tuples");
}

#[test]
fn forces() {
    let three = "coordinates(x, y, z); lagrangian = dot(x) * dot(y) * dot(z);";
    one(
        &format!("{three} kinematic = [ddot(x), ddot(y)]; constraint_forces = [(1, 2, 0), (2, 4, 0)];"),
        "(2, 4, 0)",
        "independent",
    );
    one(
        &format!(
            "{three} kinematic = [ddot(x), ddot(y)]; constraint_forces = [(0.1, 0.2, 0), (0.3, 0.6, 0)];"
        ),
        "(0.1, 0.2, 0)",
        "independent",
    );
    statement(
        "kinematic = ddot(x); constraint_forces = [(0, 0)];",
        "(0, 0)",
        "independent",
    );
    statement(
        "kinematic = ddot(x); variational = [(0, 0)];",
        "(0, 0)",
        "independent",
    );
}

#[test]
fn branches() {
    let rest = "kinematic = ddot(x); variational = [(1, 0)];";
    statement("branch = divide(x);", "branch", "expected `kinematic = …;`");
    statement(
        &format!("{rest} branch = [divide(x), _];"),
        "branch",
        "each of the 1 kinematic constraint",
    );
    statement(
        &format!("{rest} branch = divde(x);"),
        "divde",
        "did you mean `divide`?",
    );
    statement(
        &format!("{rest} branch = divide(x, y);"),
        "divide(x, y)",
        "one factor",
    );
    statement(&format!("{rest} branch = x;"), "x", "expected `divide(factor)`");
}

#[test]
fn observed_names() {
    statement(
        "let energy = x; observe = [enrgy];",
        "enrgy",
        "did you mean `energy`?",
    );
    statement("observe = [mass];", "mass", "is a parameter");
    statement("observe = [e]; let e = x;", "e", "further down");
    statement("let e = x; observe = [e, e];", "e", "observed already");
    statement("observe = [x + y];", "x + y", "give the expression a name");
    statement("observe = x;", "x", "in brackets");
}

#[test]
fn maps() {
    map("|q0| (q0, q0)", "q0", "expected 2 nodes");
    map("|| (1, 2)", "phi_lagrangian", "expected 2 nodes");
    map("|q0, q1, q2| (q0, q1)", "q0, q1, q2", "expected 2 nodes");
    map("|q0, (a, b)| (q0, q0)", "(a, b)", "plain name");
    map("|q0, q1| (q0, q1, q1)", "(q0, q1, q1)", "expected 2 vectors");
    map("|q0, q1| q0", "q0", "tuple of 2 vectors");
    map(
        "|q0, q1| (q0, (q1, q1, q1))",
        "(q1, q1, q1)",
        "expected 2 components",
    );
    map("|q0, q1| (q0, x)", "x", "such as `q0.x`");
    map("|q0, q1| (q0, e)", "e", "written out");
    map("|q0, q1| (q0, dot(q1))", "dot", "difference quotient");
    map("|q0, q1| (q0, q1.z)", "z", "no coordinate is called `z`");
    map("|q0, q1| (q0, q1.2)", "2", "from 0 to 1");
    map("|q0, q1| (q0, (q0 + q1).x)", "x", "this is no node");
    map("|q0, q1| (q0, qq1)", "qq1", "did you mean `q1`?");
    map(
        "|q0, q1| ({ let a = zz; a }, q1)",
        "zz",
        "a node, a field of the struct or `h`",
    );
    map("|q0, q1| -> f64 { (q0, q1) }", "f64", "no type");
}

#[test]
fn items() {
    let right = "coordinates(x); lagrangian = dot(x).powi(2);";
    one_on(right, "enum A { B }", "enum", "expected a struct");
    one_on(right, "fn f() {}", "fn", "expected a struct");
    one_on(right, "pub struct A(f64);", "A", "named fields");
    assert_eq!(mistakes_on(right, "struct A;"), []);
}

#[test]
fn the_path_of_the_core() {
    let declaration = "coordinates(x); lagrangian = dot(x) * dot(x);";
    one(
        &format!("crate = 5; {declaration}"),
        "5",
        "expected the path of dsocs-core",
    );
    one(
        &format!("crate = a; crate = b; {declaration}"),
        "crate",
        "a second time",
    );
}
