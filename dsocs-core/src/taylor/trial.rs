//! Trial steps, and their repetition.

use super::control::{Assessment, Sizes};
use super::integrator::Integrator;
use super::recurrences::SeriesKernel;
use super::watch::{End, each};
use crate::series::rows::Series;

/// The order of a step at a point where the higher derivatives do not exist or are rounding, as at the zero of a power. It is used if the
/// step would be shorter than the part [`LOST`] of the last one.
const ROUGH: usize = 2;
const LOST: f64 = 1e-8;

/// Factor by which steps with the acceleration alone become longer.
const LONGER: f64 = 4.0;

/// The part of a rough step at which it is judged a second time: not the middle, where the force of a symmetric
/// hill vanishes.
const WITHIN: f64 = 0.37;

/// Factor by which a step ends farther before a switch at which its own piece has no value, and the distance up to
/// which this is tried: a part of the step, or a number of smallest steps.
const FARTHER: f64 = 8.0;
const BESIDE: f64 = 1e-8;
const ROUNDINGS: f64 = 256.0;

/// Factor by which a rejected step is shortened.
pub(super) const SHORTER: f64 = 0.5;

/// A trial step.
pub(super) struct Trial {
    /// The step's length, and whether a switch or a corner ends it.
    pub end: End,
    /// Whether its series has few orders, so that the difference of accelerations at its end is the whole
    /// estimate of its error.
    pub is_rough: bool,
    /// The order of the series and the length of the step to try if this one is rejected.
    otherwise: Option<(usize, f64)>,
    /// The place beyond a switch, if the step is tried to the place before it because its own piece has no
    /// value beyond.
    pub beyond: Option<f64>,
    /// The number of longer steps that were tried before.
    pub tries: u32,
    /// Whether the first trial ends where a narrow place was foreseen, to which its series does not reach.
    pub is_foreseen: bool,
}

impl Trial {
    /// A trial of a given length.
    #[inline]
    pub fn of(size: f64, is_rough: bool) -> Self {
        Self {
            end: End::of(size),
            is_rough,
            otherwise: None,
            beyond: None,
            tries: 0,
            is_foreseen: false,
        }
    }
}

impl Integrator {
    /// If a new series is useful only to its first orders, continues with these; returns the length of the
    /// step. A function has few derivatives there, as a power at its zero, and the higher ones do not exist
    /// or are rounding. Where a root is zero there is an acceleration alone: a step as short as rounding leads beyond, if anything moves.
    #[cold]
    pub(super) fn begin_roughly(
        &mut self,
        equations: &mut dyn SeriesKernel,
        wanted: f64,
        smallest: f64,
    ) -> Option<f64> {
        // several events may have come at once
        let last = self.last.map(|(_, h)| h.abs().max(smallest / LOST));
        if wanted > LOST * last.unwrap_or(0.0) || !self.may_begin_with(&self.series) {
            return None;
        }
        self.series.set_order(ROUGH);
        // just beside the zero of a root the jerk is that of this place, and seems to lead back
        let mut leads_back = false;
        if wanted < smallest {
            let reach = last.unwrap_or(smallest);
            each(equations, |_, _, switch| leads_back |= switch.turns_within(reach));
        }
        if self.series.in_range_to() < ROUGH || leads_back {
            let n = self.series.dimension();
            // positions are known to one order more
            for (table, known) in self.series.tables_mut().into_iter().zip([ROUGH + 1, ROUGH]) {
                table[known * n..].fill(0.0);
            }
            // where a function has no derivative to rounding, as that of an angle at its end, the next steps are longer
            let again = self.last.map_or(0.0, |(_, h)| h.abs());
            let is_again = again < LOST * self.t.hi[0].abs();
            let length = if is_again { LONGER * again } else { 0.0 };
            return Some(length.max(smallest).max(f64::EPSILON * f64::EPSILON));
        }
        Some(last.unwrap_or(f64::INFINITY))
    }

    /// Whether a rough step of the length `h`, to the time `t`, is also good within: at its end alone, a force
    /// that begins and ends at zero on the way would not show.
    #[cold]
    pub(super) fn is_good_within(
        &mut self,
        equations: &mut dyn SeriesKernel,
        sizes: &Sizes,
        h: f64,
        t: f64,
    ) -> bool {
        let Assessment { end, .. } = self.arrive(equations, WITHIN * h, self.t.hi[0] + WITHIN * h);
        self.arrive(equations, h, t);
        self.control.good(sizes, end, h.abs(), true)
    }

    /// Whether the series at a start has enough orders for such a step.
    pub(super) fn may_begin_roughly(&self) -> bool {
        self.may_begin_with(&self.next)
    }

