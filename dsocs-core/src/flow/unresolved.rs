//! Whether a step resolves a force that changes within it.
//!
//! A step evaluates a force on its two legs. If the force changes between them and nowhere else, the rows do
//! not show it. An example is dry friction where the velocity changes its sign. The rows are solved, but the
//! error of the motion is of first order in the step. So the force is also evaluated between the middles of
//! the two legs. If the step resolves the force, it changes there nearly linearly in every quarter of the
//! path, or as a polynomial of low degree. (A force that grows from nothing, as after a start from rest, or
//! that has a multiple zero, is curved on the scale of any step.) For a constraint or a Lagrangian with
//! pieces the acceleration is examined in the same way. See [`crate::step::jumps`].

use core::cell::LazyCell;

use super::discrete::Discrete;
use super::jumps::{between, first_half};
use crate::number::bounded::Bounded;
use crate::number::point::{AnyLeg, map};
use crate::number::scalar::Scalar as _;
use crate::run::Unresolved;
use crate::solve::newton::Stop;
use crate::solve::predictor;
use crate::solve::{Vector, rotation};
use crate::start::place::{MotionPath, Place};
use crate::step::jumps;
use crate::step::smooth::NEAR_PREDICTION;
use crate::tape::declaration::Declaration;

impl Discrete<'_> {
    /// Whether forces are examined in steps that differ from their prediction.
    pub(super) fn may_switch(&self) -> bool {
        let shape = self.shape();
        !shape.is_of_third_order() && shape.external_forces
    }

    /// Whether a solution is near its prediction: a jump of a force shows there first.
    pub(super) fn is_near_prediction(&self, z: &[f64], e: &[f64]) -> bool {
        let vectors = &self.run_state.vectors;
        let past = self.run_state.has_solved.then(|| [vectors.before(), vectors.e()]);
        predictor::continues(z.len(), past, e, NEAR_PREDICTION)
            && (z.is_empty() || self.run_state.predictor.is_near_prediction(z, NEAR_PREDICTION))
    }

    /// Examines the solved step, and the one before if it was not, because the solution differs from its
    /// prediction.
    #[cold]
    pub(super) fn look_between(&mut self, e: &[f64], stop: Stop) {
        let run_state = &self.run_state;
        if run_state.has_solved && !run_state.is_examined {
            let before = run_state.clock.time_of(run_state.index().saturating_sub(1));
            let leg = AnyLeg {
                t: before,
                ..run_state.solved_leg()
            };
            let (part, stop) = (self.departure(leg, run_state.vectors.e()), run_state.report.stop);
            self.count(before, part, stop);
        }
        if !self.run_state.has_solved && self.run_state.index() == 1 {
            let part = self.departure_at_start(e);
            self.count(self.computed_start.t0, part, Stop::Update);
        }
        // a step that begins at a jump would report the same jump again
        let run_state = &self.run_state;
        let begins_at_jump = run_state.has_solved && run_state.report.stop == Stop::Jump;
        if stop == Stop::Jump || !begins_at_jump {
            self.count_departure(e, stop);
        }
    }

    /// Counts the solved step, if it does not resolve a force.
    pub(super) fn count_departure(&mut self, e: &[f64], stop: Stop) {
        let leg = AnyLeg {
            t: self.run_state.time(),
            ..self.next_leg()
        };
        let (time, part) = (leg.t, self.departure(leg, e));
        self.count(time, part, stop);
    }

    /// Counts a step that does not resolve a force.
    fn count(&mut self, time: f64, part: f64, stop: Stop) {
        if part > jumps::UNRESOLVED || stop == Stop::Jump {
            Unresolved::count(&mut self.unresolved, time, part);
        }
    }

    /// Deviation of the forces from a linear change within a step, relative to themselves.
    fn departure(&self, leg: AnyLeg<'_, f64>, e: &[f64]) -> f64 {
        let h = self.run_state.h;
        departure(&self.declaration(), h, leg, e, &|part| {
            between(&self.shape().rotations, (h, leg), e, part)
        })
    }

    /// [`Discrete::departure`] from the start to the middle of the first leg, with the second difference of
    /// the first step.
    fn departure_at_start(&self, e: &[f64]) -> f64 {
        let (leg, h) = (self.next_leg(), self.run_state.h);
        let path = |part: f64| first_half(&self.shape().rotations, &self.computed_start, (h, leg), part);
        departure(&self.declaration(), h, leg, e, &path)
    }
}

/// Deviation of the forces from the straight line between the ends of a path: the largest of all components,
/// relative to the change of the momentum over a step or to the force, whichever is larger.
fn departure(
    declaration: &Declaration<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    e: &[f64],
    path: &MotionPath<'_>,
) -> f64 {
    let next = Vector::of(leg.d).zip(e, |d, e| d + e);
    let force = |part: f64| {
        let Place { t, q, v, .. } = path(part);
        let mut force = Vector::zero(e.len());
        declaration.external_forces(t, &q[..], &v[..], &mut force);
        force
    };
    let forces: Vec<Vector> = jumps::places().map(force).collect();
    let errors = LazyCell::new(|| {
        let bounds = jumps::places().map(|part| {
            let Place { t, q, v, .. } = path(part);
            let mut force = vec![Bounded::splat(0.0); e.len()];
            // a velocity is a quotient of a rounded increment
            let [q, v] = [
                map(&q, Bounded::splat),
                map(&v, |v| Bounded::known(v, f64::EPSILON * v.abs())),
            ];
            declaration.external_forces(Bounded::splat(t), &q, &v, &mut force);
            Vector::from_fn(e.len(), |i| force[i].error())
        });
        bounds.fold(Vector::zero(e.len()), |most, bound| most.zip(&bound, f64::max))
    });
    // a function that has reached its limit, and a force that has found its balance, deviate by rounding: each value, and the line
    // between two of them
    let is_rounding = |values: &[f64], i: usize| jumps::aside(values) <= 2.0 * errors[i];
    let arrives = declaration.arriving(h, leg);
    let leaves = declaration.arriving(
        h,
        AnyLeg {
            t: leg.t + h,
            q: &rotation::moved_vector(&declaration.shape().rotations, leg.q, &next),
            d: &next,
        },
    );
    let parts = (0..e.len()).map(|i| {
        let values: Vec<f64> = forces.iter().map(|force| force[i]).collect();
        if jumps::is_smooth(&values) || is_rounding(&values, i) {
            return 0.0;
        }
        let whole = jumps::aside(&values);
        // L_d is a Lagrangian, not an action: its derivatives are momenta divided by the step
        let change = (leaves[i] - arrives[i]).abs();
        // far from a narrow feature its force is no rounding of the momentum, and changes by large factors
        if whole <= f64::EPSILON * leaves[i].abs().max(arrives[i].abs()) {
            return 0.0;
        }
        let ends = [values.first(), values.last()].into_iter().flatten();
        whole / ends.fold(change, |largest, force| largest.max(force.abs()))
    });
    parts.fold(0.0, f64::max)
}
