//! The steps of a flow in which something jumps.
//!
//! A step is a motion from the middle of one leg to that of the next; of third order, on the cubic polynomial through four nodes, from the second of them
//! to the third. Where an argument of the declaration changes its sign on this way, it is asked what jumps there ([`OnWay`]). Neither a stop nor a release
//! at the bound of a side costs an order, so the arguments of what rests when the step begins or when it ends are not asked for.

use super::discrete::Discrete;
use crate::number::point::AnyLeg;
use crate::regularity::sides::Piece;
use crate::run::Unresolved;
use crate::solve::{Vector, rotation};
use crate::start::Beginning;
use crate::start::place::{Place, Way};
use crate::step::crossing::OnWay;
use crate::step::jumps;
use crate::step::switches;
use crate::tape::declaration::Declaration;

/// The arguments of a run's switches.
#[derive(Clone, Debug)]
pub(super) struct Switches {
    /// The signs with which the motion left the last way that was looked at.
    came: Vec<f64>,
    /// The number of the step after it.
    index: u64,
}

/// What holds on a step.
#[derive(Clone, Copy)]
pub(super) struct Span<'a> {
    /// Where the arguments of functions that jump with the velocity are when it begins; those between rest. Empty where none rests.
    pub(super) before: &'a [Piece],
    /// Where they are when it ends.
    pub(super) after: &'a [Piece],
    /// The values of inputs that change at its middle node.
    pub(super) inputs: Option<&'a [f64]>,
}

impl Span<'_> {
    /// Whether it is asked where an argument changes its sign, by its number and its value at the end of the step: not that of what rests, comes to rest or is
    /// let go, and of what keeps its side: just after a release an argument is not yet clear of zero.
    fn asks(&self, switch: usize, last: f64) -> bool {
        let Some(before) = self.before.get(switch) else {
            return true;
        };
        let after = self.after.get(switch).copied();
        let after = after.unwrap_or_else(|| Piece::of(last));
        *before != after && *before != Piece::Between && after != Piece::Between
    }
}

impl Switches {
    /// Those of a start; `None` if there are none that are watched.
    pub(super) fn of(declaration: &Declaration<'_>) -> Option<Self> {
        let count = declaration.switches();
        (count > 0 || declaration.has_tables()).then(|| Self {
            came: vec![0.0; count],
            index: 0,
        })
    }

    /// Forgets where the motion comes from.
    pub(super) fn forget(&mut self) {
        self.came.fill(0.0);
    }
}

impl Discrete<'_> {
    /// In how many steps an argument may change its sign, if the second difference is about `e`; 0 if one may do so in the next step.
    pub(super) fn clear_of_switches(&self, e: &Vector) -> u64 {
        switches::clear_after(&self.declaration(), &|part| self.between(e, part))
    }

    /// Looks for jumps on the way of the next step, whose second difference is known, from the start on if it is the first. Returns whether an argument
    /// changes its sign there.
    #[cold]
    pub(super) fn look_for_jumps(&mut self, span: Span<'_>, e: &[f64]) -> bool {
        let Some(mut switches) = self.switches.take() else {
            return false;
        };
        let (index, h) = (self.course.index(), self.course.h);
        if switches.index != index {
            switches.forget();
        }
        let leg = AnyLeg {
            t: self.course.time(),
            ..self.next_leg()
        };
        let first = |part: f64| self.beginning_of(leg, e, part);
        let way = |part: f64| self.between(e, part);
        let (mut part, mut any) = (0.0_f64, false);
        let now = self.declaration();
        // inputs change at the middle node
        let old = span
            .inputs
            .map_or(now, |inputs| Declaration::of(self.kernel).with(inputs));
        let ways: [(&Way<'_>, [Declaration<'_>; 2]); 2] = [(&first, [old; 2]), (&way, [old, now])];
        for (way, declarations) in &ways[usize::from(index != self.first_step())..] {
            let found = switches::crossings(now, way, &mut switches.came, |switch, last| {
                span.asks(switch, last)
            });
            let on = OnWay {
                way: *way,
                h,
                declarations: *declarations,
                pieces: span.before,
            };
            for crossing in &found {
                any = true;
                part = part.max(on.jump_at(*crossing));
            }
            // what jumps says all; what is smooth where a sign changes may be narrow there, or beside
            if part <= jumps::TOLD {
                for place in switches::narrow_places(&now, way, |switch, last| span.asks(switch, last)) {
                    part = part.max(on.swings_at(place));
                }
            }
        }
        let time = leg.t;
        switches.index = index + 1;
        self.switches = Some(switches);
        if part > jumps::TOLD {
            Unresolved::count(&mut self.unresolved, time, part);
        }
        any
    }

    /// The number of the first step that is solved: of third order the start makes one.
    pub(super) fn first_step(&self) -> u64 {
        if self.shape().is_of_third_order() { 2 } else { 1 }
    }

    /// The way of the next step, with its second difference, from the middle of its first leg, at 0, to that of the second, at 1. Of third order, with the
    /// third difference, it is that from the second of its four nodes to the third: there accelerations go on from step to step.
    fn between(&self, e: &[f64], part: f64) -> Place {
        let leg = AnyLeg {
            t: self.course.time(),
            ..self.next_leg()
        };
        if self.shape().is_of_third_order() {
            return self.on_cubic(e, part - 1.0);
        }
        between(&self.shape().rotations, (self.course.h, leg), e, part)
    }

    /// A place of the next step of third order, so many steps behind its middle node.
    pub(super) fn on_cubic(&self, e: &[f64], steps: f64) -> Place {
        let leg = AnyLeg {
            t: self.course.time(),
            ..self.next_leg()
        };
        Place::on_cubic(self.course.h, leg, &self.course.vectors.second().hi, e, steps)
    }

    /// The way from the start, at 0, to that of the first step, at 1.
    fn beginning_of(&self, leg: AnyLeg<'_, f64>, e: &[f64], part: f64) -> Place {
        if self.shape().is_of_third_order() {
            let steps = part - 2.0;
            // what jumps where the motion begins has its side in motion
            let Place { v, a, .. } = self.on_cubic(e, steps.max(-1.5));
            return Place {
                v,
                a,
                ..self.on_cubic(e, steps)
            };
        }
        first_half(
            &self.shape().rotations,
            &self.beginning,
            (self.course.h, leg),
            part,
        )
    }
}

/// The way from the start, at 0, to the middle of the first leg, at 1.
pub(super) fn first_half(
    rotations: &[usize],
    beginning: &Beginning,
    (h, leg): (f64, AnyLeg<'_, f64>),
    part: f64,
) -> Place {
    let way = Vector::of(leg.d).map(|d| 0.5 * part * d);
    let q = rotation::moved_vector(rotations, &beginning.q0, &way);
    // what jumps at rest has its side in motion
    Place::of_phase(beginning.t0 + 0.5 * part * h, q, Vector::of(leg.d).map(|d| d / h))
}

/// The way of a step from the middle of its first leg, at 0, to that of the second, at 1, as the acceleration is the same all along.
pub(super) fn between(rotations: &[usize], (h, leg): (f64, AnyLeg<'_, f64>), e: &[f64], part: f64) -> Place {
    let place = part - 0.5;
    let way = Vector::from_fn(e.len(), |i| place * (leg.d[i] + 0.5 * e[i] + 0.5 * place * e[i]));
    let q = rotation::moved_vector(rotations, leg.q, &way);
    let v = Vector::of(leg.d).zip(e, |d, e| (d + part * e) / h);
    Place::of_phase(leg.t + place * h, q, v)
}
