//! Whether a step is short enough for what switches.
//!
//! A step evaluates a force on its two legs. If the force switches between them and nowhere else, the rows do not show it. An example is dry
//! friction where the velocity changes its sign. The rows are solved, but the error of the motion is of first order in the step. So the force is
//! also evaluated between the middles of the two legs. If the step resolves the force, it changes there nearly linearly. The same holds for a
//! constraint or a Lagrangian with pieces: of these the acceleration is looked at.

use super::discrete::Discrete;
use crate::number::point::AnyLeg;
use crate::solve::Vector;
use crate::solve::newton::Stop;
use crate::solve::predictor;
use crate::start;
use crate::step::smooth::FORESEEN;
use crate::tape::declaration::Declaration;

/// Where the force is evaluated between the middles of the legs: 0 is the first, 1 the second.
const BETWEEN: [f64; 3] = [0.25, 0.5, 0.75];

/// In so many equal parts a step is divided to tell whether its acceleration jumps.
const PLACES: u8 = 16;

/// A force is unresolved if its departure from a straight line, over a step, is more than this part of the change of the momentum.
const UNRESOLVED: f64 = 0.1;

impl Discrete<'_> {
    /// Whether a force or a row may switch between the places where a step evaluates it.
    pub(super) fn may_switch(&self) -> bool {
        let shape = self.shape();
        !shape.is_of_third_order() && (shape.external_forces || shape.piecewise)
    }

    /// Whether a solution is near its prediction: a force that switches shows first there.
    pub(super) fn foresees(&self, z: &[f64], e: &[f64]) -> bool {
        if !z.is_empty() {
            return self.course.predictor.foresees(z, FORESEEN);
        }
        // steps without unknowns have no predictor
        self.course.has_solved && predictor::foresees(self.course.vectors.e(), e, FORESEEN)
    }

    /// Looks at the step that was solved, and at the one before if nobody has: where the solution was not foreseen.
    #[cold]
    pub(super) fn look_between(&mut self, e: &[f64], stop: Stop) {
        let course = &self.course;
        if course.has_solved && !course.looked {
            let before = course.clock.time_of(course.index().saturating_sub(1));
            let leg = AnyLeg {
                t: before,
                ..course.solved_leg()
            };
            let (part, stop) = (self.departure(leg, course.vectors.e()), course.report.stop);
            self.count(before, part, stop);
        }
        // a step that begins at a jump meets it once more
        let course = &self.course;
        let begins_at_jump = course.has_solved && course.report.stop == Stop::Jump;
        if stop == Stop::Jump || !begins_at_jump {
            let leg = AnyLeg {
                t: course.time(),
                ..self.next_leg()
            };
            let (time, part) = (leg.t, self.departure(leg, e));
            self.count(time, part, stop);
        }
    }

    /// Counts a step that is too long for what switches in it.
    fn count(&mut self, time: f64, part: f64, stop: Stop) {
        if part > UNRESOLVED || stop == Stop::Jump {
            self.count_unresolved(time, part);
        }
    }

    /// How far forces and accelerations are from changing linearly within a step, relative to themselves.
    fn departure(&self, leg: AnyLeg<'_, f64>, e: &[f64]) -> f64 {
        let (shape, declaration, h) = (self.shape(), self.declaration(), self.course.h);
        let mut part = 0.0_f64;
        if shape.external_forces {
            part = part.max(departure(&declaration, h, leg, e));
        }
        if shape.piecewise {
            part = part.max(jump_of_acceleration(&declaration, h, leg, e));
            part = part.max(kick(&declaration, h, leg, e));
        }
        part
    }
}

