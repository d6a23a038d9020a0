//! The steps that an expert would write by hand for one system: the rivals of the generated code.
//!
//! They use all that `dsocs-core` uses (the second difference as the unknown, compensated sums, the same predictor and
//! stop rule), but for one system each: rows simplified with pencil and paper, no traits, no reports, no errors.

#![allow(clippy::needless_range_loop)] // components by index, as it would be written by hand

pub mod particle;
pub mod pendulum;

/// An update this small relative to the unknowns is the last.
const LAST_UPDATE: f64 = 1e-9;

/// The error that may remain after the last update, relative to the unknowns.
const REMAINDER: f64 = 1e-16;

/// How large a second difference is expected to be at least, relative to the increment.
const SECOND_DIFFERENCE: f64 = 1e-5;

/// The position and the increment that led to it, as sums of two numbers each.
#[derive(Clone, Copy, Debug)]
struct Path {
    q: [f64; 2],
    q_low: [f64; 2],
    d: [f64; 2],
    d_low: [f64; 2],
}

impl Path {
    fn new(q0: [f64; 2], d: [f64; 2]) -> Self {
        let mut path = Self {
            q: q0,
            q_low: [0.0; 2],
            d,
            d_low: [0.0; 2],
        };
        path.follow();
        path
    }

    /// Adds the second difference to the increment, and the increment to the position.
    #[inline(always)]
    fn advance(&mut self, e: [f64; 2]) {
        for i in 0..2 {
            let (sum, error) = two_sum(self.d[i], e[i]);
            (self.d[i], self.d_low[i]) = fast_two_sum(sum, error + self.d_low[i]);
        }
        self.follow();
    }

    #[inline(always)]
    fn follow(&mut self) {
        for i in 0..2 {
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
                let larger = if before[i] >= size { before[i] } else { size };
                let better = larger <= smallest[i];
                guess[i] = if better { sum[i] } else { guess[i] };
                smallest[i] = if better { larger } else { smallest[i] };
                before[i] = size;
            }
        }
        guess
    }
}
