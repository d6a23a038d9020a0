//! Linear equations, by elimination: solutions, the inverse, and the sign of the determinant.
//!
//! Every linear system of this crate is solved here: the updates of Newton's iteration, the matrix of a Taylor expansion, the
//! orientation of a step. All of them take columns out by the same function, with the row of the largest entry first.

// parts of every step, and of code that is compiled for the machine's own instructions; sizes are literals there
#![allow(clippy::inline_always)]

use crate::number::scalar::Scalar;

mod many;
pub(crate) mod slices;

/// Up to this many rows are eliminated inline, with loops of literal length; more by [`many`].
const FEW: usize = 8;

/// Smallest determinant for Cramer's rule, and smallest pivot for rows that are not scaled.
pub(crate) const SMALLEST_DETERMINANT: f64 = 1e-100;

/// Largest determinant for Cramer's rule, and largest pivot for rows that are not scaled.
pub(crate) const LARGEST_DETERMINANT: f64 = 1e100;

/// Whether a number fulfils a condition in every lane.
#[inline(always)]
pub(crate) fn every_lane<T: Scalar>(x: T, wanted: impl Fn(f64) -> bool) -> bool {
    (0..T::LANES).all(|lane| wanted(x.lane(lane)))
}

/// Cramer's rule for two equations, where neither overflow nor underflow can harm it.
#[inline]
pub(crate) fn cramer<T: Scalar, const M: usize>(matrix: &[[T; M]; M], right: &[T; M]) -> Option<[T; M]> {
    let determinant = determinant(matrix);
    is_safe(determinant).then(|| quotients(matrix, right, determinant))
}

/// Whether neither overflow nor underflow has harmed Cramer's rule with this determinant.
#[inline(always)]
pub(crate) fn is_safe<T: Scalar>(determinant: T) -> bool {
    every_lane(determinant, |x| {
        x.abs() > SMALLEST_DETERMINANT && x.abs() < LARGEST_DETERMINANT
    })
}

/// The determinant of two rows.
#[inline(always)]
pub(crate) fn determinant<T: Scalar, const M: usize>(matrix: &[[T; M]; M]) -> T {
    matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0]
}

/// The quotients of Cramer's rule.
#[inline(always)]
pub(crate) fn quotients<T: Scalar, const M: usize>(
    matrix: &[[T; M]; M],
    right: &[T; M],
    determinant: T,
) -> [T; M] {
    let ([a, b], [c, d]) = ([matrix[0][0], matrix[0][1]], [matrix[1][0], matrix[1][1]]);
    let scale = determinant.recip();
    let mut solution = *right;
    solution[0] = (right[0] * d - b * right[1]) * scale;
    solution[1] = (a * right[1] - c * right[0]) * scale;
    solution
}

/// Brings the rows of a matrix to a common size by powers of two, and returns these factors.
#[inline(always)]
fn scale_rows<T: Scalar, const M: usize>(a: &mut [[T; M]; M]) -> [T; M] {
    let mut scales = [T::splat(1.0); M];
    for (row, scale) in a.iter_mut().zip(&mut scales) {
        let size = row.iter().fold(T::splat(0.0), |size, entry| {
            T::select_lt(size, entry.abs(), entry.abs(), size)
        });
        [*scale] = T::from_lanes(|lane| [inverse_power_of_two(size.lane(lane))]);
        for entry in row {
            *entry = *entry * *scale;
        }
    }
    scales
}

/// Gauss elimination of rows that are first scaled to a common size.
///
/// Never inlined: the matrix of a large system would double the stack frame of the caller.
#[inline(never)]
pub(crate) fn eliminate_scaled<T: Scalar, const M: usize>(
    matrix: &[[T; M]; M],
    right: &[T; M],
) -> ([T; M], Scaled<T, M>) {
    eliminate_scaled_here(matrix, right)
}

/// [`eliminate_scaled`] inlined into its caller, which is compiled for the machine's own instructions.
#[inline(always)]
pub(crate) fn eliminate_scaled_here<T: Scalar, const M: usize>(
    matrix: &[[T; M]; M],
    right: &[T; M],
) -> ([T; M], Scaled<T, M>) {
    let (mut a, mut x) = (*matrix, *right);
    let scales = scale_rows(&mut a);
    for (x, scale) in x.iter_mut().zip(scales) {
        *x = *x * scale;
    }
    let Pivots { sign, .. } = eliminate_here(&mut a, &mut x);
    let mut pivots = x;
    for (k, pivot) in pivots.iter_mut().enumerate() {
        *pivot = a[k][k] / scales[k];
    }
    (x, Scaled { sign, pivots })
}

