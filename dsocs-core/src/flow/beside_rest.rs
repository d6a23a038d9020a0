//! Whether the acceleration jumps in a step beside what rests or comes to rest.
//!
//! Neither a stop nor a release at the bound of a side costs an order. A jump of a force does, be it one that lets a resting mass go or one that acts on another
//! coordinate; and so does an argument that goes from one side to the other. The acceleration is looked at with what rests held, or held as long as its
//! sides allow it: then only such a jump is left in it.

use super::discrete::Discrete;
use super::stick::Contacts;
use crate::regularity::resting::{AtPoint, Held};
use crate::regularity::sides::Piece;
use crate::regularity::sticking::Solution;
use crate::solve::Vector;
use crate::step::jumps;
use crate::step::smooth::FORESEEN;

/// An acceleration is known to this part of what sides make of it.
const NOISE: f64 = 1e-9;

/// At so many places of each step it is looked for a jump.
const PLACES: u8 = 6;

/// Whether an argument goes from one side to the other.
fn crosses(ends: (&Piece, &Piece)) -> bool {
    matches!(ends, (Piece::Minus, Piece::Plus) | (Piece::Plus, Piece::Minus))
}

impl Discrete<'_> {
    /// How much the acceleration jumps in a step, relative to itself, other than by a stop or by a release at the bound of a side; infinite where it is not
    /// determined.
    #[cold]
    pub(super) fn jump_in_step(&self, contacts: &mut Contacts, solution: &Solution) -> f64 {
        let before = contacts.before(self.course.index());
        if before.iter().zip(&solution.pieces).any(crosses) {
            return self.jump_of_crossing(&before, &solution.pieces, &solution.e);
        }
        let e = &solution.e;
        let is_released =
            |(before, after): (&Piece, &Piece)| *before == Piece::Between && *after != Piece::Between;
        let releases = contacts.pieces.iter().zip(&solution.pieces).any(is_released);
        if !releases && self.goes_on(contacts, e) {
            return 0.0;
        }
        let both = before.iter().zip(&solution.pieces);
        let held: Vec<Piece> = both
            .map(|(before, after)| match before {
                Piece::Between => Piece::Between,
                _ => *after,
            })
            .collect();
        self.jump_beside(contacts, &held, releases, e)
    }

    /// Whether each component of a second difference is as the last one or as the past leads to expect, to a part of itself or to the noise of an acceleration.
    fn goes_on(&self, contacts: &Contacts, e: &[f64]) -> bool {
        let last = self.course.has_solved.then(|| self.course.vectors.e());
        let expected = contacts.expected(self.course.index());
        let square = self.course.h * self.course.h;
        (0..e.len()).all(|i| {
            let room = (FORESEEN * e[i].abs()).max(self.noise(contacts, i) * square);
            let mut others = [last, expected.as_deref()].into_iter().flatten();
            others.any(|other| (e[i] - other[i]).abs() <= room)
        })
    }

    /// How large an acceleration may be by rounding.
    fn noise(&self, contacts: &Contacts, component: usize) -> f64 {
        let reach = contacts.reach.get(component).map_or(0.0, |reach| NOISE * reach);
        reach.max(jumps::rounding(self.course.h, self.next_leg().d[component]))
    }

    /// The place of a step with a second difference, in steps from its middle node: time, position and velocity.
    fn place(&self, place: f64, e: &[f64]) -> (f64, Vector, Vector) {
        let (leg, h) = (self.next_leg(), self.course.h);
        let moved = (place + 0.5).max(0.0);
        let v = Vector::of(leg.d).zip(e, |d, e| (d + moved * e) / h);
        let d = Vector::of(leg.d).zip(e, |d, e| if place < 0.0 { d } else { d + e });
        let q = Vector::of(leg.q).zip(&d, |q, d| q + place * d);
        (self.course.time() + place * h, q, v)
    }

    /// How much the acceleration jumps from the middle of the step before on, relative to itself, if what rests goes on to rest or, with `releases`, does so
    /// as long as it can: then neither a stop nor a release at the bound of a side makes it jump.
    #[cold]
    fn jump_beside(&self, contacts: &mut Contacts, pieces: &[Piece], releases: bool, e: &[f64]) -> f64 {
        let (declaration, h) = (self.declaration(), self.course.h);
        let multipliers = declaration.shape().multipliers();
        let guess = Held::guess(&Vector::of(e).map(|e| e / (h * h)), multipliers, pieces.len());
        let (t, q, v) = self.place(0.0, e);
        // what is not determined here has been solved for by the step
        let Some(mut now) = AtPoint::new(declaration, (t, &q, &v)).held(pieces, &guess) else {
            return 0.0;
        };
        contacts.reach.clone_from(&now.reach);
        if !releases && self.goes_on(contacts, e) {
            return 0.0;
        }
        let zero: Vec<bool> = pieces.iter().map(|piece| *piece == Piece::Between).collect();
        // the step that follows looks at what comes after this one; a release grows from nothing, and that it does so is told by what comes after
        let steps = if releases { 3 } else { 2 };
        let mut accelerations = Vec::with_capacity(usize::from(steps * PLACES) + 1);
        for place in 0..=steps * PLACES {
            let place = f64::from(place) / f64::from(PLACES) - 1.5;
            let (t, q, v) = self.place(place, e);
            let point = AtPoint::new(declaration, (t, &q, &v));
            let found = if releases {
                let found = point.solve(&zero, multipliers, Some(&now.x));
                found.map(|found| now.x = found.x)
            } else {
                point.held(pieces, &now).map(|held| now = held)
            };
            if found.is_none() {
                return 0.0;
            }
            accelerations.push(Vector::of(&now.x[..e.len()]));
        }
        jumps::of_acceleration(&accelerations, |i| self.noise(contacts, i))
    }

    /// How much the acceleration jumps, relative to itself, where arguments go from one side to the other in a step with a second difference; infinite where
    /// it is not determined.
    fn jump_of_crossing(&self, before: &[Piece], after: &[Piece], e: &[f64]) -> f64 {
        let (declaration, h) = (self.declaration(), self.course.h);
        let (t, q, v) = self.place(0.0, e);
        let point = AtPoint::new(declaration, (t, &q, &v));
        let a = Vector::of(e).map(|e| e / (h * h));
        let accelerations = |crossing: bool| {
            let both = before.iter().zip(after);
            let pieces: Vec<Piece> = both
                .map(|(before, after)| {
                    if crossing && crosses((before, after)) {
                        *before
                    } else {
                        *after
                    }
                })
                .collect();
            let guess = Held::guess(&a, declaration.shape().multipliers(), pieces.len());
            point.held(&pieces, &guess)
        };
        let (Some(before), Some(after)) = (accelerations(true), accelerations(false)) else {
            return f64::INFINITY;
        };
        let parts = (0..e.len()).map(|i| {
            let [before, after] = [before.x[i], after.x[i]];
            let jump = (after - before).abs();
            if jump == 0.0 {
                0.0
            } else {
                jump / before.abs().max(after.abs())
            }
        });
        parts.fold(0.0, f64::max)
    }
}
