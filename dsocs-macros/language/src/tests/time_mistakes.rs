//! What people will write wrongly about time and external forces.

use super::mistakes::mistakes_on;
use super::ITEM;

#[test]
fn look() {
    for d in [
        "coordinates(x, y); lagrangian = dot(x) * dot(y); kinematic = ddot(x); forces = [(-mass * dot(x), 0)];",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); forces = (-mass * dot(x), 0);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); external_forces = (-dot(x),);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); external_forces = -dot(x);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); external_forces = (1, 2, 3);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); external_forces = [(-dot(x), 0)];",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); external_forces = [-dot(x), 0];",
        "coordinates(x); lagrangian = dot(x) * dot(x); external_forces = [-dot(x)];",
        "coordinates(x: [3]); lagrangian = dot(x[0]) * dot(x[1]) * dot(x[2]); external_forces = (1, 2);",
        "coordinates(x: [3]); lagrangian = dot(x[0]) * dot(x[1]) * dot(x[2]); external_forces = [1, 2];",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); external_forces = (-ddot(x), 0);",
        "coordinates(x, y); let a = dot(dot(x)); lagrangian = dot(x) * dot(y); external_forces = (0, a);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); external_force = (0, 1);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); damping = (0, 1);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); friction = (0, 1);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); external_forces = (0, -dot(x).abs()); external_forces = (1, 1);",
        "coordinates(t); lagrangian = dot(t).powi(2);",
        "coordinates(x, t: [3]); lagrangian = dot(x).powi(2);",
        "coordinates(x, y); let t = x; lagrangian = dot(x) * dot(y) * t;",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) * dot(t);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) * ddot(t);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) - x(t);",
        "coordinates(x, y); lagrangian = dot(x(t)) * dot(y);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) - mass(t);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) - t();",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) - t(x);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) - t[0];",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) - time * x;",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) - sin(omega * t) * x;",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); phi_lagrangian = |q0, q1| (q0 + t * (q1 - q0), (q1 - q0) / h);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); phi_lagrangian = |t0, q0, t1, q1| (q0, (q1 - q0) / h);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); phi_lagrangian = |q0, t0, q1, t1| (t0, q0, (q1 - q0) / h);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); phi_lagrangian = |t, q0, q1| (t, q0, (q1 - q0) / h);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); phi_lagrangian = |q0, q1| (t0, q0, (q1 - q0) / h);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); phi_lagrangian = |t0, q0, t1, q1| (q0, q0, (q1 - q0) / h);",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); discrete_lagrangian = (x[1] - x[0]) * (y[1] - y[0]) * t;",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); discrete_lagrangian = (x[1] - x[0]) * (y[1] - y[0]) * t[2];",
        "coordinates(x, y); let d = t.sin(); lagrangian = dot(x) * dot(y); discrete_lagrangian = (x[1] - x[0]) * (y[1] - y[0]) * d;",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); holonomic = t;",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); holonomic = x - dot(x) * t;",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); kinematic = dot(x) - t.sin(); constraint_forces = [(1, 0)];",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); holonomic = x - t.sin(); variational = [(t, 1)];",
        "coordinates(x, y); lagrangian = t;",
        "coordinates(x, y); lagrangian = dot(x) * dot(y) - t * x; let rate = t; ",
        "coordinates(x, y); lagrangian = dot(x) * dot(y); holonomic = x - t; external_forces = (lambda, 0);",
    ] {
        println!("--- {d}");
        for (place, message) in mistakes_on(d, ITEM) {
            println!("    [{place}] {message}");
        }
    }
    for item in ["struct A { mass: f64, t: f64 }", "struct A { mass: f64, t: [f64; 3] }"] {
        println!("--- {item}");
        for (place, message) in mistakes_on("coordinates(x); lagrangian = mass * dot(x).powi(2);", item) {
            println!("    [{place}] {message}");
        }
    }
}
