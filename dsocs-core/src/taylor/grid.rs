//! A run by Taylor series: nodes at its own steps or on a grid of times.

use core::ops::ControlFlow;

use pulp::bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};

use super::integrator::Integrator;
use super::jets::Equations;
use crate::any::AnyPoint;
use crate::compensated::Compensated;
use crate::dispatch;
use crate::kernel::Kernel;
use crate::run::{
    self, AnyPolynomial, AnyVisitor, Clock, End, NodeMut, Observer, Polynomial, Room, RunError, Traced,
};
use crate::step::StepReport;
use crate::system::Point;

/// So many points are worked out before they are handed on: whole groups of registers of any size.
const BUFFER: usize = 8 * REGISTERS;

/// A motion in progress, whatever the system's type.
pub(super) struct Run<'a, const N: usize> {
    /// The motion.
    pub(super) motion: &'a mut Integrator<N>,
    /// The system.
    pub(super) equations: &'a mut dyn Equations<N>,
}

impl<const N: usize> run::Run for Run<'_, N> {
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
        self.motion.go(self.equations, end)?;
        self.motion.clock.arrive(self.motion.time());
        Ok(self.motion.report())
    }

    fn tell(&self, node: NodeMut<'_>) {
        node.write(&self.motion.node(self.equations).any());
    }

    fn clock(&self) -> &Clock {
        &self.motion.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.motion.clock
    }

    fn reverse(&mut self) -> Result<(), RunError> {
        self.motion.clock.turn();
        // at a knot or a switch the motion back is that of the other piece
        if !self.motion.knots.is_empty() || self.motion.watch.is_some() {
            self.motion.begin(self.equations);
        }
        Ok(())
    }

    fn trace(&mut self, end: f64, _: &mut Room, visit: &mut AnyVisitor<'_>) -> Result<Traced, RunError> {
        self.motion.expansions = 0;
        if self.motion.on_grid.is_some() {
            return self.trace_on_grid(end, visit);
        }
        self.motion.go(self.equations, end)?;
        let stop = match self.motion.polynomial() {
            Some(polynomial) => visit(&self.equations.declaration(), &polynomial),
            None => Ok(None),
        };
        if let Ok(Some(s)) = stop {
            self.motion.stop_at(self.equations, s);
        }
        self.motion.clock.arrive(self.motion.time());
        Ok(if stop?.is_some() {
            Traced::There
        } else {
            Traced::Whole
        })
    }

    fn sample_at_once(
        &mut self,
        times: &[f64],
        observer: &mut dyn FnMut(f64, AnyPoint<'_, f64>),
    ) -> Result<bool, RunError> {
        if self.motion.on_grid.is_some() {
            return Ok(false);
        }
        let Some(&end) = times.last() else {
            return Ok(true);
        };
        self.motion.clock.hand_out(true);
        let forward = self.motion.clock.is_forward();
        let mut buffer = [self.motion.point(); BUFFER];
        let mut rest = times;
        while let Some(&t) = rest.first() {
            if t == self.motion.time() {
                observer(t, self.motion.point().any());
                rest = &rest[1..];
                continue;
            }
            self.step(end)?;
            let reached = self.motion.time();
            let inside = |t: f64| if forward { t < reached } else { t > reached };
            let Some(polynomial) = self.motion.polynomial() else {
                continue;
            };
            loop {
                let next = &rest[..rest.len().min(buffer.len())];
                let (eights, _) = next.as_chunks::<8>();
                let first = 8 * eights.iter().take_while(|times| inside(times[7])).count();
                let others = next[first..].iter().take_while(|&&t| inside(t)).count();
                let within = &next[..first + others];
                if !within.is_empty() {
                    points(&polynomial, within, &mut buffer);
                }
                for (&t, point) in within.iter().zip(&buffer) {
                    observer(t, point.any());
                }
                rest = &rest[within.len()..];
                if within.len() < buffer.len() {
                    break;
                }
            }
        }
        Ok(true)
    }
}

impl<const N: usize> Run<'_, N> {
    /// Goes to the next node of the grid.
    fn step_on_grid(&mut self, end: f64) -> Result<StepReport, RunError> {
        let (target, end) = self.motion.target(end);
        while !self.motion.covers(target) {
            self.motion.go(self.equations, end)?;
        }
        self.motion.arrive_on_grid(self.equations, target);
        Ok(self.motion.report())
    }

    /// The same, shown.
    fn trace_on_grid(&mut self, end: f64, visit: &mut AnyVisitor<'_>) -> Result<Traced, RunError> {
        let (target, end) = self.motion.target(end);
        loop {
            if let Some(part) = self.motion.part(target) {
                let stop = visit(&self.equations.declaration(), &part)?;
                if let Some(s) = stop {
                    self.motion.stop_at(self.equations, s);
                    self.motion.shown = self.motion.time();
                    return Ok(Traced::There);
                }
            }
            if self.motion.covers(target) {
                self.motion.arrive_on_grid(self.equations, target);
                return Ok(Traced::Whole);
            }
            self.motion.shown = if self.motion.last_covers(self.motion.shown) {
                self.motion.time()
            } else {
                self.motion.shown
            };
            self.motion.go(self.equations, end)?;
        }
    }
}

