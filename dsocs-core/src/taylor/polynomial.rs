//! A step as a polynomial: the motion in between.

use super::Jets;
use super::dispatch::{self, Work};
use super::flow::State;
use super::kernel::LANES;
use super::series::Series;
use crate::compensated::Compensated;
use crate::system::Point;

/// The motion during one step: its Taylor series, good from [`Polynomial::start`] to [`Polynomial::end`].
#[derive(Debug)]
pub struct Polynomial<'f, S, const N: usize> {
    pub(super) system: &'f S,
    pub(super) series: &'f Series<N>,
    pub(super) t: Compensated<1>,
    pub(super) h: f64,
}

impl<S, const N: usize> Clone for Polynomial<'_, S, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, const N: usize> Copy for Polynomial<'_, S, N> {}

impl<'f, S: Jets<N>, const N: usize> Polynomial<'f, S, N> {
    /// The time where the step begins, about which the series is.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.t.hi[0]
    }

    /// The time where the step ends.
    #[must_use]
    pub fn end(&self) -> f64 {
        let mut t = self.t;
        t.add(&[self.h]);
        t.hi[0]
    }

    /// The length of the step, negative back in time.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.h
    }

    /// The series itself.
    #[must_use]
    pub fn series(&self) -> &'f Series<N> {
        self.series
    }

    /// The time since the step's start.
    pub(super) fn since(&self, t: f64) -> f64 {
        (t - self.t.hi[0]) - self.t.lo[0]
    }

    /// The state at the time `t`.
    #[must_use]
    pub fn at(&self, t: f64) -> State<N> {
        let [q, v, _] = self.series.point(self.since(t));
        State { t, q, v }
    }

    /// Position, velocity and acceleration at the time `t`.
    #[must_use]
    pub fn point(&self, t: f64) -> Point<f64, N> {
        let [q, v, a] = self.series.point(self.since(t));
        Point { q, v, a }
    }

    /// The generalized constraint force `Q = d/dt ∂L/∂v − ∂L/∂q` at the time `t`.
    #[must_use]
    pub fn force(&self, t: f64) -> [f64; N] {
        self.system.continuous_force(&self.point(t))
    }

    /// The states at up to [`LANES`] times, at once.
    #[must_use]
    pub fn states(&self, times: &[f64]) -> [State<N>; LANES] {
        let last = times.last().copied().unwrap_or(self.t.hi[0]);
        let times: [f64; LANES] = core::array::from_fn(|lane| times.get(lane).copied().unwrap_or(last));
        let since = times.map(|t| self.since(t));
        let [q, v] = dispatch::run(Values {
            series: self.series,
            since,
        });
        core::array::from_fn(|lane| State {
            t: times[lane],
            q: q.map(|q| q[lane]),
            v: v.map(|v| v[lane]),
        })
    }
}

/// The values at some times.
struct Values<'f, const N: usize> {
    series: &'f Series<N>,
    since: [f64; LANES],
}

impl<const N: usize> Work for Values<'_, N> {
    type Output = [[[f64; LANES]; N]; 2];

    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Self::Output {
        self.series.values::<FUSED>(&self.since)
    }
}
