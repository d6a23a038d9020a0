//! Rotations as coordinates: what is made of them, and what is said where they have no meaning.

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

/// The numbers of what is observed of a `let`, at a position whose quaternion has the norm one.
fn observed(value: &str) -> Vec<f64> {
    let text = text(&format!("let value = {value}; observe = [value];"))
        .unwrap_or_else(|mistakes| panic!("{value}\n{mistakes:?}"));
    let nodes: Vec<NodeId> = text.model.observe.iter().map(|(_, node)| *node).collect();
    values(&text.model.graph, &nodes)
}

/// Numbers at a place of the motion.
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
    near("r.matrix().transpose() * x", "r.inverse() * x");
    // a half turn about the second axis and a third
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
    // the particles at rest and the numbers are solved for beforehand
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

#[test]
fn what_is_no_operation_of_rotations_is_refused_at_its_place() {
    for (statements, message) in [
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
        ("let e = -r; observe = [e];", "a rotation has no sign"),
        (
            "let e = dot(r); observe = [e];",
            "expected `r.angular_velocity()`",
        ),
        (
            "let e = r.sin(); observe = [e];",
            "expected a number before `.sin(…)`, found a rotation",
        ),
        ("let e = r[0]; observe = [e];", "its components have no names"),
        ("let e = r_w; observe = [e];", "no name `r_w` is known here"),
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
            "`r: rotation`, `x: [3]`, `s`",
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
    ] {
        let mistakes = text(statements).map(drop).expect_err(statements);
        assert!(
            mistakes.iter().any(|mistake| mistake.message.contains(message)),
            "{statements}\n{mistakes:?}"
        );
    }
}
