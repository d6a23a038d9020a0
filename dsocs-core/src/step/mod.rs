//! One step: from a leg to the second difference that leads to the next node.
//!
//! [`unknown`] says what is looked for and [`elimination`] solves linear rows, many of them by [`sparse`], [`newton`] iterates from the guess of [`predictor`] until
//! [`convergence`] says that it has arrived, and [`pair`] tells two roots apart. What is done seldom stands in [`any`].

mod any;
pub(crate) mod convergence;
pub(crate) mod elimination;
pub(crate) mod newton;
pub(crate) mod pair;
pub(crate) mod predictor;
pub(crate) mod sparse;
pub(crate) mod unknown;

use crate::any::AnySystem;
use crate::declaration::Declaration;
use crate::error::NewtonFailure;
use crate::rounding;
use crate::system::{Leg, System};
pub(crate) use any::{AnyStep, Failing, Steps};
use newton::{Equations, Evaluation, Root, Stop};
use pair::Found;
use predictor::{Continuation, Predictor};
use sparse::{Product, Update};
use unknown::{Linearization, Unknown};

/// How large an unknown second difference is expected to be at least, relative to the increment.
pub(crate) const SECOND_DIFFERENCE: f64 = 1e-5;

/// How much what the rows were multiplied by may change, relative to itself, from a root to a point nearby.
pub(crate) const NEARLY_THE_SAME: f64 = 1e-2;

/// How a step was solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepReport {
    /// How often the rows and their Jacobian were evaluated, for all guesses that were tried.
    pub iterations: u32,
    /// How Newton's iteration ended.
    pub stop: Stop,
    /// The guess that led to the solution.
    pub guess: Guess,
}

/// Where Newton's iteration began.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Guess {
    /// At the polynomial through the last solutions.
    Predicted,
    /// At the solution of the step before.
    Last,
    /// At a straight line: no second difference.
    Straight,
    /// At the acceleration of the continuous system.
    Continuous,
    /// At the node where the path turns by the same angle as at the step before, in the plane of the last two legs.
    Turned,
    /// Beside a root that was found and did not continue the motion.
    Other,
    /// Where the caller asked for it.
    Given,
    /// At the end of a homotopy: a path along which the residual of the straight line is reduced to zero little by little.
    Followed,
}

/// The acceleration with which a motion begins.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Begins<const N: usize> {
    /// It was said.
    Said([f64; N]),
    /// It was worked out at the start: less than what the second node says, where that says anything.
    Found([f64; N]),
}

/// The equations of one step.
pub(crate) struct Step<'a, S: System<N>, const N: usize> {
    /// The system.
    pub system: &'a S,
    /// What is known since the run began.
    pub constants: &'a S::Constants<f64>,
    /// What is known since the step began.
    pub known: S::Known<f64>,
    /// The step's first two nodes.
    pub leg: Leg<f64, N>,
    /// The step.
    pub h: f64,
    /// Whether the past is too short to tell by it which of two roots continues the motion: other roots are then looked for
    /// wherever the rows bend.
    pub past_is_short: bool,
    /// The acceleration with which the motion begins, where the step is the first.
    pub begins: Option<Begins<N>>,
    /// The legs of the last solutions, the last first, where these do not lie one step apart.
    pub past: Option<&'a [Leg<f64, N>; PAST]>,
}

impl<S: System<N>, const N: usize> Equations for Step<'_, S, N> {
    type Z = S::Unknown<f64>;

    #[inline]
    fn are_affine(&self) -> bool {
        S::LINEAR
    }

    #[inline]
    fn may_jump(&self) -> bool {
        S::JUMPS
    }

    #[inline]
    fn are_watched(&self) -> bool {
        !S::DIVIDED && !S::LINEAR
    }

    #[inline]
    fn past_is_short(&self) -> bool {
        self.past_is_short
    }

    #[inline]
    fn linearize(&self, z: &Self::Z) -> Linearization<f64, Self::Z> {
        self.system.linearize(self.constants, &self.known, z)
    }

    #[inline]
    fn sparse_update(&self, z: &Self::Z) -> Option<Evaluation<Self::Z>> {
        if const { !S::SPARSE } {
            return None;
        }
        let sparse = self.system.sparse()?;
        let mut product = Product::new(sparse.is_odd());
        let Update { rows, update } = sparse.update(
            |entries| self.system.entries(self.constants, &self.known, z, entries),
            |pivot| product.take(pivot),
        );
        let finite = update.as_ref().iter().all(|x| x.is_finite());
        finite.then(|| Evaluation {
            rows,
            update,
            safe: true,
            determinant: product.value(),
        })
    }

    #[inline]
    fn evaluate(&self, z: &Self::Z) -> Evaluation<Self::Z> {
        if const { S::SPARSE } {
            return match self.sparse_update(z) {
                Some(evaluation) => evaluation,
                None => Evaluation::apart(self, z),
            };
        }
        Evaluation::dense(self, z)
    }

    #[inline]
    fn is_declared(&self, z: &Self::Z, nearby: &Self::Z) -> bool {
        if !S::SCALED {
            return true;
        }
        let here = self.system.scales(self.constants, &self.known, z);
        let there = self.system.scales(self.constants, &self.known, nearby);
        let scales = here.as_ref().iter().zip(there.as_ref());
        // false also where one of them is no number
        scales
            .into_iter()
            .all(|(here, there)| (here - there).abs() < NEARLY_THE_SAME * here.abs())
    }

    fn rounding(&self, z: &Self::Z) -> Self::Z {
        rounding::bounds(&self.declaration(&self.before()), self.h, self.leg.any(), z)
    }
}

