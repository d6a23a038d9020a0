//! Steps whose node lies exactly where a quotient of the declaration is 0/0, but has a limit, as `sin(x) / x`.
//!
//! The equations have no value at the node. But on its leg, moved forth and back along itself, they have, and what depends on them smoothly is
//! interpolated at the node. From both sides it has to come to the same value: at a pole or a jump it does not.

use super::{Guess, SECOND_DIFFERENCE, Step, StepReport, known};
use crate::number::point::{AnyLeg, OwnedLeg};
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::solve::predictor::Predictor;
use crate::solve::{Vector, newton, rotation};

/// The places at which a leg is evaluated, in increments from where it is. They are as near as rounding allows: a quotient loses its digits
/// towards its zero, at nodes as here.
const PLACES: [f64; 6] = [-0.75, -0.5, -0.25, 0.25, 0.5, 0.75];

/// The weights that interpolate values at these places by a polynomial of degree 5 at the place 0.
const WEIGHTS: [f64; 6] = [0.05, -0.3, 0.75, 0.75, -0.3, 0.05];

/// The weights that extrapolate the values at the three places on one side.
const BEFORE: [f64; 6] = [1.0, -3.0, 3.0, 0.0, 0.0, 0.0];
const AFTER: [f64; 6] = [0.0, 0.0, 0.0, 3.0, -3.0, 1.0];

/// The extrapolated values are this near to the interpolated one, as a part of the largest. If a step resolves the motion, their errors are 1/64
/// of the third difference.
const SAME: f64 = 1e-2;

/// A vector that depends on a leg and has no value there: its values beside the leg interpolated, and extrapolated from both sides; `None` if it
/// has no value at one of the places. The function is given the moved legs.
fn beside<const K: usize>(
    rotations: &[usize],
    (h, leg): (f64, AnyLeg<'_, f64>),
    weights: [[f64; 6]; K],
    mut value: impl FnMut(AnyLeg<'_, f64>) -> Option<Vector>,
) -> Option<([Vector; K], Vector)> {
    let mut sums: Option<([Vector; K], Vector)> = None;
    for (place, part) in PLACES.into_iter().enumerate() {
        let d: Vec<f64> = leg.d.iter().map(|d| part * d).collect();
        let moved = OwnedLeg {
            t: leg.t + part * h,
            q: rotation::moved(rotations, leg.q, &d),
            d: leg.d.to_vec(),
        };
        let found = value(moved.any()).filter(Vector::is_finite)?;
        let none = || Vector::zero(found.len());
        let (sums, largest) = sums.get_or_insert_with(|| (core::array::from_fn(|_| none()), none()));
        for (sum, weights) in sums.iter_mut().zip(&weights) {
            *sum = sum.zip(&found, |sum, found| sum + weights[place] * found);
        }
        *largest = largest.zip(&found, |most, found| most.max(found.abs()));
    }
    sums
}

/// The limit of a vector at a leg where it has no value, as [`Step::solve_or_limit`] finds that of its solution; `None` without values beside it.
#[cold]
pub(crate) fn of_vector(
    rotations: &[usize],
    (h, leg): (f64, AnyLeg<'_, f64>),
    value: impl FnMut(AnyLeg<'_, f64>) -> Option<Vector>,
) -> Option<Vector> {
    let ([limit], _) = beside(rotations, (h, leg), [WEIGHTS], value)?;
    Some(limit)
}

impl Step<'_> {
    /// The second difference and the unknowns that solve the step, or their limits at a node where its equations have no value.
    pub fn solve_or_limit(
        &self,
        predictor: &mut Predictor,
        max_iterations: u32,
    ) -> Result<(Vector, Vector, StepReport), NewtonFailure> {
        let solution = self
            .solve(predictor, max_iterations)
            .map(|(z, report)| (self.second_difference(&z), z, report));
        let has_value = match &solution {
            // what needs no unknown is not checked before
            Ok((e, ..)) => e.is_finite(),
            Err(cause) => !matches!(cause.reason, StepFailure::NotFinite | StepFailure::Degenerate),
        };
        if has_value {
            return solution;
        }
        self.limit(predictor, max_iterations).map_or(solution, Ok)
    }

    /// The limits of the second difference and the unknowns at a node where the equations have no value; `None` without limits.
    #[cold]
    fn limit(&self, predictor: &Predictor, max_iterations: u32) -> Option<(Vector, Vector, StepReport)> {
        let (size, guess) = (self.size(predictor), predictor.predict());
        let mut last: Option<newton::Root<Vector>> = None;
        let mut evaluations = 0;
        let solution = |leg: AnyLeg<'_, f64>| {
            let moved = Step {
                known: known(self.kernel, self.constants, leg),
                leg,
                before: self.before.clone(),
                initial_acceleration: self.initial_acceleration.clone(),
                past: None,
                ..*self
            };
            let start = guess.clone().or_else(|| moved.continuous())?;
            let root = newton::solve(&moved, &start, &size, max_iterations, &mut ()).ok()?;
            evaluations += root.evaluations;
            let both = [&moved.second_difference(&root.z)[..], &root.z].concat();
            last = Some(root);
            Some(Vector::of(&both))
        };
        let place = (self.h, self.leg);
        let ([both, before, after], largest) =
            beside(&self.shape().rotations, place, [WEIGHTS, BEFORE, AFTER], solution)?;
        let least = SECOND_DIFFERENCE * crate::number::largest(self.leg.d);
        let n = self.leg.d.len();
        let sizes = core::iter::repeat_n(least, n).chain(size.iter().copied());
        let mut components = sizes.enumerate();
        let is_limit = components.all(|(i, size)| {
            let near = SAME * largest[i].max(size);
            (before[i] - both[i]).abs() <= near && (after[i] - both[i]).abs() <= near
        });
        let root = last.filter(|_| is_limit)?;
        let (e, z) = both.split_at(n);
        let report = StepReport {
            iterations: evaluations,
            stop: root.stop,
            guess: Guess::Limit,
        };
        Some((Vector::of(e), Vector::of(z), report))
    }
}
