//! `each(…)` in lists equals its entries written out.

use super::code;
use super::mistakes::one;

/// A chain of four point masses in the plane with rods.
const CHAIN: &str = "coordinates(x: [4], y: [4]); lagrangian = sum(0..4, |i| (dot(x[i]).powi(2) + dot(y[i]).powi(2)) / 2 - y[i]);";

/// Asserts that two declarations generate the same code.
#[track_caller]
fn same(written: &str, short: &str) {
    let code = |rest: &str| code(&format!("{CHAIN} {rest}"));
    assert!(code(written) == code(short), "{written}\n{short}");
}

#[test]
fn rows_of_every_kind() {
    same(
        "holonomic = [x[0] - y[0], x[1] - y[1], x[2] - y[2]];",
        "holonomic = each(0..3, |i| x[i] - y[i]);",
    );
    same(
        "holonomic = [x[0], x[1] - y[1], x[2] - y[2], y[0] - masses[1]];",
        "holonomic = [x[0], each(1..=2, |i| x[i] - y[i]), y[0] - masses[1]];",
    );
    same(
        "nonholonomic = [dot(x[0]) - masses[0] * y[0], dot(x[1]) - masses[1] * y[1]];",
        "nonholonomic = each(0..2, |k| dot(x[k]) - masses[k] * y[k]);",
    );
    same(
        "kinematic = [ddot(x[0]) - y[1], ddot(x[1]) - y[2]]; \
         constraint_forces = [([1, 0, 0, 0], [0; 4]), ([0, 1, 0, 0], [0; 4])];",
        "kinematic = each(0..2, |i| ddot(x[i]) - y[i + 1]); \
         constraint_forces = each(0..2, |i| (|j| if i == j { 1 } else { 0 }, [0; 4]));",
    );
    same(
        "kinematic = [ddot(x[0]) * y[0], ddot(x[1]) * y[1], ddot(x[2]) + y[2]]; branch = [divide(y[0]), divide(y[1]), _]; \
         variational = chetaev;",
        "kinematic = [each(0..2, |i| ddot(x[i]) * y[i]), ddot(x[2]) + y[2]]; branch = [each(0..2, |i| divide(y[i])), _]; \
         variational = chetaev;",
    );
    same(
        "kinematic = [ddot(x[0]), ddot(x[1])]; variational = chetaev; \
         discrete_kinematic = [x[0][2] - 2 * x[0][1] + x[0][0], x[1][2] - 2 * x[1][1] + x[1][0]];",
        "kinematic = each(0..2, |i| ddot(x[i])); variational = chetaev; \
         discrete_kinematic = each(0..2, |i| x[i][2] - 2 * x[i][1] + x[i][0]);",
    );
}

#[test]
fn ranges_within_ranges() {
    same(
        "holonomic = [x[0] - y[1], x[0] - y[2], x[1] - y[2]];",
        "holonomic = each(0..2, |i| each(i + 1..3, |j| x[i] - y[j]));",
    );
}

#[track_caller]
fn mistake(rest: &str, place: &str, message: &str) {
    one(&format!("{CHAIN} {rest}"), place, message);
}

#[test]
fn what_is_wrong_is_reported_once() {
    mistake(
        "holonomic = each(0..3, |i| x[i] - z[i]);",
        "z",
        "no name `z` is known here",
    );
    mistake(
        "holonomic = each(0..3, |i| x[i + 2]);",
        "i + 2",
        "this index is 4",
    );
    mistake(
        "holonomic = each(0..3, |x| x);",
        "x",
        "already; expected another name",
    );
    mistake(
        "holonomic = each(0..n, |i| x[i]);",
        "n",
        "an integer of literals and outer indices",
    );
    mistake(
        "holonomic = each(0.., |i| x[i]);",
        "0..",
        "a range with both ends",
    );
    mistake("holonomic = each(3, |i| x[i]);", "3", "a range with both ends");
    mistake(
        "holonomic = each(0..3, x[0]);",
        "each(0..3, x[0])",
        "a range and a closure",
    );
    mistake("holonomic = each(0..0, |i| x[i]);", "0..0", "at least one index");
    mistake(
        "holonomic = each(0..100000, |i| x[i]);",
        "x[i]",
        "more than 10000 entries",
    );
    mistake(
        "holonomic = x[0] + each(0..3, |i| x[i]);",
        "each",
        "stands for entries of a list",
    );
    mistake(
        "let each = 1; holonomic = x[0] - each;",
        "each",
        "an entry of a list for every index",
    );
}