/// Sign and pivots of the elimination of scaled rows, as factors of the determinant of the unscaled ones.
pub(crate) struct Scaled<T, const M: usize> {
    /// -1 where rows were exchanged an odd number of times, 1 elsewhere.
    pub sign: T,
    /// The pivots, with the scaling of the rows undone.
    pub pivots: [T; M],
}

impl<T: Scalar, const M: usize> Scaled<T, M> {
    /// The determinant in the first lane.
    #[inline(always)]
    pub fn determinant(&self) -> Determinant {
        Determinant::of_pivots(
            self.pivots.iter().map(|pivot| pivot.lane(0)),
            self.sign.lane(0) < 0.0,
        )
    }
}

/// Sizes of the pivots and sign of the row exchanges after an elimination.
pub(crate) struct Pivots<T> {
    /// The absolute value of the smallest.
    pub smallest: T,
    /// The absolute value of the largest.
    pub largest: T,
    /// -1 where rows were exchanged an odd number of times, 1 elsewhere.
    pub sign: T,
}

/// Gauss elimination with partial pivoting, in place. The pivots stay on the diagonal.
///
/// Several lanes exchange rows by selection instead of branches, because they may differ in their pivots.
#[inline]
pub(crate) fn eliminate<T: Scalar, const M: usize>(a: &mut [[T; M]; M], x: &mut [T; M]) -> Pivots<T> {
    eliminate_here(a, x)
}

/// [`eliminate`] inlined into its caller, which is compiled for the machine's own instructions.
#[inline(always)]
pub(crate) fn eliminate_here<T: Scalar, const M: usize>(a: &mut [[T; M]; M], x: &mut [T; M]) -> Pivots<T> {
    if M > FEW
        && let (Some(a), Some(x)) = (T::doubles(a.as_flattened_mut()), T::doubles(x))
    {
        let Pivots {
            smallest,
            largest,
            sign,
        } = many::eliminate(a, x, &mut [0.0; M]);
        let [smallest, largest, sign] = [smallest, largest, sign].map(T::splat);
        return Pivots {
            smallest,
            largest,
            sign,
        };
    }
    let mut inverse = *x; // reciprocals of the pivots
    let mut exchanges = Solution { sign: T::splat(1.0) };
    take_all_out(a, x, &mut inverse, &mut exchanges);
    let (mut smallest, mut largest) = (T::splat(f64::INFINITY), T::splat(0.0));
    for k in (0..M).rev() {
        let value = x[k] * inverse[k];
        x[k] = value;
        for i in 0..k {
            x[i] = x[i] - a[i][k] * value;
        }
        let size = a[k][k].abs();
        smallest = T::select_lt(size, smallest, size, smallest);
        largest = T::select_lt(largest, size, size, largest);
    }
    Pivots {
        smallest,
        largest,
        sign: exchanges.sign,
    }
}

/// A determinant, `value · 2^exponent`: those of many rows would soon leave the range of doubles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Determinant {
    /// The number, with the sign.
    pub value: f64,
    /// The exponent of the power of two.
    pub exponent: i32,
}

impl Determinant {
    /// A determinant in the range of doubles; those of one and two rows are assumed to be.
    #[inline]
    pub(crate) fn of(value: f64) -> Self {
        Self { value, exponent: 0 }
    }

    /// The product of pivots.
    #[inline]
    pub(crate) fn of_pivots(pivots: impl Iterator<Item = f64>, odd: bool) -> Self {
        let first = Self {
            value: if odd { -1.0 } else { 1.0 },
            exponent: 0,
        };
        pivots.fold(first, Self::times)
    }

    /// The product with another pivot.
    #[inline]
    pub(crate) fn times(self, pivot: f64) -> Self {
        let (mantissa, exponent) = split(pivot);
        Self {
            value: self.value * mantissa,
            exponent: self.exponent + exponent,
        }
    }

