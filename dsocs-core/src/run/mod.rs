//! The functions that drive a run of any method, and the types of their results.
//!
//! A method provides one step, the node there and a [`Clock`]; [`Stepper`] makes a run of these. A run hands out [`Node`]s to
//! an iterator, a [`Trajectory`] or an [`Observer`]. Between the nodes the motion is a [`Polynomial`], on which [`Events`] are found.
//! A run that fails ends with a [`RunError`].

// times are reached exactly, and zeros are exact
#![allow(clippy::float_cmp)]
// schemes on coefficients are read by index, as they stand in the books
#![allow(clippy::needless_range_loop)]

mod clock;
mod error;
mod estimate;
mod events;
pub(crate) mod inputs;
mod node;
mod observer;
mod polynomial;
pub(crate) mod roots;
mod trajectory;
mod view;

pub use clock::{Clock, End};
pub use error::{Behind, FailedEvent, OneWay, RunError};
pub use estimate::Estimates;
pub use events::{Event, Events, Occurrence};
pub use inputs::{InputError, Inputs, held_value};
pub use node::Node;
pub use observer::{Observer, OnEvent, Verdict, on_event};
pub use polynomial::Polynomial;
pub(crate) use polynomial::Search;
pub use trajectory::{Failure, Trajectory};
pub use view::View;

use core::ops::ControlFlow;

use crate::flow::Unresolved;
use crate::regularity::Regularity;
use crate::step::StepReport;
use crate::system::Point;
use crate::taylor::Series;

/// Receives the motion of a step, polynomial by polynomial. It may return a time at which the method is to stop, counted from the
/// point of expansion of the polynomial.
pub type Visitor<'v, const N: usize> =
    dyn FnMut(&dyn View<N>, &Polynomial<'_, N>) -> Result<Option<f64>, RunError> + 'v;

/// How a step that was shown to a [`Visitor`] ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traced {
    /// At its own end, the next node; the visitor did not ask for another.
    Whole,
    /// At its own end, beyond where the visitor wanted to stop.
    Beyond,
    /// Where the visitor wanted to stop.
    There,
}

/// A run in progress, by any method: [`crate::Flow`], [`crate::ComposedFlow`], [`crate::TaylorFlow`].
///
/// A run has a current node; at first it is the start, which has the number 0. Every function of this trait continues from the
/// current node. Each node is handed out once: to the iterator (a run is an endless iterator of nodes, which ends after an error), to a
/// trajectory ([`Stepper::until`]), or to an observer ([`Stepper::stream`], [`Stepper::watch`]). [`Stepper::advance`] and [`Stepper::to`] pass nodes
/// without computing their velocities, forces and energies.
///
/// The trait is object safe: a function that takes a `&mut dyn Stepper<N>` works with every method.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::{Composition, RunError};
///
/// /// A pendulum.
/// #[dsocs {
///     coordinates(theta);
///     lagrangian = dot(theta).powi(2) / 2 + gravity / length * theta.cos();
/// }]
/// struct Pendulum {
///     length: f64,
///     gravity: f64,
/// }
///
/// /// When it first hangs straight down.
/// fn quarter(run: &mut dyn Stepper<1>) -> Result<f64, RunError> {
///     let mut events = Events::new(vec![Event::function(|point| point.q[0]).terminal()]);
///     let event = run.watch(10.0, &mut events, &mut |_: &Node<1>| {})?;
///     Ok(event.map_or(f64::NAN, |event| event.t))
/// }
///
/// let pendulum = Pendulum { length: 1.0, gravity: 9.81 };
/// let start = Start::second_order([1.0], [0.0]);
/// let step = quarter(&mut Flow::new(&pendulum, 0.01, start)?)?;
/// let composed = quarter(&mut ComposedFlow::new(&pendulum, 0.01, Composition::KAHAN_LI_6, start)?)?;
/// let series = quarter(&mut TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-14))?)?;
/// let exact = 0.534_784_400_139_672;
/// assert!((step - exact).abs() < 1e-4 && (composed - exact).abs() < 1e-11 && (series - exact).abs() < 1e-12);
/// # Ok::<(), RunError>(())
/// ```
///
/// # A new method
///
/// A new method owns a [`Clock`], and implements the first five functions, and [`Iterator`] by [`Stepper::next_node`]. The other functions are
/// provided. If it knows the motion between its nodes better than [`Polynomial::between`] does, it implements [`Stepper::trace`].
pub trait Stepper<const N: usize>: Iterator<Item = Result<Node<N>, RunError>> {
    /// Makes one step and advances the clock. No node is computed, and nothing is allocated. `end` is the time towards which the
    /// run goes: a method that chooses its steps does not go beyond it, other methods ignore it.
    ///
    /// # Errors
    ///
    /// [`RunError`] if there is no such step. The run stays where it was.
    fn step(&mut self, end: f64) -> Result<StepReport, RunError>;

