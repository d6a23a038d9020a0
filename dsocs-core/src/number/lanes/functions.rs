//! Elementary functions of eight numbers at once.
//!
//! Reduction of the argument and polynomials are those of fdlibm (`s_sin.c`, `k_sin.c`, `k_cos.c`) and, for the
//! exponential, the Taylor polynomial on `|r| ≤ ln 2 / 2`; branches have become selections. Products are rounded
//! before they are added, also where the processor could fuse the two, so that a result does not depend on the
//! processor.

// constants are written to all the digits that their sources give
#![allow(clippy::excessive_precision, clippy::unreadable_literal)]
// as in `register`
#![allow(clippy::inline_always)]

use super::register::Register;
use super::{LANES, Lanes, Mask};
use crate::number::scalar::Scalar;

/// `1.5 · 2⁵²`: a number added to it is rounded to an integer, which then stands in the lowest bits.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// The largest argument for which the reduction subtracts the multiple of `π/2` without rounding.
const LARGEST_ANGLE: f64 = 1e6;

/// The smallest reduced angle for which the digits of `π/2` that are carried suffice.
const SMALLEST_ANGLE: f64 = 1.0 / (1 << 24) as f64;

/// The largest argument whose exponential the vector code computes: beyond it, powers of two leave the range.
const LARGEST_EXPONENT: f64 = 708.0;

/// From here on the hyperbolic tangent is 1 in double precision.
const SATURATION: f64 = 20.0;

/// A polynomial, from its highest coefficient down.
#[inline(always)]
fn polynomial<R: Register, const D: usize>(x: Lanes<R>, coefficients: [f64; D]) -> Lanes<R> {
    let mut sum = Lanes::splat(coefficients[0]);
    for &coefficient in &coefficients[1..] {
        sum = sum * x + Lanes::splat(coefficient);
    }
    sum
}

/// Calls `function` in the lanes where the `result` of the vector code is not valid.
#[inline(always)]
fn patch<R: Register>(x: Lanes<R>, valid: Mask<R>, result: Lanes<R>, function: fn(f64) -> f64) -> Lanes<R> {
    let bits = valid.bits();
    if bits == 0xff {
        result
    } else {
        Lanes::from(replaced(x.into(), bits, result.into(), function))
    }
}

/// The lanes of [`patch`] that are not valid, seldom needed.
#[cold]
#[inline(never)]
fn replaced(x: [f64; LANES], valid: u32, mut result: [f64; LANES], function: fn(f64) -> f64) -> [f64; LANES] {
    for (lane, result) in result.iter_mut().enumerate() {
        if valid >> lane & 1 == 0 {
            *result = function(x[lane]);
        }
    }
    result
}

/// The sine.
#[inline(always)]
pub(super) fn sin<R: Register>(x: Lanes<R>) -> Lanes<R> {
    circular(x, 0, f64::sin)
}

/// The cosine.
#[inline(always)]
pub(super) fn cos<R: Register>(x: Lanes<R>) -> Lanes<R> {
    circular(x, 1, f64::cos)
}

/// The sine of `x + quarters · π/2`.
#[inline(always)]
fn circular<R: Register>(x: Lanes<R>, quarters: u64, function: fn(f64) -> f64) -> Lanes<R> {
    let shifted = x * Lanes::splat(core::f64::consts::FRAC_2_PI) + Lanes::splat(TO_INTEGER);
    let count = shifted - Lanes::splat(TO_INTEGER);
    // π/2 in two parts of 33 bits, whose multiples are exact, and a tail
    let first = x - count * Lanes::splat(1.57079632673412561417);
    let second = count * Lanes::splat(6.07710050630396597660e-11);
    let middle = first - second;
    let tail = count * Lanes::splat(2.02226624879595063154e-21) - ((first - middle) - second);
    let r = middle - tail;
    let rest = (middle - r) - tail;

    let square = r * r;
    let sine = {
        let inner = polynomial(
            square,
            [
                1.58969099521155010221e-10,
                -2.50507602534068634195e-08,
                2.75573137070700676789e-06,
                -1.98412698298579493134e-04,
                8.33333333332248946124e-03,
            ],
        );
        let cube = square * r;
        r - ((square * (Lanes::splat(0.5) * rest - cube * inner) - rest)
            - cube * Lanes::splat(-1.66666666666666324348e-01))
    };
    let cosine = {
        let inner = polynomial(
            square,
            [
                -1.13596475577881948265e-11,
                2.08757232129817482790e-09,
                -2.75573143513906633035e-07,
                2.48015872894767294178e-05,
                -1.38888888888741095749e-03,
                4.16666666666666019037e-02,
            ],
        ) * square;
        let half = Lanes::splat(0.5) * square;
        let one = Lanes::splat(1.0);
        let most = one - half;
        most + (((one - most) - half) + (square * inner - r * rest))
    };

    let quadrant = shifted.0.add_integers(Lanes::<R>::pattern(quarters).0);
    // the lowest bit minus 1 has all bits set in an even quadrant (sine); the second bit is the sign
    let last = quadrant.and(Lanes::<R>::pattern(1).0);
    let even = Mask(last.add_integers(Lanes::<R>::pattern(u64::MAX).0));
    let sign = quadrant.and(Lanes::<R>::pattern(2).0).shift_left::<62>();
    let chosen = even.select(sine, cosine);
    let result = Lanes(chosen.0.xor(sign));

    let size = x.abs();
    // near 0 nothing is subtracted, and no digits are lost
    let accurate = Lanes::splat(SMALLEST_ANGLE).at_most(r.abs()) | size.below(Lanes::splat(0.5));
    let valid = accurate & size.at_most(Lanes::splat(LARGEST_ANGLE));
    patch(x, valid, result, function)
}

