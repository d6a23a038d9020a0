//! The places on the path of a step at which a declaration changes its piece.
//!
//! The declaration gives the arguments of all piecewise expressions, and the divisors. If one of them changes
//! its sign on a path, the place is located to rounding. [`crossing`](super::crossing) measures what jumps
//! there.

use super::{jumps, knots, steep};
use crate::start::place::MotionPath;
use crate::tape::declaration::Declaration;

/// The parts of a path at which arguments are evaluated.
pub(super) const PLACES: [f64; 3] = [0.0, 0.5, 1.0];

/// Largest number of bisections of a bracket.
const HALVINGS: u32 = 48;

/// Length at which a bracket is short enough, as a part of the path: smooth quantities agree at its two ends.
const SHORT: f64 = 1e-12;

/// From a bracket's end, distances are doubled up to this many times until the argument has a clear sign, then [`MARGIN`] times more.
const DOUBLINGS: u32 = 20;
const MARGIN: usize = 3;

/// If an argument changed its sign between two paths, these powers of ½ are tried as distances back, from the
/// last to the first.
const BACK: core::ops::RangeInclusive<i32> = 1..=27;

/// If the parabola through three values of an argument comes nearer to zero than this part of its range, its
/// extremum is searched.
const NEARLY: f64 = 0.1;

/// An argument nearly touches zero if its extremum on a path is below this part of its values at the ends.
const DEEP: f64 = 0.75;

/// A part of the path beside an extremum, where the argument is larger at least if the extremum lies nearer to an end of the path.
const BESIDE: f64 = 0.125;

/// An extremum nearer to the beginning of a path than this belongs to the path before, which looks a little farther.
const NEXT: f64 = 1.0 / 32.0;
const OVERLAP: f64 = 1.125;

/// Number of sections of the interval that contains an extremum.
const SHORTENINGS: u32 = 40;

/// Arguments are evaluated again before they may have gone this part of their way to zero, estimated from
/// their change a step, in either direction, and its change.
const BOLD: f64 = 0.25;

/// Largest number of steps before arguments are evaluated again.
pub(crate) const MOST: f64 = 32.0;

/// An argument that would be zero after this many steps, at its last rate of change, may be zero in the next.
const NEAR: f64 = 1.5;

/// A change of sign of an argument on a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// The number of the argument; the arguments of tables are numbered after those of piecewise expressions.
    pub(crate) switch: usize,
    /// Parts of the path before the place and after it, close together.
    pub(crate) parts: [f64; 2],
}

impl Crossing {
    /// The place within an interval of the path where a positive value becomes negative.
    pub(crate) fn found(
        switch: usize,
        [mut before, mut after]: [f64; 2],
        value: impl Fn(f64) -> f64,
    ) -> Self {
        for _ in 0..HALVINGS {
            if after - before <= SHORT {
                break;
            }
            let middle = 0.5 * (before + after);
            if value(middle) > 0.0 {
                before = middle;
            } else {
                after = middle;
            }
        }
        // far enough from the zero itself, and from the rounding of the argument in the declaration
        let clear = |from: f64, direction: f64| {
            let parts = (0..DOUBLINGS).map(|k| from + direction * SHORT * f64::from(2_u32.pow(k)));
            let found = parts.clone().position(|part| direction * value(part) < 0.0);
            let place = found.map_or(DOUBLINGS as usize, |place| place + MARGIN);
            from + direction * SHORT * 2.0_f64.powi(i32::try_from(place).unwrap_or(0))
        };
        Self {
            switch,
            parts: [clear(before, -1.0), clear(after, 1.0)],
        }
    }
}

/// The arguments on a path.
struct Arguments<'a> {
    declaration: Declaration<'a>,
    path: &'a MotionPath<'a>,
}

