//! The types of a Taylor series' coefficients.

use crate::number::fours::{OnFours, OneByOne, on_doubles};
use crate::number::lanes::{LANES, Lanes, Register};
use crate::number::scalar::Scalar;
use crate::solve::elimination;

/// A number, or several: the recurrences of a system are the same code for all types.
///
/// A *track* is one motion. Each has its own switches and its own records of the user's functions.
pub trait Coefficient: Scalar {
    /// The number of motions in one value.
    const TRACKS: usize;

    /// Whether four coefficients fill a register together. If a single coefficient fills registers, none is
    /// computed just to fill one.
    const PACKED: bool = false;

    /// Number of repetitions of a converged iteration until the quantities that depend on it have converged,
    /// too.
    const AGAIN: u32 = 0;

    /// The number of one motion.
    fn track(self, track: usize) -> f64;

    /// The number of each motion.
    fn of_tracks(number: impl FnMut(usize) -> f64) -> Self;

    /// `self + a b`, rounded once if `FUSED` and if there are such instructions for it.
    #[inline(always)]
    #[must_use]
    fn add_product<const FUSED: bool>(self, a: Self, b: Self) -> Self {
        self + a * b
    }

    /// Does work on rows of four.
    #[doc(hidden)]
    #[inline(always)]
    fn on_fours<const FUSED: bool, W: OnFours<Self>>(work: W) -> W::Output {
        work.run(OneByOne(Self::add_product::<FUSED>))
    }

    /// Sine and cosine, of radians.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }

    /// The inverse of a matrix, by columns, and the sign of its determinant; NaN where it is singular.
    fn inverse<const FUSED: bool, const M: usize>(matrix: &[[Self; M]; M]) -> ([[Self; M]; M], Self);
}

impl Coefficient for f64 {
    const TRACKS: usize = 1;
    const PACKED: bool = true;

    #[inline(always)]
    fn track(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn of_tracks(mut number: impl FnMut(usize) -> f64) -> Self {
        number(0)
    }

    #[inline(always)]
    fn add_product<const FUSED: bool>(self, a: Self, b: Self) -> Self {
        if FUSED { a.mul_add(b, self) } else { self + a * b }
    }

    #[inline(always)]
    fn on_fours<const FUSED: bool, W: OnFours<Self>>(work: W) -> W::Output {
        on_doubles::<FUSED, W>(work)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }

    #[inline(always)]
    fn inverse<const FUSED: bool, const M: usize>(matrix: &[[Self; M]; M]) -> ([[Self; M]; M], Self) {
        elimination::inverse::<FUSED, M>(matrix)
    }
}

// nothing is fused: the bits are the same with all instructions
impl<R: Register> Coefficient for Lanes<R> {
    const TRACKS: usize = LANES;

    #[inline(always)]
    fn track(self, track: usize) -> f64 {
        self.lane(track)
    }

    #[inline(always)]
    fn of_tracks(mut number: impl FnMut(usize) -> f64) -> Self {
        // no closures within closures: they would not be compiled for the registers
        let mut lanes = [0.0; LANES];
        for (lane, value) in lanes.iter_mut().enumerate() {
            *value = number(lane);
        }
        Self::from(lanes)
    }

    // not inlined: elimination is long, and gains nothing from registers
    #[inline(never)]
    fn inverse<const FUSED: bool, const M: usize>(matrix: &[[Self; M]; M]) -> ([[Self; M]; M], Self) {
        let (mut columns, mut signs) = ([[Self::splat(0.0); M]; M], Self::splat(0.0));
        for lane in 0..LANES {
            let matrix = matrix.map(|row| row.map(|x| x.lane(lane)));
            let (inverse, sign) = elimination::inverse::<false, M>(&matrix);
            signs.set_lane(lane, sign);
            for (column, inverse) in columns.iter_mut().zip(inverse) {
                for (x, inverse) in column.iter_mut().zip(inverse) {
                    x.set_lane(lane, inverse);
                }
            }
        }
        (columns, signs)
    }
}
