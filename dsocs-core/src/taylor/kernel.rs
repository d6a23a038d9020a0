//! Inner sums of recurrences, in lanes.
//!
//! A recurrence of order `k` needs `Σ x_j y_{k-j}`. The terms with `0 < j < k` are of lower orders: they are formed for all
//! recurrences of a system together, [`LANES`] at a time, and the generated code adds the rest. Coefficients of one order
//! stand side by side, so that neither stream of a convolution has to be reversed.

use super::jet::Tape;
use super::switch::{Switch, Switches};

/// The highest order of a series.
pub const MAX_ORDER: usize = 40;

/// Rows of a table: one for each order, and one that a position is ahead of its velocity.
pub(crate) const ROWS: usize = MAX_ORDER + 2;

/// How many inner sums stand side by side.
pub const LANES: usize = 4;

/// `1/k`, and infinity for 0.
pub const RECIPROCALS: [f64; ROWS] = {
    let mut table = [f64::INFINITY; ROWS];
    let mut k = 1;
    while k < ROWS {
        table[k] = 1.0 / k as f64;
        k += 1;
    }
    table
};

/// Coefficients of one order.
type Row = [f64; LANES];

/// The operands of some inner sums, order by order.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Products {
    /// The factors on the left.
    pub left: [Row; ROWS],
    /// The factors on the right.
    pub right: [Row; ROWS],
}

/// The operands of some inner sums of squares, order by order.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Squares {
    /// The operands.
    pub rows: [Row; ROWS],
}

/// What the recurrences of a system keep of the orders before: `P` blocks of products, `S` of squares, `C` calls of the
/// user's functions, `W` switches.
#[derive(Debug)]
pub struct Table<const P: usize, const S: usize, const C: usize, const W: usize = 0> {
    /// Operands of products.
    pub products: Box<[Products; P]>,
    /// Operands of squares.
    pub squares: Box<[Squares; S]>,
    /// The functions of the user's, recorded.
    pub calls: Box<[Tape; C]>,
    /// What decides between pieces.
    pub switches: Box<[Switch; W]>,
}

impl<const P: usize, const S: usize, const C: usize, const W: usize> Default for Table<P, S, C, W> {
    fn default() -> Self {
        let zero = [[0.0; LANES]; ROWS];
        Self {
            products: boxed(&Products {
                left: zero,
                right: zero,
            }),
            squares: boxed(&Squares { rows: zero }),
            calls: boxed(&Tape::default()),
            switches: boxed(&Switch::default()),
        }
    }
}

/// An array that was never on the stack.
fn boxed<T: Clone, const M: usize>(element: &T) -> Box<[T; M]> {
    match vec![element.clone(); M].into_boxed_slice().try_into() {
        Ok(array) => array,
        // the lengths are equal
        Err(_) => Box::new(core::array::from_fn(|_| element.clone())),
    }
}

impl<const P: usize, const S: usize, const C: usize, const W: usize> Switches for Table<P, S, C, W> {
    const GROUPS: usize = if W + C == 0 { 0 } else { 1 + C };

    fn group(&mut self, group: usize) -> &mut [Switch] {
        match group.checked_sub(1) {
            None => &mut *self.switches,
            Some(call) => self.calls.get_mut(call).map_or(&mut [], Tape::switches),
        }
    }

    fn enter(&mut self) -> bool {
        let mut any = false;
        for call in self.calls.iter_mut() {
            any |= call.enter();
        }
        any
    }
}

impl<const P: usize, const S: usize, const C: usize, const W: usize> Table<P, S, C, W> {
    /// The inner sums of products of order `k`; if `EAGER` and `k > 2`, without the terms of the orders 1 and `k-1`.
    #[inline(always)]
    #[must_use]
    pub fn product_sums<const FUSED: bool, const EAGER: bool>(&self, k: usize) -> [Row; P] {
        // a few blocks share the loop: there are registers for all of their sums, and the loop is most of the work
        if P <= 2 {
            return together::<FUSED, P, 2>(&self.products, k, first::<EAGER>(k));
        }
        if P <= 4 {
            return together::<FUSED, P, 1>(&self.products, k, first::<EAGER>(k));
        }
        let mut sums = [[0.0; LANES]; P];
        let first = first::<EAGER>(k);
        let (fours, rest) = self.products.as_chunks::<4>();
        let (sums_of_fours, sums_of_rest) = sums.as_chunks_mut::<4>();
        for (sums, blocks) in sums_of_fours.iter_mut().zip(fours) {
            *sums = together::<FUSED, 4, 1>(blocks, k, first);
        }
        for (sum, block) in sums_of_rest.iter_mut().zip(rest) {
            [*sum] = together::<FUSED, 1, 2>(core::array::from_ref(block), k, first);
        }
        sums
    }