/// The path of a step from the middle of its first leg, at 0, to that of the second, at 1: time, position and velocity.
fn between(h: f64, leg: AnyLeg<'_, f64>, e: &[f64], part: f64) -> (f64, Vector, Vector) {
    let place = part - 0.5;
    let next = Vector::of(leg.d).zip(e, |d, e| d + e);
    let d = if place < 0.0 { leg.d } else { &next };
    let q = Vector::of(leg.q).zip(d, |q, d| q + place * d);
    let v = Vector::of(leg.d).zip(e, |d, e| (d + part * e) / h);
    (leg.t + place * h, q, v)
}

/// How much the acceleration jumps between the middles of two legs, relative to itself: the largest of all components. Zero where the equations
/// do not determine it.
fn jump_of_acceleration(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> f64 {
    let acceleration = |place: u8| {
        let (t, q, v) = between(h, leg, e, f64::from(place) / f64::from(PLACES));
        start::acceleration(declaration, (t, &q, &v), None)
            .ok()
            .map(|(a, _)| a)
    };
    let Some(mut before) = acceleration(0) else {
        return 0.0;
    };
    let (mut least, mut most, mut widest) = (before.clone(), before.clone(), Vector::zero(e.len()));
    for place in 1..=PLACES {
        let Some(now) = acceleration(place) else {
            return 0.0;
        };
        for i in 0..e.len() {
            widest[i] = widest[i].max((now[i] - before[i]).abs());
            (least[i], most[i]) = (least[i].min(now[i]), most[i].max(now[i]));
        }
        before = now;
    }
    let jump = |i: usize| {
        // what moves a node by less than the rounding of the increment is no jump
        let is_rounding = widest[i] * h * h <= f64::EPSILON * leg.d[i].abs();
        // what is smooth changes little from place to place
        let is_jump = !is_rounding && widest[i] >= 0.5 * (most[i] - least[i]);
        if is_jump {
            widest[i] / most[i].abs().max(least[i].abs())
        } else {
            0.0
        }
    };
    (0..e.len()).map(jump).fold(0.0, f64::max)
}

/// How much of the velocity changes in a step although no acceleration explains it, as at a corner of a constraint or where a mass jumps: the
/// largest of all components. Zero where the equations do not determine the acceleration.
fn kick(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> f64 {
    let (t, q, v) = between(h, leg, e, 0.5);
    let Ok((a, _)) = start::acceleration(declaration, (t, &q, &v), None) else {
        return 0.0;
    };
    let parts = (0..e.len()).map(|i| {
        let velocity = leg.d[i].abs().max((leg.d[i] + e[i]).abs());
        (e[i] - a[i] * h * h).abs() / velocity
    });
    parts.fold(0.0, f64::max)
}

/// How far the forces depart from the straight line between the middles of two legs: the largest of all components. It is relative to the
/// change of the momentum over a step or to the force, whichever is larger.
fn departure(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> f64 {
    let next = Vector::of(leg.d).zip(e, |d, e| d + e);
    let force = |part: f64| {
        let (t, q, v) = between(h, leg, e, part);
        let mut force = Vector::zero(e.len());
        declaration.external_forces(t, &q[..], &v[..], &mut force);
        force
    };
    let [first, last] = [0.0, 1.0].map(force);
    let mut aside = Vector::zero(e.len());
    for part in BETWEEN {
        for (i, (aside, force)) in aside.iter_mut().zip(force(part).iter()).enumerate() {
            *aside = aside.max((force - (first[i] + part * (last[i] - first[i]))).abs());
        }
    }
    let arrives = declaration.arriving(h, leg);
    let leaves = declaration.arriving(
        h,
        AnyLeg {
            t: leg.t + h,
            q: &Vector::of(leg.q).zip(&next, |q, d| q + d),
            d: &next,
        },
    );
    let parts = aside.iter().enumerate().map(|(i, aside)| {
        // L_d is a Lagrangian, not an action: its derivatives are momenta divided by the step
        let change = (leaves[i] - arrives[i]).abs();
        aside / change.max(first[i].abs()).max(last[i].abs())
    });
    parts.fold(0.0, f64::max)
}
