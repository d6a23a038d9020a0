//! What the next step of a block depends on, and how a lane of it is exchanged with a flow.

// loaded into registers and stored in code that is compiled for them, see [`crate::instructions`]
#![allow(clippy::inline_always)]

use wide::f64x8;

use super::determinants::Determinants;
use crate::compensated::Compensated;
use crate::lanes::{Lanes, Mask, Register};
use crate::scalar::Scalar;
use crate::step::convergence::Remembered;
use crate::step::course::Course;
use crate::step::predictor::Differences;
use crate::step::unknown::Unknown;

/// What the next step depends on.
#[derive(Clone, Copy)]
pub(super) struct Now<U, R, const N: usize> {
    /// The last nodes.
    pub q: Compensated<N, Lanes<R>>,
    /// The increments that led to them.
    pub d: Compensated<N, Lanes<R>>,
    /// The past solutions.
    pub predictor: Differences<U, Lanes<R>>,
    /// The determinants there.
    pub determinants: Determinants<R>,
    /// The natural sizes of the unknowns.
    natural: Natural<U, R>,
}

/// What a step has found.
#[derive(Clone, Copy)]
pub(super) struct Found<U, R, const N: usize> {
    /// The third nodes.
    pub q: Compensated<N, Lanes<R>>,
    /// The increments that lead to them.
    pub d: Compensated<N, Lanes<R>>,
    /// The solutions.
    pub z: U,
}

/// The natural sizes of the unknowns, in the lanes where they were needed lately: the rules of [`Remembered`].
#[derive(Clone, Copy)]
struct Natural<U, R> {
    /// The lanes, as bits.
    known: u32,
    /// The part of the sizes that counts.
    part: U,
    /// The inverse of the sizes.
    inverse: U,
    /// How large the unknowns were in units of them.
    level: Lanes<R>,
}

impl<R: Register, U: Unknown<Lanes<R>>> Natural<U, R> {
    /// Sizes that are not too small to be known, where the unknowns have lately been as large as `lately` says.
    #[inline(always)]
    fn raise(&self, sizes: U, lately: &U) -> U {
        if self.known == 0 {
            return sizes;
        }
        let mut level = Lanes::splat(0.0);
        for (z, &inverse) in lately.as_ref().iter().zip(self.inverse.as_ref()) {
            level = level.larger(z.abs() * inverse);
        }
        let grown = level.larger(Lanes::splat(1.0));
        let factor = Lanes::select_lt(level, self.level, level / self.level, grown);
        let known = Mask::from_bits(self.known);
        let mut raised = sizes;
        for (size, &part) in raised.as_mut().iter_mut().zip(self.part.as_ref()) {
            *size = known.select(size.larger(factor * part), *size);
        }
        raised
    }
}

impl<R: Register, U: Unknown<Lanes<R>>, const N: usize> Now<U, R, N> {
    /// Without a past.
    pub fn new() -> Self {
        let zero = Compensated::exact([Lanes::splat(0.0); N]);
        Self {
            q: zero,
            d: zero,
            predictor: Differences::new(),
            determinants: Determinants::new(),
            natural: Natural {
                known: 0,
                part: U::zero(),
                inverse: U::zero(),
                level: Lanes::splat(0.0),
            },
        }
    }

    /// How large each unknown is expected to be: as lately, at least as `least` says, and not too small to be known.
    #[inline(always)]
    pub fn expected(&self, least: &U) -> U {
        let lately = self.predictor.size();
        self.natural.raise(lately.zip(least, Scalar::larger), lately)
    }

    /// Takes a step.
    #[inline(always)]
    pub fn take(&mut self, found: &Found<U, R, N>) {
        (self.q, self.d) = (found.q, found.d);
        self.predictor.push_here(&found.z);
        self.determinants.push();
    }

