//! Numbers of twice the precision of `f64`, as unevaluated sums of two: about 32 digits.
//!
//! T. J. Dekker, *A floating-point technique for extending the available precision*, Numerische Mathematik 18
//! (1971). Only the operations that scenes need are implemented.

use core::f64::consts::FRAC_2_PI;
use core::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::LazyLock;

use dsocs_core::__private::Scalar;

use super::number::Number;

/// A sum `high + low` with `|low|` at most half a unit in the last place of `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Double {
    /// The number, rounded.
    pub high: f64,
    /// The rounding error of `high`.
    pub low: f64,
}

/// `π/2` in three parts.
const HALF_PI: [f64; 3] = [
    core::f64::consts::FRAC_PI_2,
    6.123_233_995_736_766e-17,
    -1.497_384_904_859_169_8e-33,
];

/// The relative rounding error of operations, `2⁻¹⁰²`: four units of the place after the last.
pub const PRECISION: f64 = 1.0 / (1_u128 << 102) as f64;

/// Terms of the series of sine and cosine, for arguments of at most `π/4`.
const TERMS: u32 = 30;

/// Terms of the cosine below this one change nothing: they are at most `2⁻¹¹⁰` of the sums.
const LAST: f64 = 1.0 / (1_u128 << 110) as f64;

/// The factors by which a term of the cosine and one of the sine are less than those before, besides the
/// square of the argument: `1/k(k+1)` and `1/(k+1)(k+2)` for odd `k`. To divide anew at each term would take
/// two thirds of all the time of random scenes.
static PARTS: LazyLock<Vec<[Double; 2]>> = LazyLock::new(|| {
    let part = |product: f64| Double::exact(1.0) / Double::exact(product);
    (1..TERMS)
        .step_by(2)
        .map(f64::from)
        .map(|k| [part(k * (k + 1.0)), part((k + 1.0) * (k + 2.0))])
        .collect()
});

impl Double {
    /// Zero.
    pub const ZERO: Self = Self::exact(0.0);

    /// A number of single precision, exactly.
    #[must_use]
    pub const fn exact(high: f64) -> Self {
        Self { high, low: 0.0 }
    }

    /// The sum of two single numbers with `|a| ≥ |b|`, exactly.
    fn ordered(a: f64, b: f64) -> Self {
        let high = a + b;
        Self {
            high,
            low: b - (high - a),
        }
    }

    /// The sum of two single numbers, exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let part = high - a;
        Self {
            high,
            low: (a - (high - part)) + (b - part),
        }
    }
}

impl Add for Double {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        let rest = Self::sum(self.low, other.low);
        let sum = Self::ordered(sum.high, sum.low + rest.high);
        Self::ordered(sum.high, sum.low + rest.low)
    }
}

