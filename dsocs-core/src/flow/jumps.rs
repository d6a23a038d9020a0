//! The steps of a flow in which the acceleration jumps.
//!
//! The path of a step leads from the middle of one leg to that of the next; in third order, on the cubic
//! polynomial through four nodes, from the second to the third. If an argument of the declaration changes its
//! sign on this path, the jump there is measured ([`StepPath`]). Neither a stop nor a release lowers the order,
//! so arguments that rest at the beginning or at the end of the step are not examined.

use super::discrete::Discrete;
use crate::number::bounded::Bounded;
use crate::number::point::{AnyLeg, OwnedLeg, map};
use crate::number::scalar::Scalar as _;
use crate::regularity::multipliers;
use crate::regularity::sides::Piece;
use crate::run::Unresolved;
use crate::solve::{Vector, rotation};
use crate::start::ComputedStart;
use crate::start::place::{MotionPath, Place};
use crate::step::crossing::{Change, StepPath};
use crate::step::jumps;
use crate::step::switches::{self, LastArguments};
use crate::tape::declaration::Declaration;

/// A place of the path of a step nearer to its middle node than this, as a part of the step, is at the node.
const AT_NODE: f64 = 1e-6;

/// Parts of the step by which its first leg is moved along the motion, forth and back, to see whether its equations jump at the node: by the
/// second, a smooth row changes by 1/16 of what it changes by the first, and one that jumps by as much.
const MOVED_BY: [f64; 2] = [1.6e-4, 1e-5];

/// The state of the arguments of piecewise functions.
#[derive(Clone, Debug)]
pub(super) struct ArgumentSigns {
    /// The arguments at the end of the last path that was examined.
    last: LastArguments,
    /// The index of the step that follows this path.
    index: u64,
    /// The numbers of the arguments with which the acceleration jumps on this path ([`Crossing::switch`](crate::step::switches::Crossing::switch)).
    jumped: Vec<usize>,
}

/// The conditions of a step.
#[derive(Clone, Copy)]
pub(super) struct StepConditions<'a> {
    /// The pieces of the arguments of functions that jump with the velocity, at the beginning of the step;
    /// those between rest. Empty if none rests.
    pub(super) before: &'a [Piece],
    /// Their pieces at the end of the step, if each side acts on its own part of the step; else empty.
    pub(super) after: &'a [Piece],
    /// The old values of inputs that change at its middle node.
    pub(super) inputs: Option<&'a [f64]>,
}

impl StepConditions<'_> {
    /// Whether an argument rests at an end of the step: then the declared equations alone do not determine the force.
    fn rests(&self) -> bool {
        [self.before, self.after]
            .iter()
            .any(|pieces| pieces.contains(&Piece::Between))
    }

    /// Whether the change of sign of an argument in a step is examined, given the argument's number and its value at the end of the step.
    /// That of an argument that rests, comes to rest or is released is not, nor any whose sides act on their own parts of the step, unless
    /// inputs change in it; nor is that of one that keeps its side, since just after a release an argument is near zero.
    fn is_examined(&self, switch: usize, last: f64) -> bool {
        let Some(before) = self.before.get(switch) else {
            return true;
        };
        let after = self.after.get(switch).copied();
        let has_parts = after.is_some() && self.inputs.is_none();
        let after = after.unwrap_or_else(|| Piece::of(last));
        !has_parts && *before != after && *before != Piece::Between && after != Piece::Between
    }
}

impl ArgumentSigns {
    /// The signs at the start; `None` if the declaration has no arguments to watch.
    pub(super) fn of(declaration: &Declaration<'_>) -> Option<Self> {
        declaration.is_switching().then(|| Self {
            last: LastArguments::unknown(declaration),
            index: 0,
            jumped: Vec::new(),
        })
    }

    /// Forgets the signs before the next path.
    pub(super) fn forget(&mut self) {
        self.last.forget();
    }
}

