//! Registers of AVX2 and of AVX-512.

// as in `register`
#![allow(clippy::inline_always)]

use bytemuck::cast_slice;
use simdeez::prelude::*;
use simdeez::{SimdBitMask, engines};

use super::LANES;
use super::register::Register;

/// Two registers of four numbers.
pub(crate) type Avx2 = [engines::avx2::F64x4; 2];

/// One register of eight.
pub(crate) type Avx512 = [engines::avx512::F64x8; 1];

/// The lowest bit of each byte.
const BYTES: u64 = 0x0101_0101_0101_0101;

/// Multiplier that collects the lowest bits of eight bytes in the highest byte of the product, that of the
/// first byte lowest.
const TOGETHER: u64 = 0x0102_0408_1020_4080;

/// A function of two vectors, register by register.
#[inline(always)]
fn zip<V: Copy, const K: usize>(left: [V; K], right: [V; K], function: impl Fn(V, V) -> V) -> [V; K] {
    let mut result = left;
    for (result, right) in result.iter_mut().zip(right) {
        *result = function(*result, right);
    }
    result
}

/// A function of one vector, register by register.
#[inline(always)]
fn map<V: Copy, const K: usize>(mut x: [V; K], function: impl Fn(V) -> V) -> [V; K] {
    for x in &mut x {
        *x = function(*x);
    }
    x
}

/// The bit patterns as integers.
type Integers<V> = <<V as SimdConsts>::Engine as Simd>::Vi64;

/// The bytes of the bit patterns.
type Bytes<V> = <<V as SimdConsts>::Engine as Simd>::Vi8;

impl<V, const K: usize> Register for [V; K]
where
    V: SimdFloat64,
    V::Engine: Simd<Vf64 = V>,
    Integers<V>: SimdInt64<Engine = V::Engine>,
{
    #[inline(always)]
    fn splat(value: f64) -> Self {
        [V::set1(value); K]
    }

    #[inline(always)]
    fn new(numbers: [f64; LANES]) -> Self {
        let mut registers = [V::zeroes(); K];
        for (register, numbers) in registers.iter_mut().zip(numbers.chunks_exact(V::WIDTH)) {
            *register = V::load_from_slice(numbers);
        }
        registers
    }

    #[inline(always)]
    fn array(self) -> [f64; LANES] {
        let mut numbers = [0.0; LANES];
        for (part, x) in numbers.chunks_exact_mut(V::WIDTH).zip(self) {
            x.copy_to_slice(part);
        }
        numbers
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::add)
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::sub)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::mul)
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        zip(self, other, SimdFloat::div)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        map(self, SimdBaseOps::abs)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        map(self, SimdFloat::sqrt)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::max)
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::min)
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::cmp_lt)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::cmp_lte)
    }

    #[inline(always)]
    fn select(self, then: Self, otherwise: Self) -> Self {
        let mut result = otherwise;
        for (k, mask) in self.into_iter().enumerate() {
            result[k] = mask.blendv(otherwise[k], then[k]);
        }
        result
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::bit_and)
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::bit_or)
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        zip(self, other, SimdBaseOps::bit_xor)
    }

    #[inline(always)]
    fn add_integers(self, other: Self) -> Self {
        zip(self, other, |x, y| {
            SimdBaseOps::add(x.bitcast_i64(), y.bitcast_i64()).bitcast_f64()
        })
    }

    #[inline(always)]
    fn shift_left<const BY: i32>(self) -> Self {
        map(self, |x| x.bitcast_i64().shl_const::<BY>().bitcast_f64())
    }

    #[inline(always)]
    fn mask_bits(self) -> u32 {
        // there is an instruction for the sign bits of bytes
        let (mut bits, mut place) = (0_u64, 0);
        for mask in self {
            let mut numbers = [0.0; LANES];
            mask.copy_to_slice(&mut numbers[..V::WIDTH]);
            let bytes = Bytes::<V>::load_from_slice(cast_slice(&numbers[..V::WIDTH]));
            bits |= bytes.get_mask().to_u64_lossy() << place;
            place += 8 * V::WIDTH;
        }
        ((bits & BYTES).wrapping_mul(TOGETHER) >> 56) as u32
    }
}
