//! Random draws, equal in every run. The code of proptest is compiled once for each kind of draw, not for
//! every system.

use core::fmt::Debug;

use dsocs_tests::short_or_long;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestCaseResult, TestRunner};

/// Runs a property on `cases` draws in the long form of the tests, and on a quarter of them in the short one.
pub fn test<T: Debug + 'static>(
    cases: u32,
    seed: u64,
    draws: impl Strategy<Value = T> + 'static,
    test: &dyn Fn(T) -> TestCaseResult,
) {
    let config = Config {
        cases: short_or_long(cases.div_ceil(4), cases),
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(seed),
        ..Config::default()
    };
    if let Err(error) = TestRunner::new(config).run(&draws.boxed(), test) {
        panic!("{error}");
    }
}

/// A vector of `N` components from one distribution.
pub fn vector<const N: usize>(component: impl Strategy<Value = f64> + 'static) -> BoxedStrategy<Vec<f64>> {
    prop::array::uniform::<_, N>(component)
        .prop_map(|vector| vector.to_vec())
        .boxed()
}

/// A vector as an array of `N` components.
pub fn sized<const N: usize>(vector: &[f64]) -> [f64; N] {
    let mut sized = [f64::NAN; N];
    sized.copy_from_slice(vector);
    sized
}