    /// The current node.
    fn node(&self) -> Node<N>;

    /// The clock.
    fn clock(&self) -> &Clock;

    /// The clock, to be changed.
    fn clock_mut(&mut self) -> &mut Clock;

    /// The system, seen independently of its type.
    fn view(&self) -> &dyn View<N>;

    /// Reverses the direction of time. The run goes back from the current node, which becomes number 0 and is not handed out again.
    ///
    /// The run back is the same method with the step `-h`. It retraces the nodes to rounding only if the step is symmetric in
    /// time: the step of a [`crate::Flow`] with the default maps and a constant mass matrix, and compositions of it. Otherwise
    /// (`phi_lagrangian` of first order, a mass matrix that depends on the position) the run back is another motion, which differs by the
    /// discretization error. A [`crate::TaylorFlow`] retraces its motion to its tolerance. A damped motion grows on the way back, and
    /// rounding errors grow with it.
    ///
    /// # Errors
    ///
    /// [`RunError::OneWay`] if the method cannot go back; other errors if the step back has no solution here. The run stays as it was.
    fn reverse(&mut self) -> Result<(), RunError> {
        Err(RunError::OneWay(Box::new(OneWay {
            method: "this method",
            reason: "it has no step back",
        })))
    }

    /// How regular the equations of the last step are, if the method solves equations. For a [`crate::Flow`] these are the equations of
    /// the triple about the current node. `None` before the first step.
    fn regularity(&self) -> Option<Regularity> {
        None
    }

    /// The steps of a [`crate::Flow`] so far that were too long for the external forces. `None` if there were none, and for all other
    /// methods.
    fn unresolved(&self) -> Option<Unresolved> {
        None
    }

    /// Makes one step like [`Stepper::step`] and hands the motion during the step to a visitor.
    ///
    /// Unless a method implements it otherwise, the motion shown is the polynomial between its nodes ([`Polynomial::between`]).
    ///
    /// # Errors
    ///
    /// The errors of [`Stepper::step`] and of the visitor.
    fn trace(&mut self, end: f64, visit: &mut Visitor<'_, N>) -> Result<Traced, RunError> {
        let before = self.node();
        self.step(end)?;
        let mut series = Series::new(Polynomial::<N>::ORDER);
        let polynomial = Polynomial::between(&before, &self.node(), &mut series);
        Ok(match visit(self.view(), &polynomial)? {
            Some(_) => Traced::Beyond,
            None => Traced::Whole,
        })
    }

    /// Makes exactly one step. [`Stepper::node`] then gives the node at its end, which counts as handed out.
    ///
    /// # Errors
    ///
    /// [`RunError`] if there is no step. The run stays where it was.
    #[inline]
    fn advance(&mut self) -> Result<StepReport, RunError> {
        self.step(f64::INFINITY)
    }

    /// The next node of the iterator; `None` after an error.
    fn next_node(&mut self) -> Option<Result<Node<N>, RunError>> {
        if self.clock().has_ended() {
            return None;
        }
        let node = hand_out(&mut Of(self), f64::INFINITY);
        if node.is_err() {
            self.clock_mut().end();
        }
        Some(node)
    }

    /// Runs up to the last node at or before `t` (back in time: at or after `t`), and collects all nodes that were not handed out
    /// before.
    ///
    /// A node whose time is `t` to within rounding counts as at `t`: 500 with the step 0.1 gives node 5000. A method that chooses
    /// its steps has its last node at `t`.
    ///
    /// # Errors
    ///
    /// [`Failure`] with the nodes so far if a step fails, or if `t` lies behind, is infinite or is not a number.
    fn until(&mut self, t: f64) -> Result<Trajectory<N>, Failure<N>> {
        let mut trajectory = Trajectory::default();
        match collect(self, t, &mut trajectory.nodes) {
            Ok(()) => Ok(trajectory),
            Err(error) => Err(Failure { error, trajectory }),
        }
    }

    /// Runs like [`Stepper::until`] and returns only the last node; the nodes before it are not computed.
    ///
    /// # Errors
    ///
    /// As [`Stepper::until`], without the nodes. The current node is then the last one that was reached.
    fn to(&mut self, t: f64) -> Result<Node<N>, RunError> {
        finite(t)?;
        let end = self.clock().until(t)?;
        self.clock_mut().hand_out(true);
        while !self.clock().has_reached(&end) {
            self.step(end.time())?;
        }
        Ok(self.node())
    }

