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
    /// The exponents of the powers of two that are their units.
    units: [i32; LANES],
    /// Factors for the first pivot and for every other one; their product is the inverse of the unit.
    pub scales: [Lanes<R>; 2],
    /// The inverses of the determinants that were examined last.
    inverse: Lanes<R>,
    /// The determinants of the step that is being made.
    next: Lanes<R>,
    /// The lanes, as bits, in which the last two determinants are nearly equal, and in which the next one
    /// nearly equals the last.
    steady: [u32; 2],
}

impl<R: Register> Determinants<R> {
    /// No past determinants.
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

    /// The lanes, as bits, in which determinants have become small or large since the last examination, or
    /// have passed zero.
    #[inline(always)]
    pub fn ask(&self, now: Lanes<R>) -> u32 {
        let part = now * self.inverse;
        (part.below(Lanes::splat(FALLEN)) | Lanes::splat(RISEN).below(part)).bits()
    }

    /// Records the determinants of the step that is being made. Returns the lanes of `active`, as bits, in
    /// which they depart from the past.
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

    /// Moves the determinants of the step to the past.
    #[inline(always)]
    pub fn push(&mut self) {
        self.last = [self.next, self.last[0], self.last[1], self.last[2]];
        self.steady[0] = self.steady[1];
    }

    /// The determinants in registers of another kind.
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

    /// The determinants of one lane.
    #[inline]
    pub fn lane(&self, lane: usize) -> predictor::Determinants {
        let known = (self.inverse.lane(lane), self.units[lane]);
        one(&self.last.map(Into::into), known, self.steady[0], lane)
    }

    /// Sets one lane, for a system with `unknowns` unknowns.
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

/// The lanes among `open`, as bits, in which the determinant departs from its extrapolation.
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
