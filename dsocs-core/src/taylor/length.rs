//! The length of a step.

use super::control::{Sizes, exp2};
use super::integrator::Integrator;
use super::recurrences::SeriesKernel;
use crate::number::larger;
use crate::solve::rotation;

impl Integrator {
    /// Drops the orders whose coefficients leave the range of doubles: this happens if the unit of time is
    /// long or short for the motion, as a second is for an electron in a magnetic field.
    #[cold]
    #[inline(never)]
    pub(super) fn cut_to_range(&mut self) {
        let known = self.series.in_range_to();
        if known < self.series.order() && self.order.limit(known) {
            self.series.set_order(known);
        }
    }

    /// The length of a step that the tolerance allows, from the series of its beginning.
    #[inline]
    pub(super) fn wanted(&mut self, sizes: &Sizes) -> f64 {
        let Self {
            control,
            order,
            series,
            ..
        } = self;
        match self.last {
            Some((_, last)) if !self.is_new => {
                let (log_size, before) = (control.log_size(sizes, last), order.current());
                order.learn(control, series, log_size);
                let p = order.current();
                exp2(if p == before {
                    control.log_step(sizes.last, p, log_size)
                } else {
                    control.log_step_by(series, p, log_size)
                })
            }
            _ => control.first_step(series, order.current()),
        }
    }

    /// The length of the next step, as far as the tolerance and rotations allow it.
    #[inline]
    pub(super) fn length(&mut self, equations: &dyn SeriesKernel, sizes: &Sizes) -> f64 {
        let mut wanted = self.wanted(sizes);
        if wanted.is_nan() {
            // also if nothing moves and no force acts
            wanted = self.control.first_step(&self.series, self.order.current());
        }
        self.limited(equations, wanted)
    }

    /// The length of a step that the tolerance allows, limited by rotations.
    #[inline]
    pub(super) fn limited(&self, equations: &dyn SeriesKernel, wanted: f64) -> f64 {
        let rotations = &equations.kernel().shape().rotations;
        if rotations.is_empty() {
            return wanted;
        }
        let p = self.order.current();
        let log = |k: usize| self.control.log_for(self.largest_turn(rotations, k), k);
        let turns = exp2(log(p - 1).min(log(p)));
        // the tolerance's own length also for a NaN
        if wanted > turns { turns } else { wanted }
    }

    /// The largest coefficient of order `k` of the quaternions of rotations. It may limit a step, since the
    /// angular velocity of a body that spins uniformly does not.
    #[inline(never)]
    fn largest_turn(&self, rotations: &[usize], k: usize) -> f64 {
        let n = self.series.dimension();
        let row = self.series.positions().get(k * n..(k + 1) * n).unwrap_or(&[]);
        let slots = rotations
            .iter()
            .filter_map(|&first| row.get(first..first + rotation::SLOTS));
        slots
            .flatten()
            .fold(0.0_f64, |largest, c| larger(largest, c.abs()))
    }

    /// The sizes in the series of the step's beginning, which has just become the last one.
    #[inline]
    pub(super) fn sizes(&mut self) -> Sizes {
        match self.known.take() {
            Some(sizes) => sizes,
            None => Sizes::of(&self.series, self.control.weights(), self.order.current()),
        }
    }

    /// Sets the scales with which components are compared.
    pub(super) fn scales(&mut self, scales: &[f64]) {
        let weights: Vec<f64> = scales.iter().map(|scale| scale.recip()).collect();
        self.control.weigh(&weights);
        self.weights.stop();
        self.known = None;
    }

    /// The smallest step on the way to a time.
    pub(super) fn smallest_step(&self, until: f64) -> f64 {
        let now = self.t.hi[0].abs();
        let scale = if until.is_infinite() {
            now
        } else {
            now.max(until.abs())
        };
        self.smallest.max(f64::EPSILON / 4.0 * scale)
    }
}
