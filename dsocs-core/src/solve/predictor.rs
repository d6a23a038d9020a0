//! The initial guess of Newton's iteration: a polynomial through the last solutions.

use core::marker::PhantomData;
use core::ops::Sub;

use super::convergence::{NaturalSizes, RetainedSizes};
use super::elimination::Determinant;
use super::newton::IterationRecord;
use super::unknown::Unknown;
use crate::number::array::Array;
use crate::number::point::copy;
use crate::number::scalar::Scalar;
use crate::solve::Vector;

/// The highest degree of the polynomial.
const ORDER: usize = 5;

/// Number of backward differences that are kept: `∇⁰z, ∇¹z, … ∇⁵z`.
pub(crate) const DIFFERENCES: usize = ORDER + 1;

/// Factor by which the recorded size of an unknown decays from one step to the next.
const MEMORY: f64 = 0.75;

/// The past solutions that predict the next one: backward differences, sizes and determinants.
///
/// A smooth motion is predicted with degree 5. Where the motion is not smooth on the scale of the step (a
/// switch is crossed, a phase turns several radians a step) differences grow with their order, and the degree
/// falls, down to the last solution itself.
#[derive(Clone, Debug)]
pub(crate) struct Predictor {
    /// The number of unknowns.
    unknowns: usize,
    /// `∇⁰z, ∇¹z, … ∇⁵z`, NaN where the history is too short; then the recent size of each unknown, its
    /// largest absolute value, which decays by [`MEMORY`] a step; then the factors by which the rows of the
    /// last smooth step were multiplied, NaN before it.
    past: Vec<f64>,
    /// The natural sizes of the unknowns, if they were needed lately.
    natural: Option<Box<RetainedSizes>>,
    /// The determinants at the last solutions.
    pub determinants: Determinants,
}

/// The backward differences and the sizes of a [`Predictor`] as arrays, where steps are made.
pub(crate) struct Arrays<'p, U> {
    /// The differences.
    pub differences: [&'p mut U; DIFFERENCES],
    /// The recent sizes.
    pub size: &'p mut U,
    /// The factors by which the rows of the last smooth step were multiplied; NaN before it.
    pub scales: &'p mut U,
    /// The determinants at the last solutions.
    pub determinants: &'p mut Determinants,
    /// The natural sizes, if they were needed lately.
    pub natural: Option<&'p RetainedSizes>,
}

/// Backward differences and sizes for numbers of any type, such as lanes.
#[repr(align(16))] // as compensated sums; see [`crate::number::compensated`]
#[derive(Clone, Copy, Debug)]
#[allow(clippy::struct_field_names)] // the usual name
pub(crate) struct Differences<U, T = f64> {
    /// `∇⁰z, ∇¹z, … ∇⁵z`; NaN where the history is too short.
    differences: [U; DIFFERENCES],
    /// The recent size of each unknown: its largest absolute value, which decays by [`MEMORY`] a step.
    size: U,
    /// The type of the unknowns' numbers.
    scalar: PhantomData<T>,
}

/// The determinants of the rows' Jacobian at the last solutions, the last first, in a common unit; NaN where they are not
/// known.
///
/// Along a motion the determinant changes smoothly. The two roots of a pair have Jacobians of opposite
/// orientation. So the determinant departs from its extrapolation where a step changes to another motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Determinants {
    /// The numbers.
    pub last: [f64; PAST],
    /// The exponent of the power of two that is their unit.
    pub unit: i32,
    /// The inverse of the determinant that was examined last, in that unit; NaN before.
    pub inverse: f64,
    /// The determinant of the step that is being solved.
    pub next: f64,
    /// Whether the last two determinants are nearly equal, and whether the next one nearly equals the last.
    pub steady: [bool; 2],
}

/// Number of past determinants that are kept for the extrapolation.
pub(crate) const PAST: usize = 4;

