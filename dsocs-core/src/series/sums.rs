//! Inner sums of recurrences, in lanes.
//!
//! A recurrence of order `k` needs `Σ x_j y_{k-j}`. The terms with `0 < j < k` are of lower orders: they are
//! summed for all recurrences of a system together, [`LANES`] at a time, and the generated code adds the
//! others. Coefficients of one order are contiguous, so that neither factor of a convolution has to be
//! reversed.

use super::coefficient::Coefficient;
use super::jet::{Call, Jet};
use super::orders::{LANES, ROWS, Row};
use super::switch::{Switch, Switches};

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

/// The coefficients of lower orders that the recurrences of a system need: `P` blocks of products, `S` of
/// squares, `C` calls of the user's functions, `W` switches; the last two for each motion.
#[derive(Debug)]
pub struct Table<T, const P: usize, const S: usize, const C: usize, const W: usize = 0> {
    /// Operands of products.
    pub products: Box<[Products<T>; P]>,
    /// Operands of squares.
    pub squares: Box<[Squares<T>; S]>,
    /// The calls of the user's functions.
    pub calls: Vec<[Call; C]>,
    /// The switches between pieces of functions.
    pub switches: Vec<[Switch; W]>,
}

impl<T: Coefficient, const P: usize, const S: usize, const C: usize, const W: usize> Default
    for Table<T, P, S, C, W>
{
    fn default() -> Self {
        Self {
            products: boxed(&Products::default()),
            squares: boxed(&Squares::default()),
            calls: (0..T::TRACKS)
                .map(|_| core::array::from_fn(|_| Call::default()))
                .collect(),
            switches: (0..T::TRACKS)
                .map(|_| core::array::from_fn(|_| Switch::default()))
                .collect(),
        }
    }
}

/// An array on the heap that is never built on the stack.
fn boxed<T: Clone, const M: usize>(element: &T) -> Box<[T; M]> {
    match vec![element.clone(); M].into_boxed_slice().try_into() {
        Ok(array) => array,
        // the lengths are equal
        Err(_) => Box::new(core::array::from_fn(|_| element.clone())),
    }
}

impl<T, const P: usize, const S: usize, const C: usize, const W: usize> Switches for Table<T, P, S, C, W> {
    const GROUPS: usize = if W + C == 0 { 0 } else { 1 + C };

    fn group(&mut self, track: usize, group: usize) -> &mut [Switch] {
        match group.checked_sub(1) {
            None => match self.switches.get_mut(track) {
                Some(switches) => switches,
                None => &mut [],
            },
            Some(call) => {
                let calls = self.calls.get_mut(track);
                calls
                    .and_then(|calls| calls.get_mut(call))
                    .map_or(&mut [], Call::switches)
            }
        }
    }

    fn enter(&mut self, track: usize) -> bool {
        let mut any = false;
        for call in self.calls.get_mut(track).into_iter().flatten() {
            any |= call.enter_pieces();
        }
        any
    }

    fn moves(&self) -> bool {
        self.calls.iter().flatten().any(|call| !call.is_still())
    }
}

impl<T: Coefficient, const P: usize, const S: usize, const C: usize, const W: usize> Table<T, P, S, C, W> {
    /// Begins the series of a switch's argument; `own` is its sign. Returns the sign of the piece that is continued.
    #[inline(always)]
    pub fn start(&mut self, place: usize, value: T, own: T) -> T {
        T::of_tracks(|track| self.switches[track][place].start(value.track(track), own.track(track)))
    }

    /// Begins the series of the argument of a steep smooth function.
    #[inline(always)]
    pub fn steep(&mut self, place: usize, value: T) {
        for track in 0..T::TRACKS {
            self.switches[track][place].steep(value.track(track));
        }
    }

    /// Begins the series of a bounded value.
    #[inline(always)]
    pub fn bounded(&mut self, place: usize, value: T, bound: f64) {
        for track in 0..T::TRACKS {
            self.switches[track][place].bounded(value.track(track), bound);
        }
    }

    /// Begins the series of the base of a power of a high degree; the exponent is negative in a divisor.
    #[inline(always)]
    pub fn power(&mut self, place: usize, value: T, exponent: i32) {
        for track in 0..T::TRACKS {
            self.switches[track][place].power(value.track(track), exponent);
        }
    }

    /// Passes the coefficient of order `k` of its argument to a switch.
    #[inline(always)]
    pub fn watch(&mut self, place: usize, k: usize, coefficient: T) {
        for track in 0..T::TRACKS {
            self.switches[track][place].push(k, coefficient.track(track));
        }
    }

