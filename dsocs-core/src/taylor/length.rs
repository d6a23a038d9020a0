//! How long a step may be.

use super::control::{Sizes, exp2};
use super::integrator::Integrator;
use super::recurrences::SeriesKernel;
use crate::number::larger;
use crate::solve::rotation;

impl Integrator {
    /// Does without the orders whose coefficients leave the range of doubles: in a unit of time that is long for the motion, as a second is for an
    /// electron in a magnetic field, or short.
    #[cold]
    #[inline(never)]
    pub(super) fn cut_to_range(&mut self) {
        let known = self.series.in_range_to();
        if known < self.series.order() && self.order.limit(known) {
            self.series.set_order(known);
        }
    }

    /// The length of the step that the tolerance allows, by the series of its beginning.
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
            // also where nothing moves, and nothing makes it do so
            wanted = self.control.first_step(&self.series, self.order.current());
        }
        self.limited(equations, wanted)
    }

    /// The length of a step that the tolerance allows, if rotations allow it.
    #[inline]
    pub(super) fn limited(&self, equations: &dyn SeriesKernel, wanted: f64) -> f64 {
        let rotations = &equations.kernel().shape().rotations;
        if rotations.is_empty() {
            return wanted;
        }
        let p = self.order.current();
        let log = |k: usize| self.control.log_for(self.largest_turn(rotations, k), k);
        let turns = exp2(log(p - 1).min(log(p)));
        // false also where it is no number
        if wanted > turns { turns } else { wanted }
    }

    /// The largest coefficient of an order of the quaternions of rotations, which may limit a step: where a body spins evenly its angular velocity says
    /// nothing of it.
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

    /// What the control of the step asks of the series of its beginning, which has just become the last one.
    #[inline]
    pub(super) fn sizes(&mut self) -> Sizes {
        match self.known.take() {
            Some(sizes) => sizes,
            None => Sizes::of(&self.series, self.control.weights(), self.order.current()),
        }
    }

    /// Sets in what units the components compare.
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
