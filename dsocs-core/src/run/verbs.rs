//! The functions that drive a run, compiled once for all methods and all numbers of coordinates.

use core::ops::ControlFlow;

use super::{
    AnyEvents, AnyNode, AnyObserver, AnyOccurrence, Clock, OwnedNode, Run, RunError, SampleObserver,
    TimeBehind, Workspace, inputs,
};
use crate::kernel::report::StepReport;
use crate::number::point::{AnyPoint, OwnedPoint};
use crate::tape::declaration::Declaration;

/// The functions of a run; [`crate::Stepper`] describes them.
impl dyn Run + '_ {
    /// The declaration, with the current values of the parameters.
    #[must_use]
    pub fn declaration(&self) -> Declaration<'_> {
        Declaration::of(self.kernel()).with(self.values())
    }

    /// The declaration, with the values of the parameters on the leg that ends at the current node.
    #[must_use]
    pub fn declaration_at_node(&self) -> Declaration<'_> {
        Declaration::of(self.kernel()).with(self.arriving_values())
    }

    /// Makes exactly one step; see [`crate::Stepper::advance`].
    ///
    /// # Errors
    ///
    /// [`RunError`] if there is no step. The run stays where it was.
    #[inline]
    pub fn advance(&mut self) -> Result<StepReport, RunError> {
        self.step(f64::INFINITY)
    }

    /// Runs up to the last node at or before `t`, which is then the current one; see [`crate::Stepper::to`].
    ///
    /// # Errors
    ///
    /// [`RunError`] if a step fails, or if `t` lies behind, is infinite or is not a number.
    pub fn to(&mut self, t: f64) -> Result<(), RunError> {
        finite(t)?;
        let end = self.clock().until(t)?;
        self.reach(&end)
    }

    /// Calls the visitor at every node up to the last one at or before `t`, until it breaks. The visitor
    /// reads the node itself ([`Run::write_node`]), and may set inputs. Nothing is allocated.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a step fails, if `t` lies behind or is not a number, and that of the visitor.
    pub fn walk(
        &mut self,
        t: f64,
        visit: &mut dyn FnMut(&mut Self) -> Result<ControlFlow<()>, RunError>,
    ) -> Result<(), RunError> {
        let end = self.clock().until(t)?;
        while self.go_on(&end)? {
            if visit(self)?.is_break() {
                break;
            }
        }
        Ok(())
    }

    /// Runs like `walk`, to a finite time: for [`crate::Stepper::until`] and [`crate::Inputs::drive`].
    ///
    /// # Errors
    ///
    /// The errors of `walk`, and [`RunError::Until`] if `t` is infinite.
    pub fn walk_to(
        &mut self,
        t: f64,
        visit: &mut dyn FnMut(&mut Self) -> Result<ControlFlow<()>, RunError>,
    ) -> Result<(), RunError> {
        finite(t)?;
        self.walk(t, visit)
    }

    /// Hands out nodes and events, in order, up to the first terminal event, which is returned with its index
    /// and its time; see [`crate::Stepper::watch`].
    ///
    /// # Errors
    ///
    /// The errors of `walk`, and [`RunError::Event`] if a function has no Taylor series.
    pub fn watch(
        &mut self,
        t: f64,
        events: &mut AnyEvents<'_>,
        observer: &mut dyn AnyObserver,
    ) -> Result<Option<AnyOccurrence>, RunError> {
        let end = self.clock().until(t)?;
        let resumed = events.resume(&self.declaration(), self.clock(), observer)?;
        if resumed.is_some() {
            return Ok(resumed);
        }
        let mut room = Workspace::new();
        loop {
            if !self.clock().is_handed_out() {
                self.clock_mut().hand_out(true);
                if observer.node(self).is_break() {
                    return Ok(None);
                }
            }
            if self.clock().has_reached(&end) {
                return Ok(None);
            }
            let (before, mut ended) = (self.clock().index(), None);
            let step_end = self.trace(end.time(), &mut room, &mut |declaration, polynomial| {
                ended = events.happen(declaration, polynomial, observer)?;
                Ok(ended.as_ref().map(|(s, _)| *s))
            });
            // events on the way to a node are reported before it
            if self.clock().index() != before {
                self.clock_mut().hand_out(false);
            }
            events.stand(self.clock(), step_end?);
            if let Some((_, occurrence)) = ended {
                return Ok(Some(occurrence));
            }
        }
    }

    /// Runs to the last of the given times and hands out the motion at each of them; see [`crate::Stepper::sample`].
    ///
    /// # Errors
    ///
    /// [`RunError`] if a step fails, or if the times do not come in the order of the run.
    pub fn sample(
        &mut self,
        times: &[f64],
        observer: &mut dyn FnMut(f64, AnyPoint<'_, f64>),
    ) -> Result<(), RunError> {
        let n = self.kernel().shape().dimension();
        self.sample_together(times, &mut |times, numbers| {
            for (&t, numbers) in times.iter().zip(numbers.chunks_exact(3 * n.max(1))) {
                let (q, rest) = numbers.split_at(n);
                let (v, a) = rest.split_at(n);
                observer(t, AnyPoint { t, q, v, a });
            }
            ControlFlow::Continue(())
        })
    }

    /// `sample` with an observer that receives several times together, and for each of them position, velocity and acceleration, one after
    /// the other. The run ends at the next node if the observer breaks.
    ///
    /// # Errors
    ///
    /// The errors of `sample`.
    pub fn sample_together(
        &mut self,
        times: &[f64],
        observer: &mut SampleObserver<'_>,
    ) -> Result<(), RunError> {
        in_order(times, self.clock())?;
        if self.sample_at_once(times, observer)? {
            return Ok(());
        }
        sample(self, times, observer)
    }

    /// Gives a parameter another value; see [`crate::Inputs::set_input`].
    ///
    /// # Errors
    ///
    /// [`RunError::Input`] if there is no such parameter, if the value is not finite, or if it cannot change; [`RunError::Setup`] if the motion
    /// cannot go on with the value. The run then stays as it was.
    pub fn set_input(&mut self, parameter: &str, value: f64) -> Result<(), RunError> {
        let place = inputs::place(self.kernel().shape(), parameter, value)?;
        if self.values().get(place) == Some(&value) {
            return Ok(());
        }
        self.set_value(place, value)
    }

    /// The value of a parameter that holds from the last known position on; `None` if there is no such parameter.
    #[must_use]
    pub fn input(&self, parameter: &str) -> Option<f64> {
        let parameters = &self.kernel().shape().parameters;
        let place = parameters.iter().position(|known| known.name == parameter)?;
        self.values().get(place).copied()
    }

    /// Writes the observed expressions of the declaration at a point, as many as `out` has room for.
    pub fn observe(&self, point: AnyPoint<'_, f64>, out: &mut [f64]) {
        self.declaration_at_node().observe(point, out);
    }

    /// The multipliers of a node's constraint force, by the forms of its constraints.
    #[must_use]
    pub fn multipliers(&self, node: &AnyNode<'_>) -> Vec<f64> {
        self.declaration_at_node().multipliers(node)
    }
}

