//! A run by Taylor series: nodes at its own steps or on a grid of times.

use core::ops::ControlFlow;

use pulp::bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};

use super::flow::AnyTaylorFlow;
use super::integrator::Integrator;
use super::recurrences::SeriesKernel;
use super::state::Parts;
use crate::error::SetupError;
use crate::kernel::Kernel;
use crate::kernel::clock::{Clock, End};
use crate::kernel::report::{NodeMut, StepReport};
use crate::number::dispatch;
use crate::number::point::AnyPoint;
use crate::run::{AnyPolynomial, AnyVisitor, OwnedNode, Run, RunError, SampleObserver, StepEnd, Workspace};

/// Number of points that are computed before they are handed out: a multiple of all groups of registers.
const BUFFER: usize = 8 * REGISTERS;

impl Run for AnyTaylorFlow<'_> {
    fn kernel(&self) -> &dyn Kernel {
        self.equations.kernel()
    }

    fn values(&self) -> &[f64] {
        self.equations.values()
    }

    fn step(&mut self, end: f64) -> Result<StepReport, RunError> {
        self.motion.expansions = 0;
        if self.motion.on_grid.is_some() {
            return self.step_on_grid(end);
        }
        self.motion.go(&mut *self.equations, end)?;
        self.motion.clock.arrive(self.motion.time());
        Ok(self.motion.report())
    }

    fn write_node(&self, node: NodeMut<'_>) {
        self.motion.tell(&*self.equations, node);
    }

    fn clock(&self) -> &Clock {
        &self.motion.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.motion.clock
    }

    /// Reverses the run. The motion back is computed to the tolerance, too, so it returns to its start to the
    /// tolerance, not to rounding.
    fn reverse(&mut self) -> Result<(), RunError> {
        self.motion.arrived = None;
        self.motion.torn.0 = 0;
        self.motion.clock.turn();
        // at a knot or a switch the motion back belongs to the other piece
        if !self.motion.knots.is_empty() || self.motion.watch.is_some() {
            self.motion.begin(&mut *self.equations);
        }
        Ok(())
    }

    fn trace(
        &mut self,
        end: f64,
        _: &mut Workspace,
        visit: &mut AnyVisitor<'_>,
    ) -> Result<StepEnd, RunError> {
        self.motion.expansions = 0;
        if self.motion.on_grid.is_some() {
            return self.trace_on_grid(end, visit);
        }
        self.motion.go(&mut *self.equations, end)?;
        let stop = match self.motion.polynomial() {
            Some(polynomial) => visit(&self.equations.declaration(), &polynomial),
            None => Ok(None),
        };
        if let Ok(Some(s)) = stop {
            self.motion.stop_at(&mut *self.equations, s);
        }
        self.motion.clock.arrive(self.motion.time());
        Ok(if stop?.is_some() {
            StepEnd::AtStop
        } else {
            StepEnd::NextNode
        })
    }

    fn set_value(&mut self, place: usize, value: f64) -> Result<(), RunError> {
        let mut values = self.equations.values().to_vec();
        if let Some(own) = values.get_mut(place) {
            *own = value;
        }
        self.go_on_with(&values)
    }

    fn sample_at_once(&mut self, times: &[f64], observer: &mut SampleObserver<'_>) -> Result<bool, RunError> {
        let Some(&end) = times.last() else {
            return Ok(true);
        };
        self.motion.clock.hand_out(true);
        let sampled = self.sample_between(times, end, observer);
        if self.motion.on_grid.is_some() {
            // to the last node that was reached, which is at the end or beyond
            let all = matches!(sampled, Ok(ControlFlow::Continue(())));
            while self.motion.is_before(end) && (all || self.motion.reaches_node()) {
                self.step_on_grid(end)?;
            }
        }
        sampled.map(|_| true)
    }
}

