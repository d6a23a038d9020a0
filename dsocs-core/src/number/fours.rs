//! Four numbers side by side.
//!
//! The compiler vectorises four sums by itself, unless each of them is needed by itself afterwards. Where this takes most of the time, the
//! registers are named here.

#![allow(clippy::inline_always)] // parts of recurrences, which are compiled for the machine's own instructions

#[cfg(target_arch = "x86_64")]
use pulp::{f64x4, x86::V3};

use super::scalar::Scalar;

/// Arithmetic on four numbers at once.
pub trait Fours<T>: Copy {
    /// Four numbers.
    type Row: Copy;

    /// The row of four numbers.
    fn row(self, numbers: [T; 4]) -> Self::Row;

    /// The four numbers of a row.
    fn numbers(self, row: Self::Row) -> [T; 4];

    /// `a + b`
    fn add(self, a: Self::Row, b: Self::Row) -> Self::Row;

    /// `sum + a b`
    fn add_product(self, sum: Self::Row, a: Self::Row, b: Self::Row) -> Self::Row;
}

/// A computation on rows of four, compiled for each kind of arithmetic. All functions that it calls are inlined.
pub trait OnFours<T> {
    /// Its result.
    type Output;

    /// Computes the result with an arithmetic.
    fn run<F: Fours<T>>(self, fours: F) -> Self::Output;
}

/// Arithmetic on one number after the other, by a function `(sum, a, b) ↦ sum + a b`.
#[derive(Clone, Copy)]
pub(crate) struct OneByOne<A>(pub A);

impl<T: Scalar, A: Fn(T, T, T) -> T + Copy> Fours<T> for OneByOne<A> {
    type Row = [T; 4];

    #[inline(always)]
    fn row(self, numbers: [T; 4]) -> [T; 4] {
        numbers
    }

    #[inline(always)]
    fn numbers(self, row: [T; 4]) -> [T; 4] {
        row
    }

    #[inline(always)]
    fn add(self, a: [T; 4], b: [T; 4]) -> [T; 4] {
        [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
    }

    #[inline(always)]
    fn add_product(self, sum: [T; 4], a: [T; 4], b: [T; 4]) -> [T; 4] {
        let Self(add) = self;
        [
            add(sum[0], a[0], b[0]),
            add(sum[1], a[1], b[1]),
            add(sum[2], a[2], b[2]),
            add(sum[3], a[3], b[3]),
        ]
    }
}

/// A register of four doubles, with fused products.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Registers(V3);

#[cfg(target_arch = "x86_64")]
impl Fours<f64> for Registers {
    type Row = f64x4;

    #[inline(always)]
    fn row(self, [a, b, c, d]: [f64; 4]) -> f64x4 {
        f64x4(a, b, c, d)
    }

    #[inline(always)]
    fn numbers(self, f64x4(a, b, c, d): f64x4) -> [f64; 4] {
        [a, b, c, d]
    }

    #[inline(always)]
    fn add(self, a: f64x4, b: f64x4) -> f64x4 {
        self.0.add_f64x4(a, b)
    }

    #[inline(always)]
    fn add_product(self, sum: f64x4, a: f64x4, b: f64x4) -> f64x4 {
        self.0.mul_add_f64x4(a, b, sum)
    }
}

/// Computes with doubles: in registers if products are fused, since the machine then has them.
#[inline(always)]
pub(crate) fn on_doubles<const FUSED: bool, W: OnFours<f64>>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if FUSED && let Some(simd) = V3::try_new() {
        return work.run(Registers(simd));
    }
    work.run(OneByOne(add_product::<FUSED>))
}

#[inline(always)]
fn add_product<const FUSED: bool>(sum: f64, a: f64, b: f64) -> f64 {
    if FUSED { a.mul_add(b, sum) } else { sum + a * b }
}
