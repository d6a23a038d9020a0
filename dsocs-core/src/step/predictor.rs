//! Where Newton's iteration begins: a polynomial through the last solutions.

use core::marker::PhantomData;

use super::convergence::{NaturalSizes, Remembered};
use super::elimination::Determinant;
use super::newton::Notes;
use super::unknown::Unknown;
use crate::scalar::Scalar;

/// The highest degree of the polynomial.
const ORDER: usize = 5;

/// How much of the size of past unknowns is remembered from one step to the next.
const MEMORY: f64 = 0.75;

/// The backward differences of the last solutions, and their size.
///
/// A smooth motion is predicted with degree 5. Where the motion is not smooth on the scale of the step (a
/// switch is crossed, a phase turns several radians a step) differences grow with their order, and the degree
/// falls, down to the last solution itself.
#[repr(align(16))] // as the sums, see [`crate::compensated`]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Predictor<U, T = f64> {
    /// `∇⁰z, ∇¹z, … ∇⁵z`; NaN where the history is too short.
    differences: [U; ORDER + 1],
    /// The largest absolute value of each unknown, forgotten at the rate [`MEMORY`].
    size: U,
    /// Their natural sizes, where they were needed lately.
    natural: Option<Remembered<U>>,
    /// The determinants at the last solutions.
    determinants: Determinants,
    /// The numbers that the unknowns are made of.
    scalar: PhantomData<T>,
}

/// The determinants of the rows' Jacobian at the last solutions, the last first, in a common unit; NaN where they are not
/// known.
///
/// Along a motion the determinant changes smoothly. The roots of a pair have Jacobians of opposite orientation, so that where
/// a step goes over to another motion the determinant departs from its continuation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Determinants {
    /// The numbers.
    pub last: [f64; PAST],
    /// The power of two that is their unit.
    pub unit: i32,
    /// That of the step which is being solved.
    pub next: f64,
    /// Whether the last one was nearly that before it, and whether the one which is being solved is nearly the last.
    pub steady: [bool; 2],
}

/// From so many solutions determinants are continued.
pub(crate) const PAST: usize = 4;

/// How far a determinant may be from its continuation, relative to it. That of the other root of a pair is about 2 away.
pub(crate) const FITS: f64 = 0.5;

/// Determinants in a row that differ by no more, relative to themselves, do not depart: a jump to the other root would show.
pub(crate) const STEADY: f64 = 0.25;

/// What a determinant says of the root that a step has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Continuation {
    /// It continues those of the steps before, or nothing is known of these.
    Fits,
    /// It does not.
    Departs,
    /// It does not even have their sign.
    Turned,
}

impl Determinants {
    /// Without a past.
    pub const UNKNOWN: Self = Self {
        last: [f64::NAN; PAST],
        unit: 0,
        next: f64::NAN,
        steady: [false; 2],
    };

    /// Takes the determinant of the step that is being solved.
    #[inline]
    fn take(&mut self, determinant: Determinant) -> Continuation {
        if self.last[0].is_nan() {
            self.unit = determinant.exponent;
        }
        let now = determinant.in_units_of(self.unit);
        self.next = now;
        // false also where there is no past
        self.steady[1] = (self.last[0] - now).abs() <= STEADY * now.abs();
        if self.steady == [true; 2] {
            Continuation::Fits
        } else {
            self.compare(now)
        }
    }

    /// Compares a determinant with the continuations of those of the past, of the first and of the second degree.
    #[inline(never)] // seldom needed: most determinants hardly change from step to step
    pub fn compare(&self, now: f64) -> Continuation {
        let [a, b, c, _] = self.last;
        // as many as are known
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
        // where it has changed by more than itself, it may as well have turned back before zero as have passed it
        let is_clear = (a - now).abs() <= now.abs();
        if is_clear && continued.iter().all(|x| (x - now).abs() <= bound) {
            Continuation::Fits
        } else if continued.iter().all(|x| x * now > 0.0) {
            Continuation::Departs
        } else {
            Continuation::Turned
        }
    }

