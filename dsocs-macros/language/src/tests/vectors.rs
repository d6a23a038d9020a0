//! Vectors and matrices: each equals its components written out.

use super::{code, fields_of, model};
use crate::{Text, read};

/// Coordinates and parameters of vectors in space.
const SPACE: &str =
    "coordinates(x: [3], y: [3], s); let u = dot(x); let m = [[1, s, 0], [0, 2, 0], [x[0], 0, 3]];";

/// Asserts that two expressions are the same node.
#[track_caller]
fn same(left: &str, right: &str) {
    let model = model(&format!(
        "{SPACE} lagrangian = s; let left = {left}; let right = {right}; observe = [left, right];"
    ));
    let nodes: Vec<_> = model.observe.iter().map(|(_, node)| *node).collect();
    let (left_nodes, right_nodes) = nodes.split_at(nodes.len() / 2);
    assert_eq!(left_nodes, right_nodes, "{left}\n{right}");
}

/// Asserts that two declarations generate the same code.
#[track_caller]
fn same_code(written: &str, short: &str) {
    let of = |rest: &str| code(&format!("{SPACE} {rest}"));
    assert!(of(written) == of(short), "{written}\n{short}");
}

#[test]
fn sums_and_multiples() {
    same("x + y", "[x[0] + y[0], x[1] + y[1], x[2] + y[2]]");
    same(
        "-(x - masses)",
        "[masses[0] - x[0], masses[1] - x[1], masses[2] - x[2]]",
    );
    same("2 * x * s", "[2 * x[0] * s, 2 * x[1] * s, 2 * x[2] * s]");
    same("x / mass", "[x[0] / mass, x[1] / mass, x[2] / mass]");
    same("[s; 3] + [0, 1, 2]", "[s, s + 1, s + 2]");
    same("sum(0..3, |i| i * [x[i], s])", "[x[1] + 2 * x[2], 3 * s]");
}

#[test]
fn products_and_lengths() {
    same(
        "x.inner(masses)",
        "x[0] * masses[0] + x[1] * masses[1] + x[2] * masses[2]",
    );
    same("x.norm_squared()", "sum(0..3, |i| x[i].powi(2))");
    same("(x - y).norm()", "sum(0..3, |i| (x[i] - y[i]).powi(2)).sqrt()");
    same("[s, x[0]].norm()", "(s.powi(2) + x[0].powi(2)).sqrt()");
    same(
        "x.cross(y)",
        "[x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]",
    );
    same(
        "masses.norm()",
        "(masses[0].powi(2) + masses[1].powi(2) + masses[2].powi(2)).sqrt()",
    );
    same("x.cross(y).inner(x)", "x.inner(x.cross(y))");
}

#[test]
fn derivatives_of_vectors() {
    same("dot(x)", "[dot(x[0]), dot(x[1]), dot(x[2])]");
    same("ddot(x.cross(y))[1]", "ddot(x[2] * y[0] - x[0] * y[2])");
    same("dot(u)", "ddot(x)");
}

#[test]
fn components() {
    same("u[2]", "dot(x[2])");
    same("(x + y)[1]", "x[1] + y[1]");
    same("dot(x)[0] * [s, 2][1]", "2 * dot(x[0])");
    same("sum(0..3, |i| (2 * x)[i])", "2 * (x[0] + x[1] + x[2])");
    same("m[0][1]", "s");
    same("m[2]", "[x[0], 0, 3]");
}

#[test]
fn matrices() {
    same("m * y", "[y[0] + s * y[1], 2 * y[1], x[0] * y[0] + 3 * y[2]]");
    same(
        "m.transpose() * y",
        "[y[0] + x[0] * y[2], s * y[0] + 2 * y[1], 3 * y[2]]",
    );
    same(
        "m * m",
        "[m * m.transpose()[0], m * m.transpose()[1], m * m.transpose()[2]].transpose()",
    );
    same("2 * m - m", "m");
    same("dot(m)", "[[0, dot(s), 0], [0, 0, 0], [dot(x[0]), 0, 0]]");
    same("[[1, 2, s], x][1][0]", "x[0]");
}

#[test]
fn what_is_shared_may_be_of_vectors() {
    same(
        "{ let kinetic = |a, b| a.inner(b) / 2; kinetic(u, 3 * x) }",
        "3 * u.inner(x) / 2",
    );
    same(
        "{ let shifted = |a, i| a + i * [1, 0, s]; shifted(x, 2) }",
        "[x[0] + 2, x[1], x[2] + 2 * s]",
    );
    same(
        "if s < 0 { x } else { -x }",
        "[if s < 0 { x[0] } else { -x[0] }, if s < 0 { x[1] } else { -x[1] }, if s < 0 { x[2] } else { -x[2] }]",
    );
    same("sum(0..3, |i| if i == 1 { x } else { y })", "x + 2 * y");
}

