//! The order of the series.
//!
//! A higher order makes longer steps that cost more. How much longer depends on the motion: if the radius of
//! convergence is the same for all orders, Jorba and Zou's choice is near the best; an entire function, such
//! as a motion on a circle, gains more. So every now and then a step is expanded to a higher order than it
//! needs, which tells the lengths of steps of neighbouring orders.

use super::control::{Control, Tolerance, log2};
use crate::series::orders::MAX_ORDER;
use crate::series::rows::Series;

/// The change of the order.
const CHANGE: usize = 4;
/// Number of such expansions before a decision.
const PROBES: u32 = 4;
/// Number of steps between them; smaller as long as the order is being found.
const INTERVAL: u32 = 15;
const FIRST_INTERVAL: u32 = 1;
/// The least gain for a change of order (binary logarithm).
const LEAST_GAIN: f64 = 0.03;
/// The lowest order, and the highest: beyond it little is gained, and large terms of both signs cancel.
const LOWEST: usize = 6;
const HIGHEST: usize = 28;
/// The highest order if the error is only rounding.
const HIGHEST_EXACT: usize = 22;

/// The choice of the order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    current: usize,
    highest: usize,
    /// The highest order of all expansions.
    limit: usize,
    fixed: bool,
    countdown: u32,
    interval: u32,
    probes: u32,
    /// Sums of logarithms: the gain in distance per unit of work at the order above, and below.
    gains: [f64; 2],
}

impl Order {
    pub(super) fn new(tolerance: &Tolerance) -> Self {
        let highest = if tolerance.relative < 1e-13 {
            HIGHEST_EXACT
        } else {
            HIGHEST
        };
        let current = tolerance.first_order();
        Self {
            current,
            highest: highest.max(current),
            limit: MAX_ORDER,
            fixed: tolerance.order.is_some(),
            countdown: FIRST_INTERVAL,
            interval: FIRST_INTERVAL,
            probes: 0,
            gains: [0.0; 2],
        }
    }

    /// The order of the steps.
    pub(super) fn current(&self) -> usize {
        self.current
    }

    /// The order below.
    pub(super) fn below(&self) -> usize {
        self.current.saturating_sub(CHANGE).max(LOWEST)
    }

    /// The order of the next expansion.
    #[inline(always)]
    pub(super) fn next(&mut self) -> usize {
        if self.fixed {
            return self.current;
        }
        if self.countdown > 0 {
            self.countdown -= 1;
            return self.current;
        }
        self.countdown = self.interval;
        (self.current + CHANGE).min(self.limit)
    }

    /// Limits the orders to `limit` from now on; returns whether that is enough for steps.
    pub(super) fn limit(&mut self, limit: usize) -> bool {
        let is_enough = limit >= LOWEST.min(self.current);
        if is_enough {
            self.limit = self.limit.min(limit);
            self.current = self.current.min(limit);
            self.highest = self.highest.min(limit);
        }
        is_enough
    }

    /// Evaluates an expansion to a higher order than the step needs.
    #[inline(always)]
    pub(super) fn learn(&mut self, control: &Control, series: &Series, log_size: f64) {
        if !self.fixed && series.order() >= self.current + CHANGE {
            self.weigh(control, series, log_size);
        }
    }

    fn weigh(&mut self, control: &Control, series: &Series, log_size: f64) {
        let order = self.current;
        let worth = |p: usize| control.log_step_by(series, p, log_size) - log_work(p);
        let here = worth(order);
        let below = self.below();
        for (gain, other) in self.gains.iter_mut().zip([order + CHANGE, below]) {
            let difference = worth(other) - here;
            // a series that ends gives no information
            *gain += if difference.is_finite() { difference } else { 0.0 };
        }
        self.probes += 1;
        if self.probes < PROBES {
            return;
        }
        let least = LEAST_GAIN * f64::from(PROBES);
        let [up, down] = self.gains;
        self.interval = FIRST_INTERVAL;
        if up > least && order + CHANGE <= self.highest {
            self.current = order + CHANGE;
        } else if down > least && below < order {
            self.current = below;
        } else {
            self.interval = INTERVAL;
        }
        (self.probes, self.gains) = (0, [0.0; 2]);
    }
}

/// The binary logarithm of the work of a step, in arbitrary units: a part for the step itself, one for each
/// order, and the convolutions, which are small beside it (measured on the particle, the pendulum and a
/// chain).
fn log_work(p: usize) -> f64 {
    let p = p as f64;
    log2(6.0 + p + p * p / 60.0)
}
