//! The recurrences of jets: each gives the coefficient `w_k` of a function from those of its arguments.
//!
//! `Σ` is an inner sum over `0 < j < k`, which is computed beforehand. Primes are derivatives by time, and
//! `r = 1/k`.

// parts of every operation
#![allow(clippy::inline_always)]

use super::Jet;
use super::memory::{self, Field};

/// An inner sum `Σ left_j right_{k-j}`, by its place.
struct Sum(usize);

impl Sum {
    /// The inner sum. Its newest terms are added here; the others have been summed beforehand.
    #[inline(always)]
    fn value(&self) -> f64 {
        let of = |field| memory::get(field, self.0);
        of(Field::Sum) + (of(Field::FirstLeft) * of(Field::Right) + of(Field::Left) * of(Field::FirstRight))
    }

    /// Sets its operands of this order, for the following orders.
    #[inline(always)]
    fn is_of(&self, left: f64, right: f64) {
        memory::set(Field::Left, self.0, left);
        memory::set(Field::Right, self.0, right);
    }
}

/// The next sums.
#[inline(always)]
fn sums<const M: usize>() -> [Sum; M] {
    let first = memory::take(M);
    core::array::from_fn(|i| Sum(first + i))
}

/// The data of order 0 at the place of a sum: a value, and the reciprocal of a divisor.
#[inline(always)]
fn kept(sum: &Sum, first: impl FnOnce() -> [f64; 2]) -> [f64; 2] {
    if memory::order() == 0 {
        keep(sum, first);
    }
    [Field::Start, Field::Inverse].map(|field| memory::get(field, sum.0))
}

/// Not inlined, so that the code of the higher orders is short.
#[inline(never)]
fn keep(sum: &Sum, first: impl FnOnce() -> [f64; 2]) {
    let [start, inverse] = first();
    memory::set(Field::Start, sum.0, start);
    memory::set(Field::Inverse, sum.0, inverse);
}

/// Functions of jets that depend on time.
impl Jet {
    /// `u v`.
    #[inline(always)]
    pub(super) fn product(self, v: Self) -> Self {
        let [sum] = sums();
        let now = sum.value() + self.value * v.now + self.now * v.value;
        sum.is_of(self.now, v.now);
        Self::moving(self.value * v.value, now)
    }

    /// `w = u / v` from `w v = u`.
    #[inline(always)]
    pub(super) fn quotient(self, v: Self) -> Self {
        let [sum] = sums();
        let [start, inverse] = kept(&sum, || [self.value / v.value, 1.0 / v.value]);
        let now = (self.now - (sum.value() + start * v.now)) * inverse;
        sum.is_of(now, v.now);
        Self::moving(start, now)
    }

    /// `w = c / u` from `w u = c`.
    #[inline(always)]
    pub(super) fn reciprocal(self, c: f64) -> Self {
        let [sum] = sums();
        let [start, inverse] = kept(&sum, || [c / self.value, 1.0 / self.value]);
        let now = -(sum.value() + start * self.now) * inverse;
        sum.is_of(now, self.now);
        Self::moving(start, now)
    }

    /// `w = √u` from `w² = u`.
    #[inline(always)]
    pub(super) fn root(self) -> Self {
        let [sum] = sums();
        let [start, inverse] = kept(&sum, || {
            let root = self.value.sqrt();
            [root, 1.0 / (2.0 * root)]
        });
        let now = (self.now - sum.value()) * inverse;
        sum.is_of(now, now);
        Self::moving(start, now)
    }

    /// `w = u^α` from `u w' = α w u'`.
    #[inline(always)]
    pub(super) fn power(self, exponent: f64, value: impl FnOnce(f64) -> f64) -> Self {
        let [outer, inner] = sums();
        let [start, inverse] = kept(&outer, || [value(self.value), 1.0 / self.value]);
        let [degree, r] = memory::degree();
        let rate = outer.value() * r + start * self.now;
        let now = (exponent * rate - inner.value() * r) * inverse;
        outer.is_of(degree * self.now, now);
        inner.is_of(degree * now, self.now);
        Self::moving(start, now)
    }

    /// `w' = (w + shift) u'`.
    #[inline(always)]
    pub(super) fn exponential(self, shift: f64, value: impl FnOnce(f64) -> f64) -> Self {
        let [sum] = sums();
        let [start, _] = kept(&sum, || [value(self.value), 0.0]);
        let [degree, r] = memory::degree();
        let now = sum.value() * r + self.now * (start + shift);
        sum.is_of(degree * self.now, now);
        Self::moving(start, now)
    }

    /// `(u + shift) w' = u'`.
    #[inline(always)]
    pub(super) fn logarithm(self, shift: f64, value: impl FnOnce(f64) -> f64) -> Self {
        let [sum] = sums();
        let [start, inverse] = kept(&sum, || [value(self.value), 1.0 / (self.value + shift)]);
        let [degree, r] = memory::degree();
        let now = (self.now - sum.value() * r) * inverse;
        sum.is_of(degree * now, self.now);
        Self::moving(start, now)
    }

    /// Two functions whose derivatives are each other, up to a sign for the second.
    #[inline(always)]
    pub(super) fn pair(self, sign: f64, values: impl FnOnce(f64) -> (f64, f64)) -> (Self, Self) {
        let [first, second] = sums();
        // the second is stored in place of a divisor's reciprocal
        let [f, g] = kept(&first, || values(self.value).into());
        let [degree, r] = memory::degree();
        let (f_now, g_now) = (
            first.value() * r + self.now * g,
            sign * (second.value() * r + self.now * f),
        );
        let rate = degree * self.now;
        first.is_of(rate, g_now);
        second.is_of(rate, f_now);
        (Self::moving(f, f_now), Self::moving(g, g_now))
    }

    /// A function with `w' = slope u'` and `slope = 1 + sign w²`.
    #[inline(always)]
    pub(super) fn tangent(self, sign: f64, values: impl FnOnce(f64) -> [f64; 2]) -> Self {
        let [sum, square] = sums();
        // the slope is stored in place of a divisor's reciprocal
        let [start, slope] = kept(&sum, || values(self.value));
        let [degree, r] = memory::degree();
        let now = sum.value() * r + self.now * slope;
        let slope_now = sign * (square.value() + 2.0 * start * now);
        sum.is_of(degree * self.now, slope_now);
        square.is_of(now, now);
        Self::moving(start, now)
    }

    /// A function with `slope w' = scale u'`.
    #[inline(always)]
    pub(super) fn inverse(self, slope: Self, scale: f64, value: impl FnOnce(f64) -> f64) -> Self {
        let [sum] = sums();
        let [start, inverse] = kept(&sum, || [value(self.value), 1.0 / slope.value]);
        let [degree, r] = memory::degree();
        let now = (scale * self.now - sum.value() * r) * inverse;
        sum.is_of(degree * now, slope.now);
        Self::moving(start, now)
    }

    /// `w = atan2(y, x)` from `radius w' = x y' - y x'`, `radius = x² + y²`.
    pub(super) fn angle(self, x: Self, radius: Self) -> Self {
        let y = self;
        let [first, second, own] = sums();
        let [start, inverse] = kept(&own, || [y.value.atan2(x.value), 1.0 / radius.value]);
        let [degree, r] = memory::degree();
        let ends = y.now * x.value - x.now * y.value;
        let now = ((first.value() - second.value() - own.value()) * r + ends) * inverse;
        first.is_of(degree * y.now, x.now);
        second.is_of(degree * x.now, y.now);
        own.is_of(degree * now, radius.now);
        Self::moving(start, now)
    }
}
