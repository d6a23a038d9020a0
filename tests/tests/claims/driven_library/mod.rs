//! The systems of the library with time or external forces: each against a closed form, an invariant or
//! equations by hand.

mod arm;
mod friction;
mod kapitza;
mod quaternion_top;
mod train;
mod vehicle;

use dsocs_tests::fit::order;

/// Fits the order of an error and asserts that it is two.
fn is_second<const K: usize>(name: &str, steps: [f64; K], error: impl Fn(f64) -> f64) {
    let order = order(name, &steps, error);
    assert!((order - 2.0).abs() < 0.05, "{name}: {order}");
}