/// `a + b r + c r² + d r³`. Not a closure: called several times, it would not be compiled for the registers.
#[inline(always)]
fn part<R: Register>(r: Lanes<R>, square: Lanes<R>, [a, b, c, d]: [f64; 4]) -> Lanes<R> {
    (Lanes::splat(a) + Lanes::splat(b) * r) + (Lanes::splat(c) + Lanes::splat(d) * r) * square
}

/// A power of two `2^k` and `exp(r) - 1` with `x = k ln 2 + r`, for arguments of at most [`LARGEST_EXPONENT`].
#[inline(always)]
fn reduced_exponential<R: Register>(x: Lanes<R>) -> (Lanes<R>, Lanes<R>) {
    let shifted = x * Lanes::splat(core::f64::consts::LOG2_E) + Lanes::splat(TO_INTEGER);
    let count = shifted - Lanes::splat(TO_INTEGER);
    let high = x - count * Lanes::splat(6.93147180369123816490e-01);
    let low = count * Lanes::splat(1.90821492927058770002e-10);
    let r = high - low;
    let rest = (high - r) - low;
    let square = r * r;
    let fourth = square * square;
    // 1/3! + r/4! + … + r¹¹/14!, four coefficients at a time, so that the sums are independent of each other
    let inner = part(r, square, [1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0])
        + fourth
            * (part(
                r,
                square,
                [1.0 / 5_040.0, 1.0 / 40_320.0, 1.0 / 362_880.0, 1.0 / 3_628_800.0],
            ) + fourth
                * part(
                    r,
                    square,
                    [
                        1.0 / 39_916_800.0,
                        1.0 / 479_001_600.0,
                        1.0 / 6_227_020_800.0,
                        1.0 / 87_178_291_200.0,
                    ],
                ));
    // the rest of the argument enters with the slope 1 + r, which is enough for its size
    let small = Lanes::splat(0.5) * square + (square * r * inner + (rest + rest * r));
    let power = Lanes(
        shifted
            .0
            .add_integers(Lanes::<R>::pattern(1023).0)
            .shift_left::<52>(),
    );
    (power, r + small)
}

/// The exponential.
#[inline(always)]
pub(super) fn exp<R: Register>(x: Lanes<R>) -> Lanes<R> {
    let (power, less_one) = reduced_exponential(x);
    let result = power + power * less_one;
    patch(
        x,
        x.abs().at_most(Lanes::splat(LARGEST_EXPONENT)),
        result,
        f64::exp,
    )
}

/// `exp(x) - 1` for arguments of at most [`LARGEST_EXPONENT`].
#[inline(always)]
fn exponential_less_one<R: Register>(x: Lanes<R>) -> Lanes<R> {
    let (power, less_one) = reduced_exponential(x);
    power * less_one + (power - Lanes::splat(1.0))
}

/// `exp(x) - 1`.
#[inline(always)]
pub(super) fn exp_m1<R: Register>(x: Lanes<R>) -> Lanes<R> {
    // the vector code would lose the sign of a zero
    let size = x.abs();
    let inside = size.at_most(Lanes::splat(LARGEST_EXPONENT)) & Lanes::splat(0.0).below(size);
    patch(x, inside, exponential_less_one(x), f64::exp_m1)
}

/// The hyperbolic tangent.
#[inline(always)]
pub(super) fn tanh<R: Register>(x: Lanes<R>) -> Lanes<R> {
    let size = x.abs();
    // a NaN stays: comparisons with it are false
    let size = Lanes::select_lt(Lanes::splat(SATURATION), size, Lanes::splat(SATURATION), size);
    let one = Lanes::splat(1.0);
    let two = Lanes::splat(2.0);
    let less_one = exponential_less_one(size + size);
    // t / (t + 2), written with 1 first where that loses less
    let quotient = Lanes::select_lt(size, Lanes::splat(0.55), less_one, two) / (less_one + two);
    let positive = Lanes::select_lt(size, Lanes::splat(0.55), quotient, one - quotient);
    let sign = x.0.and(R::splat(-0.0));
    Lanes(positive.0.or(sign))
}
