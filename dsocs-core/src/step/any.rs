//! What is done seldom in a step, whatever the type of the system: other guesses than the prediction, and what is told of a failure.

use super::newton::{self, Equations, Fold, Root, Stop};
use super::pair::Found;
use super::predictor::{PAST, Predictor};
use super::unknown::{Linearization, Unknown};
use super::{Begins, Guess, SECOND_DIFFERENCE, Step, StepReport, report};
use crate::any::AnySystem;
use crate::array;
use crate::declaration::Declaration;
use crate::deficiency::{self, DependentRow};
use crate::error::{FailedStep, NewtonFailure, StepError, StepFailure};
use crate::multipliers;
use crate::regularity::Regularity;
use crate::system::{Leg, System};
use crate::undefined;

/// The equations of one step of a system of any type with `N` coordinates.
///
/// What takes a step in this form is compiled once for each number of coordinates and unknowns, not for every system.
pub(crate) trait AnyStep<const N: usize>: Equations {
    /// The system.
    fn system(&self) -> &dyn AnySystem<N>;

    /// The declaration, after the second difference that a step of third order goes on from: [`AnyStep::before`].
    fn declaration<'a>(&'a self, before: &'a [f64; N]) -> Declaration<'a>;

    /// That second difference, and zero of second order.
    fn before(&self) -> [f64; N];

    /// The step.
    fn h(&self) -> f64;

    /// The step's first two nodes.
    fn leg(&self) -> &Leg<f64, N>;

    /// The acceleration with which the motion begins, where the step is the first.
    fn begins(&self) -> Option<&Begins<N>>;

    /// The legs of the last solutions, the last first, where these do not lie one step apart.
    fn past(&self) -> Option<&[Leg<f64, N>; PAST]>;

    /// The unknowns that belong to a second difference and to multipliers.
    fn unknown(&self, e: &[f64; N], multipliers: &[f64]) -> Self::Z;

    /// The second difference that belongs to the unknowns.
    fn second_difference(&self, z: &Self::Z) -> [f64; N];

    /// The second difference and the rows of the step that begins with another leg.
    fn on_leg(&self, leg: &Leg<f64, N>, z: &Self::Z) -> ([f64; N], Linearization<f64, Self::Z>);

    /// What the rows are, divided by the declared ones, where they are not the same.
    fn scales(&self, z: &Self::Z) -> Option<Self::Z>;
}

/// Makes the equations of steps of any length, whose unknowns are `Z`; every system does.
pub(crate) trait Steps<Z, const N: usize> {
    /// Hands on the equations of the step `h` that begins with a leg.
    fn step(&self, h: f64, leg: &Leg<f64, N>, take: &mut dyn FnMut(&dyn AnyStep<N, Z = Z>));
}

impl<S: System<N>, const N: usize> Steps<S::Unknown<f64>, N> for S {
    fn step(&self, h: f64, leg: &Leg<f64, N>, take: &mut dyn FnMut(&dyn AnyStep<N, Z = S::Unknown<f64>>)) {
        let constants = self.constants(&self.parameters(), h);
        take(&Step::new(self, &constants, *leg, h));
    }
}

/// How far a guess is from the straight line, in units of the longest leg, coordinate by coordinate.
const ASIDE: [f64; 3] = [0.083, -0.117, 0.059];

/// How often the continuous system's third derivative is improved by the acceleration that belongs to it.
const THIRD_DERIVATIVE: usize = 4;

/// A row that is left by less than this part of what is left of another one is met.
const UNMET: f64 = 1e-3;

/// Where and when a step failed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Failing<const N: usize> {
    /// The number of the step's middle node.
    pub index: u64,
    /// Its time.
    pub time: f64,
    /// The first node.
    pub q0: [f64; N],
}

/// Whether all numbers are finite.
pub(super) fn finite<Z: Unknown<f64>>(values: &Z) -> bool {
    values.as_ref().iter().all(|x| x.is_finite())
}

