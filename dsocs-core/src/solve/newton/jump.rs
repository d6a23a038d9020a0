//! Rows that change sign in a jump.
//!
//! An example is dry friction that stops a velocity within a step. With the friction of either direction, the
//! next velocity has the opposite direction, and no node solves the rows. Newton's iteration then alternates
//! between two points: each is the root of the rows as they are on the side of the other point. Somewhere
//! between them the rows jump. There they have a root in the sense of Filippov: a value between those of the
//! two sides solves them.

use super::{
    Equations, Evaluation, FailedIteration, Iterate, Quick, Root, Stop, arrived, is_declared, relative,
    scalar_product,
};
use crate::solve::Vector;
use crate::solve::failure::StepFailure;

/// An update leads back if it goes at least this part of the way.
const BACK: f64 = 0.5;

/// Number of bisections between the two points: down to rounding.
const HALVINGS: u32 = 53;

/// Number of times that the two points are found anew if the rows are not affine.
const REPETITIONS: u32 = 8;

/// A jump exceeds this many bounds of the rounding errors of its rows; the bounds do not include those of a
/// user's function.
const ROUNDINGS: f64 = 64.0;

/// A jump is located once it moves by at most this, relative to the unknowns.
const FOUND: f64 = 1e-12;

/// Largest number of pieces that are searched for one that contains its own root.
const PIECES: u32 = 12;

/// The root of piecewise affine rows, starting from the last two points. Only full updates are made: a full
/// update leads to the root of the piece on which it begins, a shortened one to no root.
#[cold]
pub(super) fn between_pieces(
    equations: &dyn Equations,
    [second, third]: [&Evaluation<Vector>; 2],
    size: &Vector,
) -> Result<Root<Vector>, FailedIteration> {
    let (mut before, mut now) = (second.clone(), third.clone());
    let mut evaluations = 3;
    loop {
        if let Some(root) = between(equations, [&before.at, &now.at], size) {
            return Ok(root);
        }
        if evaluations >= PIECES || !now.is_solution() {
            return Err(FailedIteration {
                reason: StepFailure::NotConverged,
                z: now.at.z,
                rows: now.at.rows,
                evaluations,
            });
        }
        let next = equations.evaluate(now.next());
        (before, now) = (now, next);
        evaluations += 1;
        if now.settles(&before, size) && is_declared(equations, &now.at.z, size) {
            return Ok(arrived(&now, evaluations));
        }
    }
}

/// The jump between the last two points of an iteration, if the iteration alternates across one.
#[cold]
pub(super) fn between(
    equations: &dyn Equations,
    [first, second]: [&Iterate<Vector>; 2],
    size: &Vector,
) -> Option<Root<Vector>> {
    // the expected size may be zero, as at rest
    let larger = |size: &Vector, z: &Vector| size.zip(z, |size, z| size.max(z.abs()));
    let units = larger(&larger(size, &first.z), &second.z);
    if along(&second.update, &first.update, &units) > -BACK {
        return None;
    }
    let mut evaluations = 3;
    let (mut from, mut to) = (first.z.clone(), second.z.clone());
    let mut last: Option<Vector> = None;
    for _ in 0..REPETITIONS {
        let way = to.zip(&from, |to, from| to - from);
        let [before, behind] = narrow(equations, &from, &way, &units, &mut evaluations)?;
        // at a root of one side both updates would be zero
        let apart = before
            .at
            .update
            .zip(&behind.at.update, |before, behind| before - behind);
        // false also for a NaN
        let is_jump = along(&apart, &way, &units) >= BACK;
        if !is_jump || is_rounding(equations, [&from, &to], [&before.at, &behind.at]) {
            return None;
        }
        let sizes = [&before, &behind].map(|trial| relative(&trial.at.update, &trial.at.z, &units));
        let nearer = if sizes[0] <= sizes[1] { &before } else { &behind };
        let z = nearer.at.z.clone();
        let moved = last.map(|last| relative(&z.zip(&last, |z, last| z - last), &z, &units));
        if equations.are_affine() || moved.is_some_and(|moved| moved <= FOUND) {
            let root = Root {
                z: z.clone(),
                stop: Stop::Jump,
                ..arrived(nearer, evaluations)
            };
            return is_declared(equations, &z, size).then_some(root);
        }
        last = Some(z);
        // the roots of the two sides, as seen from the jump
        (from, to) = (behind.next(), before.next());
    }
    None
}

/// Whether rounding explains the difference of the rows on the two sides: close to a root an iteration may
/// alternate because of rounding errors, too.
///
/// The bounds are those at the ends of the way; at the jump itself they might include the jump.
fn is_rounding(
    equations: &dyn Equations,
    ends: [&Vector; 2],
    [before, behind]: [&Iterate<Vector>; 2],
) -> bool {
    let bounds = ends.map(|end| equations.rounding(end));
    let rows = before.rows.iter().zip(&behind.rows);
    let bounds = bounds[0].iter().zip(&bounds[1]);
    rows.zip(bounds)
        .all(|((before, behind), (first, second))| (before - behind).abs() <= ROUNDINGS * (first + second))
}

/// The component of an update along a way: 1 if it leads to the end, −1 if it leads back.
fn along(update: &Vector, way: &Vector, units: &Vector) -> f64 {
    scalar_product(update, way, units) / scalar_product(way, way, units)
}

/// The points on both sides of the jump on a way, as close together as rounding allows.
fn narrow(
    equations: &dyn Equations,
    from: &Vector,
    way: &Vector,
    units: &Vector,
    evaluations: &mut u32,
) -> Option<[Evaluation<Vector>; 2]> {
    let mut trial = |part: f64| {
        *evaluations += 1;
        let trial = equations.evaluate(from.zip(way, |from, way| from + part * way));
        trial
            .is_solution()
            .then(|| (along(&trial.at.update, way, units) > 0.0, trial))
    };
    let (before, behind) = (trial(0.0)?, trial(1.0)?);
    if !before.0 || behind.0 {
        return None;
    }
    let (mut before, mut behind) = (before.1, behind.1);
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for _ in 0..HALVINGS {
        let part = 0.5 * (low + high);
        let (is_before, middle) = trial(part)?;
        if is_before {
            (low, before) = (part, middle);
        } else {
            (high, behind) = (part, middle);
        }
    }
    Some([before, behind])
}
