//! The meaning of declarations: the values of their expressions, and the parts of their models.

use super::{ITEM, analyzed, code, fields_of, model};
use crate::graph::{Callee, Comparison, Graph, Leaf, Node, NodeId};
use crate::hash::HashMap;
use crate::model::Model;

/// The values of the coordinates and of the parameters.
struct At {
    leaves: HashMap<Leaf, f64>,
    params: HashMap<&'static str, f64>,
}

fn at() -> At {
    let leaves = [
        (Leaf::Q(0), 0.3),
        (Leaf::Q(1), 0.7),
        (Leaf::V(0), 1.1),
        (Leaf::V(1), -0.4),
        (Leaf::A(0), 0.9),
        (Leaf::A(1), 2.3),
        (Leaf::X0(0), 1.0),
        (Leaf::X0(1), 2.0),
        (Leaf::X1(0), 4.0),
        (Leaf::X1(1), 8.0),
        (Leaf::X2(0), 16.0),
        (Leaf::X2(1), 32.0),
        (Leaf::H, 0.5),
    ];
    let params = [
        ("self . mass", 2.5),
        (":: core :: primitive :: f64 :: from (self . count)", 3.0),
        (":: core :: primitive :: f64 :: from (self . single)", 0.25),
        (":: core :: primitive :: f64 :: from (self . flag)", 1.0),
        ("* self . shared", 6.0),
        ("self . masses [2]", 7.0),
        ("self . masses [self . big]", 8.0),
        ("self . table . length", 9.0),
        ("self . table . value (3 , self . big)", 10.0),
        ("std :: f64 :: consts :: PI", 11.0),
        ("GRAVITY", 12.0),
        ("K :: LIMIT", 13.0),
        ("self . table . min (1.0)", 14.0),
        ("self . big as f64", 15.0),
        ("user (self . mass)", 16.0),
        (
            "self . masses . iter () . map (| m | m * self . mass) . sum :: < f64 > ()",
            17.0,
        ),
    ];
    At {
        leaves: leaves.into_iter().collect(),
        params: params.into_iter().collect(),
    }
}

impl At {
    fn value(&self, graph: &Graph, id: NodeId) -> f64 {
        let of = |id: NodeId| self.value(graph, id);
        match graph.node(id) {
            Node::Constant(bits) => bits.get(),
            Node::Leaf(leaf) => self.leaves[leaf],
            Node::Param(param) => {
                let text = graph.param_tokens(*param).to_string();
                *self
                    .params
                    .get(text.as_str())
                    .unwrap_or_else(|| panic!("unknown parameter {text}"))
            }
            Node::Sum(constant, terms) => {
                constant.get() + terms.iter().map(|&(t, c)| c.get() * of(t)).sum::<f64>()
            }
            Node::Product(factors) => factors.iter().map(|&(factor, n)| of(factor).powi(n)).product(),
            Node::Unary(op, a) => op.apply(of(*a)),
            Node::Powf(a, b) => of(*a).powf(of(*b)),
            Node::Atan2(y, x) => of(*y).atan2(of(*x)),
            Node::Select(Comparison::Lt, [l, r, a, b]) => of(if of(*l) < of(*r) { *a } else { *b }),
            Node::Select(Comparison::Le, [l, r, a, b]) => of(if of(*l) <= of(*r) { *a } else { *b }),
            Node::Call { .. } => panic!("a call has no value here"),
        }
    }

    fn values(&self, graph: &Graph, ids: &[NodeId]) -> Vec<f64> {
        ids.iter().map(|&id| self.value(graph, id)).collect()
    }
}

/// A model in which `e` is observed, and the node of `e`.
fn observed(expression: &str) -> (Model, NodeId) {
    let model = model(&format!(
        "coordinates(x, y); lagrangian = x; let e = {expression}; observe = [e];"
    ));
    let node = model.observe[0].1;
    (model, node)
}

#[track_caller]
fn means(expression: &str, expected: f64) {
    let (model, node) = observed(expression);
    let value = at().value(&model.graph, node);
    assert!(
        (value - expected).abs() <= 1e-14 * (1.0 + expected.abs()),
        "{expression}: {value}, expected {expected}"
    );
}

