//! Blocks of products and of squares of positions and velocities. Their coefficients of order `k` are known before
//! the recurrences of that order begin, so a block's coefficients are complete sums, formed in one register.

// parts of every order, which are compiled for the machine's own instructions
#![allow(clippy::inline_always)]

use super::blocks::{Squares, add_rows, square_sum};
use super::coefficient::Coefficient;
use super::orders::{LANES, ROWS, Row};
use super::sums::add_product;
use crate::number::fours::{Fours, OnFours};

/// The operands of `B` blocks of products, order by order.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Together<T, const B: usize> {
    /// The factors on the left.
    pub(super) left: [[Row<T>; B]; ROWS],
    /// The factors on the right.
    pub(super) right: [[Row<T>; B]; ROWS],
}

impl<T: Coefficient, const B: usize> Default for Together<T, B> {
    fn default() -> Self {
        let zero = [[[T::splat(0.0); LANES]; B]; ROWS];
        Self {
            left: zero,
            right: zero,
        }
    }
}

/// The products of order `k` of some blocks; the operands of that order are stored.
pub(super) struct Products<'b, T, const EAGER: bool, const B: usize, const A: usize> {
    pub blocks: &'b mut Together<T, B>,
    pub k: usize,
    pub now: [&'b [Row<T>; B]; 2],
}

impl<T: Coefficient, const EAGER: bool, const B: usize, const A: usize> OnFours<T>
    for Products<'_, T, EAGER, B, A>
{
    type Output = [Row<T>; B];

    /// Adds the terms in the order of [`crate::series::formulas::product`] and of its inner sum, which is formed in
    /// `A` partial sums.
    #[inline(always)]
    fn run<F: Fours<T>>(self, fours: F) -> [Row<T>; B] {
        let Self { blocks, k, now } = self;
        let Together { left, right } = blocks;
        let mut total;
        if !EAGER {
            total = inner::<T, F, B, A>(fours, &left[1..k], &right[1..k]);
        } else if k > 2 {
            total = inner::<T, F, B, A>(fours, &left[2..k - 1], &right[2..k - 1]);
            add::<T, F, B>(fours, &mut total, &left[1], &right[k - 1]);
            add::<T, F, B>(fours, &mut total, &right[1], &left[k - 1]);
        } else {
            total = [fours.row([T::splat(0.0); LANES]); B];
            if k == 2 {
                add::<T, F, B>(fours, &mut total, &left[1], &right[1]);
            }
        }
        add::<T, F, B>(fours, &mut total, &left[0], now[1]);
        add::<T, F, B>(fours, &mut total, now[0], &right[0]);
        (left[k], right[k]) = (*now[0], *now[1]);
        let mut rows = [[T::splat(0.0); LANES]; B];
        for b in 0..B {
            rows[b] = fours.numbers(total[b]);
        }
        rows
    }
}

/// The sums of the products of the left rows with the right rows in reverse order, in `A` partial sums.
#[inline(always)]
fn inner<T: Coefficient, F: Fours<T>, const B: usize, const A: usize>(
    fours: F,
    left: &[[Row<T>; B]],
    right: &[[Row<T>; B]],
) -> [F::Row; B] {
    let ((ahead, rest), (back_rest, back)) = (left.as_chunks::<A>(), right.as_rchunks::<A>());
    let mut sums = [[fours.row([T::splat(0.0); LANES]); B]; A];
    for (x, y) in ahead.iter().zip(back.iter().rev()) {
        for a in 0..A {
            add::<T, F, B>(fours, &mut sums[a], &x[a], &y[A - 1 - a]);
        }
    }
    if let ([x, ..], [y, ..]) = (rest, back_rest) {
        add::<T, F, B>(fours, &mut sums[0], x, y);
    }
    let mut total = sums[0];
    for a in 1..A {
        for b in 0..B {
            total[b] = fours.add(total[b], sums[a][b]);
        }
    }
    total
}

#[inline(always)]
fn add<T: Coefficient, F: Fours<T>, const B: usize>(
    fours: F,
    sums: &mut [F::Row; B],
    x: &[Row<T>; B],
    y: &[Row<T>; B],
) {
    for b in 0..B {
        sums[b] = fours.add_product(sums[b], fours.row(x[b]), fours.row(y[b]));
    }
}

/// The first `used` products of order `k`, for numbers each of which fills registers by itself.
#[inline(always)]
pub(super) fn one_by_one<T: Coefficient, const B: usize>(
    blocks: &mut Together<T, B>,
    k: usize,
    now: [&[Row<T>; B]; 2],
    used: usize,
) -> [Row<T>; B] {
    let mut rows = [[T::splat(0.0); LANES]; B];
    (blocks.left[k], blocks.right[k]) = (*now[0], *now[1]);
    for b in 0..B {
        let used = used.saturating_sub(LANES * b).min(LANES);
        for j in 1..k {
            add_rows::<T, false>(&mut rows[b], &blocks.left[j][b], &blocks.right[k - j][b], used);
        }
        add_rows::<T, false>(&mut rows[b], &blocks.left[0][b], &now[1][b], used);
        add_rows::<T, false>(&mut rows[b], &now[0][b], &blocks.right[0][b], used);
    }
    rows
}

/// The squares of order `k` of a block; the operands of that order are stored.
pub(super) struct OfSquares<'b, T, const EAGER: bool> {
    pub block: &'b mut Squares<T>,
    pub k: usize,
    pub now: &'b Row<T>,
}

