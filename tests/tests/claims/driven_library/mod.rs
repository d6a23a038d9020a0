//! The systems of the library with time or external forces: each against a closed form, an invariant or
//! equations by hand.

mod arm;
mod friction;
mod kapitza;
mod quaternion_top;
mod train;
mod vehicle;

use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{Flow, Node, Start, Stepper, System};
use dsocs_tests::fit::slope;

/// The node of the continuous motion at a time.
fn continuous<S: System<N>, const N: usize>(system: &S, start: Start<N>, t: f64) -> Node<N> {
    let mut flow = TaylorFlow::new(system, start, Tolerance::relative(1e-15)).unwrap();
    flow.to(t).unwrap()
}

/// The node of the discrete motion at a time.
fn discrete<S: System<N>, const N: usize>(system: &S, start: Start<N>, h: f64, t: f64) -> Node<N> {
    Flow::new(system, h, start).unwrap().to(t).unwrap()
}

/// The largest difference of components.
fn distance<const N: usize>(x: &[f64; N], y: &[f64; N]) -> f64 {
    let apart = x.iter().zip(y).map(|(x, y)| (x - y).abs());
    apart.fold(0.0, |largest, x| if x <= largest { largest } else { x })
}

/// Fits the order of an error and asserts that it is two.
fn is_second<const K: usize>(name: &str, steps: [f64; K], error: impl Fn(f64) -> f64) {
    let errors = steps.map(error);
    let order = slope(&steps, &errors);
    println!("{name}: order {order:.4}, errors {errors:?}");
    assert!((order - 2.0).abs() < 0.05, "{name}: {order}, {errors:?}");
}