    /// An unknown determinant.
    pub(crate) const UNKNOWN: Self = Self {
        value: f64::NAN,
        exponent: 0,
    };

    /// The determinant divided by `2^exponent`, within the range of doubles.
    #[inline]
    pub(crate) fn in_units_of(self, exponent: i32) -> f64 {
        if self.exponent == exponent {
            return self.value;
        }
        self.value * 2.0_f64.powi(self.exponent.saturating_sub(exponent))
    }
}

/// A normal number as `m · 2^e` with `1 ≤ |m| < 2`; zero, subnormal numbers, infinity and NaN stay as they are.
#[inline]
#[allow(clippy::cast_possible_truncation)] // eleven bits
fn split(x: f64) -> (f64, i32) {
    const EXPONENT: u64 = 0x7ff << 52;
    let bits = x.to_bits();
    let exponent = ((bits & EXPONENT) >> 52) as i32;
    if exponent == 0 || exponent == 0x7ff {
        return (x, 0);
    }
    (f64::from_bits(bits & !EXPONENT | 1023 << 52), exponent - 1023)
}

/// The inverse, by columns, and the sign of the determinant; rows may differ in size by hundreds of orders of magnitude. NaN if it is singular. Products
/// and sums are rounded once if `FUSED`.
///
/// Gauss and Jordan's elimination, on rows in registers: of eight rows it takes a tenth of the time of a factorisation with
/// as many back substitutions.
#[inline(always)]
pub(crate) fn inverse<const FUSED: bool, const M: usize>(matrix: &[[f64; M]; M]) -> ([[f64; M]; M], f64) {
    let mut left = *matrix;
    let scales = scale_rows(&mut left);
    let mut right = [[0.0; M]; M];
    for (i, (row, scale)) in right.iter_mut().zip(scales).enumerate() {
        row[i] = scale;
    }
    let mut pivots = [0.0; M];
    let mut kind = Inverse::<FUSED> { sign: 1.0 };
    take_all_out(&mut left, &mut right, &mut pivots, &mut kind);
    if !pivots.iter().all(|pivot| pivot.is_finite()) {
        return ([[f64::NAN; M]; M], f64::NAN);
    }
    let mut columns = [[0.0; M]; M];
    for (j, column) in columns.iter_mut().enumerate() {
        for (i, entry) in column.iter_mut().enumerate() {
            *entry = right[i][j] * pivots[i];
        }
    }
    (columns, sign_of(kind.sign, &pivots))
}

/// The sign of a product: `sign`, changed by every negative factor.
#[inline(always)]
fn sign_of(sign: f64, factors: &[f64]) -> f64 {
    let bits = factors.iter().fold(sign.to_bits(), |bits, factor| {
        bits ^ (factor.to_bits() & f64::to_bits(-0.0))
    });
    f64::from_bits(bits)
}

/// The determinant; rows may differ in size by hundreds of orders of magnitude.
pub(crate) fn determinant_of<const M: usize>(matrix: &[[f64; M]; M]) -> Determinant {
    let mut a = *matrix;
    let mut exchanges = Exchanges { odd: false };
    take_all_out(&mut a, &mut [(); M], &mut [0.0; M], &mut exchanges);
    Determinant::of_pivots((0..M).map(|k| a[k][k]), exchanges.odd)
}

/// The operations of elimination on the entries of a matrix and on its right-hand sides `R`.
trait Kind<T, R, const M: usize> {
    /// Whether columns are eliminated above the diagonal, too.
    const ABOVE: bool = false;

    /// Whether rows with a zero entry in the column are skipped. Most are zero if bodies are joined to few
    /// others.
    const SKIPS: bool = false;

    /// Brings the row with the largest entry in column `k`, from row `k` down, to the place `k`.
    fn bring_up(&mut self, a: &mut [[T; M]; M], x: &mut [R; M], k: usize);

    /// `lower - factor · upper`, of entries.
    fn minus(lower: T, factor: T, upper: T) -> T;

    /// `lower - factor · upper`, of right-hand sides.
    fn minus_right(lower: R, factor: T, upper: R) -> R;
}

/// One right-hand side, in one lane or in several.
struct Solution<T> {
    /// -1 where rows were exchanged an odd number of times, 1 elsewhere.
    sign: T,
}

