//! What a path keeps in memory: all of its steps, or some states of the run (checkpoints), from which the steps between them are computed again.

use super::block::Recorded;
use super::error::DerivativeError;
use crate::flow::Flow;
use crate::run::Stepper as _;
use crate::system::System;
use crate::tape::Eight;

/// Some consecutive steps.
#[derive(Clone, Debug)]
pub(super) struct Kept<const N: usize> {
    /// The number of the first one's middle node, from 1 on.
    pub first: usize,
    /// The steps.
    pub steps: Vec<Recorded<N>>,
    /// Their unknowns, one step after the other.
    pub unknowns: Vec<f64>,
}

impl<const N: usize> Kept<N> {
    /// No steps yet, but memory for `count` steps with `unknowns` unknowns each.
    pub fn from(first: usize, count: usize, unknowns: usize) -> Self {
        Self {
            first,
            steps: Vec::with_capacity(count),
            unknowns: Vec::with_capacity(count * unknowns),
        }
    }

    /// The number of the middle node of the step that would follow.
    pub fn end(&self) -> usize {
        self.first + self.steps.len()
    }

    /// Keeps the last step of a flow.
    #[inline]
    pub fn keep<S: System<N>>(&mut self, flow: &Flow<'_, S, N>) {
        if let Some((leg, e, z)) = flow.last_step() {
            self.steps.push(Recorded { leg, e });
            self.unknowns.extend_from_slice(z.as_ref());
        }
    }
}

/// The checkpoints: states of a run from which its steps are computed again.
pub(super) struct Checkpoints<'s, S: System<N>, const N: usize> {
    /// How many steps lie between two checkpoints. It is a multiple of [`Eight::COUNT`], so that steps are evaluated in the same blocks as if all
    /// were kept.
    pub every: usize,
    /// The states. The first one is that before the first step.
    states: Vec<Flow<'s, S, N>>,
}

impl<'s, S: System<N>, const N: usize> Checkpoints<'s, S, N> {
    /// No checkpoints: all steps are kept.
    pub fn none() -> Self {
        Self {
            every: usize::MAX,
            states: Vec::new(),
        }
    }

    /// For `count` steps of `bytes` bytes each. If all of them fit into `memory` bytes, all are kept. Otherwise checkpoints are kept, at the distance
    /// for which the checkpoints and the steps between two of them take the least memory together.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a square root of what memory can hold
    pub fn new(count: usize, bytes: usize, memory: usize) -> Self {
        if count.saturating_mul(bytes) <= memory {
            return Self::none();
        }
        let best = (count as f64 * size_of::<Flow<'s, S, N>>() as f64 / bytes as f64).sqrt();
        let every = (best as usize).next_multiple_of(Eight::COUNT).max(Eight::COUNT);
        Self {
            every,
            states: Vec::with_capacity(count / every + 1),
        }
    }

    /// Whether checkpoints are kept, not all steps.
    pub fn are_kept(&self) -> bool {
        self.every != usize::MAX
    }

    /// Keeps the state of a flow after `steps` steps, if a checkpoint is due there. Returns whether it is.
    #[inline]
    pub fn keep(&mut self, flow: &Flow<'s, S, N>, steps: usize) -> bool {
        let is_due = self.are_kept() && steps.is_multiple_of(self.every);
        if is_due {
            self.states.push(flow.clone());
        }
        is_due
    }

    /// Computes the steps behind the checkpoint number `window` again. The path has `count` steps in all.
    pub fn again(&self, window: usize, count: usize) -> Result<Kept<N>, DerivativeError> {
        let before = window * self.every;
        let own = self.every.min(count.saturating_sub(before));
        let mut kept = Kept::from(before + 1, own, 0);
        let Some(state) = self.states.get(window) else {
            return Ok(kept);
        };
        let mut flow = state.clone();
        for _ in 0..own {
            flow.step(f64::INFINITY)?;
            kept.keep(&flow);
        }
        Ok(kept)
    }
}
