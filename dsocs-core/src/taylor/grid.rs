//! A run by Taylor series: nodes at its own steps or on a grid of times.

use core::iter::FusedIterator;

use super::dispatch::{self, Work};
use super::{Jets, TaylorFlow};
use crate::run::{self, Clock, Node, Polynomial, RunError, Stepper, Traced, View, Visitor};
use crate::step::StepReport;
use crate::system::Point;

/// So many points are worked out before they are handed on.
const BUFFER: usize = 32;

impl<S: Jets<N>, const N: usize> Stepper<N> for TaylorFlow<'_, S, N> {
    #[inline]
    fn step(&mut self, end: f64) -> Result<StepReport, RunError> {
        self.expansions = 0;
        if self.on_grid.is_some() {
            return self.step_on_grid(end);
        }
        self.go(end)?;
        self.clock.arrive(self.time());
        Ok(self.report())
    }

    fn node(&self) -> Node<N> {
        self.node_here()
    }

    fn clock(&self) -> &Clock {
        &self.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.clock
    }

    fn view(&self) -> &dyn View<N> {
        self.system()
    }

    /// Turns round. The motion back is that of the tolerance, too: it returns to within the tolerance, not to rounding.
    fn reverse(&mut self) -> Result<(), RunError> {
        self.clock.turn();
        Ok(())
    }

    fn trace(&mut self, end: f64, visit: &mut Visitor<'_, N>) -> Result<Traced, RunError> {
        self.expansions = 0;
        if self.on_grid.is_some() {
            return self.trace_on_grid(end, visit);
        }
        self.go(end)?;
        let stop = match self.polynomial() {
            Some(polynomial) => visit(self.system(), &polynomial),
            None => Ok(None),
        };
        if let Ok(Some(s)) = stop {
            self.stop_at(s);
        }
        self.clock.arrive(self.time());
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
        run::in_order(times, &self.clock)?;
        if self.on_grid.is_some() {
            return run::sample(&mut run::Of(self), times, observer);
        }
        let Some(&end) = times.last() else {
            return Ok(());
        };
        self.clock.hand_out(true);
        let forward = self.clock.is_forward();
        let mut buffer = [self.point(); BUFFER];
        let mut rest = times;
        while let Some(&t) = rest.first() {
            if t == self.time() {
                observer(t, &self.point());
                rest = &rest[1..];
                continue;
            }
            self.step(end)?;
            let reached = self.time();
            let inside = |t: f64| if forward { t < reached } else { t > reached };
            let (within, beyond) = rest.split_at(rest.iter().take_while(|&&t| inside(t)).count());
            let Some(polynomial) = self.polynomial() else {
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

impl<S: Jets<N>, const N: usize> TaylorFlow<'_, S, N> {
    /// Goes to the next node of the grid.
    fn step_on_grid(&mut self, end: f64) -> Result<StepReport, RunError> {
        let (target, end) = self.target(end);
        while !self.covers(target) {
            self.go(end)?;
        }
        self.arrive_on_grid(target);
        Ok(self.report())
    }

    /// The same, shown.
    fn trace_on_grid(&mut self, end: f64, visit: &mut Visitor<'_, N>) -> Result<Traced, RunError> {
        let (target, end) = self.target(end);
        loop {
            if let Some(part) = self.part(target) {
                let stop = visit(self.system(), &part)?;
                if let Some(s) = stop {
                    self.stop_at(s);
                    self.shown = self.time();
                    return Ok(Traced::There);
                }
            }
            if self.covers(target) {
                self.arrive_on_grid(target);
                return Ok(Traced::Whole);
            }
            self.shown = if self.last_covers(self.shown) {
                self.time()
            } else {
                self.shown
            };
            self.go(end)?;
        }
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
    fn arrive_on_grid(&mut self, target: f64) {
        let point = self
            .polynomial()
            .map_or_else(|| self.point(), |polynomial| polynomial.at(target));
        self.on_grid = Some(point);
        self.shown = target;
        self.clock.tick();
    }
}

impl<S: Jets<N>, const N: usize> Iterator for TaylorFlow<'_, S, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<S: Jets<N>, const N: usize> FusedIterator for TaylorFlow<'_, S, N> {}

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
            q: core::array::from_fn(|i| q[i][lane]),
            v: core::array::from_fn(|i| v[i][lane]),
            a: core::array::from_fn(|i| a[i][lane]),
        };
    }
}