impl<T: Scalar, const M: usize> Kind<T, T, M> for Solution<T> {
    #[inline(always)]
    fn bring_up(&mut self, a: &mut [[T; M]; M], x: &mut [T; M], k: usize) {
        if T::LANES > 1 {
            self.sign = exchange(a, x, k, self.sign);
        } else if swap_up(a, x, k) {
            self.sign = -self.sign;
        }
    }

    #[inline(always)]
    fn minus(lower: T, factor: T, upper: T) -> T {
        lower - factor * upper
    }

    #[inline(always)]
    fn minus_right(lower: T, factor: T, upper: T) -> T {
        lower - factor * upper
    }
}

/// The columns of the identity as right-hand sides: elimination gives the inverse.
struct Inverse<const FUSED: bool> {
    /// -1 where rows were exchanged an odd number of times, 1 elsewhere.
    sign: f64,
}

impl<const FUSED: bool, const M: usize> Kind<f64, [f64; M], M> for Inverse<FUSED> {
    const ABOVE: bool = true;
    const SKIPS: bool = true;

    #[inline(always)]
    fn bring_up(&mut self, a: &mut [[f64; M]; M], x: &mut [[f64; M]; M], k: usize) {
        if swap_up(a, x, k) {
            self.sign = -self.sign;
        }
    }

    #[inline(always)]
    fn minus(lower: f64, factor: f64, upper: f64) -> f64 {
        if FUSED {
            (-factor).mul_add(upper, lower)
        } else {
            lower - factor * upper
        }
    }

    #[inline(always)]
    fn minus_right(lower: [f64; M], factor: f64, upper: [f64; M]) -> [f64; M] {
        core::array::from_fn(|j| <Self as Kind<f64, [f64; M], M>>::minus(lower[j], factor, upper[j]))
    }
}

/// No right-hand side: elimination gives the determinant.
struct Exchanges {
    /// Whether rows were exchanged an odd number of times.
    odd: bool,
}

impl<const M: usize> Kind<f64, (), M> for Exchanges {
    #[inline]
    fn bring_up(&mut self, a: &mut [[f64; M]; M], x: &mut [(); M], k: usize) {
        self.odd ^= swap_up(a, x, k);
    }

    #[inline]
    fn minus(lower: f64, factor: f64, upper: f64) -> f64 {
        lower - factor * upper
    }

    #[inline]
    fn minus_right((): (), _: f64, (): ()) {}
}

/// Eliminates every column; `inverse` receives the reciprocals of the pivots.
#[inline(always)]
fn take_all_out<T: Scalar, R: Copy, K: Kind<T, R, M>, const M: usize>(
    a: &mut [[T; M]; M],
    x: &mut [R; M],
    inverse: &mut [T; M],
    kind: &mut K,
) {
    if M <= FEW {
        macro_rules! columns {
            ($($k:literal)*) => {
                $(if $k < M { take_out(a, x, inverse, kind, $k); })*
            };
        }
        columns!(0 1 2 3 4 5 6 7);
    } else {
        for k in 0..M {
            take_out(a, x, inverse, kind, k);
        }
    }
}

/// Whether an entry is zero in every lane.
#[inline(always)]
fn is_zero<T: Scalar>(entry: T) -> bool {
    every_lane(entry, |x| x == 0.0)
}

/// Eliminates column `k` from the other rows, after the row with its largest entry was brought to the place
/// `k`.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // unrolled: `k` is a constant
fn take_out<T: Scalar, R: Copy, K: Kind<T, R, M>, const M: usize>(
    a: &mut [[T; M]; M],
    x: &mut [R; M],
    inverse: &mut [T; M],
    kind: &mut K,
    k: usize,
) {
    kind.bring_up(a, x, k);
    inverse[k] = a[k][k].recip();
    let first = if K::ABOVE { 0 } else { k + 1 };
    for i in first..M {
        if i == k || (K::SKIPS && M > FEW && is_zero(a[i][k])) {
            continue;
        }
        let factor = a[i][k] * inverse[k];
        for j in k + 1..M {
            a[i][j] = K::minus(a[i][j], factor, a[k][j]);
        }
        x[i] = K::minus_right(x[i], factor, x[k]);
    }
}

