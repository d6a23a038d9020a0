//! The determinants of the rows at the last solutions, in lanes: the rules of [`crate::step::predictor`].

use crate::lanes::{LANES, Lanes};
use crate::scalar::Scalar;
use crate::step::predictor::{self, Continuation, PAST, STEADY};

/// The determinants at the last solutions, the last first, each lane in a unit of its own; NaN where they are not known.
pub(super) struct Determinants {
    /// The numbers.
    last: [Lanes; PAST],
    /// The powers of two that are their units.
    units: [i32; LANES],
    /// What the first pivot is multiplied by, and every other one: the inverse of the unit, shared out.
    pub scales: [Lanes; 2],
    /// Those of the step that is being made.
    next: Lanes,
    /// The lanes in which the last one was nearly that before it, and in which that of the step that is being made is nearly the
    /// last, as bits.
    steady: [u32; 2],
}

impl Determinants {
    /// Without a past.
    pub fn new() -> Self {
        let nan = Lanes::splat(f64::NAN);
        Self {
            last: [nan; PAST],
            units: [0; LANES],
            scales: [Lanes::splat(1.0); 2],
            next: nan,
            steady: [0; 2],
        }
    }

    /// Takes the determinants of the step that is being made; the lanes of `active` in which they do not continue those before, as bits.
    #[inline]
    pub fn take(&mut self, now: Lanes, active: u32) -> u32 {
        self.next = now;
        let near = (self.last[0] - now)
            .abs()
            .at_most(Lanes::splat(STEADY) * now.abs());
        self.steady[1] = near.bits();
        let open = active & !(self.steady[0] & self.steady[1]);
        if open == 0 { 0 } else { self.departing(open) }
    }

    /// Those of some lanes in which the determinant departs from its continuation.
    #[inline(never)] // seldom needed: most determinants hardly change from step to step
    fn departing(&self, open: u32) -> u32 {
        (0..LANES)
            .filter(|lane| open >> lane & 1 == 1)
            .filter(|&lane| self.lane(lane).compare(self.next.lane(lane)) != Continuation::Fits)
            .fold(0, |departing, lane| departing | 1 << lane)
    }

    /// Puts the determinants taken last among those of the past.
    #[inline]
    pub fn push(&mut self) {
        self.last = [self.next, self.last[0], self.last[1], self.last[2]];
        self.steady[0] = self.steady[1];
    }

    /// What one lane holds.
    pub fn lane(&self, lane: usize) -> predictor::Determinants {
        predictor::Determinants {
            last: self.last.map(|last| last.lane(lane)),
            unit: self.units[lane],
            steady: [self.steady[0] >> lane & 1 == 1, false],
            ..predictor::Determinants::UNKNOWN
        }
    }

    /// Fills one lane, of a system with so many unknowns.
    pub fn set_lane(&mut self, lane: usize, determinants: &predictor::Determinants, unknowns: usize) {
        for (last, value) in self.last.iter_mut().zip(determinants.last) {
            last.set_lane(lane, value);
        }
        self.steady[0] = self.steady[0] & !(1 << lane) | u32::from(determinants.steady[0]) << lane;
        self.units[lane] = determinants.unit;
        let others = i32::try_from(unknowns.saturating_sub(1)).unwrap_or(i32::MAX);
        let share = determinants.unit / others.saturating_add(1);
        let rest = determinants.unit.saturating_sub(share.saturating_mul(others));
        self.scales[0].set_lane(lane, 2.0_f64.powi(rest.saturating_neg()));
        self.scales[1].set_lane(lane, 2.0_f64.powi(share.saturating_neg()));
    }
}
