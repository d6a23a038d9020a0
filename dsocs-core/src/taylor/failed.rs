//! Reasons why a motion does not go on.

use super::integrator::{Integrator, LOOK_EVERY};
use super::recurrences::SeriesKernel;
use super::{rounding, watch};
use crate::error::series::{FailedSeries, SeriesError, SeriesFailure};
use crate::number::point::AnyPoint;
use crate::regularity::{deficiency, dependence, undefined};
use crate::solve::Vector;
use crate::start::place::Place;

/// A motion has stalled if [`LOOK_EVERY`] steps advance it by no more than this part of the time so far.
const STALLED: f64 = 1e-9;

/// A trial step has met a jump of the acceleration (it is *torn*) if the acceleration at its end differs from that of its series by this part
/// of itself. After [`BACK_AND_FORTH`] such steps, each shorter than its series allows, the motion oscillates about the place of the jump.
const MISSED: f64 = 0.5;
pub(super) const BACK_AND_FORTH: u32 = 16;

impl Integrator {
    /// Counts the trial step as one that has met a jump, if the acceleration at its end is not that of its series, longer steps were tried
    /// before, and the difference is not rounding. A step that is accepted at once lowers the count. Such a jump shows in no series, as that
    /// of a quotient by a norm that passes zero.
    #[cold]
    pub(super) fn count_torn(
        &mut self,
        equations: &dyn SeriesKernel,
        ([acceleration, defect], size): ([f64; 2], f64),
        tries: u32,
    ) {
        if tries == 0 {
            // a jump that is passed once, as that of a user's function, is soon no longer counted
            self.torn.0 = self.torn.0.saturating_sub(1);
        } else if defect >= MISSED * acceleration
            && !self.is_rounding(equations, (defect, size), tries.max(rounding::TRIES))
        {
            if self.torn.0 == 0 {
                self.torn.1 = self.t.hi[0];
            }
            self.torn.0 += 1;
        }
    }

    /// Whether the motion ends at the current point, and why.
    #[inline(never)] // seldom in a smooth motion
    pub(super) fn halts(&mut self, equations: &mut dyn SeriesKernel) -> Option<SeriesFailure> {
        if self.steps >= self.looks_at()
            && let Some(cause) = self.has_stalled()
        {
            return Some(cause);
        }
        if self.watch.as_ref().is_some_and(|watch| watch.forks) {
            return Some(SeriesFailure::Forks);
        }
        if let Some(switch) = self.watch.as_ref().and_then(|watch| watch.stuck.clone())
            && !self.rest(equations, None)
        {
            let is_declared = equations.declaration().shape().piecewise;
            return Some(SeriesFailure::Sticks { switch, is_declared });
        }
        let (steps, since) = self.torn;
        if steps >= BACK_AND_FORTH {
            let led = (self.t.hi[0] - since).abs();
            return Some(SeriesFailure::BackAndForth { steps, led });
        }
        let (switch, by) = self.jump.clone()?;
        Some(SeriesFailure::Jumps { switch, by })
    }

    /// The failure of a motion that hardly advances, or has made the largest number of steps.
    #[cold]
    pub(super) fn has_stalled(&mut self) -> Option<SeriesFailure> {
        let (steps, now) = (self.steps, self.t.hi[0]);
        let span = (now - self.began).abs();
        let (before, then) = self.looked;
        let led = (now - then).abs();
        if steps - before >= LOOK_EVERY {
            self.looked = (steps, now);
            if led < STALLED * span {
                return Some(SeriesFailure::Stalls {
                    steps: steps - before,
                    led,
                });
            }
        }
        (steps >= self.max_steps).then(|| SeriesFailure::TooManySteps {
            steps,
            last: self.last.map_or(0.0, |(_, h)| h.abs()),
            mean: span / steps.max(1) as f64,
        })
    }

