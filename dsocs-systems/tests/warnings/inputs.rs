//! Held inputs: a run back in time returns to the start, and constraints beside an input continue.

use dsocs_scenes::random::Random;

use super::attempt_with;

/// The numbers in the last row of a run with an input.
fn end(plan: &str, text: &str, arguments: &[&str]) -> Vec<f64> {
    let (succeeds, [table, warnings]) =
        attempt_with(&[("plan.csv", plan.to_owned())], text, "run", arguments);
    assert!(succeeds, "{arguments:?}: {warnings}");
    let line = table.lines().last().unwrap_or_default();
    line.split(',').map(|number| number.parse().unwrap()).collect()
}

#[test]
fn a_run_goes_back_under_the_inputs_that_held() {
    let text = "parameters { torque = 0.0 } coordinates(theta); lagrangian = dot(theta).powi(2) / 2 + 9.81 * theta.cos(); \
        external_forces = torque; run { start = ([2.0], [0.5]); step = 0.01; until = 4; }";
    // changes at nodes of all steps; before the first time the parameter has its own value
    let plan = "0.24,3\n1.0,-5\n2.48,0\n";
    let input = ["--input", "torque=plan.csv", "--columns", "t,theta,v_theta"];
    for (method, tolerance) in [
        (["--order", "2"], 1e-10),
        (["--order", "4"], 1e-10),
        (["--tolerance", "1e-12"], 1e-8),
    ] {
        for step in ["0.01", "0.005", "0.0025"] {
            let there = [&input[..], &method, &["--step", step]].concat();
            let there = end(plan, text, &there);
            let back = [
                format!("--step=-{step}"),
                format!("--q0={}", there[1]),
                format!("--v0={}", there[2]),
            ];
            let back: Vec<&str> = back.iter().map(String::as_str).collect();
            let all = [&input[..], &method, &back, &["--t0", "4", "--until", "0"]].concat();
            let back = end(plan, text, &all);
            // at order 2 the velocity at the end is of second order, so the way back begins with an error
            let tolerance = if method[1] == "2" {
                40.0 * step.parse::<f64>().unwrap().powi(2)
            } else {
                tolerance
            };
            assert!(
                (back[1] - 2.0).abs() < tolerance && (back[2] - 0.5).abs() < tolerance,
                "{method:?} {step}: {back:?}"
            );
        }
    }
}

#[test]
fn a_law_goes_on_where_the_row_beside_it_changes() {
    // a car that approaches its speed by a constraint, whatever the steering is
    let text = "parameters { base = 1.2, steer = 0.2 } coordinates(x, y, theta); \
        lagrangian = 40 * (dot(x).powi(2) + dot(y).powi(2)) + 5 * dot(theta).powi(2); \
        let v = dot(x) * theta.cos() + dot(y) * theta.sin(); \
        nonholonomic = [dot(x) * theta.sin() - dot(y) * theta.cos(), dot(theta) * base * steer.cos() - v * steer.sin()]; \
        kinematic = ddot(x) * theta.cos() + ddot(y) * theta.sin() + 0.8 * (v - 3); \
        constraint_forces = [(theta.cos(), theta.sin(), 0)]; observe = [v]; \
        run { start = ([0, 0, 0], [1, 0, 0.168925]); project = true; step = 0.001; until = 5; }";
    let right = 3.0 - 2.0 * f64::exp(-4.0);
    for (method, tolerance) in [(["--tolerance", "1e-11"], 1e-9), (["--order", "2"], 1e-6)] {
        let arguments = [&["--input", "steer=plan.csv", "--columns", "t,v"], &method[..]].concat();
        let found = end("1,0.3\n2.5,-0.2\n", text, &arguments)[1];
        assert!((found - right).abs() < tolerance, "{method:?}: {found} {right}");
    }
}

#[test]
fn a_law_goes_on_where_a_mass_changes() {
    let text = "parameters { m = 1.0 } coordinates(x, th); \
        lagrangian = m / 2 * dot(x).powi(2) + (dot(x + 0.5 * th.sin()).powi(2) + dot(0.5 * th.cos()).powi(2)) / 2 + 4.905 * th.cos(); \
        kinematic = ddot(x) + 0.5 * dot(x) - 0.3 * th; constraint_forces = [(1, 0)]; \
        run { start = ([0, 1], [1, 0]); step = 0.01; until = 3; }";
    let run = |method: &[&str]| {
        let arguments = [&["--input", "m=plan.csv", "--columns", "t,x,th,v_x,v_th"], method].concat();
        end("1,3.0\n2,0.5\n", text, &arguments)
    };
    let right = run(&["--tolerance", "1e-12"]);
    for (method, tolerance) in [
        (["--order", "2", "--step", "0.001"], 2e-4),
        (["--order", "4", "--step", "0.01"], 2e-6),
        (["--order", "6", "--step", "0.02"], 2e-7),
    ] {
        for (found, right) in run(&method).iter().zip(&right).skip(1) {
            assert!((found - right).abs() < tolerance, "{method:?}: {found} {right}");
        }
    }
}

