//! Error messages for wrong constraints, discrete expressions and named maps.

use crate::model::Displacements;
use crate::tests::mistakes::{mistakes_on, one, statement};
use crate::tests::{ITEM, model};

fn mistakes(declaration: &str) -> Vec<(String, String)> {
    mistakes_on(declaration, ITEM)
}

#[test]
fn orders() {
    statement("holonomic = x * dot(y);", "dot(y)", "`nonholonomic = …;`");
    statement("holonomic = ddot(y) + x;", "ddot(y)", "`kinematic = …;`");
    statement(
        "let v = dot(x); holonomic = [x, v];",
        "v",
        "a constraint of positions",
    );
    statement("holonomic = mass;", "mass", "does not depend on the motion");
    statement("nonholonomic = ddot(x) + dot(y);", "ddot(x)", "`kinematic = …;`");
    statement("nonholonomic = x * y;", "x * y", "`holonomic = …;`");
    statement("nonholonomic = mass;", "mass", "does not depend on the motion");
}

/// Each of these would be a leapfrog scheme with a second solution that grows.
#[test]
fn kinematic_rows_without_an_acceleration() {
    const VELOCITIES: &str = "written `nonholonomic = …;`";
    const POSITIONS: &str = "written `holonomic = …;`";
    let rest = "variational = [(1, 0)];";
    let two = |row: &str, place: &str, message: &str| {
        statement(&format!("{rest} kinematic = {row};"), place, message);
    };
    two("dot(x) + x", "dot(x) + x", VELOCITIES);
    two("x * y - 1", "x * y - 1", POSITIONS);
    two("mass", "mass", "does not depend on the motion");
    // derivatives that cancel, in the normal form or only once it is multiplied out
    let idle = "ddot(x) - ddot(x) + dot(x)";
    two(idle, idle, VELOCITIES);
    let idle = "(ddot(x) + dot(y)).powi(2) - ddot(x).powi(2) - 2 * ddot(x) * dot(y)";
    two(idle, idle, "all of them drop out of this one");
    let idle = "((x + y).powi(2) - x * x - 2 * x * y - y * y) * ddot(x) + dot(x)";
    two(idle, idle, "all of them drop out of this one");
    let idle = "(ddot(x) + y) * (ddot(x) - y) - ddot(x).powi(2)";
    two(idle, idle, POSITIONS);
    let idle = "if ddot(x) < 0 { dot(x) } else { dot(y) }";
    two(idle, idle, VELOCITIES);
    two(
        "0 * ddot(x) + curvature.at(x, dot(y))",
        "0 * ddot(x) + curvature.at(x, dot(y))",
        VELOCITIES,
    );
    statement(
        "let v = dot(x); let f = |a| a + y; variational = []; kinematic = [v, f(ddot(x))];",
        "v",
        VELOCITIES,
    );
    statement(
        "let f = |a| a + y; variational = []; kinematic = [ddot(y), f(dot(x))];",
        "f(dot(x))",
        VELOCITIES,
    );
    one(
        "coordinates(x: [2]); lagrangian = dot(x[0]); variational = []; kinematic = [ddot(x[0]), dot(x[1])];",
        "dot(x[1])",
        VELOCITIES,
    );
    // a function that the attribute does not know depends on its arguments
    let known =
        model("coordinates(x); lagrangian = dot(x); variational = []; kinematic = curvature.at(x, ddot(x));");
    assert_eq!(known.constraints[0].order, 2);
}

/// The statement that the message names accepts the row as it is.
#[test]
fn what_drops_out_is_left_out() {
    let row = "(ddot(x) + dot(y)).powi(2) - ddot(x).powi(2) - 2 * ddot(x) * dot(y)";
    let known = model(&format!(
        "coordinates(x, y); lagrangian = dot(x); nonholonomic = {row};"
    ));
    let row = &known.constraints[0];
    assert_eq!((row.order, known.graph.order(row.value)), (1, Some(1)));
    statement(
        "nonholonomic = (dot(x) + y).powi(2) - dot(x).powi(2) - 2 * dot(x) * y;",
        "(dot(x) + y).powi(2) - dot(x).powi(2) - 2 * dot(x) * y",
        "written `holonomic = …;`",
    );
}

