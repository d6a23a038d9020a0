//! One step: from a leg to the second difference that leads to the next node.
//!
//! [`unknown`] says what is looked for and [`elimination`] solves linear rows, [`newton`] iterates from the guess of [`predictor`] until
//! [`convergence`] says that it has arrived, and [`pair`] tells two roots apart.

pub(crate) mod convergence;
pub(crate) mod elimination;
pub(crate) mod newton;
mod pair;
pub(crate) mod predictor;
pub(crate) mod unknown;

use crate::declaration::Declaration;
use crate::error::{NewtonFailure, StepFailure};
use crate::multipliers::{self, has_multipliers};
use crate::rounding;
use crate::start;
use crate::system::{Leg, System};
use newton::{Equations, Root, Stop};
use pair::Found;
use predictor::{Continuation, Predictor};
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
    /// Where the path turns once more as it did at the step before, in the plane of the last two legs.
    Turned,
    /// Beside a root that was found and did not continue the motion.
    Other,
    /// Where the caller asked for it.
    Given,
    /// At the end of a path along which the rows of a straight line are taken away little by little.
    Followed,
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
    /// Whether other roots are looked for wherever the rows bend.
    pub watchful: bool,
    /// The legs of the last solutions, the last first, where these do not lie one step apart.
    pub past: Option<&'a [Leg<f64, N>; PAST]>,
}

