//! Functions that jump with the velocity, such as dry friction: their values at the jump.
//!
//! `signum(u)` is not defined at `u = 0`. The law of dry friction is: there the force may have any value
//! between the two sides, and it has the one that keeps the mass at rest, as long as there is one. So
//! `signum(u)` stands for a set: its sign where `u` is not zero, and all of `[-1, 1]` where it is (A. F.
//! Filippov, *Differential Equations with Discontinuous Righthand Sides*, 1988; J. J. Moreau, *Unilateral
//! Contact and Dry Friction in Finite Freedom Dynamics*, 1988). For rows `R(x, s) = 0` in unknowns `x` and
//! *sides* `s`, and arguments `u(x)`, the problem is
//! ```text
//! R(x, s) = 0,   s_g = 1 if u_g > 0,   s_g = -1 if u_g < 0,   s_g in [-1, 1] if u_g = 0.
//! ```
//!
//! Newton's iteration linearises both in `x` and `s` and solves the linear problem for the next iterate (N.
//! H. Josephy, 1979). After elimination of `x` it is a linear complementarity problem with bounds,
//! `u(s) = a - B s`. Friction dissipates energy, so `B` has a positive semidefinite symmetric part. It is
//! solved by pivots of many sides at once, and of single ones if those do not terminate (J. J. Júdice, F. M.
//! Pires, *Computers Oper. Res.* 21, 1994). If `B` is singular, as with friction in all four joints of a
//! four-bar linkage, the sides at rest are not determined one by one, but their sum of forces is: then the
//! sides nearest to the last ones are taken (the proximal point method). See also V. Acary, B. Brogliato,
//! *Numerical Methods for Nonsmooth Dynamical Systems*, 2008.

use crate::solve::dense::Matrix;

/// Largest number of Newton iterations.
const MAX_ITERATIONS: u32 = 40;

/// An update of this part of the unknowns is the last: a body at rest has to be at rest to the last digit,
/// without creeping by rounding.
const LAST: f64 = f64::EPSILON * f64::EPSILON;

/// Updates below this part that no longer shrink are rounding.
const ROUNDING: f64 = 1e-9;

/// Weight of the proximal term for the sides that are solved for, relative to their effect on their own
/// argument.
const HELD: f64 = 1e-4;

/// Number of proximal iterations.
const RELEASES: u32 = 12;

/// Accuracy of an unknown that is zero, relative to the others.
const FAINT: f64 = 1e-10;

/// An argument below this part of the sides' largest effect on it is zero.
const STILL: f64 = 1e-10;

/// Number of pivots of all wrong sides at once that may fail to reduce their number.
const PATIENCE: u32 = 8;

/// Largest number of pivots; the search has always been much shorter.
const MAX_PIVOTS: u32 = 1_000;

/// Arguments beyond zero by this part count as zero.
const BEYOND: f64 = 1e-13;

/// Sides may exceed their bounds by this much: if frictions depend on each other, they are accurate to no
/// more digits, while arguments are zero to all.
const LOOSE: f64 = 1e-7;

/// The piece of a side.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Piece {
    /// The argument is negative.
    Minus,
    /// The argument is zero.
    Between,
    /// The argument is positive.
    Plus,
}

impl Piece {
    /// The piece of an argument.
    pub(crate) fn of(argument: f64) -> Self {
        if argument > 0.0 {
            Self::Plus
        } else if argument < 0.0 {
            Self::Minus
        } else {
            Self::Between
        }
    }

    /// The side of the piece; 0 in between.
    pub(crate) fn side(self) -> f64 {
        match self {
            Self::Minus => -1.0,
            Self::Between => 0.0,
            Self::Plus => 1.0,
        }
    }
}

/// Whether each argument rests.
pub(crate) fn resting(pieces: &[Piece]) -> Vec<bool> {
    pieces.iter().map(|piece| *piece == Piece::Between).collect()
}

/// Rows and arguments at a point, with their derivatives.
pub(crate) struct Linear {
    /// The rows, as many as unknowns.
    pub(crate) rows: Vec<f64>,
    /// Their derivatives by the unknowns.
    pub(crate) by_unknowns: Matrix,
    /// Their derivatives by the sides.
    pub(crate) by_sides: Matrix,
    /// The arguments.
    pub(crate) arguments: Vec<f64>,
    /// Their derivatives by the unknowns.
    pub(crate) slopes: Matrix,
}

impl Linear {
    /// The sum of the absolute terms of each row, for any sides.
    pub(crate) fn terms(&self, x: &[f64]) -> Vec<f64> {
        let of_row = |i: usize| {
            let own = self.by_unknowns.row(i).zip(x).map(|(entry, x)| (entry * x).abs());
            own.chain(self.by_sides.row(i).map(f64::abs)).sum()
        };
        (0..x.len()).map(of_row).collect()
    }
}

