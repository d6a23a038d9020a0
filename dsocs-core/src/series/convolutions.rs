//! The inner sums of recurrences that are interpreted: of any number of products and squares, in pairs of blocks.
//!
//! Their terms are added in the order of [`Table::product_sums`](super::sums::Table::product_sums),
//! [`Table::square_sums`](super::sums::Table::square_sums) and [`inner`](super::formulas::inner), so they have the bits of those sums.

use super::blocks::first;
use super::orders::{LANES, ROWS, Row};
use crate::number::fours::{Fours, OnFours};

/// A row of each block of a pair.
pub(crate) type Rows = [Row<f64>; 2];

/// The operands of a pair of blocks, order by order.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Pair {
    left: [Rows; ROWS],
    /// Those on the right from the highest order down, so that both sides of a convolution are read forwards.
    right: [Rows; ROWS],
    /// The coefficients of order 1, as they stand in the newest terms: those of a square among the products are doubled on the left and 0 on the right.
    newest: [Rows; 2],
}

impl Default for Pair {
    fn default() -> Self {
        Self {
            left: [[[0.0; LANES]; 2]; ROWS],
            right: [[[0.0; LANES]; 2]; ROWS],
            newest: [[[0.0; LANES]; 2]; 2],
        }
    }
}

impl Pair {
    /// Stores the operands of order `k` of a block.
    #[inline(always)]
    pub fn store(&mut self, k: usize, block: usize, [left, right]: [Row<f64>; 2]) {
        self.left[k][block] = left;
        self.right[ROWS - 1 - k][block] = right;
    }

    /// Keeps the operands of order 1 of a block for the newest terms, multiplied by some factors.
    #[inline(always)]
    pub fn keep(&mut self, block: usize, factors: [Row<f64>; 2]) {
        let ones = [self.left[1][block], self.right[ROWS - 2][block]];
        for side in 0..2 {
            for lane in 0..LANES {
                self.newest[side][block][lane] = factors[side][lane] * ones[side][lane];
            }
        }
    }
}

/// The inner sums of order `k`. If `EAGER`, the newest terms are added last.
pub(crate) struct InnerSums<'b, const EAGER: bool> {
    /// The pairs of blocks, products before squares.
    pub pairs: &'b [Pair],
    /// The number of pairs of products, and of leading blocks of them that form one sum in each lane.
    pub products: usize,
    pub ones: usize,
    pub k: usize,
    pub sums: &'b mut [Rows],
}

impl<const EAGER: bool> OnFours<f64> for InnerSums<'_, EAGER> {
    type Output = ();

    #[inline(always)]
    fn run<F: Fours<f64>>(self, fours: F) {
        let k = self.k.clamp(1, ROWS - 1);
        let first = first::<EAGER>(k);
        let (count, back) = (k + 1 - 2 * first, ROWS - 1 - k);
        // without a zip, for which the lengths would be divided by those of pairs
        let mut to = self.sums.iter_mut();
        let mut place = 0;
        let (products, squares) = self.pairs.split_at(self.products.min(self.pairs.len()));
        for pair in products {
            let Some(to) = to.next() else { return };
            let left = &pair.left[first..][..count];
            let right = &pair.right[back + first..][..count];
            let mut sums = if place < self.ones {
                inner::<F, 1>(fours, left, right)
            } else {
                inner::<F, 2>(fours, left, right)
            };
            if EAGER && k > 2 {
                add(fours, &mut sums, &pair.newest[0], &pair.right[back + 1]);
                add(fours, &mut sums, &pair.newest[1], &pair.left[k - 1]);
            }
            *to = [fours.numbers(sums[0]), fours.numbers(sums[1])];
            place += 2;
        }
        for pair in squares {
            let Some(to) = to.next() else { return };
            let left = &pair.left[first..][..count / 2];
            let right = &pair.right[back + first..][..count / 2];
            let mut sums = inner::<F, 1>(fours, left, right);
            sums = [fours.add(sums[0], sums[0]), fours.add(sums[1], sums[1])];
            if k.is_multiple_of(2) {
                let middle = &pair.left[k / 2];
                add(fours, &mut sums, middle, middle);
            }
            if EAGER && k > 2 {
                add(fours, &mut sums, &pair.newest[0], &pair.left[k - 1]);
            }
            *to = [fours.numbers(sums[0]), fours.numbers(sums[1])];
        }
    }
}

