//! Arrays of coordinates, sums over ranges and functions of the declaration: each equals its expanded form.

use super::{fields_of, model};
use crate::model::Model;

/// A model that observes two expressions, with the coordinates `x` and `theta: [3]`.
fn observed(left: &str, right: &str) -> Model {
    model(&format!(
        "coordinates(x, theta: [3]); let before = |i| x * i + theta[i]; lagrangian = x; \
         let left = {left}; let right = {right}; observe = [left, right];"
    ))
}

/// Asserts that two expressions are the same node.
#[track_caller]
fn same(left: &str, right: &str) {
    let model = observed(left, right);
    let text = |node| {
        let node = model.graph.node(node);
        format!("{node:?}")
    };
    let [left_node, right_node] = [model.observe[0].1, model.observe[1].1];
    assert_eq!(
        left_node,
        right_node,
        "{left}: {}, {right}: {}",
        text(left_node),
        text(right_node)
    );
}

#[test]
fn coordinates_of_an_array() {
    let names: Vec<_> = observed("x", "x")
        .coordinates
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(names, ["x", "theta_0", "theta_1", "theta_2"]);
    same("theta[2]", "theta_2");
    same("dot(theta[0]) * ddot(theta[1])", "dot(theta_0) * ddot(theta_1)");
    same(
        "theta[4 / 2] + theta[7 % (3 + 1) - 3] + theta[(1)].sin()",
        "theta_2 + theta_0 + f64::sin(theta_1)",
    );
    same("{ let k = 2; theta[k - 1] }", "theta_1");
}

#[test]
fn sums_and_products() {
    same(
        "sum(0..3, |i| theta[i].powi(2))",
        "theta_0.powi(2) + theta_1.powi(2) + theta_2.powi(2)",
    );
    same("sum(1..=2, |i| i * theta[i])", "theta_1 + 2 * theta_2");
    same(
        "sum(0..3, |i| theta[i] * sum(i..3, |j| theta[j].cos()))",
        "theta_0 * (theta_0.cos() + theta_1.cos() \
          + theta_2.cos()) + theta_1 * (theta_1.cos() + theta_2.cos()) + theta_2 * theta_2.cos()",
    );
    same(
        "sum(0..2, |i| sum(i + 1..3, |j| (theta[j] - theta[i]).sin()))",
        "(theta_1 - theta_0).sin() + (theta_2 - theta_0).sin() + (theta_2 - theta_1).sin()",
    );
    same("product(0..3, |i| theta[i])", "theta_0 * theta_1 * theta_2");
    same("sum(2..2, |i| theta[i]) + product(3..1, |i| theta[i])", "1");
    same(
        "dot(sum(0..3, |i| theta[i]))",
        "dot(theta_0) + dot(theta_1) + dot(theta_2)",
    );
    same(
        "sum(0..2, |i| { let a = theta[i] * x; a * a })",
        "(theta_0 * x).powi(2) + (theta_1 * x).powi(2)",
    );
    same("sum(1..3, |i| x.powi(i) / i)", "x + x.powi(2) / 2");
    same(
        "sum(0..3, |i| if i > 0 { theta[i - 1] } else { x })",
        "x + theta_0 + theta_1",
    );
    same(
        "sum(0..3, |i| if i == 1 || !(i < 2) { theta[i] } else { 0 })",
        "theta_1 + theta_2",
    );
}

#[test]
fn parameters_of_an_index() {
    same(
        "sum(0..3, |i| masses[i] * theta[i])",
        "masses[0] * theta_0 + masses[1] * theta_1 + masses[2] * theta_2",
    );
    same(
        "sum(0..2, |i| masses[2 - i * 2] * x)",
        "masses[2] * x + masses[0] * x",
    );
    same(
        "sum(0..2, |i| table.value(i) + table.rows[i + 1].x)",
        "table.value(0) + table.value(1) + table.rows[1].x + table.rows[2].x",
    );
    same(
        "sum(0..2, |i| curvature.at(theta[i], i))",
        "curvature.at(theta_0, 0) + curvature.at(theta_1, 1)",
    );
    // a Rust closure keeps the names of its own
    let own = "masses.iter().enumerate().map(|(k, m)| m * masses[k]).sum::<f64>()";
    same(&format!("sum(0..2, |i| i * {own})"), own);
    same("{ let two = 2; masses[two] }", "masses[2]");
}

