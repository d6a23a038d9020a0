//! Steps whose prediction does not lead to a root: other guesses, and the causes of a failure.

use super::pair::ComparedRoot;
use super::{Equations as _, Guess, Step, StepReport};
use crate::error::{FailedStep, StepError};
use crate::kernel::report::report;
use crate::regularity::Regularity;
use crate::regularity::deficiency::Singularity;
use crate::regularity::deficiency::{self, DependentRow};
use crate::regularity::dependence::NEARLY_DEPENDENT;
use crate::regularity::flat;
use crate::regularity::multipliers;
use crate::regularity::undefined;
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::solve::newton::{self, Fold, Root, Stop};
use crate::solve::predictor::Predictor;
use crate::solve::{Vector, is_finite, rotation};
use crate::start::place::Place;
use crate::start::{self, InitialAcceleration, third};
use crate::step::singular;

/// Number of iterations between the continuous system's third derivative and the acceleration that belongs to
/// it.
const THIRD_DERIVATIVE: usize = 4;

/// Number of steps ahead of a failed step in which a singularity is searched.
const AHEAD: f64 = 4.0;

/// A row counts as fulfilled if its relative residual is below this part of the largest one.
const UNMET: f64 = 1e-3;

/// Place of a failed step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FailurePlace<'a> {
    /// The number of the step's middle node.
    pub index: u64,
    /// Its time.
    pub time: f64,
    /// The first node.
    pub q0: &'a [f64],
}