/// The sums of the products of rows, in `A` partial sums.
#[inline(always)]
fn inner<F: Fours<f64>, const A: usize>(fours: F, left: &[Rows], right: &[Rows]) -> [F::Row; 2] {
    let ((chunks, rest), (others, other_rest)) = (left.as_chunks::<A>(), right.as_chunks::<A>());
    let mut sums = [[fours.row([0.0; LANES]); 2]; A];
    for (x, y) in chunks.iter().zip(others) {
        for a in 0..A {
            add(fours, &mut sums[a], &x[a], &y[a]);
        }
    }
    if let ([x, ..], [y, ..]) = (rest, other_rest) {
        add(fours, &mut sums[0], x, y);
    }
    let mut total = sums[0];
    for a in 1..A {
        for block in 0..2 {
            total[block] = fours.add(total[block], sums[a][block]);
        }
    }
    total
}

#[inline(always)]
fn add<F: Fours<f64>>(fours: F, sums: &mut [F::Row; 2], x: &Rows, y: &Rows) {
    for block in 0..2 {
        sums[block] = fours.add_product(sums[block], fours.row(x[block]), fours.row(y[block]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::fours::on_doubles;
    use crate::series::blocks::ones;
    use crate::series::formulas;
    use crate::series::sums::Table;

    /// A coefficient of order `k`.
    fn operand(k: usize, side: usize, block: usize, lane: usize) -> f64 {
        ((31 * k + 17 * side + 5 * block + lane) as f64).sin()
    }

    fn have_the_bits_of_a_table<const FUSED: bool, const EAGER: bool, const P: usize>() {
        let mut table = Table::<f64, P, 1, 0>::default();
        let products = P.div_ceil(2);
        let mut pairs = vec![Pair::default(); products + 1];
        // the last lane is a square
        let of = |k: usize, side: usize, block: usize, lane: usize| {
            operand(k, if lane == 3 { 0 } else { side }, block, lane)
        };
        let row = |k: usize, side: usize, block: usize| [0, 1, 2, 3].map(|lane| of(k, side, block, lane));
        let square_row = |k: usize| [0, 1, 2, 3].map(|lane| operand(k, 2, 0, lane));
        for k in 1..24 {
            let mut sums = vec![[[0.0; LANES]; 2]; pairs.len()];
            let work = InnerSums::<EAGER> {
                ones: ones(P),
                pairs: &pairs,
                products,
                k,
                sums: &mut sums,
            };
            on_doubles::<FUSED, _>(work);
            let (of_products, [of_squares]) = (
                table.product_sums::<FUSED, EAGER, 16>(k),
                table.square_sums::<FUSED, EAGER, 4, 0>(k),
            );
            // the coefficients of the orders 1 and `k - 1`
            let newest = |of: &dyn Fn(usize) -> f64| if k > 2 { [of(1), of(k - 1)] } else { [0.0; 2] };
            for lane in 0..LANES {
                for block in 0..P {
                    let mut sum = of_products[block][lane];
                    let sides = [0, 1].map(|side| newest(&|k| of(k, side, block, lane)));
                    if EAGER && lane == 3 {
                        sum = formulas::inner_square::<FUSED, f64>(sum, sides[0]);
                    } else if EAGER {
                        sum = formulas::inner::<FUSED, f64>(sum, sides[0], sides[1]);
                    }
                    assert_eq!(
                        sums[block / 2][block % 2][lane].to_bits(),
                        sum.to_bits(),
                        "{k} {block} {lane}"
                    );
                }
                let mut sum = of_squares[lane];
                if EAGER {
                    sum = formulas::inner_square::<FUSED, f64>(sum, newest(&|k| operand(k, 2, 0, lane)));
                }
                assert_eq!(sums[products][0][lane].to_bits(), sum.to_bits(), "{k} {lane}");
            }
            for block in 0..P {
                let sides = [row(k, 0, block), row(k, 1, block)];
                pairs[block / 2].store(k, block % 2, sides);
                [table.products[block].left[k], table.products[block].right[k]] = sides;
            }
            pairs[products].store(k, 0, [square_row(k); 2]);
            table.squares[0].rows[k] = square_row(k);
            if k == 2 {
                for block in 0..P {
                    pairs[block / 2].keep(block % 2, [[1.0, 1.0, 1.0, 2.0], [1.0, 1.0, 1.0, 0.0]]);
                }
                pairs[products].keep(0, [[2.0; LANES], [0.0; LANES]]);
            }
        }
    }

    #[test]
    fn convolutions_have_the_bits_of_a_table() {
        fn of<const P: usize>() {
            have_the_bits_of_a_table::<false, false, P>();
            have_the_bits_of_a_table::<false, true, P>();
            have_the_bits_of_a_table::<true, false, P>();
            have_the_bits_of_a_table::<true, true, P>();
        }
        of::<1>();
        of::<2>();
        of::<3>();
        of::<4>();
        of::<7>();
    }
}