    /// Calls a user's function: order 0.
    #[inline(always)]
    pub fn call<const A: usize>(
        &mut self,
        place: usize,
        values: [T; A],
        moves: [bool; A],
        function: impl Fn([Jet; A]) -> Jet,
    ) -> T {
        T::of_tracks(|track| self.calls[track][place].first(one(&values, track), moves, &function))
    }

    /// The coefficient of order `k` of a user's function.
    #[inline(always)]
    pub fn coefficient<const FUSED: bool, const A: usize>(
        &mut self,
        place: usize,
        k: usize,
        [values, inputs]: [[T; A]; 2],
        moves: [bool; A],
        function: impl Fn([Jet; A]) -> Jet,
    ) -> T {
        T::of_tracks(|track| {
            let call = &mut self.calls[track][place];
            if call.is_still() {
                return 0.0;
            }
            call.coefficient::<FUSED, A>(k, one(&values, track), one(&inputs, track), moves, &function)
        })
    }

    /// The inner sums of products of order `k`, of which the first `USED` are needed. If `EAGER` and `k > 2`,
    /// packed numbers leave out the terms of the orders 1 and `k-1`.
    #[inline(always)]
    #[must_use]
    pub fn product_sums<const FUSED: bool, const EAGER: bool, const USED: usize>(
        &self,
        k: usize,
    ) -> [Row<T>; P] {
        if !T::PACKED {
            // no closures: their calls would not be compiled for the machine's own instructions
            let mut sums = [[T::splat(0.0); LANES]; P];
            for (place, sum) in sums.iter_mut().enumerate() {
                let used = USED.saturating_sub(LANES * place).min(LANES);
                *sum = some::<T>(&self.products[place], k, used);
            }
            return sums;
        }
        // up to two blocks share one loop: there are registers for all of their sums, and the loop is most of
        // the work
        if P <= 2 {
            return together::<T, FUSED, P, 2>(&self.products, k, first::<EAGER>(k));
        }
        // more than two in pairs: with the sums of four in one loop the compiler does not vectorise
        let mut sums = [[T::splat(0.0); LANES]; P];
        let first = first::<EAGER>(k);
        let ones = if P <= 4 { P } else { P - P % 4 };
        let (of_ones, of_twos) = self.products.split_at(ones);
        let (to_ones, to_twos) = sums.split_at_mut(ones);
        let k = k.clamp(1, ROWS - 1);
        in_pairs::<T, FUSED, 1>(of_ones, k, first, to_ones);
        in_pairs::<T, FUSED, 2>(of_twos, k, first, to_twos);
        sums
    }

    /// The inner sums of squares of order `k`, as [`Table::product_sums`].
    #[inline(always)]
    #[must_use]
    pub fn square_sums<const FUSED: bool, const EAGER: bool, const USED: usize>(
        &self,
        k: usize,
    ) -> [Row<T>; S] {
        let mut sums = [[T::splat(0.0); LANES]; S];
        for (place, (sum, block)) in sums.iter_mut().zip(self.squares.iter()).enumerate() {
            let used = USED.saturating_sub(LANES * place).min(LANES);
            *sum = if T::PACKED {
                square_sum::<T, FUSED>(block, k, first::<EAGER>(k), LANES)
            } else {
                square_sum::<T, FUSED>(block, k, 1, used)
            };
        }
        sums
    }
}

/// The numbers of one motion. No closures: their calls would not be compiled for the machine's own
/// instructions.
#[inline(always)]
fn one<T: Coefficient, const A: usize>(values: &[T; A], track: usize) -> [f64; A] {
    let mut numbers = [0.0; A];
    for i in 0..A {
        numbers[i] = values[i].track(track);
    }
    numbers
}

/// `sum + a b`, rounded once if `FUSED`.
#[inline(always)]
#[must_use]
pub fn add_product<const FUSED: bool, T: Coefficient>(sum: T, a: T, b: T) -> T {
    sum.add_product::<FUSED>(a, b)
}

/// `sum + a b` for packed numbers, whose inner sums leave out their newest terms; `sum` alone for others.
#[inline(always)]
#[must_use]
pub fn newest<const FUSED: bool, T: Coefficient>(sum: T, a: T, b: T) -> T {
    if T::PACKED {
        sum.add_product::<FUSED>(a, b)
    } else {
        sum
    }
}

