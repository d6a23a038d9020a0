//! Newton's iteration in lanes: the rules of [`crate::newton`] where they lead to a root by full updates alone.

use crate::lanes::{Lanes, Mask};
use crate::newton::{LAST_UPDATE, REMAINDER};
use crate::scalar::Scalar;
use crate::unknown::{Linearization, Unknown};

/// How often the rows are evaluated before the lanes without a root are left to the iteration for one trajectory.
const MAX_EVALUATIONS: u32 = 8;

/// What the iteration found, lane by lane.
pub(super) struct Roots<U> {
    /// The unknowns.
    pub z: U,
    /// The rows that were evaluated last.
    pub rows: U,
    /// How often the rows were evaluated.
    pub evaluations: [u32; Lanes::LANES],
    /// The lanes without a root, as bits.
    pub left: u32,
}

/// A point of the iteration.
#[derive(Clone, Copy)]
struct Iterate<U> {
    /// The unknowns.
    z: U,
    /// Newton's update.
    update: U,
    /// Its size relative to the unknowns.
    size: Lanes,
}

/// Solves the rows that `linearize` evaluates, from `start`, in the lanes of `active`.
///
/// A lane that gets a root gets, after as many evaluations, the root that [`crate::newton::solve`] finds. The lanes
/// that would take part of an update, or stagnate, are left.
#[inline]
pub(super) fn solve<U: Unknown<Lanes>>(
    linear: bool,
    linearize: impl Fn(&U) -> Linearization<Lanes, U>,
    start: U,
    expected: &U,
    max_iterations: u32,
    active: u32,
) -> Roots<U> {
    let mut found = Roots {
        z: start,
        rows: start,
        evaluations: [1; Lanes::LANES],
        left: active,
    };
    let limit = max_iterations.clamp(2, MAX_EVALUATIONS);
    let mut z = start;
    let mut before: Option<Iterate<U>> = None;
    // one loop, so that the generated rows stand in it once and are inlined
    for evaluation in 1..=limit {
        let at = linearize(&z);
        let update = U::solve_lanes(&at.jacobian, &at.rows.zip(&at.rows, |row, _| -row));
        let next = z.zip(&update, |z, update| z + update);
        let small = if linear {
            u32::MAX
        } else {
            small_update(&z, &update, expected)
        };
        let Some(last) = before else {
            (found.z, found.rows) = (next, at.rows);
            found.left = active & !small;
            if found.left == 0 {
                return found;
            }
            before = Some(Iterate {
                z,
                update,
                size: relative(&z, &update, expected),
            });
            z = continued(found.left, &z, &next);
            continue;
        };
        let size = relative(&z, &update, expected);
        let is_last = if evaluation == 2 {
            small | at_most(size, LAST_UPDATE)
        } else {
            at_most(size, LAST_UPDATE)
        };
        let contraction = size / last.size;
        let settled = at_most(size * contraction * contraction, REMAINDER);
        let accepted = small | shrinking(&last, &update, expected);
        let arrived = found.left & accepted & ((is_last & settled) | at_most(size, 0.0));
        if arrived != 0 {
            let here = Mask::from_bits(arrived);
            found.z = next.zip(&found.z, |new, old| here.select(new, old));
            found.rows = at.rows.zip(&found.rows, |new, old| here.select(new, old));
            for (lane, evaluations) in found.evaluations.iter_mut().enumerate() {
                if arrived >> lane & 1 == 1 {
                    *evaluations = evaluation;
                }
            }
            found.left &= !arrived;
        }
        // an update that is not half of the last one is the other iteration's business
        let going = found.left & accepted & size.below(Lanes::splat(0.5) * last.size).bits();
        if going == 0 {
            break;
        }
        before = Some(Iterate { z, update, size });
        z = continued(going, &z, &next);
    }
    found
}

/// `next` in the lanes that go on. The others stay where they are: what is no number there would cost time.
#[inline]
fn continued<U: Unknown<Lanes>>(going: u32, z: &U, next: &U) -> U {
    let going = Mask::from_bits(going);
    next.zip(z, |next, z| going.select(next, z))
}

/// Where a number is at most `bound`.
#[inline]
fn at_most(x: Lanes, bound: f64) -> u32 {
    x.at_most(Lanes::splat(bound)).bits()
}

/// Where an update is at most [`LAST_UPDATE`] relative to the unknowns.
#[inline]
fn small_update<U: Unknown<Lanes>>(z: &U, update: &U, expected: &U) -> u32 {
    let sizes = z.as_ref().iter().zip(expected.as_ref());
    let mut small = u32::MAX;
    for (update, (z, &expected)) in update.as_ref().iter().zip(sizes) {
        let bound = Lanes::splat(LAST_UPDATE) * expected.larger(z.abs());
        small &= update.abs().at_most(bound).bits();
    }
    small
}

/// The size of an update relative to the unknowns, or to their expected sizes where these are larger. NaN where the
/// update is.
#[inline]
fn relative<U: Unknown<Lanes>>(z: &U, update: &U, expected: &U) -> Lanes {
    let zero = Lanes::splat(0.0);
    let sizes = z.as_ref().iter().zip(expected.as_ref());
    update
        .as_ref()
        .iter()
        .zip(sizes)
        .fold(zero, |largest, (update, (z, &expected))| {
            let size = update.abs();
            let ratio = size / expected.larger(z.abs());
            let ratio = Lanes::select_le(size, zero, zero, ratio);
            Lanes::select_le(ratio, largest, largest, ratio)
        })
}

/// Where the update is smaller than the one before it, both relative to the same sizes.
fn shrinking<U: Unknown<Lanes>>(before: &Iterate<U>, update: &U, expected: &U) -> u32 {
    let zero = Lanes::splat(0.0);
    let (mut first, mut second) = (zero, zero);
    for (i, &expected) in expected.as_ref().iter().enumerate() {
        let (z, last) = (before.z.as_ref()[i].abs(), before.update.as_ref()[i].abs());
        let size = expected.larger(z).larger(last);
        let share = |update: Lanes| Lanes::select_le(size, zero, zero, update / size);
        first = first.larger(share(last));
        // NaN is kept
        let now = share(update.as_ref()[i].abs());
        second = Lanes::select_le(now, second, second, now);
    }
    second.below(first).bits() | at_most(second, 0.0)
}
