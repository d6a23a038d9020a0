//! The functions of jets: what [`Real`] asks for.

use core::cmp::Ordering;

use super::Jet;
use super::tape::{self, Op};
use crate::dual::Part;
use crate::real::Real;

impl Part for Jet {
    /// Whether it is zero for all time.
    fn vanishes(&self) -> bool {
        self.node.is_none() && self.value == 0.0
    }
}

impl Jet {
    /// Two functions whose derivatives are each other, up to a sign for the second.
    fn pair(self, [first, second]: [f64; 2], sign: f64) -> (Self, Self) {
        match self.node {
            None => (Self::from(first), Self::from(second)),
            Some(u) => (
                Self::of(
                    Op::Partner {
                        u,
                        distance: 1,
                        scale: 1.0,
                    },
                    first,
                ),
                Self::of(
                    Op::Partner {
                        u,
                        distance: -1,
                        scale: sign,
                    },
                    second,
                ),
            ),
        }
    }

    /// A function `w` with `w' = (1 ± w²) u'`; `slope` is `1 ± w²`.
    fn tangent(self, value: f64, slope: f64, sign: f64) -> Self {
        let Some(u) = self.node else {
            return Self::from(value);
        };
        let result = Self::of(
            Op::Partner {
                u,
                distance: 2,
                scale: 1.0,
            },
            value,
        );
        if let Some(w) = result.node {
            let square = Self::of(Op::Square(w), value * value);
            if let Some(square) = square.node {
                Self::of(
                    Op::Affine {
                        u: square,
                        scale: sign,
                    },
                    slope,
                );
            }
        }
        result
    }

    /// A function `w` with `slope w' = scale u'`.
    fn inverse(self, slope: Self, scale: f64, value: f64) -> Self {
        match (self.node, slope.node) {
            (Some(u), Some(slope)) => Self::of(Op::Inverse { u, slope, scale }, value),
            _ => Self::from(value),
        }
    }

    /// `1 - self²`.
    fn conjugate(self) -> Self {
        (-self + 1.0) * (self + 1.0)
    }
}

/// Comparisons decide between pieces of a function.
pub(super) fn compare(left: Jet, right: Jet) -> Option<Ordering> {
    let own = left.value.partial_cmp(&right.value)?;
    let difference = left - right;
    if difference.node.is_none() {
        return Some(own);
    }
    let free = !tape::is_held();
    let side = difference.decides(match own {
        Ordering::Less => -1.0,
        // as `signum` has it
        Ordering::Equal | Ordering::Greater => 1.0,
    });
    Some(match own {
        own if free => own,
        _ if side < 0.0 => Ordering::Less,
        _ => Ordering::Greater,
    })
}

impl Real for Jet {
    fn re(self) -> f64 {
        self.value
    }

    fn abs(self) -> Self {
        self.affine(self.decides(self.value.signum()), 0.0)
    }

    fn signum(self) -> Self {
        Self::from(self.decides(self.value.signum()))
    }

    fn piece(self, places: &[f64]) -> usize {
        let own = places.partition_point(|&place| place <= self.value);
        // there are fewer places than numbers
        let number = |index: usize| i64::try_from(index).unwrap_or(i64::MAX);
        let index = |number: i64| usize::try_from(number).ok();
        let piece = tape::choose(self, number(own), |piece| {
            [piece - 1, piece].map(|end| index(end).and_then(|end| places.get(end).copied()))
        });
        index(piece).unwrap_or(0)
    }

    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    fn recip(self) -> Self {
        self.unary(Op::Recip, 1.0 / self.value)
    }

    fn powi(self, n: i32) -> Self {
        // by products: a power of zero is none of a logarithm
        let mut result: Option<Self> = None;
        let (mut square, mut rest) = (self, n.unsigned_abs());
        while rest > 0 {
            if rest & 1 == 1 {
                result = Some(result.map_or(square, |product| product * square));
            }
            rest >>= 1;
            if rest > 0 {
                square = square * square;
            }
        }
        match result {
            None => Self::from(1.0),
            Some(power) if n < 0 => Real::recip(power),
            Some(power) => power,
        }
    }

