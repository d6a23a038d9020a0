//! Where motions end, discrete and continuous ones, and how far that is from where they should.

use dsocs_core::{Node, Start, Stepper as _, Tolerance};

use crate::fit::order;
use crate::text::{Flow, System, TaylorFlow};

/// The steps of a fit of the order.
pub const STEPS: [f64; 5] = [0.04, 0.02, 0.01, 0.005, 0.0025];

/// The last node of the discrete motion.
///
/// # Panics
///
/// If the motion cannot be computed.
pub fn discrete<S: System<N>, const N: usize>(system: &S, h: f64, start: Start<N>, until: f64) -> Node<N> {
    let ended = Flow::new(system, h, start).unwrap().to(until);
    ended.unwrap_or_else(|error| panic!("h = {h}: {error}"))
}

/// The node of the continuous motion at a time.
///
/// # Panics
///
/// If the motion cannot be computed.
pub fn continuous<S: System<N>, const N: usize>(system: &S, start: Start<N>, t: f64) -> Node<N> {
    let mut flow = TaylorFlow::new(system, start, Tolerance::relative(1e-15)).unwrap();
    flow.to(t).unwrap()
}

/// The largest difference of components; NaN if one is.
#[must_use]
pub fn distance(x: &[f64], y: &[f64]) -> f64 {
    let apart = x.iter().zip(y).map(|(x, y)| (x - y).abs());
    apart.fold(0.0, |largest, x| if x <= largest { largest } else { x })
}

/// Fits the order of an error over [`STEPS`] and asserts that it is two.
///
/// # Panics
///
/// If it is not.
#[track_caller]
pub fn assert_second_order(name: &str, error: impl Fn(f64) -> f64) {
    let order = order(name, &STEPS, error);
    assert!((order - 2.0).abs() < 0.02, "{name}: {order}");
}

/// Compares a system with a known position: the Taylor flow to rounding, the step to order 2.
///
/// # Panics
///
/// If they differ by more.
#[track_caller]
pub fn assert_position<S: System<N>, const N: usize>(
    name: &str,
    system: &S,
    start: Start<N>,
    until: f64,
    known: &[f64; N],
    rounding: f64,
) {
    let apart = distance(&continuous(system, start, until).q, known);
    println!("{name}: Taylor flow {apart:.1e}");
    assert!(apart < rounding, "{name}: {apart:e}");
    assert_second_order(name, |h| distance(&discrete(system, h, start, until).q, known));
}
