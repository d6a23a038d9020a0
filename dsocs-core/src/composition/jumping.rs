//! Composed steps in which a body comes to rest, rests or slips where a function jumps with the velocity.
//!
//! A leg that goes back in time does not notice a rest that begins or ends on it, and on a moving surface legs of different lengths rest at
//! different velocities. So such a step is replaced by the paper's steps of a part of its length, all forward, with sides (see
//! [`crate::regularity::sticking`]). It is of order 2, like every step in which the acceleration jumps.

use super::run::Composed;
use super::stages::{ComposedState, State};
use crate::flow::discrete::Discrete;
use crate::kernel::report::StepReport;
use crate::number::tangent::Tangent;
use crate::regularity::sticking;
use crate::run::{OwnedNode, Run as _, RunError, Unresolved};
use crate::solve::Vector;
use crate::solve::rotation;
use crate::solve::sum::Sum;
use crate::start::{self, Rule, StartData, half_leg};

/// Number of the paper's steps that replace a composed one.
const PARTS: u32 = 16;

/// An argument is near zero if it may vanish within this number of steps, at its current rate.
const NEAR: f64 = 2.0;

impl Composed<'_> {
    /// The arguments of functions that jump with the velocity at the current node, with their rates for an
    /// acceleration.
    fn side_arguments(&self, a: &[f64]) -> Vec<Tangent> {
        let State { q, v, .. } = &self.run_state.now;
        let along = |x: &[f64], by: &[f64]| -> Vec<Tangent> {
            let both = x.iter().zip(by);
            both.map(|(x, by)| Tangent::new(*x, *by)).collect()
        };
        self.declaration().side_arguments(
            Tangent::new(self.run_state.clock.time(), 1.0),
            &along(
                &q.hi,
                &rotation::rate(&self.kernel.shape().rotations, &q.hi, &v.hi),
            ),
            &along(&v.hi, a),
        )
    }

    /// Whether an argument is zero at the current node, or may become so within the next step.
    pub(super) fn is_near_rest(&self) -> bool {
        let State { q, v, a } = &self.run_state.now;
        if self.resting.contains(&true)
            || sticking::rests_at(&self.declaration(), self.run_state.clock.time(), &q.hi, &v.hi)
        {
            return true;
        }
        // rates with the acceleration of the body, and without it: those of a surface that moves by itself
        let (moving, steady) = (self.side_arguments(a), self.side_arguments(&a.map(|_| 0.0)));
        let mut both = moving.iter().zip(&steady);
        // false also for a NaN
        let is_clear = |moving: &Tangent, steady: &Tangent| {
            let change = moving.derivative().abs() + steady.derivative().abs();
            moving.value().abs() > NEAR * (change * self.h).abs()
        };
        !both.all(|(moving, steady)| is_clear(moving, steady))
    }

    /// Whether an argument has another sign than at the beginning of a step that was undone.
    pub(super) fn has_crossed(&self, before: &ComposedState) -> bool {
        let State { q, v, .. } = &before.now;
        let t = before.clock.time();
        let before = self.declaration().side_arguments(t, &q.hi[..], &v.hi[..]);
        let now = self.side_arguments(&self.run_state.now.a);
        let mut both = before.iter().zip(&now);
        both.any(|(before, now)| before * now.value() <= 0.0)
    }

    /// Makes a step as [`PARTS`] short steps of order 2.
    #[cold]
    pub(super) fn step_slowly(&mut self) -> Result<StepReport, RunError> {
        let h = self.h / f64::from(PARTS);
        let State { q, v, a } = &self.run_state.now;
        let t0 = self.run_state.clock.time();
        let mut d = Sum {
            hi: v.hi.map(|v| h * v),
            lo: v.lo.map(|v| h * v),
        };
        let mean = half_leg::mean_acceleration(&self.declaration(), h, (t0, &q.hi, &v.hi), a);
        d.add(&mean.as_ref().unwrap_or(a).map(|a| 0.5 * h * h * a));
        let given = StartData {
            q0: q.hi.clone(),
            rule: Rule::Exact {
                v0: v.hi.clone(),
                a0: a.clone(),
                d,
                h,
                t0,
            },
            t0,
            projected: false,
            near: None,
        };
        let mut flow = Discrete::new(self.kernel, self.values.clone(), h, &given)?;
        flow.begin_at_rest(&self.resting);
        flow.steps(u64::from(PARTS))?;
        self.resting = flow.resting_arguments();
        let mut node = OwnedNode::new(0);
        node.take(&flow);
        let node = node.any();
        let force = Vector::of(node.force);
        let report = StepReport {
            stop: node.stop,
            iterations: node.iterations,
            guess: crate::kernel::report::Guess::Predicted,
        };
        if let Some(found) = flow.unresolved() {
            Unresolved::add(&mut self.unresolved, found);
        }
        self.run_state.now = State {
            q: Sum::exact(Vector::of(node.q)),
            v: Sum::exact(Vector::of(node.v)),
            a: Vector::of(node.a),
        };
        self.run_state.clock.tick();
        // the legs before this node are not extrapolated
        self.run_state.since = self.run_state.clock.index();
        self.prepare();
        self.run_state.report = report;
        let t = self.run_state.clock.time();
        if !self.is_near_rest() {
            // the next step is composed again and needs the acceleration of the continuous system
            let State { q, v, a } = &self.run_state.now;
            let found = start::acceleration(&self.declaration(), (t, &q.hi, &v.hi), Some(a));
            if let Ok((a, _)) = found {
                self.run_state.now.a = a;
            }
        }
        self.join_again(t)?;
        self.force = Some((self.run_state.clock.index(), force));
        Ok(report)
    }
}