/// The size of an unknown that the terms of the rows could produce: rounding of a zero multiplier is relative
/// to it.
pub(crate) fn reach(inverse: &Matrix, terms: &[f64], unknown: usize) -> f64 {
    inverse
        .row(unknown)
        .zip(terms)
        .map(|(entry, terms)| entry.abs() * terms)
        .sum()
}

/// A solution, or a guess of one.
#[derive(Clone, Debug)]
pub(crate) struct Sided {
    /// The unknowns.
    pub(crate) x: Vec<f64>,
    /// The sides.
    pub(crate) sides: Vec<f64>,
    /// The piece of each side.
    pub(crate) pieces: Vec<Piece>,
    /// The arguments that are zero; their sides may still be at a bound.
    pub(crate) still: Vec<bool>,
    /// Number of evaluations of the rows.
    pub(crate) evaluations: u32,
}

impl Sided {
    /// A guess.
    pub(crate) fn guess(x: Vec<f64>, pieces: Vec<Piece>) -> Self {
        Self {
            x,
            sides: pieces.iter().map(|piece| piece.side()).collect(),
            still: resting(&pieces),
            pieces,
            evaluations: 0,
        }
    }
}

/// Solves an inclusion from a guess; `None` if no solution is found. `least` is the least size of each
/// unknown.
///
/// Sides drive their arguments back to zero, `B_gg ≥ 0`; backward in time, with `direction` -1, away from it.
/// Where they do the opposite, as with a force along the velocity, the motion does not stay at rest.
///
/// If no solution is found from a guess with arguments at zero, all of them are tried at either bound: an argument that all values of its
/// side drive the same way leaves zero that way.
#[cold]
pub(crate) fn solve(
    linearize: &dyn Fn(&[f64], &[f64]) -> Linear,
    guess: &Sided,
    least: &[f64],
    direction: f64,
) -> Option<Sided> {
    solve_from(linearize, guess, least, direction).or_else(|| {
        let may_leave = direction > 0.0 && guess.pieces.contains(&Piece::Between);
        let bounds = [Piece::Minus, Piece::Plus].into_iter().filter(|_| may_leave);
        let mut found = bounds.filter_map(|bound| {
            let piece = |piece: &Piece| if *piece == Piece::Between { bound } else { *piece };
            let pieces = guess.pieces.iter().map(piece).collect();
            solve_from(
                linearize,
                &Sided::guess(guess.x.clone(), pieces),
                least,
                direction,
            )
        });
        found.next()
    })
}

/// [`solve`] from one guess.
fn solve_from(
    linearize: &dyn Fn(&[f64], &[f64]) -> Linear,
    guess: &Sided,
    least: &[f64],
    direction: f64,
) -> Option<Sided> {
    let mut now = guess.clone();
    let mut last = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let (pieces, sides) = (now.pieces.clone(), now.sides.clone());
        let largest = update(linearize, &mut now, least, direction)?;
        let same = now.pieces == pieces;
        if same
            && (largest <= LAST || largest <= ROUNDING && largest >= 0.5 * last)
            && is_solved(linearize, &mut now, &sides)
        {
            return Some(now);
        }
        last = largest;
    }
    None
}

/// Whether the rows vanish with the sides of the last update, if these have changed. With a body at rest an error of the sides does not show
/// in the unknowns, and the rows need not be linear in the sides.
fn is_solved(linearize: &dyn Fn(&[f64], &[f64]) -> Linear, now: &mut Sided, before: &[f64]) -> bool {
    let mut sides = now.sides.iter().zip(before);
    if sides.all(|(side, before)| (side - before).abs() <= ROUNDING) {
        return true;
    }
    now.evaluations += 1;
    let at = linearize(&now.x, &now.sides);
    let terms = at.terms(&now.x);
    let mut rows = at.rows.iter().zip(terms);
    rows.all(|(row, terms)| row.abs() <= ROUNDING * terms)
}