    /// The same in other registers.
    #[inline(always)]
    pub fn moved<Q: Register, V: Unknown<Lanes<Q>>>(&self) -> Now<V, Q, N> {
        let mut now = Now::<V, Q, N>::new();
        now.q = moved_sums(&self.q);
        now.d = moved_sums(&self.d);
        self.predictor
            .convert(&mut now.predictor, |to, from| *to = moved_unknown(from));
        now.determinants = self.determinants.moved();
        now.natural = Natural {
            known: self.natural.known,
            part: moved_unknown(&self.natural.part),
            inverse: moved_unknown(&self.natural.inverse),
            level: self.natural.level.moved(),
        };
        now
    }
}

impl<R: Register, U: Unknown<Lanes<R>>, const N: usize> Found<U, R, N> {
    /// The same in other registers.
    #[inline(always)]
    pub fn moved<Q: Register, V: Unknown<Lanes<Q>>>(&self) -> Found<V, Q, N> {
        Found {
            q: moved_sums(&self.q),
            d: moved_sums(&self.d),
            z: moved_unknown(&self.z),
        }
    }
}

/// Unknowns in other registers.
#[inline(always)]
fn moved_unknown<R: Register, Q: Register, U: Unknown<Lanes<R>>, V: Unknown<Lanes<Q>>>(from: &U) -> V {
    let mut to = V::zero();
    for (to, from) in to.as_mut().iter_mut().zip(from.as_ref()) {
        *to = from.moved();
    }
    to
}

/// Sums in other registers.
#[inline(always)]
fn moved_sums<R: Register, Q: Register, const N: usize>(
    from: &Compensated<N, Lanes<R>>,
) -> Compensated<N, Lanes<Q>> {
    let mut to = Compensated::exact([Lanes::splat(0.0); N]);
    for i in 0..N {
        to.hi[i] = from.hi[i].moved();
        to.lo[i] = from.lo[i].moved();
    }
    to
}

/// What a block keeps between its steps, whatever their registers are.
impl<U: Unknown<Lanes>, const N: usize> Now<U, f64x8, N> {
    /// Puts what one lane holds into a run.
    pub fn put(&self, lane: usize, course: &mut Course) {
        for (sums, one) in [(&self.q, &mut course.q), (&self.d, &mut course.d)] {
            let parts = one.hi.iter_mut().zip(one.lo.iter_mut()).enumerate();
            for (i, (hi, lo)) in parts {
                (*hi, *lo) = (sums.hi[i].lane(lane), sums.lo[i].lane(lane));
            }
        }
        let predictor = &mut course.predictor;
        for (place, vector) in self.predictor.vectors().enumerate() {
            for (i, x) in vector.as_ref().iter().enumerate() {
                predictor.set(place, i, x.lane(lane));
            }
        }
        predictor.determinants = self.determinants.lane(lane);
        let one = |from: &U| from.as_ref().iter().map(|x| x.lane(lane)).collect();
        let natural = (self.natural.known >> lane & 1 == 1).then(|| Remembered {
            part: one(&self.natural.part),
            inverse: one(&self.natural.inverse),
            level: self.natural.level.lane(lane),
        });
        predictor.set_natural(natural);
    }

    /// Fills one lane with what a run holds.
    pub fn set_lane(&mut self, lane: usize, course: &Course) {
        let fill = |to: &mut U, from: &[f64]| {
            for (to, from) in to.as_mut().iter_mut().zip(from) {
                to.set_lane(lane, *from);
            }
        };
        let predictor = &course.predictor;
        let unknowns = predictor.size().len();
        self.determinants
            .set_lane(lane, &predictor.determinants, unknowns);
        for (sums, one) in [(&mut self.q, &course.q), (&mut self.d, &course.d)] {
            for (i, (hi, lo)) in one.hi.iter().zip(one.lo.iter()).enumerate() {
                sums.hi[i].set_lane(lane, *hi);
                sums.lo[i].set_lane(lane, *lo);
            }
        }
        for (to, from) in self.predictor.vectors_mut().zip(predictor.vectors()) {
            fill(to, from);
        }
        self.natural.known &= !(1 << lane);
        if let Some(natural) = predictor.natural() {
            self.natural.known |= 1 << lane;
            fill(&mut self.natural.part, &natural.part);
            fill(&mut self.natural.inverse, &natural.inverse);
            self.natural.level.set_lane(lane, natural.level);
        }
    }
}
