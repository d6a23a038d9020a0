//! Likely mistakes with time and external forces: their places and the advice.

use crate::graph::Leaf;
use crate::tests::mistakes::{expression, mistakes_on, one_on, statement};
use crate::tests::{ITEM, model};

#[test]
fn forces_that_are_given_are_external_forces() {
    for (word, value) in [
        ("forces", "(-mass * dot(x), 0)"),
        ("forces", "[(-mass * dot(x), 0)]"),
        ("damping", "(-mass * dot(x), 0)"),
        ("friction", "-mass * dot(x)"),
        ("dissipation", "mass * dot(x).powi(2) / 2"),
        ("torque", "(1, 0)"),
    ] {
        statement(
            &format!("{word} = {value};"),
            word,
            "written `external_forces = (",
        );
    }
    statement(
        "external_force = (0, 1);",
        "external_force",
        "did you mean `external_forces`?",
    );
}

#[test]
fn external_forces_are_one_tuple_of_components() {
    let count = "a component for each of the coordinates `x`, `y`: 2 components, found";
    statement(
        "external_forces = (-dot(x),);",
        "(-dot(x),)",
        &format!("{count} 1"),
    );
    statement("external_forces = -dot(x);", "-dot(x)", &format!("{count} 1"));
    statement("external_forces = (1, 2, 3);", "(1, 2, 3)", &format!("{count} 3"));
    for list in ["[(-dot(x), 0)]", "[-dot(x), 0]", "[(1, 0), (0, 1)]"] {
        statement(
            &format!("external_forces = {list};"),
            list,
            "expected one tuple with a component for each coordinate, `external_forces = (f1, f2);`: forces that act together are added up",
        );
    }
    statement(
        "external_forces = (0, 1); external_forces = (1, 0);",
        "external_forces",
        "a second time",
    );
    // an array has its components in brackets
    let three = "coordinates(x: [3]); lagrangian = dot(x[0]) * dot(x[1]) * dot(x[2]);";
    let wrong = mistakes_on(&format!("{three} external_forces = [1, 2];"), ITEM);
    assert!(
        wrong.len() == 1 && wrong[0].1.contains("the 3 components of `x`"),
        "{wrong:?}"
    );
    for right in ["([1, 2, 3],)", "[1, 2, 3]", "[-dot(x[0]); 3]", "|i| -dot(x[i])"] {
        let model = model(&format!("{three} external_forces = {right};"));
        assert_eq!(model.external_forces.len(), 3, "{right}");
    }
}

#[test]
fn external_forces_know_no_accelerations() {
    let message =
        "an acceleration comes in here; expected forces of time, positions and velocities, f(t, q, v)";
    statement("external_forces = (-ddot(x), 0);", "ddot(x)", message);
    statement(
        "external_forces = (0, dot(dot(y) * x));",
        "dot(dot(y) * x)",
        message,
    );
    statement(
        "external_forces = (lambda, 0);",
        "lambda",
        "no name `lambda` is known here",
    );
}

#[test]
fn t_is_times_name() {
    let message = "`t` means time in a declaration; expected another name";
    for (declaration, item) in [
        (
            "coordinates(t); lagrangian = dot(mass);",
            "struct A { mass: f64 }",
        ),
        (
            "coordinates(x, t: [3]); lagrangian = dot(x).powi(2);",
            "struct A { mass: f64 }",
        ),
        (
            "coordinates(x); let t = x; lagrangian = dot(x).powi(2);",
            "struct A { mass: f64 }",
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2);",
            "struct A { t: f64 }",
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2);",
            "struct A { t: [f64; 3] }",
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2); phi_lagrangian = |t, x0| (t, x0);",
            "struct A { mass: f64 }",
        ),
    ] {
        one_on(declaration, item, "t", message);
    }
    expression("dot(x) * time", "time", "time is called `t`");
}

#[test]
fn time_is_no_function_and_nothing_is_a_function_of_it_but_functions() {
    let rate = "leave this out; expected the derivative of something that moves, `dot(x)`";
    expression("dot(x) * dot(t)", "dot(t)", rate);
    expression("dot(x) + ddot(t)", "ddot(t)", rate);
    expression("dot(x) - x(t)", "x", "a product is written with `*`");
    expression(
        "dot(x) - mass(t)",
        "mass",
        "`mass` is a number; a product is written with `*`",
    );
    expression("dot(x) - t(x)", "t", "`t` is time, and no function");
    expression("dot(x) - t()", "t", "`t` is time, and no function");
    expression(
        "dot(x) - t[0]",
        "t[0]",
        "times of nodes, `t[0]`, stand in discrete expressions alone",
    );
    // a function may be one of time
    model("coordinates(x); lagrangian = dot(x).powi(2) - curvature.at(t) * x - wind(t) * x - force(t);");
    // a derivative may be one by time alone
    model("coordinates(x); lagrangian = dot(x).powi(2) - dot((mass * t).sin()) * x;");
}