/// Largest relative deviation of a determinant from its extrapolation. That of the other root of a pair is
/// about 2.
pub(crate) const FITS: f64 = 0.5;

/// Consecutive determinants with at most this relative difference do not depart: a change to the other root
/// would be larger.
pub(crate) const STEADY: f64 = 0.25;

/// A determinant is examined once it is below this part of the one that was examined last.
pub(crate) const FALLEN: f64 = 0.5;

/// It is examined, too, once it is this many times as large, so that a later fall is measured from there.
/// Rarely reached in an oscillation.
pub(crate) const RISEN: f64 = 64.0;

/// A determinant compared with those of the steps before, to judge the root of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Continuation {
    /// It continues the earlier determinants, or there are too few.
    Fits,
    /// It departs from the extrapolation of the earlier determinants.
    Departs,
    /// It departs, and has the opposite sign.
    SignChanged,
}

impl Determinants {
    /// No past determinants.
    pub const UNKNOWN: Self = Self {
        last: [f64::NAN; PAST],
        unit: 0,
        inverse: f64::NAN,
        next: f64::NAN,
        steady: [false; 2],
    };

    /// Records the determinant of the step that is being solved, and compares it with the past.
    #[inline]
    pub fn take(&mut self, determinant: Determinant) -> Continuation {
        if self.inverse.is_nan() {
            self.unit = determinant.exponent;
        }
        let now = determinant.in_units_of(self.unit);
        self.next = now;
        // false also without a past
        let is_steady = (self.last[0] - now).abs() <= STEADY * now.abs();
        self.steady[1] = is_steady;
        // the flag from memory first: loading both at once would wait for the one that was just written
        if self.steady[0] && is_steady {
            Continuation::Fits
        } else {
            self.compare(now)
        }
    }

    /// Whether a determinant is to be examined: it has become small or large since the last examination, or
    /// has changed its sign.
    #[inline]
    #[expect(clippy::manual_range_contains, reason = "a number that is none asks nothing")]
    pub fn is_to_be_examined(&self, determinant: Determinant) -> bool {
        let part = determinant.in_units_of(self.unit) * self.inverse;
        // false also where there is no past
        part < FALLEN || part > RISEN
    }

    /// The determinant of the last solved step over the one that was examined last; NaN if it is not known.
    pub fn part(&self) -> f64 {
        self.next * self.inverse
    }

    /// Examines the determinant of the last solved step: returns whether it has become small since the last
    /// examination, or has changed its sign.
    pub fn look(&mut self) -> bool {
        let part = self.part();
        if !(FALLEN..=RISEN).contains(&part) {
            self.inverse = self.next.recip();
        }
        part < FALLEN
    }

    /// Requires that the determinant of the next step is examined, whatever it is.
    pub fn look_again(&mut self) {
        self.inverse = f64::MIN_POSITIVE.copysign(self.inverse);
    }

    /// Compares a determinant with extrapolations of the past ones, of degree 1 and of degree 2.
    #[inline(never)] // seldom needed: most determinants hardly change from step to step
    pub fn compare(&self, now: f64) -> Continuation {
        let [a, b, c, _] = self.last;
        // of the degree for which enough are known
        let continued = if a.is_nan() {
            return Continuation::Fits;
        } else if b.is_nan() {
            [a, a]
        } else if c.is_nan() {
            [a, 2.0 * a - b]
        } else {
            [2.0 * a - b, 3.0 * (a - b) + c]
        };
        let bound = FITS * now.abs();
        // a change larger than the determinant itself does not tell whether it passed zero or turned back
        // before
        let is_clear = (a - now).abs() <= now.abs();
        if is_clear && continued.iter().all(|x| (x - now).abs() <= bound) {
            Continuation::Fits
        } else if continued.iter().all(|x| x * now > 0.0) {
            Continuation::Departs
        } else {
            Continuation::SignChanged
        }
    }