/// A pendulum with a wheel, whose Lyapunov constraint has the factor `w` where the other equation holds.
fn pendulum(factor: &str) -> String {
    format!(
        "coordinates(theta, psi);
         lagrangian = 2 * dot(theta).powi(2) / 2 + 3 * (dot(theta) + dot(psi)).powi(2) / 2 - mass * (1 + theta.cos());
         let a = 1 / 2; let c = 1 / 2 + 1 / 3; let k = -3;
         let g_c = (k * a + a) * 6; let h_c = (-k * a - c) * 6; let f = (g_c.powi(2) + 4) / h_c;
         let p1 = 5 * dot(theta) + 3 * dot(psi); let p2 = 3 * (dot(theta) + dot(psi));
         let w = g_c * p1 + h_c * p2;
         let lyapunov = f / 2 * p1.powi(2) + h_c / 2 * p2.powi(2) + g_c * p1 * p2
             + 5 * (1 - (psi - k * theta).cos()) + 4 * mass * (1 - theta.cos());
         kinematic = dot(lyapunov) + w * w.tanh(); constraint_forces = [(0, 1)]; branch = divide({factor});"
    )
}

#[test]
fn a_branch_is_a_factor() {
    const NONE: &str = "expected a factor of the kinematic constraint";
    assert_eq!(mistakes_on(&pendulum("w"), ITEM), []);
    one(&pendulum("p1"), "p1", NONE);
    one(&pendulum("dot(theta)"), "dot(theta)", NONE);
    let rest = "variational = [(1, 0)];";
    let right = |row: &str, factor: &str| {
        let declaration = format!(
            "coordinates(x, y); lagrangian = dot(x).powi(2) + dot(y).powi(2); {rest} \
             kinematic = {row}; branch = divide({factor});"
        );
        assert_eq!(mistakes_on(&declaration, ITEM), [], "{declaration}");
    };
    right("(dot(x) - mass) * (ddot(y) + x)", "dot(x) - mass");
    right("dot(x).powi(2) * (ddot(y) + x)", "dot(x)");
    right("dot(x).sinh() * ddot(y) + 1 - dot(x).cos()", "dot(x)");
    right("ddot(y) * (1 - x.sin().powi(2)) + x.cos() * y", "x.cos()");
    // nothing shows that these are wrong
    right("ddot(y) + x", "1 + x.powi(2)");
    right("ddot(y) + x", "curvature.at(x)");
    let wrong = |row: &str, factor: &str| {
        statement(
            &format!("{rest} kinematic = {row}; branch = divide({factor});"),
            factor,
            NONE,
        );
    };
    wrong("ddot(y) + x", "dot(y)");
    wrong("(ddot(y) + x) * dot(x) + y", "dot(x)");
    wrong("(dot(x) - mass) * (ddot(y) + x)", "dot(x) + mass");
    statement(
        "variational = []; kinematic = [ddot(y) * x, dot(x) * (ddot(x) + y)]; branch = [divide(y), divide(dot(x))];",
        "y",
        NONE,
    );
}

