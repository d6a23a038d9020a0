//! Rules for the end of an iteration.
//!
//! The rules stand here once, for every iteration of this crate: that of one trajectory ([`super::newton`]), that of
//! several in lanes ([`crate::ensemble`]) and that for the accelerations of a Taylor series ([`crate::taylor`]).
//!
//! An update is small or large relative to the unknown, or relative to the unknown's expected *size* where
//! that is larger. There is no absolute tolerance. The smallest meaningful size follows from the rounding
//! error of the rows: see [`NaturalSizes`].
//!
//! With quadratic convergence the updates obey `ρ' = C ρ²`. So two consecutive updates bound the error that
//! is left, without an evaluation to confirm it.

use crate::number::largest;
use core::ops::{BitAnd, BitOr, Not};

use crate::number::lanes::{Lanes, Mask, Register};
use crate::number::scalar::Scalar;
use crate::solve::dense::Matrix;
use crate::solve::{Square, Vector};

/// An update this small relative to the unknowns is the last: the error after it is its square.
pub(crate) const LAST_UPDATE: f64 = 1e-9;

/// The error that may remain after the last update, relative to the unknowns.
const REMAINDER: f64 = 1e-16;

/// An update `ρ'` of at most the first size is the last if the update `ρ` before it was larger than the
/// second size: the remaining error is `C ρ'² = ρ'³/ρ²`, at most [`REMAINDER`].
const SETTLED: [(f64, f64); 3] = [(1e-10, 1e-7), (4e-12, LAST_UPDATE), (LAST_UPDATE, 3.2e-6)];

/// An update below this part of the previous one shows that the iteration converges fast.
const MUCH_SMALLER: f64 = 0.25;

/// An update above this part of the previous one does not shrink.
const SHRINKS: f64 = 0.5;

/// Below this relative size, an update that does not shrink in the first iterations may be rounding.
const SUSPECT: f64 = 1e-2;

/// After this iteration, every update that does not shrink may be rounding.
const LATE: u32 = 2;

/// An update that has not shrunk for this many iterations is noise, if it is small enough to be the last: a
/// user's function may be noisier than the bound on its rounding error.
const STAGNANT: u32 = 4;

/// A row is taken for zero if it is within this many bounds of its rounding error.
pub(crate) const ROUNDINGS: f64 = 4.0;

/// An unknown below this part of its natural size is treated as if it were as large. So the last update,
/// [`LAST_UPDATE`] times that, is no smaller than a few rounding errors of the rows.
const PART_OF_NATURAL: f64 = 1e-6;

/// Natural sizes are used up to this condition number of the equations, and for unknowns smaller than them by
/// at most this factor: with [`PART_OF_NATURAL`], sizes that are too large by this factor change no decision.
const WELL_CONDITIONED: f64 = 1e6;

/// An inverse of more rows than this is computed by one elimination, not column by column with one
/// elimination each.
const MOST_SOLVED_ONE_BY_ONE: usize = 8;

/// Numbers that can be compared, lane by lane.
pub(crate) trait Compare: Scalar {
    /// The results of a comparison, one for each lane.
    type Truth: Copy + BitAnd<Output = Self::Truth> + BitOr<Output = Self::Truth> + Not<Output = Self::Truth>;

    /// True in every lane.
    fn always() -> Self::Truth;

    /// Whether a truth value is false in the only lane. Always `false` for several lanes, which take no
    /// branches.
    fn is_never(truth: Self::Truth) -> bool {
        let _ = truth;
        false
    }

    /// Whether a number is at most another one; not where either is NaN.
    fn is_at_most(self, other: Self) -> Self::Truth;

    /// Whether a number is smaller than another one; not where either is NaN.
    fn is_below(self, other: Self) -> Self::Truth;
}

impl Compare for f64 {
    type Truth = bool;

    #[inline]
    fn always() -> bool {
        true
    }

    #[inline]
    fn is_never(truth: bool) -> bool {
        !truth
    }

    #[inline]
    fn is_at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline]
    fn is_below(self, other: Self) -> bool {
        self < other
    }
}

#[allow(clippy::inline_always)] // compiled for the machine's own instructions
impl<R: Register> Compare for Lanes<R> {
    type Truth = Mask<R>;

