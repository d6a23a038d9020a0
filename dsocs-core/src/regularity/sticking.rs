//! Sticking: steps and starts in which a function that jumps with the velocity has a value between its two sides.
//!
//! # One side for each leg
//!
//! On a leg such a function has one *side*, regardless of the number of places at which the step evaluates it
//! there: the sign of its argument in the middle of the leg, where the mass moves uniformly,
//! `u(t + h/2, q + d/2, d/h)`. A leg on which this argument is zero *rests*; its side is an unknown.
//!
//! Forces usually act at both ends of a leg, with the leg's one velocity. If the surface moves, the arguments
//! of the two ends differ by `h` times its acceleration, and on a leg that rests they have opposite signs. If
//! each place chose its own sign, friction would cancel there, and on the first slow legs after a release: an
//! error of `h` times the friction's impulse. No choice of unknowns at the single places mends this, since
//! one velocity cannot equal the surface's at two times. With one side for the leg the sum over its places is
//! the friction's impulse, to second order.
//!
//! # A step is a motion from the middle of one leg to that of the next
//!
//! The equation of a node balances the momenta of two legs, so it determines the change of velocity from the
//! middle of one leg to the middle of the next. In this span, velocities and arguments change linearly, to
//! second order. The sides in it are determined as follows:
//!
//! - If no argument changes its sign, the sides are those of the first leg, and the step is the declared one.
//! - An argument that was zero stays so as long as a side in `[-1, 1]` achieves it; else its side is at the bound, and the
//!   mass slips. This is the inclusion of [`crate::regularity::sides`] for the next leg (J. J. Moreau's time-stepping,
//!   1988; Acary and Brogliato 2008, chapter 10).
//! - If an argument arrives at zero after a part of the span, its side is the old one up to there. For the rest of the span
//!   the same inclusion decides whether it stays at zero, passes or turns back, and whether another resting argument is
//!   released by that. The force over the span is that of the mean side.
//! - If an argument only changes its sign, on a surface that does not move, the declared rows have a root with one sign on
//!   each leg. It is taken, since nodes are to obey the declared rows where they can. It is of first order there.
//!
//! As `h` goes to zero this is the solution of Filippov. Neither a stop nor a release lowers the order, nor a
//! change of sign on a surface that moves: each happens in one span, where the impulses are accurate to the
//! square of `h`.
//!
//! A kinematic constraint evaluates its signs at nodes, where the velocity is the mean of those of both legs.
//! With this velocity zero the mass would oscillate between two nodes for ever. By the rules above it is at
//! rest when the next leg is.

use crate::number::bounded::{Bounded, UNIT};
use crate::number::point::{AnyLeg, OwnedLeg, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::sides::{self, Linear, Piece, Sided};
use crate::solve::dense::Matrix;
use crate::solve::rotation;
use crate::step::switches;
use crate::tape::declaration::Declaration;

/// The least size of a second difference, relative to the leg.
const LEAST: f64 = 1e-5;

/// An argument within this many bounds of its rounding error is zero.
const ROUNDINGS: f64 = 4.0;

/// Two rows are equal if they differ by less than this part of the sides' effect.
const SAME: f64 = 1e-9;

/// An argument that arrives at zero in this last part of a span counts as arriving at the beginning of the
/// next: the rest is too short to determine a side.
const LATE: f64 = 1e-6;

/// The part of a step at which its middle node lies.
const MIDDLE: f64 = 0.5;

/// Largest number of arrivals at zero in one step, for each argument.
const ARRIVALS: usize = 4;

/// A step with sides.
pub(crate) struct Solution {
    /// The second difference.
    pub(crate) e: Vec<f64>,
    /// The multipliers.
    pub(crate) multipliers: Vec<f64>,
    /// The sides, as means over the step.
    pub(crate) sides: Vec<f64>,
    /// If inputs change at the middle node, the part of these means from before it.
    pub(crate) before: Vec<f64>,
    /// The pieces of the arguments on the second leg; those between rest.
    pub(crate) pieces: Vec<Piece>,
    /// Whether an argument that was not zero is zero now, or has changed its sign.
    pub(crate) switches: bool,
    /// Number of evaluations of the rows.
    pub(crate) evaluations: u32,
}

impl Solution {
    /// Whether an argument rests on the second leg.
    pub(crate) fn rests(&self) -> bool {
        self.pieces.contains(&Piece::Between)
    }
}

/// A step whose arguments are or may become zero.
#[derive(Clone, Copy)]
pub(crate) struct Contact<'a> {
    /// The declaration.
    pub(crate) declaration: Declaration<'a>,
    /// The declaration up to the middle node, if inputs change there.
    pub(crate) before: Option<Declaration<'a>>,
    /// The length of the step.
    pub(crate) h: f64,
    /// The first two nodes.
    pub(crate) leg: AnyLeg<'a, f64>,
    /// The pieces of the arguments on the first leg; those between rest.
    pub(crate) pieces: &'a [Piece],
}

