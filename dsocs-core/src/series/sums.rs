//! Inner sums of recurrences, in lanes.
//!
//! A recurrence of order `k` needs `Σ x_j y_{k-j}`. The terms with `0 < j < k` are of lower orders: they are
//! summed for all recurrences of a system together, [`LANES`] at a time, and the generated code adds the
//! others. Coefficients of one order are contiguous, so that neither factor of a convolution has to be
//! reversed.

use super::blocks::{Products, Squares, first, in_pairs, ones, some, square_sum, together};
use super::coefficient::Coefficient;
use super::jet::{Call, Jet};
use super::orders::{LANES, ROWS, Row};
use super::switch::{Switch, Switches};
use super::whole::{self, Together};

/// The coefficients of lower orders that the recurrences of a system need: `H` groups of `B` blocks of products of
/// positions and velocities, `P` blocks of other products, `S` of squares, `C` calls of the user's functions, `W`
/// switches; the last two for each motion.
#[derive(Debug)]
pub struct Table<
    T,
    const P: usize,
    const S: usize,
    const C: usize,
    const W: usize = 0,
    const H: usize = 0,
    const B: usize = 1,
> {
    /// Operands of products of positions and velocities.
    whole: Box<[Together<T, B>; H]>,
    /// Operands of products.
    pub products: Box<[Products<T>; P]>,
    /// Operands of squares.
    pub squares: Box<[Squares<T>; S]>,
    /// The calls of the user's functions.
    pub calls: Vec<[Call; C]>,
    /// The switches between pieces of functions.
    pub switches: Vec<[Switch; W]>,
}

impl<
    T: Coefficient,
    const P: usize,
    const S: usize,
    const C: usize,
    const W: usize,
    const H: usize,
    const B: usize,
> Default for Table<T, P, S, C, W, H, B>
{
    fn default() -> Self {
        Self {
            whole: boxed(&Together::default()),
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

impl<T, const P: usize, const S: usize, const C: usize, const W: usize, const H: usize, const B: usize>
    Switches for Table<T, P, S, C, W, H, B>
{
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

impl<
    T: Coefficient,
    const P: usize,
    const S: usize,
    const C: usize,
    const W: usize,
    const H: usize,
    const B: usize,
> Table<T, P, S, C, W, H, B>
{
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
        if H * B + P <= 2 {
            return together::<T, FUSED, P, 2>(&self.products, k, first::<EAGER>(k));
        }
        // more than two in pairs: with the sums of four in one loop the compiler does not vectorise
        let mut sums = [[T::splat(0.0); LANES]; P];
        let first = first::<EAGER>(k);
        let ones = ones(H * B + P).saturating_sub(H * B);
        let (of_ones, of_twos) = self.products.split_at(ones);
        let (to_ones, to_twos) = sums.split_at_mut(ones);
        let k = k.clamp(1, ROWS - 1);
        in_pairs::<T, FUSED, 1>(of_ones, k, first, to_ones);
        in_pairs::<T, FUSED, 2>(of_twos, k, first, to_twos);
        sums
    }

    /// Stores order 0 of the operands of products, and of the first squares, of positions and velocities.
    #[inline(always)]
    pub fn begin_whole<const V: usize>(&mut self, products: [[[Row<T>; B]; H]; 2], squares: [Row<T>; V]) {
        let [left, right] = products;
        for place in 0..H {
            let blocks = &mut self.whole[place];
            (blocks.left[0], blocks.right[0]) = (left[place], right[place]);
        }
        for (block, row) in self.squares.iter_mut().zip(squares) {
            block.rows[0] = row;
        }
    }

    /// Stores order `k` of the operands of these products, and returns their coefficients of that order, of which
    /// the first `USED` are needed.
    #[inline(always)]
    pub fn whole_products<const FUSED: bool, const EAGER: bool, const USED: usize>(
        &mut self,
        k: usize,
        [left, right]: [[[Row<T>; B]; H]; 2],
    ) -> [[Row<T>; B]; H] {
        let k = k.clamp(1, ROWS - 1);
        let mut rows = [[[T::splat(0.0); LANES]; B]; H];
        for place in 0..H {
            let (blocks, now) = (&mut self.whole[place], [&left[place], &right[place]]);
            rows[place] = if !T::PACKED {
                whole::one_by_one(blocks, k, now, USED.saturating_sub(LANES * B * place))
            } else if B * place < ones(H * B + P) {
                T::on_fours::<FUSED, _>(whole::Products::<T, EAGER, B, 1> { blocks, k, now })
            } else {
                T::on_fours::<FUSED, _>(whole::Products::<T, EAGER, B, 2> { blocks, k, now })
            };
        }
        rows
    }

    /// Stores order `k` of the operands of these squares, and returns their coefficients of that order, of which the
    /// first `USED` are needed.
    #[inline(always)]
    pub fn whole_squares<const FUSED: bool, const EAGER: bool, const USED: usize, const V: usize>(
        &mut self,
        k: usize,
        now: [Row<T>; V],
    ) -> [Row<T>; V] {
        let k = k.clamp(1, ROWS - 1);
        let mut rows = [[T::splat(0.0); LANES]; V];
        for place in 0..V.min(S) {
            let (block, now) = (&mut self.squares[place], &now[place]);
            rows[place] = if T::PACKED {
                T::on_fours::<FUSED, _>(whole::OfSquares::<T, EAGER> { block, k, now })
            } else {
                whole::squares_one_by_one(block, k, now, USED.saturating_sub(LANES * place))
            };
        }
        rows
    }

    /// The inner sums of squares of order `k`, as [`Table::product_sums`].
    #[inline(always)]
    #[must_use]
    pub fn square_sums<const FUSED: bool, const EAGER: bool, const USED: usize, const WHOLE: usize>(
        &self,
        k: usize,
    ) -> [Row<T>; S] {
        let mut sums = [[T::splat(0.0); LANES]; S];
        for place in WHOLE..S {
            let used = USED.saturating_sub(LANES * place).min(LANES);
            sums[place] = if T::PACKED {
                square_sum::<T, FUSED>(&self.squares[place], k, first::<EAGER>(k), LANES)
            } else {
                square_sum::<T, FUSED>(&self.squares[place], k, 1, used)
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
