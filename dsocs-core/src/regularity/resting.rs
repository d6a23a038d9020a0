//! The continuous motion with bodies at rest on surfaces: the values of functions that jump with the velocity
//! there.
//!
//! An argument `g(t, q, v)` that is zero stays so as long as a side in `[-1, 1]` makes its rate zero,
//! `dg/dt + ∂g/∂v · a = 0`. This is the inclusion of [`crate::regularity::sides`] for the rates of the
//! arguments that are zero. As long as the same arguments stay zero, accelerations, multipliers and sides
//! solve equations that are as smooth as the declared ones.

use crate::number::bounded::{Bounded, UNIT};
use crate::number::larger;
use crate::number::point::{AnyPoint, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::sides::{self, Linear, Piece, Sided};
use crate::regularity::sticking::{derivatives, values, zero};
use crate::solve::dense::Matrix;
use crate::solve::rotation;
use crate::tape::declaration::Declaration;

/// Largest number of Newton iterations with a known set of resting arguments.
const MAX_ITERATIONS: u32 = 20;

/// An update below this part of the unknowns is the last: the remaining error is its square.
const LAST: f64 = 1e-9;

/// Equations for sides with singular values below this depend on each other.
const DEPENDENT: f64 = 1e-9;

/// A change of velocity below this part of its terms is rounding.
pub(super) const FAINT: f64 = 1e-9;

/// A point at which arguments may be zero.
pub(crate) struct AtPoint<'a> {
    declaration: Declaration<'a>,
    t: f64,
    pub(super) q: &'a [f64],
    v: &'a [f64],
    /// The arguments, with their rates at zero acceleration.
    pub(super) drift: Vec<Tangent>,
    /// Their derivatives by the components of the velocity.
    slopes: Vec<Vec<Tangent>>,
}

/// The motion at a point with a known set of resting arguments.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    /// Accelerations, then multipliers.
    pub(crate) x: Vec<f64>,
    /// The sides; that of a resting argument exceeds its bounds once it no longer rests.
    pub(crate) sides: Vec<f64>,
    /// The contribution of the sides to each unknown, as a sum of absolute values.
    pub(crate) reach: Vec<f64>,
    /// The correction of the velocity after which the resting arguments vanish exactly.
    pub(crate) correction: Vec<f64>,
    /// Whether an argument on which no side has an effect does not stay zero.
    pub(crate) leaves: bool,
}

impl Held {
    /// A guess with the given acceleration, zero multipliers and zero sides.
    pub(crate) fn guess(a: &[f64], multipliers: usize, sides: usize) -> Self {
        let mut x = a.to_vec();
        x.resize(a.len() + multipliers, 0.0);
        Self {
            reach: vec![0.0; x.len()],
            correction: vec![0.0; a.len()],
            leaves: false,
            sides: vec![0.0; sides],
            x,
        }
    }
}

impl<'a> AtPoint<'a> {
    /// A point.
    pub(crate) fn new(declaration: Declaration<'a>, (t, q, v): (f64, &'a [f64], &'a [f64])) -> Self {
        let rates = rotation::rate(&declaration.shape().rotations, q, v);
        let moving = q.iter().zip(&rates);
        let moving: Vec<Tangent> = moving.map(|(q, rate)| Tangent::new(*q, *rate)).collect();
        let drift = declaration.side_arguments(Tangent::new(t, 1.0), &moving, &map(v, Tangent::splat));
        let still = map(q, Tangent::splat);
        let slopes = (0..q.len())
            .map(|j| declaration.side_arguments(Tangent::splat(t), &still, &moved(v, j)))
            .collect();
        Self {
            declaration,
            t,
            q,
            v,
            drift,
            slopes,
        }
    }

    /// The derivative of an argument by a component of the velocity.
    pub(super) fn slope(&self, g: usize, j: usize) -> f64 {
        self.slopes
            .get(j)
            .and_then(|column| column.get(g))
            .map_or(0.0, |slope| slope.derivative())
    }

    /// The arguments.
    pub(crate) fn arguments(&self) -> Vec<f64> {
        self.drift.iter().map(|argument| argument.value()).collect()
    }

    /// The rate of an argument for a given acceleration.
    pub(crate) fn rate(&self, g: usize, a: &[f64]) -> f64 {
        let drift = self.drift.get(g).map_or(0.0, |argument| argument.derivative());
        let terms = a.iter().enumerate().map(|(j, a)| self.slope(g, j) * a);
        drift + terms.sum::<f64>()
    }

