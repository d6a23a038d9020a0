//! The state of a run, carried from step to step.

use super::report::{Guess, StepReport};
use crate::kernel::clock::Clock;
use crate::number::point::{AnyLeg, Leg, copy};
use crate::solve::newton::Stop;
use crate::solve::predictor::Predictor;
use crate::solve::sum::Sum;
use crate::solve::{Numbers, Vector};
use crate::tape::Shape;

/// Default of [`Flow::max_iterations`](crate::Flow::max_iterations): largest number of evaluations of the
/// rows from one guess, shortened updates not counted.
pub(crate) const MAX_ITERATIONS: u32 = 60;

/// The state of a run, carried from step to step: the last leg in compensated sums, the last solved step, and
/// the past solutions.
#[derive(Clone, Debug)]
pub struct RunState {
    /// The step, negative back in time.
    pub(crate) h: f64,
    /// The known values of the run.
    pub(crate) constants: Numbers,
    /// The number and the time of the current node.
    pub(crate) clock: Clock,
    /// The last known position minus the current node, in nodes: 1, except while the run reverses its time.
    pub(crate) ahead: u64,
    /// The number of the position at which the past begins: that of the start, or of the last change of
    /// inputs.
    pub(crate) since: u64,
    /// Largest number of evaluations of the rows from one guess.
    pub(crate) max_iterations: u32,
    /// The last leg, the last solved step, and the past of third order.
    pub(crate) vectors: Vectors,
    /// In third order, the second difference of the next step, if it is given: at the start, and just after
    /// the run has reversed its time.
    pub(crate) given: Option<Sum>,
    /// The past solutions.
    pub(crate) predictor: Predictor,
    /// The time of the middle node of the last step, if the system depends on time.
    pub(crate) solved_at: f64,
    /// Statistics of the last solved step.
    pub(crate) report: StepReport,
    /// Whether a step was solved.
    pub(crate) has_solved: bool,
    /// Whether the last step was examined for jumps of a force.
    pub(crate) is_examined: bool,
    /// The number of the step before which the arguments of piecewise functions are evaluated again; the
    /// largest number if there are none.
    pub(crate) next_examination: u64,
}

/// The vectors of a run's state, contiguous in memory.
#[derive(Clone, Debug)]
pub(crate) struct Vectors {
    /// The number of increments.
    increments: usize,
    /// [`Vectors::COUNT`] vectors, one after the other, in the order of [`Arrays`].
    numbers: Vec<f64>,
}