    /// Moves the determinant of the solved step to the past.
    #[inline]
    pub fn push(&mut self) {
        self.last = [self.next, self.last[0], self.last[1], self.last[2]];
        (self.next, self.steady) = (f64::NAN, [self.steady[1], false]);
    }
}

/// Records the solution of a step.
#[allow(clippy::inline_always)] // part of every step
#[inline(always)]
fn push<'u, T: Scalar, U: Unknown<T> + 'u>(
    differences: impl IntoIterator<Item = &'u mut U>,
    size: &mut U,
    z: &U,
) {
    let mut difference = *z;
    for entry in differences {
        let last = core::mem::replace(entry, difference);
        difference = difference.zip(&last, |new, old| new - old);
    }
    *size = size.zip(z, |size, z| (T::splat(MEMORY) * size).larger(z.abs()));
}

/// Records the solution of a step in a past that is stored as in [`Predictor`]; `size_after` gives the new
/// recent size.
pub(crate) fn push_past<T: Copy + Sub<Output = T>>(past: &mut [T], z: &[T], size_after: impl Fn(T, T) -> T) {
    let m = z.len();
    let Some((differences, sizes)) = past.split_at_mut_checked(DIFFERENCES * m) else {
        return;
    };
    for (i, (&z, size)) in z.iter().zip(sizes).enumerate() {
        let mut difference = z;
        for entry in differences.iter_mut().skip(i).step_by(m) {
            let last = core::mem::replace(entry, difference);
            difference = difference - last;
        }
        *size = size_after(*size, z);
    }
}

/// The recent size of an unknown, after a solution.
#[allow(clippy::inline_always)] // for the machine's own instructions
#[inline(always)]
pub(crate) fn size_after<T: Scalar>(size: T, z: T) -> T {
    (T::splat(MEMORY) * size).larger(z.abs())
}

/// The unknowns of the next step, each by the polynomial of the degree whose last two differences are smallest.
#[allow(clippy::inline_always)] // part of every step
#[inline(always)]
fn extrapolate<T: Scalar, U: AsRef<[T]> + AsMut<[T]> + Clone>(
    last: &U,
    differences: [&(impl AsRef<[T]> + ?Sized); ORDER],
) -> U {
    let mut sizes = last.clone();
    for size in sizes.as_mut() {
        *size = size.abs();
    }
    let (mut guess, mut sum, mut smallest, mut before) = (last.clone(), last.clone(), sizes.clone(), sizes);
    // degree by degree for all unknowns together, with selections instead of branches: this is part of every
    // step
    for difference in differences {
        let (guess, sum, smallest, before) =
            (guess.as_mut(), sum.as_mut(), smallest.as_mut(), before.as_mut());
        for (place, &difference) in difference.as_ref().iter().enumerate() {
            sum[place] = sum[place] + difference;
            let size = difference.abs();
            // NaN where the history is too short: comparisons with it are false
            let larger = before[place].larger(size);
            guess[place] = T::select_le(larger, smallest[place], sum[place], guess[place]);
            smallest[place] = larger.smaller(smallest[place]);
            before[place] = size;
        }
    }
    guess
}

/// [`extrapolate`] for one unknown.
#[allow(clippy::inline_always)] // for the machine's own instructions
#[inline(always)]
pub(crate) fn extrapolate_one<T: Scalar>(last: T, differences: &[T; ORDER]) -> T {
    let (mut guess, mut sum, mut smallest, mut before) = (last, last, last.abs(), last.abs());
    for &difference in differences {
        sum = sum + difference;
        let size = difference.abs();
        let larger = before.larger(size);
        guess = T::select_le(larger, smallest, sum, guess);
        smallest = larger.smaller(smallest);
        before = size;
    }
    guess
}

/// Whether a solution is near its prediction, each unknown within a part of itself.
#[inline]
pub(crate) fn is_near_prediction(guess: &[f64], z: &[f64], part: f64) -> bool {
    // false for a NaN
    z.iter()
        .zip(guess)
        .all(|(z, guess)| (z - guess).abs() <= part * z.abs())
}

