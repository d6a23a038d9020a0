//! The continuous motion, step by step.

use core::fmt;

use super::Jets;
use super::control::{Control, Tolerance, exp2};
use super::dispatch::{self, Work};
use super::error::{TaylorError, TaylorFailure};
use super::order::Order;
use super::polynomial::Polynomial;
use super::series::Series;
use crate::compensated::Compensated;

/// How many steps a motion may take unless [`TaylorFlow::max_steps`] says otherwise.
const MAX_STEPS: u64 = 10_000_000;

/// So many states are worked out before they are handed on.
const BUFFER: usize = 32;

/// How much smaller a step is tried after one that was not good.
const SHORTER: f64 = 0.5;

/// A point of the motion in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize> {
    /// Time.
    pub t: f64,
    /// Position.
    pub q: [f64; N],
    /// Velocity.
    pub v: [f64; N],
}

impl<const N: usize> State<N> {
    /// A state at time 0.
    #[must_use]
    pub const fn new(q: [f64; N], v: [f64; N]) -> Self {
        Self { t: 0.0, q, v }
    }
}

/// The motion of the continuous system, to a tolerance, in progress.
///
/// Each step expands the motion in a Taylor series and goes as far as the tolerance lets it; the series is the motion in
/// between. The position, the velocity and the time are carried with compensated sums, so that over a million steps rounding
/// does not add up.
///
/// A step is good if, where it ends, the acceleration of its series is that of the system: where the series could not know
/// what comes (a switch that was far away, the edge of an `if`), the step is made shorter.
pub struct TaylorFlow<'s, S: Jets<N>, const N: usize> {
    /// The system.
    system: &'s S,
    /// What the parameters decide.
    fixed: S::Fixed,
    /// What the recurrences keep.
    table: S::Table,
    /// The series of the last step.
    series: Box<Series<N>>,
    /// The series at the current point; both change places with every step.
    next: Box<Series<N>>,
    /// The control of the steps.
    control: Control<N>,
    /// The choice of the order.
    order: Order,
    /// The time where the last step began, and its length.
    last: Option<(Compensated<1>, f64)>,
    /// The current time.
    t: Compensated<1>,
    /// The current position.
    q: Compensated<N>,
    /// The current velocity.
    v: Compensated<N>,
    /// The number of steps so far.
    steps: u64,
    /// The number of steps that were not good.
    rejected: u64,
    /// How many steps are allowed.
    max_steps: u64,
    /// The smallest step.
    smallest: f64,
}

impl<S: Jets<N>, const N: usize> fmt::Debug for TaylorFlow<'_, S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TaylorFlow")
            .field("state", &self.state())
            .field("order", &self.order())
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

impl<'s, S: Jets<N>, const N: usize> TaylorFlow<'s, S, N> {
    /// Sets up a motion from a state.
    ///
    /// # Errors
    ///
    /// [`TaylorError::Tolerance`] if the tolerance cannot be used, [`TaylorError::NotFinite`] if the system has no Taylor
    /// series at the start.
    pub fn new(system: &'s S, start: State<N>, tolerance: Tolerance) -> Result<Self, TaylorError> {
        let Tolerance {
            relative, absolute, ..
        } = tolerance;
        if !(relative > 0.0 && relative < 1.0 && absolute >= 0.0 && absolute.is_finite()) {
            return Err(TaylorError::Tolerance { relative, absolute });
        }
        let order = tolerance.first_order();
        let mut flow = Self {
            system,
            fixed: system.fixed(),
            table: S::Table::default(),
            series: Box::new(Series::new(order)),
            next: Box::new(Series::new(order)),
            control: Control::new(&tolerance),
            order: Order::new(&tolerance),
            last: None,
            t: Compensated::exact([start.t]),
            q: Compensated::exact(start.q),
            v: Compensated::exact(start.v),
            steps: 0,
            rejected: 0,
            max_steps: MAX_STEPS,
            smallest: 0.0,
        };
        dispatch::run(Begin { flow: &mut flow });
        let finite = |series: &Series<N>| series.velocity().as_flattened().iter().all(|x| x.is_finite());
        if start.t.is_finite() && finite(&flow.next) {
            Ok(flow)
        } else {
            Err(flow.not_finite())
        }
    }

    /// Sets how many steps the motion may take in all (10 million unless set).
    #[must_use]
    pub fn max_steps(mut self, limit: u64) -> Self {
        self.max_steps = limit;
        self
    }

    /// Sets the smallest step (unless set, what rounding leaves of the time).
    #[must_use]
    pub fn smallest_step(mut self, smallest: f64) -> Self {
        self.smallest = smallest;
        self
    }

