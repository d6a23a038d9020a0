//! Steps of third order: what they know of the past beside the leg, and how they go on.

use super::{Flow, Solved};
use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::error::StepError;
use crate::regularity::Regularity;
use crate::step::newton::Stop;
use crate::step::predictor::Predictor;
use crate::step::{Guess, Step, StepReport};
use crate::system::{Leg, System};

/// What a step of third order knows beside the last node and the increment to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Third<const N: usize> {
    /// The second difference that ends with the last node.
    pub(super) e: Compensated<N>,
    /// The second difference that the last step went on from.
    pub(super) before: [f64; N],
    /// The second difference of the next step, where it is known: that of the start, and of a run that has just turned round.
    pub(super) given: Option<Compensated<N>>,
}

impl<const N: usize> Third<N> {
    /// What is known at the start.
    pub(super) fn new(first: Option<Compensated<N>>) -> Self {
        Self {
            e: Compensated::exact([0.0; N]),
            before: [0.0; N],
            given: first,
        }
    }
}

impl<S: System<N>, const N: usize> Flow<'_, S, N> {
    /// Solves the next step for its third difference, unless the second difference is known.
    #[inline(never)]
    pub(super) fn solve_third(&mut self) -> Result<StepReport, StepError> {
        let leg = self.next_leg();
        if let Some(second) = self.third.given {
            return Ok(self.take_given(leg, second));
        }
        let (past_is_short, _) = self.near_the_start();
        let step = Step {
            past_is_short,
            ..Step::new(&*self.system, &self.constants, leg, self.h)
        };
        let (z, report) = match step.solve(&mut self.predictor, self.max_iterations) {
            Ok(solution) => solution,
            Err(cause) => return Err(self.failed(cause)),
        };
        let e = step.second_difference(&z);
        let (second, d) = self.arriving(&e);
        let q = self.q.plus(&d);
        if !q.hi.iter().all(|q| q.is_finite()) {
            return Err(self.failed(step.any().not_finite(&z)));
        }
        self.predictor.push(&z);
        self.solved = Some(Solved { leg, e, report });
        (self.q, self.d) = (q, d);
        self.go_on(second);
        Ok(report)
    }

    /// The second difference and the increment that a third difference leads to.
    pub(super) fn arriving(&self, third: &[f64; N]) -> (Compensated<N>, Compensated<N>) {
        let mut second = self.third.e;
        second.add(third);
        (second, self.d.plus(&second))
    }

    /// Goes on from a second difference.
    pub(super) fn go_on(&mut self, second: Compensated<N>) {
        self.third = Third {
            e: second,
            before: self.third.e.hi,
            given: None,
        };
        S::remember(&mut self.constants, &second.hi);
    }

    /// Makes the step whose second difference is known.
    fn take_given(&mut self, leg: Leg<f64, N>, second: Compensated<N>) -> StepReport {
        let report = StepReport {
            iterations: 0,
            stop: Stop::Start,
            guess: Guess::Given,
        };
        self.d = self.d.plus(&second);
        self.q = self.q.plus(&self.d);
        // as a third difference after none
        self.third.e = Compensated::exact([0.0; N]);
        self.solved = Some(Solved {
            leg,
            e: second.hi,
            report,
        });
        self.go_on(second);
        report
    }

    /// Turns round what is known: the second difference at the current node is the same on the way back, which makes the first
    /// step; at the start it is the one that the step back goes on from.
    pub(super) fn turn_third(&mut self, is_solved: bool) {
        if is_solved {
            self.third.given = Some(self.third.e);
        } else if let Some(first) = self.third.given {
            self.go_on(first);
        }
        // third differences change their signs, and begin anew
        self.predictor = Predictor::new();
    }

    /// The regularity of a step that was solved.
    pub(super) fn regularity_of_third(&self, solved: &Solved<N>) -> Option<Regularity> {
        // the step of the start is none of the declaration's
        if solved.report.guess == Guess::Given && solved.report.stop == Stop::Start {
            return None;
        }
        let declaration = Declaration::of(&*self.system).after(&self.third.before);
        Some(Regularity::of_third(
            &declaration,
            &self.third.before,
            S::THIRD_ORDER,
            self.h,
            solved.leg.any(),
            &solved.e,
        ))
    }
}
