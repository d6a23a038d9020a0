//! What a block of an ensemble takes over from a flow, and gives back to it.

use crate::compensated::Compensated;
use crate::flow::Flow;
use crate::step::predictor::Predictor;
use crate::system::System;

/// What the next step of a flow depends on, beside its system and `h`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<U, const N: usize> {
    /// The last node.
    pub q: Compensated<N>,
    /// The increment that led to it.
    pub d: Compensated<N>,
    /// The past solutions.
    pub predictor: Predictor<U>,
}

impl<S: System<N>, const N: usize> Flow<'_, S, N> {
    /// What the next step depends on.
    pub(crate) fn state(&self) -> State<S::Unknown<f64>, N> {
        State {
            q: self.q,
            d: self.d,
            predictor: self.predictor,
        }
    }

    /// The number of the position at which the past begins that steps go on from.
    pub(crate) fn since(&self) -> u64 {
        self.since
    }

    /// Goes on from the step with the middle node `index`, which the flow has not gone to by itself.
    pub(crate) fn resume(&mut self, index: u64, state: State<S::Unknown<f64>, N>) {
        (self.q, self.d, self.predictor) = (state.q, state.d, state.predictor);
        self.clock.jump(index - 1);
        self.solved = None;
    }
}
