//! The way to a root from a guess that Newton's iteration runs away from.
//!
//! The rows at the guess are what is wrong with it, so they are taken away little by little: `F(z) = (1 − λ) F(guess)` has
//! the guess for its root at `λ = 0` and the root that is looked for at `λ = 1` (Newton's homotopy; P. Deuflhard, *Newton
//! Methods for Nonlinear Problems*, section 5.1). From a straight line a particle is led to its turn through all smaller
//! turns. Scaling rows or unknowns changes nothing of the path.

use super::{AnyEquations, Root, relative, solve_apart};
use crate::step::unknown::{Linearization, Unknown};

/// How often the rows may be evaluated on the way.
const MAX_EVALUATIONS: u32 = 2000;

/// How often a point of the path is corrected before the step that led there is taken for too long.
const CORRECTIONS: u32 = 4;

/// A correction must be this part of the one before.
const CONTRACTION: f64 = 0.25;

/// A correction this small relative to the unknowns is enough on the way.
const CLOSE: f64 = 1e-4;

/// The shortest step of `λ`.
const SHORTEST: f64 = 1.0 / (1_u64 << 40) as f64;

/// A path that ends in a fold changes so many times as fast there as where it began, at least: `dz/dλ` grows like `1/√(λ* − λ)`.
const FOLDED: f64 = 10.0;

/// A path on which an unknown grows to so many times the size that it is expected to have leads away, and has no fold.
const AWAY: f64 = 1e8;

/// Rows at a fold that are no more than so many times the bound of their rounding errors may have a root there.
const ABOVE_ROUNDING: f64 = 1e3;

/// How far beyond the last point of a path it is seen whether the rows grow, relative to the unknowns.
const BEYOND: [f64; 3] = [1e-3, 1e-2, 1e-1];

/// Where a path turns back: near it the rows come no nearer to zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fold<Z> {
    /// The unknowns.
    pub z: Z,
    /// The rows.
    pub rows: Z,
    /// The largest row, in units of the bound of its rounding error.
    pub left: f64,
}

/// A point of the path.
#[derive(Clone, Copy)]
struct Waypoint<Z> {
    /// The unknowns.
    z: Z,
    /// `dz/dλ`.
    slope: Z,
}

/// The path from one guess.
struct Path<'a, Z> {
    /// The equations.
    equations: &'a AnyEquations<'a, Z>,
    /// How large each unknown is expected to be, at least.
    size: &'a Z,
    /// The rows at the guess.
    rows: Z,
    /// How often the rows were evaluated.
    evaluations: u32,
}

/// Follows the path from `start` to a root. If it ends before (in a fold, a singularity, at infinity) there is none; a fold is told.
///
/// Evaluations are added to `evaluations`, also those of a path that ends.
#[cold]
pub(crate) fn follow<Z: Unknown<f64>>(
    equations: &AnyEquations<'_, Z>,
    start: Z,
    size: &Z,
    max_iterations: u32,
    evaluations: &mut u32,
) -> Result<Root<Z>, Option<Fold<Z>>> {
    let first = equations.linearize(&start);
    let slope = first.update().ok_or(None)?;
    let mut path = Path {
        equations,
        size,
        rows: first.rows,
        evaluations: 1,
    };
    let end = path.walk(start, slope);
    *evaluations += path.evaluations;
    let end = end.map_err(|last| path.fold(&slope, &last))?;
    match solve_apart(equations, end, size, max_iterations, &mut ()) {
        Ok(root) => {
            *evaluations += root.evaluations;
            Ok(root)
        }
        Err(failed) => {
            *evaluations += failed.evaluations;
            Err(None)
        }
    }
}

impl<Z: Unknown<f64>> Path<'_, Z> {
    /// The end of the path, or the last point of one that does not get there.
    fn walk(&mut self, start: Z, slope: Z) -> Result<Z, Waypoint<Z>> {
        let mut at = Waypoint { z: start, slope };
        let (mut lambda, mut step) = (0.0, 1.0_f64);
        while lambda < 1.0 && self.evaluations < MAX_EVALUATIONS {
            let next = f64::min(lambda + step, 1.0);
            let guess = at.z.zip(&at.slope, |z, slope| z + (next - lambda) * slope);
            if let Some(point) = self.correct(guess, 1.0 - next) {
                (at, lambda) = (point, next);
                step *= 2.0;
            } else {
                step = 0.5 * (next - lambda);
                if step < SHORTEST * lambda.max(SHORTEST) {
                    return Err(at);
                }
            }
        }
        if lambda >= 1.0 { Ok(at.z) } else { Err(at) }
    }

    /// The fold at the last point of a path that began with the slope `first`, if that is how it ends: the path becomes steep, and beyond
    /// it the rows grow.
    fn fold(&self, first: &Z, last: &Waypoint<Z>) -> Option<Fold<Z>> {
        let steep = relative(&last.slope, &last.z, self.size);
        let growth = steep / relative(first, &last.z, self.size);
        let mut parts = last.z.as_ref().iter().zip(self.size.as_ref());
        let stays = parts.all(|(z, size)| z.abs() <= AWAY * size);
        let bounds = self.equations.rounding(&last.z);
        let left = |rows: &Z| {
            let mut parts = rows.as_ref().iter().zip(bounds.as_ref());
            parts.try_fold(0.0_f64, |most, (row, bound)| {
                let part = if *row == 0.0 { 0.0 } else { row.abs() / bound };
                part.is_finite().then_some(most.max(part))
            })
        };
        let rows = self.equations.linearize(&last.z).rows;
        let least = left(&rows)?;
        let turns = BEYOND.iter().all(|part| {
            let z = last.z.zip(&last.slope, |z, slope| z + part / steep * slope);
            left(&self.equations.linearize(&z).rows).is_some_and(|left| left > least)
        });
        // false also where something is no number
        let is_fold = growth >= FOLDED && stays && turns && least > ABOVE_ROUNDING;
        is_fold.then_some(Fold {
            z: last.z,
            rows,
            left: least,
        })
    }

    /// Newton's iteration to the point of the path where `part` of the first rows is left; it has to converge fast.
    fn correct(&mut self, guess: Z, part: f64) -> Option<Waypoint<Z>> {
        let (mut z, mut before) = (guess, f64::INFINITY);
        for _ in 0..CORRECTIONS {
            self.evaluations += 1;
            let at = self.equations.linearize(&z);
            let rows = at.rows.zip(&self.rows, |row, first| row - part * first);
            let update = Linearization { rows, ..at }.update()?;
            let slope = Linearization {
                rows: self.rows,
                ..at
            }
            .update()?;
            let now = relative(&update, &z, self.size);
            if now > CONTRACTION * before {
                return None;
            }
            z = z.zip(&update, |z, update| z + update);
            if now <= CLOSE {
                return Some(Waypoint { z, slope });
            }
            before = now;
        }
        None
    }
}