    /// Sets in what units the coordinates' velocities compare: of which numbers of each are of one size (1 for each unless
    /// set).
    #[must_use]
    pub fn scales(mut self, scales: [f64; N]) -> Self {
        self.control.scales(&scales);
        self
    }

    /// The system.
    #[must_use]
    pub fn system(&self) -> &'s S {
        self.system
    }

    /// The order of the velocity's series; the position's is one more.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order.current()
    }

    /// How many steps were made.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// How many steps were tried and made shorter.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.rejected
    }

    /// The current state.
    #[must_use]
    pub fn state(&self) -> State<N> {
        State {
            t: self.t.hi[0],
            q: self.q.hi,
            v: self.v.hi,
        }
    }

    /// The current position with what rounding took from it.
    pub(crate) fn position(&self) -> Compensated<N> {
        self.q
    }

    /// The acceleration in the current state.
    #[must_use]
    pub fn acceleration(&self) -> [f64; N] {
        self.next.velocity()[1]
    }

    /// The last step as a polynomial; `None` before the first.
    #[must_use]
    pub fn polynomial(&self) -> Option<Polynomial<'_, S, N>> {
        self.last.map(|(t, h)| Polynomial {
            system: self.system,
            series: &self.series,
            t,
            h,
        })
    }

    /// Makes one step, as long as the tolerance allows, but not beyond the time `until`, towards which it goes; returns it
    /// as a polynomial. Nothing is allocated.
    ///
    /// # Errors
    ///
    /// [`TaylorError`] if there is no such step. The flow stays where it was.
    #[inline]
    pub fn step(&mut self, until: f64) -> Result<Polynomial<'_, S, N>, TaylorError> {
        self.advance(until)?;
        match self.last {
            Some((t, h)) => Ok(Polynomial {
                system: self.system,
                series: &self.series,
                t,
                h,
            }),
            None => Err(self.not_finite()),
        }
    }

    /// Runs to the time `t`, forward or back, and returns the state there.
    ///
    /// # Errors
    ///
    /// [`TaylorError`] if the motion does not get there. The flow then stands at the last good step.
    pub fn until(&mut self, t: f64) -> Result<State<N>, TaylorError> {
        if !t.is_finite() {
            return Err(TaylorError::Until { until: t });
        }
        while self.t.hi[0] != t {
            self.advance(t)?;
        }
        Ok(self.state())
    }

    /// The states at some times, which come in the order of the motion and not before the current time.
    ///
    /// # Errors
    ///
    /// [`TaylorFailure`] with the states so far.
    pub fn sample(&mut self, times: &[f64]) -> Result<Vec<State<N>>, TaylorFailure<N>> {
        let mut states = Vec::with_capacity(times.len());
        match self.stream(times, |state| states.push(*state)) {
            Ok(()) => Ok(states),
            Err(error) => Err(TaylorFailure { error, states }),
        }
    }

    /// Hands the states at some times to a closure, one by one. The times come in the order of the motion and not before
    /// the current time; the steps are the motion's own, and several times in one step are worked out together.
    ///
    /// # Errors
    ///
    /// [`TaylorError`] if the motion does not get to the last of the times.
    pub fn stream(&mut self, times: &[f64], mut observer: impl FnMut(&State<N>)) -> Result<(), TaylorError> {
        let Some(&end) = times.last() else {
            return Ok(());
        };
        let forward = end >= self.t.hi[0];
        let mut previous = self.t.hi[0];
        for &t in times {
            if !t.is_finite() {
                return Err(TaylorError::Until { until: t });
            }
            if t != previous && (t > previous) != forward {
                return Err(TaylorError::Behind {
                    until: t,
                    t: previous,
                });
            }
            previous = t;
        }
        let mut buffer = [self.state(); BUFFER];
        let mut rest = times;
        while let Some(&t) = rest.first() {
            let now = self.t.hi[0];
            if t == now {
                observer(&self.state());
                rest = &rest[1..];
                continue;
            }
            let polynomial = self.step(end)?;
            let (reached, inside) = (
                polynomial.end(),
                |t: f64, end: f64| if forward { t < end } else { t > end },
            );
            let count = rest.iter().take_while(|&&t| inside(t, reached)).count();
            let (within, beyond) = rest.split_at(count);
            for times in within.chunks(buffer.len()) {
                polynomial.states(times, &mut buffer);
                buffer[..times.len()].iter().for_each(&mut observer);
            }
            rest = beyond;
        }
        Ok(())
    }

    /// Goes back to a point of the last step, a time `s` after its start.
    pub(super) fn stop_at(&mut self, s: f64) {
        let Some((t, _)) = self.last else {
            return;
        };
        let ((q, v), [dq, dv, a]) = (self.series.start(), self.series.increments::<false>(s));
        self.t = t;
        self.t.add(&[s]);
        (self.q, self.v) = (Compensated::exact(q), Compensated::exact(v));
        self.q.add(&dq);
        self.v.add(&dv);
        self.next.expect(&a);
        self.last = Some((t, s));
        dispatch::run(Begin { flow: self });
    }

    /// Makes one step towards a time.
    #[inline]
    fn advance(&mut self, until: f64) -> Result<(), TaylorError> {
        let left = (until - self.t.hi[0]) - self.t.lo[0];
        if !left.is_finite() {
            return Err(TaylorError::Until { until });
        }
        if self.steps >= self.max_steps {
            return Err(TaylorError::TooManySteps {
                steps: self.steps,
                t: self.t.hi[0],
            });
        }
        let scale = self.t.hi[0].abs().max(until.abs());
        let smallest = self.smallest.max(f64::EPSILON / 4.0 * scale);
        match dispatch::run(Advance {
            flow: self,
            until,
            left,
            smallest,
        }) {
            Outcome::Good => {
                self.steps += 1;
                Ok(())
            }
            Outcome::NotFinite => Err(self.not_finite()),
            Outcome::TooSmall(step) => Err(TaylorError::StepTooSmall {
                t: self.t.hi[0],
                step,
                smallest,
                q: self.q.hi.to_vec(),
                v: self.v.hi.to_vec(),
            }),
        }
    }

    #[cold]
    fn not_finite(&self) -> TaylorError {
        TaylorError::NotFinite {
            t: self.t.hi[0],
            q: self.q.hi.to_vec(),
            v: self.v.hi.to_vec(),
            coordinates: S::COORDINATES.map(|coordinate| coordinate.name).to_vec(),
        }
    }
}

