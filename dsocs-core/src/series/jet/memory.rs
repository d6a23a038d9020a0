//! The data that a function's operations keep from order to order.
//!
//! A function is called once for each order, with the same operations each time. So an operation is
//! identified by its number: those that need their own past take the places of this memory in turn. A thread
//! has one memory. A [`Call`](super::Call) loads its function's data into it, and stores them afterwards.
//!
//! Every operation uses it, so the first 64 places are plain cells.

// parts of every operation
#![allow(clippy::inline_always)]

use core::cell::Cell;
use std::cell::RefCell;

use crate::series::orders::{LANES, RECIPROCALS, ROWS, Row};

/// Number of rows of places that are cells of the thread; further ones are on the heap.
const FAST: usize = 16;

/// The fields of a place.
#[derive(Clone, Copy)]
pub(super) enum Field {
    /// The coefficient of order 0.
    Start,
    /// The reciprocal of the divisor of all orders.
    Inverse,
    /// The inner sum of the order, without its newest terms.
    Sum,
    /// The operands of the inner sum: of the order before, until those of this order replace them.
    Left,
    Right,
    /// The operands of order 1, the factors of the newest terms.
    FirstLeft,
    FirstRight,
}

/// The number of fields.
const FIELDS: usize = 7;

/// The memory of a thread.
struct Memory {
    /// The order that is computed.
    order: Cell<usize>,
    /// The next place.
    at: Cell<usize>,
    /// Whether a function is being called.
    is_used: Cell<bool>,
    /// The number of the owner of the places, and the last number that was given.
    owner: Cell<u64>,
    owners: Cell<u64>,
    /// Rows of places, field by field.
    fields: [[[Cell<f64>; LANES]; FAST]; FIELDS],
}

thread_local! {
    static MEMORY: Memory = const {
        Memory {
            order: Cell::new(0),
            at: Cell::new(0),
            is_used: Cell::new(false),
            owner: Cell::new(0),
            owners: Cell::new(0),
            fields: [const { [const { [const { Cell::new(0.0) }; LANES] }; FAST] }; FIELDS],
        }
    };

    /// The places on the heap.
    static BEYOND: RefCell<Vec<[f64; FIELDS]>> = const { RefCell::new(Vec::new()) };
}

/// Begins the operations of order `k`.
#[inline(always)]
pub(super) fn begin(k: usize) {
    MEMORY.with(|memory| {
        memory.order.set(k);
        memory.at.set(0);
    });
}

/// The order that is computed.
#[inline(always)]
pub(super) fn order() -> usize {
    MEMORY.with(|memory| memory.order.get())
}

/// The order as a number, and its reciprocal.
#[inline(always)]
pub(super) fn degree() -> [f64; 2] {
    let k = order().min(ROWS - 1);
    [k as f64, RECIPROCALS[k]]
}

/// Number of places that have been taken.
#[inline(always)]
pub(super) fn places() -> usize {
    MEMORY.with(|memory| memory.at.get())
}

/// Takes the next places, and returns the first.
#[inline(always)]
pub(super) fn take(places: usize) -> usize {
    MEMORY.with(|memory| {
        let at = memory.at.get();
        memory.at.set(at + places);
        at
    })
}

/// The value of a field at a place.
#[inline(always)]
pub(super) fn get(field: Field, at: usize) -> f64 {
    MEMORY.with(
        |memory| match memory.fields[field as usize].as_flattened().get(at) {
            Some(cell) => cell.get(),
            None => get_beyond(field, at - LANES * FAST),
        },
    )
}

/// Sets a field at a place.
#[inline(always)]
pub(super) fn set(field: Field, at: usize, value: f64) {
    MEMORY.with(
        |memory| match memory.fields[field as usize].as_flattened().get(at) {
            Some(cell) => cell.set(value),
            None => set_beyond(field, at - LANES * FAST, value),
        },
    );
}

/// Gives the places to a new owner, and returns its number.
pub(super) fn own() -> u64 {
    MEMORY.with(|memory| {
        let owner = memory.owners.get() + 1;
        memory.owners.set(owner);
        memory.owner.set(owner);
        owner
    })
}

/// Gives the places to an owner, and returns whether they are its own already.
#[inline(always)]
pub(super) fn is_own(owner: u64) -> bool {
    MEMORY.with(|memory| memory.owner.replace(owner) == owner)
}

/// Sets a field of the first places, row by row.
#[inline(always)]
pub(super) fn set_rows<'r>(field: Field, rows: impl ExactSizeIterator<Item = &'r Row<f64>> + Clone) {
    if rows.len() > FAST {
        for (row, values) in rows.clone().enumerate().skip(FAST) {
            for (lane, &value) in values.iter().enumerate() {
                set_beyond(field, LANES * (row - FAST) + lane, value);
            }
        }
    }
    MEMORY.with(|memory| {
        for (cells, values) in memory.fields[field as usize].iter().zip(rows) {
            for (cell, &value) in cells.iter().zip(values) {
                cell.set(value);
            }
        }
    });
}

/// A field of a row of places.
#[inline(always)]
pub(super) fn row(field: Field, row: usize) -> Row<f64> {
    let first = LANES * row;
    [
        get(field, first),
        get(field, first + 1),
        get(field, first + 2),
        get(field, first + 3),
    ]
}

#[cold]
#[inline(never)]
fn get_beyond(field: Field, at: usize) -> f64 {
    BEYOND.with_borrow(|places| places.get(at).map_or(f64::NAN, |place| place[field as usize]))
}

#[cold]
#[inline(never)]
fn set_beyond(field: Field, at: usize, value: f64) {
    BEYOND.with_borrow_mut(|places| {
        if places.len() <= at {
            places.resize(at + 1, [0.0; FIELDS]);
        }
        places[at][field as usize] = value;
    });
}

/// The memory of a function that is being called, saved while it calls another.
#[derive(Debug)]
pub(super) struct Saved {
    order: usize,
    at: usize,
    owner: u64,
    fields: [[Row<f64>; FAST]; FIELDS],
    beyond: Vec<[f64; FIELDS]>,
}

/// Begins to use the memory. If it is in use, because a function computes a motion itself, its content is
/// saved.
#[inline(always)]
pub(super) fn enter() -> Option<Box<Saved>> {
    MEMORY.with(|memory| {
        if memory.is_used.replace(true) {
            Some(save(memory))
        } else {
            None
        }
    })
}

/// Ends the use of the memory.
#[inline(always)]
pub(super) fn leave(outer: Option<Box<Saved>>) {
    match outer {
        None => MEMORY.with(|memory| memory.is_used.set(false)),
        Some(saved) => restore(*saved),
    }
}

#[cold]
#[inline(never)]
fn save(memory: &Memory) -> Box<Saved> {
    Box::new(Saved {
        order: memory.order.get(),
        at: memory.at.get(),
        owner: memory.owner.get(),
        fields: memory
            .fields
            .each_ref()
            .map(|rows| rows.each_ref().map(|row| row.each_ref().map(Cell::get))),
        beyond: BEYOND.take(),
    })
}

#[cold]
#[inline(never)]
fn restore(saved: Saved) {
    begin(saved.order);
    MEMORY.with(|memory| {
        memory.at.set(saved.at);
        memory.owner.set(saved.owner);
        for (field, saved) in memory.fields.iter().zip(&saved.fields) {
            for (cell, &saved) in field.as_flattened().iter().zip(saved.as_flattened()) {
                cell.set(saved);
            }
        }
    });
    BEYOND.set(saved.beyond);
}
