//! The recurrences of all operations, for the attribute's code and for the interpreter: order 0, and any
//! other order.
//!
//! A pair holds the coefficients of order 0 and of the order `k` that is computed, and `r = 1/k`. An inner
//! sum has the terms of the orders between.

// parts of every operation, which are compiled for the machine's own instructions
#![allow(clippy::inline_always)]

use super::coefficient::Coefficient;
use super::sums::{add_product, newest};

/// An inner sum with its newest terms, `x_1 y_{k-1} + y_1 x_{k-1}`, if it was formed without them. The
/// operands are given by their coefficients of the orders 1 and `k-1`.
#[inline(always)]
#[must_use]
pub fn inner<const FUSED: bool, T: Coefficient>(sum: T, x: [T; 2], y: [T; 2]) -> T {
    newest::<FUSED, T>(newest::<FUSED, T>(sum, x[0], y[1]), y[0], x[1])
}

/// [`inner`] for the product of an operand with itself.
#[inline(always)]
#[must_use]
pub fn inner_square<const FUSED: bool, T: Coefficient>(sum: T, x: [T; 2]) -> T {
    newest::<FUSED, T>(sum, T::splat(2.0) * x[0], x[1])
}

/// `u v`.
#[inline(always)]
#[must_use]
pub fn product<const FUSED: bool, T: Coefficient>(inner: T, u: [T; 2], v: [T; 2]) -> T {
    add_product::<FUSED, T>(add_product::<FUSED, T>(inner, u[0], v[1]), u[1], v[0])
}

/// `u²`.
#[inline(always)]
#[must_use]
pub fn square<const FUSED: bool, T: Coefficient>(inner: T, u: [T; 2]) -> T {
    add_product::<FUSED, T>(inner, T::splat(2.0) * u[0], u[1])
}

/// `w = u / v` from `w v = u`; `y` is `1 / v` at order 0.
#[inline(always)]
#[must_use]
pub fn quotient<const FUSED: bool, T: Coefficient>(inner: T, own: T, u: T, v: T, y: T) -> T {
    (u - add_product::<FUSED, T>(inner, own, v)) * y
}

/// `w = 1 / v` from `w v = 1`.
#[inline(always)]
#[must_use]
pub fn reciprocal<const FUSED: bool, T: Coefficient>(inner: T, own: T, v: T, y: T) -> T {
    -add_product::<FUSED, T>(inner, own, v) * y
}

/// `w = √u` from `w² = u`; `y` is `1 / 2w` at order 0.
#[inline(always)]
#[must_use]
pub fn root<T: Coefficient>(inner: T, u: T, y: T) -> T {
    (u - inner) * y
}

/// `w = u^α` from `u w' = α w u'`: `k u₀ w_k = α k w₀ u_k + Σ (α (k-j) - j) w_j u_{k-j}`; `y` is `1 / u` at
/// order 0. If `u₀` is zero, so are the coefficients below the order `α`, and those beyond are NaN.
#[inline(always)]
#[must_use]
pub fn power<T: Coefficient>(exponent: T, [outer, inner]: [T; 2], own: T, u: T, [y, r]: [T; 2]) -> T {
    let now = (exponent * (outer * r + own * u) - inner * r) * y;
    let at_zero = T::select_lt(T::splat(1.0), exponent * r, T::splat(0.0), T::splat(f64::NAN));
    T::select_lt(y.abs(), T::splat(f64::INFINITY), now, at_zero)
}

/// `w' = factor u'`, with the factor at order 0.
#[inline(always)]
#[must_use]
pub fn rate<const FUSED: bool, T: Coefficient>(inner: T, u: T, factor: T, r: T) -> T {
    add_product::<FUSED, T>(inner * r, u, factor)
}

/// `slope w' = u'`; `y` is `1 / slope` at order 0.
#[inline(always)]
#[must_use]
pub fn by_slope<T: Coefficient>(inner: T, u: T, y: T, r: T) -> T {
    (u - inner * r) * y
}

/// `w = atan2(y, x)` from `radius w' = x y' - y x'`, `radius = x² + y²`; `inverse` is `1 / radius` at order 0.
#[inline(always)]
#[must_use]
pub fn angle<T: Coefficient>(
    [left, right, rest]: [T; 3],
    ordinate: [T; 2],
    abscissa: [T; 2],
    [inverse, r]: [T; 2],
) -> T {
    ((left - right - rest) * r + (ordinate[1] * abscissa[0] - abscissa[1] * ordinate[0])) * inverse
}

/// Selects one of two numbers: the first if `decides` is positive.
#[inline(always)]
#[must_use]
pub fn select<T: Coefficient>(decides: T, then: T, otherwise: T) -> T {
    T::select_lt(T::splat(0.0), decides, then, otherwise)
}

/// Order 0: `1 - u²`.
#[inline(always)]
#[must_use]
pub fn conjugate<T: Coefficient>(u: T) -> T {
    (T::splat(1.0) - u) * (T::splat(1.0) + u)
}

/// Order 0: the reciprocal of the divisor of all orders.
#[inline(always)]
#[must_use]
pub fn inverted<T: Coefficient>(divisor: T) -> T {
    T::splat(1.0) / divisor
}