/// Whether a second difference follows from the last two, where the unknowns do not determine it: coordinates
/// that are known without a root have no unknowns and no prediction. It follows if it is near the last one,
/// or near the line through both; the line can pass zero, as a motion does.
#[inline]
pub(crate) fn continues(unknowns: usize, past: Option<[&[f64]; 2]>, e: &[f64], part: f64) -> bool {
    unknowns >= e.len()
        || past.is_some_and(|[before, last]| {
            e.iter().zip(before).zip(last).all(|((e, before), last)| {
                let near = |guess: f64| (e - guess).abs() <= part * e.abs();
                // false for a NaN
                near(*last) || near(2.0 * last - before)
            })
        })
}

impl<U: Unknown<f64>> Arrays<'_, U> {
    /// Records the solution of a step, and its determinant if the system's roots are `watched` for others.
    #[allow(clippy::inline_always)] // part of every step
    #[inline(always)]
    pub fn push(&mut self, z: &U, watched: bool) {
        push(
            self.differences.iter_mut().map(|difference| &mut **difference),
            self.size,
            z,
        );
        if watched {
            self.determinants.push();
        }
    }

    /// The unknowns of the next step; `None` without a past.
    #[allow(clippy::inline_always)] // part of every step
    #[inline(always)]
    pub fn predict(&self) -> Option<U> {
        let [last, d1, d2, d3, d4, d5] = &self.differences;
        if last.as_ref().iter().any(|z| z.is_nan()) {
            return None;
        }
        Some(extrapolate(&**last, [d1, d2, d3, d4, d5]))
    }
}

impl<T: Scalar, U: Unknown<T>> Differences<U, T> {
    /// No past solutions.
    pub fn new() -> Self {
        let unknown = U::zero();
        Self {
            differences: [unknown.zip(&unknown, |_, _| T::splat(f64::NAN)); DIFFERENCES],
            size: unknown,
            scalar: PhantomData,
        }
    }

    /// Records the solution of a step.
    #[allow(clippy::inline_always)] // for the machine's own instructions
    #[inline(always)]
    pub fn push_here(&mut self, z: &U) {
        push(&mut self.differences, &mut self.size, z);
    }

    /// The recent size of each unknown.
    #[inline]
    pub fn size(&self) -> &U {
        &self.size
    }

    /// The unknowns of the next step.
    #[allow(clippy::inline_always)] // for the machine's own instructions
    #[inline(always)]
    pub fn extrapolate_here(&self) -> U {
        let [last, d1, d2, d3, d4, d5] = &self.differences;
        extrapolate(last, [d1, d2, d3, d4, d5])
    }

    /// All vectors, in the order of [`Predictor::vectors`].
    #[allow(clippy::inline_always)] // for the machine's own instructions
    #[inline(always)]
    pub fn vectors(&self) -> impl Iterator<Item = &U> {
        self.differences.iter().chain([&self.size])
    }

    /// The vectors of [`Differences::vectors`], mutable.
    #[allow(clippy::inline_always)] // for the machine's own instructions
    #[inline(always)]
    pub fn vectors_mut(&mut self) -> impl Iterator<Item = &mut U> {
        self.differences.iter_mut().chain([&mut self.size])
    }
}

impl Predictor {
    /// A predictor of this many unknowns, without a past.
    pub fn new(unknowns: usize) -> Self {
        let mut past = vec![f64::NAN; DIFFERENCES * unknowns];
        past.resize((DIFFERENCES + 1) * unknowns, 0.0);
        past.resize((DIFFERENCES + 2) * unknowns, f64::NAN);
        Self {
            unknowns,
            past,
            natural: None,
            determinants: Determinants::UNKNOWN,
        }
    }

    /// The differences and then the sizes, one vector after the other.
    pub fn vectors(&self) -> impl Iterator<Item = &[f64]> {
        (0..=DIFFERENCES).map(|place| self.vector(place))
    }

