//! The pendulum with the discrete law `ΔV = -h F` for its Lyapunov function `V`: exact in every step, until
//! no step solves it.

use dsocs_core::{Flow, Leg, RunError, Start, Stepper};
use dsocs_systems::{ExactDecrease, InertiaWheelPendulum};

use super::{continuous, order, start};
use dsocs_tests::motion::distance;

/// `V` on a leg, at its middle.
fn lyapunov(h: f64, leg: &Leg<f64, 2>) -> f64 {
    let middle = core::array::from_fn(|i| leg.q[i] - leg.d[i] / 2.0);
    InertiaWheelPendulum::default().lyapunov(middle, leg.d.map(|d| d / h))
}

/// Runs as far as possible and measures in every step by how much the decrease of `V` differs from `h F`.
/// Returns the time that was reached, the value of `V` there, the largest deviation relative to `V`, and the
/// error at the end.
fn run(h: f64, until: f64) -> (f64, f64, f64, Option<RunError>) {
    let pendulum = ExactDecrease::default();
    let (q, v) = start("exact-decrease");
    let mut flow = Flow::new(&pendulum, h, Start::second_order(q, v)).unwrap();
    let (mut before, mut worst, mut error) = (lyapunov(h, &flow.leg()), 0.0_f64, None);
    while flow.time() < until - h / 2.0 {
        if let Err(ended) = flow.advance() {
            error = Some(ended);
            break;
        }
        let node = flow.node();
        let dissipation = InertiaWheelPendulum::default().dissipation(node.q, node.v);
        let after = lyapunov(h, &flow.leg());
        assert!(dissipation >= 0.0);
        worst = worst.max((after - before + h * dissipation).abs() / before);
        before = after;
    }
    println!(
        "h = {h}: t = {}, V = {before}, missed by {worst:.1e} of V",
        flow.time()
    );
    (flow.time(), before, worst, error)
}

#[test]
fn the_lyapunov_function_falls_exactly_up_to_the_first_switch() {
    // w, the motor's power over V, first passes through zero at about t = 29
    for h in [0.1, 0.05, 0.02, 0.01, 0.005, 0.002] {
        let (reached, _, worst, error) = run(h, 28.0);
        assert!(error.is_none() && reached > 27.9, "h = {h}: {error:?}");
        assert!(worst < 1e-11, "h = {h}: {worst:e}");
    }
}

#[test]
fn large_steps_end_at_the_switch_and_a_small_one_passes_it() {
    for h in [0.1, 0.05, 0.02, 0.01] {
        let (reached, _, _, error) = run(h, 60.0);
        assert!(
            error.is_some() && (28.0..30.0).contains(&reached),
            "h = {h}: {reached}"
        );
    }
    let (reached, value, worst, error) = run(0.001, 60.0);
    assert!(
        error.is_none() && worst < 1e-10,
        "{reached}: {error:?}, {worst:e}"
    );
    let (q, v) = continuous(&InertiaWheelPendulum::default(), start("exact-decrease"), 60.0);
    let exact = InertiaWheelPendulum::default().lyapunov(q, v);
    println!("V = {value}, exactly {exact}");
    assert!((value / exact - 1.0).abs() < 1e-2, "{value} {exact}");
}

#[test]
fn it_comes_near_to_the_papers_pendulum_with_the_second_order() {
    let start = start("exact-decrease");
    let (exact, _) = continuous(&InertiaWheelPendulum::default(), start, 10.0);
    let steps = [0.04, 0.02, 0.01, 0.005, 0.0025];
    let order = order(&ExactDecrease::default(), start, 10.0, &steps, |q| {
        distance(q, &exact)
    });
    assert!((order - 2.0).abs() < 0.05, "{order}");
}