/// `callee(arguments)` as text, with the arguments' values.
#[track_caller]
fn is_call(expression: &str, callee: &str, arguments: &[f64]) {
    let (model, node) = observed(expression);
    let Node::Call {
        callee: index,
        args,
        wrt,
    } = model.graph.node(node).clone()
    else {
        panic!("{expression} is no call: {:?}", model.graph.node(node))
    };
    let text = match model.graph.callee(index) {
        Callee::Function(tokens) => tokens.to_string(),
        Callee::Method(method) => format!(".{method}"),
    };
    assert_eq!(text, callee, "{expression}");
    assert_eq!(at().values(&model.graph, &args), arguments, "{expression}");
    assert!(wrt.is_empty());
}

/// The attribute's documentation: both compare by `<`, which does not hold for NaN.
#[test]
fn the_smaller_and_the_larger_of_a_number_and_none() {
    // at x = 0.3
    for nan in ["(x - 1).sqrt()", "(x - 1).ln()"] {
        means(&format!("{{ let n = {nan}; n.min(y) }}"), 0.7);
        means(&format!("{{ let n = {nan}; y.max(n) }}"), 0.7);
        for lost in ["y.min(n)", "n.max(y)"] {
            let model = model(&format!(
                "coordinates(x, y); let n = {nan}; let e = {lost}; lagrangian = e;"
            ));
            assert!(at().value(&model.graph, model.lagrangian).is_nan(), "{lost}");
        }
    }
}

#[test]
fn arithmetic() {
    means("1 + 2 * x - y / 4", 1.0 + 0.6 - 0.175);
    means("-(x + 1_000) * 0x10", -1000.3 * 16.0);
    means("1.5e1f64 + 2f64 * -x", 15.0 - 0.6);
    means("{ let a = x * x; let b = a + y; a / b }", 0.09 / 0.79);
    means("{ let a = x; a } + { let a = y; a }", 1.0);
}

#[test]
fn functions() {
    let (x, y) = (0.3_f64, 0.7_f64);
    let one: [(&str, f64); 25] = [
        ("sqrt", x.sqrt()),
        ("cbrt", x.cbrt()),
        ("exp", x.exp()),
        ("exp_m1", x.exp_m1()),
        ("exp2", x.exp2()),
        ("ln", x.ln()),
        ("ln_1p", x.ln_1p()),
        ("log10", x.log10()),
        ("log2", x.log2()),
        ("sin", x.sin()),
        ("cos", x.cos()),
        ("tan", x.tan()),
        ("asin", x.asin()),
        ("acos", x.acos()),
        ("atan", x.atan()),
        ("sinh", x.sinh()),
        ("cosh", x.cosh()),
        ("tanh", x.tanh()),
        ("asinh", x.asinh()),
        ("atanh", x.atanh()),
        ("abs", x.abs()),
        ("signum", x.signum()),
        ("recip", x.recip()),
        ("to_radians", x.to_radians()),
        ("to_degrees", x.to_degrees()),
    ];
    for (name, expected) in &one {
        means(&format!("x.{name}()"), *expected);
        means(&format!("f64::{name}(x)"), *expected);
    }
    means("x.sin().cos()", x.sin().cos());
    means("(1 + x).acosh()", (1.0 + x).acosh());
    means("x.log(3)", x.log(3.0));
    means("x.powf(y)", x.powf(y));
    means("x.powi(3)", x.powi(3));
    means("x.powi(-2)", x.powi(-2));
    means("(-x).powi((2))", x.powi(2));
    means("x.atan2(y)", x.atan2(y));
    means("x.hypot(y)", x.hypot(y));
    means("x.min(y) + 10 * x.max(y)", x + 10.0 * y);
    means("y.min(x) + 10 * y.max(x)", x + 10.0 * y);
    means("x.mul_add(y, 2)", x.mul_add(y, 2.0));
}

#[test]
fn choices() {
    means("if x < y { 1 } else { 2 }", 1.0);
    means("if x > y { 1 } else { 2 }", 2.0);
    means("if x <= 0.3 { 1 } else { 2 }", 1.0);
    means("if x >= 0.3 { 1 } else { 2 }", 1.0);
    means("if x > y { 1 } else if y > 0.6 { let a = 3; a } else { 2 }", 3.0);
    means("if x < y && y < 0.5 { 1 } else { 2 }", 2.0);
    means("if x < y || y < 0.5 { 1 } else { 2 }", 1.0);
    means("if !(x < y) { 1 } else { 2 }", 2.0);
    means("if flag { x } else { y }", 0.3);
    means("if !flag { x } else { y }", 0.7);
}

