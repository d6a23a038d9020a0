//! Sticking: steps and starts in which a function that jumps with the velocity has a value between its two sides.
//!
//! On a leg such a function has one side, that of its argument in the middle of the leg, where the mass goes on evenly: `u(t + h/2, q + d/2, d/h)`. A
//! mass *rests* on a leg if this argument is zero. A step is then the inclusion of [`crate::regularity::sides`] for the next leg (J. J. Moreau's time-stepping, 1988;
//! Acary and Brogliato 2008, chapter 10), with these rules for the leg before it:
//!
//! - Where the mass has rested so far, or comes to rest, the first leg has no side of its own. It takes that of the next leg. So the force is that which
//!   the equations of motion need, and a mass stays where it is as long as that is within the friction.
//! - Where the argument changes its sign, the first leg keeps its side, as in every step without a jump. A mass does not come to rest for one step if it is
//!   torn away at the next.
//!
//! As `h` goes to zero this is the solution of Filippov. A stop that holds costs no order: the last leg is shorter than `h²` times the acceleration. A
//! turn without a stop has a side on one leg that is the other one's on a part of it, and the order is 1 there.
//!
//! A kinematic constraint has its signs at nodes, where the velocity is the mean of those of both legs. With this velocity zero the mass would go to and
//! fro between two nodes for ever. By the rules above it is at rest when the next leg is.

use crate::number::bounded::Bounded;
use crate::number::point::{AnyLeg, AnyPoint, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::sides::{self, Linear, Piece, Sided};
use crate::solve::dense::Matrix;
use crate::tape::declaration::Declaration;

/// How large a second difference is at least, relative to the leg.
const LEAST: f64 = 1e-5;

/// An argument of so many bounds of its rounding error is zero.
const ROUNDINGS: f64 = 4.0;

/// Two rows are the same if they differ by less than this part of what the sides change.
const SAME: f64 = 1e-9;

/// The sides of a step.
#[derive(Clone, Debug)]
pub(crate) struct Sticking {
    /// Those on the first leg.
    pub(crate) first: Vec<f64>,
    /// Those on the second leg and at the node.
    pub(crate) second: Vec<f64>,
    /// Which arguments are zero on the second leg.
    pub(crate) rests: Vec<bool>,
    /// Which of them were not on the first.
    arrives: bool,
    /// Whether an argument changes its sign.
    crosses: bool,
}

impl Sticking {
    /// What rests on a leg, of which nothing else is known.
    pub(crate) fn resting(rests: Vec<bool>) -> Self {
        let none = vec![0.0; rests.len()];
        Self {
            first: none.clone(),
            second: none,
            rests,
            arrives: false,
            crosses: false,
        }
    }

    /// Whether anything rests on the second leg.
    pub(crate) fn rests(&self) -> bool {
        self.rests.contains(&true)
    }

    /// Whether everything that rests has rested before, and nothing else switches.
    pub(crate) fn is_steady(&self) -> bool {
        !self.arrives && !self.crosses
    }
}

/// A step with sides.
pub(crate) struct Solution {
    /// The second difference.
    pub(crate) e: Vec<f64>,
    /// The multipliers.
    pub(crate) multipliers: Vec<f64>,
    /// The sides.
    pub(crate) sticking: Sticking,
    /// How often the rows were evaluated.
    pub(crate) evaluations: u32,
}

/// A step whose arguments may be zero.
#[derive(Clone, Copy)]
pub(crate) struct Contact<'a> {
    /// The declaration.
    pub(crate) declaration: Declaration<'a>,
    /// The step.
    pub(crate) h: f64,
    /// The first two nodes.
    pub(crate) leg: AnyLeg<'a, f64>,
    /// Which arguments are zero on the first leg.
    pub(crate) rests: &'a [bool],
}