    /// Whether an argument does not stay zero with a given acceleration.
    fn leaves(&self, g: usize, a: &[f64]) -> bool {
        let drift = self.drift.get(g).map_or(0.0, |argument| argument.derivative());
        let terms = a.iter().enumerate().map(|(j, a)| (self.slope(g, j) * a).abs());
        self.rate(g, a).abs() > FAINT * terms.fold(drift.abs(), f64::max)
    }

    /// Rows and arguments; for arguments that are zero, their rates.
    pub(super) fn linearize(&self, x: &[f64], sides: &[f64], zero: &[bool]) -> Linear {
        let n = self.q.len();
        let (time, q, v) = (
            Tangent::splat(self.t),
            map(self.q, Tangent::splat),
            map(self.v, Tangent::splat),
        );
        let rows = |x: &[Tangent], sides: &[Tangent]| {
            let (a, multipliers) = x.split_at(n);
            let point = AnyPoint {
                t: time,
                q: &q,
                v: &v,
                a,
            };
            self.declaration.sided_continuous(point, multipliers, sides)
        };
        let (fixed, plain) = (map(sides, Tangent::splat), map(x, Tangent::splat));
        let by_unknowns: Vec<_> = (0..x.len()).map(|j| rows(&moved(x, j), &fixed)).collect();
        let by_sides: Vec<_> = (0..sides.len()).map(|g| rows(&plain, &moved(sides, g))).collect();
        let a = x.get(..n).unwrap_or(&[]);
        Linear {
            rows: values(&by_unknowns),
            by_unknowns: derivatives(&by_unknowns, x.len(), x.len()),
            by_sides: derivatives(&by_sides, x.len(), sides.len()),
            arguments: (0..sides.len())
                .map(|g| {
                    if zero[g] {
                        self.rate(g, a)
                    } else {
                        self.drift[g].value()
                    }
                })
                .collect(),
            slopes: Matrix::from_fn(sides.len(), x.len(), |g, j| {
                if zero[g] && j < n { self.slope(g, j) } else { 0.0 }
            }),
        }
    }

    /// The largest rate of each argument for a given acceleration and any sides. Two arguments that are
    /// multiples of each other vanish together; with rounding one may be beyond zero and the other not yet,
    /// so this tells whether both rest.
    pub(crate) fn fastest(&self, a: &[f64], multipliers: usize) -> Vec<f64> {
        let sides = self.drift.len();
        let (none, all) = (vec![0.0; sides], vec![true; sides]);
        // a friction may be proportional to a constraint force
        let x = self.unknowns(&none, &all, multipliers).unwrap_or_else(|| {
            let mut x = a.to_vec();
            x.resize(a.len() + multipliers, 0.0);
            x
        });
        let at = self.linearize(&x, &none, &all);
        let by_sides =
            sides::inverse(at.by_unknowns).map(|inverse| at.slopes.times(&inverse.times(&at.by_sides)));
        let reach = |g: usize| {
            by_sides
                .as_ref()
                .map_or(0.0, |by_sides| by_sides.row(g).map(f64::abs).sum::<f64>())
        };
        (0..sides)
            .map(|g| larger(self.rate(g, a).abs(), reach(g)))
            .collect()
    }

    /// The accelerations and multipliers for given sides.
    pub(crate) fn unknowns(&self, sides: &[f64], zero: &[bool], multipliers: usize) -> Option<Vec<f64>> {
        let mut x = vec![0.0; self.q.len() + multipliers];
        for _ in 0..MAX_ITERATIONS {
            let at = self.linearize(&x, sides, zero);
            let terms = at.terms(&x);
            let inverse = sides::inverse(at.by_unknowns)?;
            let newton = inverse.times_vector(&at.rows);
            let mut is_last = true;
            for (i, (x, newton)) in x.iter_mut().zip(&newton).enumerate() {
                *x -= newton;
                is_last &= newton.abs() <= LAST * sides::reach(&inverse, &terms, i).max(x.abs());
            }
            if is_last {
                return Some(x);
            }
        }
        None
    }

    /// The sizes of the arguments' terms.
    pub(super) fn sizes(&self) -> Vec<f64> {
        let (q, v) = (map(self.q, Bounded::splat), map(self.v, Bounded::splat));
        let arguments = self.declaration.side_arguments(Bounded::splat(self.t), &q, &v);
        arguments
            .into_iter()
            .map(|argument| argument.error() / UNIT)
            .collect()
    }