    /// Runs like [`Stepper::until`], but hands each node to an observer and keeps none. An infinite `t` is allowed; then the
    /// observer has to end the run.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a step fails, or if `t` lies behind or is not a number.
    fn stream(&mut self, t: f64, observer: &mut dyn Observer<N>) -> Result<(), RunError> {
        walk(&mut Of(self), t, &mut |_, node| observer.node(node))
    }

    /// Runs like [`Stepper::stream`] and hands each node on with the regularity of its step ([`Stepper::regularity`]); the
    /// node of the start has none.
    ///
    /// # Errors
    ///
    /// As [`Stepper::stream`].
    fn certify(
        &mut self,
        t: f64,
        observer: &mut dyn FnMut(&Node<N>, Option<Regularity>) -> ControlFlow<()>,
    ) -> Result<(), RunError> {
        walk(&mut Of(self), t, &mut |run, node| {
            observer(node, run.regularity())
        })
    }

    /// Runs like [`Stepper::stream`], and hands nodes and events to the observer, in order. The run ends early at the first terminal
    /// event, which is then returned.
    ///
    /// An event is a change of sign of a function. A zero without a change of sign is not an event, and neither is a zero at
    /// the start. Every change within a step is found, even if a function changes its sign several times. The search uses the
    /// [`Polynomial`] of the step, whose documentation says how exact it is. On this polynomial the zero is exact to rounding.
    ///
    /// After a terminal event, the current node of a run by Taylor series is at the event. For the discrete methods it is the node after
    /// the event. When the run goes on, this node is handed out, and so are the events between the terminal one and this node.
    ///
    /// # Errors
    ///
    /// As [`Stepper::stream`]; and [`RunError::Event`] if a function has no Taylor series.
    fn watch(
        &mut self,
        t: f64,
        events: &mut Events<'_, N>,
        observer: &mut dyn Observer<N>,
    ) -> Result<Option<Occurrence<N>>, RunError> {
        watch(&mut Of(self), t, events, observer)
    }

    /// Runs to the last of the given times and hands out the motion at each of them. The times have to be in the order of the run,
    /// none of them before the current node. Between nodes the motion is the [`Polynomial`] of the step.
    ///
    /// # Errors
    ///
    /// As [`Stepper::stream`].
    fn sample(
        &mut self,
        times: &[f64],
        observer: &mut dyn FnMut(f64, &Point<f64, N>),
    ) -> Result<(), RunError> {
        in_order(times, self.clock())?;
        sample(&mut Of(self), times, observer)
    }

    /// Writes the observed expressions of the declaration at a node to `out`, in the order of [`crate::System::OBSERVABLES`], as many as
    /// `out` has room for.
    fn observe(&self, node: &Node<N>, out: &mut [f64]) {
        self.view().observed(&node.point(), out);
    }

    /// The multipliers of a node's constraint force; see [`crate::multipliers`].
    fn multipliers(&self, node: &Node<N>) -> Vec<f64> {
        self.view().multipliers_of(node)
    }
}

/// Refuses a time at which no run ends by itself.
fn finite(t: f64) -> Result<(), RunError> {
    if t.is_infinite() {
        Err(RunError::Until { until: t })
    } else {
        Ok(())
    }
}

/// Refuses times that do not come in the order of the run.
pub(crate) fn in_order(times: &[f64], clock: &Clock) -> Result<(), RunError> {
    let mut previous = clock.time();
    // many at a time, most of which are in order: the first that is not is looked for only where there is one
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        return Ok(());
    };
    let wrong = |before: f64, after: f64| {
        let behind = if clock.is_forward() {
            after < before
        } else {
            after > before
        };
        usize::from(behind | after.is_nan())
    };
    let mut wrongs = wrong(previous, first);
    for (&before, &after) in times.iter().zip(&times[1..]) {
        wrongs += wrong(before, after);
    }
    if wrongs == 0 && first.is_finite() && last.is_finite() {
        return Ok(());
    }
    for &t in times {
        if !t.is_finite() {
            return Err(RunError::Until { until: t });
        }
        if t != previous && (t > previous) != clock.is_forward() {
            return Err(RunError::behind(Behind {
                until: t,
                time: previous,
                h: clock.step(),
            }));
        }
        previous = t;
    }
    Ok(())
}

/// Puts the nodes up to the last one at or before `t` beside others: [`hand_out`] in a loop, but of the run's own type, so that no
/// node is copied on its way.
fn collect<R: Stepper<N> + ?Sized, const N: usize>(
    run: &mut R,
    t: f64,
    nodes: &mut Vec<Node<N>>,
) -> Result<(), RunError> {
    finite(t)?;
    let end = run.clock().until(t)?;
    while !run.clock().has_reached(&end) {
        if run.clock().is_handed_out() {
            run.step(end.time())?;
        } else {
            run.clock_mut().hand_out(true);
        }
        nodes.push(run.node());
    }
    Ok(())
}

