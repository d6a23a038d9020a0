//! The places on the way of a step at which a declaration changes its piece.
//!
//! The declaration tells the arguments of all that is given by pieces, and what it divides by. Where one of them changes its sign on a way, the place is found
//! to rounding. What jumps there is told by [`crossing`](super::crossing).

use super::{jumps, knots};
use crate::start::place::Way;
use crate::tape::declaration::Declaration;

/// At these parts of a way arguments are looked at.
const PLACES: [f64; 3] = [0.0, 0.5, 1.0];

/// So often a bracket is halved.
const HALVINGS: u32 = 48;

/// A bracket is left when it is as short as this part of the way: what is smooth is the same at both of its ends.
const SHORT: f64 = 1e-12;

/// From a bracket it is gone farther so often, twice as far each time, until the argument has its sign to all digits that it has; and then so much farther.
const DOUBLINGS: u32 = 20;
const MARGIN: usize = 3;

/// Where an argument has changed between two ways, these powers of a half are gone back, from the last to the first.
const BACK: core::ops::RangeInclusive<i32> = 1..=27;

/// Where a parabola through three values of an argument comes nearer to zero than this part of its range, its extremum is looked for.
const NEARLY: f64 = 0.1;

/// An argument nearly meets zero where its extremum on a way is this part of its values at the ends.
const DEEP: f64 = 0.75;

/// So often the part of a way in which an extremum lies is made shorter.
const SHORTENINGS: u32 = 40;

/// Arguments are looked at again before they may have gone this part of their way to zero, by how they change, in either direction, and how that changes.
const BOLD: f64 = 0.25;

/// So many steps are made at most before arguments are looked at again.
pub(crate) const MOST: f64 = 32.0;

/// Where an argument would be zero after so many steps, as it has changed in the last one, it may be zero in the next.
const NEAR: f64 = 1.5;

/// The number of no argument.
pub(crate) const NONE: usize = usize::MAX;

/// Where an argument changes its sign on a way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Which argument; [`NONE`] where it is none of these.
    pub(crate) switch: usize,
    /// Parts of the way before the place and after it, close together.
    pub(crate) parts: [f64; 2],
}

impl Crossing {
    /// The place within a part of a way where a value that is positive becomes negative.
    pub(super) fn found(
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
        // clear of the zero itself, and of the rounding with which the declaration has the argument
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

/// The arguments on a way.
struct Arguments<'a> {
    declaration: Declaration<'a>,
    way: &'a Way<'a>,
}

impl Arguments<'_> {
    fn all(&self, part: f64) -> Vec<f64> {
        (self.way)(part).arguments(&self.declaration)
    }

    fn one(&self, part: f64, switch: usize) -> f64 {
        self.all(part).get(switch).copied().unwrap_or(f64::NAN)
    }

    /// Where an argument changes its sign within a part of the way, at whose beginning it has a side.
    fn crossing(&self, switch: usize, part: [f64; 2], side: f64) -> Crossing {
        Crossing::found(switch, part, |part| side * self.one(part, switch))
    }

    /// The place between two where an argument comes nearest to zero, if it goes beyond.
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

    /// Where arguments change their signs, by their values at some places of the way, from the first to the last.
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
                // it has changed about where the way before this one ended, as another polynomial tells
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
            // to zero and back
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

/// The value at the extremum of the parabola through three equally spaced values, if it lies between the first and the last.
fn extremum(values: [f64; 3]) -> Option<f64> {
    Some(extremum_at(values)?.1)
}

/// Its place, from -1 to 1, and the value there.
fn extremum_at([first, middle, last]: [f64; 3]) -> Option<(f64, f64)> {
    let (slope, bend) = (0.5 * (last - first), first - 2.0 * middle + last);
    let place = -slope / bend;
    (place.abs() < 1.0).then_some((place, middle + 0.5 * slope * place))
}

/// The parts of a way where something may be narrower than a step: an argument that keeps its sign comes much nearer to zero than at both ends, so that a motion
/// nearly meets a pole, or samples lie between the ends. Whether an argument is asked for is told by its number and its value at the end of the way: what rests
/// is zero to rounding.
pub(crate) fn narrow_places(
    declaration: &Declaration<'_>,
    way: &Way<'_>,
    is_asked: impl Fn(usize, f64) -> bool,
) -> Vec<f64> {
    let [first, middle, last] = PLACES.map(|part| way(part).arguments(declaration));
    let asked = (0..first.len()).filter(|&g| is_asked(g, last[g]));
    let pits = asked.filter_map(|g| {
        let values = [first[g], middle[g], last[g]];
        let side = values[0].signum();
        let (place, value) = extremum_at(values)?;
        let least = DEEP * values[0].abs().min(values[2].abs());
        let keeps = values.iter().all(|value| side * value > 0.0);
        (keeps && side * value < least).then_some(0.5 + 0.5 * place)
    });
    pits.chain(knots::hidden(declaration, way)).collect()
}

/// Where arguments change their signs on a way, or tables of samples bend, in the order of time. `came` are the signs with which the motion came to its beginning, 0 if that is not
/// known; those with which it leaves it are put in their place. Whether one is asked for is told by its number and its value at the end of the way.
///
/// An argument may have a corner where another one changes its sign, as `w - |t - t1|` has, and go to zero and back there. So arguments are looked at on both
/// sides of each such place, too.
pub(crate) fn crossings(
    declaration: Declaration<'_>,
    way: &Way<'_>,
    came: &mut [f64],
    is_asked: impl Fn(usize, f64) -> bool,
) -> Vec<Crossing> {
    let arguments = Arguments { declaration, way };
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
    found.extend(knots::bends(&declaration, way));
    found.sort_by(|x, y| x.parts[0].total_cmp(&y.parts[0]));
    found
}

/// In how many steps an argument on a side may come to zero, as it changes from step to step and as that changes; 0 if it may do so in the next.
pub(crate) fn clear(side: f64, way: f64, change: f64, turn: f64) -> f64 {
    let (nears, turns) = ((-side * change).max(0.0), turn.abs());
    if way < NEAR * (nears + turns) {
        return 0.0;
    }
    // as far as `moves k + turns k²/2` is a part of the way; what goes away and turns only later may come back as quickly
    let (part, moves) = (BOLD * way, change.abs());
    let steps = 2.0 * part / (moves + (moves * moves + 2.0 * turns * part).sqrt());
    steps.clamp(1.0, MOST)
}

/// In how many steps an argument may come to zero after a way; 0 if one may do so in the next.
pub(crate) fn clear_after(declaration: &Declaration<'_>, way: &Way<'_>) -> u64 {
    let [first, middle, last] = PLACES.map(|part| way(part).arguments(declaration));
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
    let steps = clears.fold(knots::clear(declaration, way), f64::min) as u64;
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