impl<S: System<N>, const N: usize> Equations for Step<'_, S, N> {
    type Z = S::Unknown<f64>;

    const LINEAR: bool = S::LINEAR;
    const WATCHED: bool = !S::DIVIDED;

    #[inline]
    fn watchful(&self) -> bool {
        self.watchful
    }

    #[inline]
    fn linearize(&self, z: &Self::Z) -> Linearization<f64, Self::Z> {
        self.system.linearize(self.constants, &self.known, z)
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
        rounding::bounds(self.system, self.h, &self.leg, z)
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
            watchful: false,
            past: None,
        }
    }

    /// The second difference that belongs to the unknowns.
    #[inline]
    pub fn second_difference(&self, z: &S::Unknown<f64>) -> [f64; N] {
        self.system.second_difference(self.constants, &self.known, z)
    }

    /// The unknowns that belong to a second difference, with the multipliers that come nearest to its constraint force.
    pub fn unknowns(&self, e: &[f64; N]) -> S::Unknown<f64> {
        if !has_multipliers::<S, N>() {
            return self.system.unknown(e, &[]);
        }
        let multipliers = multipliers::of_step(&Declaration::of(self.system), self.h, &self.leg, e);
        self.system.unknown(e, &multipliers)
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
                    let continuation = self.take_determinant(&root, predictor);
                    if continuation == Continuation::Fits && !self.in_question(&root) {
                        return Ok(report(root, Guess::Predicted));
                    }
                    let (found, start) = (Found { root, continuation }, &start);
                    return self.checked(found, start, Guess::Predicted, predictor, &size);
                }
                Err(failed) => evaluations = failed.evaluations,
            }
        }
        self.solve_without_prediction(predictor, &size, max_iterations, evaluations)
    }

    /// How large each unknown is expected to be: as lately, and not much smaller than the increment.
    #[inline]
    fn size(&self, predictor: &Predictor<S::Unknown<f64>>) -> S::Unknown<f64> {
        let increment = self.system.unknown(&self.leg.d, &[]);
        let least = increment.zip(&increment, |d, _| SECOND_DIFFERENCE * d.abs());
        predictor.expected(&least)
    }

    /// Solves the step from every guess but the prediction.
    #[cold]
    fn solve_without_prediction(
        &self,
        predictor: &mut Predictor<S::Unknown<f64>>,
        size: &S::Unknown<f64>,
        max_iterations: u32,
        mut evaluations: u32,
    ) -> Result<(S::Unknown<f64>, StepReport), NewtonFailure> {
        let straight = (S::Unknown::<f64>::zero(), Guess::Straight);
        let continuous = self.continuous().map(|z| (z, Guess::Continuous));
        let last = predictor.last().map(|z| (z, Guess::Last));
        let turned = predictor.last().and_then(|z| self.turned(&z));
        // the first step has the acceleration for its best guess; later the last solution is nearer
        let guesses = if last.is_none() {
            [continuous, Some(straight), None, None]
        } else {
            [
                turned.map(|z| (z, Guess::Turned)),
                last,
                Some(straight),
                continuous,
            ]
        };
        for (start, guess) in guesses.into_iter().flatten() {
            match newton::solve_apart(self, start, size, max_iterations, predictor) {
                Ok(root) => {
                    evaluations += root.evaluations;
                    let continuation = self.take_determinant(&root, predictor);
                    let root = Root { evaluations, ..root };
                    return self.checked(Found { root, continuation }, &start, guess, predictor, size);
                }
                Err(failed) => evaluations += failed.evaluations,
            }
        }
        for (start, _) in [Some(straight), last, continuous].into_iter().flatten() {
            if let Some(root) = newton::follow(self, start, size, max_iterations, &mut evaluations) {
                self.take_determinant(&root, predictor);
                return Ok(report(Root { evaluations, ..root }, Guess::Followed));
            }
        }
        let best = predictor
            .predict()
            .or(continuous.map(|(z, _)| z))
            .unwrap_or(straight.0);
        Err(newton::explain(self, best, size, max_iterations))
    }

    /// The failure of a step whose rows have a root that leads to no finite node.
    #[cold]
    pub fn not_finite(&self, z: &S::Unknown<f64>) -> NewtonFailure {
        // affine rows without an update are singular
        let at = self.linearize(&S::Unknown::zero());
        let finite = |values: &S::Unknown<f64>| values.as_ref().iter().all(|x| x.is_finite());
        let singular = at.update().is_none() && finite(&at.rows) && at.jacobian.as_ref().iter().all(finite);
        NewtonFailure {
            reason: if singular {
                StepFailure::Singular
            } else {
                StepFailure::NotFinite
            },
            unknowns: z.as_ref().to_vec(),
            residual: self.linearize(z).rows.as_ref().to_vec(),
            updates: Vec::new(),
            other: Vec::new(),
        }
    }

    /// The unknowns of a step that turns as the last one did, where that turned by much: the last leg but one, mirrored
    /// in the last. No polynomial through the past foresees a path that goes to and fro.
    fn turned(&self, last: &S::Unknown<f64>) -> Option<S::Unknown<f64>> {
        let d = self.leg.d;
        let e = self.second_difference(last);
        let product = |x: &[f64; N], y: &[f64; N]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        // by the largest component first, for squares of any size
        let largest = d
            .iter()
            .chain(&e)
            .fold(0.0_f64, |largest, x| x.abs().max(largest));
        let (d, e) = (d.map(|d| d / largest), e.map(|e| e / largest));
        let length = product(&d, &d);
        if product(&e, &e) <= length || length == 0.0 {
            return None;
        }
        let before: [f64; N] = core::array::from_fn(|i| d[i] - e[i]);
        let stretch = 2.0 * product(&before, &d) / length;
        let e: [f64; N] = core::array::from_fn(|i| largest * ((stretch * d[i] - before[i]) - d[i]));
        e.iter().all(|e| e.is_finite()).then(|| self.unknowns(&e))
    }

    /// The unknowns of the continuous system's acceleration at `(q1, d/h)`.
    fn continuous(&self) -> Option<S::Unknown<f64>> {
        let v = self.leg.d.map(|d| d / self.h);
        let (a, multipliers) = start::acceleration(self.system, &self.leg.q, &v).ok()?;
        Some(self.system.unknown(&a.map(|a| a * self.h * self.h), &multipliers))
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