/// A motion in progress, as the functions see it that hand something out at every step. They are compiled once for each number of
/// coordinates, not for every system.
pub(crate) trait Run<const N: usize> {
    /// See [`Stepper::step`].
    fn step(&mut self, end: f64) -> Result<(), RunError>;

    /// See [`Stepper::node`].
    fn node(&self) -> Node<N>;

    /// See [`Stepper::clock`].
    fn clock(&self) -> &Clock;

    /// See [`Stepper::clock_mut`].
    fn clock_mut(&mut self) -> &mut Clock;

    /// See [`Stepper::regularity`].
    fn regularity(&self) -> Option<Regularity>;

    /// See [`Stepper::trace`].
    fn trace(&mut self, end: f64, visit: &mut Visitor<'_, N>) -> Result<Traced, RunError>;
}

/// A run of any method.
pub(crate) struct Of<'r, R: ?Sized>(pub &'r mut R);

impl<R: Stepper<N> + ?Sized, const N: usize> Run<N> for Of<'_, R> {
    fn step(&mut self, end: f64) -> Result<(), RunError> {
        self.0.step(end).map(|_| ())
    }

    fn node(&self) -> Node<N> {
        self.0.node()
    }

    fn clock(&self) -> &Clock {
        self.0.clock()
    }

    fn clock_mut(&mut self) -> &mut Clock {
        self.0.clock_mut()
    }

    fn regularity(&self) -> Option<Regularity> {
        self.0.regularity()
    }

    fn trace(&mut self, end: f64, visit: &mut Visitor<'_, N>) -> Result<Traced, RunError> {
        self.0.trace(end, visit)
    }
}

/// The next node of a run, not beyond the time `end`.
pub(crate) fn hand_out<const N: usize>(run: &mut dyn Run<N>, end: f64) -> Result<Node<N>, RunError> {
    if run.clock().is_handed_out() {
        run.step(end)?;
    } else {
        run.clock_mut().hand_out(true);
    }
    Ok(run.node())
}

/// Shows the nodes up to the last one at or before `t`.
fn walk<const N: usize>(
    run: &mut dyn Run<N>,
    t: f64,
    visit: &mut dyn FnMut(&dyn Run<N>, &Node<N>) -> ControlFlow<()>,
) -> Result<(), RunError> {
    let end = run.clock().until(t)?;
    while !run.clock().has_reached(&end) {
        let node = hand_out(run, end.time())?;
        if visit(run, &node).is_break() {
            break;
        }
    }
    Ok(())
}

/// Shows nodes and events, in order, up to the first terminal event.
fn watch<const N: usize>(
    run: &mut dyn Run<N>,
    t: f64,
    events: &mut Events<'_, N>,
    observer: &mut dyn Observer<N>,
) -> Result<Option<Occurrence<N>>, RunError> {
    let end = run.clock().until(t)?;
    if let Some(occurrence) = events.resume(run.clock(), observer) {
        return Ok(Some(occurrence));
    }
    loop {
        if !run.clock().is_handed_out() {
            let node = hand_out(run, end.time())?;
            if observer.node(&node).is_break() {
                return Ok(None);
            }
        }
        if run.clock().has_reached(&end) {
            return Ok(None);
        }
        let (before, mut ended) = (run.clock().index(), None);
        let traced = run.trace(end.time(), &mut |view, polynomial| {
            ended = events.happen(view, polynomial, observer)?;
            Ok(ended.map(|(s, _)| s))
        });
        // what happens on the way to a node is told before it
        if run.clock().index() != before {
            run.clock_mut().hand_out(false);
        }
        let traced = traced?;
        if let Some((_, occurrence)) = ended {
            events.leave(run.clock(), traced);
            return Ok(Some(occurrence));
        }
    }
}

/// Shows the motion at some times, which come in order.
pub(crate) fn sample<const N: usize>(
    run: &mut dyn Run<N>,
    mut times: &[f64],
    observer: &mut dyn FnMut(f64, &Point<f64, N>),
) -> Result<(), RunError> {
    let Some(&last) = times.last() else {
        return Ok(());
    };
    run.clock_mut().hand_out(true);
    let (now, forward) = (run.clock().time(), run.clock().is_forward());
    if times.first() == Some(&now) {
        let point = run.node().point();
        while let Some((&t, rest)) = times.split_first().filter(|(t, _)| **t == now) {
            observer(t, &point);
            times = rest;
        }
    }
    while !times.is_empty() {
        run.trace(last, &mut |_, polynomial| {
            let end = polynomial.end();
            while let Some((&t, rest)) = times.split_first() {
                if if forward { t > end } else { t < end } {
                    break;
                }
                observer(t, &polynomial.at(t));
                times = rest;
            }
            Ok(None)
        })?;
    }
    Ok(())
}
