//! The continuous motion, step by step.

use core::fmt;

use super::Jets;
use super::control::{Control, Tolerance, exp2};
use super::dispatch::{self, Work};
use super::error::{FailedSeries, SeriesError, SeriesFailure};
use super::order::Order;
use super::series::Series;
use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::error::SetupError;
use crate::run::{Clock, Node, Polynomial, RunError, Search};
use crate::start::{self, Start};
use crate::step::newton::Stop;
use crate::step::{Guess, StepReport};
use crate::system::Point;

/// How many steps a motion may take unless [`TaylorFlow::max_steps`] says otherwise.
const MAX_STEPS: u64 = 10_000_000;

/// How much smaller a step is tried after one that was not good.
const SHORTER: f64 = 0.5;

/// The motion of the continuous system, to a tolerance, in progress.
///
/// Each step expands the motion in a Taylor series and goes as far as the tolerance lets it; the series is the motion in
/// between. The position, the velocity and the time are carried with compensated sums, so that over a million steps rounding
/// does not add up.
///
/// A step is good if, where it ends, the acceleration of its series is that of the system: where the series could not know
/// what comes (a switch that was far away, the edge of an `if`), the step is made shorter.
///
/// The verbs are those of [`crate::Stepper`]. Nodes lie where the steps end, the last one of [`crate::Stepper::until`] at the time asked for; or at
/// the times of a grid ([`TaylorFlow::every`]), read off the series. [`crate::Stepper::sample`] hands the motion at any times on, several at once.
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
    /// Which node is the current one.
    pub(super) clock: Clock,
    /// How often the motion was expanded on the way to it.
    pub(super) expansions: u32,
    /// The motion at the current node, where nodes lie on a grid.
    pub(super) on_grid: Option<Point<f64, N>>,
    /// The time up to which the motion has been shown; see [`crate::Stepper::trace`].
    pub(super) shown: f64,
}

impl<S: Jets<N>, const N: usize> fmt::Debug for TaylorFlow<'_, S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TaylorFlow")
            .field("time", &self.time())
            .field("position", self.position())
            .field("velocity", self.velocity())
            .field("order", &self.order())
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

impl<'s, S: Jets<N>, const N: usize> TaylorFlow<'s, S, N> {
    /// Sets up a motion, forward in time unless it is turned round ([`crate::Stepper::reverse`]).
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the tolerance, the start or a parameter cannot be used, if the start gives no velocity, or if the system
    /// has no Taylor series there.
    pub fn new(system: &'s S, start: Start<N>, tolerance: Tolerance) -> Result<Self, SetupError> {
        let Tolerance {
            relative, absolute, ..
        } = tolerance;
        if !(relative > 0.0 && relative < 1.0 && absolute >= 0.0 && absolute.is_finite()) {
            return Err(SetupError::Tolerance { relative, absolute });
        }
        start::check_parameters(system)?;
        let (t0, q0, v0) = start.phase(system)?;
        Declaration::of(system).prepare();
        let order = tolerance.first_order();
        let mut flow = Self {
            system,
            fixed: system.fixed(&system.parameters()),
            table: S::Table::default(),
            series: Box::new(Series::new(order)),
            next: Box::new(Series::new(order)),
            control: Control::new(&tolerance),
            order: Order::new(&tolerance),
            last: None,
            t: Compensated::exact([t0]),
            q: Compensated::exact(q0),
            v: Compensated::exact(v0),
            steps: 0,
            rejected: 0,
            max_steps: MAX_STEPS,
            smallest: 0.0,
            clock: Clock::free(t0),
            expansions: 0,
            on_grid: None,
            shown: t0,
        };
        dispatch::run(Begin { flow: &mut flow });
        let finite = |series: &Series<N>| series.velocity().as_flattened().iter().all(|x| x.is_finite());
        if finite(&flow.next) {
            Ok(flow)
        } else {
            Err(SetupError::Series(flow.failed(SeriesFailure::NotFinite)))
        }
    }