impl<T: Coefficient, const EAGER: bool> OnFours<T> for OfSquares<'_, T, EAGER> {
    type Output = Row<T>;

    #[inline(always)]
    fn run<F: Fours<T>>(self, fours: F) -> Row<T> {
        let Self { block, k, now } = self;
        let mut sum;
        if !EAGER {
            sum = inner_squares::<T, F>(fours, block, k, &block.rows[1..k]);
        } else if k > 2 {
            sum = inner_squares::<T, F>(fours, block, k, &block.rows[2..k - 1]);
            let first = fours.row(block.rows[1]);
            sum = fours.add_product(sum, fours.add(first, first), fours.row(block.rows[k - 1]));
        } else {
            sum = fours.row([T::splat(0.0); LANES]);
            if k == 2 {
                let first = fours.row(block.rows[1]);
                sum = fours.add_product(sum, first, first);
            }
        }
        let start = fours.row(block.rows[0]);
        sum = fours.add_product(sum, fours.add(start, start), fours.row(*now));
        block.rows[k] = *now;
        fours.numbers(sum)
    }
}

/// The sum of products of rows with those at the other end, each product once.
#[inline(always)]
fn inner_squares<T: Coefficient, F: Fours<T>>(
    fours: F,
    block: &Squares<T>,
    k: usize,
    rows: &[Row<T>],
) -> F::Row {
    let mut sum = fours.row([T::splat(0.0); LANES]);
    for (low, high) in rows[..rows.len() / 2].iter().zip(rows.iter().rev()) {
        sum = fours.add_product(sum, fours.row(*low), fours.row(*high));
    }
    sum = fours.add(sum, sum);
    if k.is_multiple_of(2) {
        let middle = fours.row(block.rows[k / 2]);
        sum = fours.add_product(sum, middle, middle);
    }
    sum
}

/// The first `used` squares of order `k`, for numbers each of which fills registers by itself.
#[inline(always)]
pub(super) fn squares_one_by_one<T: Coefficient>(
    block: &mut Squares<T>,
    k: usize,
    now: &Row<T>,
    used: usize,
) -> Row<T> {
    let used = used.min(LANES);
    let mut sum = square_sum::<T, false>(block, k, 1, used);
    for lane in 0..used {
        sum[lane] = add_product::<false, T>(sum[lane], T::splat(2.0) * block.rows[0][lane], now[lane]);
    }
    block.rows[k] = *now;
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::formulas;
    use crate::series::sums::Table;

    /// Operands of all orders; a row for each block.
    fn operands(k: usize, side: usize) -> [Row<f64>; 2] {
        [0, 1].map(|block| [0, 1, 2, 3].map(|lane| ((31 * k + 17 * side + 5 * block + lane) as f64).sin()))
    }

    /// The coefficients of an operand of the orders 1 and `k - 1`; 0 where there is none of that order.
    fn newest(k: usize, of: impl Fn(usize) -> f64) -> [f64; 2] {
        [
            if k > 2 { of(1) } else { 0.0 },
            if k > 1 { of(k - 1) } else { 0.0 },
        ]
    }

    fn bits_of_one_by_one<const FUSED: bool, const EAGER: bool>() {
        let mut together = Table::<f64, 0, 1, 0, 0, 1, 2>::default();
        let mut apart = Table::<f64, 2, 1, 0>::default();
        together.begin_whole([[operands(0, 0)], [operands(0, 1)]], [operands(0, 2)[0]]);
        for k in 1..24 {
            let [left, right, square] = [0, 1, 2].map(|side| operands(k, side));
            let [products] = together.whole_products::<FUSED, EAGER, 8>(k, [[left], [right]]);
            let [squares] = together.whole_squares::<FUSED, EAGER, 4, 1>(k, [square[0]]);
            let sums = apart.product_sums::<FUSED, EAGER, 8>(k);
            let [of_squares] = apart.square_sums::<FUSED, EAGER, 4, 0>(k);
            for lane in 0..LANES {
                for block in 0..2 {
                    let of = |side: usize| move |k: usize| operands(k, side)[block][lane];
                    let mut sum = sums[block][lane];
                    if EAGER {
                        sum = formulas::inner::<FUSED, f64>(sum, newest(k, of(0)), newest(k, of(1)));
                    }
                    let pairs = [0, 1].map(|side| [of(side)(0), of(side)(k)]);
                    let product = formulas::product::<FUSED, f64>(sum, pairs[0], pairs[1]);
                    assert_eq!(products[block][lane].to_bits(), product.to_bits(), "{k}");
                }
                let of = |k: usize| operands(k, 2)[0][lane];
                let mut sum = of_squares[lane];
                if EAGER {
                    sum = formulas::inner_square::<FUSED, f64>(sum, newest(k, of));
                }
                let value = formulas::square::<FUSED, f64>(sum, [of(0), of(k)]);
                assert_eq!(squares[lane].to_bits(), value.to_bits(), "{k}");
            }
            for block in 0..2 {
                (apart.products[block].left[k], apart.products[block].right[k]) = (left[block], right[block]);
            }
            apart.squares[0].rows[k] = square[0];
        }
    }

    #[test]
    fn blocks_have_the_bits_of_their_products() {
        bits_of_one_by_one::<false, false>();
        bits_of_one_by_one::<false, true>();
        bits_of_one_by_one::<true, false>();
        bits_of_one_by_one::<true, true>();
    }
}