#[test]
fn a_row_that_is_a_vector_is_several() {
    let lagrangian = "lagrangian = u.norm_squared() / 2 + dot(y).norm_squared() / 2 + dot(s).powi(2) / 2;";
    same_code(
        &format!("{lagrangian} holonomic = [x[0] - y[0], x[1] - y[1], x[2] - y[2], s - x[0]];"),
        &format!("{lagrangian} holonomic = [x - y, s - x[0]];"),
    );
    same_code(
        &format!(
            "{lagrangian} nonholonomic = [dot(x[0]) - s * y[0], dot(x[1]) - s * y[1], dot(x[2]) - s * y[2]];"
        ),
        &format!("{lagrangian} nonholonomic = u - s * y;"),
    );
    same_code(
        &format!(
            "{lagrangian} kinematic = [ddot(x[0]) * y[0], ddot(x[1]) * y[0], ddot(x[2]) * y[0], ddot(s)]; variational = chetaev; \
             branch = [divide(y[0]), divide(y[0]), divide(y[0]), _];"
        ),
        &format!(
            "{lagrangian} kinematic = [ddot(x) * y[0], ddot(s)]; variational = chetaev; branch = [divide(y[0]), _];"
        ),
    );
    same_code(
        &format!(
            "{lagrangian} kinematic = [ddot(x[0]), ddot(x[1]), ddot(x[2])]; variational = chetaev; \
             discrete_kinematic = [node(ddot(x[0])), node(ddot(x[1])), node(ddot(x[2]))];"
        ),
        &format!(
            "{lagrangian} kinematic = ddot(x); variational = chetaev; discrete_kinematic = node(ddot(x));"
        ),
    );
}

#[test]
fn forces_and_fields() {
    let lagrangian = "lagrangian = u.norm_squared() / 2 + dot(y).norm_squared() / 2 + dot(s).powi(2) / 2;";
    same_code(
        &format!(
            "{lagrangian} external_forces = ([mass * dot(x[1]), -mass * dot(x[0]), 0], [-s * y[0], -s * y[1], -s * y[2]], 0);"
        ),
        &format!("{lagrangian} external_forces = (mass * u.cross([0, 0, 1]), -s * y, 0);"),
    );
    let of = |fields: &str| {
        model(&format!(
            "coordinates(x: [3]); lagrangian = dot(x).norm_squared(); kinematic = ddot(x)[2]; variational = {fields};"
        ))
    };
    let (short, long) = (
        of("[x.cross(dot(x)), 2 * x]"),
        of(
            "[[x[1] * dot(x[2]) - x[2] * dot(x[1]), x[2] * dot(x[0]) - x[0] * dot(x[2]), x[0] * dot(x[1]) - x[1] * dot(x[0])], |i| 2 * x[i]]",
        ),
    );
    assert_eq!(fields_of(&short).len(), 2);
    assert_eq!(
        format!("{:?}", fields_of(&short)),
        format!("{:?}", fields_of(&long))
    );
    // one vector in place of adjacent numbers
    let flat = |force: &str| {
        code(&format!(
            "coordinates(x, y, z); lagrangian = dot(x).powi(2); let _r = [x, y, z]; external_forces = {force};"
        ))
    };
    assert!(flat("(-x, -y, -z)") == flat("-_r"));
}

#[test]
fn observed_vectors_have_numbered_names() {
    let model = model(
        "coordinates(x: [2]); /** The momentum [kg m/s] */ let p = mass * dot(x); let e = p.norm(); lagrangian = e; observe = [p, e];",
    );
    assert_eq!(model.observables(), ["p_0", "p_1", "e"]);
    assert_eq!(
        model.docs.observe[..2],
        ["The momentum [kg m/s]", "The momentum [kg m/s]"]
    );
}

fn text(text: &str) -> Text {
    read("body", text, &[]).unwrap_or_else(|mistakes| panic!("{text}\n{mistakes:?}"))
}

#[test]
fn vectors_and_matrices_are_parameters() {
    let read = text(
        "parameters { b = [0.0, 1.0], k = [[1.0, 0.5], [b[1], 2.0]], big: [3] = [1.0; 3] } coordinates(x: [2]); \
         lagrangian = dot(x).norm_squared() / 2 - (k * x - b).inner(x) + big.norm() * x[0];",
    );
    assert_eq!(
        read.model.parameters(),
        [
            "b_0", "b_1", "k_0_0", "k_0_1", "k_1_0", "k_1_1", "big_0", "big_1", "big_2"
        ]
    );
    assert_eq!(read.values, [0.0, 1.0, 1.0, 0.5, 1.0, 2.0, 1.0, 1.0, 1.0]);
    let by_elements = text(
        "parameters { b = [0.0, 1.0], k = [[1.0, 0.5], [b[1], 2.0]], big: [3] = [1.0; 3] } coordinates(x: [2]); \
         lagrangian = (dot(x[0]).powi(2) + dot(x[1]).powi(2)) / 2 - ((k[0][0] * x[0] + k[0][1] * x[1] - b[0]) * x[0] \
         + (k[1][0] * x[0] + k[1][1] * x[1] - b[1]) * x[1]) + (big[0].powi(2) + big[1].powi(2) + big[2].powi(2)).sqrt() * x[0];",
    );
    assert!(read.model.data().tape == by_elements.model.data().tape);
}

#[test]
fn matrices_of_a_struct_are_parameters() {
    let declaration =
        "coordinates(x: [2]); lagrangian = (k * dot(x)).inner(dot(x)) + (k[0] + k[1]).inner(x);";
    let item = "struct Body { k: [[f64; 2]; 2] }";
    let Ok(model) = super::analyzed(declaration, item) else {
        panic!("the matrix was not read")
    };
    assert_eq!(model.parameters(), ["k_0_0", "k_0_1", "k_1_0", "k_1_1"]);
    assert!(model.code().to_string().replace(' ', "").contains("self.k[1][0]"));
}