impl Neg for Double {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for Double {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let low = self.high.mul_add(other.high, -high);
        Self::ordered(high, low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Double {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * Self::exact(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::exact(second);
        Self::ordered(first, second) + Self::exact(rest.high / other.high)
    }
}

impl From<f64> for Double {
    fn from(value: f64) -> Self {
        Self::exact(value)
    }
}

impl From<Double> for f64 {
    /// The number, rounded.
    fn from(double: Double) -> Self {
        double.high
    }
}

impl Number for Double {
    fn of(value: f64) -> Self {
        Self::exact(value)
    }

    fn root(self) -> Self {
        let root = self.high.sqrt();
        if root == 0.0 {
            return Self::ZERO;
        }
        let rest = self - Self::exact(root) * Self::exact(root);
        let root = Self::ordered(root, rest.high / (2.0 * root));
        // a second step of Newton, for the digits of the low part
        root + (self - root * root) / (root + root)
    }

    /// Sine and cosine by their series, after reduction by quarter turns.
    fn sine_cosine(self) -> (Self, Self) {
        let turns = (self.high * FRAC_2_PI).round();
        let whole = HALF_PI.map(|part| Self::exact(part) * Self::exact(turns));
        let x = ((self - whole[0]) - whole[1]) - whole[2];
        let square = -(x * x);
        let (mut sine, mut cosine) = (x, Self::exact(1.0));
        let (mut odd, mut even) = (x, Self::exact(1.0));
        for [of_even, of_odd] in PARTS.iter() {
            even = even * square * *of_even;
            odd = odd * square * *of_odd;
            (sine, cosine) = (sine + odd, cosine + even);
            if even.high.abs() < LAST {
                break;
            }
        }
        match turns.rem_euclid(4.0) {
            0.0 => (sine, cosine),
            1.0 => (cosine, -sine),
            2.0 => (-sine, -cosine),
            _ => (-cosine, sine),
        }
    }
}

/// Functions that no scene calls: they return NaN, which fails every comparison.
macro_rules! unknown {
    ($($name:ident),* $(,)?) => {
        $(
            fn $name(self) -> Self {
                Self::exact(f64::NAN)
            }
        )*
    };
}

/// Generated code computes with these numbers, too.
impl Scalar for Double {
    const LANES: usize = 1;

    fn splat(value: f64) -> Self {
        Self::exact(value)
    }

    fn lane(self, _: usize) -> f64 {
        self.high
    }

    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        function(0).map(Self::exact)
    }

    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if (left - right).high < 0.0 {
            then
        } else {
            otherwise
        }
    }

    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if (left - right).high <= 0.0 {
            then
        } else {
            otherwise
        }
    }

    fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    fn signum(self) -> Self {
        Self::exact(self.high.signum())
    }

    fn recip(self) -> Self {
        Self::exact(1.0) / self
    }

    fn sqrt(self) -> Self {
        self.root()
    }

    fn sin(self) -> Self {
        self.sine_cosine().0
    }

    fn cos(self) -> Self {
        self.sine_cosine().1
    }

    fn powi(self, exponent: i32) -> Self {
        let power = (0..exponent.unsigned_abs()).fold(Self::exact(1.0), |power, _| power * self);
        if exponent < 0 { power.recip() } else { power }
    }

    unknown!(
        cbrt, exp, exp_m1, ln, ln_1p, tan, asin, acos, atan, sinh, cosh, tanh, asinh, acosh, atanh
    );

    fn powf(self, _: Self) -> Self {
        Self::exact(f64::NAN)
    }

    fn atan2(self, _: Self) -> Self {
        Self::exact(f64::NAN)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)] // the same numbers, to the last bit

    use super::*;

    /// The distance of two numbers.
    fn distance(x: Double, y: Double) -> f64 {
        (x - y).high.abs()
    }

    #[test]
    fn numbers_have_thirty_digits() {
        let third = Double::exact(1.0) / Double::exact(3.0);
        assert_eq!(third.high, 1.0 / 3.0);
        assert!(distance(third * Double::exact(3.0), Double::exact(1.0)) < 1e-31);
        let root = Double::exact(2.0).root();
        assert!(distance(root * root, Double::exact(2.0)) < 1e-31);
        let (s, c) = Double::exact(1.0).sine_cosine();
        assert_eq!(s.high, 1.0_f64.sin());
        assert!(distance(s * s + c * c, Double::exact(1.0)) < 1e-31);
        // the triple angle: another series and another quarter turn
        let (three, _) = Double::exact(3.0).sine_cosine();
        let expected = Double::exact(3.0) * s - Double::exact(4.0) * s * s * s;
        assert!(distance(three, expected) < 1e-30);
        let (sixteen, _) = Double::exact(-32.0).sine_cosine();
        let (_, half) = Double::exact(-16.0).sine_cosine();
        let (other, _) = Double::exact(-16.0).sine_cosine();
        assert!(distance(sixteen, Double::exact(2.0) * other * half) < 1e-30);
    }
}
