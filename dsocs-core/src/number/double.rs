//! Numbers of twice the precision, each as an unevaluated sum of two doubles: some 32 digits.
//!
//! The rows of a step are evaluated with them where they must be more accurate than the nodes that they are
//! formed from. Sums, products and quotients are those of Dekker and Knuth (Hida, Li and Bailey, *Library for
//! double-double and quad-double arithmetic*, 2007). Functions start from the double's value and improve it
//! by a step of Newton's, or are Taylor series. A user's function is called with plain doubles, and is
//! accurate to double precision only.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::number::scalar::Scalar;

/// A number as the unevaluated sum `hi + lo`, with `hi` the rounded sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Double {
    hi: f64,
    lo: f64,
}

/// `ln 2`.
const LN_2: Double = Double {
    hi: core::f64::consts::LN_2,
    lo: 2.319_046_813_846_299_6e-17,
};

/// `π/2` as a sum of three doubles.
const HALF_PI: [f64; 3] = [
    core::f64::consts::FRAC_PI_2,
    6.123_233_995_736_766e-17,
    -1.497_384_904_859_169_8e-33,
];

/// The exponential is computed for the argument divided by `2^HALVINGS`, and squared this many times.
const HALVINGS: i32 = 8;

/// Beyond this argument the hyperbolic tangent is 1.
const FLAT: f64 = 40.0;

impl Double {
    /// A double.
    #[must_use]
    pub fn exact(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }

    /// The difference of two doubles, exactly.
    #[must_use]
    pub fn difference(left: f64, right: f64) -> Self {
        two_sum(left, -right)
    }

    /// The number, rounded.
    #[must_use]
    pub fn rounded(self) -> f64 {
        self.hi
    }

    /// The sum of two doubles, the first of which is larger in absolute value.
    fn sum(hi: f64, lo: f64) -> Self {
        let sum = hi + lo;
        if !sum.is_finite() {
            return Self::exact(sum);
        }
        Self {
            hi: sum,
            lo: lo - (sum - hi),
        }
    }

    /// The number times a power of two.
    fn scaled(self, by: f64) -> Self {
        Self {
            hi: self.hi * by,
            lo: self.lo * by,
        }
    }

    /// `exp(x) − 1` for a small argument.
    fn exp_m1_small(self) -> Self {
        let part = self.scaled(f64::from(-HALVINGS).exp2());
        let (mut term, mut sum) = (part, part);
        for k in 2..16 {
            term = term * part / Self::splat(f64::from(k));
            sum = sum + term;
        }
        for _ in 0..HALVINGS {
            sum = sum.scaled(2.0) + sum * sum;
        }
        sum
    }

    /// Sine and cosine.
    fn sin_cos(self) -> [Self; 2] {
        let turns = (self.hi / HALF_PI[0]).round();
        if !turns.is_finite() || turns.abs() > 1e15 {
            return [Self::exact(f64::NAN); 2];
        }
        let rest = HALF_PI
            .iter()
            .fold(self, |rest, part| rest - two_product(turns, *part));
        let square = rest * rest;
        let series = |first: Self, from: u32| {
            let (mut term, mut sum) = (first, first);
            for k in 0..16 {
                let m = f64::from(from + 2 * k);
                term = -(term * square) / Self::splat(m * (m + 1.0));
                sum = sum + term;
            }
            sum
        };
        let (sin, cos) = (series(rest, 2), series(Self::splat(1.0), 1));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 0 to 3
        match turns.rem_euclid(4.0) as u8 {
            0 => [sin, cos],
            1 => [cos, -sin],
            2 => [-sin, -cos],
            _ => [-cos, sin],
        }
    }
}

/// The sum of two doubles, exactly.
fn two_sum(a: f64, b: f64) -> Double {
    let sum = a + b;
    if !sum.is_finite() {
        return Double::exact(sum);
    }
    let of_b = sum - a;
    Double {
        hi: sum,
        lo: (a - (sum - of_b)) + (b - of_b),
    }
}

/// The product of two doubles, exactly.
fn two_product(a: f64, b: f64) -> Double {
    let product = a * b;
    if !product.is_finite() {
        return Double::exact(product);
    }
    Double {
        hi: product,
        lo: a.mul_add(b, -product),
    }
}