impl<const N: usize> Integrator<N> {
    /// Hands out the nodes that the steps have come to, and returns the time that the next ones go towards; breaks at the last node, and
    /// where an observer ends the run.
    pub(super) fn hand_nodes_out(
        &mut self,
        equations: &dyn Equations<N>,
        end: &End,
        mut observer: Option<&mut dyn Observer<N>>,
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
                observer.node(&self.node(equations))?;
            }
            if self.clock.has_reached(end) {
                return ControlFlow::Break(());
            }
            self.expansions = 0;
        }
        ControlFlow::Continue(self.towards(end))
    }

    /// The time that steps go towards.
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

    /// The time of the next node, and the time that the steps go towards.
    fn target(&self, end: f64) -> (f64, f64) {
        let target = self.clock.time_of(self.clock.index() + 1);
        let farther = if self.clock.is_forward() {
            end.max(target)
        } else {
            end.min(target)
        };
        (target, if end.is_infinite() { end } else { farther })
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

    /// What has not been shown of the last step, up to a time.
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

    /// Stands at the next node of the grid.
    fn arrive_on_grid(&mut self, equations: &dyn Equations<N>, target: f64) {
        let mut point = self.polynomial().map_or_else(
            || self.point(),
            |polynomial| Polynomial::of(polynomial).at(target),
        );
        if let Some(projection) = &mut self.projection {
            let (mut q, mut v) = (Compensated::exact(point.q), Compensated::exact(point.v));
            projection.apply(equations, target, &mut q, &mut v);
            (point.q, point.v) = (q.hi, v.hi);
        }
        self.on_grid = Some(point);
        self.shown = target;
        self.clock.tick();
    }
}

/// The motion at some times, worked out several at a time. Nothing is allocated.
fn points<const N: usize>(
    polynomial: &AnyPolynomial<'_>,
    times: &[f64],
    points: &mut [Point<f64, N>; BUFFER],
) {
    dispatch::registers(Values {
        polynomial: *polynomial,
        times,
        points,
    });
}

/// The motion at up to [`BUFFER`] times.
struct Values<'a, 'f, const N: usize> {
    polynomial: AnyPolynomial<'f>,
    times: &'a [f64],
    points: &'a mut [Point<f64, N>; BUFFER],
}

impl<const N: usize> WithSimd for Values<'_, '_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (mut times, mut points) = (self.times, self.points.as_mut_slice());
        while !times.is_empty() {
            let registers = if times.len() > S::F64_LANES { REGISTERS } else { 1 };
            // with a buffer of whole groups there is always room
            let Some((group, beyond)) = points.split_at_mut_checked(registers * S::F64_LANES) else {
                return;
            };
            let (now, later) = times.split_at(group.len().min(times.len()));
            if registers == 1 {
                fill::<S, N, 1>(simd, &self.polynomial, now, group);
            } else {
                fill::<S, N, REGISTERS>(simd, &self.polynomial, now, group);
            }
            (times, points) = (later, beyond);
        }
    }
}

/// Registers of times at once, as long as there are so many: chains of sums wait for themselves, and more of them have no room.
const REGISTERS: usize = 3;

/// The motion at up to as many times as `R` registers hold, where there is room for all of them.
#[inline(always)]
fn fill<S: Simd, const N: usize, const R: usize>(
    simd: S,
    polynomial: &AnyPolynomial<'_>,
    times: &[f64],
    points: &mut [Point<f64, N>],
) {
    let mut since = [simd.splat_f64s(0.0); R];
    for (since, &t) in cast_slice_mut::<_, f64>(&mut since).iter_mut().zip(times) {
        *since = polynomial.since(t);
    }
    // all lanes, since loops of a known length need no checks
    let lanes = R * S::F64_LANES;
    let points = &mut points[..lanes];
    for i in 0..N {
        let [q, v, a] = polynomial.series.values(simd, i, &since);
        let [q, v, a] = [&q, &v, &a].map(|x| cast_slice::<_, f64>(x));
        for lane in 0..lanes {
            (points[lane].q[i], points[lane].v[i], points[lane].a[i]) = (q[lane], v[lane], a[lane]);
        }
    }
    for (point, &t) in points.iter_mut().zip(times) {
        point.t = t;
    }
}