/// One iteration of [`solve`]. Returns the largest update, relative to its unknown.
pub(super) fn update(
    linearize: &dyn Fn(&[f64], &[f64]) -> Linear,
    now: &mut Sided,
    least: &[f64],
    direction: f64,
) -> Option<f64> {
    now.evaluations += 1;
    let at = linearize(&now.x, &now.sides);
    let count = now.x.len();
    let terms = at.terms(&now.x);
    let inverse = inverse(at.by_unknowns)?;
    let newton = inverse.times_vector(&at.rows);
    let by_sides = inverse.times(&at.by_sides);
    let b = at.slopes.times(&by_sides);
    let moved = at.slopes.times_vector(&newton);
    let a: Vec<f64> = at
        .arguments
        .iter()
        .zip(&moved)
        .map(|(u, moved)| u - moved)
        .collect();
    let repels = |pieces: &[Piece]| {
        (0..pieces.len()).any(|g| pieces[g] == Piece::Between && b[(g, g)] * direction < 0.0)
    };
    if repels(&now.pieces) {
        return None;
    }
    let changes = complement(&a, &b, now)?;
    if repels(&now.pieces) {
        return None;
    }
    let by_change = by_sides.times_vector(&changes);
    let sizes: Vec<f64> = (0..count)
        .map(|i| reach(&inverse, &terms, i).max(now.x[i].abs()).max(least[i]))
        .collect();
    let faint = FAINT * sizes.iter().fold(0.0_f64, |most, size| most.max(*size));
    let mut largest = 0.0_f64;
    for i in 0..count {
        let update = newton[i] + by_change[i];
        now.x[i] -= update;
        if update != 0.0 {
            largest = largest.max(update.abs() / sizes[i].max(faint));
        }
    }
    let left = b.times_vector(&changes);
    now.still = (0..a.len())
        .map(|g| {
            let reach = b.row(g).map(f64::abs).sum::<f64>();
            now.pieces[g] == Piece::Between || (a[g] - left[g]).abs() <= STILL * reach
        })
        .collect();
    (!largest.is_nan()).then_some(largest)
}

/// The inverse of a matrix whose rows may have different units; `None` if it is singular.
pub(super) fn inverse(mut matrix: Matrix) -> Option<Matrix> {
    let lengths = matrix.normalize_columns();
    let mut inverse = matrix.inverse();
    for (i, length) in lengths.iter().enumerate() {
        inverse.divide_row(i, *length);
    }
    inverse.is_finite().then_some(inverse)
}

/// Solves the complementarity problem `u(s + δ) = a - B δ` for the change `δ` of the sides, from given pieces
/// and sides. Changes become small: so arguments vanish to the digits of the change, not of the sides.
fn complement(a: &[f64], b: &Matrix, now: &mut Sided) -> Option<Vec<f64>> {
    let sides = a.len();
    let largest = |g: usize| b.row(g).fold(0.0_f64, |most, x| most.max(x.abs()));
    // a side without effect on any argument must not become a divisor
    let hold: Vec<f64> = (0..sides)
        .map(|g| {
            let own = b[(g, g)].abs().max(1e-3 * largest(g)).max(a[g].abs() * HELD);
            HELD * own.max(f64::MIN_POSITIVE / HELD)
        })
        .collect();
    let held = Matrix::from_fn(sides, sides, |g, k| {
        b[(g, k)] + if g == k { hold[g] } else { 0.0 }
    });
    let mut changes = vec![0.0; sides];
    for release in 0..RELEASES {
        let from: Vec<f64> = (0..sides).map(|g| a[g] + hold[g] * changes[g]).collect();
        let mut pieces = now.pieces.clone();
        let Some(found) = pivot(&from, &held, &now.sides, &mut pieces) else {
            // dependent sides can be at their bounds in several ways, and rounding decides
            if release == 0 {
                return None;
            }
            break;
        };
        now.pieces = pieces;
        let pairs = found.iter().zip(&changes);
        let moved = pairs.fold(0.0_f64, |most, (found, change)| most.max((found - change).abs()));
        changes = found;
        let largest = changes
            .iter()
            .fold(0.0_f64, |most, change| most.max(change.abs()));
        if moved <= f64::EPSILON * largest {
            break;
        }
    }
    for (side, change) in now.sides.iter_mut().zip(&changes) {
        *side += change;
    }
    Some(changes)
}