impl Arguments<'_> {
    fn all(&self, part: f64) -> Vec<f64> {
        (self.path)(part).arguments(&self.declaration)
    }

    fn one(&self, part: f64, switch: usize) -> f64 {
        self.all(part).get(switch).copied().unwrap_or(f64::NAN)
    }

    /// The change of sign of an argument within an interval of the path, at whose beginning it has the sign
    /// `side`.
    fn crossing(&self, switch: usize, part: [f64; 2], side: f64) -> Crossing {
        Crossing::found(switch, part, |part| side * self.one(part, switch))
    }

    /// The place between two where an argument with the sign `side` has changed it, searched towards its
    /// minimum; `None` if it keeps it.
    fn beyond(&self, switch: usize, [mut from, mut to]: [f64; 2], side: f64) -> Option<f64> {
        let value = |part: f64| side * self.one(part, switch);
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let places = |from: f64, to: f64| [to - golden * (to - from), from + golden * (to - from)];
        let [mut left, mut right] = places(from, to);
        let [mut at_left, mut at_right] = [value(left), value(right)];
        for _ in 0..SHORTENINGS {
            if at_left < 0.0 {
                return Some(left);
            }
            if at_right < 0.0 {
                return Some(right);
            }
            if at_left < at_right {
                (to, right, at_right) = (right, left, at_left);
                left = places(from, to)[0];
                at_left = value(left);
            } else {
                (from, left, at_left) = (left, right, at_right);
                right = places(from, to)[1];
                at_right = value(right);
            }
        }
        None
    }

    /// The changes of sign of the arguments, from their values at some places of the path, from the first to
    /// the last.
    fn changes(
        &self,
        values: &[(f64, Vec<f64>)],
        came: &[f64],
        is_asked: &dyn Fn(usize, f64) -> bool,
    ) -> Vec<Crossing> {
        let mut found = Vec::new();
        let last = values.last().map_or(&[][..], |(_, values)| values);
        let asked = came.iter().enumerate().zip(last);
        for ((switch, came), _) in asked.filter(|((switch, _), last)| is_asked(*switch, **last)) {
            let own = values.iter().map(|(place, values)| (*place, values[switch]));
            let (mut side, mut from) = (*came, 0.0);
            if side * values[0].1[switch] < 0.0 {
                // it changed its sign near the end of the last path, which is another polynomial
                from = BACK
                    .rev()
                    .map(|k| -(0.5_f64.powi(k)))
                    .find(|part| side * self.one(*part, switch) > 0.0)
                    .unwrap_or(0.0);
            }
            let before = found.len();
            for (place, value) in own.clone() {
                if side * value < 0.0 {
                    if from < place {
                        found.push(self.crossing(switch, [from, place], side));
                    }
                    side = -side;
                } else if side == 0.0 && value != 0.0 {
                    side = value.signum();
                }
                if value != 0.0 {
                    from = place;
                }
            }
            if found.len() > before || side == 0.0 {
                continue;
            }
            // two changes of sign: to zero and back
            let at = PLACES.map(|part| {
                own.clone()
                    .find(|(place, _)| place.total_cmp(&part).is_eq())
                    .map_or(f64::NAN, |(_, value)| value)
            });
            let range = jumps::range(at.iter().copied());
            let nearest = extremum(at).map_or(f64::INFINITY, |value| side * value);
            if nearest < NEARLY * (range[1] - range[0])
                && let Some(beyond) = self.beyond(switch, [0.0, 1.0], side)
            {
                found.push(self.crossing(switch, [0.0, beyond], side));
                found.push(self.crossing(switch, [beyond, 1.0], -side));
            }
        }
        found
    }
}

/// The extreme value of the parabola through three equally spaced values, if it lies between the first and
/// the last.
fn extremum(values: [f64; 3]) -> Option<f64> {
    let (place, value, _) = vertex(values);
    (0.0 < place && place < 1.0).then_some(value)
}

/// The vertex of the parabola through three values at the places 0, 1/2 and 1: its place, the value there, and the factor of the square of
/// the distance from it.
fn vertex([first, middle, last]: [f64; 3]) -> (f64, f64, f64) {
    let (slope, bend) = (0.5 * (last - first), first - 2.0 * middle + last);
    let place = -slope / bend;
    (0.5 + 0.5 * place, middle + 0.5 * slope * place, 2.0 * bend)
}

/// The place where an argument that keeps its sign comes much nearer to zero than beside it. Of a place close to the end of one path and the
/// beginning of the next, the first path has it.
fn pit(values: [f64; 3]) -> Option<f64> {
    let side = values[1].signum();
    let (place, value, factor) = vertex(values);
    let ends = values[0].abs().min(values[2].abs());
    let least = DEEP * ends.max(side * (value + factor * BESIDE * BESIDE));
    let keeps = values.iter().all(|value| side * value >= 0.0);
    (keeps && side * value < least && NEXT < place && place < 1.0 + OVERLAP * NEXT).then_some(place)
}