    fn powf(self, n: f64) -> Self {
        #[allow(clippy::cast_possible_truncation)] // a small integer
        if n.fract() == 0.0 && n.abs() <= 64.0 {
            return Real::powi(self, n as i32);
        }
        self.unary(|u| Op::Power(u, n), self.value.powf(n))
    }

    fn powd(self, exp: Self) -> Self {
        if exp.node.is_none() {
            return Real::powf(self, exp.value);
        }
        Real::exp(Real::ln(self) * exp)
    }

    fn sqrt(self) -> Self {
        self.unary(Op::Sqrt, self.value.sqrt())
    }

    fn cbrt(self) -> Self {
        self.unary(|u| Op::Power(u, 1.0 / 3.0), self.value.cbrt())
    }

    fn exp(self) -> Self {
        self.unary(|u| Op::Exp(u, 0.0), self.value.exp())
    }

    fn exp2(self) -> Self {
        Real::exp(self.affine(core::f64::consts::LN_2, 0.0))
    }

    fn exp_m1(self) -> Self {
        self.unary(|u| Op::Exp(u, 1.0), self.value.exp_m1())
    }

    fn ln(self) -> Self {
        self.unary(|u| Op::Ln(u, 0.0), self.value.ln())
    }

    fn log(self, base: f64) -> Self {
        Real::ln(self).affine(1.0 / base.ln(), 0.0)
    }

    fn log2(self) -> Self {
        Real::ln(self).affine(core::f64::consts::LOG2_E, 0.0)
    }

    fn log10(self) -> Self {
        Real::ln(self).affine(core::f64::consts::LOG10_E, 0.0)
    }

    fn ln_1p(self) -> Self {
        self.unary(|u| Op::Ln(u, 1.0), self.value.ln_1p())
    }

    fn sin(self) -> Self {
        Real::sin_cos(self).0
    }

    fn cos(self) -> Self {
        Real::sin_cos(self).1
    }

    fn tan(self) -> Self {
        let value = self.value.tan();
        self.tangent(value, 1.0 + value * value, 1.0)
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = self.value.sin_cos();
        self.pair([sine, cosine], -1.0)
    }

    fn asin(self) -> Self {
        let slope = Real::sqrt(self.conjugate());
        self.inverse(slope, 1.0, self.value.asin())
    }

    fn acos(self) -> Self {
        let slope = Real::sqrt(self.conjugate());
        self.inverse(slope, -1.0, self.value.acos())
    }

    fn atan(self) -> Self {
        let slope = self * self + 1.0;
        self.inverse(slope, 1.0, self.value.atan())
    }

    fn atan2(self, other: Self) -> Self {
        let value = self.value.atan2(other.value);
        match (self.node, other.node) {
            (None, None) => Self::from(value),
            (Some(y), Some(x)) => {
                let radius = self * self + other * other;
                match radius.node {
                    Some(radius) => Self::of(Op::Atan2 { y, x, radius }, value),
                    None => Self::from(value),
                }
            }
            // atan2(y, x) = atan(y/x) + const = const - atan(x/y)
            (Some(_), None) if other.value != 0.0 => {
                let angle = Real::atan(self / other);
                angle.affine(1.0, value - angle.value)
            }
            _ => {
                let angle = Real::atan(other / self);
                angle.affine(-1.0, value + angle.value)
            }
        }
    }

    fn sinh(self) -> Self {
        self.pair([self.value.sinh(), self.value.cosh()], 1.0).0
    }

    fn cosh(self) -> Self {
        self.pair([self.value.sinh(), self.value.cosh()], 1.0).1
    }

    fn tanh(self) -> Self {
        let value = self.value.tanh();
        // steep: no sign is to be kept
        let _ = self.decides(0.0);
        self.tangent(value, (1.0 - value) * (1.0 + value), -1.0)
    }

    fn asinh(self) -> Self {
        let slope = Real::sqrt(self * self + 1.0);
        self.inverse(slope, 1.0, self.value.asinh())
    }

    fn acosh(self) -> Self {
        let slope = Real::sqrt(-self.conjugate());
        self.inverse(slope, 1.0, self.value.acosh())
    }

    fn atanh(self) -> Self {
        let slope = self.conjugate();
        self.inverse(slope, 1.0, self.value.atanh())
    }
}