/// [`complement`] without a proximal term; `pieces` receives those of the solution.
fn pivot(a: &[f64], b: &Matrix, from: &[f64], pieces: &mut [Piece]) -> Option<Vec<f64>> {
    let sides = a.len();
    let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
    for _ in 0..MAX_PIVOTS {
        let between: Vec<usize> = (0..sides).filter(|&g| pieces[g] == Piece::Between).collect();
        let mut changes: Vec<f64> = (0..sides)
            .map(|g| match pieces[g] {
                Piece::Between => 0.0,
                piece => piece.side() - from[g],
            })
            .collect();
        if !between.is_empty() {
            let left = |g: usize| a[g] - b.row(g).zip(&changes).map(|(b, s)| b * s).sum::<f64>();
            let right: Vec<f64> = between.iter().map(|&g| left(g)).collect();
            let own = Matrix::from_fn(between.len(), between.len(), |i, j| b[(between[i], between[j])]);
            let solved = inverse(own)?.times_vector(&right);
            for (&g, value) in between.iter().zip(solved) {
                changes[g] = value;
            }
        }
        let wrong: Vec<(usize, Piece)> = (0..sides)
            .filter_map(|g| {
                let terms = b.row(g).zip(&changes).map(|(b, change)| b * change);
                let argument = a[g] - terms.sum::<f64>();
                let terms = b.row(g).zip(&changes).zip(from);
                let size = terms.fold(a[g].abs(), |size, ((b, change), from)| {
                    size + (b * change).abs() + (b * from).abs()
                });
                let to = match pieces[g] {
                    Piece::Between if from[g] + changes[g] > 1.0 + LOOSE => Piece::Plus,
                    Piece::Between if from[g] + changes[g] < -1.0 - LOOSE => Piece::Minus,
                    Piece::Plus if argument < -BEYOND * size => Piece::Between,
                    Piece::Minus if argument > BEYOND * size => Piece::Between,
                    _ => return None,
                };
                Some((g, to))
            })
            .collect();
        if wrong.is_empty() {
            return Some(changes);
        }
        if wrong.len() < fewest {
            (fewest, patience) = (wrong.len(), PATIENCE);
        } else {
            patience = patience.saturating_sub(1);
        }
        let changed = if patience > 0 { wrong.len() } else { 1 };
        for &(g, to) in &wrong[..changed] {
            pieces[g] = to;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `u(s) = a - B s` with `B = G Gᵀ D`, as friction has it, with as many independent directions as `rank`.
    fn friction(a: &[f64], directions: &[f64], limits: &[f64], rank: usize) -> Matrix {
        let count = a.len();
        let entry = |g: usize, k: usize| directions[g * 4 + k];
        Matrix::from_fn(count, count, |g, j| {
            let product: f64 = (0..rank).map(|k| entry(g, k) * entry(j, k)).sum();
            product * limits[j]
        })
    }

    /// Solves the inclusion, and checks the solution against the definition.
    fn is_solved(a: &[f64], b: &Matrix) -> bool {
        let mut now = Sided::guess(Vec::new(), vec![Piece::Between; a.len()]);
        let mut left = a.to_vec();
        // repeated, as in Newton's iteration
        for _ in 0..MAX_ITERATIONS {
            let Some(changes) = complement(&left, b, &mut now) else {
                return false;
            };
            let taken = b.times_vector(&changes);
            left = left
                .iter()
                .zip(&taken)
                .map(|(left, taken)| left - taken)
                .collect();
        }
        let size = a.iter().fold(1e-3_f64, |most, a| most.max(a.abs()));
        (0..a.len()).all(|g| {
            let (argument, side) = (left[g], now.sides[g]);
            let is_zero = argument.abs() <= 1e-12 * size;
            side.abs() <= 1.0 + LOOSE && (is_zero || side == argument.signum())
        })
    }

    #[test]
    fn frictions_solve_their_inclusion() {
        let mut state = 1_u64;
        let mut random = |from: f64, to: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            from + (to - from) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for round in 0..800 {
            let (count, rank) = (1 + round % 7, 1 + round / 7 % 4);
            let directions: Vec<f64> = (0..28).map(|_| random(-1.0, 1.0)).collect();
            let limits: Vec<f64> = (0..count).map(|_| random(0.05, 2.0)).collect();
            // arguments that belong to a velocity: with fewer directions than frictions they are dependent
            let velocity: Vec<f64> = (0..rank).map(|_| random(-2.0, 2.0)).collect();
            let a: Vec<f64> = (0..count)
                .map(|g| (0..rank).map(|k| directions[g * 4 + k] * velocity[k]).sum())
                .collect();
            let b = friction(&a, &directions, &limits, rank);
            assert!(is_solved(&a, &b), "{round}: {a:?} {b:?}");
        }
    }

    #[test]
    fn what_is_beyond_the_friction_is_at_its_bound() {
        let b = Matrix::from_fn(2, 2, |i, j| if i == j { 0.5 } else { 0.0 });
        let mut now = Sided::guess(Vec::new(), vec![Piece::Between; 2]);
        complement(&[0.2, -3.0], &b, &mut now).unwrap();
        assert!(
            (now.sides[0] - 0.4).abs() < 1e-15 && now.sides[1] == -1.0,
            "{now:?}"
        );
        assert_eq!(now.pieces, [Piece::Between, Piece::Minus]);
    }
}
