//! Messages of runs with a constraint of third order: singularities and jumps of the jerk, and none for
//! regular motions.

/// Whether a command succeeds on a text; and its standard output and standard error.
fn attempt(text: &str, arguments: &[&str]) -> (bool, [String; 2]) {
    super::attempt(text, arguments[0], &arguments[1..])
}

/// One coordinate with a row that prescribes its jerk.
fn alone(row: &str, start: &str) -> String {
    format!(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; kinematic = {row}; constraint_forces = [(1,)]; \
         run {{ start = {start}; step = 0.01; until = 2.0; }}"
    )
}

/// A mass on a spring, and a second coordinate whose row contains the first.
fn beside(statements: &str, acceleration: f64) -> String {
    format!(
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.powi(2) / 2; {statements} \
         constraint_forces = [(0, 1)]; run {{ start = ([1.0, 0.0], [0.0, 0.0]); acceleration = [{acceleration}, 0.0]; step = 0.01; until = 5.0; }}"
    )
}

/// The row of a servo that follows a target.
fn servo(target: &str) -> String {
    format!("kinematic = dddot(y) + 3 * ddot(y) + 3 * dot(y) + y - {target};")
}

/// A cart-pole whose tip has a prescribed jerk; at 45 degrees the cart cannot control it.
const POLE: &str = "coordinates(x, theta); \
    lagrangian = dot(x).powi(2) + dot(x) * dot(theta) * theta.cos() + dot(theta).powi(2) / 2 - 9.81 * theta.cos(); \
    kinematic = dddot(x + 2 * theta.sin()) - 0.5; constraint_forces = [(1, 0)]; \
    run { start = ([0.0, 1.2], [0.0, -1.5]); step = 0.01; until = 3.0; }";

/// Steps from 0.01 to less than 0.001, none of which divides another.
fn steps(count: i32) -> impl Iterator<Item = String> {
    (0..count).map(move |k| format!("{:.6}", 0.01 * 0.05_f64.powf(f64::from(k) / f64::from(count))))
}

#[test]
fn a_run_does_not_pass_the_singularity_of_its_law() {
    let laws = [
        (beside("kinematic = x * dddot(y) - 1;", -1.0), None),
        (
            alone("(1 - x) * dddot(x) - 1", "([0.0], [1.0]); acceleration = [0.0]"),
            None,
        ),
        (
            beside("kinematic = (dot(x) + 0.3) * dddot(y) - 1 - y;", -1.0),
            None,
        ),
        (POLE.to_owned(), Some("--f0")),
    ];
    for (text, force) in &laws {
        for step in steps(20) {
            let mut arguments = vec!["run", "--step", &step];
            arguments.extend(force.iter().flat_map(|force| [*force, "0,0"]));
            let (succeeds, [_, stderr]) = attempt(text, &arguments);
            let ends = stderr.contains("the equations become singular")
                && stderr.contains("where the jerk grows without bound");
            let asks = force.is_some() && stderr.contains("there are two solutions");
            assert!(!succeeds && (ends || asks), "{text} {step}: {stderr}");
        }
    }
}

#[test]
fn a_pole_of_the_row_is_told() {
    let poles = [
        alone("dddot(x) - 1 / (1 - x)", "([0.0], [1.0]); acceleration = [0.0]"),
        alone("dddot(x) - 1 / (1 - t)", "([0.0], [1.0]); acceleration = [0.0]"),
    ];
    for text in &poles {
        for step in steps(20) {
            let (succeeds, [_, stderr]) = attempt(text, &["run", "--step", &step]);
            assert!(
                !succeeds || stderr.contains("a force is infinite"),
                "{text} {step}: {stderr}"
            );
            assert!(!stderr.contains("--tolerance"), "{stderr}");
        }
    }
}

#[test]
fn a_jump_of_the_jerk_is_told() {
    let rest = "([0.0], [0.0]); acceleration = [0.0]";
    let jumps = [
        alone("dddot(x) - (if t < 0.73111 { 1 } else { -2 })", rest),
        alone("dddot(x) + 3 * (x - 0.50117).signum()", rest),
        alone("dddot(x) - (if ddot(x) < 0.50311 { 1 } else { 0.2 })", rest),
        alone(
            "dddot(x) - (if (t - 1.00312).abs() < 0.00007 { 50 } else { 0 })",
            rest,
        ),
        beside(&servo("(if x > 0.2 { 1 } else { 0.5 })"), -1.0),
        beside(
            &format!(
                "external_forces = (if x > 0.3 {{ 0 }} else {{ 0.5 }}, 0); {}",
                servo("x.sin()")
            ),
            -1.0,
        ),
        beside(
            &format!(
                "external_forces = (-0.15 * dot(x).signum(), 0); {}",
                servo("x.sin()")
            ),
            -0.85,
        ),
    ];
    for text in &jumps {
        for step in steps(12) {
            let (succeeds, [_, stderr]) = attempt(text, &["run", "--step", &step]);
            assert!(
                succeeds && stderr.contains("of the first order"),
                "{text} {step}: {stderr}"
            );
            assert!(
                !stderr.contains("--tolerance") && !stderr.contains("--estimate-error"),
                "{stderr}"
            );
        }
    }
    // then the checks of the whole motion are excused
    let (succeeds, [table, stderr]) = attempt(&jumps[0], &["check"]);
    assert!(succeeds && !table.contains("FAILED"), "{table}{stderr}");
    assert!((table + &stderr).contains("not required here"));
}

