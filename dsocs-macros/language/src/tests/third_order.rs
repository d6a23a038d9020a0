//! Third derivatives: where they are allowed, and the messages for wrong ones.

use super::mistakes::{one, statement};
use super::model;
use crate::graph::Leaf;

#[test]
fn a_jerk_is_a_third_derivative_however_it_is_written() {
    let declared = |row: &str| {
        format!(
            "coordinates(x, y); lagrangian = dot(x).powi(2) + dot(y).powi(2); let speed = dot(x); let pull = ddot(x); \
             kinematic = {row}; constraint_forces = [(1, 0)];"
        )
    };
    for row in [
        "dddot(x) - 1",
        "dot(ddot(x)) - 1",
        "ddot(speed) - 1",
        "dot(pull) - 1",
    ] {
        let model = model(&declared(row));
        assert_eq!(model.order(), 3, "{row}");
        let row = model.constraints[0].value;
        assert!(model.graph.depends_on(row, Leaf::J(0)) && !model.graph.depends_on(row, Leaf::A(0)));
        assert_eq!(model.third_order().collect::<Vec<_>>(), [0]);
    }
    assert_eq!(model(&declared("ddot(x) - 1")).order(), 2);
    // a jerk that cancels does not count
    assert_eq!(model(&declared("dddot(x) - dot(ddot(x)) + ddot(x)")).order(), 2);
}

#[test]
fn jerks_stand_in_kinematic_constraints_alone() {
    let jerk = "a jerk, a third derivative, comes in here";
    one(
        "coordinates(x); lagrangian = dot(x) * dddot(x);",
        "dddot(x)",
        jerk,
    );
    one(
        "coordinates(x); let j = dddot(x); lagrangian = dot(x).powi(2); holonomic = x - j;",
        "j",
        "with accelerations `kinematic",
    );
    let declared =
        |rest: &str| format!("coordinates(x, y); lagrangian = dot(x).powi(2) + dot(y).powi(2); {rest}");
    one(
        &declared("nonholonomic = dot(x) - dddot(y);"),
        "dddot(y)",
        "with jerks it is written `kinematic",
    );
    one(&declared("external_forces = (dddot(x), 0);"), "dddot(x)", jerk);
    let third = "kinematic = dddot(x) - 1;";
    one(
        &declared(&format!("{third} variational = [(0, dddot(y))];")),
        "dddot(y)",
        "expected directions of time, positions, velocities and accelerations",
    );
    one(
        &declared(&format!("{third} constraint_forces = [(1, dddot(y))];")),
        "dddot(y)",
        jerk,
    );
    one(
        &declared(&format!(
            "let rate = dddot(y); {third} constraint_forces = [(1, 0)]; observe = [rate];"
        )),
        "rate",
        "expected what a node knows",
    );
}

#[test]
fn what_is_for_second_order_is_refused_beside_the_third() {
    let declared = |rest: &str| {
        format!(
            "coordinates(x, y); lagrangian = dot(x).powi(2) + dot(y).powi(2); kinematic = dddot(x) - dot(y); \
             constraint_forces = [(1, 0)]; {rest}"
        )
    };
    one(
        &declared("discrete_kinematic = x[2] - x[1];"),
        "discrete_kinematic",
        "imposed on four nodes",
    );
    one(
        &declared("phi_kinematic = midpoint;"),
        "phi_kinematic",
        "`phi_variational` is where",
    );
    one(
        &declared("branch = divide(dot(y));"),
        "dot(y)",
        "factors are divided out of those of second order",
    );
}

#[test]
fn higher_derivatives_are_reported() {
    statement("let a = ddddot(x);", "ddddot", "at most a third derivative");
    statement(
        "let a = ddot(ddot(x));",
        "ddot(ddot(x))",
        "at most order 3, a jerk, in a kinematic constraint",
    );
    statement("let dddot = x;", "dddot", "the third time derivative");
    statement("let a = dddot;", "dddot", "expected an argument");
    statement("let a = x.dddot();", "dddot", "`dddot(x)`");
    statement("let a = xdddot;", "xdddot", "did you mean `dddot(x)`?");
}