    /// Puts the determinant taken last among those of the past.
    #[inline]
    fn push(&mut self) {
        self.last = [self.next, self.last[0], self.last[1], self.last[2]];
        (self.next, self.steady) = (f64::NAN, [self.steady[1], false]);
    }
}

impl<T: Scalar, U: Unknown<T>> Predictor<U, T> {
    /// A predictor without a past.
    pub fn new() -> Self {
        let unknown = U::zero();
        Self {
            differences: [unknown.zip(&unknown, |_, _| T::splat(f64::NAN)); ORDER + 1],
            size: unknown,
            natural: None,
            determinants: Determinants::UNKNOWN,
            scalar: PhantomData,
        }
    }

    /// Takes in the solution of a step.
    #[inline]
    pub fn push(&mut self, z: &U) {
        self.push_here(z);
    }

    /// The same as part of its caller, which is compiled for the machine's own instructions.
    #[allow(clippy::inline_always)] // as it says
    #[inline(always)]
    pub fn push_here(&mut self, z: &U) {
        let mut difference = *z;
        for entry in &mut self.differences {
            let last = core::mem::replace(entry, difference);
            difference = difference.zip(&last, |new, old| new - old);
        }
        self.determinants.push();
        self.size = self
            .size
            .zip(z, |size, z| (T::splat(MEMORY) * size).larger(z.abs()));
    }

    /// The size that each unknown has had lately, at least 0.
    #[inline]
    pub fn size(&self) -> &U {
        &self.size
    }

    /// The extrapolated solution of the next step; NaN without a past.
    ///
    /// Each unknown chooses its own degree `p`, the one that makes `max(|∇ᵖz|, |∇ᵖ⁻¹z|)` smallest: two
    /// differences in a row, because one alone may be small by passing through zero.
    #[inline]
    pub fn extrapolate(&self) -> U {
        self.extrapolate_here()
    }

    /// The same as part of its caller, which is compiled for the machine's own instructions.
    #[allow(clippy::inline_always)] // as it says
    #[inline(always)]
    pub fn extrapolate_here(&self) -> U {
        let last = self.differences[0];
        let sizes = last.zip(&last, |z, _| z.abs());
        let (mut guess, mut sum, mut smallest, mut before) = (last, last, sizes, sizes);
        // degree by degree and all unknowns side by side, with selections for branches: this is part of every step
        for difference in &self.differences[1..] {
            let (guess, sum, smallest, before) =
                (guess.as_mut(), sum.as_mut(), smallest.as_mut(), before.as_mut());
            for (place, &difference) in difference.as_ref().iter().enumerate() {
                sum[place] = sum[place] + difference;
                let size = difference.abs();
                // NaN where the history is too short, which is not smaller than anything
                let larger = before[place].larger(size);
                guess[place] = T::select_le(larger, smallest[place], sum[place], guess[place]);
                smallest[place] = larger.smaller(smallest[place]);
                before[place] = size;
            }
        }
        guess
    }

    /// Changes the numbers that the unknowns are made of: `convert` fills the unknowns given first from those
    /// given second.
    #[allow(clippy::inline_always)] // for the machine's own instructions
    #[inline(always)]
    pub fn convert<R: Scalar, V: Unknown<R>>(
        &self,
        into: &mut Predictor<V, R>,
        mut convert: impl FnMut(&mut V, &U),
    ) {
        for (to, from) in into.differences.iter_mut().zip(&self.differences) {
            convert(to, from);
        }
        convert(&mut into.size, &self.size);
    }
}

impl<U: Unknown<f64>> Predictor<U> {
    /// Forgets all but the last solution and the sizes: the past is of no use when the motion turns round.
    pub fn turn(&mut self) {
        let (size, natural, last) = (self.size, self.natural, self.last());
        *self = Self::new();
        if let Some(last) = last {
            self.push(&last);
        }
        (self.size, self.natural) = (size, natural);
    }

