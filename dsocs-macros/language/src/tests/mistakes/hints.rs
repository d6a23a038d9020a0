//! Hints for misspelt or foreign names, and warnings about declarations without effect.

use crate::tests::mistakes::{expression, mistakes_on, one, one_on, statement};
use crate::tests::{ITEM, model};

/// Notations of other languages, and the hints for them.
#[test]
fn other_ways_of_writing() {
    for name in ["x_dot", "xdot", "dx", "dot_x", "dx_dt", "dxdt"] {
        expression(&format!("{name} * y"), name, "did you mean `dot(x)`?");
    }
    for name in ["x_ddot", "xddot", "ddx", "ddot_x"] {
        expression(&format!("{name} * y"), name, "did you mean `ddot(x)`?");
    }
    expression("dz * y", "dz", "expected a coordinate");
    expression("x.dot() * y", "dot", "expected `dot(x)`");
    let array = "coordinates(theta: [2]); let energy = theta[0]; lagrangian =";
    one(
        &format!("{array} theta_dot[1];"),
        "theta_dot",
        "did you mean `dot(theta)`?",
    );
    one(
        &format!("{array} denergy;"),
        "denergy",
        "did you mean `dot(energy)`?",
    );
    // a field is found before the derivative of another name
    assert_eq!(
        mistakes_on(
            "coordinates(x); lagrangian = dx * dot(x);",
            "struct A { dx: f64 }"
        ),
        []
    );

    statement("holonomic = x - y = 0;", "= 0", "leave this out");
    statement("holonomic = [x - y == 0.0, y];", "== 0.0", "leave this out");
    statement("nonholonomic = dot(x) = y;", "= y", "`a = b` is written `a - b`");

    expression(
        "x**2 * dot(x)",
        "**",
        "`**` is no power in Rust; expected `.powi(2)`",
    );
    expression("x**y * dot(x)", "**", "expected `.powf(y)`");
    expression("x ** mass", "**", "expected `.powf(mass)`");
    expression("2**0.5 * dot(x)", "**", "expected `.powf(0.5)`");
    assert_eq!(
        mistakes_on(
            "coordinates(x); let e = dot(x) * *shared; lagrangian = e * e;",
            ITEM
        ),
        []
    );
}

/// Functions and constants by their names in other languages.
#[test]
fn names_elsewhere() {
    for (call, name, meant) in [
        ("sin(x)", "sin", "expected `(…).sin()` or `f64::sin(…)`"),
        ("max(x, y)", "max", "expected `(…).max(…)`"),
        ("log(x)", "log", "expected `(…).ln()`"),
        ("sign(x)", "sign", "expected `(…).signum()`"),
        ("pow(x, 2)", "pow", "expected `(…).powi(2)` or `.powf(a)`"),
        ("fabs(x)", "fabs", "expected `(…).abs()`"),
        ("arctan2(y, x)", "arctan2", "expected `(…).atan2(x)`"),
        ("diff(x, t)", "diff", "expected `dot(x)`"),
        (
            "Derivative(x * y, t)",
            "Derivative",
            "expected `dot(x*y)`, and `ddot(x*y)` for the second one",
        ),
        ("Pi * x", "Pi", "did you mean `pi`?"),
        ("np.pi * x", "np", "expected `pi`, without `np`"),
        ("np.sin(x)", "np", "expected `(…).sin()`, without `np`"),
        (
            "math.sqrt(x * y)",
            "math",
            "expected `(…).sqrt()`, without `math`",
        ),
        ("np.sign(x)", "np", "expected `(…).signum()`"),
        (
            "x.abs",
            "abs",
            "a method is called with parentheses: expected `.abs()`",
        ),
        ("(x * y).sqrt", "sqrt", "expected `.sqrt()`"),
        ("x.sign", "sign", "expected `.signum()`"),
        ("x.squared()", "squared", "expected `.powi(2)`"),
        ("dot(x).pow(2)", "pow", "expected `.powi(2)` or `.powf(a)`"),
        ("x.arcsin()", "arcsin", "expected `.asin()`"),
        ("2 (x + y)", "2", "a product is written with `*`"),
        (
            "mass x.sin()",
            "x",
            "expected `;` or an operator: a product is written with `*`",
        ),
        ("2 x", "x", "a product is written with `*`"),
        ("x.sin() y.cos()", "y", "a product is written with `*`"),
        (
            "mass * (2 x)",
            "x",
            "expected an operator: a product is written with `*`",
        ),
    ] {
        expression(&format!("{call} * y"), name, meant);
    }
    // a name of the declaration takes precedence, and a path means the user's function
    for own in [
        "let sign = |i| i; lagrangian = sign(x) * dot(x);",
        "let pi = 3; lagrangian = pi * dot(x);",
        "let np = 3; lagrangian = np * dot(x);",
        "lagrangian = self::sign(x) * dot(x) * PI * TAU * pi * tau;",
        "lagrangian = Wave::squared(x) * dot(x);",
        "lagrangian = square(x) * dot(x);",
    ] {
        assert_eq!(
            mistakes_on(&format!("coordinates(x, y); {own}"), ITEM),
            [],
            "{own}"
        );
    }
}

