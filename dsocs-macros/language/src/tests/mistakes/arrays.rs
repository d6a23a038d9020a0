//! Error messages for wrong arrays, sums and functions.

use crate::tests::mistakes::{one, one_on};

/// A mistake in an expression of `x` and `theta: [8]`.
#[track_caller]
fn expression(expression: &str, place: &str, message: &str) {
    one(
        &format!(
            "coordinates(x, theta: [8]); let f = |i| theta[i]; let e = {expression}; lagrangian = e * e;"
        ),
        place,
        message,
    );
}

#[track_caller]
fn coordinates(coordinates: &str, place: &str, message: &str) {
    one(
        &format!("coordinates({coordinates}); lagrangian = 1;"),
        place,
        message,
    );
}

#[test]
fn arrays() {
    coordinates("theta[8]", "theta[8]", "as `theta: [8]`");
    coordinates("theta: 8", "8", "in brackets");
    coordinates("theta: [f64; 8]", "[f64; 8]", "alone, `[8]`");
    coordinates("theta: [N]", "N", "a literal number");
    coordinates("theta: [0]", "0", "at least one");
    coordinates("theta: [2.5]", "2.5", "in brackets");
    coordinates("theta: [1000000000]", "1000000000", "at most 1000");
    coordinates("a: [600], b: [600]", "coordinates", "at most 1000");
    coordinates("theta: [3], theta_1", "theta_1", "a coordinate already");
    coordinates(
        "theta_1, theta: [3]",
        "theta",
        "`theta_1` is the name of a coordinate already",
    );
    coordinates("theta: [3], theta", "theta", "an array of coordinates already");
    one(
        "coordinates(theta: [2]); let theta_1 = 2; lagrangian = 1;",
        "theta_1",
        "a coordinate already",
    );
    one("coordinates(sum); lagrangian = 1;", "sum", "a sum over a range");
}

#[test]
fn indices() {
    expression(
        "theta[8]",
        "8",
        "this index is 8, but `theta` has the length 8; expected an index from 0 to 7",
    );
    expression("theta[2 - 3]", "2 - 3", "this index is -1");
    expression("sum(0..8, |i| theta[i + 1])", "i + 1", "this index is 8");
    expression(
        "theta[x]",
        "x",
        "expected an integer that the declaration itself tells",
    );
    expression("theta[big]", "big", "expected an integer");
    expression("theta[1.0]", "1.0", "expected an integer");
    expression("theta[1 / 0]", "1 / 0", "expected an integer");
    expression(
        "x.powf(theta)",
        "theta",
        "found a vector of 8 components; expected one of them, `theta[0]` to `theta[7]`",
    );
    expression("theta * x + 1", "+", "a vector of 8 components and a number");
    expression(
        "theta.sin()",
        "sin",
        "expected a number before `.sin(…)`, found a vector",
    );
    expression("x[0]", "x", "`x` is a coordinate: it stands without an index");
    expression("f[0]", "f", "expected parentheses, `f(…)`");
    expression("{ let a = x; a[0] }", "a", "`a` is a `let`");
    expression(
        "masses[3] * x",
        "3",
        "`masses` has the length 3; expected an index from 0 to 2",
    );
    expression("sum(0..8, |i| masses[i] * x)", "i", "this index is 3");
    expression("masses[x]", "masses[x]", "`table.at(x)`");
    expression("x + masses", "+", "a number and a vector of 3 components");
}

#[test]
fn sums() {
    expression("sum(x, |i| x)", "x", "a range with both ends");
    expression("sum(..8, |i| x)", "..8", "a range with both ends");
    expression("sum(0..x, |i| x)", "x", "expected an integer");
    expression("sum(0..8)", "sum(0..8)", "a range and a closure");
    expression("sum(0..8, theta)", "sum(0..8, theta)", "a range and a closure");
    expression(
        "sum(0..8, |i, j| theta[i])",
        "sum(0..8, |i, j| theta[i])",
        "a range and a closure",
    );
    expression("sum(0..8, |i: usize| theta[i])", "usize", "no type");
    expression("sum(0..8, |(i, j)| x)", "(i, j)", "plain name");
    expression("sum(0..8, |x| x)", "x", "`x` is the name of a coordinate already");
    expression(
        "sum(0..8, |i| sum(0..8, |i| x))",
        "i",
        "`i` is the name of an index already",
    );
    expression("sum(0..8, |i| thta[i])", "thta", "did you mean `theta`?");
    expression("sum(0..8, |i| j * theta[i])", "j", "no name `j` is known");
    expression("sum(0..1000000, |i| x)", "|i| x", "more than 200000 terms");
    expression("sum * x", "sum", "expected a range and a closure");
    expression("0..8", "0..8", "which stands in `sum");
    one(
        "coordinates(x); lagrangian = sum(0..3, |i| i * ddot(x));",
        "ddot(x)",
        "positions and velocities",
    );
}