#[test]
fn maps_know_the_times_that_they_name() {
    let map = |closure: &str, place: &str, message: &str| {
        statement(&format!("phi_lagrangian = {closure};"), place, message);
    };
    map(
        "|q0, q1| (q0 + t * (q1 - q0), (q1 - q0) / h)",
        "t",
        "named with their times: `|t0, q0, t1, q1| (t, q, v)`",
    );
    map(
        "|t0, q0, t1, q1| (q0, (q1 - q0) / h)",
        "(q0, (q1 - q0) / h)",
        "expected the time and 2 vectors, `phi_lagrangian = |t0, q0, t1, q1| (t, q, v);`, found 2",
    );
    map(
        "|q0, q1| (t0, q0, (q1 - q0) / h)",
        "(t0, q0, (q1 - q0) / h)",
        "expected 2 vectors, `phi_lagrangian = |q0, q1| (q, v);`, found 3",
    );
    // in the wrong order the names mean other things
    let order = "the time stands before its node, `|t0, q0, t1, q1| (t, q, v)`";
    map("|q0, t0, q1, t1| (t0, q0, (q1 - q0) / h)", "t0", order);
    map("|t0, q0, t1, q1| (q0, q0, (q1 - q0) / h)", "q0", order);
    statement(
        "kinematic = ddot(x); constraint_forces = [(1, 0)]; \
         phi_kinematic = |t0, q0, t1, q1, t2, q2| (q1, q1, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2));",
        "q1",
        "the time stands before its node, `|t0, q0, t1, q1, t2, q2| (t, q, v, a)`",
    );
    // a map may stand in parentheses
    model(
        "coordinates(x, y); lagrangian = dot(x) * dot(y); phi_lagrangian = (|q0, q1| (q0, (q1 - q0) / h));",
    );
}

#[test]
fn discrete_statements_know_the_times_of_nodes() {
    let discrete = |value: &str, place: &str, message: &str| {
        statement(
            &format!("let d = t.sin(); discrete_lagrangian = (x[1] - x[0]) * (y[1] - y[0]) * {value};"),
            place,
            message,
        );
    };
    discrete("t", "t", "expected `t[0]` to `t[1]`");
    discrete(
        "t[2]",
        "2",
        "there is no node 2 here; expected a node from 0 to 1",
    );
    discrete("d", "d", "or its value on the leg, `leg(d, 0)`");
}

#[test]
fn constraints_are_constraints_of_the_motion_also_with_time() {
    statement("holonomic = t;", "t", "this does not depend on the motion");
    statement(
        "kinematic = dot(x) - t.sin(); constraint_forces = [(1, 0)];",
        "dot(x) - t.sin()",
        "is written `nonholonomic = …;`",
    );
}

/// A time that is not declared costs nothing: no expression of an autonomous system depends on it. A system
/// that depends on time is recognised.
#[test]
fn who_depends_on_time_is_known() {
    let start = "coordinates(x, y); lagrangian = dot(x) * dot(y) - x * y;";
    let leaves = [Leaf::T, Leaf::T0, Leaf::T1, Leaf::T2];
    for autonomous in [
        "",
        "external_forces = (-dot(x), mass);",
        "holonomic = x - y;",
        "nonholonomic = dot(x) - y;",
        "kinematic = ddot(x) + y; variational = [(0, 1)];",
        "phi_lagrangian = midpoint;",
    ] {
        assert!(
            !model(&format!("{start} {autonomous}")).depends_on_time(),
            "{autonomous}"
        );
    }
    for driven in [
        "external_forces = (-dot(x), t);",
        "holonomic = x - y * t;",
        "nonholonomic = dot(x) - t;",
        "kinematic = ddot(x) + y - t; variational = [(0, 1)];",
        "kinematic = ddot(x) + y; variational = [(t, 1)];",
        "discrete_lagrangian = (x[1] - x[0]) * (y[1] - y[0]) + x[0] * t[0];",
        "let e = t * x; observe = [e];",
    ] {
        let model = model(&format!("{start} {driven}"));
        assert!(model.depends_on_time(), "{driven}");
        assert!(leaves.iter().any(|leaf| model.graph.has_leaf(*leaf)), "{driven}");
    }
}
