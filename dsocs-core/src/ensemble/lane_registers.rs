//! The state of a block between steps, in registers.

// loaded into registers and stored in code that is compiled for them, see [`crate::number::instructions`]
#![allow(clippy::inline_always)]

use super::determinants::Determinants;
use super::lane_state::LaneState;
use crate::number::compensated::Compensated;
use crate::number::lanes::{Lanes, Mask, Register};
use crate::number::scalar::Scalar;
use crate::solve::predictor::Differences;
use crate::solve::unknown::Unknown;
use crate::tape::Eight;

/// The state between steps.
#[derive(Clone, Copy)]
pub(super) struct LaneRegisters<U, R, const N: usize> {
    /// The last nodes.
    pub q: Compensated<N, Lanes<R>>,
    /// The increments that led to them.
    pub d: Compensated<N, Lanes<R>>,
    /// The past solutions.
    pub predictor: Differences<U, Lanes<R>>,
    /// The determinants at these solutions.
    pub determinants: Determinants<R>,
    /// The natural sizes of the unknowns.
    natural: Natural<U, R>,
}

/// The result of a step.
#[derive(Clone, Copy)]
pub(super) struct StepResult<U, R, const N: usize> {
    /// The third nodes.
    pub q: Compensated<N, Lanes<R>>,
    /// The increments that lead to them.
    pub d: Compensated<N, Lanes<R>>,
    /// The solutions.
    pub z: U,
}

/// The natural sizes of the unknowns (see [`RetainedSizes`](crate::solve::convergence::RetainedSizes)), in the lanes where recent steps
/// needed them.
#[derive(Clone, Copy)]
pub(super) struct Natural<U, R> {
    /// The lanes, as bits.
    pub known: u32,
    /// The part of the sizes that is used.
    pub part: U,
    /// The inverse of the sizes.
    pub inverse: U,
    /// The largest ratio of an unknown to its natural size.
    pub level: Lanes<R>,
}

impl<R: Register, U: AsRef<[Lanes<R>]>> Natural<U, R> {
    /// Expected sizes, raised to the natural ones, for recent sizes `lately` of the unknowns.
    #[inline(always)]
    pub fn raise<Z: AsMut<[Lanes<R>]>>(&self, sizes: Z, lately: impl Iterator<Item = Lanes<R>>) -> Z {
        if self.known == 0 {
            return sizes;
        }
        let mut level = Lanes::splat(0.0);
        for (z, &inverse) in lately.zip(self.inverse.as_ref()) {
            level = level.larger(z.abs() * inverse);
        }
        let grown = level.larger(Lanes::splat(1.0));
        let factor = Lanes::select_lt(level, self.level, level / self.level, grown);
        let known = Mask::from_bits(self.known);
        let mut raised = sizes;
        for (size, &part) in raised.as_mut().iter_mut().zip(self.part.as_ref()) {
            *size = known.select(size.larger(factor * part), *size);
        }
        raised
    }
}

impl<R: Register, U: Unknown<Lanes<R>>, const N: usize> LaneRegisters<U, R, N> {
    /// No past.
    #[inline(always)]
    fn new() -> Self {
        let zero = Compensated::exact([Lanes::splat(0.0); N]);
        Self {
            q: zero,
            d: zero,
            predictor: Differences::new(),
            determinants: Determinants::new(),
            natural: Natural {
                known: 0,
                part: U::zero(),
                inverse: U::zero(),
                level: Lanes::splat(0.0),
            },
        }
    }

    /// The expected size of each unknown: its recent one, at least `least`, and at least its natural one.
    #[inline(always)]
    pub fn expected(&self, least: &U) -> U {
        let lately = self.predictor.size();
        self.natural
            .raise(lately.zip(least, Scalar::larger), lately.as_ref().iter().copied())
    }

    /// Commits a step.
    #[inline(always)]
    pub fn take(&mut self, found: &StepResult<U, R, N>) {
        (self.q, self.d) = (found.q, found.d);
        self.predictor.push_here(&found.z);
        self.determinants.push();
    }

    /// The state, loaded into registers.
    #[inline(always)]
    pub fn load(lane_state: &LaneState) -> Self {
        let mut now = Self::new();
        // there may be no unknowns
        let m = now.predictor.size().as_ref().len().max(1);
        let sums = [&mut now.q.hi, &mut now.q.lo, &mut now.d.hi, &mut now.d.lo];
        for (to, from) in sums.into_iter().zip(lane_state.sums.chunks_exact(N)) {
            load(to, from);
        }
        for (to, from) in now.predictor.vectors_mut().zip(lane_state.past.chunks_exact(m)) {
            load(to.as_mut(), from);
        }
        now.determinants = lane_state.determinants.moved();
        now.natural.known = lane_state.known;
        let natural = [&mut now.natural.part, &mut now.natural.inverse];
        for (to, from) in natural.into_iter().zip(lane_state.natural.chunks_exact(m)) {
            load(to.as_mut(), from);
        }
        now.natural.level = lane_state.level.0.into();
        now
    }

    /// Stores the state; natural sizes do not change in a step.
    #[inline(always)]
    pub fn store(&self, lane_state: &mut LaneState) {
        // there may be no unknowns
        let m = self.predictor.size().as_ref().len().max(1);
        let sums = [&self.q.hi, &self.q.lo, &self.d.hi, &self.d.lo];
        for (to, from) in lane_state.sums.chunks_exact_mut(N).zip(sums) {
            store(to, from);
        }
        for (to, from) in lane_state.past.chunks_exact_mut(m).zip(self.predictor.vectors()) {
            store(to, from.as_ref());
        }
        lane_state.determinants = self.determinants.moved();
    }
}

impl<R: Register, U: Unknown<Lanes<R>>, const N: usize> StepResult<U, R, N> {
    /// Stores the step as held back.
    #[inline(always)]
    pub fn store(&self, lane_state: &mut LaneState) {
        let sums = [&self.q.hi, &self.q.lo, &self.d.hi, &self.d.lo];
        let (to, z) = lane_state.found.split_at_mut(4 * N);
        for (to, from) in to.chunks_exact_mut(N).zip(sums) {
            store(to, from);
        }
        store(z, self.z.as_ref());
    }
}

/// Loads numbers into registers.
#[inline(always)]
pub(super) fn load<R: Register>(to: &mut [Lanes<R>], from: &[Eight]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = from.0.into();
    }
}

/// Stores numbers.
#[inline(always)]
pub(super) fn store<R: Register>(to: &mut [Eight], from: &[Lanes<R>]) {
    for (to, &from) in to.iter_mut().zip(from) {
        to.0 = from.into();
    }
}
