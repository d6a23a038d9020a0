//! The state of a motion: compensated sums of positions and velocities, with any number of coordinates.

use crate::number::compensated::{self, Compensated};
use crate::solve::rotation;

/// Position and velocity as compensated sums, and the acceleration at the end of the last series.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// The number of coordinates.
    n: usize,
    /// High and low parts of the position, high and low parts of the velocity, acceleration.
    numbers: Box<[f64]>,
}

/// The parts of a [`State`], mutable: high and low parts of the sums.
pub(crate) struct Parts<'a> {
    /// The position.
    pub q: [&'a mut [f64]; 2],
    /// The velocity.
    pub v: [&'a mut [f64]; 2],
    /// The acceleration.
    pub a: &'a mut [f64],
}

impl State {
    /// A position and a velocity that are known exactly.
    pub fn exact(q: &[f64], v: &[f64]) -> Self {
        let n = q.len();
        let mut state = Self {
            n,
            numbers: vec![0.0; 5 * n].into_boxed_slice(),
        };
        state.set_position(q);
        state.set_velocity(v);
        state
    }

    /// The position.
    #[inline]
    pub fn q(&self) -> &[f64] {
        &self.numbers[..self.n]
    }

    /// The velocity.
    #[inline]
    pub fn v(&self) -> &[f64] {
        &self.numbers[2 * self.n..3 * self.n]
    }

    /// The acceleration at the end of the last series.
    #[inline]
    pub fn a(&self) -> &[f64] {
        &self.numbers[4 * self.n..]
    }

    /// All parts, mutable.
    #[inline]
    pub fn parts(&mut self) -> Parts<'_> {
        let n = self.n;
        let (q, rest) = self.numbers.split_at_mut(n);
        let (q_low, rest) = rest.split_at_mut(n);
        let (v, rest) = rest.split_at_mut(n);
        let (v_low, a) = rest.split_at_mut(n);
        Parts {
            q: [q, q_low],
            v: [v, v_low],
            a,
        }
    }

    /// Sets a position that is known exactly.
    pub fn set_position(&mut self, q: &[f64]) {
        let [hi, lo] = self.parts().q;
        hi.copy_from_slice(q);
        lo.fill(0.0);
    }

    /// Sets a velocity that is known exactly.
    pub fn set_velocity(&mut self, v: &[f64]) {
        let [hi, lo] = self.parts().v;
        hi.copy_from_slice(v);
        lo.fill(0.0);
    }

    /// Copies another state.
    pub fn copy(&mut self, other: &Self) {
        self.numbers.copy_from_slice(&other.numbers);
    }

    /// Adds to the position.
    pub fn move_position(&mut self, by: &[f64]) {
        let [hi, lo] = self.parts().q;
        compensated::add_all(hi, lo, by);
    }

    /// Moves the position by an increment, which turns rotations. Nothing is allocated.
    pub fn turn_position(&mut self, rotations: &[usize], by: &[f64]) {
        let [hi, lo] = self.parts().q;
        rotation::move_sum(rotations, [hi, lo], by);
    }

    /// Adds to the velocity.
    pub fn move_velocity(&mut self, by: &[f64]) {
        let [hi, lo] = self.parts().v;
        compensated::add_all(hi, lo, by);
    }

    /// Position and velocity as arrays; `None` for another number of coordinates.
    #[inline(always)]
    pub fn sized<const N: usize>(&self) -> Option<[Compensated<N>; 2]> {
        let [q, q_low, v, v_low, _] = self.numbers.as_chunks().0 else {
            return None;
        };
        let sum = |hi: &[f64; N], lo: &[f64; N]| Compensated { hi: *hi, lo: *lo };
        (self.n == N).then(|| [sum(q, q_low), sum(v, v_low)])
    }

    /// High and low parts of the position, high and low parts of the velocity, and acceleration as arrays;
    /// `None` for another number of coordinates.
    #[inline(always)]
    pub fn rows<const N: usize>(&mut self) -> Option<&mut [[f64; N]; 5]> {
        self.numbers.as_chunks_mut().0.try_into().ok()
    }

    /// Sets position, velocity and acceleration; does nothing for another number of coordinates.
    #[inline(always)]
    pub fn take<const N: usize>(&mut self, q: &Compensated<N>, v: &Compensated<N>, a: &[f64; N]) {
        if let [to_q, to_q_low, to_v, to_v_low, to_a] = self.numbers.as_chunks_mut().0 {
            (*to_q, *to_q_low) = (q.hi, q.lo);
            (*to_v, *to_v_low) = (v.hi, v.lo);
            *to_a = *a;
        }
    }
}