/// A place nearer than this to the change of a side, as a part of the path, is at that change.
const EVENT: f64 = 1.0 / 32.0;

/// The places of a path where a feature may be narrower than the step: an argument that keeps its sign comes
/// much nearer to zero than at both ends, so that the motion nearly meets a pole; or samples lie between the
/// ends; or the argument of a steep function has a zero or an extremum. `is_asked` selects arguments by number and value at the end of the path,
/// since those of resting bodies are zero to rounding, and stops and releases are resolved.
pub(crate) fn narrow_places(
    declaration: &Declaration<'_>,
    path: &MotionPath<'_>,
    is_asked: impl Fn(usize, f64) -> bool,
) -> Vec<f64> {
    let [first, middle, last] = PLACES.map(|part| path(part).arguments(declaration));
    let asked = (0..first.len()).filter(|&g| is_asked(g, last[g]));
    let pits = asked.filter_map(|g| pit([first[g], middle[g], last[g]]));
    // friction may have its peak where its side changes, which is resolved
    let is_at_event = |place: &f64| {
        let [before, after] = [place - EVENT, place + EVENT].map(|part| path(part).arguments(declaration));
        (0..declaration.sides()).any(|g| !is_asked(g, last[g]) && before[g] * after[g] <= 0.0)
    };
    let mut steep = steep::places(declaration, path);
    steep.retain(|place| !is_at_event(place));
    pits.chain(knots::hidden(declaration, path))
        .chain(steep)
        .collect()
}

/// Changes of sign of arguments on the last paths, in the order of time, at parts of the next path: negative.
#[derive(Clone, Debug, Default)]
pub(crate) struct LastChanges(Vec<Crossing>);

/// Length of the time in which changes are remembered, in paths.
const REMEMBERED: f64 = 3.0;

/// The arguments at the end of the last path that was examined.
#[derive(Clone, Debug)]
pub(crate) struct LastArguments {
    /// Their signs, 0 if unknown.
    pub(crate) signs: Vec<f64>,
    /// Their changes before that end.
    pub(crate) changes: LastChanges,
}

impl LastArguments {
    /// Nothing is known of the arguments of a declaration.
    pub(crate) fn unknown(declaration: &Declaration<'_>) -> Self {
        Self {
            signs: vec![0.0; declaration.switches()],
            changes: LastChanges::default(),
        }
    }

    /// Forgets all before another motion.
    pub(crate) fn forget(&mut self) {
        self.signs.fill(0.0);
        self.changes.0.clear();
    }
}

impl LastChanges {
    /// Goes on to the next path, given the changes of sign on this one and its length as a part of the next. Those of tables are not
    /// remembered, since their samples are known, nor those of functions that jump with the velocity, which come to rest.
    pub(crate) fn push(&mut self, declaration: &Declaration<'_>, found: &[Crossing], length: f64) {
        let remembered = declaration.sides()..declaration.switches();
        self.0.extend(
            found
                .iter()
                .filter(|crossing| remembered.contains(&crossing.switch)),
        );
        for Crossing { parts, .. } in &mut self.0 {
            *parts = parts.map(|part| length * (part - 1.0));
        }
        self.0.retain(|crossing| crossing.parts[0] > -REMEMBERED);
    }

    /// The places between two changes of sign of an argument, the second of which is on this path: a force that acts there alone may be too
    /// small beside the changes to show.
    pub(crate) fn between(&self, found: &[Crossing]) -> Vec<f64> {
        let places = found.iter().enumerate().flat_map(|(k, last)| {
            let before = || self.0.iter().chain(&found[..k]).rev();
            let same = before().find(|first| first.switch == last.switch);
            let pairs = [before().next(), same].into_iter().flatten().map(|first| {
                let [from, to] = [first.parts[1], last.parts[0]];
                // the force of a hill is zero in its middle
                [0.25, 0.5, 0.75].map(|part| from + part * (to - from))
            });
            pairs.collect::<Vec<_>>()
        });
        // it may act for longer than changes are remembered
        let begun = (!self.0.is_empty()).then_some([0.0, 0.5]);
        places.flatten().chain(begun.into_iter().flatten()).collect()
    }
}