/// The events that are possible in a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Outlook {
    /// An argument rests, or is near a change of its sign, in the middle of a leg or at one of the places of
    /// the step.
    Sided,
    /// Another argument of a piecewise function may change its sign.
    Switches,
    /// No change of sign within this number of steps.
    Clear(u64),
}

/// The arguments in the middle of a leg.
pub(crate) fn in_the_middle(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    at_part(declaration, h, leg, 0.5)
}

/// The arguments at a place of a leg, with the velocity of the leg; `part` is 0 at its end, 1 at its
/// beginning.
fn at_part(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, part: f64) -> Vec<f64> {
    let q = rotation::moved(&declaration.shape().rotations, leg.q, &map(leg.d, |d| -part * d));
    let v = map(leg.d, |d| d / h);
    declaration.side_arguments(leg.t - part * h, &q, &v)
}

/// The pieces of the arguments on a leg; those that are zero to rounding are between.
pub(crate) fn pieces_of_leg(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Vec<Piece> {
    let q = rotation::moved(&declaration.shape().rotations, leg.q, &map(leg.d, |d| -0.5 * d));
    let rests = zero(declaration, leg.t - 0.5 * h, &q, &map(leg.d, |d| d / h));
    let arguments = in_the_middle(declaration, h, leg).into_iter().zip(rests);
    arguments
        .map(|(argument, rests)| {
            if rests {
                Piece::Between
            } else {
                Piece::of(argument)
            }
        })
        .collect()
}

/// Whether each argument is zero at a position and a velocity, to [its rounding](roundings).
pub(crate) fn zero(declaration: &Declaration<'_>, t: f64, q: &[f64], v: &[f64]) -> Vec<bool> {
    let arguments = roundings(declaration, t, q, v).into_iter();
    arguments
        .map(|[argument, error]| argument.abs() <= error)
        .collect()
}

/// The arguments, each with the error below which it may be zero: by its rounding and by that of time, position and velocity themselves. Decimal
/// numbers of a start are rounded, and so is the velocity of a leg.
pub(crate) fn roundings(declaration: &Declaration<'_>, t: f64, q: &[f64], v: &[f64]) -> Vec<[f64; 2]> {
    let rounded = |x: f64| Bounded::known(x, UNIT * x.abs());
    let arguments = declaration.side_arguments(rounded(t), &map(q, rounded), &map(v, rounded));
    let with_error = |argument: Bounded| [argument.lane(0), ROUNDINGS * argument.error()];
    arguments.into_iter().map(with_error).collect()
}

/// Whether an argument is zero, to rounding, at a position and a velocity.
pub(crate) fn rests_at(declaration: &Declaration<'_>, t: f64, q: &[f64], v: &[f64]) -> bool {
    zero(declaration, t, q, v).contains(&true)
}

/// The rest of a step from an arrival on.
struct Span<'a> {
    /// The sides so far, each times its part of the step: up to the middle node if inputs change there, and
    /// from there on.
    kept: &'a [Vec<f64>; 2],
    /// The part of the step that has passed.
    done: f64,
    /// Whether each argument is zero when it begins, so that its side is unknown.
    free: &'a [bool],
}