/// How a step ended.
enum Outcome {
    Good,
    NotFinite,
    TooSmall(f64),
}

/// The expansion at the start.
struct Begin<'f, 's, S: Jets<N>, const N: usize> {
    flow: &'f mut TaylorFlow<'s, S, N>,
}

impl<S: Jets<N>, const N: usize> Work for Begin<'_, '_, S, N> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let flow = self.flow;
        flow.next.begin(&flow.q.hi, &flow.v.hi);
        flow.system
            .expand::<FUSED>(&flow.fixed, &mut flow.next, &mut flow.table);
    }
}

/// One step.
struct Advance<'f, 's, S: Jets<N>, const N: usize> {
    flow: &'f mut TaylorFlow<'s, S, N>,
    until: f64,
    left: f64,
    smallest: f64,
}

impl<S: Jets<N>, const N: usize> Work for Advance<'_, '_, S, N> {
    type Output = Outcome;

    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Outcome {
        let Self {
            flow,
            until,
            left,
            smallest,
        } = self;
        core::mem::swap(&mut flow.series, &mut flow.next);
        let wanted = match flow.last {
            Some((_, last)) => {
                let log_size = flow.control.log_size(&flow.series, last);
                flow.order.learn(&flow.control, &flow.series, log_size);
                exp2(
                    flow.control
                        .log_step(&flow.series, flow.order.current(), log_size),
                )
            }
            None => flow.control.first_step(&flow.series, flow.order.current()),
        };
        flow.next.set_order(flow.order.next());
        let mut size = wanted.min(left.abs());
        if wanted.is_nan() || wanted < smallest {
            core::mem::swap(&mut flow.series, &mut flow.next);
            return if wanted > 0.0 {
                Outcome::TooSmall(wanted)
            } else {
                Outcome::NotFinite
            };
        }
        loop {
            let whole = size == left.abs();
            let h = if whole { left } else { size.copysign(left) };
            let [dq, dv, a] = flow.series.increments::<FUSED>(h);
            let (mut q, mut v) = (flow.q, flow.v);
            q.add(&dq);
            v.add(&dv);
            flow.next.begin(&q.hi, &v.hi);
            flow.next.expect(&a);
            flow.system
                .expand::<FUSED>(&flow.fixed, &mut flow.next, &mut flow.table);
            let good = flow.control.good(&flow.series, &flow.next, &a, size);
            // a jump of the acceleration is passed in a step that no clock would see
            if good || (size <= smallest && flow.next.is_finite()) {
                flow.last = Some((flow.t, h));
                if whole {
                    flow.t = Compensated::exact([until]);
                } else {
                    flow.t.add(&[h]);
                }
                (flow.q, flow.v) = (q, v);
                return Outcome::Good;
            }
            flow.rejected += 1;
            if size <= smallest {
                // back to where it was
                core::mem::swap(&mut flow.series, &mut flow.next);
                return Outcome::NotFinite;
            }
            size = (SHORTER * size).max(smallest);
        }
    }
}