/// The pieces of the arguments of a leg that ends with `q`.
fn pieces_of_leg(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Vec<Piece> {
    let q: Vec<f64> = leg.q.iter().zip(leg.d).map(|(q, d)| q - 0.5 * d).collect();
    let v = map(leg.d, |d| d / h);
    let arguments = declaration.side_arguments(leg.t - 0.5 * h, &q, &v);
    arguments.into_iter().map(Piece::of).collect()
}

/// Which arguments are zero, to rounding, at a position and a velocity.
fn zero(declaration: &Declaration<'_>, t: f64, q: &[f64], v: &[f64]) -> Vec<bool> {
    let arguments = declaration.side_arguments(
        Bounded::splat(t),
        &map(q, Bounded::splat),
        &map(v, Bounded::splat),
    );
    let is_zero = |argument: Bounded| argument.lane(0).abs() <= ROUNDINGS * argument.error();
    arguments.into_iter().map(is_zero).collect()
}

/// Which arguments are zero on a leg, to rounding.
pub(crate) fn rests_on(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Vec<bool> {
    let q: Vec<f64> = leg.q.iter().zip(leg.d).map(|(q, d)| q - 0.5 * d).collect();
    zero(declaration, leg.t - 0.5 * h, &q, &map(leg.d, |d| d / h))
}

impl Contact<'_> {
    /// Whether an argument changes its sign, or is zero, on one of the two legs.
    pub(crate) fn may_rest(&self, e: &[f64]) -> bool {
        let first = pieces_of_leg(&self.declaration, self.h, self.leg);
        let second = self.next(e);
        let second = pieces_of_leg(&self.declaration, self.h, second.any());
        first
            .iter()
            .zip(&second)
            .any(|(first, second)| first != second || *first == Piece::Between)
    }

    /// The leg after this one.
    fn next(&self, e: &[f64]) -> crate::number::point::OwnedLeg<f64> {
        let d: Vec<f64> = self.leg.d.iter().zip(e).map(|(d, e)| d + e).collect();
        crate::number::point::OwnedLeg {
            t: self.leg.t + self.h,
            q: self.leg.q.iter().zip(&d).map(|(q, d)| q + d).collect(),
            d,
        }
    }

    /// Solves the step from a guess of its second difference and its multipliers.
    #[cold]
    pub(crate) fn solve(&self, e: &[f64], multipliers: &[f64]) -> Option<Solution> {
        self.settle(e, multipliers, true)
    }

    /// The same. With `lasting`, nothing comes to rest that does not stay at rest at the next step.
    fn settle(&self, e: &[f64], multipliers: &[f64], lasting: bool) -> Option<Solution> {
        let own = pieces_of_leg(&self.declaration, self.h, self.leg);
        let rested = |g: usize| self.rests.get(g).copied().unwrap_or(false) || own[g] == Piece::Between;
        let pieces: Vec<Piece> = (0..own.len())
            .map(|g| if rested(g) { Piece::Between } else { own[g] })
            .collect();
        let guess = Sided::guess(e.iter().chain(multipliers).copied().collect(), pieces);
        let n = e.len();
        let least: Vec<f64> = (0..guess.x.len())
            .map(|i| if i < n { LEAST * self.leg.d[i].abs() } else { 0.0 })
            .collect();
        // the sides of the first leg that it keeps
        let mut kept: Vec<Option<f64>> = vec![None; own.len()];
        let mut found = sides::solve(
            &|x, sides| self.linearize(x, sides, &kept),
            &guess,
            &least,
            self.h.signum(),
        )?;
        let arrives = |found: &Sided, g: usize| found.still[g] && !rested(g);
        let crosses = |found: &Sided, g: usize| !rested(g) && !found.still[g] && found.pieces[g] != own[g];
        let mut torn = vec![false; own.len()];
        if lasting && (0..own.len()).any(|g| arrives(&found, g)) {
            let next = self.next(&found.x[..n]);
            let contact = Contact {
                leg: next.any(),
                rests: &found.still,
                ..*self
            };
            let rest = vec![0.0; n];
            if let Some(after) = contact.settle(&rest, &found.x[n..], false) {
                torn = (0..own.len())
                    .map(|g| arrives(&found, g) && !after.sticking.rests[g])
                    .collect();
            }
        }
        if (0..own.len()).any(|g| torn[g] || crosses(&found, g)) {
            for g in 0..own.len() {
                if torn[g] || crosses(&found, g) {
                    kept[g] = Some(own[g].side());
                }
            }
            let evaluations = found.evaluations;
            found = sides::solve(
                &|x, sides| self.linearize(x, sides, &kept),
                &found,
                &least,
                self.h.signum(),
            )?;
            found.evaluations += evaluations;
        }
        let first = (0..own.len())
            .map(|g| kept[g].unwrap_or(found.sides[g]))
            .collect();
        let sticking = Sticking {
            first,
            rests: found.still.clone(),
            arrives: (0..own.len()).any(|g| arrives(&found, g)),
            crosses: (0..own.len()).any(|g| crosses(&found, g)),
            second: found.sides,
        };
        let multipliers = found.x.split_off(n);
        Some(Solution {
            e: found.x,
            multipliers,
            sticking,
            evaluations: found.evaluations,
        })
    }

    /// Whether a solution without rest solves the declared rows, whose signs need not be those of the middle of a leg.
    pub(crate) fn is_declared(&self, solution: &Solution) -> bool {
        let Solution {
            e,
            multipliers,
            sticking: Sticking { first, second, .. },
            ..
        } = solution;
        let sided = |sides: [&[f64]; 2]| self.declaration.sided(self.h, self.leg, e, multipliers, sides);
        let turned = [first, second].map(|sides| map(sides, |side| -side));
        let rows = self.declaration.declared(self.h, self.leg, e, multipliers);
        let (own, other) = (sided([first, second]), sided([&turned[0], &turned[1]]));
        let mut rows = rows.iter().zip(&own).zip(&other);
        rows.all(|((row, own), other)| (row - own).abs() <= SAME * (own - other).abs())
    }

    /// The rows and the arguments, with sides of the first leg that it keeps.
    fn linearize(&self, x: &[f64], sides: &[f64], kept: &[Option<f64>]) -> Linear {
        let (n, h) = (self.leg.q.len(), Tangent::splat(self.h));
        let leg = self.leg.map(Tangent::splat);
        let rows = |x: &[Tangent], sides: &[Tangent]| {
            let first: Vec<Tangent> = sides
                .iter()
                .zip(kept)
                .map(|(side, kept)| kept.map_or(*side, Tangent::splat))
                .collect();
            let (e, multipliers) = x.split_at(n);
            self.declaration
                .sided(h, leg.any(), e, multipliers, [&first, sides])
        };
        let half = Tangent::splat(0.5);
        let arguments = |e: &[Tangent]| {
            let d: Vec<Tangent> = leg.d.iter().zip(e).map(|(d, e)| *d + *e).collect();
            let q: Vec<Tangent> = leg.q.iter().zip(&d).map(|(q, d)| *q + half * *d).collect();
            let v = map(&d, |d| d / h);
            self.declaration.side_arguments(leg.t + half * h, &q, &v)
        };
        let fixed = map(sides, Tangent::splat);
        let by_unknowns: Vec<_> = (0..x.len()).map(|j| rows(&moved(x, j), &fixed)).collect();
        let plain = map(x, Tangent::splat);
        let by_sides: Vec<_> = (0..sides.len()).map(|g| rows(&plain, &moved(sides, g))).collect();
        let slopes: Vec<_> = (0..n).map(|j| arguments(&moved(&x[..n], j))).collect();
        Linear {
            rows: values(&by_unknowns),
            by_unknowns: derivatives(&by_unknowns, x.len(), x.len()),
            by_sides: derivatives(&by_sides, x.len(), sides.len()),
            arguments: values(&slopes),
            slopes: derivatives(&slopes, sides.len(), x.len()),
        }
    }
}

/// The values of what was differentiated, column by column.
fn values(columns: &[Vec<Tangent>]) -> Vec<f64> {
    columns
        .first()
        .map_or_else(Vec::new, |column| column.iter().map(|x| x.value()).collect())
}

/// The derivatives; columns that are missing are zero.
fn derivatives(columns: &[Vec<Tangent>], rows: usize, count: usize) -> Matrix {
    Matrix::from_fn(rows, count, |i, j| {
        columns
            .get(j)
            .and_then(|column| column.get(i))
            .map_or(0.0, |x| x.derivative())
    })
}

/// The acceleration, the multipliers and the sides of the continuous system at a point where an argument is zero; `None` elsewhere, and where there is
/// none. An argument stays zero as long as a side between its bounds makes it do so.
#[cold]
pub(crate) fn of_motion(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    multipliers: usize,
    near: Option<&[f64]>,
) -> Option<Sided> {
    let zero = zero(declaration, t, q, v);
    if !zero.contains(&true) {
        return None;
    }
    let n = q.len();
    // the arguments as they change: what does not depend on the acceleration, and the slopes by it
    let fixed_q: Vec<Tangent> = q.iter().zip(v).map(|(q, v)| Tangent::new(*q, *v)).collect();
    let drift = declaration.side_arguments(Tangent::new(t, 1.0), &fixed_q, &map(v, Tangent::splat));
    let still_q = map(q, Tangent::splat);
    let slopes: Vec<_> = (0..n)
        .map(|j| declaration.side_arguments(Tangent::splat(t), &still_q, &moved(v, j)))
        .collect();
    let slope = |g: usize, j: usize| {
        if zero[g] && j < n {
            slopes[j][g].derivative()
        } else {
            0.0
        }
    };
    let (still_v, time) = (map(v, Tangent::splat), Tangent::splat(t));
    let linearize = |x: &[f64], sides: &[f64]| {
        let rows = |x: &[Tangent], sides: &[Tangent]| {
            let (a, multipliers) = x.split_at(n);
            let point = AnyPoint {
                t: time,
                q: &still_q,
                v: &still_v,
                a,
            };
            declaration.sided_continuous(point, multipliers, sides)
        };
        let (fixed, plain) = (map(sides, Tangent::splat), map(x, Tangent::splat));
        let by_unknowns: Vec<_> = (0..x.len()).map(|j| rows(&moved(x, j), &fixed)).collect();
        let by_sides: Vec<_> = (0..sides.len()).map(|g| rows(&plain, &moved(sides, g))).collect();
        Linear {
            rows: values(&by_unknowns),
            by_unknowns: derivatives(&by_unknowns, x.len(), x.len()),
            by_sides: derivatives(&by_sides, x.len(), sides.len()),
            arguments: (0..sides.len())
                .map(|g| {
                    if zero[g] {
                        let terms = (0..n).map(|j| slope(g, j) * x[j]);
                        drift[g].derivative() + terms.sum::<f64>()
                    } else {
                        drift[g].value()
                    }
                })
                .collect(),
            slopes: Matrix::from_fn(sides.len(), x.len(), slope),
        }
    };
    let pieces: Vec<Piece> = (0..zero.len())
        .map(|g| {
            if zero[g] {
                Piece::Between
            } else {
                Piece::of(drift[g].value())
            }
        })
        .collect();
    let x = (0..n + multipliers).map(|i| near.and_then(|near| near.get(i)).copied().unwrap_or(0.0));
    let guess = Sided::guess(x.collect(), pieces);
    sides::solve(&linearize, &guess, &vec![0.0; n + multipliers], 1.0)
}
