//! Blocks of inner sums, four in a row.

// parts of every order, which are compiled for the machine's own instructions
#![allow(clippy::inline_always)]

use super::coefficient::Coefficient;
use super::orders::{LANES, ROWS, Row};
use super::sums::add_product;

/// The operands of some inner sums, order by order.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Products<T = f64> {
    /// The factors on the left.
    pub left: [Row<T>; ROWS],
    /// The factors on the right.
    pub right: [Row<T>; ROWS],
}

impl<T: Coefficient> Default for Products<T> {
    fn default() -> Self {
        let zero = [[T::splat(0.0); LANES]; ROWS];
        Self {
            left: zero,
            right: zero,
        }
    }
}

/// The operands of some inner sums of squares, order by order.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Squares<T = f64> {
    /// The operands.
    pub rows: [Row<T>; ROWS],
}

impl<T: Coefficient> Default for Squares<T> {
    fn default() -> Self {
        Self {
            rows: [[T::splat(0.0); LANES]; ROWS],
        }
    }
}

#[inline(always)]
pub(super) fn add_rows<T: Coefficient, const FUSED: bool>(
    sum: &mut Row<T>,
    a: &Row<T>,
    b: &Row<T>,
    used: usize,
) {
    for lane in 0..used.min(LANES) {
        sum[lane] = add_product::<FUSED, T>(sum[lane], a[lane], b[lane]);
    }
}

/// The lowest order of an inner sum.
#[inline(always)]
pub(super) fn first<const EAGER: bool>(k: usize) -> usize {
    if EAGER && k > 2 { 2 } else { 1 }
}

/// The number of leading blocks that form one sum in each lane. The others form two, which need not wait for each
/// other: there are registers for those of at most two blocks, and for the ones beyond a multiple of four.
#[inline(always)]
pub(crate) fn ones(blocks: usize) -> usize {
    match blocks {
        0..=2 => 0,
        3..=4 => blocks,
        many => many - many % 4,
    }
}

/// The inner sums of any number of blocks, without the terms of the orders 1 and `k-1`.
#[inline(always)]
pub(crate) fn inner_sums<const FUSED: bool>(blocks: &[Products], k: usize, sums: &mut [Row<f64>]) {
    let ((pairs, rest), (to_pairs, to_rest)) = (blocks.as_chunks::<2>(), sums.as_chunks_mut::<2>());
    for (sums, blocks) in to_pairs.iter_mut().zip(pairs) {
        *sums = together::<f64, FUSED, 2, 2>(blocks, k, 2);
    }
    for (sum, block) in to_rest.iter_mut().zip(rest) {
        [*sum] = together::<f64, FUSED, 1, 2>(core::array::from_ref(block), k, 2);
    }
}

/// The inner sums of blocks, two blocks in one loop; each is `A` sums side by side.
#[inline(always)]
pub(super) fn in_pairs<T: Coefficient, const FUSED: bool, const A: usize>(
    blocks: &[Products<T>],
    k: usize,
    first: usize,
    sums: &mut [Row<T>],
) {
    let ((pairs, rest), (to_pairs, to_rest)) = (blocks.as_chunks::<2>(), sums.as_chunks_mut::<2>());
    for (to, pair) in to_pairs.iter_mut().zip(pairs) {
        *to = along_rows::<T, FUSED, 2, A>(pair, k, first);
    }
    for (to, block) in to_rest.iter_mut().zip(rest) {
        [*to] = along_rows::<T, FUSED, 1, A>(core::array::from_ref(block), k, first);
    }
}