impl<'a> Contact<'a> {
    /// The possible events of the step, if its second difference is about `e`, and changes by about `bend`
    /// from step to step.
    #[cold]
    pub(crate) fn outlook(&self, e: &[f64], bend: &[f64]) -> Outlook {
        if self.pieces.contains(&Piece::Between) {
            return Outlook::Sided;
        }
        let next = self.next(e);
        let after: Vec<f64> = e.iter().zip(bend).map(|(e, bend)| e + bend).collect();
        let after = Contact {
            leg: next.any(),
            ..*self
        }
        .next(&after);
        let [first, second, third] =
            [self.leg, next.any(), after.any()].map(|leg| in_the_middle(&self.declaration, self.h, leg));
        let end = at_part(&self.declaration, self.h, self.leg, 0.0);
        let mut clear = f64::INFINITY;
        for (g, piece) in self.pieces.iter().enumerate() {
            let side = piece.side();
            // false also for a NaN
            if ![first[g], second[g], end[g]]
                .iter()
                .all(|argument| side * argument > 0.0)
            {
                return Outlook::Sided;
            }
            let way = first[g].abs() - 2.0 * (end[g] - first[g]).abs();
            let (change, turn) = (
                second[g] - first[g],
                (third[g] - second[g]) - (second[g] - first[g]),
            );
            let steps = switches::clear(side, way, change, turn);
            if steps == 0.0 {
                return Outlook::Sided;
            }
            clear = clear.min(steps);
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and a few hundred"
        )]
        let clear = clear as u64;
        Outlook::Clear(clear)
    }

    /// Whether a solution of the declared rows keeps the sides of the first leg, at all places where they are
    /// evaluated.
    pub(crate) fn keeps(&self, e: &[f64], multipliers: &[f64]) -> bool {
        let second = in_the_middle(&self.declaration, self.h, self.next(e).any());
        let mut pieces = self.pieces.iter().zip(&second);
        pieces.all(|(piece, argument)| piece.side() * argument > 0.0)
            && self.is_declared(e, multipliers, &map(self.pieces, Piece::side))
    }

    /// The leg after this one.
    pub(crate) fn next(&self, e: &[f64]) -> OwnedLeg<f64> {
        let d: Vec<f64> = self.leg.d.iter().zip(e).map(|(d, e)| d + e).collect();
        OwnedLeg {
            t: self.leg.t + self.h,
            q: rotation::moved(&self.declaration.shape().rotations, self.leg.q, &d),
            d,
        }
    }

    /// Whether a solution only changes signs, without rest, on surfaces that do not move. Then the declared
    /// rows may have their own root, with the old sign at all places of one leg and the new one at those of
    /// the other.
    pub(crate) fn only_crosses(&self, solution: &Solution) -> bool {
        if !solution.switches || solution.rests() || self.pieces.contains(&Piece::Between) {
            return false;
        }
        let next = self.next(&solution.e);
        let [first, second] = [self.leg, next.any()].map(|leg| {
            let middle = in_the_middle(&self.declaration, self.h, leg);
            (middle, at_part(&self.declaration, self.h, leg, 0.0))
        });
        (0..self.pieces.len()).all(|g| {
            let size = first.0[g].abs() + second.0[g].abs();
            [&first, &second]
                .iter()
                .all(|(middle, end)| (end[g] - middle[g]).abs() <= SAME * size)
        })
    }

    /// Solves the step from a guess of its second difference and its multipliers.
    #[cold]
    pub(crate) fn solve(&self, e: &[f64], multipliers: &[f64]) -> Option<Solution> {
        let (n, count) = (e.len(), self.pieces.len());
        let least: Vec<f64> = (0..n + multipliers.len())
            .map(|i| if i < n { LEAST * self.leg.d[i].abs() } else { 0.0 })
            .collect();
        let mut pieces = self.pieces.to_vec();
        let mut arguments = in_the_middle(self.declaration_after(0.0), self.h, self.leg);
        let mut free: Vec<bool> = (0..count)
            .map(|g| pieces[g].side() * arguments[g] <= 0.0)
            .collect();
        let (mut kept, mut done) = ([vec![0.0; count], vec![0.0; count]], 0.0);
        let mut evaluations = 0;
        let mut x: Vec<f64> = e.iter().chain(multipliers).copied().collect();
        let changes = usize::from(self.before.is_some());
        for left in (0..=ARRIVALS * count + changes).rev() {
            let begin = |g: usize| if free[g] { Piece::Between } else { pieces[g] };
            let guess = Sided::guess(x, (0..count).map(begin).collect());
            let span = Span {
                kept: &kept,
                done,
                free: &free,
            };
            let linearize = |x: &[f64], sides: &[f64]| self.linearize(x, sides, &span);
            let found = sides::solve(&linearize, &guess, &least, self.h.signum());
            // beyond an arrival the rows may have no root with the former side, as with a friction that grows
            // towards rest; one update gives the arrival to the same order
            let is_known = found.is_some();
            let found = if let Some(found) = found {
                found
            } else {
                let mut now = guess;
                sides::update(&linearize, &mut now, &least, self.h.signum())?;
                now
            };
            evaluations += found.evaluations;
            let leg = self.next(&found.x[..n]);
            let next = in_the_middle(self.declaration_after(done), self.h, leg.any());
            // an argument that has left zero goes on to one side
            for g in (0..count).filter(|&g| free[g]) {
                pieces[g] = if found.still[g] {
                    Piece::Between
                } else {
                    found.pieces[g]
                };
            }
            let arrives = |g: usize| {
                let is_beyond = !free[g] && pieces[g].side() * next[g] < 0.0;
                is_beyond.then(|| arguments[g] / (arguments[g] - next[g]))
            };
            let until = if self.is_before(done) {
                (MIDDLE - done) / (1.0 - done)
            } else {
                1.0
            };
            let first = (0..count).filter_map(arrives).fold(until, f64::min);
            // exactly at the middle node, not before it by rounding
            let place = if first >= until && until < 1.0 {
                MIDDLE
            } else {
                done + first * (1.0 - done)
            };
            if place >= 1.0 - LATE || left == 0 {
                if !is_known {
                    return None;
                }
                x = found.x;
                let multipliers = x.split_off(n);
                let switches =
                    (0..count).any(|g| self.pieces[g] != Piece::Between && pieces[g] != self.pieces[g]);
                let [before, after] = kept;
                return Some(Solution {
                    sides: (0..count)
                        .map(|g| before[g] + after[g] + (1.0 - done) * found.sides[g])
                        .collect(),
                    before,
                    e: x,
                    multipliers,
                    pieces,
                    switches,
                    evaluations,
                });
            }
            let arrived: Vec<bool> = (0..count)
                .map(|g| arrives(g).is_some_and(|part| part <= first))
                .collect();
            let part = usize::from(!self.is_before(done));
            for g in 0..count {
                kept[part][g] += (place - done) * found.sides[g];
                arguments[g] += first * (next[g] - arguments[g]);
                free[g] = arrived[g] || pieces[g] == Piece::Between;
            }
            if self.is_before(done) && !self.is_before(place) {
                for (g, argument) in self.moved(leg.any()) {
                    (arguments[g], pieces[g], free[g]) = (argument, Piece::of(argument), argument == 0.0);
                }
            }
            (done, x) = (place, found.x);
        }
        None
    }

    /// The arguments that an input changes at the middle node, with their values there. Arguments without
    /// this input agree to the last bit.
    fn moved(&self, next: AnyLeg<'_, f64>) -> Vec<(usize, f64)> {
        let of = |declaration: &Declaration<'_>| {
            [self.leg, next].map(|leg| in_the_middle(declaration, self.h, leg))
        };
        let [old, new] = [self.declaration_after(0.0), &self.declaration].map(of);
        let same = |g: usize| (0..2).all(|end| old[end][g].to_bits() == new[end][g].to_bits());
        let moved = (0..self.pieces.len()).filter(|&g| !same(g));
        moved.map(|g| (g, 0.5 * (new[0][g] + new[1][g]))).collect()
    }

    /// The declaration at a part of the step.
    fn declaration_after(&self, done: f64) -> &Declaration<'a> {
        match &self.before {
            Some(before) if done < MIDDLE => before,
            _ => &self.declaration,
        }
    }

    /// Whether an input change lies ahead at a part of the step.
    fn is_before(&self, done: f64) -> bool {
        self.before.is_some() && done < MIDDLE
    }

    /// The constraint force of a solution.
    pub(crate) fn force(&self, solution: &Solution) -> Vec<f64> {
        let (h, leg, e) = (self.h, self.leg, &solution.e);
        let Some(before) = &self.before else {
            return self.declaration.sided_force(h, leg, e, &solution.sides);
        };
        // each declaration holds on one half
        let old = before.sided_force(h, leg, e, &map(&solution.before, |side| side / MIDDLE));
        let sides = solution.sides.iter().zip(&solution.before);
        let sides: Vec<f64> = sides.map(|(side, before)| (side - before) / MIDDLE).collect();
        let new = self.declaration.sided_force(h, leg, e, &sides);
        old.iter().zip(&new).map(|(old, new)| 0.5 * (old + new)).collect()
    }

    /// Whether a solution with sides also solves the declared rows, in which every place has its own sign.
    pub(crate) fn is_declared(&self, e: &[f64], multipliers: &[f64], sides: &[f64]) -> bool {
        let sided = |sides: &[f64]| self.declaration.sided(self.h, self.leg, e, multipliers, sides);
        let rows = self.declaration.declared(self.h, self.leg, e, multipliers);
        let (own, other) = (sided(sides), sided(&map(sides, |side| -side)));
        let mut rows = rows.iter().zip(&own).zip(&other);
        rows.all(|((row, own), other)| (row - own).abs() <= SAME * (own - other).abs())
    }

    /// The rows and the arguments in the rest of the step.
    fn linearize(&self, x: &[f64], sides: &[f64], span: &Span<'_>) -> Linear {
        let (n, h) = (self.leg.q.len(), Tangent::splat(self.h));
        let leg = self.leg.map(Tangent::splat);
        let left = Tangent::splat(1.0 - span.done);
        let rows = |x: &[Tangent], sides: &[Tangent]| {
            let [before, after] = span.kept;
            let (e, multipliers) = x.split_at(n);
            let sided = |declaration: &Declaration<'_>, kept: &[f64], sides: &[Tangent], part: f64| {
                let mean = sides.iter().zip(kept).map(|(side, kept)| {
                    (Tangent::splat(*kept) + left * *side) * Tangent::splat(part.recip())
                });
                let mean: Vec<Tangent> = mean.collect();
                declaration.sided(h, leg.any(), e, multipliers, &mean)
            };
            match &self.before {
                None => sided(&self.declaration, after, sides, 1.0),
                // up to the middle, the motion is as if no input changed
                Some(old) if span.done < MIDDLE => sided(old, before, sides, 1.0),
                Some(old) => {
                    let none = map(sides, |_| Tangent::splat(0.0));
                    let old = sided(old, before, &none, MIDDLE);
                    let new = sided(&self.declaration, after, sides, MIDDLE);
                    let half = Tangent::splat(0.5);
                    old.into_iter()
                        .zip(new)
                        .map(|(old, new)| half * (old + new))
                        .collect()
                }
            }
        };
        let half = Tangent::splat(0.5);
        let arguments = |e: &[Tangent]| {
            let d: Vec<Tangent> = leg.d.iter().zip(e).map(|(d, e)| *d + *e).collect();
            let way = map(&d, |d| half * d);
            let q = rotation::moved(&self.declaration.shape().rotations, &leg.q, &way);
            let v = map(&d, |d| d / h);
            self.declaration_after(span.done)
                .side_arguments(leg.t + half * h, &q, &v)
        };
        let fixed = map(sides, Tangent::splat);
        let by_unknowns: Vec<_> = (0..x.len()).map(|j| rows(&moved(x, j), &fixed)).collect();
        let plain = map(x, Tangent::splat);
        let by_sides: Vec<_> = (0..sides.len()).map(|g| rows(&plain, &moved(sides, g))).collect();
        let slopes: Vec<_> = (0..n).map(|j| arguments(&moved(&x[..n], j))).collect();
        // a known side counts as if its argument stayed there
        let own = values(&slopes);
        let slopes = derivatives(&slopes, sides.len(), x.len());
        let arguments = (0..sides.len()).map(|g| if span.free[g] { own[g] } else { sides[g] });
        Linear {
            rows: values(&by_unknowns),
            by_unknowns: derivatives(&by_unknowns, x.len(), x.len()),
            by_sides: derivatives(&by_sides, x.len(), sides.len()),
            arguments: arguments.collect(),
            slopes: Matrix::from_fn(sides.len(), x.len(), |g, j| {
                if span.free[g] { slopes[(g, j)] } else { 0.0 }
            }),
        }
    }
}

/// The values of differentiated columns.
pub(super) fn values(columns: &[Vec<Tangent>]) -> Vec<f64> {
    columns
        .first()
        .map_or_else(Vec::new, |column| column.iter().map(|x| x.value()).collect())
}

/// The derivatives of columns; missing columns are zero.
pub(super) fn derivatives(columns: &[Vec<Tangent>], rows: usize, count: usize) -> Matrix {
    Matrix::from_fn(rows, count, |i, j| {
        columns
            .get(j)
            .and_then(|column| column.get(i))
            .map_or(0.0, |x| x.derivative())
    })
}