#[test]
fn functions_of_the_declaration() {
    same("before(2) + before(1)", "2 * x + theta_2 + x + theta_1");
    same("sum(0..3, |i| before(i))", "3 * x + theta_0 + theta_1 + theta_2");
    same(
        "{ let square = |a| a * a; square(dot(x)) + square(3) }",
        "dot(x).powi(2) + 9",
    );
    same(
        "{ let at = |i, j| theta[i] * theta[j]; at(1, 2) }",
        "theta_1 * theta_2",
    );
    same(
        "{ let at = |i| sum(0..=i, |j| theta[j]); sum(0..2, |j| at(j)) }",
        "2 * theta_0 + theta_1",
    );
    same("dot(before(1))", "dot(x) + dot(theta_1)");
    same("before(if x < 1 { 0 } else { 0 })", "theta_0");
}

#[test]
fn fields_in_the_shape_of_the_coordinates() {
    let fields = |fields: &str| {
        let model = model(&format!(
            "coordinates(x, theta: [3]); lagrangian = x; kinematic = [ddot(x), ddot(theta[0])]; \
             variational = [{fields}, (x, theta_0, dot(x), theta_2)];"
        ));
        assert_eq!(fields_of(&model)[0], fields_of(&model)[1], "{fields}");
    };
    fields("(x, [theta[0], dot(x), theta[2]])");
    fields("(x, |i| if i == 1 { dot(x) } else { theta[i] })");
    let single =
        model("coordinates(theta: [2]); lagrangian = theta[0]; variational = [[1; 2], |i| theta[i]];");
    let pair = model(
        "coordinates(theta: [2]); lagrangian = theta[0]; variational = [(1, 1), ([theta[0], theta[1]],)];",
    );
    assert_eq!(
        format!("{:?}", fields_of(&single)),
        format!("{:?}", fields_of(&pair))
    );
    let one = model("coordinates(theta: [1]); lagrangian = theta[0]; variational = [2 + theta[0]];");
    assert_eq!(fields_of(&one)[0].len(), 1);
}

#[test]
fn maps_of_arrays() {
    for closure in [
        "|a, b, c| ((b.x, [b.theta[0], b.theta_1, b.theta[1 + 1]]), (c - a) / h, b + c)",
        "|a, b, c| ((b, [b; 3]), { let d = c - a; (d.x / h, |i| d.theta[i] / h) }, c + b)",
        "|a, b, c| ((b.x, b), { let slope = |d| d / h; slope(c - a) }, sum(0..3, |i| b * i / 3) + c)",
        "|a, b, c| (b + 0 * sum(0..3, |i| b.theta[i]), (c - a) / h, (b + c, b + c))",
    ] {
        let model = model(&format!(
            "coordinates(x, theta: [3]); lagrangian = x; phi_variational = {closure}; \
             phi_kinematic = |a, b, c| (b, (c - a) / h, b + c);"
        ));
        assert_eq!(model.phi_kinematic, model.phi_variational, "{closure}");
    }
}

#[test]
fn numbers_from_a_macro_by_example() {
    use proc_macro2::{Delimiter, Group};
    // groups without delimiters, as a fragment such as `$n:literal` produces
    let group = |source: &str| Group::new(Delimiter::None, super::tokens(source));
    let (n, last) = (group("3"), group("3 - 1"));
    let declaration = quote::quote! {
        coordinates(theta: [#n]);
        lagrangian = sum(0..#n, |i| theta[i]) + theta[#last];
    };
    let Ok(model) = crate::expand::model(
        declaration,
        &syn::parse_quote!(
            struct A;
        ),
    ) else {
        panic!("the groups were not seen through")
    };
    assert_eq!(model.coordinates.len(), 3);
}
