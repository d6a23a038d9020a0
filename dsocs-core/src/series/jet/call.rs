//! The call of a user's function, order by order.

// parts of every operation of the recurrences
#![allow(clippy::inline_always)]

use super::memory::{self, Field};
use super::pieces::Pieces;
use super::{Jet, memory::Saved};
use crate::series::blocks::{Products, inner_sums};
use crate::series::orders::{LANES, ROWS, Row};
use crate::series::switch::Switch;

/// A user's function at a point, with its operations' coefficients of lower orders.
#[derive(Clone, Debug, Default)]
pub struct Call {
    /// Number of places of the [memory] that its operations take.
    places: usize,
    /// Whether its value depends on time.
    moves: bool,
    pieces: Pieces,
    /// The number by which it owns the thread's memory while it computes a series, from order 0 to the last.
    owner: u64,
    /// The values and reciprocals of order 0.
    starts: Vec<[Row<f64>; 2]>,
    /// The operands of the inner sums.
    blocks: Vec<Products>,
    sums: Vec<Row<f64>>,
}

impl Call {
    /// Calls a function with the values of its arguments, and returns its value: order 0. A constant argument
    /// enters as a number.
    #[inline]
    pub fn first<const A: usize>(
        &mut self,
        values: [f64; A],
        moves: [bool; A],
        function: impl FnOnce([Jet; A]) -> Jet,
    ) -> f64 {
        self.begin(|| function(jets(values, [0.0; A], moves)))
    }

    /// The function's coefficient of order `k`, `k ≥ 1`, from those of its arguments; lower orders come first.
    #[inline(always)]
    pub fn coefficient<const FUSED: bool, const A: usize>(
        &mut self,
        k: usize,
        values: [f64; A],
        inputs: [f64; A],
        moves: [bool; A],
        function: impl FnOnce([Jet; A]) -> Jet,
    ) -> f64 {
        self.next::<FUSED>(k, || function(jets(values, inputs, moves)))
    }

    /// Calls a function that makes its own jets: order 0.
    pub(crate) fn begin(&mut self, function: impl FnOnce() -> Jet) -> f64 {
        let outer = memory::enter();
        memory::begin(0);
        let result = self.pieces.during(function);
        self.pieces.keep();
        self.moves = result.moves;
        self.places = memory::places();
        let blocks = self.places.div_ceil(LANES);
        self.blocks.resize_with(blocks, Products::default);
        self.sums.resize(blocks, [0.0; LANES]);
        self.starts.clear();
        let fields = [Field::Start, Field::Inverse];
        self.starts
            .extend((0..blocks).map(|row| fields.map(|field| memory::row(field, row))));
        for field in [Field::Left, Field::Right, Field::FirstLeft, Field::FirstRight] {
            memory::set_rows(field, self.sums.iter().map(|_| &[0.0; LANES]));
        }
        self.owner = memory::own();
        memory::leave(outer);
        result.value
    }

    /// [`Call::coefficient`] for a function that makes its own jets.
    #[inline(always)]
    pub(crate) fn next<const FUSED: bool>(&mut self, k: usize, function: impl FnOnce() -> Jet) -> f64 {
        if self.is_still() {
            return 0.0;
        }
        let k = k.clamp(1, ROWS - 1);
        let outer = self.enter::<FUSED>(k);
        let result = if self.pieces.is_empty() {
            function()
        } else {
            self.pieces.during(function)
        };
        // a function whose operations differ from order to order has no series
        let is_same = memory::places() == self.places;
        self.leave(k, outer);
        if is_same { result.now } else { f64::NAN }
    }

    /// Loads the data of order `k` into the memory.
    #[inline(always)]
    fn enter<const FUSED: bool>(&mut self, k: usize) -> Option<Box<Saved>> {
        inner_sums::<FUSED>(&self.blocks, k, &mut self.sums);
        let outer = memory::enter();
        memory::begin(k);
        if !memory::is_own(self.owner) {
            self.refill(k);
        }
        memory::set_rows(Field::Sum, self.sums.iter());
        outer
    }

    /// Reloads the data of the orders below `k` into the memory, if another function was called since.
    #[cold]
    #[inline(never)]
    fn refill(&self, k: usize) {
        // the row of order 0 has no operands, but zeros
        let row = |order: usize| if order > 0 && order < k { order } else { 0 };
        let (blocks, [last, first]) = (&self.blocks, [row(k - 1), row(1)]);
        memory::set_rows(Field::Start, self.starts.iter().map(|[start, _]| start));
        memory::set_rows(Field::Inverse, self.starts.iter().map(|[_, inverse]| inverse));
        memory::set_rows(Field::Left, blocks.iter().map(|block| &block.left[last]));
        memory::set_rows(Field::Right, blocks.iter().map(|block| &block.right[last]));
        memory::set_rows(Field::FirstLeft, blocks.iter().map(|block| &block.left[first]));
        let first = if k > 2 { first } else { 0 };
        memory::set_rows(Field::FirstRight, blocks.iter().map(|block| &block.right[first]));
    }

    /// Stores the operands of order `k` from the memory.
    #[inline(always)]
    fn leave(&mut self, k: usize, outer: Option<Box<Saved>>) {
        for (row, block) in self.blocks.iter_mut().enumerate() {
            block.left[k] = memory::row(Field::Left, row);
            block.right[k] = memory::row(Field::Right, row);
        }
        // in order 2 both newest terms are the same
        match k {
            1 => memory::set_rows(Field::FirstLeft, self.blocks.iter().map(|block| &block.left[1])),
            2 => memory::set_rows(Field::FirstRight, self.blocks.iter().map(|block| &block.right[1])),
            _ => {}
        }
        memory::leave(outer);
    }

    /// Whether the function's value is constant, and nothing was compared.
    #[inline]
    pub(crate) fn is_still(&self) -> bool {
        !self.moves && self.pieces.is_empty()
    }

    /// The switches that the function has evaluated.
    pub(crate) fn switches(&mut self) -> &mut [Switch] {
        self.pieces.switches()
    }

    /// Enters the pieces that choices have changed to; returns whether there are any.
    pub(crate) fn enter_pieces(&mut self) -> bool {
        self.pieces.enter()
    }
}

#[inline(always)]
fn jets<const A: usize>(values: [f64; A], now: [f64; A], moves: [bool; A]) -> [Jet; A] {
    core::array::from_fn(|i| {
        if moves[i] {
            Jet::moving(values[i], now[i])
        } else {
            Jet::from(values[i])
        }
    })
}
