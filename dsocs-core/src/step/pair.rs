//! Steps with two solutions.

use super::any::{AnyStep, vector};
use super::elimination::Determinant;
use super::newton::{self, BENT, Root, relative};
use super::predictor::{Continuation, FITS, PAST, Predictor};
use super::unknown::{Linearization, Unknown};
use super::{Guess, Step, StepReport, report};
use crate::error::{NewtonFailure, StepFailure};
use crate::system::{Leg, System};

/// A root that is this many lengths of a leg away is not in question.
const FAR: f64 = 10.0;

/// Without a past, a root is the one that is meant if it is nearer to the continuous system's acceleration than this part of
/// the other one's distance.
const NEARER: f64 = 0.1;

/// How often the leg before is improved.
const FORMER: u32 = 4;

/// One of two roots.
enum Candidate {
    /// The one that was found first.
    Found,
    /// The other one.
    Other,
}

/// The solutions of a step.
pub(crate) struct Pair<Z> {
    /// The one that the iteration finds.
    pub found: (Z, StepReport),
    /// Another one.
    pub other: Option<Z>,
}

/// A root, and what the determinant there says of it.
pub(super) struct Found<Z> {
    /// The root.
    pub root: Root<Z>,
    /// Whether the determinant continues those of the steps before.
    pub continuation: Continuation,
}

/// Whether another root may be as near to the guess as this one.
#[inline]
pub(super) fn in_question<Z>(root: &Root<Z>, past_is_short: bool) -> bool {
    let straight = root.bend < BENT; // false for a NaN
    !straight && (root.close || past_is_short)
}

