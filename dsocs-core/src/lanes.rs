//! Eight numbers side by side, and masks of them.

use core::fmt;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use wide::{f64x8, u64x8};

use crate::scalar::Scalar;

mod functions;
#[cfg(test)]
mod tests;

/// How many numbers lie side by side.
pub(crate) const LANES: usize = 8;

/// Eight real numbers, one for each of eight trajectories that the generated code steps at once.
///
/// Arithmetic, roots and comparisons are those of `f64`, bit for bit. So are the functions that are not
/// listed here; they go through `f64`'s, lane by lane. The following have vector code of their own. Where an
/// argument is outside of the range, that lane goes through `f64`'s function.
///
/// | function | range of the vector code | error, in units in the last place |
/// |---|---|---|
/// | `sin`, `cos` | `\|x\| ≤ 10⁶` | below 1 |
/// | `exp` | `\|x\| ≤ 708` | below 1 |
/// | `exp_m1` | `\|x\| ≤ 708` | below 2 |
/// | `tanh` | all | below 2.5 |
///
/// A lane's result never depends on what the other lanes hold.
///
/// ```
/// use dsocs_core::__private::{Lanes, Scalar};
///
/// let x = Lanes::from([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, f64::INFINITY]);
/// let y = x.tanh() + Lanes::splat(1.0);
/// assert_eq!(y.lane(0), 1.0);
/// assert_eq!(y.lane(7), 2.0);
/// ```
#[derive(Clone, Copy, PartialEq)]
pub struct Lanes(f64x8);

impl From<[f64; LANES]> for Lanes {
    #[inline]
    fn from(lanes: [f64; LANES]) -> Self {
        Self(f64x8::new(lanes))
    }
}

impl From<Lanes> for [f64; LANES] {
    #[inline]
    fn from(lanes: Lanes) -> Self {
        lanes.0.to_array()
    }
}

impl fmt::Debug for Lanes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Lanes").field(self.0.as_array()).finish()
    }
}

/// For each lane, whether something holds there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask(f64x8);

impl Mask {
    /// The lanes whose bits are set, lane 0 in the lowest.
    pub fn from_bits(bits: u32) -> Self {
        let lanes = core::array::from_fn(|lane| if bits >> lane & 1 == 1 { u64::MAX } else { 0 });
        Self(f64x8::from_bits(u64x8::new(lanes)))
    }

    /// One bit a lane, lane 0 in the lowest.
    #[inline]
    pub fn bits(self) -> u32 {
        self.0.to_bitmask()
    }

    /// `then` in the lanes where the mask holds, `otherwise` in the others.
    #[inline]
    pub fn select(self, then: Lanes, otherwise: Lanes) -> Lanes {
        Lanes(self.0.select(then.0, otherwise.0))
    }
}

impl BitAnd for Mask {
    type Output = Self;

    #[inline]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask {
    type Output = Self;

    #[inline]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Lanes {
    /// Where `self < other`; nowhere where either is NaN.
    #[inline]
    pub(crate) fn below(self, other: Self) -> Mask {
        Mask(self.0.simd_lt(other.0))
    }

    /// Where `self <= other`; nowhere where either is NaN.
    #[inline]
    pub(crate) fn at_most(self, other: Self) -> Mask {
        Mask(self.0.simd_le(other.0))
    }

    /// Where the number is neither infinite nor NaN.
    #[inline]
    pub(crate) fn finite(self) -> Mask {
        self.abs().below(Self::splat(f64::INFINITY))
    }

    /// Puts a number into one lane.
    #[inline]
    pub(crate) fn set_lane(&mut self, lane: usize, value: f64) {
        self.0.as_mut_array()[lane] = value;
    }

    /// The bit patterns.
    #[inline]
    fn bits(self) -> u64x8 {
        self.0.to_bits()
    }

    /// The numbers with given bit patterns.
    #[inline]
    fn from_bits(bits: u64x8) -> Self {
        Self(f64x8::from_bits(bits))
    }

    /// A function of `f64`, lane by lane.
    #[inline]
    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        Self(f64x8::new(self.0.to_array().map(function)))
    }

    /// The same for two arguments.
    #[inline]
    fn each_pair(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let (left, right) = (self.0.to_array(), other.0.to_array());
        Self(f64x8::new(core::array::from_fn(|i| function(left[i], right[i]))))
    }
}

macro_rules! operator {
    ($($operator:ident $method:ident),* $(,)?) => {
        $(
            impl $operator for Lanes {
                type Output = Self;

                #[inline]
                fn $method(self, other: Self) -> Self {
                    Self($operator::$method(self.0, other.0))
                }
            }
        )*
    };
}

operator!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Lanes {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! lane_by_lane {
    ($($name:ident),* $(,)?) => {
        $(
            fn $name(self) -> Self {
                self.each(f64::$name)
            }
        )*
    };
}

impl Scalar for Lanes {
    const LANES: usize = LANES;

    #[inline]
    fn splat(value: f64) -> Self {
        Self(f64x8::splat(value))
    }

    #[inline]
    fn lane(self, lane: usize) -> f64 {
        self.0.as_array()[lane]
    }

    #[inline]
    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        let mut results = [[0.0; LANES]; P];
        for lane in 0..LANES {
            for (result, value) in results.iter_mut().zip(function(lane)) {
                result[lane] = value;
            }
        }
        results.map(Self::from)
    }

    #[inline]
    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        left.below(right).select(then, otherwise)
    }

    #[inline]
    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        left.at_most(right).select(then, otherwise)
    }

    // the instructions of this architecture give their second operand where either is NaN
    #[cfg(target_arch = "x86_64")]
    #[inline]
    fn larger(self, other: Self) -> Self {
        Self(self.0.fast_max(other.0))
    }

    #[cfg(target_arch = "x86_64")]
    #[inline]
    fn smaller(self, other: Self) -> Self {
        Self(self.0.fast_min(other.0))
    }

    #[inline]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline]
    fn signum(self) -> Self {
        self.each(f64::signum)
    }

    #[inline]
    fn recip(self) -> Self {
        Self::splat(1.0) / self
    }

    #[inline]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    fn exp(self) -> Self {
        functions::exp(self)
    }

    fn exp_m1(self) -> Self {
        functions::exp_m1(self)
    }

    fn sin(self) -> Self {
        functions::sin(self)
    }

    fn cos(self) -> Self {
        functions::cos(self)
    }

    fn tanh(self) -> Self {
        functions::tanh(self)
    }

    lane_by_lane!(
        cbrt, ln, ln_1p, tan, asin, acos, atan, sinh, cosh, asinh, acosh, atanh
    );

    fn powf(self, exponent: Self) -> Self {
        self.each_pair(exponent, f64::powf)
    }

    #[inline]
    fn powi(self, exponent: i32) -> Self {
        // by squares, as `f64::powi` goes
        let (mut result, mut square, mut left) = (Self::splat(1.0), self, exponent.unsigned_abs());
        loop {
            if left & 1 == 1 {
                result = result * square;
            }
            left >>= 1;
            if left == 0 {
                break;
            }
            square = square * square;
        }
        if exponent < 0 { result.recip() } else { result }
    }

    fn atan2(self, x: Self) -> Self {
        self.each_pair(x, f64::atan2)
    }
}