/// Exchanges two rows, so that the one with the largest entry in column `k`, from row `k` down, stands at the place `k`;
/// `false` if it stood there.
#[inline(always)]
fn swap_up<T: Scalar, R, const M: usize>(a: &mut [[T; M]; M], x: &mut [R; M], k: usize) -> bool {
    let (mut pivot, mut largest) = (k, a[k][k].abs().lane(0));
    for (i, row) in a.iter().enumerate().skip(k + 1) {
        let size = row[k].abs().lane(0);
        if largest < size {
            (pivot, largest) = (i, size);
        }
    }
    if pivot != k {
        a.swap(k, pivot);
        x.swap(k, pivot);
    }
    pivot != k
}

/// [`swap_up`] in each lane by itself; returns `sign`, reversed in lanes whose rows were exchanged.
#[inline(always)]
fn exchange<T: Scalar, const M: usize>(a: &mut [[T; M]; M], x: &mut [T; M], k: usize, sign: T) -> T {
    let (mut pivot, mut largest) = (T::splat(k as f64), a[k][k].abs());
    for (i, row) in a.iter().enumerate().skip(k + 1) {
        let size = row[k].abs();
        pivot = T::select_lt(largest, size, T::splat(i as f64), pivot);
        largest = T::select_lt(largest, size, size, largest);
    }
    for i in k + 1..M {
        let (head, tail) = a.split_at_mut(i);
        for j in k..M {
            exchange_where(i, pivot, &mut head[k][j], &mut tail[0][j]);
        }
        let (head, tail) = x.split_at_mut(i);
        exchange_where(i, pivot, &mut head[k], &mut tail[0]);
    }
    T::select_le(pivot, T::splat(k as f64), sign, -sign)
}

/// Exchanges two numbers in the lanes whose pivot stands in row `i`.
#[inline(always)]
fn exchange_where<T: Scalar>(i: usize, pivot: T, upper: &mut T, lower: &mut T) {
    let (place, u, l) = (T::splat(i as f64), *upper, *lower);
    *upper = T::select_le(pivot, place, T::select_le(place, pivot, l, u), u);
    *lower = T::select_le(pivot, place, T::select_le(place, pivot, u, l), l);
}