/// [`together`] with rows that are iterated over: faster where more sums follow.
#[inline(always)]
fn along_rows<T: Coefficient, const FUSED: bool, const P: usize, const A: usize>(
    blocks: &[Products<T>; P],
    k: usize,
    first: usize,
) -> [Row<T>; P] {
    let end = (k + 1).saturating_sub(first);
    // as many rows from the left as from the right, which are read backwards
    let rows: [[&[Row<T>]; 2]; P] = core::array::from_fn(|p| {
        [&blocks[p].left, &blocks[p].right].map(|rows| rows.get(first..end).unwrap_or_default())
    });
    let mut sums = [[[T::splat(0.0); LANES]; A]; P];
    let mut total = [[T::splat(0.0); LANES]; P];
    let chunks = rows.map(|[left, right]| (left.as_chunks::<A>(), right.as_rchunks::<A>()));
    let mut add = |p: usize, left: &[Row<T>; A], right: &[Row<T>; A]| {
        for a in 0..A {
            add_rows::<T, FUSED>(&mut sums[p][a], &left[a], &right[A - 1 - a], LANES);
        }
    };
    if P == 2 {
        // both blocks have as many rows
        let [one, other] = [0, P - 1].map(|p| chunks[p].0.0.iter().zip(chunks[p].1.1.iter().rev()));
        for ((left, right), (other_left, other_right)) in one.zip(other) {
            add(0, left, right);
            add(P - 1, other_left, other_right);
        }
    } else {
        for (p, ((left, _), (_, right))) in chunks.iter().enumerate() {
            for (left, right) in left.iter().zip(right.iter().rev()) {
                add(p, left, right);
            }
        }
    }
    for (p, ((_, left), (right, _))) in chunks.iter().enumerate() {
        for (left, right) in left.iter().zip(right.iter().rev()) {
            add_rows::<T, FUSED>(&mut sums[p][0], left, right, LANES);
        }
        total[p] = sums[p][0];
        for sum in &sums[p][1..] {
            for lane in 0..LANES {
                total[p][lane] = total[p][lane] + sum[lane];
            }
        }
    }
    total
}

/// `Σ left_j right_{k-j}` over `first ≤ j ≤ k - first` for each block, in `A` partial sums, whose additions need not
/// wait for each other. Rows are split off both ends, so that no place is compared with a length.
#[inline(always)]
pub(super) fn together<T: Coefficient, const FUSED: bool, const P: usize, const A: usize>(
    blocks: &[Products<T>; P],
    k: usize,
    first: usize,
) -> [Row<T>; P] {
    let end = (k.clamp(1, ROWS - 1) + 1).saturating_sub(first);
    // as many rows from the left as from the right, which are read backwards
    let mut ahead: [&[Row<T>]; P] = [&[]; P];
    let mut back = ahead;
    for p in 0..P {
        ahead[p] = blocks[p].left.get(first..end).unwrap_or_default();
        back[p] = blocks[p].right.get(first..end).unwrap_or_default();
    }
    let mut sums = [[[T::splat(0.0); LANES]; A]; P];
    'rows: loop {
        for p in 0..P {
            let split = (ahead[p].split_first_chunk::<A>(), back[p].split_last_chunk::<A>());
            let (Some((left, later)), Some((earlier, right))) = split else {
                break 'rows;
            };
            for a in 0..A {
                add_rows::<T, FUSED>(&mut sums[p][a], &left[a], &right[A - 1 - a], LANES);
            }
            (ahead[p], back[p]) = (later, earlier);
        }
        if P == 0 {
            break;
        }
    }
    let mut total = [[T::splat(0.0); LANES]; P];
    for p in 0..P {
        let (mut later, mut earlier) = (ahead[p], back[p]);
        while let ([left, rest @ ..], [others @ .., right]) = (later, earlier) {
            add_rows::<T, FUSED>(&mut sums[p][0], left, right, LANES);
            (later, earlier) = (rest, others);
        }
        total[p] = sums[p][0];
        for sum in &sums[p][1..] {
            for lane in 0..LANES {
                total[p][lane] = total[p][lane] + sum[lane];
            }
        }
    }
    total
}

/// The first sums of one block, each of which fills registers alone.
#[inline(always)]
pub(super) fn some<T: Coefficient>(block: &Products<T>, k: usize, used: usize) -> Row<T> {
    let k = k.clamp(1, ROWS - 1);
    let mut sums = [T::splat(0.0); LANES];
    for j in 1..k {
        add_rows::<T, false>(&mut sums, &block.left[j], &block.right[k - j], used);
    }
    sums
}

/// `Σ x_j x_{k-j}` over `first ≤ j ≤ k - first`, each product once.
#[inline(always)]
pub(super) fn square_sum<T: Coefficient, const FUSED: bool>(
    block: &Squares<T>,
    k: usize,
    first: usize,
    used: usize,
) -> Row<T> {
    let k = k.clamp(1, ROWS - 1);
    let mut sum = [T::splat(0.0); LANES];
    for j in first..k.div_ceil(2) {
        add_rows::<T, FUSED>(&mut sum, &block.rows[j], &block.rows[k - j], used);
    }
    for x in &mut sum {
        *x = *x * T::splat(2.0);
    }
    if k.is_multiple_of(2) {
        add_rows::<T, FUSED>(&mut sum, &block.rows[k / 2], &block.rows[k / 2], used);
    }
    sum
}