    /// How large each unknown is expected to be: as lately, at least as `least` says, and not too small to be known.
    #[inline]
    pub fn expected(&self, least: &U) -> U {
        let size = self.size.zip(least, f64::max);
        match &self.natural {
            None => size,
            Some(natural) => natural.raise(&size, &self.size),
        }
    }

    /// Takes the determinant at the solution of the step that is being made: whether it continues those before.
    #[inline]
    pub fn take_determinant(&mut self, determinant: Determinant) -> Continuation {
        self.determinants.take(determinant)
    }

    /// The determinants at the last solutions.
    pub fn determinants(&self) -> &Determinants {
        &self.determinants
    }

    /// The same with other determinants.
    pub fn with_determinants(self, determinants: Determinants) -> Self {
        Self { determinants, ..self }
    }

    /// The natural sizes of the unknowns, where they were needed lately.
    pub fn natural(&self) -> Option<&Remembered<U>> {
        self.natural.as_ref()
    }

    /// The same with other natural sizes.
    pub fn with_natural(self, natural: Option<Remembered<U>>) -> Self {
        Self { natural, ..self }
    }

    /// The last solution.
    pub fn last(&self) -> Option<U> {
        let last = self.differences[0];
        last.as_ref().iter().all(|z| !z.is_nan()).then_some(last)
    }

    /// The last solutions, [`PAST`] at most, the last first.
    pub fn past(&self) -> Vec<U> {
        let mut differences = self.differences;
        let mut solutions = Vec::with_capacity(PAST);
        for k in 0..PAST {
            // one step back: each difference loses the next one
            let known = if k == 0 { 0 } else { (ORDER + 1).saturating_sub(k) };
            for place in 0..known {
                differences[place] =
                    differences[place].zip(&differences[place + 1], |now, change| now - change);
            }
            solutions.push(differences[0]);
        }
        solutions.retain(|z| z.as_ref().iter().all(|z| !z.is_nan()));
        solutions
    }

    /// The extrapolated solution of the next step, or `None` without a past.
    #[allow(clippy::inline_always)] // part of every step, and called where steps fail, too
    #[inline(always)]
    pub fn predict(&self) -> Option<U> {
        self.last()?;
        Some(self.extrapolate())
    }
}

impl<U: Unknown<f64>> Predictor<U> {
    /// Whether the prediction of a solution is off by no more than a part of it, unknown by unknown; not where there is no past.
    #[inline]
    pub fn foresees(&self, z: &U, part: f64) -> bool {
        let guess = self.extrapolate();
        let unknowns = z.as_ref().iter().zip(guess.as_ref());
        // false for a NaN
        unknowns
            .into_iter()
            .all(|(z, guess)| (z - guess).abs() <= part * z.abs())
    }
}