/// The power of two that brings a positive number into `[1, 2)`, as far as a normal number can; 1 for zero, NaN for
/// infinity.
pub(crate) fn inverse_power_of_two(size: f64) -> f64 {
    if size == 0.0 {
        return 1.0;
    }
    if size == f64::INFINITY {
        return f64::NAN;
    }
    let exponent = (size.to_bits() >> 52) & 0x7ff;
    f64::from_bits(2046_u64.saturating_sub(exponent).clamp(1, 2045) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn determinants_have_their_signs_and_sizes() {
        let of = |determinant: Determinant| determinant.in_units_of(0);
        assert_eq!(of(determinant_of::<0>(&[])), 1.0);
        assert_eq!(of(determinant_of(&[[-3.0]])), -3.0);
        assert_eq!(of(determinant_of(&[[0.0, 1e-200], [1e200, 5.0]])), -1.0);
        let odd = [[0.0, 0.0, 2.0], [0.0, 3.0, 1.0], [4.0, 1.0, 1.0]];
        assert_eq!(of(determinant_of(&odd)), -24.0);
        let even = [[0.0, 2.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 0.0]];
        assert_eq!(of(determinant_of(&even)), 24.0);
        let small = determinant_of(&[[1e-200, 0.0, 0.0], [0.0, -1e-200, 0.0], [0.0, 0.0, 1e-200]]);
        assert!(small.exponent < -1900 && small.value < 0.0);
        assert_eq!(small.in_units_of(small.exponent), small.value);
        assert!(of(determinant_of(&[[f64::NAN]])).is_nan());
        assert_eq!(of(determinant_of(&[[1.0, 2.0], [2.0, 4.0]])), 0.0);
    }

    #[test]
    fn inverses_of_slices_have_the_bits_of_arrays() {
        fn compare<const M: usize>(seed: u64) {
            let mut state = seed;
            let mut number = || {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
            };
            let mut matrix = [[0.0; M]; M];
            for row in &mut matrix {
                let scale = 10_f64.powf(100.0 * number());
                for entry in row {
                    *entry = scale * number();
                }
            }
            let (mut right, mut pivots, mut columns) = (vec![0.0; M * M], vec![0.0; M], vec![0.0; M * M]);
            for fused in [false, true] {
                let mut rows = matrix.as_flattened().to_vec();
                let room = (&mut right[..], &mut pivots[..], &mut columns[..]);
                let inverse = if fused {
                    slices::inverse::<true>(&mut rows, room.0, room.1, room.2);
                    inverse::<true, M>(&matrix).0
                } else {
                    slices::inverse::<false>(&mut rows, room.0, room.1, room.2);
                    inverse::<false, M>(&matrix).0
                };
                let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(inverse.as_flattened()), bits(&columns));
                assert!(columns.iter().all(|x| x.is_finite()));
            }
        }
        for seed in 1..20 {
            compare::<1>(seed);
            compare::<2>(seed);
            compare::<5>(seed);
            compare::<8>(seed);
            compare::<13>(seed);
        }
        let (mut right, mut pivots, mut columns) = ([0.0; 4], [0.0; 2], [0.0; 4]);
        slices::inverse::<false>(&mut [1.0, 2.0, 2.0, 4.0], &mut right, &mut pivots, &mut columns);
        assert!(columns.iter().all(|x| x.is_nan()));
    }

    #[test]
    fn many_rows_are_eliminated_as_few_are() {
        /// Column by column, as few rows are.
        #[allow(clippy::needless_range_loop)] // the textbook form
        fn one_by_one<const M: usize>(a: &mut [[f64; M]; M], x: &mut [f64; M]) -> bool {
            let (mut inverse, mut odd) = ([0.0; M], false);
            for k in 0..M {
                odd ^= swap_up(a, x, k);
                inverse[k] = a[k][k].recip();
                for i in k + 1..M {
                    let factor = a[i][k] * inverse[k];
                    for j in k + 1..M {
                        a[i][j] -= factor * a[k][j];
                    }
                    x[i] -= factor * x[k];
                }
            }
            for k in (0..M).rev() {
                x[k] *= inverse[k];
                for i in 0..k {
                    x[i] -= a[i][k] * x[k];
                }
            }
            odd
        }
        fn check<const M: usize>(seed: &mut u32) {
            let mut next = || {
                *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(*seed) / f64::from(u32::MAX) - 0.5
            };
            let matrix: [[f64; M]; M] = core::array::from_fn(|_| core::array::from_fn(|_| next()));
            let right: [f64; M] = core::array::from_fn(|_| next());
            let [mut a, mut b] = [matrix; 2];
            let [mut x, mut y] = [right; 2];
            let pivots = eliminate(&mut a, &mut x);
            let odd = one_by_one(&mut b, &mut y);
            assert_eq!(x, y);
            assert_eq!(pivots.sign, if odd { -1.0 } else { 1.0 });
            let sizes: [f64; M] = core::array::from_fn(|k| b[k][k].abs());
            assert_eq!(core::array::from_fn::<_, M, _>(|k| a[k][k].abs()), sizes);
            assert_eq!(pivots.smallest, sizes.into_iter().fold(f64::INFINITY, f64::min));
            assert_eq!(pivots.largest, sizes.into_iter().fold(0.0, f64::max));
        }
        let mut seed = 1;
        for _ in 0..20 {
            check::<9>(&mut seed);
            check::<10>(&mut seed);
            check::<17>(&mut seed);
            check::<32>(&mut seed);
        }
    }

    #[test]
    fn the_inverse_is_the_inverse() {
        let matrix = [[3e150, 1e150, 0.0], [1e-140, -2e-140, 5e-141], [0.0, 4.0, 1.0]];
        for columns in [inverse::<false, 3>(&matrix), inverse::<true, 3>(&matrix)] {
            for (i, row) in matrix.iter().enumerate() {
                for (j, column) in columns.0.iter().enumerate() {
                    let product: f64 = row.iter().zip(column).map(|(a, b)| a * b).sum();
                    let terms: f64 = row.iter().zip(column).map(|(a, b)| (a * b).abs()).sum();
                    let identity = if i == j { 1.0 } else { 0.0 };
                    assert!((product - identity).abs() < 1e-15 * terms.max(1.0), "{product}");
                }
            }
        }
        let singular = inverse::<false, 2>(&[[1.0, 2.0], [2.0, 4.0]]);
        assert!(singular.0.as_flattened().iter().all(|x| x.is_nan()));
    }
}
