//! In a step of thousands of operations, equal sequences of operations are compiled to loops. The result has
//! the bits of the tape, which executes each operation by itself.

use dsocs_core::Leg;
use dsocs_tests::tape;

dsocs_systems::planar_chain! {
    /// Enough links for the step to have loops.
    #[derive(Clone, Debug)]
    pub(crate) struct PlanarChain26; 26
}

#[test]
fn code_and_tape_of_a_step_with_loops_agree() {
    let chain = PlanarChain26 {
        masses: core::array::from_fn(|i| 1.0 + 0.3 * i as f64),
        lengths: core::array::from_fn(|i| 0.5 + 0.1 * (i as f64).sin()),
        gravity: 9.81,
    };
    let leg = Leg {
        t: 0.0,
        q: core::array::from_fn(|i| 0.7 * (1.3 * i as f64).sin()),
        d: core::array::from_fn(|i| 1e-3 * (i as f64).cos()),
    };
    let e = core::array::from_fn(|i| 1e-5 * (2.0 * i as f64).cos());
    tape::same_bits(&chain, 1e-2, &leg, &e, &[]).unwrap();
}