    /// The inner sums of squares of order `k`, as [`Table::product_sums`].
    #[inline(always)]
    #[must_use]
    pub fn square_sums<const FUSED: bool, const EAGER: bool>(&self, k: usize) -> [Row; S] {
        let mut sums = [[0.0; LANES]; S];
        for (sum, block) in sums.iter_mut().zip(self.squares.iter()) {
            *sum = square_sum::<FUSED>(block, k, first::<EAGER>(k));
        }
        sums
    }
}

/// `sum + a b`, rounded once if `FUSED`.
#[inline(always)]
#[must_use]
pub fn add_product<const FUSED: bool>(sum: f64, a: f64, b: f64) -> f64 {
    if FUSED { a.mul_add(b, sum) } else { sum + a * b }
}

/// `Σ c_i x_i`, in four sums side by side: one alone would wait for itself.
#[inline(always)]
#[must_use]
pub fn weighted<const FUSED: bool, const M: usize>(c: [f64; M], x: [f64; M]) -> f64 {
    let mut sums = [0.0; 4];
    for i in 0..M {
        sums[i % 4] = add_product::<FUSED>(sums[i % 4], c[i], x[i]);
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

#[inline(always)]
fn add_rows<const FUSED: bool>(sum: &mut Row, a: &Row, b: &Row) {
    for lane in 0..LANES {
        sum[lane] = add_product::<FUSED>(sum[lane], a[lane], b[lane]);
    }
}

/// The lowest order of an inner sum.
#[inline(always)]
fn first<const EAGER: bool>(k: usize) -> usize {
    if EAGER && k > 2 { 2 } else { 1 }
}

/// `Σ left_j right_{k-j}` over `first ≤ j ≤ k - first` for each block, in `A` sums side by side: one alone would wait for itself.
#[inline(always)]
fn together<const FUSED: bool, const P: usize, const A: usize>(
    blocks: &[Products; P],
    k: usize,
    first: usize,
) -> [Row; P] {
    let k = k.clamp(1, ROWS - 1);
    let mut sums = [[[0.0; LANES]; P]; A];
    let end = k + 1 - first;
    let mut j = first;
    while j + A <= end {
        for (a, sums) in sums.iter_mut().enumerate() {
            for (sum, block) in sums.iter_mut().zip(blocks) {
                add_rows::<FUSED>(sum, &block.left[j + a], &block.right[k - j - a]);
            }
        }
        j += A;
    }
    while j < end {
        for (sum, block) in sums[0].iter_mut().zip(blocks) {
            add_rows::<FUSED>(sum, &block.left[j], &block.right[k - j]);
        }
        j += 1;
    }
    let mut total = sums[0];
    for sums in &sums[1..] {
        for (total, sum) in total.iter_mut().zip(sums) {
            for lane in 0..LANES {
                total[lane] += sum[lane];
            }
        }
    }
    total
}

/// `Σ x_j x_{k-j}` over `first ≤ j ≤ k - first`, each product once.
#[inline(always)]
fn square_sum<const FUSED: bool>(block: &Squares, k: usize, first: usize) -> Row {
    let k = k.clamp(1, ROWS - 1);
    let mut sum = [0.0; LANES];
    for j in first..k.div_ceil(2) {
        add_rows::<FUSED>(&mut sum, &block.rows[j], &block.rows[k - j]);
    }
    for x in &mut sum {
        *x *= 2.0;
    }
    if k.is_multiple_of(2) {
        add_rows::<FUSED>(&mut sum, &block.rows[k / 2], &block.rows[k / 2]);
    }
    sum
}
