//! The determinants of the rows at the last solutions, in lanes: the rules of [`crate::solve::predictor`].

// parts of every step, compiled for the machine's own instructions (see [`crate::number::instructions`])
#![allow(clippy::inline_always)]

use crate::number::lanes::{LANES, Lanes, Register};
use crate::number::scalar::Scalar;
use crate::solve::predictor::{self, Continuation, FALLEN, PAST, RISEN, STEADY};

/// The determinants at the last solutions, the last first, each lane in a unit of its own; NaN where they are not known.
#[derive(Clone, Copy)]
pub(super) struct Determinants<R> {
    /// The numbers.
    last: [Lanes<R>; PAST],
    /// The powers of two that are their units.
    units: [i32; LANES],
    /// What the first pivot is multiplied by, and every other one: the inverse of the unit, shared out.
    pub scales: [Lanes<R>; 2],
    /// The inverses of those that were looked at last.
    inverse: Lanes<R>,
    /// Those of the step that is being made.
    next: Lanes<R>,
    /// The lanes in which the last one was nearly that before it, and in which that of the step that is being made is nearly the
    /// last, as bits.
    steady: [u32; 2],
}

impl<R: Register> Determinants<R> {
    /// Without a past.
    pub fn new() -> Self {
        let nan = Lanes::splat(f64::NAN);
        Self {
            last: [nan; PAST],
            units: [0; LANES],
            scales: [Lanes::splat(1.0); 2],
            inverse: nan,
            next: nan,
            steady: [0; 2],
        }
    }

    /// The lanes in which determinants have become small since they were looked at last, or large, or have passed zero, as bits.
    #[inline(always)]
    pub fn ask(&self, now: Lanes<R>) -> u32 {
        let part = now * self.inverse;
        (part.below(Lanes::splat(FALLEN)) | Lanes::splat(RISEN).below(part)).bits()
    }

    /// Takes the determinants of the step that is being made; the lanes of `active` in which they do not continue those before, as bits.
    #[inline(always)]
    pub fn take(&mut self, now: Lanes<R>, active: u32) -> u32 {
        self.next = now;
        let near = (self.last[0] - now)
            .abs()
            .at_most(Lanes::splat(STEADY) * now.abs());
        self.steady[1] = near.bits();
        let open = active & !(self.steady[0] & self.steady[1]);
        if open == 0 {
            return 0;
        }
        let mut last = [[0.0; LANES]; PAST];
        for (to, from) in last.iter_mut().zip(self.last) {
            *to = from.into();
        }
        departing(open, &last, self.units, self.steady[0], &self.next.into())
    }

    /// Puts the determinants taken last among those of the past.
    #[inline(always)]
    pub fn push(&mut self) {
        self.last = [self.next, self.last[0], self.last[1], self.last[2]];
        self.steady[0] = self.steady[1];
    }

    /// The same in other registers.
    #[inline(always)]
    pub fn moved<Q: Register>(&self) -> Determinants<Q> {
        let mut moved = Determinants::<Q>::new();
        for (to, from) in moved.last.iter_mut().zip(&self.last) {
            *to = from.moved();
        }
        for (to, from) in moved.scales.iter_mut().zip(&self.scales) {
            *to = from.moved();
        }
        (moved.inverse, moved.next) = (self.inverse.moved(), self.next.moved());
        (moved.units, moved.steady) = (self.units, self.steady);
        moved
    }

    /// What one lane holds.
    #[inline]
    pub fn lane(&self, lane: usize) -> predictor::Determinants {
        let known = (self.inverse.lane(lane), self.units[lane]);
        one(&self.last.map(Into::into), known, self.steady[0], lane)
    }

    /// Fills one lane, of a system with so many unknowns.
    pub fn set_lane(&mut self, lane: usize, determinants: &predictor::Determinants, unknowns: usize) {
        for (last, value) in self.last.iter_mut().zip(determinants.last) {
            last.set_lane(lane, value);
        }
        self.steady[0] = self.steady[0] & !(1 << lane) | u32::from(determinants.steady[0]) << lane;
        self.inverse.set_lane(lane, determinants.inverse);
        self.units[lane] = determinants.unit;
        let others = i32::try_from(unknowns.saturating_sub(1)).unwrap_or(i32::MAX);
        let share = determinants.unit / others.saturating_add(1);
        let rest = determinants.unit.saturating_sub(share.saturating_mul(others));
        self.scales[0].set_lane(lane, 2.0_f64.powi(rest.saturating_neg()));
        self.scales[1].set_lane(lane, 2.0_f64.powi(share.saturating_neg()));
    }
}

/// One lane of the past.
fn one(
    last: &[[f64; LANES]; PAST],
    (inverse, unit): (f64, i32),
    steady: u32,
    lane: usize,
) -> predictor::Determinants {
    predictor::Determinants {
        last: core::array::from_fn(|k| last[k][lane]),
        unit,
        inverse,
        steady: [steady >> lane & 1 == 1, false],
        ..predictor::Determinants::UNKNOWN
    }
}

/// Those of some lanes in which the determinant departs from its continuation.
#[inline(never)] // seldom needed: most determinants hardly change from step to step
fn departing(
    open: u32,
    last: &[[f64; LANES]; PAST],
    units: [i32; LANES],
    steady: u32,
    now: &[f64; LANES],
) -> u32 {
    let departs = |lane: usize| {
        let past = one(last, (f64::NAN, units[lane]), steady, lane);
        past.compare(now[lane]) != Continuation::Fits
    };
    (0..LANES)
        .filter(|lane| open >> lane & 1 == 1)
        .filter(|&lane| departs(lane))
        .fold(0, |departing, lane| departing | 1 << lane)
}