impl<'a, S: System<N>, const N: usize> Step<'a, S, N> {
    /// The equations of the step that begins with `leg`.
    #[inline]
    pub fn new(system: &'a S, constants: &'a S::Constants<f64>, leg: Leg<f64, N>, h: f64) -> Self {
        Self {
            system,
            constants,
            known: system.known(constants, &leg),
            leg,
            h,
            past_is_short: false,
            begins: None,
            past: None,
        }
    }

    /// The second difference that belongs to the unknowns.
    #[inline]
    pub fn second_difference(&self, z: &S::Unknown<f64>) -> [f64; N] {
        self.system.second_difference(self.constants, &self.known, z)
    }

    /// Solves the step, from the prediction or, if that does not lead to a root, from other guesses.
    #[inline]
    pub fn solve(
        &self,
        predictor: &mut Predictor<S::Unknown<f64>>,
        max_iterations: u32,
    ) -> Result<(S::Unknown<f64>, StepReport), NewtonFailure> {
        let size = self.size(predictor);
        let mut evaluations = 0;
        if let Some(start) = predictor.predict() {
            match newton::solve(self, start, &size, max_iterations, predictor) {
                // nearly always: with one or two evaluations nothing bends, and the determinant goes on as before
                Ok(root) => {
                    if S::JUMPS && root.stop == Stop::Jump {
                        return Ok(report(root, Guess::Predicted));
                    }
                    let continuation = self.take_determinant(&root, predictor);
                    if continuation == Continuation::Fits && !self.in_question(&root) {
                        return Ok(report(root, Guess::Predicted));
                    }
                    let (found, start) = (Found { root, continuation }, &start);
                    return self
                        .any()
                        .checked(found, start, Guess::Predicted, predictor, &size);
                }
                Err(failed) => evaluations = failed.evaluations,
            }
        }
        self.any()
            .solve_without_prediction(predictor, &size, max_iterations, evaluations)
    }

    /// The same, without the type of the system.
    #[inline]
    pub fn any(&self) -> &dyn AnyStep<N, Z = S::Unknown<f64>> {
        self
    }

    /// Holds the determinant at a root against those of the steps before.
    #[inline]
    fn take_determinant(
        &self,
        root: &Root<S::Unknown<f64>>,
        predictor: &mut Predictor<S::Unknown<f64>>,
    ) -> Continuation {
        if S::DIVIDED || S::LINEAR {
            Continuation::Fits
        } else if root.determinant.value.is_nan() {
            self.any().continuation(root, predictor)
        } else {
            predictor.take_determinant(root.determinant)
        }
    }

    /// Whether another root may be as near to the guess as this one.
    #[inline]
    fn in_question(&self, root: &Root<S::Unknown<f64>>) -> bool {
        !S::DIVIDED && !S::LINEAR && pair::in_question(root, self.past_is_short)
    }

    /// How large each unknown is expected to be: as lately, and not much smaller than the increment.
    #[inline]
    pub fn size(&self, predictor: &Predictor<S::Unknown<f64>>) -> S::Unknown<f64> {
        let increment = self.system.unknown(&self.leg.d, &[]);
        let least = increment.zip(&increment, |d, _| SECOND_DIFFERENCE * d.abs());
        predictor.expected(&least)
    }
}

impl<S: System<N>, const N: usize> AnyStep<N> for Step<'_, S, N> {
    fn system(&self) -> &dyn AnySystem<N> {
        self.system
    }

    fn declaration<'a>(&'a self, before: &'a [f64; N]) -> Declaration<'a> {
        Declaration::of(self.system).after(before)
    }

    fn before(&self) -> [f64; N] {
        S::past(self.constants)
    }

    fn h(&self) -> f64 {
        self.h
    }

    fn leg(&self) -> &Leg<f64, N> {
        &self.leg
    }

    fn begins(&self) -> Option<&Begins<N>> {
        self.begins.as_ref()
    }

    fn past(&self) -> Option<&[Leg<f64, N>; PAST]> {
        self.past
    }

    fn unknown(&self, e: &[f64; N], multipliers: &[f64]) -> Self::Z {
        self.system.unknown(e, multipliers)
    }

    fn second_difference(&self, z: &Self::Z) -> [f64; N] {
        Step::second_difference(self, z)
    }

    fn on_leg(&self, leg: &Leg<f64, N>, z: &Self::Z) -> ([f64; N], Linearization<f64, Self::Z>) {
        let moved = Step {
            known: self.system.known(self.constants, leg),
            leg: *leg,
            ..*self
        };
        (moved.second_difference(z), moved.linearize(z))
    }

    fn scales(&self, z: &Self::Z) -> Option<Self::Z> {
        S::SCALED.then(|| self.system.scales(self.constants, &self.known, z))
    }
}

pub(crate) use predictor::PAST;

/// What is told of a root.
#[inline]
fn report<Z>(root: Root<Z>, guess: Guess) -> (Z, StepReport) {
    (
        root.z,
        StepReport {
            iterations: root.evaluations,
            stop: root.stop,
            guess,
        },
    )
}
