//! Newton's iteration in lanes, with the rules of [`crate::solve::newton`]. It finds only roots that full updates lead to; all other lanes
//! are left to the iteration of a flow.

// compiled for the machine's own instructions (see [`crate::number::instructions`])
#![allow(clippy::inline_always)]

use crate::number::lanes::{LANES, Lanes, Mask, Register};
use crate::number::scalar::Scalar;
use crate::solve::convergence::{LAST_UPDATE, Update, converges};
use crate::solve::newton::{BENT, CLOSE, Components};
use crate::step::pair::MANY;

/// Number of evaluations after which lanes without a root are left to the iteration for one trajectory.
pub(super) const MAX_EVALUATIONS: u32 = 8;

/// The result of the iteration, lane by lane.
#[derive(Clone, Copy)]
pub(super) struct Roots<U, R> {
    /// The unknowns.
    pub z: U,
    /// Number of evaluations of the rows.
    pub evaluations: [u32; LANES],
    /// The lanes without a root, or whose root may have another one nearby, as bits.
    pub left: u32,
    /// The determinants of the Jacobians from which the last updates came, in the requested units.
    pub determinants: Lanes<R>,
}

/// A point of the iteration.
#[derive(Clone, Copy)]
struct Iterate<U> {
    /// Newton's update.
    update: U,
    /// The size of each unknown: its own or its expected one, whichever is larger.
    expected: U,
}

impl<U> Iterate<U> {
    /// The update, with the sizes to compare it with.
    #[inline(always)]
    fn update(&self) -> Update<'_, U> {
        Update {
            components: &self.update,
            unknowns: &self.expected,
            sizes: &self.expected,
        }
    }
}

/// Equations in lanes. Properties of a type are constants, so that unused code is not compiled; those of a
/// single system are methods.
pub(super) trait Equations<R: Register> {
    /// The unknowns.
    type Z: Components<Lanes<R>>;

    /// Whether the rows may be affine in the unknowns.
    const MAY_BE_LINEAR: bool;

    /// Whether the iteration to a root may be watched for a second root.
    const MAY_BE_WATCHED: bool;

    /// Whether the rows may be the declared ones times a factor that may vanish.
    const MAY_BE_SCALED: bool;

    /// Whether the rows are affine, if they may be.
    #[inline(always)]
    fn are_linear(&self) -> bool {
        true
    }

    /// Whether the iteration is watched, if it may be.
    #[inline(always)]
    fn are_watched(&self) -> bool {
        true
    }

    /// Whether the rows have a factor, if they may have.
    #[inline(always)]
    fn are_scaled(&self) -> bool {
        true
    }

    /// The lanes where the iteration is watched also for roots that would not be close.
    fn past_is_short(&self) -> Mask<R>;

    /// Newton's update, NaN in lanes where it is inaccurate, and the determinants in the requested units (see
    /// [`Unknown::solve_lanes`](crate::solve::unknown::Unknown::solve_lanes)).
    fn update(&mut self, z: &Self::Z) -> (Self::Z, Lanes<R>);

    /// The lanes in which a root at `z` is one of the declared rows (see [`crate::solve::newton::Equations`]).
    fn declared(&mut self, z: &Self::Z, nearby: &Self::Z) -> Mask<R>;
}