/// `Σ c_i x_i`, in four independent sums, which need not wait for each other.
#[inline(always)]
#[must_use]
pub fn weighted<const FUSED: bool, const M: usize, T: Coefficient>(c: [T; M], x: [T; M]) -> T {
    let mut sums = [T::splat(0.0); 4];
    for i in 0..M {
        sums[i % 4] = add_product::<FUSED, T>(sums[i % 4], c[i], x[i]);
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

#[inline(always)]
fn add_rows<T: Coefficient, const FUSED: bool>(sum: &mut Row<T>, a: &Row<T>, b: &Row<T>, used: usize) {
    for lane in 0..used.min(LANES) {
        sum[lane] = add_product::<FUSED, T>(sum[lane], a[lane], b[lane]);
    }
}

/// The lowest order in an inner sum.
#[inline(always)]
fn first<const EAGER: bool>(k: usize) -> usize {
    if EAGER && k > 2 { 2 } else { 1 }
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

/// The inner sums of any number of blocks of products and of squares, as [`Table::product_sums`] and
/// [`Table::square_sums`] form them; squares stand behind the products.
#[inline(always)]
pub(crate) fn all_sums<const FUSED: bool, const EAGER: bool>(
    products: &[Products],
    squares: &[Squares],
    k: usize,
    sums: &mut [Row<f64>],
) {
    let k = k.clamp(1, ROWS - 1);
    let first = first::<EAGER>(k);
    let (to_products, to_squares) = sums.split_at_mut(products.len().min(sums.len()));
    // in a few blocks, and in those beyond the last four, each sum is split in two
    let ones = match products.len() {
        0..=2 => 0,
        3..=4 => products.len(),
        many => many - many % 4,
    };
    let (of_ones, of_twos) = products.split_at(ones);
    let (to_ones, to_twos) = to_products.split_at_mut(ones);
    in_pairs::<f64, FUSED, 1>(of_ones, k, first, to_ones);
    in_pairs::<f64, FUSED, 2>(of_twos, k, first, to_twos);
    for (to, block) in to_squares.iter_mut().zip(squares) {
        *to = square_sum::<f64, FUSED>(block, k, first, LANES);
    }
}

/// The inner sums of blocks, two blocks in one loop; each is split into `A` independent sums.
#[inline(always)]
fn in_pairs<T: Coefficient, const FUSED: bool, const A: usize>(
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

/// [`together`] with iterators over rows, without bounds checks.
#[inline(always)]
fn along_rows<T: Coefficient, const FUSED: bool, const P: usize, const A: usize>(
    blocks: &[Products<T>; P],
    k: usize,
    first: usize,
) -> [Row<T>; P] {
    let end = (k + 1).saturating_sub(first);
    // as many rows from the left as from the right, the latter in reverse
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
        // both blocks have the same number of rows
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

/// `Σ left_j right_{k-j}` over `first ≤ j ≤ k - first` for each block, in `A` independent sums, which need
/// not wait for each other.
#[inline(always)]
fn together<T: Coefficient, const FUSED: bool, const P: usize, const A: usize>(
    blocks: &[Products<T>; P],
    k: usize,
    first: usize,
) -> [Row<T>; P] {
    let k = k.clamp(1, ROWS - 1);
    let mut sums = [[[T::splat(0.0); LANES]; P]; A];
    let end = k + 1 - first;
    let mut j = first;
    while j + A <= end {
        for (a, sums) in sums.iter_mut().enumerate() {
            for (sum, block) in sums.iter_mut().zip(blocks) {
                add_rows::<T, FUSED>(sum, &block.left[j + a], &block.right[k - j - a], LANES);
            }
        }
        j += A;
    }
    while j < end {
        for (sum, block) in sums[0].iter_mut().zip(blocks) {
            add_rows::<T, FUSED>(sum, &block.left[j], &block.right[k - j], LANES);
        }
        j += 1;
    }
    let mut total = sums[0];
    for sums in &sums[1..] {
        for (total, sum) in total.iter_mut().zip(sums) {
            for lane in 0..LANES {
                total[lane] = total[lane] + sum[lane];
            }
        }
    }
    total
}

/// The first `used` sums of one block, each of which fills registers alone.
#[inline(always)]
fn some<T: Coefficient>(block: &Products<T>, k: usize, used: usize) -> Row<T> {
    let k = k.clamp(1, ROWS - 1);
    let mut sums = [T::splat(0.0); LANES];
    for j in 1..k {
        add_rows::<T, false>(&mut sums, &block.left[j], &block.right[k - j], used);
    }
    sums
}

/// `Σ x_j x_{k-j}` over `first ≤ j ≤ k - first`, each product once.
#[inline(always)]
fn square_sum<T: Coefficient, const FUSED: bool>(
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
