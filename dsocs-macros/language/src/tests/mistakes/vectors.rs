//! Error messages for wrong vectors and matrices.

use crate::read;
use crate::tests::mistakes::{one, one_on};

/// A mistake in an expression of `x: [3]`, `y: [2]` and `s`.
#[track_caller]
fn expression(expression: &str, place: &str, message: &str) {
    one(
        &format!(
            "coordinates(x: [3], y: [2], s); let m = [[1, s], [0, 2]]; let e = {expression}; lagrangian = s; observe = [e];"
        ),
        place,
        message,
    );
}

#[test]
fn sums() {
    expression("x + 1", "+", "a vector of 3 components and a number");
    expression("s - masses", "-", "a number and a vector of 3 components");
    expression(
        "x + y",
        "+",
        "a vector of 3 components and a vector of 2 components",
    );
    expression("m - y", "-", "a matrix of 2 by 2 and a vector of 2 components");
    expression(
        "sum(0..2, |i| if i == 0 { x } else { y })",
        "if i == 0 { x } else { y }",
        "the same for every index",
    );
    expression("if s < 0 { x } else { 0 }", "if", "the same in both cases");
}

#[test]
fn products() {
    expression(
        "x * x",
        "*",
        "expected `a.inner(b)`, a number, or `a.cross(b)`, a vector",
    );
    expression("s / x", "/", "expected a number behind `/`");
    expression("m * x", "*", "as many columns on the left");
    expression("y * m", "*", "`m.transpose() * v`");
    expression(
        "x.inner(y)",
        "inner",
        "two vectors of the same length, found a vector of 3 components and a vector of 2 components",
    );
    expression("y.cross(y)", "cross", "two vectors of 3 components");
    expression("x.inner()", "inner", "expected 1 argument");
    expression("x.norm(2)", "norm", "expected no argument");
    expression(
        "s.norm()",
        "norm",
        "expected a vector before `.norm(…)`, found a number",
    );
    expression("x.transpose()", "transpose", "expected a matrix");
    expression("product(0..2, |i| x)", "x", "expected a number, found a vector");
}

#[test]
fn other_words() {
    expression("x.dot(x)", "dot", "`a.inner(b)`");
    expression(
        "dot(x, x)",
        "dot(x, x)",
        "the inner product of two vectors is written `a.inner(b)`",
    );
    expression("x.abs()", "abs", "expected `.norm()`");
    expression("x.powi(2)", "powi", "expected `.norm_squared()`");
    expression("x.magnitude()", "magnitude", "expected `.norm()`");
    expression("x.nrm()", "nrm", "did you mean `norm`?");
    expression("x.sin()", "sin", "expected a number before `.sin(…)`");
}

#[test]
fn a_number_is_expected() {
    expression(
        "s.atan2(x)",
        "x",
        "expected a number, found a vector of 3 components",
    );
    expression(
        "s.sqrt() + (x + x)[3]",
        "3",
        "this index is 3, but this has the length 3",
    );
    expression("{ let v = 2 * x; v[4] }", "4", "`v` has the length 3");
    expression("m[0][2]", "2", "has the length 2");
    expression("(s + 1)[0]", "(s + 1)", "expected a vector before the index");
    expression("table.at(x)", "x", "expected a number, found a vector");
    expression(
        "[s, x]",
        "[s, x]",
        "vectors of the same length, the rows of a matrix",
    );
    expression("[]", "[]", "at least one component");
    one(
        "coordinates(x: [3]); lagrangian = 2 * dot(x);",
        "2 * dot(x)",
        "expected a number, found a vector of 3 components",
    );
    one(
        "coordinates(x: [3]); lagrangian = dot(x).norm_squared(); external_forces = x.norm();",
        "x.norm()",
        "expected the 3 components of `x`: a vector",
    );
    one(
        "coordinates(x: [3], s); lagrangian = dot(x).norm_squared() + dot(s).powi(2); external_forces = (-x, -x);",
        "-x",
        "expected a number, found a vector",
    );
}

#[test]
fn rows() {
    let rows = |rows: &str, place: &str, message: &str| {
        one(
            &format!("coordinates(x: [3], s); lagrangian = dot(x).norm_squared() + dot(s).powi(2); {rows}"),
            place,
            message,
        );
    };
    rows(
        "holonomic = [x, x.norm_squared() - s, s];",
        "holonomic",
        "found 5 holonomic constraints, for 4 coordinates",
    );
    rows(
        "nonholonomic = x - [1, 2, 3];",
        "x - [1, 2, 3]",
        "expected a velocity",
    );
    rows(
        "holonomic = [[1, 2], [3, 4]] * [[1, 0], [0, 1]];",
        "[[1, 2], [3, 4]] * [[1, 0], [0, 1]]",
        "a number or a vector that is zero",
    );
    rows(
        "kinematic = ddot(x); variational = chetaev; discrete_kinematic = node(ddot(x[0]));",
        "ddot(x)",
        "as many components as those of the discrete row in its place, 1, found 3",
    );
    rows(
        "kinematic = ddot(x); variational = [([1, 0, 0], 0), ([0, 1, 0], 0)];",
        "variational",
        "3 kinematic constraints",
    );
}

#[test]
fn names() {
    one(
        "coordinates(x: [2]); let p_1 = 2; let p = p_1 * dot(x); lagrangian = p.norm(); observe = [p];",
        "p",
        "`p_1` has a meaning already",
    );
    one_on(
        "coordinates(k_0_1); lagrangian = k_0_1;",
        "struct A { k: [[f64; 2]; 2] }",
        "k",
        "a coordinate already",
    );
}

#[test]
fn parameters_of_a_text() {
    for (parameters, message) in [
        ("k = [[1.0, 2.0], [3.0]]", "with as many numbers in each"),
        ("k = [[1.0, 2.0], 3.0]", "a row of the matrix in brackets"),
        ("k: [2] = [[1.0, 2.0], [3.0, 4.0]]", "without `: […]`"),
        ("k = [[0.0; 100]; 100]", "at most 1000 elements"),
        (
            "b = [1.0, 2.0], k = 2 * b",
            "expected a number, found a vector of 2 components",
        ),
    ] {
        let text = format!("parameters {{ {parameters} }} coordinates(x); lagrangian = dot(x).powi(2);");
        let mistakes = read("wrong", &text, &[]).unwrap_err();
        assert!(
            mistakes[0].message.contains(message),
            "{parameters}\n{mistakes:?}"
        );
    }
}