/// Solves equations from `start`, in the lanes of `active`.
///
/// If a lane gets a root, it is the root that [`crate::solve::newton::solve`] finds, after as many
/// evaluations. Lanes that would take a shortened update, or stagnate, are left without.
#[inline(always)]
pub(super) fn solve<R: Register, E: Equations<R>>(
    equations: &mut E,
    start: E::Z,
    expected: &E::Z,
    max_iterations: u32,
    active: u32,
) -> Roots<E::Z, R> {
    let mut z = start.clone();
    let mut found = Roots {
        z: start,
        evaluations: [1; LANES],
        left: active,
        determinants: Lanes::splat(f64::NAN),
    };
    let (nowhere, everywhere) = (Mask::splat(false), Mask::splat(true));
    let (mut bent, mut ambiguous) = (nowhere, nowhere);
    let limit = max_iterations.clamp(2, MAX_EVALUATIONS);
    let mut before: Option<Iterate<E::Z>> = None;
    let mut before_that: Option<Iterate<E::Z>> = None;
    let mut converging = everywhere;
    // one loop, so that the generated rows are inlined once
    for evaluation in 1..=limit {
        let (update, determinants) = equations.update(&z);
        let next = z.with(&update, |z, update| z + update);
        let now = Iterate {
            update,
            expected: z.with(expected, |z, expected| expected.larger(z.abs())),
        };
        let last = match &before {
            None if E::MAY_BE_LINEAR && equations.are_linear() => finite(&now.update),
            None => now.update().is_small(LAST_UPDATE),
            Some(before) => now.update().settles(&before.update()),
        };
        let mut arriving = last & converging;
        if E::MAY_BE_WATCHED && evaluation >= 3 && equations.are_watched() {
            if let (3, Some(first), Some(second)) = (evaluation, &before_that, &before) {
                [bent, ambiguous] = bent_and_ambiguous(first, second);
                ambiguous = ambiguous | (bent & equations.past_is_short());
            }
            // such lanes are left to the iteration of a flow, which examines the other root
            arriving = arriving & !if evaluation > MANY { bent } else { ambiguous };
        }
        let mut arrived = found.left & arriving.bits();
        if E::MAY_BE_SCALED && arrived != 0 && equations.are_scaled() {
            let root = if E::MAY_BE_LINEAR && equations.are_linear() {
                &next
            } else {
                &z
            };
            let nearby = root.with(expected, |z, expected| {
                z + Lanes::splat(LAST_UPDATE) * expected.larger(z.abs())
            });
            arrived &= equations.declared(root, &nearby).bits();
        }
        if arrived == active {
            (found.z, found.left, found.determinants) = (next, 0, determinants);
            found.evaluations = [evaluation; LANES];
            return found;
        }
        if arrived != 0 {
            let here = Mask::from_bits(arrived);
            found.z = next.with(&found.z, |new, old| here.select(new, old));
            found.determinants = here.select(determinants, found.determinants);
            for (lane, evaluations) in found.evaluations.iter_mut().enumerate() {
                if arrived >> lane & 1 == 1 {
                    *evaluations = evaluation;
                }
            }
            found.left &= !arrived;
        }
        if found.left == 0 {
            break;
        }
        // the convergence of the first three evaluations is not checked, that of a fourth is
        if let (Some(second), 3..) = (&before, evaluation) {
            converging = converging & converges(second.update().relative(), now.update().relative());
            if let (Some(first), 3) = (&before_that, evaluation) {
                converging = converging & converges(first.update().relative(), second.update().relative());
            }
            if found.left & converging.bits() == 0 {
                break;
            }
        }
        (before_that, before) = (before, Some(now));
        z = continued(found.left, &z, &next);
    }
    found
}

/// The lanes in which all components are finite.
#[inline(always)]
fn finite<R: Register, U: Components<Lanes<R>>>(x: &U) -> Mask<R> {
    let components = x.as_ref().iter();
    components.fold(Mask::splat(true), |finite, x| finite & x.finite())
}

/// The lanes in which the rows bend on the way to the root, and of these the ones where another root may be
/// close: the rules of [`crate::solve::newton`] for the worst pair of components.
#[inline(always)]
fn bent_and_ambiguous<R: Register, U: Components<Lanes<R>>>(
    first: &Iterate<U>,
    second: &Iterate<U>,
) -> [Mask<R>; 2] {
    let zero = Lanes::splat(0.0);
    let (mut before, mut after) = (zero, zero);
    let (mut smallest, mut largest) = (Lanes::splat(f64::INFINITY), zero);
    let updates = first.update.as_ref().iter().zip(second.update.as_ref());
    for ((first, second), &size) in updates.zip(second.expected.as_ref()) {
        (before, after) = (before.larger(first.abs()), after.larger(second.abs()));
        (smallest, largest) = (smallest.smaller(size), largest.larger(size));
    }
    let straight = (after * largest).below(Lanes::splat(BENT) * before * smallest);
    let close = (Lanes::splat(CLOSE) * (before * before) * smallest).at_most(after * (largest * largest));
    let bent = !straight;
    [bent, bent & close]
}

/// `next` in the lanes that continue. The others keep their values: NaN would cost time.
#[inline(always)]
fn continued<R: Register, U: Components<Lanes<R>>>(going: u32, z: &U, next: &U) -> U {
    let going = Mask::<R>::from_bits(going);
    next.with(z, |next, z| going.select(next, z))
}