    /// Sets a component of a vector in the order of [`Predictor::vectors`].
    pub fn set(&mut self, vector: usize, component: usize, value: f64) {
        if let Some(place) = self.past.get_mut(vector * self.unknowns + component) {
            *place = value;
        }
    }

    fn vector(&self, place: usize) -> &[f64] {
        self.past
            .get(place * self.unknowns..(place + 1) * self.unknowns)
            .unwrap_or(&[])
    }

    /// Differences, sizes and factors as arrays; `None` for another number of unknowns.
    #[allow(clippy::inline_always)] // part of every step
    #[inline(always)]
    pub fn arrays<U: Array<f64>>(&mut self) -> Option<Arrays<'_, U>> {
        // one check of the length in place of eight
        if self.past.len() < (DIFFERENCES + 2) * U::LENGTH {
            return None;
        }
        let (d0, rest) = U::split(&mut self.past)?;
        let (d1, rest) = U::split(rest)?;
        let (d2, rest) = U::split(rest)?;
        let (d3, rest) = U::split(rest)?;
        let (d4, rest) = U::split(rest)?;
        let (d5, rest) = U::split(rest)?;
        let (size, rest) = U::split(rest)?;
        let (scales, _) = U::split(rest)?;
        let arrays = Arrays {
            differences: [d0, d1, d2, d3, d4, d5],
            size,
            scales,
            determinants: &mut self.determinants,
            natural: self.natural.as_deref(),
        };
        Some(arrays)
    }

    /// Records the solution of a step that was not smooth.
    pub fn push(&mut self, z: &[f64]) {
        push_past(&mut self.past, z, size_after);
        // the factors of such a step are not known
        for scale in self.past.iter_mut().skip((DIFFERENCES + 1) * self.unknowns) {
            *scale = f64::NAN;
        }
        self.determinants.push();
    }

    /// Records the solution of a smooth step and the factors of its rows, and its determinant if the system's
    /// roots are `watched` for others.
    #[inline]
    pub fn push_smooth(&mut self, z: &[f64], scales: &[f64], watched: bool) {
        push_past(&mut self.past, z, size_after);
        let last = self.past.get_mut((DIFFERENCES + 1) * self.unknowns..);
        copy(last.unwrap_or_default(), scales);
        if watched {
            self.determinants.push();
        }
    }

    /// The factors by which the rows of the last smooth step were multiplied; NaN where they are not known.
    #[inline]
    pub fn scales(&self) -> &[f64] {
        self.vector(DIFFERENCES + 1)
    }

    /// The recent size of each unknown.
    pub fn size(&self) -> &[f64] {
        self.vector(DIFFERENCES)
    }

    /// Forgets the past, except the last solution, its size and the natural sizes, because the run reverses
    /// its time.
    pub fn turn(&mut self) {
        let last = self.last();
        let mut turned = Self::new(self.unknowns);
        if let Some(last) = last {
            turned.push(last);
        }
        let sizes = turned
            .past
            .iter_mut()
            .zip(&self.past)
            .skip(DIFFERENCES * self.unknowns);
        for (to, from) in sizes.take(self.unknowns) {
            *to = *from;
        }
        turned.natural = self.natural.take();
        *self = turned;
    }

    /// The expected size of each unknown: its recent one, and at least `least`.
    pub fn expected(&self, least: &[f64]) -> Vector {
        let mut sizes = Vector::of(self.size()).zip(least, f64::max);
        if let Some(natural) = &self.natural {
            natural.raise(&mut sizes, self.size());
        }
        sizes
    }

    /// Compares the determinant at the root of the step that is being solved with those of the steps before.
    pub fn take_determinant(&mut self, determinant: Determinant) -> Continuation {
        self.determinants.take(determinant)
    }

    /// The natural sizes of the unknowns, where they were needed lately.
    pub fn natural(&self) -> Option<&RetainedSizes> {
        self.natural.as_deref()
    }

    /// Sets the natural sizes.
    pub fn set_natural(&mut self, natural: Option<RetainedSizes>) {
        self.natural = natural.map(Box::new);
    }

    /// The last solution; `None` without a past.
    pub fn last(&self) -> Option<&[f64]> {
        let last = self.vector(0);
        (!last.iter().any(|z| z.is_nan())).then_some(last)
    }

    /// The last solutions, the last first, at most [`PAST`].
    pub fn past(&self) -> Vec<Vector> {
        let mut differences: Vec<Vector> = self.vectors().take(DIFFERENCES).map(Vector::of).collect();
        let mut solutions = Vec::with_capacity(PAST);
        for k in 0..PAST {
            // shifted one step back: each shift loses the highest difference
            let known = if k == 0 { 0 } else { DIFFERENCES.saturating_sub(k) };
            for place in 0..known {
                differences[place] =
                    differences[place].zip(&differences[place + 1], |now, change| now - change);
            }
            solutions.push(differences[0].clone());
        }
        solutions.retain(|z| z.iter().all(|z| !z.is_nan()));
        solutions
    }

    /// The unknowns of the next step; `None` without a past.
    pub fn predict(&self) -> Option<Vector> {
        self.predict_as(Vector::of)
    }

    /// The predicted unknowns as vectors of another type, which `of` makes from numbers.
    #[inline]
    pub fn predict_as<U: AsRef<[f64]> + AsMut<[f64]> + Clone>(&self, of: impl Fn(&[f64]) -> U) -> Option<U> {
        let last = of(self.last()?);
        let differences = [1, 2, 3, 4, 5].map(|place| self.vector(place));
        Some(extrapolate(&last, differences))
    }

    /// Whether a solution is near its prediction, each unknown within a part of itself.
    pub fn is_near_prediction(&self, z: &[f64], part: f64) -> bool {
        let differences = [1, 2, 3, 4, 5].map(|place| self.vector(place));
        is_near_prediction(&extrapolate(&Vector::of(self.vector(0)), differences), z, part)
    }
}

