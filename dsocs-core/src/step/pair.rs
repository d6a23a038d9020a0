//! Steps with two solutions: which of two roots continues the motion.

use super::{Guess, Step, StepReport};
use crate::kernel::report::report;
use crate::kernel::run_state::MAX_ITERATIONS;
use crate::number::point::{AnyLeg, OwnedLeg, map};
use crate::solve::elimination::Determinant;
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::solve::newton::{self, BENT, Equations as _, Linearized, Root, Stop, relative};
use crate::solve::predictor::{Continuation, Predictor};
use crate::solve::{Vector, is_finite, rotation};
use crate::start;

/// A root farther away than this many lengths of a leg is discarded.
const FAR: f64 = 10.0;

/// Roots closer than this many lengths of a leg differ by rounding: they are the same.
const ONE: f64 = 16.0 * f64::EPSILON;

/// A root farther away than half a leg is considered only if the updates did not converge directly to the one
/// that was found.
const NEAR: f64 = 0.5;

/// A root is chosen if its distance from the extrapolated past (without one, from the continuous system's
/// acceleration) is less than this part of the other root's distance.
const NEARER: f64 = 0.1;

/// A root that took more evaluations than this was not predicted.
pub(crate) const MANY: u32 = 5;

/// From this number of past solutions on, unknowns alone or determinants alone can decide which root
/// continues them.
const ENOUGH: usize = 3;

/// Largest relative deviation of the chosen root's determinant from its extrapolation.
const TELLS: f64 = 0.4;

/// Accelerations of the continuous system are equal if they differ by less than this, relative to themselves
/// and to the legs.
const SAME: f64 = 1e-6;

/// Number of iterations to find the leg before.
const FORMER: u32 = 4;

/// One of two roots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Candidate {
    /// The root that was found first.
    First,
    /// The other root.
    Other,
}

/// The solutions of a step.
pub(crate) struct Pair {
    /// The root that the iteration finds.
    pub found: (Vector, StepReport),
    /// Another root.
    pub other: Option<Vector>,
}

/// A root, and its determinant compared with the past.
pub(super) struct ComparedRoot {
    /// The root.
    pub root: Root<Vector>,
    /// Whether the determinant continues those of the steps before.
    pub continuation: Continuation,
}

/// The root that is supported, if only one of two is.
fn one_of(found: bool, other: bool) -> Option<Candidate> {
    match (found, other) {
        (true, false) => Some(Candidate::First),
        (false, true) => Some(Candidate::Other),
        _ => None,
    }
}

/// Polynomial extrapolations to the next value after the last ones, given from the last back: of degrees 1 to
/// 3 from four values; from fewer, of the degrees that they determine.
fn extrapolations(past: &[f64]) -> Vec<f64> {
    match *past {
        [a] => vec![a],
        [a, b] => vec![a, 2.0 * a - b],
        [a, b, c] => vec![2.0 * a - b, 3.0 * (a - b) + c],
        [a, b, c, d, ..] => vec![2.0 * a - b, 3.0 * (a - b) + c, 4.0 * (a + c) - 6.0 * b - d],
        [] => Vec::new(),
    }
}

/// The root to which the unknowns of the last steps extrapolate: all extrapolations have to be [`NEARER`] to
/// it.
fn continued_unknowns(past: &[Vector], found: &Vector, other: &Vector, size: &Vector) -> Option<Candidate> {
    let guesses = |past: &[Vector]| -> Vec<Vector> {
        let mut guesses: Vec<Vector> = Vec::new();
        for i in 0..found.len() {
            let values: Vec<f64> = past.iter().map(|z| z[i]).collect();
            let extrapolated = extrapolations(&values);
            guesses.resize_with(extrapolated.len(), || Vector::zero(found.len()));
            for (guess, value) in guesses.iter_mut().zip(extrapolated) {
                guess[i] = value;
            }
        }
        guesses
    };
    let (mut now, last) = (guesses(past), past.first()?);
    if past.len() == ENOUGH - 1 {
        // at the beginning of a motion the last value alone is no guess
        now.drain(..1.min(now.len()));
    }
    // the extrapolation has to be reliable: it would have predicted the last solution, too
    let before = guesses(
        past.get(1..)
            .filter(|before| before.len() >= ENOUGH - 1)
            .unwrap_or(&[]),
    );
    // along the line through both roots, with one at 0 and the other at 1
    let line = other.zip(found, |other, found| other - found);
    let square = newton::scalar_product(&line, &line, size);
    let along = |from: &Vector, to: &Vector| {
        newton::scalar_product(&to.zip(from, |to, from| to - from), &line, size) / square
    };
    let worth = before.iter().all(|guess| along(last, guess).abs() < NEARER);
    let leads_to = |root: &Vector| worth && now.iter().all(|guess| along(root, guess).abs() < NEARER);
    one_of(leads_to(found), leads_to(other))
}