impl Step<'_> {
    /// Whether the unknowns are third differences.
    pub(super) fn is_of_third_order(&self) -> bool {
        self.shape().is_of_third_order()
    }

    /// Solves the step from all guesses except the prediction.
    #[cold]
    pub fn solve_without_prediction(
        &self,
        predictor: &mut Predictor,
        size: &Vector,
        max_iterations: u32,
        mut evaluations: u32,
    ) -> Result<(Vector, StepReport), NewtonFailure> {
        let straight = (Vector::zero(self.shape().unknowns), Guess::Straight);
        let continuous = self.continuous().map(|z| (z, Guess::Continuous));
        let last = predictor.last().map(|z| (Vector::of(z), Guess::Last));
        let turned = predictor.last().and_then(|z| self.turned(z));
        // the first step has the acceleration as its best guess; later the last solution is nearer
        let guesses = if last.is_none() {
            [continuous.clone(), Some(straight.clone()), None, None]
        } else {
            [
                turned.map(|z| (z, Guess::EqualTurn)),
                last.clone(),
                Some(straight.clone()),
                continuous.clone(),
            ]
        };
        for (start, guess) in guesses.into_iter().flatten() {
            match newton::solve(self, &start, size, max_iterations, predictor) {
                Ok(root) => {
                    evaluations += root.evaluations;
                    let continuation = self.continuation(&root, predictor);
                    let root = Root { evaluations, ..root };
                    return self.checked(
                        ComparedRoot { root, continuation },
                        &start,
                        guess,
                        predictor,
                        size,
                    );
                }
                Err(failed) => evaluations += failed.evaluations,
            }
        }
        // at a straight line nothing decides between two roots that are mirror images of each other
        for start in self.beside_straight() {
            match newton::solve(self, &start, size, max_iterations, predictor) {
                Ok(root) => {
                    evaluations += root.evaluations;
                    let continuation = self.continuation(&root, predictor);
                    let root = Root { evaluations, ..root };
                    return self.checked(
                        ComparedRoot { root, continuation },
                        &start,
                        Guess::EqualTurn,
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
        let mut folds: Option<Fold> = None;
        for (start, _) in [Some(straight.clone()), last, continuous.clone()]
            .into_iter()
            .flatten()
        {
            match newton::follow(self, start, size, max_iterations, &mut evaluations) {
                Ok(root) => {
                    self.continuation(&root, predictor);
                    return Ok(report(Root { evaluations, ..root }, Guess::Homotopy));
                }
                Err(Some(fold)) if folds.as_ref().is_none_or(|best| fold.left < best.left) => {
                    folds = Some(fold);
                }
                Err(_) => {}
            }
        }
        let best = predictor
            .predict()
            .or(continuous.map(|(z, _)| z))
            .unwrap_or(straight.0);
        let failure = newton::explain(self, &best, size, max_iterations);
        Err(match folds {
            // no guess leads to a root, and the residual has a minimum at this fold
            Some(fold) if failure.reason == StepFailure::NotConverged => NewtonFailure {
                reason: StepFailure::NoSolution,
                unknowns: fold.z.to_vec(),
                residual: fold.rows.to_vec(),
                ..failure
            },
            _ => failure,
        })
    }

    /// The step in which several functions jump and no node solves the rows: the root of the affine rows on
    /// the pieces of a straight path.
    fn ahead(&self, evaluations: u32) -> Option<Root<Vector>> {
        if !(self.are_affine() && self.may_jump()) {
            return None;
        }
        let evaluation = newton::Quick::evaluate(
            self as &dyn newton::Equations,
            Vector::zero(self.shape().unknowns),
        );
        let update = evaluation.at.update;
        (evaluation.safe && update.is_finite()).then_some(Root {
            z: update,
            evaluations: evaluations + 1,
            stop: Stop::Jump,
            bend: 0.0,
            close: false,
            determinant: evaluation.determinant,
        })
    }

    /// The declared rows that the second difference `e` does not fulfil, each with its residual.
    fn unmet(&self, e: &[f64]) -> Vec<(DependentRow, f64)> {
        let (h, leg) = (self.h, self.leg);
        let declaration = self.declaration();
        let multipliers = multipliers::of_step(&declaration, h, leg, e);
        let rows = declaration.declared(h, leg, e, &multipliers);
        // relative to its change on the way from a straight line
        let straight = declaration.declared(h, leg, &Vector::zero(e.len()), &multipliers);
        let named = rows.iter().zip(&straight).enumerate();
        let parts: Vec<_> = named
            .map(|(i, (row, straight))| (i, *row, row.abs() / (row - straight).abs()))
            .collect();
        let largest = parts.iter().fold(0.0_f64, |largest, part| largest.max(part.2));
        let left = parts.into_iter().filter(|part| part.2 > UNMET * largest);
        left.map(|(i, row, _)| (deficiency::row(&declaration, i), row))
            .collect()
    }

    /// The failure of a step whose root is not finite, or whose affine rows are singular.
    #[cold]
    pub fn not_finite(&self, z: &[f64]) -> NewtonFailure {
        // affine rows without an update are singular
        let at = self.linearize(&Vector::zero(z.len()));
        let singular = at.update().is_none() && at.rows.is_finite() && is_finite(at.jacobian.entries());
        NewtonFailure {
            reason: if singular {
                StepFailure::Singular
            } else {
                StepFailure::NotFinite
            },
            unknowns: z.to_vec(),
            residual: self.linearize(z).rows.to_vec(),
            updates: Vec::new(),
            other: Vec::new(),
        }
    }

    /// The failure of a step whose root does not continue the motion.
    #[cold]
    pub fn refused(&self, reason: StepFailure, z: &[f64]) -> NewtonFailure {
        NewtonFailure {
            reason,
            unknowns: z.to_vec(),
            residual: self.linearize(z).rows.to_vec(),
            updates: Vec::new(),
            other: Vec::new(),
        }
    }

    /// The error of the step.
    #[cold]
    pub fn error(&self, at: &FailurePlace<'_>, cause: NewtonFailure) -> StepError {
        let (leg, before, size) = (self.leg, &self.before, self.shape().unknowns);
        let declaration = self.declaration();
        let e = self.second_difference(&Vector::resized(&cause.unknowns, size));
        let straight = Vector::zero(e.len());
        let open = |e: &[f64]| deficiency::of_step(&declaration, self.h, leg, e);
        let deficiency = match cause.reason {
            StepFailure::Singular => open(&e),
            // with rows that are singular up to rounding the iteration may end anywhere; such rows are singular on a straight line, too
            StepFailure::NotConverged => {
                open(&straight).and_then(|straight| open(&e).filter(|open| *open == straight))
            }
            StepFailure::NotFinite
            | StepFailure::Degenerate
            | StepFailure::AmbiguousRoot
            | StepFailure::PassesSingularity
            | StepFailure::PassesRest
            | StepFailure::Forks
            | StepFailure::TurnsTooFar
            | StepFailure::NoSolution => None,
        };
        let undefined = match cause.reason {
            StepFailure::NotFinite | StepFailure::Degenerate => {
                // on a straight line, if the iteration diverged
                let e = if e.is_finite() { &e } else { &straight };
                undefined::of_point(&declaration, declaration.point(self.h, leg, e).any())
            }
            _ => None,
        };
        let unmet = if cause.reason == StepFailure::NoSolution {
            self.unmet(&e)
        } else {
            Vec::new()
        };
        let next = |e: &[f64]| {
            let d: Vec<f64> = (0..e.len()).map(|i| leg.d[i] + (before[i] + e[i])).collect();
            rotation::moved(&self.shape().rotations, leg.q, &d)
        };
        let error = StepError::new(FailedStep {
            index: at.index,
            time: at.time,
            h: self.h,
            q0: at.q0.to_vec(),
            q1: leg.q.to_vec(),
            q2: next(&e),
            other: if cause.other.is_empty() {
                Vec::new()
            } else {
                next(&self.second_difference(&Vector::resized(&cause.other, size)))
            },
            regularity: Regularity::of_declaration(&declaration, self.h, leg, &e),
            coordinates: declaration
                .coordinates()
                .iter()
                .map(|coordinate| coordinate.name.clone())
                .collect(),
            may_divide: self.shape().may_divide(),
            deficiency,
            undefined,
            third_order: self.is_of_third_order(),
            singular_at: None,
            dependent: self.dependence(cause.reason),
            without_gradient: matches!(
                cause.reason,
                StepFailure::Singular
                    | StepFailure::NotConverged
                    | StepFailure::NoSolution
                    | StepFailure::AmbiguousRoot
            )
            .then(|| flat::without_gradient(&declaration, self.h, leg, &e))
            .flatten(),
            unmet,
            cause,
        });
        let may_be = matches!(
            error.details().cause.reason,
            StepFailure::NoSolution | StepFailure::NotConverged
        );
        match may_be.then(|| self.singularity_ahead()).flatten() {
            Some(singularity) => error.at(singularity),
            None => error,
        }
    }

    /// The time and the first dependent row of dependent constraints on positions and velocities, if a step
    /// without a solution approaches such a place.
    fn dependence(&self, reason: StepFailure) -> Option<(f64, DependentRow)> {
        let declaration = self.declaration();
        if declaration.lower() == 0 || !matches!(reason, StepFailure::NoSolution | StepFailure::NotConverged)
        {
            return None;
        }
        let (leg, h) = (self.leg, self.h);
        let path = |part: f64| {
            let steps = AHEAD * part - 1.0;
            if self.is_of_third_order() {
                let none = Vector::zero(leg.d.len());
                return Place::on_cubic(h, leg, &self.before, &none, steps);
            }
            let displacement = Vector::of(leg.d).map(|d| steps * d);
            let q = rotation::moved_vector(&self.shape().rotations, leg.q, &displacement);
            Place::of_phase(leg.t + steps * h, q, Vector::of(leg.d).map(|d| d / h))
        };
        singular::dependence(&declaration, &path, NEARLY_DEPENDENT)
    }

    /// The singularity that a step without a solution approaches, if there is one.
    pub(crate) fn singularity_ahead(&self) -> Option<Singularity> {
        let (leg, h) = (self.leg, self.h);
        let declaration = self.declaration();
        if self.is_of_third_order() {
            // extrapolated with the jerk in the middle of the leg
            let none = Vector::zero(leg.d.len());
            let Place { t, q, v, a } = Place::on_cubic(h, leg, &self.before, &none, -0.5);
            let j = third::jerk(&declaration, t, [&q, &v, &a], &none)?;
            let e = Vector::of(&j).map(|j| h * h * h * j);
            let path = [-0.5, AHEAD].map(|steps| Place::on_cubic(h, leg, &self.before, &e, steps));
            return singular::on_path(&declaration, &path, &j);
        }
        let (q, v) = (Vector::of(leg.q), Vector::of(leg.d).map(|d| d / h));
        let (a, _) = start::acceleration(&declaration, (leg.t, &q, &v), None).ok()?;
        // extrapolated with the acceleration in the middle of the leg
        let at = |steps: f64| {
            let displacement = v.map(|v| steps * h * v);
            let q = rotation::moved_vector(&self.shape().rotations, &q, &displacement);
            Place::of_phase(leg.t + steps * h, q, v.zip(&a, |v, a| v + (steps + 0.5) * h * a))
        };
        singular::on_path(&declaration, &[at(-0.5), at(AHEAD)], &a)
    }

    /// The unknowns of a step that turns as the last one did, if that turned by much: the last leg but one,
    /// mirrored at the last. A polynomial through the past cannot predict a path that moves to and fro.
    fn turned(&self, last: &[f64]) -> Option<Vector> {
        if self.is_of_third_order() {
            return None;
        }
        let d = self.leg.d;
        let e = self.second_difference(last);
        let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        // divided by the largest component first, against overflow of squares
        let largest = d
            .iter()
            .chain(e.iter())
            .fold(0.0_f64, |largest, x| x.abs().max(largest));
        let (d, e) = (Vector::of(d).map(|d| d / largest), e.map(|e| e / largest));
        let length = product(&d, &d);
        if product(&e, &e) <= length || length == 0.0 {
            return None;
        }
        let before = d.zip(&e, |d, e| d - e);
        let stretch = 2.0 * product(&before, &d) / length;
        let e = d.zip(&before, |d, before| largest * ((stretch * d - before) - d));
        e.is_finite().then(|| self.unknowns(&e))
    }

    /// The unknowns of paths that turn from the straight line, by a little and by more, to both sides.
    fn beside_straight(&self) -> [Vector; 4] {
        let d = self.leg.d;
        let longest = d.iter().fold(0.0_f64, |longest, d| longest.max(d.abs()));
        let by = |turn: f64| {
            // parallel to no axis, and to no usual diagonal
            let e = deficiency::beside(&vec![0.0; d.len()], turn * longest);
            self.unknown(&e, &[])
        };
        [by(1.0), by(-1.0), by(6.0), by(-6.0)]
    }

    /// The unknowns of the continuous system's third derivative in the middle of the leg, searched near a
    /// third difference.
    pub(super) fn continuous_of_third(&self, near: &[f64]) -> Option<Vector> {
        let (leg, h, before) = (self.leg, self.h, &self.before);
        let q = Vector::of(leg.q).zip(leg.d, |q, d| q - 0.5 * d);
        let v = Vector::of(leg.d).map(|d| d / h);
        let cube = h * h * h;
        let declaration = self.declaration();
        let improved = |third: &[f64], near: &[f64]| -> Option<Vector> {
            let a = before.zip(third, |before, third| (before + 0.5 * third) / (h * h));
            let near = Vector::of(near).map(|near| near / cube);
            let j = third::jerk(&declaration, leg.t - 0.5 * h, [&q, &v, &a], &near)?;
            Some(Vector::of(&j).map(|j| j * cube))
        };
        // iterated with the acceleration that belongs to it
        let mut third = Vector::zero(before.len());
        for _ in 1..THIRD_DERIVATIVE {
            third = improved(&third, &third)?;
        }
        Some(self.unknowns(&improved(&third, near)?))
    }

    /// The unknowns of the acceleration that was given for the start, else of the continuous system's at
    /// `(q1, d/h)`, else of that at the start.
    pub(super) fn continuous(&self) -> Option<Vector> {
        let (leg, h) = (self.leg, self.h);
        if self.is_of_third_order() {
            return self.continuous_of_third(&Vector::zero(leg.d.len()));
        }
        let begins = |a: &Vector| Some(self.unknowns(&a.map(|a| a * h * h)));
        if let Some(InitialAcceleration::Given(a)) = &self.initial_acceleration {
            return begins(a);
        }
        let v = Vector::of(leg.d).map(|d| d / h);
        let found = start::acceleration(&self.declaration(), (leg.t, leg.q, &v), None);
        match (found, &self.initial_acceleration) {
            (Ok((a, multipliers)), _) => Some(self.unknown(&a.map(|a| a * h * h), &multipliers)),
            (Err(_), Some(InitialAcceleration::Given(a) | InitialAcceleration::Computed(a))) => begins(a),
            (Err(_), None) => None,
        }
    }
}