    /// Hands out nodes at a grid of times, the current one and those `h` apart, back in time for a negative `h`. The steps
    /// stay those of the tolerance.
    ///
    /// # Errors
    ///
    /// [`SetupError::Step`] if `h` is zero, infinite or not a number.
    pub fn every(mut self, h: f64) -> Result<Self, SetupError> {
        if !h.is_finite() || h == 0.0 {
            return Err(SetupError::Step { h });
        }
        let handed = self.clock.is_handed_out();
        self.on_grid = Some(self.point());
        self.shown = self.time();
        self.clock = Clock::even(self.time(), h);
        self.clock.hand_out(handed);
        Ok(self)
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

    /// The time up to which the motion is known.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.t.hi[0]
    }

    /// The position there.
    #[must_use]
    pub fn position(&self) -> &[f64; N] {
        &self.q.hi
    }

    /// The velocity there.
    #[must_use]
    pub fn velocity(&self) -> &[f64; N] {
        &self.v.hi
    }

    /// The acceleration there.
    #[must_use]
    pub fn acceleration(&self) -> &[f64; N] {
        &self.next.velocity()[1]
    }

    /// Position, velocity and acceleration there.
    pub(super) fn point(&self) -> Point<f64, N> {
        Point {
            q: self.q.hi,
            v: self.v.hi,
            a: self.next.velocity()[1],
        }
    }

    /// The position with what rounding took from it.
    pub(crate) fn exact_position(&self) -> Compensated<N> {
        self.q
    }

    /// The last step as a polynomial, [`Polynomial::start`] to [`TaylorFlow::time`]; `None` before the first.
    #[must_use]
    pub fn polynomial(&self) -> Option<Polynomial<'_, N>> {
        self.last.map(|(t, h)| Polynomial {
            series: &self.series,
            t,
            from: 0.0,
            to: h,
            search: Search::SERIES,
        })
    }

    /// What is told of a number of expansions.
    pub(super) fn report(&self) -> StepReport {
        StepReport {
            iterations: self.expansions,
            stop: Stop::Start,
            guess: Guess::Given,
        }
    }

    /// The current node.
    pub(super) fn node_here(&self) -> Node<N> {
        let Point { q, v, a } = self.on_grid.unwrap_or_else(|| self.point());
        Node {
            index: self.clock.index(),
            t: self.clock.time(),
            q,
            v,
            a,
            force: Declaration::of(self.system).continuous_force(&Point { q, v, a }),
            energy: self.system.energy(&q, &v),
            iterations: self.expansions,
            stop: Stop::Start,
        }
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

    /// Makes one step towards a time, as long as the tolerance allows, but not beyond it. An infinite time is one that lies
    /// in the direction of the run, and never reached.
    #[inline]
    pub(super) fn go(&mut self, until: f64) -> Result<(), RunError> {
        let (until, scale) = if until.is_infinite() {
            let far = if self.clock.is_forward() {
                f64::MAX
            } else {
                f64::MIN
            };
            (far, self.t.hi[0].abs())
        } else {
            (until, self.t.hi[0].abs().max(until.abs()))
        };
        let left = (until - self.t.hi[0]) - self.t.lo[0];
        if self.steps >= self.max_steps {
            let steps = self.steps;
            return Err(self.failed(SeriesFailure::TooManySteps { steps }).into());
        }
        let smallest = self.smallest.max(f64::EPSILON / 4.0 * scale);
        let rejected = self.rejected;
        match dispatch::run(Advance {
            flow: self,
            until,
            left,
            smallest,
        }) {
            Outcome::Good => {
                self.steps += 1;
                self.expansions += 1 + u32::try_from(self.rejected - rejected).unwrap_or(u32::MAX - 1);
                Ok(())
            }
            Outcome::NotFinite => Err(self.failed(SeriesFailure::NotFinite).into()),
            Outcome::TooSmall(step) => {
                Err(self.failed(SeriesFailure::StepTooSmall { step, smallest }).into())
            }
        }
    }

    #[cold]
    fn failed(&self, cause: SeriesFailure) -> SeriesError {
        SeriesError::new(FailedSeries {
            step: self.steps,
            time: self.t.hi[0],
            q: self.q.hi.to_vec(),
            v: self.v.hi.to_vec(),
            coordinates: S::COORDINATES.map(|coordinate| coordinate.name).to_vec(),
            cause,
        })
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
