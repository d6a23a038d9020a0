//! Steps written by hand for one system each, as an expert would: the competitors of the generated code.
//!
//! They use the numerical methods of `dsocs-core` (the second difference as the unknown, compensated sums, its
//! predictor and its stop rule), but for one system each: rows simplified with pencil and paper, no traits, no
//! reports, no errors.

#![allow(clippy::needless_range_loop)] // components by index, as it would be written by hand

pub mod chain;
pub mod lean;
pub mod particle;
pub mod pendulum;
pub mod top;

/// The last update of Newton's iteration is this small, relative to the unknowns.
const LAST_UPDATE: f64 = 1e-9;

/// An update of at most the first size is also the last if the one before was larger than the second: the
/// remaining error is below rounding.
const SETTLED: [(f64, f64); 3] = [(1e-10, 1e-7), (4e-12, LAST_UPDATE), (LAST_UPDATE, 3.2e-6)];

/// The smallest expected second difference, relative to the increment.
const SECOND_DIFFERENCE: f64 = 1e-5;

/// The position and the increment that led to it, as sums of two numbers each.
#[derive(Clone, Copy, Debug)]
struct Path<const N: usize> {
    q: [f64; N],
    q_low: [f64; N],
    d: [f64; N],
    d_low: [f64; N],
}

impl<const N: usize> Path<N> {
    fn new(q0: [f64; N], d: [f64; N]) -> Self {
        let mut path = Self {
            q: q0,
            q_low: [0.0; N],
            d,
            d_low: [0.0; N],
        };
        path.follow();
        path
    }

    /// Adds the second difference to the increment, and the increment to the position.
    #[inline(always)]
    fn advance(&mut self, e: [f64; N]) {
        for i in 0..N {
            let (sum, error) = two_sum(self.d[i], e[i]);
            (self.d[i], self.d_low[i]) = fast_two_sum(sum, error + self.d_low[i]);
        }
        self.follow();
    }

    #[inline(always)]
    fn follow(&mut self) {
        for i in 0..N {
            let (sum, error) = two_sum(self.q[i], self.d[i]);
            (self.q[i], self.q_low[i]) = fast_two_sum(sum, error + (self.q_low[i] + self.d_low[i]));
        }
    }
}

#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_virtual = sum - a;
    let a_virtual = sum - b_virtual;
    (sum, (a - a_virtual) + (b - b_virtual))
}

#[inline(always)]
fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// Backward differences of the last `M` unknowns, and their size.
#[derive(Clone, Copy, Debug)]
struct History<const M: usize> {
    differences: [[f64; M]; 6],
    size: [f64; M],
}

impl<const M: usize> History<M> {
    fn new() -> Self {
        Self {
            differences: [[f64::NAN; M]; 6],
            size: [0.0; M],
        }
    }

    #[inline(always)]
    fn push(&mut self, z: [f64; M]) {
        for i in 0..M {
            let mut difference = z[i];
            for row in &mut self.differences {
                let last = row[i];
                row[i] = difference;
                difference -= last;
            }
            self.size[i] = (0.75 * self.size[i]).max(z[i].abs());
        }
    }

    /// The extrapolation of the degree whose last two differences are smallest; NaN without a past.
    #[inline(always)]
    fn predict(&self) -> [f64; M] {
        let mut guess = self.differences[0];
        let mut sum = guess;
        let mut smallest = guess.map(f64::abs);
        let mut before = smallest;
        for difference in &self.differences[1..] {
            for i in 0..M {
                sum[i] += difference[i];
                let size = difference[i].abs();
                // in the order of the instructions: the second where either is NaN
                let larger = if before[i] > size { before[i] } else { size };
                guess[i] = if larger <= smallest[i] { sum[i] } else { guess[i] };
                smallest[i] = if larger < smallest[i] { larger } else { smallest[i] };
                before[i] = size;
            }
        }
        guess
    }
}

#[inline(always)]
fn small<const N: usize>(update: [f64; N], e: [f64; N], size: [f64; N], tolerance: f64) -> bool {
    let mut small = true;
    for i in 0..N {
        small &= update[i].abs() <= tolerance * e[i].abs().max(size[i]);
    }
    small
}

#[inline(always)]
fn moved<const N: usize>(e: [f64; N], part: f64, update: [f64; N]) -> [f64; N] {
    let mut e = e;
    for i in 0..N {
        e[i] += part * update[i];
    }
    e
}

/// Whether the update is the last, given the one before (see [`SETTLED`]).
#[inline(always)]
fn settled<const N: usize>(before: ([f64; N], [f64; N]), now: ([f64; N], [f64; N]), size: [f64; N]) -> bool {
    SETTLED.iter().any(|&(largest, smallest)| {
        small(now.1, now.0, size, largest) && !small(before.1, before.0, size, smallest)
    })
}

/// Newton's iteration, with the stop rule of `dsocs-core`.
#[inline(always)]
fn solve<const N: usize>(
    update_at: impl Fn([f64; N]) -> [f64; N],
    e: [f64; N],
    size: [f64; N],
) -> Option<([f64; N], u32)> {
    let first = update_at(e);
    let next = moved(e, 1.0, first);
    if small(first, e, size, LAST_UPDATE) {
        return Some((next, 1));
    }
    let second = update_at(next);
    if settled((e, first), (next, second), size) {
        return Some((moved(next, 1.0, second), 2));
    }
    iterate(update_at, (next, second), size)
}

/// Newton's iteration from the third evaluation on. An update that does not make the next one smaller is
/// halved.
#[inline(never)]
fn iterate<const N: usize>(
    update_at: impl Fn([f64; N]) -> [f64; N],
    second: ([f64; N], [f64; N]),
    size: [f64; N],
) -> Option<([f64; N], u32)> {
    let mut now = second;
    let mut count = 2;
    while count < 500 {
        let (before, mut part) = (now, 1.0);
        loop {
            let e = moved(before.0, part, before.1);
            now = (e, update_at(e));
            count += 1;
            if part >= 1.0 && settled(before, now, size) {
                return Some((moved(now.0, 1.0, now.1), count));
            }
            if relative(now.1, before.0, size) < relative(before.1, before.0, size) || part < 1e-6 {
                break;
            }
            part *= 0.5;
        }
        let (was, is) = (relative(before.1, before.0, size), relative(now.1, now.0, size));
        // the remaining error is below rounding, or the update itself is rounding
        if part >= 1.0 && is <= LAST_UPDATE && (is >= 0.5 * was || is * (is / was).powi(2) <= 1e-16) {
            return Some((moved(now.0, 1.0, now.1), count));
        }
    }
    None
}

#[inline(always)]
fn relative<const N: usize>(update: [f64; N], e: [f64; N], size: [f64; N]) -> f64 {
    let mut largest = 0.0_f64;
    for i in 0..N {
        largest = largest.max(update[i].abs() / e[i].abs().max(size[i]));
    }
    largest
}
