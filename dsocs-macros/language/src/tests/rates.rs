//! The parameters inside a `dot(…)`, whose rates are missing in the derivative.

use super::model;

/// The names of the parameters inside a `dot(…)`, in a declaration in `x`, `y` and `z: [3]`.
fn inside(declaration: &str) -> Vec<String> {
    let model = model(&format!("coordinates(x, y, z: [3]); {declaration}"));
    let names = model.parameters();
    let places = model.parameters_of_rates().into_iter();
    places.map(|place| names[place].to_owned()).collect()
}

const KINETIC: &str = "dot(x).powi(2) + dot(y).powi(2) + sum(0..3, |i| dot(z[i]).powi(2))";

#[test]
fn of_every_way_to_write_one() {
    for (body, expected) in [
        // directly, and through names, functions, sums and user's functions
        ("lagrangian = KINETIC + dot(x + mass * y.sin());", &["mass"][..]),
        (
            "let tip = x + mass * y.sin(); lagrangian = KINETIC + dot(tip).powi(2);",
            &["mass"],
        ),
        (
            "let arm = mass * y.cos(); let tip = x + arm; let v = dot(tip); lagrangian = KINETIC + v.powi(2);",
            &["mass"],
        ),
        (
            "let tip = |i| x + masses[i] * z[i]; lagrangian = KINETIC + sum(1..3, |i| dot(tip(i)).powi(2));",
            &["masses_1", "masses_2"],
        ),
        (
            "let v = |i| dot(masses[i] * x); lagrangian = KINETIC + v(0).powi(2);",
            &["masses_0"],
        ),
        (
            "lagrangian = KINETIC + dot(sum(0..2, |i| masses[i] * z[i])).powi(2);",
            &["masses_0", "masses_1"],
        ),
        (
            "lagrangian = KINETIC + dot(curvature.at(x, mass)).powi(2);",
            &["mass"],
        ),
        (
            "lagrangian = KINETIC + dot(f64::max(mass, 1.0) * x).powi(2);",
            &["mass"],
        ),
        (
            "lagrangian = KINETIC + dot(if x < mass { x } else { y }).powi(2);",
            &["mass"],
        ),
        // in every statement
        (
            "lagrangian = KINETIC; external_forces = (-dot(x - mass), 0, |i| 0);",
            &["mass"],
        ),
        (
            "lagrangian = KINETIC; nonholonomic = dot(mass * x + y);",
            &["mass"],
        ),
        (
            "lagrangian = KINETIC; kinematic = ddot(mass * x) + y; variational = chetaev;",
            &["mass"],
        ),
        (
            "lagrangian = KINETIC; let v = mass * dot(x).powi(2); kinematic = dot(v) + dot(x).powi(2); variational = chetaev;",
            &["mass"],
        ),
        (
            "lagrangian = KINETIC; let v = dot(mass * x); observe = [v];",
            &["mass"],
        ),
        (
            "lagrangian = KINETIC; kinematic = dddot(mass * x); variational = chetaev;",
            &["mass"],
        ),
        // the derivatives that the library itself takes need no rate of a parameter
        ("lagrangian = mass * (KINETIC) - masses[0] * x.cos();", &[]),
        (
            "lagrangian = KINETIC; nonholonomic = dot(x) - mass * dot(y);",
            &[],
        ),
        (
            "lagrangian = KINETIC; kinematic = ddot(x) + mass * dot(x); variational = chetaev;",
            &[],
        ),
        (
            "lagrangian = KINETIC; phi_lagrangian = |q0, q1| ((1 - mass) * q0 + mass * q1, (q1 - q0) / h);",
            &[],
        ),
        ("lagrangian = KINETIC + mass * dot(x * y);", &[]),
        // an expression that nothing uses
        ("let _v = dot(mass * x); lagrangian = KINETIC;", &[]),
        (
            "let _v = dot(mass * x); let _w = 2 * _v; lagrangian = KINETIC;",
            &[],
        ),
    ] {
        assert_eq!(inside(&body.replace("KINETIC", KINETIC)), expected, "{body}");
    }
}