    #[inline(always)]
    fn always() -> Mask<R> {
        Mask::splat(true)
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> Mask<R> {
        self.at_most(other)
    }

    #[inline(always)]
    fn is_below(self, other: Self) -> Mask<R> {
        self.below(other)
    }
}

/// An update, the unknowns from which it leads away, and the sizes that these are expected to have at least.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Update<'a, U> {
    /// The update.
    pub components: &'a U,
    /// The unknowns.
    pub unknowns: &'a U,
    /// Their expected sizes.
    pub sizes: &'a U,
}

impl<U> Update<'_, U> {
    /// Whether the update is at most `tolerance` relative to the unknowns; not where it is NaN. No division: this is part of
    /// every step.
    #[inline(always)]
    #[allow(clippy::inline_always)] // also in code that is compiled for the machine's own instructions
    pub fn is_small<T: Compare>(&self, tolerance: f64) -> T::Truth
    where
        U: AsRef<[T]>,
    {
        let mut small = T::always();
        let sizes = self.unknowns.as_ref().iter().zip(self.sizes.as_ref());
        for (update, (unknown, &size)) in self.components.as_ref().iter().zip(sizes) {
            let expected = unknown.abs().larger(size);
            small = small & update.abs().is_at_most(T::splat(tolerance) * expected);
            if T::is_never(small) {
                break;
            }
        }
        small
    }

    /// Whether the update is the last, after the full one `before`: whether at most [`REMAINDER`] is left after it.
    #[inline(always)]
    #[allow(clippy::inline_always)] // part of every step
    pub fn settles<T: Compare>(&self, before: &Self) -> T::Truth
    where
        U: AsRef<[T]>,
    {
        let mut settled = !T::always();
        for (largest, smallest) in SETTLED {
            let small = self.is_small(largest);
            if T::is_never(small) {
                continue;
            }
            settled = settled | (small & !before.is_small(smallest));
            if T::is_never(!settled) {
                break;
            }
        }
        settled
    }

    /// The size of the update relative to the unknowns, of all components the largest; NaN where a component is.
    #[inline(always)]
    #[allow(clippy::inline_always)] // as above
    pub fn relative<T: Compare>(&self) -> T
    where
        U: AsRef<[T]>,
    {
        let zero = T::splat(0.0);
        let (unknowns, sizes) = (self.unknowns.as_ref(), self.sizes.as_ref());
        let mut largest = zero;
        for (place, update) in self.components.as_ref().iter().enumerate() {
            let update = update.abs();
            // an update of zero is small, also where the unknown is zero
            let quotient = update / unknowns[place].abs().larger(sizes[place]);
            let ratio = T::select_le(update, zero, zero, quotient);
            largest = T::select_le(ratio, largest, largest, ratio);
        }
        largest
    }
}

/// Whether an update of the relative size `now`, after one of the size `before`, shows that the iteration converges fast.
#[inline(always)]
#[allow(clippy::inline_always)] // as above
pub(crate) fn converges<T: Compare>(before: T, now: T) -> T::Truth {
    now.is_below(T::splat(MUCH_SMALLER) * before)
}

/// Whether the later of two full updates, of the relative sizes `before` and `now`, is the last.
pub(crate) fn is_last(before: f64, now: f64) -> bool {
    let contraction = now / before;
    now <= LAST_UPDATE && now * contraction * contraction <= REMAINDER
}

/// Decrease of the updates of an iteration that does not converge fast.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    /// The smallest update so far, relative to the unknowns.
    smallest: f64,
    /// The last update, relative to the unknowns.
    last: f64,
    /// Number of consecutive updates that were not much smaller than the smallest one.
    stagnant: u32,
}

/// Possible cause of an update that does not shrink.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StagnationCause {
    /// No suspicion: it shrinks, or it is too early to tell.
    None,
    /// Perhaps rounding: it is if all rows are within [`ROUNDINGS`] bounds of their rounding errors.
    Rounding,
    /// Noise of a user's function, whatever the bounds of the rows' rounding errors are.
    Noise,
}

impl Progress {
    /// The progress after the first update, of the relative size `size`.
    pub fn new(size: f64) -> Self {
        Self {
            smallest: size,
            last: size,
            stagnant: 0,
        }
    }

    /// The size of the last update, relative to the unknowns.
    pub fn last(&self) -> f64 {
        self.last
    }

    /// Records the size of the next update, relative to the unknowns.
    pub fn take(&mut self, size: f64) {
        if size < SHRINKS * self.smallest {
            (self.smallest, self.stagnant) = (size, 0);
        } else {
            self.stagnant += 1;
        }
        self.last = size;
    }