/// [`Vectors`] as arrays.
pub(crate) struct Arrays<'c, const N: usize> {
    /// The last known position.
    pub q: [&'c mut [f64; N]; 2],
    /// The increment that led to it.
    pub d: [&'c mut [f64; N]; 2],
    /// The middle node of the last solved step.
    pub solved_q: &'c mut [f64; N],
    /// The increment that led to it.
    pub solved_d: &'c mut [f64; N],
    /// The second difference of that step; in third order, the third.
    pub e: &'c mut [f64; N],
    /// In third order: the second difference that ends with the last node.
    pub second: [&'c mut [f64; N]; 2],
    /// If forces may jump, the second difference of the step before; in third order, the one that the last
    /// step continued.
    pub before: &'c mut [f64; N],
}

/// The last solved step.
pub(crate) struct Solved<'c, const N: usize> {
    /// Its first two nodes.
    pub leg: Leg<f64, N>,
    /// Its second difference; in third order, the third.
    pub e: &'c [f64; N],
    /// If forces may jump, the second difference of the step before; in third order, the one that it
    /// continued.
    pub before: &'c [f64; N],
}

/// The places of the vectors; a compensated sum takes two, high part first.
const Q: usize = 0;
const D: usize = 2;
const SOLVED_Q: usize = 4;
const SOLVED_D: usize = 5;
const E: usize = 6;
const SECOND: usize = 7;
const BEFORE: usize = 9;

impl Vectors {
    /// The number of vectors.
    const COUNT: usize = 10;

    /// The vectors of a run that begins with a leg.
    pub fn new(q: &Sum, d: &Sum) -> Self {
        let increments = d.hi.len();
        let mut vectors = Self {
            increments,
            numbers: vec![0.0; Self::COUNT * increments],
        };
        vectors.set_sum(Q, q);
        vectors.set_sum(D, d);
        vectors
    }

    /// The vectors as arrays; `None` for another number of coordinates.
    #[allow(clippy::inline_always)] // part of every step
    #[inline(always)]
    pub fn arrays<const N: usize>(&mut self) -> Option<Arrays<'_, N>> {
        let [
            q,
            q_low,
            d,
            d_low,
            solved_q,
            solved_d,
            e,
            second,
            second_low,
            before,
        ] = self.numbers.as_chunks_mut().0
        else {
            return None;
        };
        Some(Arrays {
            q: [q, q_low],
            d: [d, d_low],
            solved_q,
            solved_d,
            e,
            second: [second, second_low],
            before,
        })
    }

    /// The vectors as slices, in the order of [`Arrays`]; the compensated sums of the last leg are one slice,
    /// as are those of the second difference.
    #[inline]
    pub fn slices(&mut self) -> [&mut [f64]; 6] {
        let n = self.increments;
        let (leg, rest) = self.numbers.split_at_mut(SOLVED_Q * n);
        let (solved_q, rest) = rest.split_at_mut(n);
        let (solved_d, rest) = rest.split_at_mut(n);
        let (e, rest) = rest.split_at_mut(n);
        let (second, before) = rest.split_at_mut((BEFORE - SECOND) * n);
        [leg, solved_q, solved_d, e, second, before]
    }

    /// The last solved step, as arrays; `None` for another number of coordinates.
    #[inline]
    pub fn solved<const N: usize>(&self, t: f64) -> Option<Solved<'_, N>> {
        let [_, _, _, _, q, d, e, _, _, before] = self.numbers.as_chunks().0 else {
            return None;
        };
        Some(Solved {
            leg: Leg { t, q: *q, d: *d },
            e,
            before,
        })
    }

    fn vector(&self, place: usize) -> &[f64] {
        let n = self.increments;
        self.numbers.get(place * n..(place + 1) * n).unwrap_or(&[])
    }

    fn set(&mut self, place: usize, vector: &[f64]) {
        let n = self.increments;
        let room = self.numbers.get_mut(place * n..(place + 1) * n);
        copy(room.unwrap_or(&mut []), vector);
    }

    fn sum(&self, place: usize) -> Sum {
        Sum {
            hi: Vector::of(self.vector(place)),
            lo: Vector::of(self.vector(place + 1)),
        }
    }

    fn set_sum(&mut self, place: usize, sum: &Sum) {
        self.set(place, &sum.hi);
        self.set(place + 1, &sum.lo);
    }

    /// The last known position, rounded.
    pub fn position(&self) -> &[f64] {
        self.vector(Q)
    }

    /// The increment that led to it, rounded.
    pub fn increment(&self) -> &[f64] {
        self.vector(D)
    }

    /// The last known position.
    pub fn q(&self) -> Sum {
        self.sum(Q)
    }

    /// The increment that led to it.
    pub fn d(&self) -> Sum {
        self.sum(D)
    }

    /// Sets the last leg.
    pub fn set_leg(&mut self, q: &Sum, d: &Sum) {
        self.set_sum(Q, q);
        self.set_sum(D, d);
    }

    /// Moves on to the leg `(q, d)`; the last leg becomes that of the solved step, with the second difference
    /// `e`.
    pub fn commit(&mut self, q: &Sum, d: &Sum, e: &[f64]) {
        let n = self.increments;
        self.numbers.copy_within(Q * n..(Q + 1) * n, SOLVED_Q * n);
        self.numbers.copy_within(D * n..(D + 1) * n, SOLVED_D * n);
        self.numbers.copy_within(E * n..(E + 1) * n, BEFORE * n);
        self.set(E, e);
        self.set_leg(q, d);
    }

    /// The last solved step: its middle node, the increment that led to it and the second difference, one
    /// after the other.
    pub fn solved_step(&self) -> &[f64] {
        let n = self.increments;
        self.numbers.get(SOLVED_Q * n..SECOND * n).unwrap_or(&[])
    }

    /// The second difference of the last solved step; in third order, the third.
    pub fn e(&self) -> &[f64] {
        self.vector(E)
    }

    /// In third order: the second difference that ends with the last node.
    pub fn second(&self) -> Sum {
        self.sum(SECOND)
    }

    /// If forces may jump, the second difference of the step before; in third order, the one that the last
    /// step continued.
    pub fn before(&self) -> &[f64] {
        self.vector(BEFORE)
    }

    /// In third order: moves on to the second difference that ends with the next node.
    pub fn go_on(&mut self, second: &Sum) {
        let n = self.increments;
        self.numbers.copy_within(SECOND * n..(SECOND + 1) * n, BEFORE * n);
        self.set_sum(SECOND, second);
    }

    /// In third order: sets the second difference that ends with the last node.
    pub fn set_second(&mut self, second: &Sum) {
        self.set_sum(SECOND, second);
    }

    /// The compensated sums of the last leg: the high and low part of the position, then of the increment.
    pub fn leg_sums(&self) -> impl Iterator<Item = &[f64]> {
        (Q..SOLVED_Q).map(|place| self.vector(place))
    }

    /// The compensated sums of the last leg, mutable.
    pub fn leg_sums_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        self.numbers
            .chunks_exact_mut(self.increments.max(1))
            .take(SOLVED_Q)
    }
}

