//! The errors against the exact motion are those of the reference's tables, to four digits; so are their slopes.

use dsocs_core::{Flow, Start, Stepper, System};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum};
use dsocs_tests::closed_form::{self, pendulum::START};
use dsocs_tests::data::Table;
use dsocs_tests::fit;

/// The rows of a table that belong to one start: steps and errors.
fn rows(table: &Table, start: &str, error: &str) -> (Vec<f64>, Vec<f64>) {
    let rows = table
        .text("start")
        .into_iter()
        .zip(table.numbers("h"))
        .zip(table.numbers(error));
    rows.filter(|((name, _), _)| *name == start)
        .map(|((_, h), error)| (h, error))
        .unzip()
}

/// The largest error of coordinate 0 at the nodes from 0 to `steps` that are multiples of `every`.
fn largest_error<S: System<2>>(
    system: &S,
    h: f64,
    start: Start<2>,
    steps: u64,
    every: u64,
    exact: impl Fn(u64) -> f64,
) -> f64 {
    let mut flow = Flow::new(system, h, start).unwrap();
    let mut largest = 0.0_f64;
    loop {
        let k = flow.index();
        if k.is_multiple_of(every) {
            largest = largest.max((flow.position()[0] - exact(k)).abs());
        }
        if k == steps {
            return largest;
        }
        flow.advance().unwrap();
    }
}

fn steps(until: f64, h: f64) -> u64 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small whole number
    let steps = (until / h).round() as u64;
    steps
}

fn compare(computed: &[f64], table: &[f64], h: &[f64]) {
    for ((computed, table), h) in computed.iter().zip(table).zip(h) {
        println!("h = {h}: {computed:.7e}, in the table {table:.7e}");
        assert!(
            fit::agree(*computed, *table, 4),
            "h = {h}: {computed:e} instead of {table:e}"
        );
    }
}

fn particle(name: &str, start: Start<2>) -> (Vec<f64>, Vec<f64>) {
    let (h, table) = rows(&Table::read("particle_errors.csv"), name, "max_err_x");
    assert_eq!(h.len(), 7);
    let system = CurvedParticle::default();
    let error = |&h: &f64| {
        let exact = |k: u64| closed_form::particle(k as f64 * h)[0];
        largest_error(&system, h, start, steps(500.0, h), 1, exact)
    };
    let errors: Vec<f64> = h.iter().map(error).collect();
    compare(&errors, &table, &h);
    (h, errors)
}

#[test]
fn of_the_particle_with_the_papers_start() {
    let (h, errors) = particle("paper", Start::paper([0.0, 0.0], [1.0, 1.0]));
    let slope = fit::slope(&h, &errors);
    println!("slope {slope}");
    assert!((slope - 1.61).abs() <= 0.01, "slope {slope}");
}

#[test]
fn of_the_particle_with_the_second_order_start() {
    let (h, errors) = particle("second_order", Start::second_order([0.0, 0.0], [1.0, 1.0]));
    let slopes = fit::local_slopes(&h, &errors);
    println!("local slopes {slopes:.4?}");
    for slope in &slopes[2..] {
        assert!((slope - 2.0).abs() <= 1e-3, "local slopes {slopes:?}");
    }
}

fn pendulum(name: &str, start: Start<2>) -> (Vec<f64>, Vec<f64>) {
    // the exact motion is kept at whole seconds only, and the table has a column for them
    let (h, table) = rows(
        &Table::read("pendulum_errors.csv"),
        name,
        "max_err_theta_integer_t",
    );
    assert_eq!(h.len(), 5);
    let theta = Table::read("pendulum_continuous_every1.csv").numbers("theta");
    let system = InertiaWheelPendulum::default();
    let error = |&h: &f64| {
        let second = steps(1.0, h);
        let exact = |k: u64| theta[usize::try_from(k / second).unwrap()];
        largest_error(&system, h, start, steps(2000.0, h), second, exact)
    };
    let errors: Vec<f64> = h.iter().map(error).collect();
    compare(&errors, &table, &h);
    (h, errors)
}

#[test]
fn of_the_pendulum_with_the_papers_start() {
    pendulum("paper", Start::paper(START.0, START.1));
}

#[test]
fn of_the_pendulum_with_the_second_order_start() {
    let (h, errors) = pendulum("second_order", Start::second_order(START.0, START.1));
    let slopes = fit::local_slopes(&h, &errors);
    println!("local slopes {slopes:.4?}");
    let last = slopes.last().unwrap();
    assert!((last - 2.0).abs() <= 1e-3, "local slopes {slopes:?}");
}