    /// The failure of a motion that gets no further: it sticks, if a step ended at a switch that is still there, and
    /// the equations determine the acceleration. So does a relay that leads a mass to rest.
    #[cold]
    pub(super) fn failed_at_switch(
        &self,
        equations: &mut dyn SeriesKernel,
        cause: SeriesFailure,
        smallest: f64,
    ) -> SeriesError {
        let error = self.failed(equations, cause);
        let (mut nearest, mut least) = (None, f64::INFINITY);
        watch::each(equations, |group, place, switch| {
            let is_there = switch.is_zero() || switch.takes() <= smallest;
            if is_there && switch.size() < least {
                (nearest, least) = (Some((group, place)), switch.size());
            }
        });
        let Some((group, place)) = nearest.filter(|_| self.at_switch[1]) else {
            return error;
        };
        let details = error.details();
        let gets_no_further = matches!(
            details.cause,
            SeriesFailure::Stalls { .. } | SeriesFailure::StepTooSmall { .. }
        );
        if details.deficiency.is_some() || !gets_no_further {
            return error;
        }
        let (switch, is_declared) = (
            equations.switch(group, place),
            equations.declaration().shape().piecewise,
        );
        self.failed(equations, SeriesFailure::Sticks { switch, is_declared })
    }

    #[cold]
    pub(super) fn failed(&self, equations: &dyn SeriesKernel, cause: SeriesFailure) -> SeriesError {
        let cause = self.because_of_dependence(equations, &cause).unwrap_or(cause);
        let undefined = || {
            let (t, q, v) = (self.t.hi[0], self.now.q(), self.now.v());
            let a = &vec![0.0; q.len()];
            let (declaration, point) = (equations.declaration(), AnyPoint { t, q, v, a });
            undefined::of_point(&declaration, point)
                .or_else(|| undefined::without_derivative(&declaration, point))
                .or_else(|| undefined::overflowing(&declaration, point))
        };
        let open = || {
            let (t, q, v) = (self.t.hi[0], self.now.q(), self.now.v());
            let a = self.series.velocity_of(1);
            let zero = vec![0.0; q.len()];
            let a = if a.iter().all(|a| a.is_finite()) { a } else { &zero };
            deficiency::near_point(&equations.declaration(), AnyPoint { t, q, v, a })
        };
        // the jump may be a near-deficiency of the equations
        let cause = match cause {
            SeriesFailure::BackAndForth { steps, led } if open().is_some() => SeriesFailure::Stalls {
                steps: steps.into(),
                led,
            },
            cause => cause,
        };
        SeriesError::new(FailedSeries {
            step: self.steps,
            time: self.t.hi[0],
            q: self.now.q().to_vec(),
            v: self.now.v().to_vec(),
            coordinates: equations
                .kernel()
                .shape()
                .coordinates
                .iter()
                .map(|coordinate| coordinate.name.clone())
                .collect(),
            undefined: (cause == SeriesFailure::NotFinite).then(undefined).flatten(),
            deficiency: matches!(
                cause,
                SeriesFailure::Stalls { .. }
                    | SeriesFailure::StepTooSmall { .. }
                    | SeriesFailure::Unbounded { .. }
                    | SeriesFailure::TooManySteps { .. }
            )
            .then(open)
            .flatten(),
            may_divide: equations.declaration().constraints()[2] > 0,
            // the first group is that of the declaration itself
            calls: equations.groups() > 1,
            tolerance: self.control.relative(),
            cause,
        })
    }

    /// The failure by dependent constraints, if they may be the reason why a run ends here without a switch.
    #[cold]
    fn because_of_dependence(
        &self,
        equations: &dyn SeriesKernel,
        cause: &SeriesFailure,
    ) -> Option<SeriesFailure> {
        let may_be = matches!(
            cause,
            SeriesFailure::Jumps { switch: None, .. }
                | SeriesFailure::NotFinite
                | SeriesFailure::StepTooSmall { .. }
                | SeriesFailure::Stalls { .. }
        );
        if self.projection.is_none() || !may_be {
            return None;
        }
        let time = self.t.hi[0];
        let place = Place::of_phase(time, Vector::of(self.now.q()), Vector::of(self.now.v()));
        let row = dependence::dependent_at(&equations.declaration(), &place)?;
        Some(SeriesFailure::Dependent { time, row })
    }
}
