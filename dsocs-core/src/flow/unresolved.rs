//! Whether a step is short enough for what switches.
//!
//! A step evaluates a force on its two legs. If the force switches between them and nowhere else, the rows do not show it. An example is dry
//! friction where the velocity changes its sign. The rows are solved, but the error of the motion is of first order in the step. So the force is
//! also evaluated between the middles of the two legs. If the step resolves the force, it changes there nearly linearly. The same holds for a
//! constraint or a Lagrangian with pieces: of these the acceleration is looked at.

use super::{Flow, Solved};
use crate::any::{AnyLeg, AnySystem};
use crate::declaration::Declaration;
use crate::step::newton::Stop;
use crate::system::{Leg, System};

/// Where the force is evaluated between the middles of the legs: 0 is the first, 1 the second.
const BETWEEN: [f64; 3] = [0.25, 0.5, 0.75];

/// In so many equal parts a step is divided to tell whether its acceleration jumps.
const PLACES: u8 = 16;

/// Only steps that differ from their prediction are examined: by more than this, relative to the second difference. A force that
/// changes as predicted has not been switched.
pub(crate) const FORESEEN: f64 = 0.1;

/// A force is unresolved if its departure from a straight line, over a step, is more than this part of the change of the momentum.
const UNRESOLVED: f64 = 0.1;

/// The steps of a run that were too long for what switches in them. In such a step, an external force departs from the straight line between its
/// values on the two legs. The step is counted if this departure is more than a tenth of the change of the momentum over the step, or of the force
/// if that is larger. If a constraint or the Lagrangian has a `signum` or a comparison, the step is also counted if the acceleration jumps by more than
/// a tenth of itself; and if the velocity changes by a tenth of itself although no acceleration explains it. Each such step reduces the
/// order of the run to 1, and a velocity that jumps makes the motion depend on where the nodes lie.
///
/// The usual case is dry friction that changes its direction within a step. The nodes still obey the discrete equations, and the run goes on. Where
/// these have no solution, because a function jumps over it, the node is that of the jump, and the step is counted, too
/// ([`Stop::Jump`](crate::Stop::Jump)). So is the step in which friction stops a mass, but not those in which it holds it
/// ([`Stop::Sticks`](crate::Stop::Sticks)).
///
/// Three things help: a smaller step, a function that changes more smoothly, or [`TaylorFlow`](crate::TaylorFlow), whose steps end at the jump, unless the motion
/// sticks there. What switches is evaluated at some places between the legs, and only in steps that differ from their prediction. So a pulse
/// shorter than a quarter of a step may be missed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unresolved {
    /// How many steps.
    pub steps: u64,
    /// The time of the middle node of the first of them.
    pub first: f64,
    /// The largest departure from the straight line, relative to the change of the momentum over the step, or to the acceleration \[1\].
    pub largest: f64,
}

impl<S: System<N>, const N: usize> Flow<'_, S, N> {
    /// Whether anything is declared that may switch within a step and be seen there.
    pub(super) const MAY_SWITCH: bool = S::EXTERNAL_FORCES || S::PIECEWISE;

    /// Whether a solution is close to its prediction. Its second difference is `e`.
    #[inline]
    pub(super) fn foresees(&self, z: &S::Unknown<f64>, e: &[f64; N]) -> bool {
        if !z.as_ref().is_empty() {
            return self.predictor.foresees(z, FORESEEN);
        }
        // steps without unknowns have no predictor
        self.solved.is_some_and(|last| {
            let pairs = e.iter().zip(&last.e);
            pairs
                .into_iter()
                .all(|(e, last)| (e - last).abs() <= FORESEEN * e.abs())
        })
    }

    /// Examines the step that begins with `leg`, has the second difference `e` and ended with `stop`: whether anything switches between its legs.
    /// The step before is examined, too, if it was not yet. Its second difference may contain half of the same jump, which can be too small to be
    /// noticed by itself.
    #[cold]
    pub(super) fn look_between(&mut self, leg: &Leg<f64, N>, e: &[f64; N], stop: Stop) {
        if let (Some(Solved { leg, e, report }), false) = (self.solved, self.looked) {
            let before = self.clock.time_of(self.index().saturating_sub(1));
            self.look_at(before, &leg, &e, report.stop);
        }
        // a step that begins at a jump meets it once more
        let begins_at_jump = self.solved.is_some_and(|last| last.report.stop == Stop::Jump);
        if stop == Stop::Jump || !begins_at_jump {
            self.look_at(self.time(), leg, e, stop);
        }
    }

    /// Examines one step, whose middle node has the time given.
    fn look_at(&mut self, time: f64, leg: &Leg<f64, N>, e: &[f64; N], stop: Stop) {
        let leg = Leg { t: time, ..*leg };
        let system: &S = &self.system;
        let mut part = 0.0_f64;
        if S::EXTERNAL_FORCES {
            part = part.max(departure(&Declaration::of(system), self.h, &leg, e));
        }
        if S::PIECEWISE {
            part = part.max(jump_of_acceleration(system, self.h, &leg, e));
            part = part.max(kick(system, self.h, &leg, e));
        }
        if part > UNRESOLVED || stop == Stop::Jump {
            self.count_unresolved(time, part);
        }
    }
}