#[test]
fn right_motions_are_not_warned_of() {
    let rest = "([0.0], [0.0]); acceleration = [0.0]";
    let right = [
        beside(&servo("x.sin()"), -1.0),
        beside(&servo("(x - 0.2).abs()"), -1.0),
        beside(&servo("x * x.abs()"), -1.0),
        beside(
            "kinematic = (1.1 + x.sin()) * dddot(y) + 3 * ddot(y) + 3 * dot(y) + y;",
            -1.0,
        ),
        beside(
            &format!("external_forces = (-(x - 0.3).abs(), 0); {}", servo("x.sin()")),
            -1.7,
        ),
        beside(
            &format!(
                "external_forces = (-0.2 * dot(x) * dot(x).abs(), 0); {}",
                servo("x.sin()")
            ),
            -1.0,
        ),
        alone("dddot(x) - 1 + (ddot(x) - 0.503).abs()", rest),
        alone("dddot(x) - t.sin() + x.cosh() - 1", rest),
    ];
    for text in &right {
        for step in steps(12) {
            let (succeeds, [_, stderr]) = attempt(text, &["run", "--step", &step]);
            assert!(succeeds && stderr.is_empty(), "{text} {step}: {stderr}");
        }
    }
    // a jerk that jumps at nodes: a leg takes the jerk at its middle
    let pulse = alone("dddot(x) - (if t < 0.5 { 1 } else { -2 })", rest);
    for step in ["0.01", "0.0025"] {
        let (succeeds, [table, stderr]) = attempt(&pulse, &["run", "--step", step, "--until", "1"]);
        let end: f64 = table
            .lines()
            .last()
            .unwrap()
            .split(',')
            .nth(1)
            .unwrap()
            .parse()
            .unwrap();
        // the exact position: 1/48 + 1/16 + 1/16 - 1/24
        let h: f64 = step.parse().unwrap();
        assert!(
            succeeds && stderr.is_empty() && (end - 5.0 / 48.0).abs() < h * h,
            "{end} {stderr}"
        );
    }
}

#[test]
fn a_certified_run_says_nothing_of_the_step_that_the_start_makes() {
    let (succeeds, [_, stderr]) = attempt(&beside(&servo("x.sin()"), -1.0), &["run", "--certify"]);
    assert!(succeeds && stderr.is_empty(), "{stderr}");
}

#[test]
fn friction_at_a_start_has_the_side_to_which_the_motion_leaves() {
    let text = |acceleration: f64| {
        format!(
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.powi(2); \
             external_forces = (-0.4 * (dot(x) - 0.1 * t).signum(), 0); {} constraint_forces = [(0, 1)]; \
             run {{ start = ([1.0, 0.0], [0.0, 0.0]); acceleration = [{acceleration}, 0.0]; step = 0.01; until = 0.5; }}",
            servo("x.sin()")
        )
    };
    let there = 0.2 + 0.8 * (0.5 * 2.0_f64.sqrt()).cos();
    for arguments in [&["run"][..], &["run", "--f0", "0,0"]] {
        let (succeeds, [table, stderr]) = attempt(&text(-1.6), arguments);
        let [first, last] = [1, 51].map(|row| table.lines().nth(row).unwrap().to_owned());
        let number = |line: &str, place: usize| line.split(',').nth(place).unwrap().parse::<f64>().unwrap();
        assert!(succeeds && stderr.is_empty(), "{stderr}");
        assert!((number(&last, 1) - there).abs() < 1e-4, "{last}");
        assert!(number(&first, 5).abs() < 1e-6, "{first}");
    }
    // the acceleration of the other side is refused
    let (succeeds, [_, stderr]) = attempt(&text(-2.4), &["run"]);
    assert!(!succeeds && stderr.contains("the start violates"), "{stderr}");
}
