//! One step: from a leg to the second difference that leads to the next node.

use crate::error::{NewtonFailure, StepFailure};
use crate::newton::{self, Equations, Root, Stop};
use crate::predictor::Predictor;
use crate::rounding;
use crate::start;
use crate::system::{Leg, System};
use crate::unknown::{Linearization, Unknown};

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
}

impl<S: System<N>, const N: usize> Equations for Step<'_, S, N> {
    type Z = S::Unknown<f64>;

    const LINEAR: bool = S::LINEAR;

    #[inline]
    fn linearize(&self, z: &Self::Z) -> Linearization<f64, Self::Z> {
        self.system.residual(self.constants, &self.known, z)
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
        predictor: &Predictor<S::Unknown<f64>>,
        max_iterations: u32,
    ) -> Result<(S::Unknown<f64>, StepReport), NewtonFailure> {
        let size = self.size(predictor);
        if let Some(start) = predictor.predict()
            && let Ok(root) = newton::solve(self, start, &size, max_iterations, &mut |_| {})
        {
            return Ok(report(root, Guess::Predicted));
        }
        self.solve_without_prediction(predictor, &size, max_iterations)
    }

    /// How large each unknown is expected to be: as lately, and not much smaller than the increment.
    #[inline]
    fn size(&self, predictor: &Predictor<S::Unknown<f64>>) -> S::Unknown<f64> {
        let increment = self.system.unknown(&self.leg.d);
        predictor
            .size()
            .zip(&increment, |past, d| past.max(SECOND_DIFFERENCE * d.abs()))
    }

    /// Solves the step from every guess but the prediction.
    #[cold]
    fn solve_without_prediction(
        &self,
        predictor: &Predictor<S::Unknown<f64>>,
        size: &S::Unknown<f64>,
        max_iterations: u32,
    ) -> Result<(S::Unknown<f64>, StepReport), NewtonFailure> {
        let first_step = predictor.last().is_none();
        let straight = (S::Unknown::<f64>::zero(), Guess::Straight);
        let continuous = self.continuous().map(|z| (z, Guess::Continuous));
        // the first step has the acceleration for its best guess; later the last solution is nearer
        let guesses = if first_step {
            [continuous, Some(straight), None]
        } else {
            [
                predictor.last().map(|z| (z, Guess::Last)),
                Some(straight),
                continuous,
            ]
        };
        for (start, guess) in guesses.into_iter().flatten() {
            if let Ok(root) = newton::solve(self, start, size, max_iterations, &mut |_| {}) {
                return Ok(report(root, guess));
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
        NewtonFailure {
            reason: StepFailure::NotFinite,
            unknowns: z.as_ref().to_vec(),
            residual: self.linearize(z).rows.as_ref().to_vec(),
            updates: Vec::new(),
        }
    }

    /// The unknowns of the continuous system's acceleration at `(q1, d/h)`.
    fn continuous(&self) -> Option<S::Unknown<f64>> {
        let v = self.leg.d.map(|d| d / self.h);
        let a = start::acceleration(self.system, &self.leg.q, &v).ok()?;
        Some(self.system.unknown(&a.map(|a| a * self.h * self.h)))
    }
}

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