impl<U: Unknown<f64>> Notes<U> for Predictor<U> {
    fn natural_sizes(&mut self, sizes: &NaturalSizes<U>) {
        self.natural = Some(Remembered::new(sizes));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_turns_round_forgets_its_past_and_no_size() {
        let mut predictor: Predictor<[f64; 2]> = Predictor::new();
        for k in 0..8 {
            predictor.push(&[f64::from(k), 1e-3]);
        }
        predictor.push(&[-3.0, 1e-3]);
        predictor.natural_sizes(&NaturalSizes {
            sizes: [1.0, 2.0],
            condition: 3.0,
            level: 4.0,
        });
        let size = *predictor.size();
        assert!(size[0] > 3.0, "{size:?}");
        let expected = predictor.expected(&[0.0; 2]);
        predictor.turn();
        assert_eq!(
            (predictor.past(), predictor.last()),
            (vec![[-3.0, 1e-3]], Some([-3.0, 1e-3]))
        );
        assert_eq!(*predictor.size(), size);
        assert!(predictor.natural().is_some());
        assert_eq!(predictor.expected(&[0.0; 2]), expected);
    }

    #[test]
    fn polynomials_up_to_the_fifth_degree_are_exact() {
        for degree in 0..=5 {
            let value = |k: i32| [f64::from(k).powi(degree), 1.0];
            let mut predictor = Predictor::new();
            assert_eq!(predictor.predict(), None);
            for k in 0..12 {
                predictor.push(&value(k - 6));
            }
            assert_eq!(predictor.predict(), Some(value(6)), "degree {degree}");
        }
    }

    #[test]
    fn a_rotation_is_predicted_at_every_phase() {
        let mut predictor = Predictor::new();
        let mut worst: f64 = 0.0;
        for k in 0..2000 {
            let phase = f64::from(k) * 0.01;
            if k > 6 {
                let guess: [f64; 1] = predictor.predict().unwrap();
                worst = worst.max((guess[0] - phase.sin()).abs());
            }
            predictor.push(&[phase.sin()]);
        }
        assert!(worst < 1e-11, "{worst:e}");
    }

    #[test]
    fn noise_is_not_blown_up() {
        let mut predictor = Predictor::new();
        let (mut seed, mut worst) = (1_u32, 0.0_f64);
        for _ in 0..1000 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            predictor.push(&[f64::from(seed) / f64::from(u32::MAX) - 0.5]);
            let guess: [f64; 1] = predictor.predict().unwrap();
            worst = worst.max(guess[0].abs());
        }
        assert!(worst < 5.0, "{worst}");
    }

    #[test]
    fn turning_keeps_the_last_solution_only() {
        let mut predictor = Predictor::new();
        for k in 0..9 {
            predictor.push(&[f64::from(k), 1.0]);
        }
        predictor.turn();
        assert_eq!(predictor.predict(), Some([8.0, 1.0]));
        assert_eq!(predictor.size(), &[8.0, 1.0]);
    }

    /// What is said of the last of some determinants, the first first.
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
        use Continuation::{Departs, Fits, Turned};
        // as a parabola goes
        assert_eq!(said(&[1.0, 1.2, 1.5, 1.9]), Fits);
        assert_eq!(said(&[4.0, 3.0, 2.0, 1.0]), Fits);
        // at zero nothing tells the two roots of a pair
        assert_eq!(said(&[3.0, 2.0, 1.0, 0.0]), Turned);
        // the other root of a pair
        assert_eq!(said(&[1.0, 1.0, 1.0, -1.0]), Turned);
        assert_eq!(said(&[1.0, 1.0, -1.0]), Turned);
        assert_eq!(said(&[1.0, 1.0, 1.0, 3.0]), Departs);
        // one that has changed by more than itself may have turned back before zero
        assert_eq!(said(&[2.3, 1.6, 1.0, 0.45]), Departs);
        // after a jump one determinant that is near the last one says nothing
        assert_eq!(said(&[9.0, 3.0, 1.0, 0.8]), Turned);
        // two do
        assert_eq!(said(&[9.0, 3.0, 1.0, 0.8, 0.7]), Fits);
    }

    #[test]
    fn the_past_is_what_was_pushed() {
        let values = [3.0, -1.0, 4.0, 1.0, -5.0, 9.0, 2.0];
        let mut predictor = Predictor::new();
        for (count, value) in values.iter().enumerate() {
            predictor.push(&[*value]);
            let past = predictor.past();
            assert_eq!(past.len(), (count + 1).min(PAST));
            for (k, [found]) in past.iter().enumerate() {
                assert!((found - values[count - k]).abs() < 1e-12, "{past:?}");
            }
        }
    }

    #[test]
    fn what_is_foreseen_is_near_the_prediction() {
        let mut predictor = Predictor::new();
        assert!(!predictor.foresees(&[1.0, 1.0], 0.1));
        for _ in 0..6 {
            predictor.push(&[1.0, 2.0]);
        }
        assert!(predictor.foresees(&[1.05, 2.1], 0.1));
        assert!(!predictor.foresees(&[1.05, 2.4], 0.1));
        assert!(!predictor.foresees(&[f64::NAN, 2.0], 0.1));
    }
}