/// The changes of sign of arguments on a path, and the corners of tables, in the order of time. `came` has
/// the signs at the beginning of the path, 0 if unknown, and receives those at its end. `is_asked` selects
/// arguments by number and value at the end of the path.
///
/// An argument may have a corner where another one changes its sign, as `w - |t - t1|` has, and go to zero
/// and back there. So all arguments are evaluated on both sides of each change of sign, too.
pub(crate) fn crossings(
    declaration: Declaration<'_>,
    path: &MotionPath<'_>,
    came: &mut [f64],
    is_asked: impl Fn(usize, f64) -> bool,
) -> Vec<Crossing> {
    let arguments = Arguments { declaration, path };
    let mut values: Vec<(f64, Vec<f64>)> = PLACES.map(|part| (part, arguments.all(part))).into();
    let mut found = arguments.changes(&values, came, &is_asked);
    if !found.is_empty() {
        let beside = found.iter().flat_map(|crossing| crossing.parts);
        let beside: Vec<f64> = beside.filter(|part| (0.0..1.0).contains(part)).collect();
        values.extend(beside.into_iter().map(|part| (part, arguments.all(part))));
        values.sort_by(|(x, _), (y, _)| x.total_cmp(y));
        found = arguments.changes(&values, came, &is_asked);
    }
    for (switch, came) in came.iter_mut().enumerate() {
        let mut own = values.iter().rev().map(|(_, values)| values[switch]);
        *came = own.find(|value| *value != 0.0).map_or(0.0, f64::signum);
    }
    found.extend(knots::bends(&declaration, path));
    found.sort_by(|x, y| x.parts[0].total_cmp(&y.parts[0]));
    found
}

/// Number of steps until an argument at a `distance` from zero may reach it, from its `change` a step
/// and the change `turn` of that; 0 if it may do so in the next.
pub(crate) fn clear(side: f64, distance: f64, change: f64, turn: f64) -> f64 {
    let (nears, turns) = ((-side * change).max(0.0), turn.abs());
    if distance < NEAR * (nears + turns) {
        return 0.0;
    }
    // as far as `moves k + turns k²/2` is a part of the distance; an argument that moves away may turn and come
    // back as quickly
    let (part, moves) = (BOLD * distance, change.abs());
    let steps = 2.0 * part / (moves + (moves * moves + 2.0 * turns * part).sqrt());
    steps.clamp(1.0, MOST)
}

/// Number of steps after a path until an argument may reach zero; 0 if one may do so in the next.
pub(crate) fn clear_after(declaration: &Declaration<'_>, path: &MotionPath<'_>) -> u64 {
    let [first, middle, last] = PLACES.map(|part| path(part).arguments(declaration));
    let others = [knots::clear(declaration, path), steep::clear(declaration, path)];
    let clears = (0..last.len()).map(|g| {
        let (change, turn) = (last[g] - first[g], 4.0 * (first[g] - 2.0 * middle[g] + last[g]));
        let side = last[g].signum();
        if [first[g], middle[g], last[g]]
            .iter()
            .all(|value| side * value > 0.0)
        {
            clear(side, last[g].abs(), change, turn)
        } else {
            0.0
        }
    });
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and a few hundred"
    )]
    let steps = others.into_iter().chain(clears).fold(MOST, f64::min) as u64;
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_extremum_between_the_places_is_that_of_the_parabola() {
        assert_eq!(extremum([1.0, 0.0, 1.0]), Some(0.0));
        // (x - 1/2)² - 1/4
        assert_eq!(extremum([2.0, 0.0, 0.0]), Some(-0.25));
        assert_eq!(extremum([1.0, 2.0, 3.0]), None);
    }

    #[test]
    fn what_comes_to_zero_soon_is_looked_at() {
        assert_eq!(clear(1.0, 1.0, -1.0, 0.0), 0.0);
        assert_eq!(clear(1.0, 20.0, -1.0, 0.0), 5.0);
        assert_eq!(clear(1.0, 20.0, 1.0, 0.0), 5.0);
        assert_eq!(clear(1.0, 1.0, 0.0, 0.0), MOST);
    }
}