impl Add for Double {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (hi, lo) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let sum = Self::sum(hi.hi, hi.lo + lo.hi);
        Self::sum(sum.hi, sum.lo + lo.lo)
    }
}

impl Neg for Double {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            hi: -self.hi,
            lo: -self.lo,
        }
    }
}

impl Sub for Double {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl Mul for Double {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = two_product(self.hi, other.hi);
        if !product.hi.is_finite() {
            return product;
        }
        Self::sum(product.hi, product.lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl Div for Double {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        if !first.is_finite() || !other.hi.is_finite() {
            return Self::exact(first);
        }
        let rest = self - other * Self::exact(first);
        let second = rest.hi / other.hi;
        let rest = rest - other * Self::exact(second);
        Self::sum(first, second) + Self::exact(rest.hi / other.hi)
    }
}

impl Scalar for Double {
    const LANES: usize = 1;

    fn splat(value: f64) -> Self {
        Self::exact(value)
    }

    fn lane(self, _: usize) -> f64 {
        self.hi
    }

    fn from_lanes<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        function(0).map(Self::exact)
    }

    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if (left - right).hi < 0.0 { then } else { otherwise }
    }

    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if (left - right).hi <= 0.0 { then } else { otherwise }
    }

    fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    fn signum(self) -> Self {
        Self::exact(self.hi.signum())
    }

    fn recip(self) -> Self {
        Self::splat(1.0) / self
    }

    fn sqrt(self) -> Self {
        let root = self.hi.sqrt();
        if root == 0.0 || !root.is_finite() {
            return Self::exact(root);
        }
        let rest = self - two_product(root, root);
        Self::sum(root, rest.hi / (2.0 * root))
    }

    fn cbrt(self) -> Self {
        let root = Self::exact(self.hi.cbrt());
        if root.hi == 0.0 || !root.hi.is_finite() {
            return root;
        }
        let square = root * root;
        root - (square * root - self) / (square * Self::splat(3.0))
    }

    fn exp(self) -> Self {
        let twos = (self.hi / LN_2.hi).round();
        if twos.is_nan() || twos.abs() > 1000.0 {
            return Self::exact(self.hi.exp());
        }
        let rest = self - LN_2 * Self::exact(twos);
        (Self::splat(1.0) + rest.exp_m1_small()).scaled(twos.exp2())
    }

    fn exp_m1(self) -> Self {
        if self.hi.abs() < 0.5 {
            self.exp_m1_small()
        } else {
            self.exp() - Self::splat(1.0)
        }
    }

    fn ln(self) -> Self {
        let first = Self::exact(self.hi.ln());
        if !first.hi.is_finite() {
            return first;
        }
        first + (self * (-first).exp() - Self::splat(1.0))
    }

    fn ln_1p(self) -> Self {
        let first = Self::exact(self.hi.ln_1p());
        if !first.hi.is_finite() {
            return first;
        }
        first - (first.exp_m1() - self) / (Self::splat(1.0) + self)
    }

    fn sin(self) -> Self {
        self.sin_cos()[0]
    }

    fn cos(self) -> Self {
        self.sin_cos()[1]
    }

    fn tan(self) -> Self {
        let [sin, cos] = self.sin_cos();
        sin / cos
    }

    fn asin(self) -> Self {
        self.atan2((Self::splat(1.0) - self * self).sqrt())
    }

    fn acos(self) -> Self {
        (Self::splat(1.0) - self * self).sqrt().atan2(self)
    }

    fn atan(self) -> Self {
        self.atan2(Self::splat(1.0))
    }

    fn sinh(self) -> Self {
        let part = self.exp_m1();
        (part + part / (Self::splat(1.0) + part)).scaled(0.5)
    }

    fn cosh(self) -> Self {
        let part = self.exp();
        (part + part.recip()).scaled(0.5)
    }

    fn tanh(self) -> Self {
        if self.hi.abs() > FLAT {
            return self.signum();
        }
        let part = self.scaled(2.0).exp_m1();
        part / (part + Self::splat(2.0))
    }

    fn asinh(self) -> Self {
        let size = self.abs();
        let square = size * size;
        let one = Self::splat(1.0);
        // ln(x + √(x² + 1)) without a difference of ones
        let value = (size + square / (one + (square + one).sqrt())).ln_1p();
        if self.hi < 0.0 { -value } else { value }
    }

    fn acosh(self) -> Self {
        (self + (self * self - Self::splat(1.0)).sqrt()).ln()
    }

    fn atanh(self) -> Self {
        (self.scaled(2.0) / (Self::splat(1.0) - self)).ln_1p().scaled(0.5)
    }

    fn powf(self, exponent: Self) -> Self {
        if self.hi > 0.0 {
            (exponent * self.ln()).exp()
        } else {
            Self::exact(self.hi.powf(exponent.hi))
        }
    }

    fn powi(self, exponent: i32) -> Self {
        let (mut power, mut square, mut rest) = (Self::splat(1.0), self, exponent.unsigned_abs());
        while rest > 0 {
            if rest % 2 == 1 {
                power = power * square;
            }
            square = square * square;
            rest /= 2;
        }
        if exponent < 0 { power.recip() } else { power }
    }

    fn atan2(self, x: Self) -> Self {
        let first = Self::exact(self.hi.atan2(x.hi));
        let [sin, cos] = first.sin_cos();
        // the tangent of the remaining angle
        let rest = (self * cos - x * sin) / (x * cos + self * sin);
        if rest.hi.is_finite() { first + rest } else { first }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether two numbers agree to 30 digits.
    fn agree(found: Double, expected: Double) -> bool {
        (found - expected).hi.abs() <= 1e-30 * expected.hi.abs().max(1e-2)
    }

    /// `hi + lo`.
    fn number(hi: f64, lo: f64) -> Double {
        Double::sum(hi, lo)
    }

    #[test]
    fn functions_have_thirty_digits() {
        let x = Double::exact(0.7);
        // there and back again
        for (found, expected) in [
            (x.sqrt() * x.sqrt(), x),
            (x.cbrt().powi(3), x),
            (x.exp().ln(), x),
            (x.ln_1p().exp_m1(), x),
            (x.sin().asin(), x),
            (x.cos().acos(), x),
            (x.tan().atan(), x),
            (x.sinh().asinh(), x),
            (x.cosh().acosh(), x),
            (x.tanh().atanh(), x),
            (x.powf(Double::exact(4.0)).powf(Double::exact(0.25)), x),
            (x.recip().recip(), x),
        ] {
            assert!(agree(found, expected), "{found:?} {expected:?}");
        }
        // the base of the exponential, and π
        let one = Double::exact(1.0);
        assert!(agree(
            one.exp(),
            number(core::f64::consts::E, 1.445_646_891_729_250_2e-16)
        ));
        assert!(agree(
            one.atan().scaled(4.0),
            number(core::f64::consts::PI, 1.224_646_799_147_353_2e-16)
        ));
        // far out, where the argument has to be reduced
        let far = Double::exact(1e6);
        let [sin, cos] = far.sin_cos();
        assert!(agree(sin * sin + cos * cos, one));
        assert!(agree(
            sin,
            number(-0.349_993_502_171_292_94, -1.595_284_880_932_396_8e-17)
        ));
    }

    #[test]
    fn sums_and_quotients_keep_what_a_double_loses() {
        let third = Double::exact(1.0) / Double::exact(3.0);
        assert!(agree(third * Double::exact(3.0), Double::exact(1.0)));
        let d = Double::difference(1.0, 1e-20);
        assert_eq!((d - Double::exact(1.0)).rounded(), -1e-20);
    }

    #[test]
    fn what_is_not_finite_stays_so() {
        assert_eq!(Double::exact(1000.0).exp().rounded(), f64::INFINITY);
        assert_eq!(Double::exact(-1000.0).exp().rounded(), 0.0);
        assert_eq!(Double::exact(800.0).tanh().rounded(), 1.0);
        assert!(Double::exact(f64::NAN).sin().rounded().is_nan());
        assert!((Double::exact(1.0) / Double::exact(0.0)).rounded().is_infinite());
    }
}
