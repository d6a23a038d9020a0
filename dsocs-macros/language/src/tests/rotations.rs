//! Rotations as coordinates: their operations, and the messages where they have no meaning.

use crate::graph::{Graph, Leaf, NodeId};
use crate::{Text, read};

/// The text of a system with a rotation `r`, an array `x: [3]` and a number `s`.
fn text(statements: &str) -> Result<Text, Vec<crate::Mistake>> {
    read(
        "body",
        &format!(
            "parameters {{ inertia = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.0], [0.0, 0.0, 1.0]] }} coordinates(r: rotation, x: [3], s); \
             let w = r.angular_velocity(); \
             lagrangian = w.inner(inertia * w) / 2 + dot(x).norm_squared() / 2 + dot(s).powi(2) / 2; {statements}"
        ),
        &[],
    )
}

/// The numeric values of a `let`, at a position with a unit quaternion.
fn observed(value: &str) -> Vec<f64> {
    let text = text(&format!("let value = {value}; observe = [value];"))
        .unwrap_or_else(|mistakes| panic!("{value}\n{mistakes:?}"));
    let nodes: Vec<NodeId> = text.model.observe.iter().map(|(_, node)| *node).collect();
    values(&text.model.graph, &nodes)
}

/// The numeric values of nodes at a state of the motion.
fn values(graph: &Graph, nodes: &[NodeId]) -> Vec<f64> {
    const Q: [f64; 8] = [0.5, -0.1, 0.7, 0.5, 0.3, -0.2, 0.9, 0.4];
    const V: [f64; 8] = [0.0, 0.6, -0.3, 1.1, 0.2, 0.5, -0.7, 0.1];
    const A: [f64; 8] = [0.0, -0.4, 0.8, 0.2, 0.1, 0.3, 0.6, -0.5];
    let leaf = |leaf: Leaf| match leaf {
        Leaf::Q(i) => Q[i],
        Leaf::V(i) => V[i],
        Leaf::A(i) => A[i],
        _ => f64::NAN,
    };
    graph.values(nodes, &leaf, &|_| f64::NAN).unwrap()
}

#[track_caller]
fn near(one: &str, other: &str) {
    let (left, right) = (observed(one), observed(other));
    assert_eq!(left.len(), right.len(), "{one}\n{other}");
    for (left_value, right_value) in left.iter().zip(&right) {
        assert!(
            (left_value - right_value).abs() < 1e-14,
            "{one}: {left:?}\n{other}: {right:?}"
        );
    }
}

#[test]
fn a_rotation_turns_vectors() {
    near("(r * x).norm_squared()", "x.norm_squared()");
    near("(r * x).inner(r * w)", "x.inner(w)");
    near("(r * x).cross(r * w)", "r * x.cross(w)");
    near("r.inverse() * (r * x)", "x");
    near("r * r.inverse() * x", "x");
    near("r * (r * x)", "(r * r) * x");
    near("r.matrix() * x", "r * x");
    // the sign binds tighter than the product
    near("-r * x", "-(r * x)");
    near("(-r) * x", "-(r * x)");
    near("-r.inverse() * x", "-(r.inverse() * x)");
    near("-w.inner(x) * x + -r * x", "-(w.inner(x) * x) - r * x");
    near("r.matrix().transpose() * x", "r.inverse() * x");
    // the first entry of the matrix, 2 (w² + x²) - 1
    near("(r * [1, 0, 0])[0]", "2 * (0.25 + 0.01) - 1");
}

#[test]
fn derivatives_along_the_motion_are_those_of_a_body_that_turns() {
    near("dot(r * x)", "r * (w.cross(x) + dot(x))");
    near(
        "dot(r.inverse() * x)",
        "(r.inverse() * x).cross(w) + r.inverse() * dot(x)",
    );
    near(
        "ddot(r * [1, 2, 3])",
        "r * (w.cross(w.cross([1, 2, 3])) + dot(w).cross([1, 2, 3]))",
    );
    near("(r * r).angular_velocity()", "r.inverse() * w + w");
    near("r.inverse().angular_velocity()", "-(r * w)");
}

#[test]
fn a_rotation_is_four_places_and_three_unknowns() {
    let text = text("external_forces = (r.inverse() * x, -x, 0);").unwrap();
    assert_eq!(
        text.model.coordinates(),
        ["r_w", "r_x", "r_y", "r_z", "x_0", "x_1", "x_2", "s"]
    );
    let data = text.model.data();
    assert_eq!((data.rotations, data.motion), (vec![0], 8));
    // the particles at rest and the other coordinates are solved for symbolically
    assert_eq!(data.unknowns, 3);
}