/// The path of a step from the middle of its first leg, at 0, to that of the second, at 1: time, position and velocity.
fn between<const N: usize>(h: f64, leg: &Leg<f64, N>, e: &[f64; N], part: f64) -> (f64, [f64; N], [f64; N]) {
    let place = part - 0.5;
    let next: [f64; N] = core::array::from_fn(|i| leg.d[i] + e[i]);
    let d = if place < 0.0 { &leg.d } else { &next };
    let q = core::array::from_fn(|i| leg.q[i] + place * d[i]);
    let v = core::array::from_fn(|i| (leg.d[i] + part * e[i]) / h);
    (leg.t + place * h, q, v)
}

/// How much the acceleration jumps between the middles of two legs, relative to itself: the largest of all components. Zero where the equations
/// do not determine it.
fn jump_of_acceleration<S: System<N>, const N: usize>(
    system: &S,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
) -> f64 {
    let any: &dyn AnySystem<N> = system;
    let acceleration = |place: u8| {
        let (t, q, v) = between(h, leg, e, f64::from(place) / f64::from(PLACES));
        any.acceleration((t, &q, &v), None).ok().map(|(a, _)| a)
    };
    let Some(mut before) = acceleration(0) else {
        return 0.0;
    };
    let (mut least, mut most, mut widest) = (before, before, [0.0_f64; N]);
    for place in 1..=PLACES {
        let Some(now) = acceleration(place) else {
            return 0.0;
        };
        for i in 0..N {
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
    (0..N).map(jump).fold(0.0, f64::max)
}

/// How much of the velocity changes in a step although no acceleration explains it, as at a corner of a constraint or where a mass jumps: the
/// largest of all components. Zero where the equations do not determine the acceleration.
fn kick<S: System<N>, const N: usize>(system: &S, h: f64, leg: &Leg<f64, N>, e: &[f64; N]) -> f64 {
    let any: &dyn AnySystem<N> = system;
    let (t, q, v) = between(h, leg, e, 0.5);
    let Ok((a, _)) = any.acceleration((t, &q, &v), None) else {
        return 0.0;
    };
    let parts = (0..N).map(|i| {
        let velocity = leg.d[i].abs().max((leg.d[i] + e[i]).abs());
        (e[i] - a[i] * h * h).abs() / velocity
    });
    parts.fold(0.0, f64::max)
}

/// How far the forces depart from the straight line between the middles of two legs: the largest of all components. It is relative to the
/// change of the momentum over a step or to the force, whichever is larger.
fn departure<const N: usize>(declaration: &Declaration<'_>, h: f64, leg: &Leg<f64, N>, e: &[f64; N]) -> f64 {
    let next: [f64; N] = core::array::from_fn(|i| leg.d[i] + e[i]);
    let force = |part: f64| {
        let (t, q, v) = between(h, leg, e, part);
        let mut force = [0.0; N];
        declaration.external_forces(t, &q, &v, &mut force);
        force
    };
    let [first, last] = [0.0, 1.0].map(force);
    let mut aside = [0.0_f64; N];
    for part in BETWEEN {
        for (i, (aside, force)) in aside.iter_mut().zip(force(part)).enumerate() {
            *aside = aside.max((force - (first[i] + part * (last[i] - first[i]))).abs());
        }
    }
    let arrives = declaration.arriving(h, leg.any());
    let leaves = declaration.arriving(
        h,
        AnyLeg {
            t: leg.t + h,
            q: &core::array::from_fn::<_, N, _>(|i| leg.q[i] + next[i]),
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
