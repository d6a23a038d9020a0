//! Newton's homotopy: the path to a root from a guess from which Newton's iteration diverges.
//!
//! The residual at the guess is removed little by little: `F(z) = (1 − λ) F(guess)` has the root `guess` at
//! `λ = 0` and the wanted root at `λ = 1` (P. Deuflhard, *Newton Methods for Nonlinear Problems*, section
//! 5.1). For a particle that is to turn, the path leads from the straight line through all smaller turns. It
//! does not depend on the scaling of rows or unknowns.

use super::{Equations, Root, relative, solve};
use crate::solve::Vector;

/// Largest number of evaluations of the rows on a path.
const MAX_EVALUATIONS: u32 = 2000;

/// Largest number of corrections of a point; if they are not enough, the step of `λ` was too long.
const CORRECTIONS: u32 = 4;

/// Largest ratio of a correction to the previous one.
const CONTRACTION: f64 = 0.25;

/// A correction this small relative to the unknowns ends the correction of a point.
const CLOSE: f64 = 1e-4;

/// The shortest step of `λ`.
const SHORTEST: f64 = 1.0 / (1_u64 << 40) as f64;

/// A path on which an unknown exceeds this many times its expected size goes to infinity, and has no fold.
const AWAY: f64 = 1e8;

/// If the rows at a fold are below this many bounds of their rounding errors, there may be a root.
const ABOVE_ROUNDING: f64 = 1e3;

/// Half-width of the interval in which a fold is searched about the last point of a path, relative to the
/// unknowns.
const BEYOND: f64 = 1e-2;

/// Accuracy to which the fold is located, relative to the unknowns.
const NARROW: f64 = 1e-9;

/// The golden section.
const SECTION: f64 = 0.618_033_988_749_894_9;

/// A fold, where the path turns back: a local minimum of the residual that is not zero.
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
    /// The expected size of each unknown, at least.
    size: &'a Vector,
    /// The rows at the guess.
    rows: Vector,
    /// Number of evaluations of the rows.
    evaluations: u32,
}

/// Follows the path from `start` to a root. `Err` if it ends before: with the fold where it turns back, with
/// `None` at a singularity or at infinity.
///
/// Evaluations are added to `evaluations`, also those of a path that ends before.
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
    /// The end of the path, or its last point if it ends before.
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

    /// The fold near the last point of a path: along the path's direction the largest row, in units of its
    /// rounding error, has a minimum. `None` if the path ends otherwise.
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
        // golden section search
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
        // false also for a NaN
        (is_inside && before.left > ABOVE_ROUNDING).then_some(before)
    }

    /// Newton's iteration to the point of the path where the residual is `part` of that at the guess; it has
    /// to converge fast.
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