    /// Whether a step may be one of few orders: the first of a new series, and one that would be too short where the series has the acceleration
    /// alone, or at a switch.
    pub(super) fn may_be_rough(
        &self,
        equations: &mut dyn SeriesKernel,
        is_short: bool,
        smallest: f64,
    ) -> bool {
        let has_few_orders = || self.series.in_range_to() + 1 == ROUGH;
        self.is_new || (is_short && (has_few_orders() || Self::is_at_switch(equations, smallest)))
    }

    /// Whether a series has enough orders to begin with: at a root that vanishes, and where a motion comes to a place at which a function has no
    /// derivative, as long as something moves away from there.
    fn may_begin_with(&self, series: &Series) -> bool {
        let known = series.in_range_to();
        let moves = |k: usize| series.velocity_of(k).iter().any(|x| *x != 0.0);
        let is_at_zero = || self.watch.as_ref().is_some_and(|watch| watch.touches());
        let may_move = || self.last.is_some() || is_at_zero();
        known >= ROUGH || (known + 1 == ROUGH && may_move() && (moves(0) || moves(1)))
    }

    /// The order up to which the next series shows where an argument leads in a time `tau`.
    pub(super) fn tells_to(&self, tau: f64) -> usize {
        let order = self.next.order();
        let step = self.control.first_step(&self.next, self.order().min(order));
        if step > LOST * tau.abs() { order } else { ROUGH + 2 }
    }

    /// Sets the length of the first trial of a system with switches.
    pub(super) fn foresee_trial(&mut self, equations: &mut dyn SeriesKernel, trial: &mut Trial, left: f64) {
        let has_pieces = self.watch.as_ref().is_some_and(|watch| watch.has_pieces);
        let whole = trial.end.size;
        trial.end = self.foresee(equations, whole.copysign(left), true);
        let mut has_corner = true;
        if trial.end.at_corner {
            has_corner = self.is_corner(equations, trial.end.size.copysign(left));
            if !has_corner {
                trial.end = self.foresee(equations, whole.copysign(left), false);
            }
        }
        trial.is_foreseen = trial.end.size < whole && !trial.end.at_switch && !trial.end.at_corner;
        let End {
            size,
            at_switch,
            at_corner,
            ..
        } = trial.end;
        if !at_switch
            && !at_corner
            && has_corner
            && let Some(place) = self.comes_to_corner(equations, size.copysign(left))
            && place <= left.abs()
            && let Some(known) = self.tells_up_to(place)
            && self.is_corner(equations, place.copysign(left))
        {
            trial.otherwise = Some((self.series.order(), size));
            self.series.set_order(known);
            trial.end = End {
                at_corner: true,
                ..End::of(place)
            };
            return;
        }
        if !has_pieces || trial.end.at_switch || trial.is_rough {
            return;
        }
        let size = trial.end.size;
        if let Some(place) = self.ends_at_zero(equations, size.copysign(left)) {
            trial.otherwise = Some((self.series.order(), size));
            trial.is_rough = true;
            self.series.set_order(ROUGH);
            trial.end = self.near(equations, left.signum(), [place, 2.0 * place]);
        }
    }

    /// Sets the next trial after a rejected step; `is_finite` tells whether its end was. Returns `false` if
    /// there is none.
    #[cold]
    pub(super) fn try_again(&mut self, trial: &mut Trial, is_finite: bool, smallest: f64) -> bool {
        let End {
            size,
            before,
            at_switch,
            ..
        } = trial.end;
        let farthest = (BESIDE * size).max(ROUNDINGS * smallest).min(0.5 * size);
        let farther = trial.beyond.map(|beyond| (beyond, FARTHER * (beyond - size)));
        let farther = farther.filter(|(_, farther)| at_switch && !is_finite && *farther < farthest);
        if at_switch && !is_finite && before < size && before > 0.0 {
            // the step's own piece has no value beyond, as a power of a negative number
            (trial.end.size, trial.beyond) = (before, Some(size));
        } else if let Some((beyond, farther)) = farther {
            // nor at the zero itself, as a power divided by a root of the same number
            trial.end.size = beyond - farther;
        } else if let Some((order, whole)) = trial.otherwise.take() {
            self.series.set_order(order);
            *trial = Trial::of(whole, false);
        } else if size <= smallest {
            return false;
        } else {
            trial.tries += 1;
            trial.end.size = (SHORTER * size).max(smallest);
            (trial.end.at_switch, trial.end.at_corner) = (false, false);
        }
        true
    }

    /// The length of a step that was tried with the length `h`: beyond a switch, where the next piece has a
    /// value.
    pub(super) fn beyond(&mut self, equations: &mut dyn SeriesKernel, trial: &Trial, h: f64) -> f64 {
        let Some(beyond) = trial.beyond.filter(|_| trial.end.at_switch) else {
            return h;
        };
        let h = self.representable(beyond.copysign(h));
        self.arrive(equations, h, self.t.hi[0] + h);
        h
    }
}
