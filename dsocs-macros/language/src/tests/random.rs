//! Random declarations: the result is code or errors, never a panic, and both are valid Rust.

use proptest::prelude::*;

use super::{ITEM, tokens};
use crate::expand::{expand, model};

/// A random expression, in most cases a valid one.
fn expression() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        8 => prop::sample::select(vec![
            "x", "y", "dot(x)", "dot(y)", "ddot(x)", "ddot(y)", "mass", "2", "0.5", "0", "masses[1]", "a",
        ]),
        1 => prop::sample::select(vec![
            "1e308", "1e-308", "table", "flag", "h", "dot(ddot(x))", "masses[9]", "unknown", "\"text\"", "()", "-0.0",
        ]),
    ]
    .prop_map(str::to_owned);
    leaf.prop_recursive(5, 40, 3, |inner| {
        let binary = prop::sample::select(vec!["+", "-", "*", "/", "<", "%", "^", "&&"]);
        let unary = prop::sample::select(vec![
            "sin", "cos", "tanh", "sqrt", "abs", "ln", "recip", "exp", "signum", "cbrt", "nothing",
        ]);
        prop_oneof![
            6 => (inner.clone(), binary, inner.clone()).prop_map(|(l, op, r)| format!("({l} {op} {r})")),
            3 => (inner.clone(), unary).prop_map(|(e, f)| format!("({e}).{f}()")),
            2 => (inner.clone(), -3..5_i32).prop_map(|(e, n)| format!("({e}).powi({n})")),
            1 => (inner.clone(), inner.clone()).prop_map(|(e, p)| format!("({e}).powf({p})")),
            1 => (inner.clone(), inner.clone()).prop_map(|(y, x)| format!("({y}).atan2({x})")),
            1 => inner.clone().prop_map(|e| format!("dot({e})")),
            1 => (inner.clone(), inner.clone()).prop_map(|(x, y)| format!("curvature.at({x}, {y})")),
            1 => inner.clone().prop_map(|e| format!("sum(0..3, |i| {e} * i)")),
            1 => (inner.clone(), inner.clone(), inner.clone())
                .prop_map(|(c, t, e)| format!("if {c} < x {{ {t} }} else {{ {e} }}")),
            1 => inner.prop_map(|e| format!("-{e}")),
        ]
    })
}

/// A declaration of two coordinates: most statements are there, in any order, some twice.
fn declaration() -> impl Strategy<Value = String> {
    let statement = prop_oneof![
        4 => expression().prop_map(|e| format!("kinematic = {e};")),
        2 => (expression(), expression()).prop_map(|(a, b)| format!("kinematic = [{a}, {b}];")),
        4 => (expression(), expression()).prop_map(|(a, b)| format!("variational = [({a}, {b})];")),
        2 => (expression(), expression()).prop_map(|(a, b)| format!("constraint_forces = [({a}, {b})];")),
        1 => expression().prop_map(|e| format!("branch = divide({e});")),
        2 => expression().prop_map(|e| format!("let a = {e};")),
        1 => Just("observe = [a];".to_owned()),
        1 => expression().prop_map(|e| format!("phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) * {e} / h);")),
        1 => Just("phi_kinematic = |q0, q1, q2| (q1, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2));".to_owned()),
    ];
    (
        expression(),
        prop::collection::vec(statement, 0..5),
        any::<bool>(),
    )
        .prop_map(|(l, rest, kinetic)| {
            let kinetic = if kinetic {
                "dot(x).powi(2) + dot(y).powi(2) + "
            } else {
                ""
            };
            format!("coordinates(x, y); {} lagrangian = {kinetic}{l};", rest.join(" "))
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn declarations_become_code_or_errors(declaration in declaration()) {
        let (declaration, item) = (tokens(&declaration), tokens(ITEM));
        let code = expand(declaration.clone(), &item);
        prop_assert!(syn::parse2::<syn::File>(code.clone()).is_ok(), "no Rust: {code}");
        if let Err(mistakes) = model(declaration, &syn::parse2(item).unwrap()) {
            prop_assert!(!mistakes.errors.is_empty());
        }
    }

    #[test]
    fn any_tokens_become_errors(text in "[a-z0-9 (){}\\[\\];=+*/.,|<>&-]{0,80}") {
        if let Ok(declaration) = text.parse() {
            let code = expand(declaration, &tokens(ITEM));
            prop_assert!(syn::parse2::<syn::File>(code.clone()).is_ok(), "no Rust: {code}");
        }
    }
}
