//! A step as a polynomial: the motion in between.

use super::Jets;
use super::dispatch::{self, Work};
use super::flow::State;
use super::series::Series;
use crate::compensated::Compensated;
use crate::declaration::Declaration;
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
        Declaration::of(self.system).continuous_force(&self.point(t))
    }

    /// The states at some times, worked out several at a time; as many as both slices have. Nothing is allocated.
    pub fn states(&self, times: &[f64], states: &mut [State<N>]) {
        dispatch::run(Values {
            polynomial: *self,
            times,
            states,
        });
    }
}

/// The states at some times.
struct Values<'a, 'f, S, const N: usize> {
    polynomial: Polynomial<'f, S, N>,
    times: &'a [f64],
    states: &'a mut [State<N>],
}

impl<S: Jets<N>, const N: usize> Work for Values<'_, '_, S, N> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let count = self.times.len().min(self.states.len());
        let (mut times, mut states) = (&self.times[..count], &mut self.states[..count]);
        while !times.is_empty() {
            let (done, rest) = if times.len() > FEW {
                times.split_at(MANY.min(times.len()))
            } else {
                (times, [].as_slice())
            };
            let (to, beyond) = states.split_at_mut(done.len());
            if done.len() > FEW {
                fill::<FUSED, S, N, MANY>(&self.polynomial, done, to);
            } else {
                fill::<FUSED, S, N, FEW>(&self.polynomial, done, to);
            }
            (times, states) = (rest, beyond);
        }
    }
}

/// Times at once: as long as some are left, and at the end. Chains of sums wait for themselves, so more of them side by
/// side take hardly longer.
const MANY: usize = 8;
const FEW: usize = 4;

/// The states at up to `L` times.
#[inline(always)]
fn fill<const FUSED: bool, S: Jets<N>, const N: usize, const L: usize>(
    polynomial: &Polynomial<'_, S, N>,
    times: &[f64],
    states: &mut [State<N>],
) {
    let mut since = [0.0; L];
    for (since, &t) in since.iter_mut().zip(times) {
        *since = polynomial.since(t);
    }
    let [q, v] = polynomial.series.values::<FUSED, L>(&since);
    for (lane, (state, &t)) in states.iter_mut().zip(times).enumerate().take(L) {
        *state = State {
            t,
            q: core::array::from_fn(|i| q[i][lane]),
            v: core::array::from_fn(|i| v[i][lane]),
        };
    }
}
