//! The memory of a path: all of its steps, or states of the run (checkpoints), from which the steps between
//! them are computed again.

use core::ops::Range;

use super::error::DerivativeError;
use crate::flow::discrete::Discrete;
use crate::number::point::AnyLeg;
use crate::run::Run as _;
use crate::tape::Eight;

/// The numbers of a step, in the order of storage: the time of the middle node, the node, the increment that
/// led to it, the second difference, the unknowns.
#[derive(Clone, Copy, Debug)]
struct Layout {
    /// The number of coordinates.
    coordinates: usize,
    /// The number of unknowns.
    unknowns: usize,
}

impl Layout {
    /// The total count of numbers.
    fn width(self) -> usize {
        1 + 3 * self.coordinates + self.unknowns
    }
}

/// Some consecutive steps.
#[derive(Clone, Debug)]
pub(super) struct RecordedSteps {
    /// The number of the first step's middle node, from 1 on.
    pub first: usize,
    /// The layout of a step.
    layout: Layout,
    /// The number of steps.
    count: usize,
    /// Their numbers, one step after the other.
    numbers: Vec<f64>,
}

impl RecordedSteps {
    /// The memory of a step in bytes.
    pub fn bytes([coordinates, unknowns]: [usize; 2]) -> usize {
        let layout = Layout {
            coordinates,
            unknowns,
        };
        size_of::<f64>() * layout.width()
    }

    /// No steps yet, with memory for `count` steps of the given numbers of coordinates and unknowns.
    pub fn from(first: usize, count: usize, [coordinates, unknowns]: [usize; 2]) -> Self {
        let layout = Layout {
            coordinates,
            unknowns,
        };
        Self {
            first,
            layout,
            count: 0,
            numbers: Vec::with_capacity(count * layout.width()),
        }
    }

    /// The number of the middle node of the step that would follow.
    pub fn end(&self) -> usize {
        self.first + self.count
    }

    /// Stores a step: its time; the middle node, the increment and the second difference as one slice; the
    /// unknowns.
    #[inline]
    pub fn push(&mut self, t: f64, step: &[f64], z: &[f64]) {
        self.count += 1;
        self.numbers.push(t);
        self.numbers.extend_from_slice(step);
        self.numbers.extend_from_slice(z);
    }

    /// The steps with the middle nodes of a range.
    pub fn steps(&self, nodes: Range<usize>) -> StepSlice<'_> {
        let width = self.layout.width();
        let places = (nodes.start - self.first) * width..(nodes.end - self.first) * width;
        StepSlice {
            layout: self.layout,
            count: nodes.len(),
            numbers: &self.numbers[places],
        }
    }
}

/// Consecutive steps of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepSlice<'p> {
    /// The layout of a step.
    layout: Layout,
    /// The number of steps.
    count: usize,
    /// The numbers of the steps.
    numbers: &'p [f64],
}

impl<'p> StepSlice<'p> {
    /// The place of the time among the numbers of a step.
    pub const TIME: usize = 0;

    /// The number of steps.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The place of a coordinate of the middle node.
    pub fn node(i: usize) -> usize {
        Self::TIME + 1 + i
    }

    /// The place of a component of the increment.
    pub fn increment(&self, i: usize) -> usize {
        1 + self.layout.coordinates + i
    }

    /// The place of a component of the second difference.
    pub fn difference(&self, i: usize) -> usize {
        1 + 2 * self.layout.coordinates + i
    }

    /// The place of an unknown.
    pub fn unknown(&self, i: usize) -> usize {
        1 + 3 * self.layout.coordinates + i
    }

    /// A number of each step, by its place. Unused lanes repeat the last step.
    #[inline]
    pub fn gathered(&self, place: usize) -> Eight {
        let (width, last) = (self.layout.width(), self.count() - 1);
        Eight::from_fn(|lane| self.numbers[lane.min(last) * width + place])
    }

    /// The first step: its first two nodes and its second difference.
    pub fn first(&self) -> (AnyLeg<'p, f64>, &'p [f64]) {
        let n = self.layout.coordinates;
        let (q, rest) = self.numbers[1..].split_at(n);
        let (d, rest) = rest.split_at(n);
        let t = self.numbers[0];
        (AnyLeg { t, q, d }, &rest[..n])
    }
}

/// The checkpoints: states of a run from which its steps are computed again.
pub(super) struct Checkpoints<'s> {
    /// The number of steps between two checkpoints, a multiple of [`Eight::COUNT`], so that steps are
    /// evaluated in the same blocks as if all were stored.
    pub every: usize,
    /// The states. The first one is that before the first step.
    states: Vec<Discrete<'s>>,
}

impl<'s> Checkpoints<'s> {
    /// No checkpoints: all steps are kept.
    pub fn none() -> Self {
        Self {
            every: usize::MAX,
            states: Vec::new(),
        }
    }

    /// Checkpoints for `count` steps of `bytes` bytes each, and states of `state` bytes. If all steps fit
    /// into `memory` bytes, all are stored. Otherwise checkpoints are, at the distance for which the
    /// checkpoints and the steps between two of them take the least memory together.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the square root of a number of steps in memory
    pub fn new(count: usize, [bytes, state]: [usize; 2], memory: usize) -> Self {
        if count.saturating_mul(bytes) <= memory {
            return Self::none();
        }
        let best = (count as f64 * state as f64 / bytes as f64).sqrt();
        let every = (best as usize).next_multiple_of(Eight::COUNT).max(Eight::COUNT);
        Self {
            every,
            states: Vec::with_capacity(count / every + 1),
        }
    }

    /// Whether checkpoints are stored, not all steps.
    pub fn are_kept(&self) -> bool {
        self.every != usize::MAX
    }

    /// Stores the state of a flow after `steps` steps, if a checkpoint is due there. Returns whether it is.
    #[inline]
    pub fn record(&mut self, flow: &Discrete<'s>, steps: usize) -> bool {
        let is_due = self.are_kept() && steps.is_multiple_of(self.every);
        if is_due {
            self.states.push(flow.clone());
        }
        is_due
    }

    /// Computes the steps after the checkpoint number `window` again. The path has `count` steps in all, with
    /// the numbers `sizes` of coordinates and unknowns.
    pub fn again(
        &self,
        window: usize,
        count: usize,
        sizes: [usize; 2],
    ) -> Result<RecordedSteps, DerivativeError> {
        let before = window * self.every;
        let own = self.every.min(count.saturating_sub(before));
        let mut record = RecordedSteps::from(before + 1, own, sizes);
        let Some(state) = self.states.get(window) else {
            return Ok(record);
        };
        let mut flow = state.clone();
        for _ in 0..own {
            flow.step(f64::INFINITY)?;
            record_last(&mut record, &flow);
        }
        Ok(record)
    }
}

/// Stores the last step of a flow.
#[inline]
pub(super) fn record_last(record: &mut RecordedSteps, flow: &Discrete<'_>) {
    let run_state = &flow.run_state;
    if let (true, Some(z)) = (run_state.has_solved, run_state.predictor.last()) {
        record.push(run_state.solved_at, run_state.vectors.solved_step(), z);
    }
}