/// Declarations without effect are warned of; they are no mistakes.
#[test]
fn warnings() {
    let told = |declaration: &str| -> Vec<(usize, String)> {
        let model = model(declaration).warnings().into_iter();
        model.map(|warning| (warning.column, warning.message)).collect()
    };
    let free = "coordinates(x, y); lagrangian = dot(x).powi(2) + dot(y).powi(2)";
    assert_eq!(told(&format!("{free};")), []);
    let unused = told(&format!("{free}; let used = x; let speed = used;"));
    assert_eq!(unused.len(), 1, "{unused:?}");
    assert_eq!(unused[0].0, free.len() + "; let used = x; let ".len() + 1);
    assert!(unused[0].1.contains("nothing uses this `let`"), "{unused:?}");
    for used in [
        "let _speed = x;",
        "let seen = x; observe = [seen];",
        "let f = |i| i; holonomic = x - f(y);",
        "let n = 3; holonomic = x - sum(0..n, |i| i) * y;",
        "let w = dot(x); kinematic = ddot(x) * w; variational = [(0, 1)]; branch = divide(w);",
        "let u = x; variational = [(u, 0), (0, 1)];",
    ] {
        assert_eq!(told(&format!("{free}; {used}")), [], "{used}");
    }

    let massless = "coordinates(x, y); lagrangian = dot(x).powi(2)";
    for forgotten in [
        ";",
        " - x * y.powi(2);",
        "; kinematic = ddot(x) + y; variational = [(0, 1)];",
    ] {
        let told = told(&format!("{massless}{forgotten}"));
        assert_eq!(told.len(), 1, "{told:?}");
        assert_eq!(told[0].0, "coordinates(x, ".len() + 1);
        assert!(told[0].1.contains("the acceleration of `y`"), "{told:?}");
    }
    for bound in [
        "holonomic = y - x.powi(2);",
        "nonholonomic = dot(y) - x;",
        "kinematic = ddot(y) - x; constraint_forces = [(0, 1)];",
    ] {
        assert_eq!(told(&format!("{massless}; {bound}")), [], "{bound}");
    }
}

/// A holonomic constraint that was differentiated twice drifts; one of second order does not.
#[test]
fn differentiated_constraints() {
    let told = |declaration: &str| -> Vec<(usize, String)> {
        let model = model(declaration).warnings().into_iter();
        model.map(|warning| (warning.column, warning.message)).collect()
    };
    let free = "coordinates(x, y); lagrangian = dot(x).powi(2) + dot(y).powi(2) - y; let _g = x.powi(2) + y.powi(2);";
    for row in [
        "kinematic = ddot(_g); variational = chetaev;",
        "kinematic = x * ddot(x) + y * ddot(y) + dot(x).powi(2) + dot(y).powi(2); variational = chetaev;",
        "kinematic = ddot(x * y.sin()); constraint_forces = [(3 * y.sin(), 3 * x * y.cos())];",
    ] {
        let found = told(&format!("{free} {row}"));
        assert_eq!(found.len(), 1, "{row}: {found:?}");
        assert!(found[0].1.contains("under `holonomic`"), "{found:?}");
        assert_eq!(found[0].0, free.len() + " kinematic = ".len() + 1, "{row}");
    }
    for row in [
        // stabilised, damped, or not a second derivative of positions alone
        "kinematic = ddot(_g) + 2 * dot(_g) + _g - 1; variational = chetaev;",
        "kinematic = ddot(_g) + dot(x); variational = chetaev;",
        "kinematic = dot(x * dot(y) - y * dot(x)); variational = chetaev;",
        "kinematic = dot(dot(x).powi(2) + dot(y).powi(2)); variational = chetaev;",
        // a force that may act in another direction, or a joint that goes on turning
        "kinematic = ddot(_g); constraint_forces = [(1, 0)];",
        "kinematic = ddot(x - y); variational = chetaev;",
    ] {
        let unused = told(&format!("{free} {row}"));
        assert!(unused.is_empty(), "{row}: {unused:?}");
    }
}

/// The nearest name is suggested, and none where none is near.
#[test]
fn nearest_names() {
    let item = "struct A { n: f64, length: f64, m: f64 }";
    let of = |name: &str| format!("coordinates(x); lagrangian = {name} * dot(x);");
    one_on(&of("lenght"), item, "lenght", "did you mean `length`?");
    one_on(
        &of("lenght"),
        "struct A { n: f64 }",
        "lenght",
        "expected a coordinate",
    );
    one_on(&of("leng"), item, "leng", "expected a coordinate");
    one_on(&of("k"), item, "k", "expected a coordinate");
}

#[test]
fn a_field_has_no_name_of_a_column() {
    let declaration = "coordinates(x); lagrangian = dot(x).powi(2);";
    for (item, place, message) in [
        (
            "struct S { mass: f64, v_x: f64 }",
            "v_x",
            "`v_x` is the column of the velocity of `x`",
        ),
        (
            "struct S { a_x: f64 }",
            "a_x",
            "`a_x` is the column of the acceleration of `x`",
        ),
        (
            "struct S { lambda: [f64; 2] }",
            "lambda",
            "`lambda_0` is the column of a multiplier",
        ),
    ] {
        one_on(declaration, item, place, message);
    }
    // what is no number has no column
    assert!(mistakes_on(declaration, "struct S { energy: String, force_x: Samples }").is_empty());
}
