//! Estimated errors, and the message where they cannot be estimated.

use super::run;

/// The number that follows these words.
fn number_after(stderr: &str, words: &str) -> f64 {
    let rest = stderr
        .split(words)
        .nth(1)
        .unwrap_or_else(|| panic!("{words}: {stderr}"));
    let number: String = rest
        .chars()
        .take_while(|c| c.is_ascii_digit() || "e.-".contains(*c))
        .collect();
    number.parse().unwrap_or_else(|_| panic!("{words}: {stderr}"))
}

#[test]
fn beside_a_corner_that_hides_in_an_angle_or_a_root_errors_are_estimated() {
    for lagrangian in [
        "dot(u).powi(2) / 2 - u.sin().asin().powi(2) / 2",
        "dot(u).powi(2) / 2 - (1 - u.cos().powi(2)).sqrt()",
    ] {
        let text = format!(
            "coordinates(u); lagrangian = {lagrangian}; run {{ start = ([1], [1.5]); step = 0.01; until = 10; }}"
        );
        let (stderr, last) = run(&text, &["--tolerance", "1e-9", "--estimate-error"]);
        let error: f64 = last.rsplit(',').next().unwrap().parse().unwrap();
        assert!(error > 1e-13 && error < 1e-7, "{text}: {last}");
        assert!(number_after(&stderr, "is known to ") < 1e-9, "{text}: {stderr}");
        assert!(!stderr.contains("cannot be estimated"), "{text}: {stderr}");
    }
}

/// Where the continuous motion ends at a corner, the run goes on without estimates, and the note gives the
/// time up to which errors are known.
#[test]
fn where_the_continuous_motion_ends_the_run_goes_on_without() {
    // a bead on a wire with a corner
    let text = "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; holonomic = y - 0.5 * x.abs(); \
        run { start = ([-1, 0.5], [1, -0.5]); step = 0.01; until = 2; }";
    let (stderr, last) = run(text, &["--estimate-error"]);
    assert!(last.starts_with("2,") && last.ends_with(",,"), "{last}");
    assert!(
        stderr.contains("the largest errors up to t = ")
            && stderr.contains("beyond, the errors cannot be estimated: "),
        "{stderr}"
    );
    let reached = number_after(&stderr, "up to t = ");
    assert!(reached > 0.9 && reached <= 1.0, "{stderr}");
}

#[test]
fn errors_are_known_to_no_less_than_rounding_tells() {
    for until in [1.0, 10.0, 100.0] {
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; run {{ start = ([1], [0]); step = 0.01; until = {until}; }}"
        );
        let (stderr, last) = run(&text, &["--tolerance", "1e-15", "--estimate-error"]);
        let values: Vec<f64> = last.split(',').map(|value| value.parse().unwrap()).collect();
        let real = (values[1] - values[0].cos()).abs();
        let known = number_after(&stderr, "is known to ");
        assert!(
            known >= 0.5 * real && known > 1e-16 * until,
            "{until}: {real:e}: {stderr}"
        );
        assert!(known < 1e-15 * (1.0 + until), "{until}: {stderr}");
    }
}