    /// The suspicion about the last update, a full one of iteration `iteration`, after one of the size
    /// `before`.
    pub fn stagnation_cause(&self, before: f64, iteration: u32) -> StagnationCause {
        let size = self.last;
        if size < SHRINKS * before || (size > SUSPECT && iteration <= LATE) {
            StagnationCause::None
        } else if self.stagnant >= STAGNANT && size <= LAST_UPDATE {
            StagnationCause::Noise
        } else {
            StagnationCause::Rounding
        }
    }
}

/// The *natural size* of each unknown, `S = |J⁻¹| T`, with the Jacobian `J` of the rows and the sizes `T` of
/// their terms: its size if the terms of the rows did not cancel.
///
/// Rounding changes the rows by about `u T`, with the unit round-off `u`, and so the root by about `u S`: no
/// unknown can be known more precisely. Unknowns may span many decades: a pull at the inner end of a chain is
/// felt at its outer end by `1e-15` of it. Then a small unknown has to be measured by its natural size, not
/// by its own. (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd ed., section 7.2:
/// componentwise perturbations of linear equations.)
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NaturalSizes {
    /// The sizes.
    pub sizes: Vector,
    /// The largest diagonal entry of `|J⁻¹| |J|`, which does not depend on the scaling of rows or unknowns; 1
    /// for a diagonal Jacobian.
    pub condition: f64,
    /// The largest ratio `|z|/S` of an unknown to its natural size.
    pub level: f64,
}

/// The inverse of a matrix whose rows are brought to the size 1: all columns by one elimination.
fn inverse_of_scaled(jacobian: &Square) -> Matrix {
    let rows: Vec<(&[f64], f64)> = jacobian.rows().map(|row| (row, largest(row))).collect();
    Matrix::from_fn(rows.len(), rows.len(), |i, j| rows[i].0[j] / rows[i].1).inverse()
}

impl NaturalSizes {
    /// The natural sizes near `z`, for the Jacobian and the sizes of the terms of each row; `None` if the Jacobian is
    /// singular or an entry is not finite.
    #[cold]
    pub fn new(jacobian: &Square, terms: &[f64], z: &[f64]) -> Option<Self> {
        let count = jacobian.size();
        let (mut sizes, mut condition) = (Vector::zero(count), Vector::zero(count));
        let inverse = (count > MOST_SOLVED_ONE_BY_ONE).then(|| inverse_of_scaled(jacobian));
        for ((place, row), term) in jacobian.rows().enumerate().zip(terms) {
            let largest = largest(row);
            // a column of the inverse, in units that neither overflow nor underflow
            let column = match &inverse {
                Some(inverse) => Vector::from_fn(count, |i| inverse[(i, place)]),
                None => jacobian.solve(&Vector::from_fn(
                    count,
                    |i| if i == place { largest } else { 0.0 },
                ))?,
            };
            let term = term / largest;
            sizes = sizes.zip(&column, |size, x| size + x.abs() * term);
            condition = condition.zip(
                &column.zip(row, |x, entry| x.abs() * (entry.abs() / largest)),
                |sum, part| sum + part,
            );
        }
        let condition = condition.iter().fold(0.0_f64, |largest, x| largest.max(*x));
        let ratios = z.iter().zip(sizes.iter());
        let ratios = ratios.map(|(z, size)| if *size > 0.0 { z.abs() / size } else { 0.0 });
        let level = ratios.fold(0.0, f64::max);
        sizes.is_finite().then_some(Self {
            sizes,
            condition,
            level,
        })
    }

    /// The size of each unknown.
    pub fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// Whether the sizes come from coupled unknowns and not from nearly singular rows: near a double root,
    /// natural sizes are large without bound.
    pub fn are_usual(&self) -> bool {
        self.condition <= WELL_CONDITIONED && self.level * WELL_CONDITIONED >= 1.0
    }

    /// Expected sizes, raised to at least [`PART_OF_NATURAL`] of the natural sizes.
    pub fn raise(&self, sizes: &Vector) -> Vector {
        sizes.zip(&self.sizes, |size, natural| size.max(PART_OF_NATURAL * natural))
    }
}