#[test]
fn time_derivatives() {
    let (x, y, vx, vy, ax, ay) = (0.3, 0.7, 1.1, -0.4, 0.9, 2.3);
    means("dot(x) + ddot(y) + dot(dot(x))", vx + ay + ax);
    means("dot(x * y)", vx * y + x * vy);
    means("ddot(x * y)", ax * y + 2.0 * vx * vy + x * ay);
    means(
        "dot(dot(x).powi(2) * y.sin())",
        2.0 * vx * ax * f64::sin(y) + vx * vx * f64::cos(y) * vy,
    );
    means("dot(mass)", 0.0);
}

#[test]
fn parameters() {
    means("mass * count + single + shared", 2.5 * 3.0 + 0.25 + 6.0);
    means("masses[2] + masses[big] * x", 7.0 + 2.4);
    means("table.length + table.value(3, big)", 19.0);
    means("std::f64::consts::PI + GRAVITY + K::LIMIT", 36.0);
    means("table.min(1.0)", 14.0);
    means("big as f64", 15.0);
    means("mass.sqrt()", 2.5_f64.sqrt());
    means("user(mass)", 16.0);
    means("masses.iter().map(|m| m * mass).sum::<f64>()", 17.0);
}

#[test]
fn functions_of_the_user() {
    is_call("curvature.at(x, 2 * y)", "self . curvature . at", &[0.3, 1.4]);
    is_call("curvature.min(x)", "self . curvature . min", &[0.3]);
    is_call("friction::<K>(dot(x), mass)", "friction :: < K >", &[1.1, 2.5]);
    is_call("laws::friction(ddot(x), 3)", "laws :: friction", &[0.9, 3.0]);
    is_call("x.bessel(y)", ".bessel", &[0.3, 0.7]);
    is_call("force(x)", "(self . force)", &[0.3]);
    is_call("(table.force)(x)", "(self . table . force)", &[0.3]);
    is_call("{ let k = mass; law(k) }", "law", &[2.5]);
    is_call("{ let k = 2 * mass; k.floor() }", ".floor", &[5.0]);
}

#[test]
fn maps_of_components_and_of_vectors() {
    let check = |closure: &str| {
        let model = model(&format!(
            "coordinates(x, y); lagrangian = x; phi_lagrangian = {closure};"
        ));
        let crate::model::PairPoint { q, v, .. } = model.phi_lagrangian[0].clone();
        assert_eq!(at().values(&model.graph, &q), [2.5, 5.0], "{closure}");
        assert_eq!(at().values(&model.graph, &v), [6.0, 12.0], "{closure}");
    };
    check("|q0, q1| ((q0 + q1) / 2, (q1 - q0) / h)");
    check("|a, b| { let d = b - a; (a + d / 2, d / h) }");
    check("|q0, q1| { let d = (q1 - q0, q1.y - q0.1); ((q0 + q1) / 2, (d.x / h, d.1 / h)) }");
    check("|q0, q1| (({ let s = q0 + q1; s.x } / 2, (q0 + q1) / 2), { let d = q1 - q0; (d / h, d / h) })");
    check("|q0, q1| (((q0.x + q1.0) / 2, (q0.y + q1.1) / 2), if h < 1 { (q1 - q0) * 2 } else { q0 })");
}