#[test]
fn values_that_never_hold_are_told_and_no_others() {
    let text = "parameters { u = 0.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2; let held = 1 * u; external_forces = held; observe = [held]; \
        run { start = ([0.0], [0.0]); step = 0.01; until = 2; }";
    let mut random = Random::new(7);
    let mut next = || random.between(0.0, 1.0);
    let (mut warned, mut silent) = (0, 0);
    for case in 0..24 {
        let coarse = case % 3 == 0;
        let (mut plan, mut t, mut values) = (String::new(), 0.1, Vec::new());
        while t < 1.5 {
            let value = 1.0 + values.len() as f64;
            plan.extend([t.to_string(), ",".to_owned(), value.to_string(), "\n".to_owned()]);
            values.push(value);
            // some changes have nodes between them, others have none
            t += if coarse {
                0.05 + 0.1 * next()
            } else {
                0.03 * next()
            };
            t = if next() < 0.3 {
                (t * 100.0).round() / 100.0 + 0.01
            } else {
                t
            };
        }
        let method: &[&str] =
            [&["--order", "2"][..], &["--order", "4"], &["--tolerance", "1e-9"]][case / 3 % 3];
        let way: &[&str] = if case % 2 == 0 {
            &[]
        } else {
            &["--step=-0.01", "--t0", "2", "--until", "0"]
        };
        let all = [&["--input", "u=plan.csv", "--columns", "held"], method, way].concat();
        let (succeeds, [table, warnings]) = attempt_with(&[("plan.csv", plan.clone())], text, "run", &all);
        assert!(succeeds, "{plan}: {warnings}");
        let held: Vec<f64> = table.lines().skip(1).map(|line| line.parse().unwrap()).collect();
        let passed = values.iter().filter(|value| !held.contains(value)).count();
        let expected = match passed {
            0 => None,
            1 => Some("a value of the input `u` never held".to_owned()),
            _ => Some(format!("{passed} values of the input `u` never held")),
        };
        match expected {
            None => assert!(!warnings.contains("never held"), "{all:?} {plan}: {warnings}"),
            Some(expected) => assert!(
                warnings.contains(&expected),
                "{all:?} {plan}: {expected}; {warnings}"
            ),
        }
        if passed > 0 { warned += 1 } else { silent += 1 }
    }
    assert!(warned >= 8 && silent >= 4, "{warned} {silent}");
}

/// A mass that a brake stops exactly at a node, beside which the velocity is zero by rounding alone: errors are estimated beyond.
#[test]
fn errors_are_estimated_beyond_a_stop_at_a_node_of_an_input() {
    let text = "parameters { brake = 0.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = -brake * dot(x).signum(); \
        run { start = ([0], [3]); step = 0.125; until = 4; }";
    for plan in ["0.5,2\n1.5,0\n2,2\n", "0,2\n1,0\n2,2\n", "0.5,1.5\n"] {
        let files = [("plan.csv", plan.to_owned())];
        let (succeeds, [_, warnings]) = attempt_with(
            &files,
            text,
            "run",
            &["--input", "brake=plan.csv", "--estimate-error"],
        );
        assert!(
            succeeds && !warnings.contains("cannot be estimated"),
            "{plan}: {warnings}"
        );
    }
}

/// A drone that drops its load, with a thrust.
const DRONE: &str = "parameters { mass = 2.0, thrust = 0.0 } coordinates(z); lagrangian = mass / 2 * dot(z).powi(2) - mass * 9.81 * z; \
    external_forces = thrust; run { start = ([10], [3]); step = 0.01; until = 1; }";