/// Natural sizes that were needed at one step and serve at the next ones.
#[derive(Clone, Debug)]
pub(crate) struct RetainedSizes {
    /// [`PART_OF_NATURAL`] of the sizes.
    pub part: Vector,
    /// `1/S`.
    pub inverse: Vector,
    /// The largest ratio of an unknown to its natural size at that step.
    pub level: f64,
}

impl RetainedSizes {
    /// Takes natural sizes.
    pub fn new(natural: &NaturalSizes) -> Self {
        Self {
            part: natural.sizes.map(|size| PART_OF_NATURAL * size),
            inverse: natural
                .sizes
                .map(|size| if size > 0.0 { 1.0 / size } else { 0.0 }),
            level: natural.level,
        }
    }

    /// The largest ratio of an unknown to its natural size.
    fn level(&self, z: &[f64]) -> f64 {
        let ratios = z.iter().zip(self.inverse.iter());
        ratios.fold(0.0, |largest, (z, inverse)| f64::max(largest, z.abs() * inverse))
    }

    /// Raises expected sizes to at least [`PART_OF_NATURAL`] of the natural sizes, for recent sizes `lately`
    /// of the unknowns.
    ///
    /// Natural sizes are rescaled with the unknowns: they shrink as these do, and grow once these have
    /// outgrown them.
    #[inline(never)] // seldom needed, and then by systems that have many unknowns
    pub fn raise(&self, sizes: &mut [f64], lately: &[f64]) {
        let level = self.level(lately);
        let factor = if level < self.level {
            level / self.level
        } else {
            level.max(1.0)
        };
        for (size, part) in sizes.iter_mut().zip(self.part.iter()) {
            *size = size.max(factor * part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square<const M: usize>(rows: &[[f64; M]; M]) -> Square {
        Square::from_fn(M, |i, j| rows[i][j])
    }

    #[test]
    fn natural_sizes_do_not_depend_on_units() {
        let jacobian = [[2.0, 1.0], [1.0, 1e-3]];
        let terms = [3.0, 1.0];
        let here = NaturalSizes::new(&square(&jacobian), &terms, &[1.0, 1.0]).unwrap();
        // |J⁻¹| = [[1e-3, 1], [1, 2]] / 0.998
        for (found, size) in here.sizes.iter().zip([1.003, 5.0]) {
            assert!((found * 0.998 - size).abs() < 1e-14, "{found}");
        }
        for exponent in [-400, -40, 40, 400] {
            let unit = 2.0_f64.powi(exponent);
            // the second row and the first unknown in other units
            let scaled = [[2.0 / unit, 1.0], [1.0, 1e-3 * unit]];
            let there = NaturalSizes::new(&square(&scaled), &[3.0, unit], &[1.0, 1.0]).unwrap();
            assert_eq!([there.sizes[0] / unit, there.sizes[1]], here.sizes[..]);
            assert_eq!(there.condition, here.condition);
        }
    }

    #[test]
    fn natural_sizes_of_many_unknowns_are_those_of_a_known_inverse() {
        const M: usize = 40;
        // sums of the first unknowns, each row in a unit of its own: the inverse is a difference of two rows
        let mut jacobian = [[0.0; M]; M];
        for (i, row) in jacobian.iter_mut().enumerate() {
            row[..=i].fill(2.0_f64.powi(i32::try_from(i).unwrap()));
        }
        let natural = NaturalSizes::new(&square(&jacobian), &[1.0; M], &[1.0; M]).unwrap();
        for (i, size) in natural.sizes.iter().enumerate() {
            let unit = 0.5_f64.powi(i32::try_from(i).unwrap());
            let expected = if i == 0 { unit } else { 3.0 * unit };
            assert!((size / expected - 1.0).abs() < 1e-12, "{i}: {size}");
        }
        assert!((natural.condition - 1.0).abs() < 1e-12, "{}", natural.condition);
        jacobian[M - 1] = jacobian[0];
        assert_eq!(NaturalSizes::new(&square(&jacobian), &[1.0; M], &[1.0; M]), None);
    }

    #[test]
    fn a_singular_jacobian_has_no_natural_sizes() {
        assert_eq!(
            NaturalSizes::new(&square(&[[1.0, 2.0], [2.0, 4.0]]), &[1.0, 1.0], &[1.0, 1.0]),
            None
        );
        let nearly = NaturalSizes::new(
            &square(&[[1.0, 2.0], [2.0, 4.0 + 1e-12]]),
            &[1.0, 1.0],
            &[1.0, 1.0],
        )
        .unwrap();
        assert!(!nearly.are_usual());
    }

    #[test]
    fn natural_sizes_are_used_where_they_are_neither_hardly_determined_nor_far_too_large() {
        let natural = |condition, level| NaturalSizes {
            sizes: Vector::of(&[1.0, 2.0]),
            condition,
            level,
        };
        assert!(natural(1.0, 1.0).are_usual() && natural(0.9e6, 1.1e-6).are_usual());
        assert!(!natural(1.1e6, 1.0).are_usual() && !natural(1.0, 0.9e-6).are_usual());
        // so large that the last update is a few roundings of the rows
        assert_eq!(natural(1.0, 1.0).raise(&Vector::of(&[0.0, 5.0]))[..], [1e-6, 5.0]);
        assert_eq!(
            natural(1.0, 1.0).raise(&Vector::of(&[1e-5, 0.0]))[..],
            [1e-5, 2e-6]
        );
    }

    #[test]
    fn an_update_that_shrinks_as_it_should_is_the_last_and_one_that_does_not_is_none() {
        let settles = |before: f64, now: f64| {
            let update = |components| Update {
                components,
                unknowns: &[1.0],
                sizes: &[0.0],
            };
            update(&[now]).settles::<f64>(&update(&[before]))
        };
        // the remaining error is now³/before²
        assert!(settles(1e-5, 1e-10) && settles(4e-6, 9e-10) && settles(2e-7, 9e-11) && settles(2e-9, 3e-12));
        assert!(
            !settles(1e-9, 9e-10) && !settles(1e-7, 9e-10) && !settles(1e-8, 9e-11) && !settles(9e-10, 3e-12)
        );
        assert!(!settles(1.0, 2e-9));
    }

    #[test]
    fn progress_tells_what_has_stopped_to_shrink() {
        let mut progress = Progress::new(1.0);
        for size in [0.3, 0.1, 0.01] {
            progress.take(size);
        }
        assert_eq!(
            (progress.stagnant, progress.smallest, progress.last()),
            (0, 0.01, 0.01)
        );
        progress.take(1e-10);
        for stagnant in 1..=STAGNANT {
            assert_ne!(progress.stagnation_cause(1e-10, 9), StagnationCause::Noise);
            progress.take(0.9e-10);
            assert_eq!(progress.stagnant, stagnant);
        }
        assert_eq!(progress.stagnation_cause(1e-10, 9), StagnationCause::Noise);
        // large ones may still shrink, in the first iterations
        let mut progress = Progress::new(1.0);
        progress.take(0.9);
        assert_eq!(progress.stagnation_cause(1.0, LATE), StagnationCause::None);
        assert_eq!(
            progress.stagnation_cause(1.0, LATE + 1),
            StagnationCause::Rounding
        );
        assert_eq!(progress.stagnation_cause(10.0, LATE + 1), StagnationCause::None);
    }

    #[test]
    fn an_update_is_judged_by_the_size_that_is_expected() {
        let (update, unknowns) = ([1e-10, 1e-20], [1.0, 1e-15]);
        let own = Update {
            components: &update,
            unknowns: &unknowns,
            sizes: &[0.0, 0.0],
        };
        assert!(!own.is_small::<f64>(LAST_UPDATE));
        let expected = Update {
            sizes: &[0.0, 1e-10],
            ..own
        };
        assert!(expected.is_small::<f64>(LAST_UPDATE));
        let nothing = Update {
            components: &[f64::NAN, 0.0],
            ..own
        };
        assert!(!nothing.is_small::<f64>(1.0));
    }

    #[test]
    fn what_is_remembered_goes_with_the_motion() {
        let natural = NaturalSizes {
            sizes: Vector::of(&[1.0, 2.0]),
            condition: 3.0,
            level: 0.5,
        };
        let retained = RetainedSizes::new(&natural);
        let raised = |lately: [f64; 2]| {
            let mut sizes = [0.0, 0.0];
            retained.raise(&mut sizes, &lately);
            sizes
        };
        assert_eq!(raised([0.5, 0.0]), [1e-6, 2e-6]);
        assert_eq!(raised([0.25, 0.0]), [0.5e-6, 1e-6]);
        assert_eq!(raised([4.0, 0.0]), [4e-6, 8e-6]);
        assert_eq!(raised([0.0, 0.0]), [0.0, 0.0]);
    }
}