/// Without a declared map the step is of order 2: the paper's map for `L = T(v) - V(q)`, the middle of the
/// leg otherwise.
#[test]
fn the_map_of_the_lagrangian_where_none_is_written() {
    const FREE: &str = "lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - x * y";
    let code = |statements: &str| code(&format!("coordinates(x, y); {statements}"));
    let is = |map: &str, statements: &str| {
        let (default, declared) = (
            code(statements),
            code(&format!("{statements} phi_lagrangian = {map};")),
        );
        assert!(default == declared, "{statements}");
    };
    is("paper", &format!("{FREE};"));
    is("paper", &format!("{FREE} + dot(x).powi(4);"));
    is(
        "paper",
        &format!("{FREE}; holonomic = x.powi(2) + y.powi(2) - 1;"),
    );
    is(
        "paper",
        &format!("{FREE}; kinematic = ddot(x) + x; constraint_forces = [(0, 1)];"),
    );
    is("paper", &format!("{FREE} + (x * dot(y) - dot(y) * x);"));
    // a mass matrix that depends on the position, a force like that of a magnetic field
    is("midpoint", &format!("{FREE} + x * dot(x).powi(2);"));
    is("midpoint", &format!("{FREE} + x * dot(y);"));
    is("midpoint", &format!("{FREE} + curvature.at(x, dot(y));"));
    is("midpoint", &format!("{FREE}; nonholonomic = dot(x) - y;"));
    is(
        "midpoint",
        &format!("{FREE}; nonholonomic = dot(x) - y; kinematic = ddot(y); variational = chetaev;"),
    );
    is(
        "midpoint",
        &format!(
            "{FREE}; kinematic = ddot(x); constraint_forces = [(0, 1)]; discrete_kinematic = leg(dot(x), 1) - leg(dot(x), 0);"
        ),
    );
}

#[test]
fn the_variational_map_is_the_kinematic_one_unless_given() {
    let kinematic = "phi_kinematic = |a, b, c| (b, (c - b) / h, (c - 2 * b + a) / h.powi(2));";
    let start = "coordinates(x, y); lagrangian = x;";
    let both = model(&format!("{start} {kinematic}"));
    assert_eq!(both.phi_kinematic, both.phi_variational);
    let crate::model::TriplePoint { q, v, a, .. } = both.phi_variational.clone().unwrap();
    assert_eq!(at().values(&both.graph, &q), [4.0, 8.0]);
    assert_eq!(at().values(&both.graph, &v), [24.0, 48.0]);
    assert_eq!(at().values(&both.graph, &a), [36.0, 72.0]);
    let other = model(&format!(
        "{start} {kinematic} phi_variational = |a, b, c| (a, b, c);"
    ));
    assert_ne!(other.phi_kinematic, other.phi_variational);
    let only = model(&format!("{start} phi_variational = |a, b, c| (a, b, c);"));
    assert!(only.phi_kinematic.is_none() && only.phi_variational.is_some());
}

#[test]
fn the_parts_of_a_model() {
    let model = model(
        "lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)); let w = dot(x) * y; let v = ddot(x); \
         coordinates(x, y); kinematic = [dot(w), w * ddot(y)]; variational = []; branch = [_, divide(w)]; observe = [w, v];",
    );
    assert_eq!(model.coordinates, ["x", "y"]);
    let parameters: Vec<_> = model
        .parameters
        .iter()
        .map(|p| (p.name.as_str(), p.element.clone(), p.doc.as_str()))
        .collect();
    assert_eq!(
        parameters,
        [
            ("mass", vec![], "The mass, in [kg]."),
            ("masses_0", vec![0], ""),
            ("masses_1", vec![1], ""),
            ("masses_2", vec![2], ""),
        ]
    );
    assert_eq!(
        model.constraints.iter().map(|row| row.order).collect::<Vec<_>>(),
        [2, 2]
    );
    assert_eq!(model.constraints[0].divide, None);
    assert_eq!(model.constraints[1].divide, Some(model.observe[0].1));
    assert!(fields_of(&model).is_empty());
    assert_eq!(
        model
            .observe
            .iter()
            .map(|(name, _)| name.to_string())
            .collect::<Vec<_>>(),
        ["w", "v"]
    );
}

#[test]
fn documentation_is_kept() {
    let declaration = "
        coordinates(
            /// The way [m].
            x,
            /// The angles
            /// of the rods [rad].
            theta: [2],
            y,
        );
        /** The speed [m/s]. */
        let speed = dot(x);
        let other = dot(y);
        /// The Lagrangian has nobody to be told to.
        lagrangian = speed.powi(2) + other.powi(2) + dot(theta[0]).powi(2) + dot(theta[1]).powi(2);
        observe = [other, speed];
    ";
    let item = "
        /// Two rods
        /// on a cart.
        ///
        /// More of them.
        #[derive(Clone)]
        struct Rods;
    ";
    let docs = analyzed(declaration, item).unwrap().docs;
    assert_eq!(docs.system, "Two rods on a cart.");
    let angles = "The angles of the rods [rad].";
    assert_eq!(docs.coordinates, ["The way [m].", angles, angles, ""]);
    assert_eq!(docs.observe, ["", "The speed [m/s]."]);
}

