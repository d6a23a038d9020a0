//! What a run of steps carries from one to the next.

use super::report::StepReport;
use crate::kernel::clock::Clock;
use crate::number::point::AnyLeg;
use crate::solve::predictor::Predictor;
use crate::solve::sum::Sum;
use crate::solve::{Numbers, Vector};
use crate::tape::Shape;

/// How often the rows of a step are evaluated from one guess unless [`Flow::max_iterations`](crate::Flow::max_iterations) says otherwise,
/// parts of updates apart.
pub(crate) const MAX_ITERATIONS: u32 = 60;

/// What a run of steps carries from one to the next: the last leg in compensated sums, past solutions, and the step that was solved last.
#[derive(Clone, Debug)]
pub struct Course {
    /// The step, negative back in time.
    pub(crate) h: f64,
    /// What is known since the run began.
    pub(crate) constants: Numbers,
    /// Which node is the current one.
    pub(crate) clock: Clock,
    /// How many nodes further the last position is that is known: one, but for the moment in which the run turns round.
    pub(crate) ahead: u64,
    /// The number of the position at which the past begins that steps go on from: that of the start, or of a change of inputs.
    pub(crate) since: u64,
    /// How often the rows may be evaluated from one guess.
    pub(crate) max_iterations: u32,
    /// The last position that is known.
    pub(crate) q: Sum,
    /// The increment that led to it.
    pub(crate) d: Sum,
    /// What a step of third order knows beside.
    pub(crate) third: Third,
    /// The past solutions.
    pub(crate) predictor: Predictor,
    /// The last step that was solved; it is one once the run has made a step.
    pub(crate) solved: Solved,
    /// Whether a step was solved.
    pub(crate) has_solved: bool,
    /// Whether the last step was examined for forces that switch.
    pub(crate) looked: bool,
    /// The number of the step in which something rests.
    pub(crate) rests_at: Option<u64>,
}

/// What a step of third order knows beside the last node and the increment to it.
#[derive(Clone, Debug)]
pub(crate) struct Third {
    /// The second difference that ends with the last node.
    pub e: Sum,
    /// The second difference that the last step went on from.
    pub before: Vector,
    /// The second difference of the next step, where it is known: that of the start, and of a run that has just turned round.
    pub given: Option<Sum>,
}

/// A step that was solved.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    /// The time of its middle node, where the system asks for it.
    pub t: f64,
    /// The middle node.
    pub q: Vector,
    /// The increment that led to it.
    pub d: Vector,
    /// The second difference; of third order, the third.
    pub e: Vector,
    /// How it was solved.
    pub report: StepReport,
}

impl Solved {
    /// The first two nodes.
    pub fn leg(&self) -> AnyLeg<'_, f64> {
        AnyLeg {
            t: self.t,
            q: &self.q,
            d: &self.d,
        }
    }
}

impl Course {
    /// How many numbers it holds, about.
    pub(crate) fn numbers(&self) -> usize {
        self.constants.len() + 12 * self.q.hi.len() + 7 * self.predictor.size().len()
    }

    /// Goes on from the step with the middle node `index`, which the run has not gone to by itself.
    pub(crate) fn resume(&mut self, index: u64) {
        self.clock.jump(index - 1);
        self.has_solved = false;
    }

    /// The number of the last position that is known, the middle node of the next step.
    pub(crate) fn index(&self) -> u64 {
        self.clock.index() + self.ahead
    }

    /// The time of that position.
    pub(crate) fn time(&self) -> f64 {
        self.clock.time_of(self.index())
    }

    /// The leg that the next step begins with, with the time only where the system asks for it.
    pub(crate) fn next_leg(&self, shape: &Shape) -> AnyLeg<'_, f64> {
        AnyLeg {
            t: if shape.depends_on_time { self.time() } else { 0.0 },
            q: &self.q.hi,
            d: &self.d.hi,
        }
    }

    /// Whether the past is too short to tell two roots apart by it.
    #[inline]
    pub(crate) fn past_is_short(&self) -> bool {
        past_is_short(self.index(), self.since)
    }
}

/// Whether the past of the step with this middle node is too short to tell two roots apart by it.
#[inline]
pub(crate) fn past_is_short(index: u64, since: u64) -> bool {
    index - since <= SHORT_PAST
}

/// The first steps, which have too short a past to tell by it which of two roots continues the motion.
pub(crate) const SHORT_PAST: u64 = 5;
