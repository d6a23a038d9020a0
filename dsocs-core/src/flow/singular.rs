//! Steps near a singularity of the equations.

use smallvec::{SmallVec, smallvec};

use super::discrete::Discrete;
use crate::error::StepError;
use crate::kernel::report::Guess;
use crate::run::NearlySingular;
use crate::solve::failure::StepFailure;
use crate::solve::{Vector, rotation};
use crate::start;
use crate::start::place::Place;
use crate::step::singular::{self, DeterminantChange};

/// A velocity below this part of that of the legs before is nearly zero.
const SLOW: f64 = 0.1;

impl Discrete<'_> {
    /// Examines a step whose determinant has become small or has passed zero, or that was not solved from its
    /// prediction. A motion that ends at a singularity must not continue behind it.
    #[cold]
    pub(super) fn look_for_singularity(
        &mut self,
        e: &[f64],
        z: &[f64],
        guess: Guess,
    ) -> Result<(), StepError> {
        let determinants = &mut self.run_state.predictor.determinants;
        let part = determinants.part();
        let fallen = determinants.look();
        let is_led = guess == Guess::Predicted && !part.is_nan();
        if is_led && !fallen {
            return Ok(());
        }
        let third = self.shape().is_of_third_order();
        let [turns, slows] = if third && fallen {
            self.turns_back(e)
        } else {
            [false; 2]
        };
        let (path, declaration) = (self.path(e), self.declaration());
        let h = self.run_state.h;
        let unit = if third { h * h * h } else { h * h };
        let near = Vector::of(e).map(|e| e / unit);
        // the two places before the last, between which the determinant is compared; in third order the path begins a step earlier
        let [.., before, here, _] = &path[..] else {
            return Ok(());
        };
        let change = singular::change(&declaration, [before, here], 1.0, &near);
        // without a past, the determinant is compared with that of the start
        let begins = part.is_nan();
        if begins && change == DeterminantChange::Little && !turns {
            return Ok(());
        }
        let found = singular::on_path(&declaration, &path, &near).or_else(|| {
            // a step over a singularity may have a smooth path with an unpredicted acceleration: the path with the predicted one is searched,
            // too
            let [expected, _] = self
                .expected()
                .filter(|_| part < 0.0 && !self.is_near_prediction(z, e))?;
            singular::on_path(&declaration, &self.path(&expected), &near)
        });
        let rests = found
            .as_ref()
            .map_or(turns, |found| third && self.is_slow_at(e, found.time));
        // a singularity that lies ahead reverses the motion: the step has passed it, not a state of rest
        let thrown = if rests && !slows {
            self.next_step().singularity_ahead()
        } else {
            None
        };
        let rests = rests && thrown.is_none();
        let found = thrown.or(found);
        if rests {
            let cause = self.next_step().refused(StepFailure::PassesRest, z);
            return Err(self.failed(cause));
        }
        if let Some(singularity) = found {
            let cause = self.next_step().refused(StepFailure::PassesSingularity, z);
            return Err(self.failed(cause).at(singularity));
        }
        if change == DeterminantChange::Falls {
            self.run_state.predictor.determinants.look_again();
        }
        if part < 0.0 || change == DeterminantChange::Falls || (begins && change == DeterminantChange::Rises)
        {
            let of_step = change == DeterminantChange::Little;
            let run_state = &self.run_state;
            if of_step && run_state.has_solved && singular::is_resolved(run_state.vectors.e(), e) {
                return Ok(());
            }
            NearlySingular::count(&mut self.nearly_singular, self.run_state.time(), of_step);
        }
        Ok(())
    }

    /// The error of a step that was solved with sides, none of which changes, if it leads over a singularity:
    /// its determinant is not recorded with those of smooth steps.
    #[cold]
    pub(super) fn passes_singularity(&self, e: &[f64], z: &[f64]) -> Option<StepError> {
        if self.shape().is_of_third_order() {
            return None;
        }
        let (path, declaration, h) = (self.path(e), self.declaration(), self.run_state.h);
        let near = Vector::of(e).map(|e| e / (h * h));
        let solved: SmallVec<[_; 4]> = path
            .iter()
            .map(|place| place.solve(&declaration, &near))
            .collect();
        let mut pairs = solved.windows(2);
        let changes = pairs.any(|pair| match pair {
            [Some(one), Some(other)] => singular::are_opposite(one, other),
            _ => true,
        });
        if !changes {
            return None;
        }
        let singularity = singular::on_path(&declaration, &path, &near)?;
        let cause = self.next_step().refused(StepFailure::PassesSingularity, z);
        Some(self.failed(cause).at(singularity))
    }

    /// Whether a step of third order with a third difference turns back, as where the motion passes through
    /// rest: one of its legs is opposite to the one before, in the mass metric. And whether the legs before
    /// were slowing down.
    fn turns_back(&self, e: &[f64]) -> [bool; 2] {
        let (run_state, leg) = (&self.run_state, self.next_leg());
        let last = run_state.vectors.second().hi;
        let before = Vector::of(leg.d).zip(&last, |d, last| d - last);
        let after = Vector::from_fn(e.len(), |i| leg.d[i] + (last[i] + e[i]));
        let [has_turned, turns] =
            [(&before[..], leg.d), (leg.d, &after[..])].map(|(one, other)| self.product(one, other) < 0.0);
        [
            has_turned || turns,
            has_turned || self.product(leg.d, &last) < 0.0,
        ]
    }

    /// Whether a step of third order with a third difference is nearly at rest at a time, compared with the
    /// legs before.
    fn is_slow_at(&self, e: &[f64], time: f64) -> bool {
        let (run_state, leg) = (&self.run_state, self.next_leg());
        let steps = (time - run_state.time()) / run_state.h;
        let there = self.on_cubic(e, steps).v.map(|v| v * run_state.h);
        let before = Vector::of(leg.d).zip(&run_state.vectors.second().hi, |d, last| d - last);
        let longest = self.product(&before, &before).max(self.product(leg.d, leg.d));
        self.product(&there, &there) < SLOW * SLOW * longest
    }

    /// The inner product of two increments of the next step in the mass metric.
    fn product(&self, one: &[f64], other: &[f64]) -> f64 {
        let (run_state, leg) = (&self.run_state, self.next_leg());
        let v = Vector::of(leg.d).map(|d| d / run_state.h);
        let mass = start::mass_matrix(&self.declaration(), run_state.time(), leg.q, &v);
        let terms = one.iter().enumerate().flat_map(|(i, x)| {
            let mass = &mass;
            other.iter().enumerate().map(move |(j, y)| x * mass[(i, j)] * y)
        });
        terms.sum()
    }

    /// The path of a step with a second difference: from the node before its middle node to the middle of its
    /// second leg. In third order, with a third difference, from the first of its four nodes.
    fn path(&self, e: &[f64]) -> SmallVec<[Place; 4]> {
        if self.shape().is_of_third_order() {
            return SmallVec::from_buf([-2.0, -1.0, 0.0, 0.5].map(|steps| self.on_cubic(e, steps)));
        }
        let (run_state, leg) = (&self.run_state, self.next_leg());
        let (h, t) = (run_state.h, run_state.time());
        let velocity = |d: &[f64], e: &[f64]| Vector::of(d).zip(e, |d, e| (d + 0.5 * e) / h);
        let solved = run_state.solved_leg();
        let before = if run_state.has_solved {
            Place::of_phase(
                t - h,
                Vector::of(solved.q),
                velocity(solved.d, run_state.vectors.e()),
            )
        } else if run_state.index() == 1 {
            let computed_start = &self.computed_start;
            Place::of_phase(
                computed_start.t0,
                computed_start.q0.clone(),
                computed_start.v0.clone(),
            )
        } else {
            let displacement = Vector::of(leg.d).map(|d| -0.5 * d);
            let q = rotation::moved_vector(&self.shape().rotations, leg.q, &displacement);
            Place::of_phase(t - 0.5 * h, q, Vector::of(leg.d).map(|d| d / h))
        };
        let here = Place::of_phase(t, Vector::of(leg.q), velocity(leg.d, e));
        let next = Vector::of(leg.d).zip(e, |d, e| d + e);
        let q = rotation::moved_vector(&self.shape().rotations, &here.q, &next.map(|d| 0.5 * d));
        let after = Place::of_phase(t + 0.5 * h, q, next.map(|d| d / h));
        smallvec![before, here, after]
    }
}