/// An arm that is drawn in: its inertia depends on a parameter, and its momentum on a coordinate that is zero at first.
const ARM: &str = "parameters { reach = 1.0 } coordinates(x, th); lagrangian = (dot(x).powi(2) + (1 + reach.powi(2)) * dot(th).powi(2)) / 2 \
    + reach * x * dot(x) * dot(th); external_forces = (0, -0.1 * dot(th)); run { start = ([0, 0], [0.3, 1]); step = 0.01; until = 1; }";

#[test]
fn a_velocity_that_jumps_with_a_mass_is_no_step_that_is_too_long() {
    for (text, input, plan, jump) in [
        (DRONE, "mass", "0,2\n0.5,1\n", "from 2 to 1 at t = 0.5"),
        (DRONE, "mass", "0.5,8\n", "from 2 to 8 at t = 0.5"),
        (ARM, "reach", "0.5,0.2\n", "from 1 to 0.2 at t = 0.5"),
    ] {
        for method in [["--order", "2"], ["--order", "4"], ["--tolerance", "1e-10"]] {
            let option = format!("{input}=plan.csv");
            let arguments = [&["--input", &option, "--columns", "t"], &method[..]].concat();
            let (succeeds, [_, warnings]) =
                attempt_with(&[("plan.csv", plan.to_owned())], text, "run", &arguments);
            assert!(succeeds, "{warnings}");
            let said = format!("the input `{input}` changes {jump}, and the momenta depend on it");
            assert!(
                warnings.lines().count() == 1
                    && warnings.contains(&said)
                    && warnings.contains("keeps the momentum"),
                "{method:?}: {warnings}"
            );
        }
    }
    // from 3 − 9.81 · 0.5 the velocity becomes twice as large
    let (_, [_, warnings]) = attempt_with(
        &[("plan.csv", "0.5,1\n".to_owned())],
        DRONE,
        "run",
        &["--input", "mass=plan.csv"],
    );
    assert!(
        warnings.contains("of `z` jumps there from -1.9050 to -3.8100"),
        "{warnings}"
    );
}

#[test]
fn an_input_on_which_no_momentum_depends_is_not_told() {
    // a force; a mass at rest; the steering of a car, by whose change the constraint gives an impulse
    let rest = "parameters { mass = 2.0 } coordinates(x); lagrangian = mass / 2 * dot(x).powi(2); external_forces = (t - 0.7).max(0); \
        run { start = ([0], [0]); step = 0.01; until = 1; }";
    let car = "parameters { steer = 0.2 } coordinates(x, y, theta); lagrangian = 40 * (dot(x).powi(2) + dot(y).powi(2)) + 5 * dot(theta).powi(2); \
        nonholonomic = [dot(x) * theta.sin() - dot(y) * theta.cos(), dot(theta) * steer.cos() - (dot(x) * theta.cos() + dot(y) * theta.sin()) * steer.sin()]; \
        external_forces = (-1e-3 * dot(x), 0, 0); run { start = ([0, 0, 0], [1, 0, 0.2027]); project = true; step = 0.01; until = 1; }";
    for (text, input, value) in [
        (DRONE, "thrust", "5"),
        (rest, "mass", "1"),
        (car, "steer", "-1.2"),
    ] {
        for method in [["--order", "2"], ["--order", "4"], ["--tolerance", "1e-10"]] {
            let option = format!("{input}=plan.csv");
            let arguments = [&["--input", &option], &method[..]].concat();
            let plan = format!("0.5,{value}\n");
            // compositions have no constraints of velocities
            if input == "steer" && method[1] == "4" {
                continue;
            }
            let (succeeds, [_, warnings]) = attempt_with(&[("plan.csv", plan)], text, "run", &arguments);
            assert!(succeeds && warnings.is_empty(), "{input} {method:?}: {warnings}");
        }
    }
}

#[test]
fn a_stiff_contact_is_told_beside_a_mass_that_changes() {
    let text = "parameters { mass = 1.0 } coordinates(x); lagrangian = mass * dot(x).powi(2) / 2 - 9.81 * mass * x; external_forces = 1e6 * (-x).max(0); \
        run { start = ([1], [0]); step = 0.01; until = 1; }";
    let plan = "0.2,1.5\n0.44,1.6\n0.45,1.7\n0.46,1.8\n".to_owned();
    let (_, [_, warnings]) = attempt_with(&[("plan.csv", plan)], text, "run", &["--input", "mass=plan.csv"]);
    let told = ["a force changes there too fast", "the energy grows"];
    assert!(
        told.iter().any(|told| warnings.contains(told)) && warnings.contains("the momenta depend on it"),
        "{warnings}"
    );
}