/// Whether another root may be as near to the guess as this one.
#[inline]
pub(crate) fn is_ambiguous<Z>(root: &Root<Z>, past_is_short: bool) -> bool {
    let straight = root.bend < BENT; // false for a NaN
    !straight && (root.close || past_is_short || root.evaluations > MANY)
}

impl Step<'_> {
    /// Compares the determinant at a root with those of the steps before.
    #[cold]
    pub(super) fn continuation(&self, root: &Root<Vector>, predictor: &mut Predictor) -> Continuation {
        let determinant = if root.determinant.value.is_nan() {
            self.determinant(&root.z)
        } else {
            root.determinant
        };
        let continuation = predictor.take_determinant(determinant);
        if self.are_watched() {
            continuation
        } else {
            Continuation::Fits
        }
    }

    /// Whether another root may be as near to the guess as this one.
    fn is_ambiguous(&self, root: &Root<Vector>) -> bool {
        self.are_watched() && is_ambiguous(root, self.past_is_short)
    }

    /// The determinant of the rows' Jacobian.
    #[cold]
    fn determinant(&self, z: &[f64]) -> Determinant {
        self.linearize(z).jacobian.determinant()
    }

    /// Returns a root, unless another one continues the motion or the choice is ambiguous.
    #[cold]
    pub(super) fn checked(
        &self,
        ComparedRoot { root, continuation }: ComparedRoot,
        start: &Vector,
        guess: Guess,
        predictor: &mut Predictor,
        size: &Vector,
    ) -> Result<(Vector, StepReport), NewtonFailure> {
        if root.stop == Stop::Jump {
            return Ok(report(root, guess));
        }
        let legs = self
            .unknown(self.leg.d, &[])
            .zip(size, |d, size| d.abs().max(size));
        // a root farther away than the legs allow belongs to no motion, whether found first or second
        let reach = self.reach(&legs);
        if continuation != Continuation::Fits && relative(&root.z, &Vector::zero(size.len()), &reach) > FAR {
            return self.nearer(&root, predictor, [size, &reach]);
        }
        // a root that was found without a past or an acceleration is in doubt, however directly the iteration
        // converged
        let unforeseen = self.are_watched() && predictor.last().is_none() && guess != Guess::Continuous;
        let other = match continuation {
            Continuation::Fits if unforeseen => self.other(start, &root.z, predictor, size),
            Continuation::Fits if !self.is_ambiguous(&root) => None,
            Continuation::Fits => newton::nearby(self, start, &root.z, size),
            Continuation::Departs | Continuation::SignChanged => self.other(start, &root.z, predictor, size),
        };
        let Some(other) = other else {
            return Ok(report(root, guess));
        };
        let apart = other.zip(&root.z, |other, root| other - root);
        let distance = relative(&apart, &root.z, &legs);
        if distance > FAR || distance <= ONE {
            return Ok(report(root, guess));
        }
        let past = predictor.past();
        let candidate = if past.is_empty() {
            self.near_continuous(&root.z, &other, &legs)
        } else {
            self.continued(&past, &root.z, &other, size, &legs)
        };
        match candidate {
            Some(Candidate::First) => Ok(report(root, guess)),
            Some(Candidate::Other) => {
                predictor.take_determinant(self.determinant(&other));
                Ok(report(Root { z: other, ..root }, Guess::Other))
            }
            // the determinant alone does not refuse a root to which all updates converged directly, if the
            // other is not near
            None if distance > NEAR && !unforeseen && !self.is_ambiguous(&root) => Ok(report(root, guess)),
            // nearness to the guess does not decide: where roots change sides it picks the wrong one as often
            // as not
            None => Err(self.ambiguous(&root.z, &other)),
        }
    }

    /// The sizes beyond which an unknown belongs to no motion: those of the legs; infinite for multipliers,
    /// which may grow by any factor.
    fn reach(&self, legs: &Vector) -> Vector {
        // values for which no combination of second differences that is an unknown vanishes
        let is_difference = self.unknown(
            &Vector::from_fn(self.leg.d.len(), |i| 1.0 + 0.618_034 * i as f64),
            &[],
        );
        legs.zip(
            &is_difference,
            |legs, part| if part == 0.0 { f64::INFINITY } else { legs },
        )
    }

    /// The failure of a step with two roots.
    fn ambiguous(&self, root: &[f64], other: &[f64]) -> NewtonFailure {
        NewtonFailure {
            reason: StepFailure::AmbiguousRoot,
            unknowns: root.to_vec(),
            residual: self.linearize(root).rows.to_vec(),
            updates: Vec::new(),
            other: other.to_vec(),
        }
    }

    /// The root that continues the motion if the iteration went to one far beyond the legs: another guess
    /// leads to it, and the determinant confirms it.
    #[cold]
    fn nearer(
        &self,
        far: &Root<Vector>,
        predictor: &mut Predictor,
        [size, legs]: [&Vector; 2],
    ) -> Result<(Vector, StepReport), NewtonFailure> {
        let guesses = [
            (predictor.last().map(Vector::of), Guess::Last),
            (Some(Vector::zero(size.len())), Guess::Straight),
            (self.continuous(), Guess::Continuous),
        ];
        let mut evaluations = far.evaluations;
        let mut other = None;
        for (start, guess) in guesses {
            let Some(start) = start else { continue };
            let Ok(root) = newton::solve(self, &start, size, MAX_ITERATIONS, &mut ()) else {
                continue;
            };
            evaluations += root.evaluations;
            if relative(&root.z, &Vector::zero(size.len()), legs) > FAR {
                let apart = root.z.zip(&far.z, |root, far| root - far);
                if guess == Guess::Continuous && relative(&apart, &far.z, size) <= SAME {
                    predictor.take_determinant(self.determinant(&root.z));
                    return Ok(report(Root { evaluations, ..root }, guess));
                }
                continue;
            }
            if predictor.take_determinant(self.determinant(&root.z)) == Continuation::Fits {
                return Ok(report(Root { evaluations, ..root }, guess));
            }
            other.get_or_insert(root.z);
        }
        Err(match other {
            Some(other) => self.ambiguous(&far.z, &other),
            // no second root: the iteration diverged, and no guess leads back
            None => NewtonFailure {
                reason: StepFailure::NotConverged,
                other: Vec::new(),
                ..self.ambiguous(&far.z, &far.z)
            },
        })
    }

    /// The root that continues the motion, if the past decides.
    ///
    /// The roots of a pair have Jacobians of opposite orientation. Along a motion the determinant changes
    /// smoothly, also where it passes through zero because the two roots change sides. So do the unknowns, if
    /// the step is short enough. Both may be extrapolated from the last steps; the results must not
    /// contradict each other.
    ///
    /// One or two past solutions are not enough for either. Then the continuous system's acceleration decides
    /// as at the first step, if the past does not contradict it and the acceleration is unique: of two, the
    /// start has chosen one.
    fn continued(
        &self,
        past: &[Vector],
        found: &Vector,
        other: &Vector,
        size: &Vector,
        legs: &Vector,
    ) -> Option<Candidate> {
        let by_unknowns = continued_unknowns(past, found, other, size);
        let by_determinants = self.continued_determinants(past, found, other, size);
        match (by_determinants, by_unknowns) {
            (Some(one), Some(another)) => (one == another).then_some(one),
            (by_the_past, None) | (None, by_the_past) if past.len() < ENOUGH => self
                .near_continuous(found, other, legs)
                .filter(|candidate| by_the_past.is_none_or(|other| other == *candidate))
                .filter(|_| self.has_one_acceleration(found, other, legs)),
            (candidate, None) | (None, candidate) => candidate,
        }
    }

    /// [`Step::continued`] by determinants alone, along the line through both roots.
    fn continued_determinants(
        &self,
        past: &[Vector],
        found: &Vector,
        other: &Vector,
        size: &Vector,
    ) -> Option<Candidate> {
        if self.is_of_third_order() {
            // in third order, earlier steps continued other second differences
            return None;
        }
        let mut leg = self.leg.to_owned();
        let mut former = Vec::with_capacity(past.len());
        for (place, z) in past.iter().enumerate() {
            let rows;
            if let Some(past) = self.past {
                (_, rows) = self.on_leg(past[place], z);
            } else {
                (leg, rows) = self.former(leg.any(), z)?;
            }
            former.push(rows.jacobian);
        }
        let direction = other.zip(found, |other, found| other - found);
        // in units of the determinant at a root: all have to be near 1
        let fits = |root: &Vector| {
            let now = self.linearize(root).jacobian;
            let part = |at| newton::orientation(&now, at, &direction, size);
            let parts: Option<Vec<f64>> = former.iter().map(part).collect();
            let parts = parts?;
            let bound = if parts.len() > 1 { TELLS } else { NEARER };
            let all_fit = extrapolations(&parts).iter().all(|x| (x - 1.0).abs() <= bound);
            // and the extrapolation has to be reliable: it would have predicted the last one, too
            let foreseen = parts.split_first().is_none_or(|(last, before)| {
                before.len() < ENOUGH - 1 || extrapolations(before).iter().all(|x| (x - last).abs() <= bound)
            });
            Some(all_fit && foreseen)
        };
        one_of(fits(found)?, fits(other)?)
    }

    /// The root that is clearly nearer to the continuous system's acceleration.
    fn near_continuous(&self, found: &Vector, other: &Vector, legs: &Vector) -> Option<Candidate> {
        let acceleration = self.continuous()?;
        let distance = |root: &Vector| relative(&root.zip(&acceleration, |x, y| x - y), &acceleration, legs);
        let (found, other) = (distance(found), distance(other));
        if found < NEARER * other {
            Some(Candidate::First)
        } else if other < NEARER * found {
            Some(Candidate::Other)
        } else {
            None
        }
    }

    /// Whether the continuous system has the same acceleration near both roots.
    fn has_one_acceleration(&self, found: &Vector, other: &Vector, legs: &Vector) -> bool {
        let (leg, square) = (self.leg, self.h * self.h);
        let v = Vector::of(leg.d).map(|d| d / self.h);
        let near = |root: &Vector| {
            let e = self.second_difference(root);
            if self.is_of_third_order() {
                return self.continuous_of_third(&e);
            }
            let a = e.map(|e| e / square);
            let (a, _) = start::acceleration(&self.declaration(), (leg.t, leg.q, &v), Some(&a)).ok()?;
            Some(self.unknown(&a.map(|a| a * square), &[]))
        };
        let (Some(found), Some(other)) = (near(found), near(other)) else {
            return false;
        };
        let apart = found.zip(&other, |x, y| x - y);
        relative(&apart, &found, legs) < SAME
    }

    /// The leg before a given leg, and the rows of its step at its solution.
    fn former(&self, leg: AnyLeg<'_, f64>, z: &[f64]) -> Option<(OwnedLeg<f64>, Linearized)> {
        let (mut e, mut rows) = self.on_leg(leg, z);
        let mut former = leg.to_owned();
        // the second difference depends on the unknowns and, weakly, on the leg that is searched
        for _ in 0..FORMER {
            former = OwnedLeg {
                t: leg.t - self.h,
                q: rotation::moved(&self.shape().rotations, leg.q, &map(leg.d, |d| -d)),
                d: leg.d.iter().zip(e.iter()).map(|(d, e)| d - e).collect(),
            };
            (e, rows) = self.on_leg(former.any(), z);
        }
        is_finite(&former.d).then_some((former, rows))
    }

    /// The root nearest to a guess, without the search for others.
    pub fn solve_near(
        &self,
        start: &Vector,
        predictor: &mut Predictor,
        size: &Vector,
        max_iterations: u32,
    ) -> Result<(Vector, StepReport), NewtonFailure> {
        match newton::solve(self, start, size, max_iterations, &mut ()) {
            Ok(root) => {
                self.continuation(&root, predictor);
                Ok(report(root, Guess::Given))
            }
            Err(_) => Err(newton::explain(self, start, size, max_iterations)),
        }
    }

    /// The root nearest to a guess, without a past.
    #[cold]
    pub fn solve_from(
        &self,
        start: &Vector,
        max_iterations: u32,
    ) -> Result<(Vector, StepReport), NewtonFailure> {
        let size = self.least();
        // a predictor without a past, and without room for one
        self.solve_near(start, &mut Predictor::new(0), &size, max_iterations)
    }

    /// A root other than `root`, searched by deflation from several guesses, beginning with the one that led
    /// to it.
    #[cold]
    fn other(&self, start: &Vector, root: &Vector, predictor: &Predictor, size: &Vector) -> Option<Vector> {
        let beside = |part: f64| root.zip(size, |root, size| root + part * root.abs().max(size));
        let guesses = [
            Some(start.clone()),
            predictor.last().map(Vector::of),
            self.continuous(),
            Some(Vector::zero(size.len())),
            Some(beside(1e-6)),
            Some(beside(-1e-6)),
            Some(beside(1.0)),
            Some(beside(-1.0)),
        ];
        // for each guess, first the pair on its way to the root, then deflation from the guess itself
        guesses.into_iter().flatten().find_map(|guess| {
            newton::nearby(self, &guess, root, size).or_else(|| newton::other_root(self, &guess, root, size))
        })
    }
}