impl AnyTaylorFlow<'_> {
    /// Hands out the motion at some times, the last of which is `end`, step by step, until the observer breaks.
    fn sample_between(
        &mut self,
        times: &[f64],
        end: f64,
        observer: &mut SampleObserver<'_>,
    ) -> Result<ControlFlow<()>, RunError> {
        let forward = self.motion.clock.is_forward();
        let n = self.motion.series.dimension();
        let mut buffer = vec![0.0; BUFFER * 3 * n];
        let mut rest = times;
        let now = self.motion.clock.time();
        if self.motion.on_grid.is_some() && rest.first() == Some(&now) {
            let mut node = OwnedNode::new(n);
            node.take(self);
            let count = rest.iter().take_while(|t| **t == now).count();
            for t in &rest[..count] {
                if observer(&[*t], node.point()).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
            rest = &rest[count..];
        }
        // nodes of a grid lie within steps
        let mut is_known = self.motion.on_grid.is_some() && now != self.motion.time();
        while let Some(&t) = rest.first() {
            let here = t == self.motion.time();
            if here || self.motion.at_switch[1] && self.motion.is_near(t) {
                let point = self.motion.point();
                let told = self
                    .motion
                    .at_jump(&self.equations.declaration(), AnyPoint { t, ..point });
                let AnyPoint { q, v, a, .. } = point;
                let a = told.as_ref().map_or(a, |(a, _)| a);
                for (room, x) in buffer.chunks_exact_mut(n.max(1)).zip([q, v, a]) {
                    room.copy_from_slice(x);
                }
                if observer(&[t], &buffer[..3 * n]).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
                rest = &rest[1..];
                continue;
            }
            if !core::mem::take(&mut is_known) {
                self.motion.expansions = 0;
                self.motion.go(&mut *self.equations, end)?;
                if self.motion.on_grid.is_none() {
                    self.motion.clock.arrive(self.motion.time());
                }
            }
            let reached = self.motion.time();
            // at a switch a point has the side of the declaration
            let apart = |t: f64| !(self.motion.at_switch[1] && self.motion.is_near(t));
            let inside = |t: f64| (if forward { t < reached } else { t > reached }) && apart(t);
            let Some(polynomial) = self.motion.polynomial() else {
                continue;
            };
            loop {
                let next = &rest[..rest.len().min(BUFFER)];
                let (eights, _) = next.as_chunks::<8>();
                let first = 8 * eights.iter().take_while(|times| inside(times[7])).count();
                let others = next[first..].iter().take_while(|&&t| inside(t)).count();
                let within = &next[..first + others];
                if !within.is_empty() {
                    points(&polynomial, within, &mut buffer);
                    if observer(within, &buffer[..within.len() * 3 * n]).is_break() {
                        return Ok(ControlFlow::Break(()));
                    }
                }
                rest = &rest[within.len()..];
                if within.len() < BUFFER {
                    break;
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Moves to the next node of the grid.
    fn step_on_grid(&mut self, end: f64) -> Result<StepReport, RunError> {
        let (target, end) = self.motion.target(end);
        while !self.motion.covers(target) {
            self.motion.go(&mut *self.equations, end)?;
        }
        self.motion.arrive_on_grid(&*self.equations, target);
        Ok(self.motion.report())
    }

    /// [`AnyTaylorFlow::step_on_grid`] that shows the motion to a visitor.
    fn trace_on_grid(&mut self, end: f64, visit: &mut AnyVisitor<'_>) -> Result<StepEnd, RunError> {
        let (target, end) = self.motion.target(end);
        loop {
            if let Some(part) = self.motion.part(target) {
                let stop = visit(&self.equations.declaration(), &part)?;
                if let Some(s) = stop {
                    self.motion.stop_at(&mut *self.equations, s);
                    self.motion.shown = self.motion.time();
                    return Ok(StepEnd::AtStop);
                }
            }
            if self.motion.covers(target) {
                self.motion.arrive_on_grid(&*self.equations, target);
                return Ok(StepEnd::NextNode);
            }
            self.motion.shown = if self.motion.last_covers(self.motion.shown) {
                self.motion.time()
            } else {
                self.motion.shown
            };
            self.motion.go(&mut *self.equations, end)?;
        }
    }
}

/// Receives nodes on the way, and may end the run.
pub(super) type Visit<'a> = dyn FnMut(&Integrator) -> ControlFlow<()> + 'a;

impl Integrator {
    /// Puts the nodes on a grid of times.
    ///
    /// # Errors
    ///
    /// [`SetupError::Step`] if `h` is zero, infinite or not a number.
    pub(super) fn every(&mut self, h: f64) -> Result<(), SetupError> {
        if !h.is_finite() || h == 0.0 {
            return Err(SetupError::Step { h });
        }
        let handed = self.clock.is_handed_out();
        self.stand_here();
        self.shown = self.time();
        self.clock = Clock::even(self.time(), h);
        self.clock.hand_out(handed);
        Ok(())
    }

    /// Moves the current node of a grid to the end of the motion.
    pub(super) fn stand_here(&mut self) {
        let mut state = self.on_grid.take().unwrap_or_else(|| self.now.clone());
        state.copy(&self.now);
        state.parts().a.copy_from_slice(self.acceleration());
        self.on_grid = Some(state);
    }

    /// Hands out the nodes that the steps have reached, and returns the time that the next steps go to.
    /// Breaks at the last node, or if an observer ends the run.
    pub(super) fn hand_nodes_out(
        &mut self,
        equations: &dyn SeriesKernel,
        end: &End,
        mut observer: Option<&mut Visit<'_>>,
    ) -> ControlFlow<(), f64> {
        loop {
            if !self.clock.is_handed_out() {
                self.clock.hand_out(true);
            } else if self.on_grid.is_some() {
                if !self.reaches_node() {
                    break;
                }
                let (target, _) = self.target(end.time());
                self.arrive_on_grid(equations, target);
            } else if self.clock.time() == self.time() {
                break;
            } else {
                self.clock.arrive(self.time());
            }
            if let Some(observer) = &mut observer {
                observer(self)?;
            }
            if self.clock.has_reached(end) {
                return ControlFlow::Break(());
            }
            self.expansions = 0;
        }
        ControlFlow::Continue(self.towards(end))
    }

    /// The time that steps go to.
    pub(super) fn towards(&self, end: &End) -> f64 {
        if self.on_grid.is_some() {
            self.target(end.time()).1
        } else {
            end.time()
        }
    }

    /// Whether the next node of the grid has been reached.
    pub(super) fn reaches_node(&self) -> bool {
        self.covers(self.clock.time_of(self.clock.index() + 1))
    }

    /// The time of the next node, and the time that the steps go to.
    fn target(&self, end: f64) -> (f64, f64) {
        let target = self.clock.time_of(self.clock.index() + 1);
        let farther = if self.clock.is_forward() {
            end.max(target)
        } else {
            end.min(target)
        };
        (target, if end.is_infinite() { end } else { farther })
    }

    /// Whether the current node comes before a time.
    fn is_before(&self, t: f64) -> bool {
        if self.clock.is_forward() {
            self.clock.time() < t
        } else {
            self.clock.time() > t
        }
    }

    /// Whether the motion is known up to a time.
    fn covers(&self, t: f64) -> bool {
        if self.clock.is_forward() {
            self.time() >= t
        } else {
            self.time() <= t
        }
    }

    /// Whether the last step reaches a time.
    fn last_covers(&self, t: f64) -> bool {
        self.polynomial().is_some() && self.covers(t)
    }

    /// The part of the last step that has not been shown, up to a time.
    fn part(&self, target: f64) -> Option<AnyPolynomial<'_>> {
        let whole = self.polynomial()?;
        if self.shown == self.time() || !self.covers(self.shown) {
            return None;
        }
        let inside = |s: f64| s.clamp(f64::min(0.0, whole.to), f64::max(0.0, whole.to));
        let part = AnyPolynomial {
            from: inside(whole.since(self.shown)),
            to: inside(whole.since(target)),
            ..whole
        };
        (part.from != part.to).then_some(part)
    }

    /// Moves to the next node of the grid. Nothing is allocated.
    fn arrive_on_grid(&mut self, equations: &dyn SeriesKernel, target: f64) {
        match (self.last, &mut self.on_grid) {
            (Some((t, _)), Some(state)) => {
                let Parts { q, v, a } = state.parts();
                let ([q, q_low], [v, v_low]) = (q, v);
                self.series.point((target - t.hi[0]) - t.lo[0], [q, v, a]);
                // the low parts are used by projections alone
                if self.projection.is_some() {
                    q_low.fill(0.0);
                    v_low.fill(0.0);
                }
            }
            _ => self.stand_here(),
        }
        if let (Some(projection), Some(state)) = (&mut self.projection, &mut self.on_grid) {
            projection.apply(equations, target, state);
        }
        self.shown = target;
        self.clock.tick();
    }
}

/// The motion at some times, computed several at a time: position, velocity and acceleration of each, one
/// after the other. Nothing is allocated.
fn points(polynomial: &AnyPolynomial<'_>, times: &[f64], points: &mut [f64]) {
    fn values<const N: usize>(polynomial: &AnyPolynomial<'_>, times: &[f64], points: &mut [f64]) {
        dispatch::registers(Values::<N> {
            polynomial: *polynomial,
            times,
            points,
        });
    }
    match polynomial.series.dimension() {
        1 => values::<1>(polynomial, times, points),
        2 => values::<2>(polynomial, times, points),
        3 => values::<3>(polynomial, times, points),
        4 => values::<4>(polynomial, times, points),
        _ => values::<ANY>(polynomial, times, points),
    }
}

/// Stands for any number of coordinates, where there is no instance for the number itself.
const ANY: usize = 0;

/// The motion of `N` coordinates, or of any number for [`ANY`], at up to [`BUFFER`] times.
struct Values<'a, 'f, const N: usize> {
    polynomial: AnyPolynomial<'f>,
    times: &'a [f64],
    points: &'a mut [f64],
}

impl<const N: usize> WithSimd for Values<'_, '_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = if N == ANY {
            self.polynomial.series.dimension()
        } else {
            N
        };
        let (mut times, mut points) = (self.times, self.points);
        // the components fill a register, so no lane is lost for few times
        if N == S::F64_LANES {
            while let [_, ..] = times {
                let count = times.len().min(FEW);
                let Some((group, beyond)) = points.split_at_mut_checked(count * 3 * n) else {
                    return;
                };
                let (now, later) = times.split_at(count);
                match count {
                    1 => fill_components::<S, 1>(simd, &self.polynomial, now, group),
                    2 => fill_components::<S, 2>(simd, &self.polynomial, now, group),
                    _ => fill_components::<S, FEW>(simd, &self.polynomial, now, group),
                }
                (times, points) = (later, beyond);
            }
            return;
        }
        while !times.is_empty() {
            let registers = if times.len() > S::F64_LANES { REGISTERS } else { 1 };
            // with a buffer of whole groups there is always room
            let lanes = registers * S::F64_LANES;
            let Some((group, beyond)) = points.split_at_mut_checked(lanes * 3 * n) else {
                return;
            };
            let (now, later) = times.split_at(lanes.min(times.len()));
            if registers == 1 {
                fill::<S, 1>(simd, n, &self.polynomial, now, group);
            } else {
                fill::<S, REGISTERS>(simd, n, &self.polynomial, now, group);
            }
            (times, points) = (later, beyond);
        }
    }
}

/// Number of registers of times that are evaluated together. With fewer of them, each sum waits for the one before it; more do not fit.
const REGISTERS: usize = 3;

/// The motion of `n` coordinates at up to as many times as `R` registers hold, as long as there is room for
/// all of them.
#[inline(always)]
fn fill<S: Simd, const R: usize>(
    simd: S,
    n: usize,
    polynomial: &AnyPolynomial<'_>,
    times: &[f64],
    points: &mut [f64],
) {
    let mut since = [simd.splat_f64s(0.0); R];
    for (since, &t) in cast_slice_mut::<_, f64>(&mut since).iter_mut().zip(times) {
        *since = polynomial.since(t);
    }
    for i in 0..n {
        let [q, v, a] = polynomial.series.values(simd, (i, n), &since);
        let [q, v, a] = [&q, &v, &a].map(|x| cast_slice::<_, f64>(x));
        for (point, ((q, v), a)) in points.chunks_exact_mut(3 * n).zip(q.iter().zip(v).zip(a)) {
            (point[i], point[n + i], point[2 * n + i]) = (*q, *v, *a);
        }
    }
}

/// Number of times that are evaluated together if the components of the motion fill a register.
const FEW: usize = 3;

/// The motion at `R` times, of as many coordinates as a register holds.
#[inline(always)]
fn fill_components<S: Simd, const R: usize>(
    simd: S,
    polynomial: &AnyPolynomial<'_>,
    times: &[f64],
    points: &mut [f64],
) {
    let mut since = [simd.splat_f64s(0.0); R];
    for (since, &t) in since.iter_mut().zip(times) {
        *since = simd.splat_f64s(polynomial.since(t));
    }
    let values = polynomial.series.side_by_side(simd, &since);
    let (rows, _) = S::as_mut_simd_f64s(points);
    for (row, value) in rows.iter_mut().zip(values.as_flattened()) {
        *row = *value;
    }
}