impl<Z: Unknown<f64>, const N: usize> dyn AnyStep<N, Z = Z> + '_ {
    /// Holds the determinant at a root against those of the steps before.
    #[cold]
    pub(super) fn continuation(&self, root: &Root<Z>, predictor: &mut Predictor<Z>) -> Continuation {
        if !self.are_watched() || self.are_linear() {
            return Continuation::Fits;
        }
        let determinant = if root.determinant.value.is_nan() {
            self.determinant(&root.z)
        } else {
            root.determinant
        };
        predictor.take_determinant(determinant)
    }

    /// Whether another root may be as near to the guess as this one.
    fn is_in_question(&self, root: &Root<Z>) -> bool {
        self.are_watched() && in_question(root, self.past_is_short())
    }

    /// The determinant of the rows' Jacobian.
    #[cold]
    fn determinant(&self, z: &Z) -> Determinant {
        Z::determinant(&self.linearize(z).jacobian)
    }

    /// A root, if no other one continues the motion for all that is known of it.
    #[cold]
    pub(super) fn checked(
        &self,
        Found { root, continuation }: Found<Z>,
        start: &Z,
        guess: Guess,
        predictor: &mut Predictor<Z>,
        size: &Z,
    ) -> Result<(Z, StepReport), NewtonFailure> {
        let other = match continuation {
            Continuation::Fits if !self.is_in_question(&root) => None,
            Continuation::Fits | Continuation::Departs => newton::nearby(self, start, &root.z, size),
            Continuation::Turned => self.other(start, &root.z, predictor, size),
        };
        let Some(other) = other else {
            return Ok(report(root, guess));
        };
        // a root beyond the lengths of the legs belongs to no motion
        let apart = other.zip(&root.z, |other, root| other - root);
        let legs = self
            .unknown(&self.leg().d, &[])
            .zip(size, |d, size| d.abs().max(size));
        if relative(&apart, &root.z, &legs) > FAR {
            return Ok(report(root, guess));
        }
        let candidate = match predictor.lately::<PAST>() {
            Some(past) => self.continued(&past, &root.z, &other, size),
            None => self.near_continuous(&root.z, &other, &legs),
        };
        match candidate {
            Some(Candidate::Found) => Ok(report(root, guess)),
            Some(Candidate::Other) => {
                predictor.take_determinant(self.determinant(&other));
                Ok(report(Root { z: other, ..root }, Guess::Other))
            }
            // the determinant alone is no reason to refuse a root to which all updates have led straight
            None if !self.is_in_question(&root) => Ok(report(root, guess)),
            // nearness to the guess does not tell: where roots change sides it picks the wrong one as often as not
            None => Err(NewtonFailure {
                reason: StepFailure::AmbiguousRoot,
                unknowns: root.z.as_ref().to_vec(),
                residual: self.linearize(&root.z).rows.as_ref().to_vec(),
                updates: Vec::new(),
                other: other.as_ref().to_vec(),
            }),
        }
    }

    /// Which of two roots continues the motion, if the past tells.
    ///
    /// The roots of a pair have Jacobians of opposite orientation, and along a motion the determinant changes smoothly,
    /// also where it passes through zero because the two roots change sides: there nearness to the past says nothing.
    /// Determinants are compared along the line through both roots, extrapolated from the last four steps.
    fn continued(&self, past: &[Z; PAST], found: &Z, other: &Z, size: &Z) -> Option<Candidate> {
        let mut leg = *self.leg();
        let mut former = [self.linearize(found).jacobian; PAST];
        for (place, (z, jacobian)) in past.iter().zip(&mut former).enumerate() {
            let rows;
            if let Some(past) = self.past() {
                (_, rows) = self.on_leg(&past[place], z);
            } else {
                (leg, rows) = self.former(&leg, z)?;
            }
            *jacobian = rows.jacobian;
        }
        let direction = other.zip(found, |other, found| other - found);
        // the determinants extrapolated in the first three degrees, in units of that at a root: all have to be near 1
        let fits = |root: &Z| {
            let now = self.linearize(root).jacobian;
            let part = |at| newton::orientation::<Z>(&now, at, &direction, size);
            let [a, b, c, d] = [
                part(&former[0])?,
                part(&former[1])?,
                part(&former[2])?,
                part(&former[3])?,
            ];
            let extrapolated = [2.0 * a - b, 3.0 * (a - b) + c, 4.0 * (a + c) - 6.0 * b - d];
            Some(
                extrapolated
                    .iter()
                    .all(|determinant| (determinant - 1.0).abs() <= FITS),
            )
        };
        match (fits(found)?, fits(other)?) {
            (true, false) => Some(Candidate::Found),
            (false, true) => Some(Candidate::Other),
            _ => None,
        }
    }

    /// Which of two roots the continuous system's acceleration speaks for, clearly.
    fn near_continuous(&self, found: &Z, other: &Z, legs: &Z) -> Option<Candidate> {
        let acceleration = self.continuous()?;
        let distance = |root: &Z| relative(&root.zip(&acceleration, |x, y| x - y), &acceleration, legs);
        let (found, other) = (distance(found), distance(other));
        if found < NEARER * other {
            Some(Candidate::Found)
        } else if other < NEARER * found {
            Some(Candidate::Other)
        } else {
            None
        }
    }

    /// The leg before a leg, and the rows of its step at its solution.
    fn former(&self, leg: &Leg<f64, N>, z: &Z) -> Option<(Leg<f64, N>, Linearization<f64, Z>)> {
        let (mut e, mut rows) = self.on_leg(leg, z);
        let mut former = *leg;
        // the second difference follows from the unknowns and, to a lesser degree, from the leg that is looked for
        for _ in 0..FORMER {
            former = Leg {
                q: core::array::from_fn(|i| leg.q[i] - leg.d[i]),
                d: core::array::from_fn(|i| leg.d[i] - e[i]),
            };
            (e, rows) = self.on_leg(&former, z);
        }
        former.d.iter().all(|d| d.is_finite()).then_some((former, rows))
    }

    /// The root nearest to a guess, whatever other roots there are.
    pub fn solve_near(
        &self,
        start: Z,
        predictor: &mut Predictor<Z>,
        size: &Z,
        max_iterations: u32,
    ) -> Result<(Z, StepReport), NewtonFailure> {
        match newton::solve_apart(self, start, size, max_iterations, &mut ()) {
            Ok(root) => {
                self.continuation(&root, predictor);
                Ok(report(root, Guess::Given))
            }
            Err(_) => Err(newton::explain(self, start, size, max_iterations)),
        }
    }

    /// The root nearest to a guess, without a past.
    #[cold]
    pub fn solve_from(&self, start: Z, max_iterations: u32) -> Result<(Z, StepReport), NewtonFailure> {
        let size = self.least();
        self.solve_near(start, &mut Predictor::new(), &size, max_iterations)
    }

    /// Another root than `root`, looked for by deflation from several guesses; first from the one that led to it.
    #[cold]
    fn other(&self, start: &Z, root: &Z, predictor: &Predictor<Z>, size: &Z) -> Option<Z> {
        let beside = |part: f64| root.zip(size, |root, size| root + part * root.abs().max(size));
        let guesses = [
            Some(*start),
            predictor.last(),
            self.continuous(),
            Some(Z::zero()),
            Some(beside(1e-6)),
            Some(beside(-1e-6)),
            Some(beside(1.0)),
            Some(beside(-1.0)),
        ];
        // each guess looked at from the root first, then by itself
        guesses.into_iter().flatten().find_map(|guess| {
            newton::nearby(self, &guess, root, size).or_else(|| newton::other_root(self, &guess, root, size))
        })
    }
}

impl<S: System<N>, const N: usize> Step<'_, S, N> {
    /// The root that [`Step::solve`] finds and another one, looked for by deflation from several guesses.
    pub fn pair(
        &self,
        predictor: &Predictor<S::Unknown<f64>>,
        max_iterations: u32,
    ) -> Result<Pair<S::Unknown<f64>>, NewtonFailure> {
        let size = self.size(predictor);
        let found = match self.solve(&mut { *predictor }, max_iterations) {
            Ok(found) => found,
            Err(failure) if failure.reason == StepFailure::AmbiguousRoot => {
                let found = self.any().solve_near(
                    vector(&failure.unknowns),
                    &mut { *predictor },
                    &size,
                    max_iterations,
                )?;
                return Ok(Pair {
                    found,
                    other: Some(vector(&failure.other)),
                });
            }
            Err(failure) => return Err(failure),
        };
        let root = found.0;
        let other = self.any().other(&root, &root, predictor, &size);
        Ok(Pair { found, other })
    }
}