/// As many unknowns as there are values; those without one are zero.
pub(super) fn vector<Z: Unknown<f64>>(values: &[f64]) -> Z {
    let mut z = Z::zero();
    for (z, value) in z.as_mut().iter_mut().zip(values) {
        *z = *value;
    }
    z
}

impl<Z: Unknown<f64>, const N: usize> dyn AnyStep<N, Z = Z> + '_ {
    /// Whether the unknowns are third differences.
    pub(super) fn is_of_third_order(&self) -> bool {
        !self.system().third_order().is_empty()
    }

    /// The unknowns that belong to a second difference, with the multipliers that come nearest to its constraint force.
    pub fn unknowns(&self, e: &[f64; N]) -> Z {
        let multipliers =
            multipliers::of_step(&self.declaration(&self.before()), self.h(), self.leg().any(), e);
        self.unknown(e, &multipliers)
    }

    /// The sign of the determinant of the rows, as they were declared.
    pub fn orientation(&self, z: &Z) -> f64 {
        let sign = Z::determinant(&self.linearize(z).jacobian).value.signum();
        let scales = self.scales(z);
        let scales = scales.iter().flat_map(Z::as_ref);
        scales.fold(sign, |sign, scale| sign * scale.signum())
    }

    /// How large each unknown is expected to be without a past.
    pub fn least(&self) -> Z {
        let increment = self.unknown(&self.leg().d, &[]);
        increment.zip(&increment, |d, _| SECOND_DIFFERENCE * d.abs())
    }

    /// Solves the step from every guess but the prediction.
    #[cold]
    pub fn solve_without_prediction(
        &self,
        predictor: &mut Predictor<Z>,
        size: &Z,
        max_iterations: u32,
        mut evaluations: u32,
    ) -> Result<(Z, StepReport), NewtonFailure> {
        let straight = (Z::zero(), Guess::Straight);
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
                    let continuation = self.continuation(&root, predictor);
                    let root = Root { evaluations, ..root };
                    return self.checked(Found { root, continuation }, &start, guess, predictor, size);
                }
                Err(failed) => evaluations += failed.evaluations,
            }
        }
        // a straight line is a point where nothing decides between two roots if these are each other's mirror images
        for start in self.beside_straight() {
            match newton::solve_apart(self, start, size, max_iterations, predictor) {
                Ok(root) => {
                    evaluations += root.evaluations;
                    let continuation = self.continuation(&root, predictor);
                    let root = Root { evaluations, ..root };
                    return self.checked(
                        Found { root, continuation },
                        &start,
                        Guess::Turned,
                        predictor,
                        size,
                    );
                }
                Err(failed) => evaluations += failed.evaluations,
            }
        }
        if let Some(root) = self.ahead(evaluations) {
            return Ok(report(root, Guess::Straight));
        }
        let mut folds: Option<Fold<Z>> = None;
        for (start, _) in [Some(straight), last, continuous].into_iter().flatten() {
            match newton::follow(self, start, size, max_iterations, &mut evaluations) {
                Ok(root) => {
                    self.continuation(&root, predictor);
                    return Ok(report(Root { evaluations, ..root }, Guess::Followed));
                }
                Err(Some(fold)) if folds.is_none_or(|best| fold.left < best.left) => folds = Some(fold),
                Err(_) => {}
            }
        }
        let best = predictor
            .predict()
            .or(continuous.map(|(z, _)| z))
            .unwrap_or(straight.0);
        let failure = newton::explain(self, best, size, max_iterations);
        Err(match folds {
            // nothing leads to a root, and this is where the rows stop to come nearer to zero
            Some(fold) if failure.reason == StepFailure::NotConverged => NewtonFailure {
                reason: StepFailure::NoSolution,
                unknowns: fold.z.as_ref().to_vec(),
                residual: fold.rows.as_ref().to_vec(),
                ..failure
            },
            _ => failure,
        })
    }

    /// Where several functions jump in one step and no node solves the rows: the node that does if each has the value of a path that goes straight
    /// on.
    fn ahead(&self, evaluations: u32) -> Option<Root<Z>> {
        if !(self.are_affine() && self.may_jump()) {
            return None;
        }
        let at = self.evaluate(&Z::zero());
        (at.safe && finite(&at.update)).then_some(Root {
            z: at.update,
            evaluations: evaluations + 1,
            stop: Stop::Jump,
            bend: 0.0,
            close: false,
            determinant: at.determinant,
        })
    }

    /// The rows, as they were declared, that are not met at the second difference `e`, and what is left of each.
    fn unmet(&self, e: &[f64; N]) -> Vec<(DependentRow, f64)> {
        let (h, leg, before) = (self.h(), self.leg().any(), self.before());
        let declaration = self.declaration(&before);
        let multipliers = multipliers::of_step(&declaration, h, leg, e);
        let rows = declaration.declared(h, leg, e, &multipliers);
        // each against what it changes by on the way from a straight line
        let straight = declaration.declared(h, leg, &[0.0; N], &multipliers);
        let named = rows.iter().zip(&straight).enumerate();
        let parts: Vec<_> = named
            .map(|(i, (row, straight))| (i, *row, row.abs() / (row - straight).abs()))
            .collect();
        let largest = parts.iter().fold(0.0_f64, |largest, part| largest.max(part.2));
        let left = parts.into_iter().filter(|part| part.2 > UNMET * largest);
        left.map(|(i, row, _)| (deficiency::row(&declaration, i), row))
            .collect()
    }

    /// The failure of a step whose rows have a root that leads to no finite node.
    #[cold]
    pub fn not_finite(&self, z: &Z) -> NewtonFailure {
        // affine rows without an update are singular
        let at = self.linearize(&Z::zero());
        let singular =
            at.update().is_none() && finite(&at.rows) && at.jacobian.as_ref().iter().all(finite::<Z>);
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

    /// The error of the step.
    #[cold]
    pub fn error(&self, at: &Failing<N>, cause: NewtonFailure) -> StepError {
        let (leg, before) = (self.leg(), self.before());
        let declaration = self.declaration(&before);
        let e = self.second_difference(&vector(&cause.unknowns));
        let open = |e: &[f64; N]| deficiency::of_step(&declaration, self.h(), leg.any(), e);
        let deficiency = match cause.reason {
            StepFailure::Singular => open(&e),
            // rows that are singular but for rounding send the iteration anywhere: these are so on a straight line, too
            StepFailure::NotConverged => {
                open(&[0.0; N]).and_then(|straight| open(&e).filter(|open| *open == straight))
            }
            StepFailure::NotFinite
            | StepFailure::Degenerate
            | StepFailure::AmbiguousRoot
            | StepFailure::NoSolution => None,
        };
        let undefined = match cause.reason {
            StepFailure::NotFinite | StepFailure::Degenerate => {
                // on a straight line, where the iteration went nowhere
                let e = if e.iter().all(|e| e.is_finite()) {
                    e
                } else {
                    [0.0; N]
                };
                undefined::of_point(&declaration, declaration.point(self.h(), leg.any(), &e).any())
            }
            _ => None,
        };
        let unmet = if cause.reason == StepFailure::NoSolution {
            self.unmet(&e)
        } else {
            Vec::new()
        };
        let next = |e: [f64; N]| {
            (0..N)
                .map(|i| leg.q[i] + (leg.d[i] + (before[i] + e[i])))
                .collect()
        };
        StepError::new(FailedStep {
            index: at.index,
            time: at.time,
            h: self.h(),
            q0: at.q0.to_vec(),
            q1: leg.q.to_vec(),
            q2: next(e),
            other: if cause.other.is_empty() {
                Vec::new()
            } else {
                next(self.second_difference(&vector(&cause.other)))
            },
            regularity: Regularity::of_declaration(&declaration, self.h(), leg.any(), &e),
            coordinates: declaration
                .coordinates()
                .iter()
                .map(|coordinate| coordinate.name.clone())
                .collect(),
            may_divide: self.system().may_divide(),
            deficiency,
            undefined,
            unmet,
            cause,
        })
    }

    /// The unknowns of a step that turns as the last one did, where that turned by much: the last leg but one, mirrored
    /// in the last. No polynomial through the past foresees a path that goes to and fro.
    fn turned(&self, last: &Z) -> Option<Z> {
        if self.is_of_third_order() {
            return None;
        }
        let d = self.leg().d;
        let e = self.second_difference(last);
        let product = |x: &[f64; N], y: &[f64; N]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        // by the largest component first, for squares of any size
        let largest = d
            .iter()
            .chain(&e)
            .fold(0.0_f64, |largest, x| x.abs().max(largest));
        let (d, e) = (array::map(&d, |d| d / largest), array::map(&e, |e| e / largest));
        let length = product(&d, &d);
        if product(&e, &e) <= length || length == 0.0 {
            return None;
        }
        let before: [f64; N] = array::from_fn(|i| d[i] - e[i]);
        let stretch = 2.0 * product(&before, &d) / length;
        let e: [f64; N] = array::from_fn(|i| largest * ((stretch * d[i] - before[i]) - d[i]));
        e.iter().all(|e| e.is_finite()).then(|| self.unknowns(&e))
    }

    /// The unknowns of paths that leave the straight line a little, and more: to one side, and to the other.
    fn beside_straight(&self) -> [Z; 4] {
        let d = self.leg().d;
        let longest = d.iter().fold(0.0_f64, |longest, d| longest.max(d.abs()));
        let by = |turn: f64| {
            let mut e = [0.0; N];
            for (i, e) in e.iter_mut().enumerate() {
                // along no axis, and along none of the usual diagonals
                *e = turn * longest * ASIDE[i % ASIDE.len()];
            }
            self.unknown(&e, &[])
        };
        [by(1.0), by(-1.0), by(6.0), by(-6.0)]
    }

    /// The unknowns of the continuous system's third derivative in the middle of the leg, looked for near a third difference.
    pub(super) fn continuous_of_third(&self, near: &[f64; N]) -> Option<Z> {
        let (leg, h, before) = (self.leg(), self.h(), self.before());
        let q = array::from_fn(|i| leg.q[i] - 0.5 * leg.d[i]);
        let v = array::map(&leg.d, |d| d / h);
        let cube = h * h * h;
        let third_order = self.system().of_third_order()?;
        let improved = |third: &[f64; N], near: &[f64; N]| -> Option<[f64; N]> {
            let a = array::from_fn(|i| (before[i] + 0.5 * third[i]) / (h * h));
            let near = array::map(near, |near| near / cube);
            let j = third_order.jerk(leg.t - 0.5 * h, [&q, &v, &a], &near)?;
            Some(array::map(&j, |j| j * cube))
        };
        // with the acceleration of one of them, whatever is near
        let mut third = [0.0; N];
        for _ in 1..THIRD_DERIVATIVE {
            third = improved(&third, &third)?;
        }
        Some(self.unknowns(&improved(&third, near)?))
    }

    /// The unknowns of the acceleration with which the motion is said to begin or, where nothing was said, of the continuous
    /// system's at `(q1, d/h)`; where that has none, of the acceleration at the start.
    pub(super) fn continuous(&self) -> Option<Z> {
        let (leg, h) = (self.leg(), self.h());
        if self.is_of_third_order() {
            return self.continuous_of_third(&[0.0; N]);
        }
        let begins = |a: &[f64; N]| Some(self.unknowns(&array::map(a, |a| a * h * h)));
        if let Some(Begins::Said(a)) = self.begins() {
            return begins(a);
        }
        let v = array::map(&leg.d, |d| d / h);
        match (
            self.system().acceleration((leg.t, &leg.q, &v), None),
            self.begins(),
        ) {
            (Ok((a, multipliers)), _) => Some(self.unknown(&array::map(&a, |a| a * h * h), &multipliers)),
            (Err(_), Some(Begins::Said(a) | Begins::Found(a))) => begins(a),
            (Err(_), None) => None,
        }
    }
}
