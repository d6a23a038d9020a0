//! Coefficients with derivatives in several directions.

// parts of every operation of the recurrences
#![allow(clippy::inline_always)]

use core::array;
use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::number::scalar::Scalar;
use crate::number::tangent::{PLACES, Tangent};
use crate::series::coefficient::Coefficient;
use crate::solve::elimination;

/// Number of directions that are computed together.
pub(super) const DIRECTIONS: usize = 4;

/// A number and its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// The number.
    pub value: f64,
    /// The derivatives.
    pub by: [f64; DIRECTIONS],
}

impl Moved {
    /// A function's value, and its derivatives by the chain rule. Zero derivatives stay zero, also where the
    /// slope is infinite.
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self {
            value,
            by: self.by.map(|by| if by == 0.0 { 0.0 } else { by * slope }),
        }
    }

    /// A function whose slope comes from dual numbers.
    #[inline]
    fn function(self, function: impl Fn(Tangent) -> Tangent) -> Self {
        let result = function(Tangent::new(self.value, 1.0));
        self.chain(result.value(), result.derivative())
    }

    /// A function of two arguments.
    fn pair(self, other: Self, function: impl Fn(Tangent, Tangent) -> Tangent) -> Self {
        let still = |x: f64| Tangent::new(x, 0.0);
        let left = function(Tangent::new(self.value, 1.0), still(other.value));
        let right = function(still(self.value), Tangent::new(other.value, 1.0));
        self.chain(left.value(), left.derivative()) + other.chain(0.0, right.derivative())
    }
}

impl Add for Moved {
    type Output = Self;

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self.value += other.value;
        for (by, other) in self.by.iter_mut().zip(other.by) {
            *by += other;
        }
        self
    }
}

impl Sub for Moved {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Moved {
    type Output = Self;

    #[inline(always)]
    fn neg(mut self) -> Self {
        self.value = -self.value;
        for by in &mut self.by {
            *by = -*by;
        }
        self
    }
}

impl Mul for Moved {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for (by, other_by) in self.by.iter_mut().zip(other.by) {
            *by = *by * other.value + self.value * other_by;
        }
        self.value *= other.value;
        self
    }
}

impl Div for Moved {
    type Output = Self;

    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        let quotient = self.value / other.value;
        for (by, other_by) in self.by.iter_mut().zip(other.by) {
            *by = (*by - quotient * other_by) / other.value;
        }
        self.value = quotient;
        self
    }
}

macro_rules! functions {
    ($($name:ident),* $(,)?) => {
        $(
            fn $name(self) -> Self {
                self.function(Scalar::$name)
            }
        )*
    };
}

impl Scalar for Moved {
    const LANES: usize = 1;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self {
            value,
            by: [0.0; DIRECTIONS],
        }
    }

    /// The number itself in lane 0; the others are those of [`Tangent`], direction by direction.
    fn lane(self, lane: usize) -> f64 {
        Tangent::new(self.value, self.by[lane / PLACES]).lane(lane % PLACES)
    }

    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        let mut results = [Self::splat(0.0); P];
        for direction in 0..DIRECTIONS {
            let moved = Tangent::<f64>::from_lanes(|place| function(direction * PLACES + place));
            for (result, moved) in results.iter_mut().zip(moved) {
                result.value = moved.value();
                result.by[direction] = moved.derivative();
            }
        }
        results
    }

    #[inline(always)]
    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.value < right.value { then } else { otherwise }
    }

    #[inline(always)]
    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.value <= right.value {
            then
        } else {
            otherwise
        }
    }

    functions!(
        abs, signum, recip, sqrt, cbrt, exp, exp_m1, ln, ln_1p, sin, cos, tan, asin, acos, atan, sinh, cosh,
        tanh, asinh, acosh, atanh,
    );

    fn powf(self, exponent: Self) -> Self {
        if exponent.by == [0.0; DIRECTIONS] {
            let exponent = Tangent::new(exponent.value, 0.0);
            return self.function(|x| x.powf(exponent));
        }
        self.pair(exponent, Scalar::powf)
    }

    fn powi(self, exponent: i32) -> Self {
        self.function(|x| x.powi(exponent))
    }

    fn atan2(self, x: Self) -> Self {
        self.pair(x, Scalar::atan2)
    }
}

impl Coefficient for Moved {
    const TRACKS: usize = 1;
    const AGAIN: u32 = 1;

    #[inline(always)]
    fn track(self, _: usize) -> f64 {
        self.value
    }

    #[inline(always)]
    fn of_tracks(mut number: impl FnMut(usize) -> f64) -> Self {
        Self::splat(number(0))
    }

    /// The derivative of the inverse `X` of a matrix `A` is `-X A' X`.
    fn inverse<const FUSED: bool, const M: usize>(matrix: &[[Self; M]; M]) -> ([[Self; M]; M], Self) {
        // by columns
        let (inverse, sign) = elimination::inverse::<false, M>(&matrix.map(|row| row.map(|x| x.value)));
        let mut result = inverse.map(|column| column.map(Self::splat));
        for direction in 0..DIRECTIONS {
            // A' X, by columns
            let moved: [[f64; M]; M] = array::from_fn(|j| {
                array::from_fn(|i| (0..M).map(|k| matrix[i][k].by[direction] * inverse[j][k]).sum())
            });
            for (result, moved) in result.iter_mut().zip(moved) {
                for (i, x) in result.iter_mut().enumerate() {
                    x.by[direction] = -(0..M).map(|k| inverse[k][i] * moved[k]).sum::<f64>();
                }
            }
        }
        (result, Self::splat(sign))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two numbers that move in different directions.
    fn two() -> [Moved; 2] {
        let mut two = [0.7, 1.9].map(Moved::splat);
        (two[0].by[0], two[1].by[2]) = (1.0, 1.0);
        (two[0].by[3], two[1].by[3]) = (0.5, -2.0);
        two
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let functions: [fn([Moved; 2]) -> Moved; 9] = [
            |[x, y]| x * y - x / y,
            |[x, y]| (x * y).sin() + y.cos().exp(),
            |[x, y]| x.powf(y),
            |[x, y]| x.atan2(y) + x.powi(3),
            |[x, y]| x.powf(Moved::splat(2.5)) * y.sqrt(),
            |[x, y]| (x + y).tanh() * (x - y).abs(),
            |[x, y]| Moved::inverse::<false, 2>(&[[x, y], [y, x * x]]).0[0][0],
            |[x, y]| Moved::inverse::<false, 2>(&[[x, y], [y * y, x * x]]).0[0][1],
            |[x, y]| Moved::from_lanes(|lane| [x.lane(lane) * y.lane(lane).ln()])[0],
        ];
        for (place, function) in functions.iter().enumerate() {
            let exact = function(two());
            for direction in 0..DIRECTIONS {
                let moved = |by: f64| {
                    let moved = two().map(|x| Moved::splat(x.value + by * x.by[direction]));
                    function(moved).value
                };
                let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                let found = exact.by[direction];
                assert!((difference - found).abs() < 1e-8, "{place}: {difference} {found}");
            }
        }
    }

    #[test]
    fn what_does_not_move_has_no_infinite_slope() {
        let root = Moved::splat(0.0).sqrt();
        assert_eq!((root.value, root.by), (0.0, [0.0; DIRECTIONS]));
    }
}