/// Refuses an infinite time, at which no run ends by itself.
fn finite(t: f64) -> Result<(), RunError> {
    if t.is_infinite() {
        Err(RunError::Until { until: t })
    } else {
        Ok(())
    }
}

/// Refuses times that are not in the order of the run.
pub(crate) fn in_order(times: &[f64], clock: &Clock) -> Result<(), RunError> {
    let mut previous = clock.time();
    // many times at once, most of them in order: the first wrong one is searched only if there is one
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
            return Err(RunError::time_behind(TimeBehind {
                until: t,
                time: previous,
                h: clock.step(),
            }));
        }
        previous = t;
    }
    Ok(())
}

/// Hands out the motion at some times, which are in order, step by step.
fn sample(run: &mut dyn Run, mut times: &[f64], observer: &mut SampleObserver<'_>) -> Result<(), RunError> {
    let Some(&last) = times.last() else {
        return Ok(());
    };
    run.clock_mut().hand_out(true);
    let (now, forward) = (run.clock().time(), run.clock().is_forward());
    let (mut room, mut point) = (
        Workspace::new(),
        OwnedPoint::zero(run.kernel().shape().dimension()),
    );
    if times.first() == Some(&now) {
        let mut node = OwnedNode::new(0);
        node.take(run);
        while let Some((&t, rest)) = times.split_first().filter(|(t, _)| **t == now) {
            if observer(&[t], node.point()).is_break() {
                return Ok(());
            }
            times = rest;
        }
    }
    while !times.is_empty() {
        run.trace(last, &mut room, &mut |_, polynomial| {
            let end = polynomial.end();
            while let Some((&t, rest)) = times.split_first() {
                if if forward { t > end } else { t < end } {
                    break;
                }
                polynomial.at(t, &mut point);
                let goes_on = observer(&[t], point.vectors()).is_continue();
                times = if goes_on { rest } else { &[] };
            }
            Ok(None)
        })?;
    }
    Ok(())
}