#[test]
fn a_compiled_system_knows_where_its_rotations_are() {
    let code = |coordinates: &str| {
        let model = crate::analyze(format!(
            "#[dsocs {{ coordinates({coordinates}); lagrangian = r.angular_velocity().norm_squared() + dot(s).powi(2); }}] struct Body;"
        ).as_str());
        model
            .unwrap_or_else(|mistakes| panic!("{mistakes:?}"))
            .code()
            .to_string()
            .replace(' ', "")
    };
    assert!(code("s, r: rotation").contains("constROTATIONS:&'static[usize]=&[1];"));
}

#[test]
fn a_start_has_three_numbers_of_velocity() {
    let runs = text("run { start = ([1, 0, 0, 0, 1, 2, 3, 4], [0.1, 0.2, 0.3, 5, 6, 7, 8]); }")
        .unwrap()
        .runs;
    let [_, v0] = runs[0].start.clone().unwrap();
    assert_eq!(v0, [0.0, 0.1, 0.2, 0.3, 5.0, 6.0, 7.0, 8.0]);
}

#[test]
fn a_start_of_another_length_is_refused_with_how_many_numbers_a_rotation_has() {
    for (run, message) in [
        (
            "([1, 0, 0, 0, 1, 2, 3, 4], [1, 2, 3, 5, 6])",
            "three for a rotation, in the frame of its body: 7, found 5",
        ),
        (
            "([1, 0, 0, 1, 2, 3, 4], [1, 2, 3, 5, 6, 7, 8])",
            "four for a rotation, `w, x, y, z`: 8, found 7",
        ),
    ] {
        let mistakes = text(&format!("run {{ start = {run}; }}")).map(drop).unwrap_err();
        assert!(mistakes[0].message.contains(message), "{mistakes:?}");
    }
}

#[test]
fn a_single_zero_stands_for_a_vector() {
    assert!(text("external_forces = (0, 0, 0);").is_ok());
    assert!(text("external_forces = (w, 0, s);").is_ok());
    let mistakes = text("external_forces = (w, 1, s);").map(drop).unwrap_err();
    assert!(
        mistakes[0].message.contains("the 3 components of `x`"),
        "{mistakes:?}"
    );
}

#[test]
fn equations_are_counted_by_three_for_a_rotation() {
    assert!(text("kinematic = dot(w); variational = [(0, [1, 0, 0], 0), (0, [0, 1, 0], 0), (0, [0, 0, 1], 0), (0, [0; 3], 1)];").is_ok());
    let mistakes = text("kinematic = dot(w); variational = [(w, 0 * x, 1)];").unwrap_err();
    assert!(
        mistakes[0]
            .message
            .contains("3 kinematic constraints and 1 variational field make 4 equations, for 7 coordinates"),
        "{mistakes:?}"
    );
}

/// Statements that are refused, each with a part of the message.
#[track_caller]
fn refused(all: &[(&str, &str)]) {
    for (statements, message) in all {
        let mistakes = text(statements).map(drop).expect_err(statements);
        assert!(
            mistakes.iter().any(|mistake| mistake.message.contains(message)),
            "{statements}\n{mistakes:?}"
        );
    }
}

#[test]
fn what_is_no_operation_of_rotations_is_refused_at_its_place() {
    refused(&[
        ("let e = r + r; observe = [e];", "found a rotation and a rotation"),
        (
            "let e = 2 * r; observe = [e];",
            "the rotation on the left of what it turns",
        ),
        (
            "let e = x * r; observe = [e];",
            "the rotation on the left of what it turns",
        ),
        ("let e = r * 2; observe = [e];", "a rotation turns a vector"),
        ("let e = r * [1, 2]; observe = [e];", "vectors of 3 components"),
        ("let e = r / 2; observe = [e];", "its inverse is `r.inverse()`"),
        ("let e = -r; observe = [e];", "a vector that it turns, `-(r * c)`"),
        ("let e = -r * r; observe = [e];", "a rotation has no sign"),
        ("let e = -r * 2; observe = [e];", "a rotation has no sign"),
        (
            "let e = r - r; observe = [e];",
            "expected `r.inverse() * s`, the turn from `r` to `s`",
        ),
        (
            "let e = r.w; observe = [e];",
            "the components of a rotation have no names",
        ),
        (
            "let e = r.angular_velocity; observe = [e];",
            "expected parentheses, `.angular_velocity()`",
        ),
        ("let e = r.angle; observe = [e];", "a rotation has no `angle`"),
        (
            "let e = r.omega(); observe = [e];",
            "a rotation has no `omega`; expected `r * c`, a vector turned, `r.inverse()`, `r.angular_velocity()` or `r.matrix()`",
        ),
        (
            "let e = r.angle(); observe = [e];",
            "`r.matrix()`, from whose elements angles follow",
        ),
        (
            "let e = v_r_y; observe = [e];",
            "expected `r.angular_velocity()[1]`",
        ),
        (
            "let e = dot(r); observe = [e];",
            "expected `r.angular_velocity()`",
        ),
        ("let e = r.sin(); observe = [e];", "a rotation has no `sin`"),
        (
            "let e = r[0]; observe = [e];",
            "the components of a rotation have no names",
        ),
        (
            "let e = (r * r)[0]; observe = [e];",
            "the components of a rotation have no names",
        ),
        (
            "let s2 = r * r; let e = s2[0]; observe = [e];",
            "the components of a rotation have no names",
        ),
        (
            "let e = r_w; observe = [e];",
            "no name `r_w` is known here: the components of a rotation have no names",
        ),
        ("let e = r.norm(); observe = [e];", "a rotation has no `norm`"),
        (
            "let e = x.angular_velocity(); observe = [e];",
            "expected a rotation before",
        ),
        ("let e = r * r; observe = [e];", "observed as it is"),
        (
            "let e = s.atan2(r); observe = [e];",
            "expected a number, found a rotation",
        ),
    ]);
}