#[test]
fn counts() {
    statement(
        "holonomic = [x, y]; nonholonomic = dot(x);",
        "nonholonomic",
        "no more constraints than coordinates: found 2 holonomic constraints, 1 nonholonomic constraint, for 2 coordinates",
    );
    statement(
        "holonomic = [x, y]; kinematic = ddot(x); variational = chetaev;",
        "variational",
        "no more constraints than coordinates",
    );
    statement(
        "holonomic = x; variational = [(0, 1), (1, 0)];",
        "variational",
        "1 holonomic constraint and 2 variational fields make 3 equations, for 2 coordinates",
    );
    statement(
        "holonomic = x; nonholonomic = dot(y); constraint_forces = [(0, 1)];",
        "constraint_forces",
        "as many forces as constraints: found 1 force and 1 holonomic constraint, 1 nonholonomic constraint",
    );
    statement("holonomic = [];", "[]", "at least one");
    statement(
        "nonholonomic = (dot(x), dot(y));",
        "(dot(x), dot(y))",
        "`nonholonomic = [c1, c2];`",
    );
    statement("holonomic = x; holonomic = y;", "holonomic", "a second time");
}

#[test]
fn rows_that_are_multiples_of_others_are_refused() {
    for (statements, place, message) in [
        (
            "nonholonomic = [dot(x) - y, 2 * (dot(x) - y)];",
            "2 * (dot(x) - y)",
            "a multiple of nonholonomic constraint 1",
        ),
        (
            "nonholonomic = [dot(x) - y, (dot(x) - y) * x.cos()];",
            "(dot(x) - y) * x.cos()",
            "a multiple of",
        ),
        (
            "holonomic = [x - y, mass * y - mass * x];",
            "mass * y - mass * x",
            "a multiple of holonomic constraint 1",
        ),
        (
            "holonomic = x * y; nonholonomic = y * dot(x) + x * dot(y);",
            "y * dot(x) + x * dot(y)",
            "of the time derivative of holonomic constraint 1",
        ),
        (
            "kinematic = [ddot(x) + x, dot(y) * (ddot(x) + x)]; constraint_forces = [(1, 0), (0, 1)];",
            "dot(y) * (ddot(x) + x)",
            "a multiple of kinematic constraint 1",
        ),
    ] {
        statement(statements, place, message);
    }
    for right in [
        "nonholonomic = [dot(x) - y, dot(x) - 2 * y];",
        "holonomic = [x - y, x + y];",
        "holonomic = x - y; nonholonomic = dot(x) - 2 * dot(y);",
        "kinematic = [ddot(x) + x, dot(y) * (ddot(x) + y)]; constraint_forces = [(1, 0), (0, 1)];",
    ] {
        let found = mistakes(&format!(
            "coordinates(x, y); lagrangian = dot(x) * dot(y); {right}"
        ));
        assert!(
            found.iter().all(|(_, message)| !message.contains("multiple")),
            "{right}: {found:?}"
        );
    }
}

/// Errors of factors: the power of external forces is named only if the constraint lacks it.
#[test]
fn wrong_factors() {
    let declared = |constraint: &str, factor: &str| {
        format!(
            "coordinates(x, y); let e = (dot(x).powi(2) + dot(y).powi(2) + x.powi(2) + (y - x).powi(2)) / 2; \
             lagrangian = dot(x).powi(2) + dot(y).powi(2) - e; external_forces = (-dot(x), 0); \
             kinematic = {constraint}; constraint_forces = [(0, 1)]; branch = divide({factor});"
        )
    };
    let [without, with] = [
        "dot(e) + dot(y).powi(2)",
        "dot(e) + dot(y).powi(2) + dot(x).powi(2)",
    ];
    assert!(mistakes(&declared(with, "dot(y)")).is_empty());
    for (constraint, factor, power) in [(without, "dot(y)", true), (with, "dot(x)", false)] {
        let found = mistakes(&declared(constraint, factor));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0]
                .1
                .contains("expected a factor of the kinematic constraint"),
            "{found:?}"
        );
        assert_eq!(found[0].1.contains("their power"), power, "{found:?}");
    }
}