impl Discrete<'_> {
    /// Number of steps until an argument may change its sign, if the second difference is about `e`; 0 if one
    /// may do so in the next step.
    pub(super) fn clear_of_switches(&self, e: &Vector) -> u64 {
        switches::clear_after(&self.declaration(), &|part| self.between(e, part))
    }

    /// Searches for jumps on the path of the next step, whose second difference is known, and for the first
    /// step on the path from the start. Returns whether an argument changes its sign there.
    #[cold]
    pub(super) fn look_for_jumps(&mut self, span: StepConditions<'_>, e: &[f64]) -> bool {
        let Some(mut switches) = self.switches.take() else {
            return false;
        };
        let (index, h) = (self.run_state.index(), self.run_state.h);
        if switches.index != index {
            switches.forget();
        }
        switches.jumped.clear();
        let leg = AnyLeg {
            t: self.run_state.time(),
            ..self.next_leg()
        };
        let first = |part: f64| self.beginning_of(leg, e, part);
        let path = |part: f64| self.between(e, part);
        let (mut part, mut any) = (0.0_f64, false);
        let now = self.declaration();
        // inputs change at the middle node
        let old = span
            .inputs
            .map_or(now, |inputs| Declaration::of(self.kernel).with(inputs));
        let paths: [(&MotionPath<'_>, [Declaration<'_>; 2]); 2] = [(&first, [old; 2]), (&path, [old, now])];
        // at its middle node, the step is evaluated or is not: if not, a jump there is resolved
        let resolves = |on: &StepPath<'_>, [before, after]: [f64; 2]| {
            let is_at_node = (before - 0.5).abs().max((after - 0.5).abs()) < AT_NODE;
            is_at_node && span.inputs.is_none() && !span.rests() && !self.jumps_at_node(&now, on.h, leg, e)
        };
        for (number, (path, declarations)) in paths
            .iter()
            .enumerate()
            .skip(usize::from(index != self.first_step()))
        {
            let found = switches::crossings(now, path, &mut switches.last.signs, |switch, last| {
                span.is_examined(switch, last)
            });
            let along = |path| StepPath {
                path,
                h,
                declarations: *declarations,
                pieces: span.before,
            };
            let on = along(*path);
            for crossing in &found {
                any = true;
                let Change { size, is_jump } = on.change_at(*crossing);
                if is_jump {
                    switches.jumped.push(crossing.switch);
                }
                if size > jumps::REPORTED && size.is_finite() && number == 1 && resolves(&on, crossing.parts)
                {
                    continue;
                }
                part = part.max(size);
            }
            // a jump that is reported is enough; without one, features narrower than the step may lie at or
            // beside the change of sign
            if part <= jumps::REPORTED {
                let swings = |on: &StepPath<'_>, between: Vec<f64>| {
                    let is_examined = |switch, last| span.is_examined(switch, last);
                    let narrow = switches::narrow_places(&now, on.path, is_examined).into_iter();
                    let swings = narrow.map(|place| on.swings_at(place));
                    let between = between.into_iter().filter_map(|place| on.deviation(place));
                    let swings = swings.chain(between);
                    swings.fold(0.0, f64::max)
                };
                let with_last = |part: f64| self.with_last(e, part);
                let continued = number == 1 && self.run_state.has_solved;
                let around = along(if continued { &with_last } else { *path });
                part = part.max(swings(&around, switches.last.changes.between(&found)));
                // a force that acts at the middle node alone leads away from the path that would show it
                if part <= jumps::REPORTED && number == 1 {
                    let expected = |part: f64| self.between(self.run_state.vectors.e(), part);
                    let on = along(&expected);
                    let mut unknown = vec![0.0; now.switches()];
                    let found = switches::crossings(now, on.path, &mut unknown, |switch, last| {
                        span.is_examined(switch, last)
                    });
                    part = part.max(swings(&on, switches.last.changes.between(&found)));
                }
            }
            // the path from the start is half as long as that of a step
            let is_half = number == 0 && !now.shape().is_of_third_order();
            switches
                .last
                .changes
                .push(&now, &found, if is_half { 0.5 } else { 1.0 });
        }
        let time = leg.t;
        switches.index = index + 1;
        self.switches = Some(switches);
        if part > jumps::REPORTED {
            Unresolved::count(&mut self.unresolved, time, part);
        }
        any
    }

    /// The numbers of the arguments with which the acceleration jumps in the last step ([`Crossing::switch`](crate::step::switches::Crossing::switch)).
    pub(crate) fn jumped(&self) -> &[usize] {
        let switches = self.switches.as_ref();
        let examined = switches.filter(|switches| switches.index == self.run_state.index());
        examined.map_or(&[], |switches| &switches.jumped)
    }

    /// Whether the equations of a step jump as its nodes are moved a little along the motion: then they are evaluated at the middle node, on one
    /// side of a jump there. Equations that are evaluated within the legs alone take each leg's own side, as the motion does. In third order
    /// they are taken to jump.
    #[cold]
    fn jumps_at_node(&self, declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> bool {
        let shape = self.shape();
        if shape.is_of_third_order() {
            return true;
        }
        let multipliers = multipliers::of_step(declaration, h, leg, e);
        let rows = |part: f64| {
            let by = leg.d.iter().map(|d| part * d).collect::<Vec<_>>();
            let moved = OwnedLeg {
                t: leg.t + part * h,
                q: rotation::moved(&shape.rotations, leg.q, &by),
                d: leg.d.iter().zip(e).map(|(d, e)| d + part * e).collect(),
            };
            declaration.declared(h, moved.any(), e, &multipliers)
        };
        let [far, near] = MOVED_BY.map(|part| [rows(-part), rows(part)]);
        let bounded = |x: &[f64]| map(x, Bounded::splat);
        let (q, d) = (bounded(leg.q), bounded(leg.d));
        let leg = AnyLeg {
            t: Bounded::splat(leg.t),
            q: &q,
            d: &d,
        };
        let errors = declaration.declared(Bounded::splat(h), leg, &bounded(e), &bounded(&multipliers));
        errors.iter().enumerate().any(|(i, at)| {
            let [far, near] = [&far, &near].map(|[before, after]| (after[i] - before[i]).abs());
            // false also for a NaN
            let is_smooth = near <= 2.0 * at.error() || near <= 0.5 * far;
            !is_smooth
        })
    }

    /// The number of the first solved step; in third order the start gives one.
    pub(super) fn first_step(&self) -> u64 {
        if self.shape().is_of_third_order() { 2 } else { 1 }
    }

    /// The path of the next step, for its second difference, from the middle of its first leg, at 0, to that
    /// of the second, at 1. In third order, for the third difference, it leads from the second of its four
    /// nodes to the third, so that accelerations are continuous from step to step.
    fn between(&self, e: &[f64], part: f64) -> Place {
        let leg = AnyLeg {
            t: self.run_state.time(),
            ..self.next_leg()
        };
        if self.shape().is_of_third_order() {
            return self.on_cubic(e, part - 1.0);
        }
        between(&self.shape().rotations, (self.run_state.h, leg), e, part)
    }

    /// The path of the next step, before its beginning that of the last one.
    fn with_last(&self, e: &[f64], part: f64) -> Place {
        let shape = self.shape();
        if part >= 0.0 || shape.is_of_third_order() {
            return self.between(e, part);
        }
        let h = self.run_state.h;
        let leg = AnyLeg {
            t: self.run_state.time() - h,
            ..self.run_state.solved_leg()
        };
        between(&shape.rotations, (h, leg), self.run_state.vectors.e(), part + 1.0)
    }

    /// A place of the next step in third order, `steps` steps after its middle node.
    pub(super) fn on_cubic(&self, e: &[f64], steps: f64) -> Place {
        let leg = AnyLeg {
            t: self.run_state.time(),
            ..self.next_leg()
        };
        Place::on_cubic(
            self.run_state.h,
            leg,
            &self.run_state.vectors.second().hi,
            e,
            steps,
        )
    }

    /// The path from the start, at 0, to the beginning of the first step's path, at 1.
    fn beginning_of(&self, leg: AnyLeg<'_, f64>, e: &[f64], part: f64) -> Place {
        if self.shape().is_of_third_order() {
            let steps = part - 2.0;
            // a function that jumps at rest has the side of the motion that begins
            let Place { v, a, .. } = self.on_cubic(e, steps.max(-1.5));
            return Place {
                v,
                a,
                ..self.on_cubic(e, steps)
            };
        }
        first_half(
            &self.shape().rotations,
            &self.computed_start,
            (self.run_state.h, leg),
            part,
        )
    }
}