#[test]
fn statements_that_rotations_do_not_know_are_refused() {
    refused(&[
        (
            "holonomic = w[0] - s;",
            "with velocities it is written `nonholonomic = …;`",
        ),
        (
            "holonomic = r;",
            "a number or a vector that is zero, found a rotation",
        ),
        (
            "external_forces = (1, x, 0);",
            "a vector in the frame of its body",
        ),
        (
            "external_forces = (0, 0, 0, 0, 0, 0, 0, 0);",
            "an entry for each of `r: rotation`, `x: [3]`, `s`: 3 entries, `([a, b, c], [a, b, c], a)`, found 8",
        ),
        (
            "phi_lagrangian = |q0, q1| (q0, (q1 - q0) / h);",
            "a formula of positions is no rotation",
        ),
        (
            "phi_kinematic = midpoint;",
            "a mean of three positions is no rotation",
        ),
        (
            "kinematic = dddot(s); variational = chetaev;",
            "of second order at most, so far",
        ),
        (
            "discrete_lagrangian = leg(s, 0);",
            "no discrete Lagrangian, so far",
        ),
    ]);
}

#[test]
fn what_looks_like_a_rotation_is_reported_at_its_place() {
    for (coordinates, at, message) in [
        ("r: Rotation", "Rotation", "expected `r: rotation`"),
        ("r: Quaternion", "Quaternion", "expected `r: rotation`"),
        ("x, r: [rotation; 2]", "[rotation; 2]", "rotations have no arrays"),
        ("x, r: [rotation]", "[rotation]", "rotations have no arrays"),
        ("x: f64", "f64", "expected the number of coordinates in brackets"),
    ] {
        let text = format!("coordinates({coordinates}); lagrangian = 0;");
        let mistakes = read("body", &text, &[]).map(drop).unwrap_err();
        let mistake = &mistakes[0];
        assert!(mistake.message.contains(message), "{coordinates}: {mistakes:?}");
        assert_eq!(
            &text[mistake.column - 1..mistake.end_column - 1],
            at,
            "{coordinates}"
        );
    }
}

#[test]
fn columns_of_one_name_are_refused() {
    for (declaration, at, message) in [
        (
            "coordinates(x, v_x); lagrangian = dot(x).powi(2) + dot(v_x).powi(2);",
            "v_x",
            "the velocity of `x`",
        ),
        (
            "coordinates(force_x, x); lagrangian = dot(x).powi(2) + dot(force_x).powi(2);",
            "force_x",
            "the force of `x`",
        ),
        (
            "coordinates(w, v: rotation); lagrangian = dot(w).powi(2) + v.angular_velocity().norm_squared();",
            "v",
            "`v_w` is the column of the velocity of `w`",
        ),
        (
            "coordinates(r: rotation, v_r_x); lagrangian = dot(v_r_x).powi(2) + r.angular_velocity().norm_squared();",
            "v_r_x",
            "the velocity of `r_x`",
        ),
        (
            "coordinates(energy); lagrangian = dot(energy).powi(2);",
            "energy",
            "the column of the energy",
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2); let energy = dot(x).powi(2); observe = [energy];",
            "energy",
            "the column of the energy",
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2); let v_x = dot(x); observe = [v_x];",
            "v_x",
            "the velocity of `x`",
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2); let lambda = [x, 2 * x]; observe = [lambda];",
            "lambda",
            "`lambda_0` is the column of a multiplier",
        ),
        (
            "coordinates(a_x, x); lagrangian = dot(x).powi(2) + dot(a_x).powi(2);",
            "a_x",
            "`a_x` is the column of the acceleration of `x`",
        ),
        (
            "coordinates(x); lagrangian = dot(x).powi(2); let a_x = ddot(x); observe = [a_x];",
            "a_x",
            "the acceleration of `x`",
        ),
    ] {
        let mistakes = read("body", declaration, &[]).map(drop).expect_err(declaration);
        let mistake = &mistakes[0];
        assert!(mistake.message.contains(message), "{declaration}: {mistakes:?}");
        assert_eq!(
            &declaration[mistake.column - 1..mistake.end_column - 1],
            at,
            "{declaration}"
        );
    }
    // a `let` that is not observed has no column
    assert!(
        read(
            "body",
            "coordinates(x); let energy = dot(x).powi(2); lagrangian = energy;",
            &[]
        )
        .is_ok()
    );
}