    /// Solves the inclusion with some arguments zero, from unknowns near `near`.
    #[cold]
    pub(crate) fn solve(&self, zero: &[bool], multipliers: usize, near: Option<&[f64]>) -> Option<Sided> {
        let count = self.q.len() + multipliers;
        let pieces = zero.iter().zip(&self.drift).map(|(zero, argument)| {
            if *zero {
                Piece::Between
            } else {
                Piece::of(argument.value())
            }
        });
        let x = (0..count).map(|i| near.and_then(|near| near.get(i)).copied().unwrap_or(0.0));
        let guess = Sided::guess(x.collect(), pieces.collect());
        let linearize = |x: &[f64], sides: &[f64]| self.linearize(x, sides, zero);
        sides::solve(&linearize, &guess, &vec![0.0; count], 1.0)
    }

    /// The motion in which the arguments between two pieces rest and the others keep their sides, from a
    /// guess; `None` if the sides of the resting ones are not determined. Where a friction has no normal force its side has no effect, and
    /// stays as it is.
    pub(crate) fn held(&self, pieces: &[Piece], guess: &Held) -> Option<Held> {
        let all: Vec<usize> = (0..pieces.len())
            .filter(|&g| pieces[g] == Piece::Between)
            .collect();
        let zero = sides::resting(pieces);
        let mut now = guess.clone();
        for (side, piece) in now.sides.iter_mut().zip(pieces) {
            if *piece != Piece::Between {
                *side = piece.side();
            }
        }
        for _ in 0..MAX_ITERATIONS {
            let at = self.linearize(&now.x, &now.sides, &zero);
            let terms = at.terms(&now.x);
            let inverse = sides::inverse(at.by_unknowns)?;
            let newton = inverse.times_vector(&at.rows);
            let by_sides = inverse.times(&at.by_sides);
            let by_rests = at.slopes.times(&by_sides);
            let moved = at.slopes.times_vector(&newton);
            let has_effect = |g: usize| {
                all.iter()
                    .any(|&k| by_rests[(g, k)] != 0.0 || by_rests[(k, g)] != 0.0)
            };
            let (rests, free): (Vec<usize>, Vec<usize>) = all.iter().partition(|&&g| has_effect(g));
            let own = Matrix::from_fn(rests.len(), rests.len(), |i, j| by_rests[(rests[i], rests[j])]);
            let right: Vec<f64> = rests.iter().map(|&g| at.arguments[g] - moved[g]).collect();
            let changes = shortest(own.clone(), right)?;
            let along = |changes: &[f64], i: usize| -> f64 {
                let terms = rests.iter().zip(changes);
                terms.map(|(&g, change)| by_sides[(i, g)] * change).sum()
            };
            now.reach = (0..now.x.len())
                .map(|i| by_sides.row(i).map(f64::abs).sum())
                .collect();
            let mut is_last = true;
            for (i, x) in now.x.iter_mut().enumerate() {
                let update = newton[i] + along(&changes, i);
                *x -= update;
                is_last &= update.abs() <= LAST * sides::reach(&inverse, &terms, i).max(x.abs());
                if !x.is_finite() {
                    return None;
                }
            }
            for (&g, change) in rests.iter().zip(&changes) {
                now.sides[g] += change;
            }
            if is_last {
                now.leaves = free.iter().any(|&g| self.leaves(g, &now.x[..self.q.len()]));
                let arguments: Vec<f64> = rests.iter().map(|&g| self.drift[g].value()).collect();
                let by = shortest(own, arguments)?;
                now.correction = (0..self.q.len()).map(|i| -along(&by, i)).collect();
                return Some(now);
            }
        }
        None
    }
}

/// The shortest solution of the equations for sides. More frictions may act than there are directions of
/// motion: then only their sum is determined, and each side is changed as little as possible.
fn shortest(own: Matrix, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let (decomposed, lengths) = own.equilibrated(&mut right)?;
    let solution = decomposed.solve(&right, DEPENDENT);
    let scaled = solution.iter().zip(lengths);
    Some(
        scaled
            .map(|(x, length)| if *x == 0.0 { 0.0 } else { x / length })
            .collect(),
    )
}

/// The constraint force at a point with a body at rest; `None` elsewhere.
#[cold]
pub(crate) fn force(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) -> Option<Vec<f64>> {
    let multipliers = declaration.shape().multipliers();
    let found = of_motion(declaration, (point.t, point.q, point.v), multipliers, None)?;
    Some(declaration.sided_continuous_force(point, &found.sides))
}

/// The acceleration, the multipliers and the sides of the continuous system at a point where an argument is
/// zero to rounding; `None` elsewhere, or if there is no solution.
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
    AtPoint::new(*declaration, (t, q, v)).solve(&zero, multipliers, near)
}