#[test]
fn functions() {
    expression("f", "f", "`f` is a function; expected its arguments");
    expression("f()", "f()", "expected 1 argument of `f`, found 0");
    expression("f(1, 2)", "f(1, 2)", "expected 1 argument of `f`, found 2");
    expression("f(x)", "i", "expected an integer");
    expression(
        "{ let g = |i| theta[i] + tht; g(1) + sum(0..3, |i| g(i)) }",
        "tht",
        "no name `tht`",
    );
    expression("{ let g = |f| f; g(1) }", "f", "the name of a function already");
    expression("{ let g = |a: f64| a; g(1) }", "f64", "no type");
    one(
        "coordinates(x); lagrangian = g(x); let g = |a| a;",
        "g",
        "further down",
    );
    one(
        "coordinates(x); let g = |a| g(a - 1); lagrangian = g(3);",
        "g",
        "further down, or here",
    );
    one(
        "coordinates(x); let g = |a| a * x; lagrangian = g(3); observe = [g];",
        "g",
        "is a function",
    );
}

#[test]
fn shapes() {
    let field = |field: &str, place: &str, message: &str| {
        one(
            &format!(
                "coordinates(x, theta: [3]); lagrangian = x; kinematic = [ddot(x), ddot(theta[1]), ddot(theta[2])]; \
                 variational = [{field}];"
            ),
            place,
            message,
        );
    };
    field(
        "(1, 2, 3)",
        "(1, 2, 3)",
        "`x`, `theta: [3]`: 4 components, found 3",
    );
    field("(1, [1, 2])", "[1, 2]", "the 3 components of `theta`: a vector");
    field("(1, [0; 4])", "[0; 4]", "found 4");
    field("(1, 2)", "2", "found a number");
    field("(1, |i| theta[i + 1])", "i + 1", "this index is 3");
    field("(1, [0, 0, thta[1]])", "thta", "did you mean `theta`?");
}

#[test]
fn maps() {
    let map = |closure: &str, place: &str, message: &str| {
        one(
            &format!(
                "coordinates(x, theta: [3]); let f = |i| theta[i]; lagrangian = x; phi_lagrangian = {closure};"
            ),
            place,
            message,
        );
    };
    map(
        "|q0, q1| (q0, q1.theta)",
        "theta",
        "`q1.theta[0]` to `q1.theta[2]`",
    );
    map("|q0, q1| (q0, q1.theta[3])", "3", "this index is 3");
    map("|q0, q1| (q0, q1[3])", "q1", "such as `q1.theta[0]`");
    map("|q0, q1| (q0, theta[1])", "theta[1]", "such as `q0.theta[1]`");
    map("|q0, q1| (q0, theta)", "theta", "such as `q0.theta`");
    map("|q0, q1| (q0, f(1))", "f", "`f` is a function of the declaration");
    map(
        "|q0, q1| (q0, (q1, [q1, q1]))",
        "[q1, q1]",
        "the 3 components of `theta`",
    );
    map("|q0, q1| (q0, [q1, q1])", "[q1, q1]", "found a list");
    map(
        "|q0, q1| (q0, (q1, q1, q1))",
        "(q1, q1, q1)",
        "expected 4 components",
    );
}

#[test]
fn fields_of_the_struct() {
    one_on(
        "coordinates(x: [2]); lagrangian = x[0] * x[1];",
        "struct A { x_1: f64 }",
        "x_1",
        "a coordinate already",
    );
}
