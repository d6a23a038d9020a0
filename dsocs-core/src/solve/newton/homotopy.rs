//! The way to a root from a guess that Newton's iteration runs away from.
//!
//! The rows at the guess are what is wrong with it, so they are taken away little by little: `F(z) = (1 − λ) F(guess)` has
//! the guess for its root at `λ = 0` and the root that is looked for at `λ = 1` (Newton's homotopy; P. Deuflhard, *Newton
//! Methods for Nonlinear Problems*, section 5.1). From a straight line a particle is led to its turn through all smaller
//! turns. Scaling rows or unknowns changes nothing of the path.

use super::{Equations, Root, relative, solve};
use crate::solve::Vector;

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

/// A path on which an unknown grows to so many times the size that it is expected to have leads away, and has no fold.
const AWAY: f64 = 1e8;

/// Rows at a fold that are no more than so many times the bound of their rounding errors may have a root there.
const ABOVE_ROUNDING: f64 = 1e3;

/// A fold is looked for so far from the last point of a path, to either side, relative to the unknowns.
const BEYOND: f64 = 1e-2;

/// And to within so much.
const NARROW: f64 = 1e-9;

/// The golden section.
const SECTION: f64 = 0.618_033_988_749_894_9;

/// Where a path turns back: near it the rows come no nearer to zero.
#[derive(Clone, Debug)]
pub(crate) struct Fold {
    /// The unknowns.
    pub z: Vector,
    /// The rows.
    pub rows: Vector,
    /// The largest row, in units of the bound of its rounding error.
    pub left: f64,
}

/// A point of the path.
#[derive(Clone)]
struct Waypoint {
    /// The unknowns.
    z: Vector,
    /// `dz/dλ`.
    slope: Vector,
}

/// The path from one guess.
struct Path<'a> {
    /// The equations.
    equations: &'a dyn Equations,
    /// How large each unknown is expected to be, at least.
    size: &'a Vector,
    /// The rows at the guess.
    rows: Vector,
    /// How often the rows were evaluated.
    evaluations: u32,
}

/// Follows the path from `start` to a root. If it ends before (in a fold, a singularity, at infinity) there is none; a fold is told.
///
/// Evaluations are added to `evaluations`, also those of a path that ends.
#[cold]
pub(crate) fn follow(
    equations: &dyn Equations,
    start: Vector,
    size: &Vector,
    max_iterations: u32,
    evaluations: &mut u32,
) -> Result<Root<Vector>, Option<Fold>> {
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
    let end = end.map_err(|last| path.fold(&last))?;
    match solve(equations, &end, size, max_iterations, &mut ()) {
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

impl Path<'_> {
    /// The end of the path, or the last point of one that does not get there.
    fn walk(&mut self, start: Vector, slope: Vector) -> Result<Vector, Waypoint> {
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

    /// The fold at the last point of a path, if that is how it ends: along the path's direction there the largest row, in units of its
    /// rounding, has a least value.
    fn fold(&self, last: &Waypoint) -> Option<Fold> {
        let mut parts = last.z.iter().zip(self.size);
        if !parts.all(|(z, size)| z.abs() <= AWAY * size) {
            return None;
        }
        let bounds = self.equations.rounding(&last.z);
        let steep = relative(&last.slope, &last.z, self.size);
        let at = |part: f64| {
            let z = last.z.zip(&last.slope, |z, slope| z + part / steep * slope);
            let rows = self.equations.linearize(&z).rows;
            let mut parts = rows.iter().zip(&bounds);
            let left = parts.try_fold(0.0_f64, |most, (row, bound)| {
                let part = if *row == 0.0 { 0.0 } else { row.abs() / bound };
                part.is_finite().then_some(most.max(part))
            })?;
            Some(Fold { z, rows, left })
        };
        // by sections of equal ratio
        let (mut low, mut high) = (-BEYOND, BEYOND);
        let [mut first, mut second] = [high - SECTION * (high - low), low + SECTION * (high - low)];
        let (mut before, mut after) = (at(first)?, at(second)?);
        while high - low > NARROW {
            if before.left < after.left {
                (high, second, after) = (second, first, before);
                first = high - SECTION * (high - low);
                before = at(first)?;
            } else {
                (low, first, before) = (first, second, after);
                second = low + SECTION * (high - low);
                after = at(second)?;
            }
        }
        let is_inside = low > -BEYOND && high < BEYOND;
        // false also where it is no number
        (is_inside && before.left > ABOVE_ROUNDING).then_some(before)
    }

    /// Newton's iteration to the point of the path where `part` of the first rows is left; it has to converge fast.
    fn correct(&mut self, guess: Vector, part: f64) -> Option<Waypoint> {
        let (mut z, mut before) = (guess, f64::INFINITY);
        for _ in 0..CORRECTIONS {
            self.evaluations += 1;
            let at = self.equations.linearize(&z);
            let rows = at.rows.zip(&self.rows, |row, first| row - part * first);
            let jacobian = at.jacobian;
            let update = jacobian.solve(&rows.map(|row| -row))?;
            let slope = jacobian.solve(&self.rows.map(|row| -row))?;
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