impl Step<'_> {
    /// The root that [`Step::solve`] finds and another one, searched by deflation from several guesses.
    pub fn pair(&self, predictor: &Predictor, max_iterations: u32) -> Result<Pair, NewtonFailure> {
        let size = self.size(predictor);
        let found = match self.solve(&mut predictor.clone(), max_iterations) {
            Ok(found) => found,
            Err(failure) if failure.reason == StepFailure::AmbiguousRoot => {
                let found = self.solve_near(
                    &Vector::resized(&failure.unknowns, size.len()),
                    &mut predictor.clone(),
                    &size,
                    max_iterations,
                )?;
                return Ok(Pair {
                    found,
                    other: Some(Vector::resized(&failure.other, size.len())),
                });
            }
            Err(failure) => return Err(failure),
        };
        let root = &found.0;
        let other = self.other(root, root, predictor, &size);
        Ok(Pair { found, other })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::discrete::{constants_of, values_of};
    use crate::number::point::Leg;
    use dsocs_macros::dsocs;

    /// Two accelerations, of which one changes with time.
    #[dsocs {
        coordinates(x);
        lagrangian = dot(x).powi(2) / 2;
        kinematic = (ddot(x) + t * x) * (ddot(x) - 1);
        constraint_forces = [(1,)];
    }]
    #[derive(Clone, Copy)]
    struct Timed;

    #[test]
    fn the_step_before_was_made_at_its_own_time() {
        let (h, leg) = (
            0.1,
            Leg {
                t: 2.0,
                q: [1.0],
                d: [0.1],
            },
        );
        let constants = constants_of(&Timed, &[], h);
        let step = |leg| Step::new((&Timed, &[]), &constants, leg, h);
        let z = step(leg.any()).unknown(&[0.03], &[]);
        let (former, rows) = step(leg.any()).former(leg.any(), &z).unwrap();
        let expected = Leg {
            t: 2.0 - h,
            q: [0.9],
            d: [0.1 - 0.03],
        };
        assert_eq!(former, expected.any().to_owned());
        assert_eq!(rows.rows, step(expected.any()).linearize(&z).rows);
        // the rows depend on time
        let other = Leg { t: 2.0, ..expected };
        assert_ne!(rows.rows, step(other.any()).linearize(&z).rows);
    }

    /// Two oscillators, one of which is the motion.
    #[dsocs {
        coordinates(x);
        lagrangian = dot(x).powi(2) / 2;
        kinematic = (ddot(x) + k[0] * x.sin() + f[0]) * (ddot(x) + k[1] * x + f[1]);
        constraint_forces = [(1,)];
    }]
    #[derive(Clone, Copy)]
    struct Springs {
        k: [f64; 2],
        f: [f64; 2],
    }

    /// The past records the determinant at the chosen root, not at the one that was found first.
    #[test]
    fn the_root_that_is_chosen_is_remembered_by_its_own_determinant() {
        let (h, mut chosen) = (0.2, 0);
        let numbers = (0..60).map(|i| f64::from(i) * 0.05 - 1.5);
        for (place, force) in numbers.enumerate() {
            let system = Springs {
                k: [0.5 + 0.07 * place as f64, 1.7],
                f: [force, 0.3],
            };
            let values = values_of(&system);
            let constants = constants_of(&system, &values, h);
            let acceleration = |x: f64| -(system.k[1] * x + system.f[1]);
            let mut predictor = Predictor::new(1);
            let mut leg = Leg {
                t: 0.0,
                q: [1.0],
                d: [0.3],
            };
            for _ in 0..200 {
                let now = leg;
                let step = Step::new((&system, &values), &constants, now.any(), h);
                let meant = step.unknown(&[h * h * acceleration(leg.q[0])], &[]);
                let (z, report) = step.solve(&mut predictor, MAX_ITERATIONS).unwrap_or_else(|_| {
                    let size = step.size(&predictor);
                    let near = step.solve_near(&meant, &mut predictor, &size, MAX_ITERATIONS);
                    near.unwrap()
                });
                predictor.push(&z);
                if report.guess == Guess::Other {
                    chosen += 1;
                    let determinants = &predictor.determinants;
                    let expected = step.determinant(&z).in_units_of(determinants.unit);
                    let remembered = determinants.last[0];
                    assert!(
                        (remembered - expected).abs() <= 1e-9 * expected.abs(),
                        "{remembered:e} {expected:e}"
                    );
                }
                leg.d[0] += step.second_difference(&z)[0];
                leg.q[0] += leg.d[0];
                leg.t += h;
            }
        }
        println!("{chosen} times another root than the one that was found first");
        assert!(chosen > 2, "{chosen}");
    }

    /// Two accelerations, both far larger than those of the motion.
    #[dsocs {
        coordinates(x);
        lagrangian = dot(x).powi(2) / 2;
        kinematic = (ddot(x) - 1000) * (ddot(x) + 3000);
        constraint_forces = [(1,)];
    }]
    #[derive(Clone, Copy)]
    struct Far;

    /// If the iteration has diverged, no other root that is as far away is taken.
    #[test]
    fn a_root_beyond_the_legs_is_not_taken_for_another_one() {
        let h = 0.1;
        let constants = constants_of(&Far, &[], h);
        let leg = Leg {
            t: 0.0,
            q: [0.0],
            d: [0.1],
        };
        let step = Step::new((&Far, &[]), &constants, leg.any(), h);
        let far = |acceleration: f64| Root {
            z: step.unknown(&[h * h * acceleration], &[]),
            evaluations: 1,
            stop: Stop::Update,
            bend: 0.0,
            close: false,
            determinant: Determinant::UNKNOWN,
        };
        let (size, legs) = (step.least(), step.unknown(&leg.d, &[]));
        let failure = step
            .nearer(&far(-3000.0), &mut Predictor::new(1), [&size, &legs])
            .unwrap_err();
        assert_eq!(failure.reason, StepFailure::NotConverged);
        assert!(failure.other.is_empty());
        // with longer legs it is another root
        let longer = step.unknown(&[10.0], &[]);
        let (z, _) = step
            .nearer(&far(-3000.0), &mut Predictor::new(1), [&size, &longer])
            .unwrap();
        assert!((z[0].abs() / (h * h) - 1000.0).abs() < 1e-6, "{z:?}");
    }

    /// The root to which the last solutions, given from the last back, lead.
    fn led(past: &[f64], found: f64, other: f64) -> Option<Candidate> {
        let one = |z: f64| Vector::of(&[z]);
        let past: Vec<Vector> = past.iter().map(|z| one(*z)).collect();
        continued_unknowns(&past, &one(found), &one(other), &one(1.0))
    }

    #[test]
    fn unknowns_lead_to_a_root_only_if_they_led_to_the_last() {
        use Candidate::{First, Other};
        assert_eq!(led(&[3.0, 2.0, 1.0, 0.0], 4.0, 0.0), Some(First));
        assert_eq!(led(&[3.0, 2.0, 1.0, 0.0], 0.0, 4.0), Some(Other));
        // between the two
        assert_eq!(led(&[3.0, 2.0, 1.0, 0.0], 6.0, 2.0), None);
        // three solutions that change by a quarter of the distance would not have foreseen the last one
        assert_eq!(led(&[3.0, 2.0, 1.0], 4.0, 0.0), None);
        assert_eq!(led(&[3.0, 2.0, 1.0], 4.0, 44.0), Some(First));
        // one past solution decides only for the near root; two decide nothing if the root continues only one
        // of them
        assert_eq!(led(&[3.0], 3.0, 9.0), Some(First));
        assert_eq!(led(&[3.0, 2.0], 4.0, 9.0), Some(First));
        assert_eq!(led(&[3.0, 2.0], 3.0, 9.0), None);
        assert_eq!(led(&[], 3.0, 9.0), None);
    }

    #[test]
    fn polynomials_are_extrapolated() {
        // of degree 1, 2 and 3
        for (degree, exact) in [
            (1, [true; 3]),
            (2, [false, true, true]),
            (3, [false, false, true]),
        ] {
            let value = |k: i32| f64::from(k).powi(degree);
            let found = extrapolations(&[value(4), value(3), value(2), value(1)]);
            assert_eq!(found.len(), 3);
            for (found, exact) in found.iter().zip(exact) {
                assert_eq!((found - value(5)).abs() < 1e-12, exact, "{degree}: {found}");
            }
        }
    }
}