impl IterationRecord for Predictor {
    fn natural_sizes(&mut self, sizes: &NaturalSizes) {
        self.natural = Some(Box::new(RetainedSizes::new(sizes)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_turns_round_forgets_its_past_and_no_size() {
        let mut predictor: Predictor = Predictor::new(2);
        for k in 0..8 {
            predictor.push(&[f64::from(k), 1e-3]);
        }
        predictor.push(&[-3.0, 1e-3]);
        predictor.natural_sizes(&NaturalSizes {
            sizes: Vector::of(&[1.0, 2.0]),
            condition: 3.0,
            level: 4.0,
        });
        let size = predictor.size().to_vec();
        assert!(size[0] > 3.0, "{size:?}");
        let expected = predictor.expected(&[0.0; 2]);
        predictor.turn();
        assert_eq!(
            (predictor.past(), predictor.last()),
            (vec![Vector::of(&[-3.0, 1e-3])], Some(&[-3.0, 1e-3][..]))
        );
        assert_eq!(predictor.size(), size);
        assert!(predictor.natural().is_some());
        assert_eq!(predictor.expected(&[0.0; 2]), expected);
    }

    #[test]
    fn polynomials_up_to_the_fifth_degree_are_exact() {
        for degree in 0..=5 {
            let value = |k: i32| [f64::from(k).powi(degree), 1.0];
            let mut predictor = Predictor::new(2);
            assert_eq!(predictor.predict(), None);
            for k in 0..12 {
                predictor.push(&value(k - 6));
            }
            assert_eq!(
                predictor.predict(),
                Some(Vector::of(&value(6))),
                "degree {degree}"
            );
        }
    }

    #[test]
    fn a_rotation_is_predicted_at_every_phase() {
        let mut predictor = Predictor::new(1);
        let mut worst: f64 = 0.0;
        for k in 0..2000 {
            let phase = f64::from(k) * 0.01;
            if k > 6 {
                let guess = predictor.predict().unwrap();
                worst = worst.max((guess[0] - phase.sin()).abs());
            }
            predictor.push(&[phase.sin()]);
        }
        assert!(worst < 1e-11, "{worst:e}");
    }

    #[test]
    fn noise_is_not_blown_up() {
        let mut predictor = Predictor::new(1);
        let (mut seed, mut worst) = (1_u32, 0.0_f64);
        for _ in 0..1000 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            predictor.push(&[f64::from(seed) / f64::from(u32::MAX) - 0.5]);
            let guess = predictor.predict().unwrap();
            worst = worst.max(guess[0].abs());
        }
        assert!(worst < 5.0, "{worst}");
    }

    #[test]
    fn turning_keeps_the_last_solution_only() {
        let mut predictor = Predictor::new(2);
        for k in 0..9 {
            predictor.push(&[f64::from(k), 1.0]);
        }
        predictor.turn();
        assert_eq!(predictor.predict(), Some(Vector::of(&[8.0, 1.0])));
        assert_eq!(predictor.size(), &[8.0, 1.0]);
    }

    /// The verdict on the last of some determinants, given from the first to the last.
    fn said(determinants: &[f64]) -> Continuation {
        let mut kept = Determinants::UNKNOWN;
        let mut said = Continuation::Fits;
        for &determinant in determinants {
            said = kept.take(Determinant::of(determinant));
            kept.push();
        }
        said
    }

    #[test]
    fn determinants_are_continued() {
        use Continuation::{Departs, Fits, SignChanged};
        // along a parabola
        assert_eq!(said(&[1.0, 1.2, 1.5, 1.9]), Fits);
        assert_eq!(said(&[4.0, 3.0, 2.0, 1.0]), Fits);
        // at zero, the two roots of a pair cannot be distinguished
        assert_eq!(said(&[3.0, 2.0, 1.0, 0.0]), SignChanged);
        // the other root of a pair
        assert_eq!(said(&[1.0, 1.0, 1.0, -1.0]), SignChanged);
        assert_eq!(said(&[1.0, 1.0, -1.0]), SignChanged);
        assert_eq!(said(&[1.0, 1.0, 1.0, 3.0]), Departs);
        // one that has changed by more than itself may have turned back before zero
        assert_eq!(said(&[2.3, 1.6, 1.0, 0.45]), Departs);
        // after a jump, one determinant near the last one is not enough
        assert_eq!(said(&[9.0, 3.0, 1.0, 0.8]), SignChanged);
        // two are
        assert_eq!(said(&[9.0, 3.0, 1.0, 0.8, 0.7]), Fits);
    }

    #[test]
    fn the_past_is_what_was_pushed() {
        let values = [3.0, -1.0, 4.0, 1.0, -5.0, 9.0, 2.0];
        let mut predictor = Predictor::new(1);
        for (count, value) in values.iter().enumerate() {
            predictor.push(&[*value]);
            let past = predictor.past();
            assert_eq!(past.len(), (count + 1).min(PAST));
            for (k, found) in past.iter().enumerate() {
                assert!((found[0] - values[count - k]).abs() < 1e-12, "{past:?}");
            }
        }
    }

    #[test]
    fn what_is_foreseen_is_near_the_prediction() {
        let mut predictor = Predictor::new(2);
        assert!(!predictor.is_near_prediction(&[1.0, 1.0], 0.1));
        for _ in 0..6 {
            predictor.push(&[1.0, 2.0]);
        }
        assert!(predictor.is_near_prediction(&[1.05, 2.1], 0.1));
        assert!(!predictor.is_near_prediction(&[1.05, 2.4], 0.1));
        assert!(!predictor.is_near_prediction(&[f64::NAN, 2.0], 0.1));
    }
}