#[test]
fn without_constraints_every_displacement_is_virtual() {
    let model = model("coordinates(x, y); lagrangian = x;");
    let fields: Vec<_> = fields_of(&model)
        .iter()
        .map(|field| at().values(&model.graph, field))
        .collect();
    assert_eq!(fields, [[1.0, 0.0], [0.0, 1.0]]);
}

#[test]
fn one_coordinate_needs_no_tuple() {
    for field in ["(dot(x),)", "dot(x)", "(dot(x))"] {
        let model = model(&format!(
            "coordinates(x); lagrangian = x; variational = [{field}];"
        ));
        assert_eq!(at().values(&model.graph, &fields_of(&model)[0]), [1.1]);
    }
}

/// Asserts that the forces do no work on the fields, and that there are enough fields.
#[track_caller]
fn annihilates(coordinates: &[&str], forces: &[&str]) -> Vec<Vec<f64>> {
    let n = coordinates.len();
    let accelerations = |count: usize| {
        let rows = coordinates.iter().take(count).map(|name| format!("ddot({name})"));
        rows.collect::<Vec<_>>().join(", ")
    };
    let rows = accelerations(forces.len());
    let declaration = format!(
        "coordinates({}); lagrangian = dot(a); kinematic = [{rows}]; constraint_forces = [{}];",
        coordinates.join(", "),
        forces.join(", ")
    );
    let at = At {
        leaves: (0..n).map(|i| (Leaf::Q(i), 0.5 + 0.1 * i as f64)).collect(),
        params: HashMap::default(),
    };
    let from_forces = model(&declaration);
    let fields: Vec<_> = fields_of(&from_forces)
        .iter()
        .map(|f| at.values(&from_forces.graph, f))
        .collect();
    assert_eq!(fields.len(), n - forces.len());
    for force in forces {
        let rest = accelerations(n - 1);
        let list = format!(
            "coordinates({}); lagrangian = dot(a); kinematic = [{rest}]; variational = [{force}];",
            coordinates.join(", ")
        );
        let direct = model(&list);
        let force = at.values(&direct.graph, &fields_of(&direct)[0]);
        for field in &fields {
            let work: f64 = force.iter().zip(field).map(|(a, b)| a * b).sum();
            assert!(work.abs() < 1e-14, "{force:?} · {field:?} = {work}");
        }
    }
    fields
}

#[test]
fn annihilators() {
    assert_eq!(annihilates(&["a", "b"], &["(0, 1)"]), [[1.0, 0.0]]);
    assert_eq!(annihilates(&["a", "b"], &["(1, a)"]), [[-0.5, 1.0]]);
    let minors = annihilates(&["a", "b"], &["(a.sin(), b)"]);
    assert_eq!(minors, [[0.6, -f64::sin(0.5)]]);
    annihilates(&["a", "b", "c"], &["(a, 3, b)"]);
    annihilates(&["a", "b", "c"], &["(a, b, c)", "(b, c, a)"]);
    annihilates(&["a", "b", "c"], &["(a, 1, c)", "(b, 2, a)"]);
    annihilates(&["a", "b", "c"], &["(1, 0, 1)", "(0, 1, b)"]);
    annihilates(&["a", "b", "c", "d"], &["(2, a, 3, b)", "(0, 1, a, c)"]);
    annihilates(&["a", "b", "c"], &["(1, 0, 0)", "(0, 1, 0)", "(1, 1, 1)"]);
}

#[test]
fn items_of_every_kind() {
    let right = "coordinates(x); lagrangian = mass * dot(x).powi(2);";
    for item in [
        "struct A { mass: f64 }",
        "#[derive(Clone)] pub(crate) struct A<'a, T: ?Sized + 'a, const N: usize> where T: Copy { data: &'a T, mass: f64, a: [f64; N] }",
    ] {
        let model = analyzed(right, item).unwrap();
        assert_eq!(model.parameters.len(), 1);
    }
    assert!(analyzed("coordinates(x); lagrangian = dot(x).powi(2);", "struct A;").is_ok());
    assert!(analyzed("coordinates(x); lagrangian = dot(x).powi(2);", ITEM).is_ok());
}
