//! Elimination of many rows of doubles: one function for any number of them, for the widest registers that the machine has.
//!
//! Two columns are eliminated at a time, so that an entry is loaded and stored once for both. Every entry has
//! the same operations in the same order as with one column after the other, so the bits are the same.

use pulp::{Arch, Simd, WithSimd};

use super::Pivots;

/// Gauss elimination with partial pivoting, in place, of a square matrix, row by row. The pivots stay on the
/// diagonal.
pub(super) fn eliminate(a: &mut [f64], x: &mut [f64], inverse: &mut [f64]) -> Pivots<f64> {
    Arch::new().dispatch(Elimination { a, x, inverse })
}

/// The matrix, the right-hand side, which becomes the solution, and room for the reciprocals of the pivots.
struct Elimination<'a> {
    a: &'a mut [f64],
    x: &'a mut [f64],
    inverse: &'a mut [f64],
}

impl WithSimd for Elimination<'_> {
    type Output = Pivots<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Pivots<f64> {
        let Self { a, x, inverse } = self;
        let size = x.len();
        let mut odd = false;
        let mut k = 0;
        while k < size {
            odd ^= bring_up(a, x, k);
            inverse[k] = a[k * size + k].recip();
            if k + 1 == size {
                break;
            }
            // the factors replace the eliminated column, and the next pivot needs the next column alone
            let next = a[k * size + k + 1];
            for i in k + 1..size {
                let row = &mut a[i * size + k..i * size + k + 2];
                row[0] *= inverse[k];
                row[1] -= row[0] * next;
            }
            odd ^= bring_up(a, x, k + 1);
            take_two_out(simd, a, x, inverse, k);
            k += 2;
        }
        solve(a, x, inverse, odd)
    }
}

/// Eliminates the columns `k` and `k + 1` from the rows below; the factors of the first replace it.
#[inline(always)]
fn take_two_out<S: Simd>(simd: S, a: &mut [f64], x: &mut [f64], inverse: &mut [f64], k: usize) {
    let size = x.len();
    let (done, below) = a.split_at_mut((k + 2) * size);
    let (first, second) = done[k * size..].split_at_mut(size);
    let factor = second[k];
    for (second, &first) in second[k + 2..].iter_mut().zip(&first[k + 2..]) {
        *second -= factor * first;
    }
    x[k + 1] -= factor * x[k];
    inverse[k + 1] = second[k + 1].recip();
    // from a multiple of the register's length on: the entries before it in the rows below are not read again
    let from = (k + 2) / S::F64_LANES * S::F64_LANES;
    let (first, first_rest) = S::as_simd_f64s(&first[from..]);
    let (second, second_rest) = S::as_simd_f64s(&second[from..]);
    let right = [x[k], x[k + 1]];
    for (row, x) in below.chunks_exact_mut(size).zip(&mut x[k + 2..]) {
        let factors = [row[k], row[k + 1] * inverse[k + 1]];
        let (entries, rest) = S::as_mut_simd_f64s(&mut row[from..]);
        let splat = factors.map(|factor| simd.splat_f64s(factor));
        for ((entry, &first), &second) in entries.iter_mut().zip(first).zip(second) {
            let less = simd.sub_f64s(*entry, simd.mul_f64s(splat[0], first));
            *entry = simd.sub_f64s(less, simd.mul_f64s(splat[1], second));
        }
        for ((entry, &first), &second) in rest.iter_mut().zip(first_rest).zip(second_rest) {
            *entry = without(*entry, factors, [first, second]);
        }
        *x = without(*x, factors, right);
    }
}

/// An entry minus its multiples of two rows.
#[inline(always)]
fn without(entry: f64, factors: [f64; 2], upper: [f64; 2]) -> f64 {
    entry - factors[0] * upper[0] - factors[1] * upper[1]
}

/// Exchanges two rows, so that the one with the largest entry in column `k`, from row `k` down, stands at the place `k`;
/// `false` if it stood there.
#[inline(always)]
fn bring_up(a: &mut [f64], x: &mut [f64], k: usize) -> bool {
    let size = x.len();
    let (mut pivot, mut largest) = (k, a[k * size + k].abs());
    for i in k + 1..size {
        let entry = a[i * size + k].abs();
        if largest < entry {
            (pivot, largest) = (i, entry);
        }
    }
    if pivot == k {
        return false;
    }
    let (above, below) = a.split_at_mut(pivot * size);
    above[k * size..(k + 1) * size].swap_with_slice(&mut below[..size]);
    x.swap(k, pivot);
    true
}

/// Back substitution, from the last unknown to the first.
#[inline(always)]
fn solve(a: &[f64], x: &mut [f64], inverse: &[f64], odd: bool) -> Pivots<f64> {
    let size = x.len();
    let (mut smallest, mut largest) = (f64::INFINITY, 0.0_f64);
    for k in (0..size).rev() {
        let value = x[k] * inverse[k];
        x[k] = value;
        for i in 0..k {
            x[i] -= a[i * size + k] * value;
        }
        let pivot = a[k * size + k].abs();
        smallest = if pivot < smallest { pivot } else { smallest };
        largest = if largest < pivot { pivot } else { largest };
    }
    Pivots {
        smallest,
        largest,
        sign: if odd { -1.0 } else { 1.0 },
    }
}