/// The path from the start, at 0, to the middle of the first leg, at 1.
pub(super) fn first_half(
    rotations: &[usize],
    computed_start: &ComputedStart,
    (h, leg): (f64, AnyLeg<'_, f64>),
    part: f64,
) -> Place {
    let displacement = Vector::of(leg.d).map(|d| 0.5 * part * d);
    let q = rotation::moved_vector(rotations, &computed_start.q0, &displacement);
    // a function that jumps at rest has the side of the motion that begins
    Place::of_phase(
        computed_start.t0 + 0.5 * part * h,
        q,
        Vector::of(leg.d).map(|d| d / h),
    )
}

/// The path of a step from the middle of its first leg, at 0, to that of the second, at 1, with constant
/// acceleration.
pub(super) fn between(rotations: &[usize], (h, leg): (f64, AnyLeg<'_, f64>), e: &[f64], part: f64) -> Place {
    let place = part - 0.5;
    let displacement = Vector::from_fn(e.len(), |i| place * (leg.d[i] + 0.5 * e[i] + 0.5 * place * e[i]));
    let q = rotation::moved_vector(rotations, leg.q, &displacement);
    let v = Vector::of(leg.d).zip(e, |d, e| (d + part * e) / h);
    Place::of_phase(leg.t + place * h, q, v)
}
