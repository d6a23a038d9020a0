//! A run by Taylor series: nodes at its own steps or on a grid of times.

use core::ops::ControlFlow;

use super::integrator::Integrator;
use super::jets::Equations;
use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::dispatch::{self, Work};
use crate::run::{self, Clock, End, Node, Observer, Polynomial, RunError, Stepper, Traced, View, Visitor};
use crate::step::StepReport;
use crate::system::Point;

/// So many points are worked out before they are handed on.
const BUFFER: usize = 32;

/// A motion in progress, whatever the system's type.
pub(super) struct Run<'a, const N: usize> {
    /// The motion.
    pub(super) motion: &'a mut Integrator<N>,
    /// The system.
    pub(super) equations: &'a mut dyn Equations<N>,
}

impl<const N: usize> Stepper<N> for Run<'_, N> {
    fn step(&mut self, end: f64) -> Result<StepReport, RunError> {
        self.motion.expansions = 0;
        if self.motion.on_grid.is_some() {
            return self.step_on_grid(end);
        }
        self.motion.go(self.equations, end)?;
        self.motion.clock.arrive(self.motion.time());
        Ok(self.motion.report())
    }

    fn node(&self) -> Node<N> {
        self.motion.node(self.equations)
    }

    fn clock(&self) -> &Clock {
        &self.motion.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.motion.clock
    }

    fn view(&self) -> &dyn View<N> {
        self.equations.view()
    }

    fn reverse(&mut self) -> Result<(), RunError> {
        self.motion.clock.turn();
        // at a knot or a switch the motion back is that of the other piece
        if !self.motion.knots.is_empty() || self.motion.watch.is_some() {
            self.motion.begin(self.equations);
        }
        Ok(())
    }

    fn trace(&mut self, end: f64, visit: &mut Visitor<'_, N>) -> Result<Traced, RunError> {
        self.motion.expansions = 0;
        if self.motion.on_grid.is_some() {
            return self.trace_on_grid(end, visit);
        }
        self.motion.go(self.equations, end)?;
        let stop = match self.motion.polynomial() {
            Some(polynomial) => visit(self.equations.view(), &polynomial),
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

    fn sample(
        &mut self,
        times: &[f64],
        observer: &mut dyn FnMut(f64, &Point<f64, N>),
    ) -> Result<(), RunError> {
        run::in_order(times, &self.motion.clock)?;
        if self.motion.on_grid.is_some() {
            return run::sample(&mut run::Of(self), times, observer);
        }
        let Some(&end) = times.last() else {
            return Ok(());
        };
        self.motion.clock.hand_out(true);
        let forward = self.motion.clock.is_forward();
        let mut buffer = [self.motion.point(); BUFFER];
        let mut rest = times;
        while let Some(&t) = rest.first() {
            if t == self.motion.time() {
                observer(t, &self.motion.point());
                rest = &rest[1..];
                continue;
            }
            self.step(end)?;
            let reached = self.motion.time();
            let inside = |t: f64| if forward { t < reached } else { t > reached };
            let (within, beyond) = rest.split_at(rest.iter().take_while(|&&t| inside(t)).count());
            let Some(polynomial) = self.motion.polynomial() else {
                continue;
            };
            for times in within.chunks(buffer.len()) {
                points(&polynomial, times, &mut buffer);
                for (&t, point) in times.iter().zip(&buffer) {
                    observer(t, point);
                }
            }
            rest = beyond;
        }
        Ok(())
    }
}

impl<const N: usize> Run<'_, N> {
    /// Goes to the next node of the grid.
    fn step_on_grid(&mut self, end: f64) -> Result<StepReport, RunError> {
        let (target, end) = self.motion.target(end);
        while !self.motion.covers(target) {
            self.motion.go(self.equations, end)?;
        }
        self.motion.arrive_on_grid(&self.equations.declaration(), target);
        Ok(self.motion.report())
    }

    /// The same, shown.
    fn trace_on_grid(&mut self, end: f64, visit: &mut Visitor<'_, N>) -> Result<Traced, RunError> {
        let (target, end) = self.motion.target(end);
        loop {
            if let Some(part) = self.motion.part(target) {
                let stop = visit(self.equations.view(), &part)?;
                if let Some(s) = stop {
                    self.motion.stop_at(self.equations, s);
                    self.motion.shown = self.motion.time();
                    return Ok(Traced::There);
                }
            }
            if self.motion.covers(target) {
                self.motion.arrive_on_grid(&self.equations.declaration(), target);
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

impl<const N: usize> Iterator for Run<'_, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
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
                self.arrive_on_grid(&equations.declaration(), target);
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
    fn part(&self, target: f64) -> Option<Polynomial<'_, N>> {
        let whole = self.polynomial()?;
        if self.shown == self.time() || !self.covers(self.shown) {
            return None;
        }
        let inside = |s: f64| s.clamp(f64::min(0.0, whole.to), f64::max(0.0, whole.to));
        let part = Polynomial {
            from: inside(whole.since(self.shown)),
            to: inside(whole.since(target)),
            ..whole
        };
        (part.from != part.to).then_some(part)
    }

    /// Stands at the next node of the grid.
    fn arrive_on_grid(&mut self, declaration: &Declaration<'_>, target: f64) {
        let mut point = self
            .polynomial()
            .map_or_else(|| self.point(), |polynomial| polynomial.at(target));
        if let Some(projection) = &mut self.projection {
            let (mut q, mut v) = (Compensated::exact(point.q), Compensated::exact(point.v));
            projection.apply(declaration, target, &mut q, &mut v);
            (point.q, point.v) = (q.hi, v.hi);
        }
        self.on_grid = Some(point);
        self.shown = target;
        self.clock.tick();
    }
}

/// The motion at some times, worked out several at a time; as many as both slices have. Nothing is allocated.
fn points<const N: usize>(polynomial: &Polynomial<'_, N>, times: &[f64], points: &mut [Point<f64, N>]) {
    dispatch::run(Values {
        polynomial: *polynomial,
        times,
        points,
    });
}

/// The motion at some times.
struct Values<'a, 'f, const N: usize> {
    polynomial: Polynomial<'f, N>,
    times: &'a [f64],
    points: &'a mut [Point<f64, N>],
}

impl<const N: usize> Work for Values<'_, '_, N> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let count = self.times.len().min(self.points.len());
        let (mut times, mut points) = (&self.times[..count], &mut self.points[..count]);
        while !times.is_empty() {
            let (done, rest) = if times.len() > FEW {
                times.split_at(MANY.min(times.len()))
            } else {
                (times, [].as_slice())
            };
            let (to, beyond) = points.split_at_mut(done.len());
            if done.len() > FEW {
                fill::<FUSED, N, MANY>(&self.polynomial, done, to);
            } else {
                fill::<FUSED, N, FEW>(&self.polynomial, done, to);
            }
            (times, points) = (rest, beyond);
        }
    }
}

/// Times at once: as long as some are left, and at the end. Chains of sums wait for themselves, so more of them side by
/// side take hardly longer.
const MANY: usize = 8;
const FEW: usize = 4;

/// The motion at up to `L` times.
#[inline(always)]
fn fill<const FUSED: bool, const N: usize, const L: usize>(
    polynomial: &Polynomial<'_, N>,
    times: &[f64],
    points: &mut [Point<f64, N>],
) {
    let mut since = [0.0; L];
    for (since, &t) in since.iter_mut().zip(times) {
        *since = polynomial.since(t);
    }
    let [q, v, a] = polynomial.series.values::<FUSED, L>(&since);
    for (lane, point) in points.iter_mut().enumerate().take(L) {
        *point = Point {
            t: times.get(lane).copied().unwrap_or(f64::NAN),
            q: core::array::from_fn(|i| q[i][lane]),
            v: core::array::from_fn(|i| v[i][lane]),
            a: core::array::from_fn(|i| a[i][lane]),
        };
    }
}