#[test]
fn rules_of_displacements() {
    statement(
        "holonomic = x; variational = chetaev;",
        "variational",
        "there is no `kinematic = …;`",
    );
    statement(
        "kinematic = ddot(x); variational = chetaef;",
        "chetaef",
        "or `chetaev`",
    );
    statement(
        "kinematic = ddot(x); variational = chetaev; constraint_forces = [(1, 0)];",
        "constraint_forces",
        "`variational` stands above",
    );
    statement(
        "kinematic = ddot(x); constraint_forces = chetaev;",
        "chetaev",
        "a list of tuples",
    );
    one(
        "coordinates(x, y, z); lagrangian = dot(x); holonomic = [x, y, x + 2 * y];",
        "x + 2 * y",
        "expected independent constraints",
    );
    one(
        "coordinates(x, y, z); lagrangian = dot(x); holonomic = x; kinematic = ddot(y); constraint_forces = [(2, 0, 0)];",
        "(2, 0, 0)",
        "expected independent forces",
    );
    // no basis of the displacements exists everywhere
    let free = model("coordinates(x, y, z); lagrangian = dot(x); holonomic = x * y + z * z;");
    assert!(matches!(free.displacements, Displacements::Annihilated));
    assert_eq!(free.multipliers(), 1);
    let known = model("coordinates(x, y, z); lagrangian = dot(x); nonholonomic = dot(z) - y * dot(x);");
    assert_eq!(known.multipliers(), 0);
}

#[test]
fn discrete_expressions() {
    let lagrangian = |value: &str| format!("discrete_lagrangian = {value};");
    statement(&lagrangian("x * (y[1] - y[0])"), "x", "expected `x[0]` to `x[1]`");
    statement(&lagrangian("x[2] / h"), "2", "a node from 0 to 1");
    statement(&lagrangian("dot(x)"), "dot(x)", "`(x[1] - x[0]) / h`");
    statement(&lagrangian("node(x)"), "node(x)", "expected `leg(e, 0)`");
    statement(&lagrangian("leg(x, 1)"), "1", "there is no leg 1 here");
    statement(&lagrangian("leg(ddot(x), 0)"), "ddot(x)", "which a leg gives");
    statement(
        &lagrangian("leg(x, y, 0)"),
        "leg(x, y, 0)",
        "expected `leg(e, 0)`",
    );
    statement(
        "let v = dot(x); discrete_lagrangian = v * x[0];",
        "v",
        "`leg(v, 0)`",
    );
    let rest = "kinematic = ddot(x); constraint_forces = [(1, 0)];";
    let kinematic = |value: &str| format!("{rest} discrete_kinematic = {value};");
    statement(&kinematic("x[1] - x[0]"), "x[1] - x[0]", "the third node");
    statement(
        &kinematic("[x[2], y[2]]"),
        "discrete_kinematic",
        "as many discrete constraints as kinematic ones, 1, found 2",
    );
    statement(
        "discrete_kinematic = x[2];",
        "discrete_kinematic",
        "expected `kinematic = …;` beside it",
    );
    assert_eq!(
        mistakes_on(
            "coordinates(x, theta: [2]); lagrangian = dot(x); let v = dot(theta[1]); kinematic = dot(v); \
             constraint_forces = [(0, [0, 1])]; discrete_lagrangian = leg(v, 0) * (theta[1][1] - x[0]) / h; \
             discrete_kinematic = leg(v, 1) - leg(v, 0) + h * node(dot(v)) + theta[0][2];",
            ITEM
        ),
        []
    );
}

#[test]
fn named_maps() {
    statement(
        "phi_lagrangian = midpiont;",
        "midpiont",
        "did you mean `midpoint`?",
    );
    statement(
        "phi_kinematic = trapezoid;",
        "trapezoid",
        "`phi_lagrangian` alone",
    );
    for map in ["paper", "midpoint", "trapezoid"] {
        let model = model(&format!(
            "coordinates(x); lagrangian = x; phi_lagrangian = {map};"
        ));
        let points = if map == "trapezoid" { 2 } else { 1 };
        assert_eq!(model.phi_lagrangian.len(), points);
    }
}