/// The report before the first step.
const NOTHING: StepReport = StepReport {
    iterations: 0,
    stop: Stop::Start,
    guess: Guess::Given,
};

impl RunState {
    /// A run with the step `h` that begins at a time, with the leg that ends with `q`.
    pub(crate) fn new(shape: &Shape, (h, constants): (f64, Numbers), t0: f64, (q, d): (&Sum, &Sum)) -> Self {
        Self {
            h,
            constants,
            clock: Clock::even(t0, h),
            ahead: 1,
            since: 0,
            max_iterations: MAX_ITERATIONS,
            vectors: Vectors::new(q, d),
            given: None,
            predictor: Predictor::new(shape.unknowns),
            solved_at: 0.0,
            report: NOTHING,
            has_solved: false,
            is_examined: true,
            next_examination: u64::MAX,
        }
    }

    /// A run after one step: from a leg, with the second difference `e`; in third order, with the third
    /// difference `e` after the second difference `past`. [`Kernel::report`](crate::Kernel::report) can be
    /// called with it.
    #[must_use]
    pub fn of_step(
        shape: &Shape,
        (h, constants): (f64, &[f64]),
        leg: AnyLeg<'_, f64>,
        [e, past]: [&[f64]; 2],
    ) -> Self {
        let [q, d] = [leg.q, leg.d].map(|vector| Sum::exact(Vector::of(vector)));
        let mut run_state = Self::new(shape, (h, constants.into()), leg.t, (&q, &d));
        run_state.vectors.commit(&q, &d, e);
        run_state.vectors.set(BEFORE, past);
        (run_state.solved_at, run_state.has_solved) = (leg.t, true);
        run_state
    }

    /// The approximate count of its numbers.
    pub(crate) fn numbers(&self) -> usize {
        self.constants.len() + self.vectors.numbers.len() + 7 * self.predictor.size().len()
    }

    /// Continues from the step with the middle node `index`, to which the run has not stepped.
    pub(crate) fn resume(&mut self, index: u64) {
        self.clock.jump(index - 1);
        self.has_solved = false;
    }

    /// The number of the last known position, the middle node of the next step.
    pub(crate) fn index(&self) -> u64 {
        self.clock.index() + self.ahead
    }

    /// The time of that position.
    pub(crate) fn time(&self) -> f64 {
        self.clock.time_of(self.index())
    }

    /// The first leg of the next step; its time is set only if the system depends on time.
    pub(crate) fn next_leg(&self, shape: &Shape) -> AnyLeg<'_, f64> {
        AnyLeg {
            t: if shape.depends_on_time { self.time() } else { 0.0 },
            q: self.vectors.position(),
            d: self.vectors.increment(),
        }
    }

    /// The first two nodes of the last solved step.
    pub(crate) fn solved_leg(&self) -> AnyLeg<'_, f64> {
        AnyLeg {
            t: self.solved_at,
            q: self.vectors.vector(SOLVED_Q),
            d: self.vectors.vector(SOLVED_D),
        }
    }

    /// Whether the past is too short to tell two roots apart.
    #[inline]
    pub(crate) fn past_is_short(&self) -> bool {
        past_is_short(self.index(), self.since)
    }
}

/// Whether the past of the step with this middle node is too short to tell two roots apart.
#[inline]
pub(crate) fn past_is_short(index: u64, since: u64) -> bool {
    index - since <= SHORT_PAST
}

/// Number of first steps whose past is too short to tell which of two roots continues the motion.
pub(crate) const SHORT_PAST: u64 = 5;