#[test]
fn what_is_reduced_has_its_position_in_no_equation() {
    let body = |more: &str| {
        read(
            "body",
            &format!(
                "parameters {{ mass = 1.3, depth = 0.2 }}
                 coordinates(r: rotation, x: [3], s);
                 let w = r.angular_velocity();
                 {more}"
            ),
            &[],
        )
    };
    let energy = "lagrangian = w.norm_squared() + mass * dot(x).norm_squared() / 2 + dot(s).powi(2);";
    // a reduced body may have velocity constraints and forces, and a difference of nodes is no position
    for statements in [
        "",
        "nonholonomic = w[2] - depth * dot(s);",
        "external_forces = (-w, 0.1 * dot(x), -dot(s) * t);",
        "kinematic = dot(w)[0] - ddot(s); constraint_forces = [([1, 0, 0], [0, 0, 0], 0)];",
    ] {
        let body = body(&format!("{energy} {statements} reduced(r, x, s);"));
        assert!(body.is_ok(), "{statements}");
    }
    for (statements, name, place) in [
        (
            "lagrangian = w.norm_squared() + dot(x).norm_squared() + dot(s).powi(2) - (r * [0, 0, 1])[2];",
            "r",
            "attitude is in the Lagrangian",
        ),
        (
            &*format!("{energy} holonomic = x - r * [1, 0, 0];"),
            "x",
            "position is in a holonomic constraint",
        ),
        (
            &*format!("{energy} nonholonomic = (r * w)[2] - s;"),
            "s",
            "position is in a nonholonomic constraint",
        ),
        (
            &*format!("{energy} nonholonomic = (r * w)[2] - s;"),
            "r",
            "attitude is in a nonholonomic constraint",
        ),
        (
            &*format!(
                "{energy} kinematic = ddot(s) - x[1]; constraint_forces = [([0, 0, 1], [0, 0, 0], 1)];"
            ),
            "x",
            "position is in a kinematic constraint",
        ),
        (
            &*format!(
                "{energy} kinematic = ddot(s) - w[1]; constraint_forces = [(r.inverse() * [0, 0, 1], [0, 0, 0], 1)];"
            ),
            "r",
            "attitude is in a constraint force",
        ),
        (
            &*format!("{energy} external_forces = (r.inverse() * [0, 0, 1], [0, 0, 0], 0);"),
            "r",
            "attitude is in an external force",
        ),
    ] {
        let mistakes = body(&format!("{statements} reduced({name});"))
            .err()
            .unwrap_or_default();
        let told: Vec<String> = mistakes.iter().map(|mistake| mistake.message.clone()).collect();
        assert_eq!(
            told,
            [format!("`{name}` is not reduced: its {place}")],
            "{statements}"
        );
    }
    let told = |statement: &str| {
        let mistakes = body(&format!("{energy} {statement}")).err().unwrap_or_default();
        mistakes
            .iter()
            .map(|mistake| mistake.message.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(
        told("reduced(q);"),
        ["no coordinate is called `q`; expected r, x, s"]
    );
    assert_eq!(
        told("reduced(w);"),
        ["no coordinate is called `w`; expected r, x, s"]
    );
    assert_eq!(told("reduced = r;"), ["expected `reduced(r);`, without `=`"]);
    assert_eq!(told("reduced(2 * s);"), ["expected the name of a coordinate"]);
    assert_eq!(
        told("reduced();"),
        ["expected the names of coordinates, `reduced(r);`"]
    );
}
