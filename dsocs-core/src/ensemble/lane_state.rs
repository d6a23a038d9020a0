//! The state of a block between its steps, for registers of any kind, and the exchange of one lane with a
//! run.

use wide::f64x8;

use super::determinants::Determinants;
use crate::kernel::run_state::RunState;
use crate::solve::Vector;
use crate::solve::convergence::RetainedSizes;
use crate::solve::predictor::{DIFFERENCES, push_past, size_after};
use crate::tape::Eight;
use crate::tape::Shape;

/// The state of a block between steps. Vectors lie one after the other, each number eight times, once for
/// each lane.
#[derive(Clone)]
pub(super) struct LaneState {
    /// The number of coordinates.
    coordinates: usize,
    /// The number of unknowns of a step.
    unknowns: usize,
    /// The last nodes and the increments that led to them, as compensated sums: high parts, then low parts.
    pub sums: Vec<Eight>,
    /// The past solutions: their backward differences, then their recent sizes (see
    /// [`crate::solve::predictor`]).
    pub past: Vec<Eight>,
    /// The determinants at these solutions.
    pub determinants: Determinants<f64x8>,
    /// The natural sizes of the unknowns: the part of them that is used, then their inverse.
    pub natural: Vec<Eight>,
    /// The largest ratio of an unknown to its natural size.
    pub level: Eight,
    /// The lanes where natural sizes are known, as bits.
    pub known: u32,
    /// The step that is not committed yet: its nodes and increments as above, then the solutions.
    pub found: Vec<Eight>,
}

impl LaneState {
    /// The number of vectors of the past.
    pub const VECTORS: usize = DIFFERENCES + 1;

    /// No past.
    pub fn new(shape: &Shape) -> Self {
        let (n, m) = (shape.increments, shape.unknowns);
        let zeros = |count: usize| vec![Eight::ZERO; count];
        Self {
            coordinates: n,
            unknowns: m,
            sums: zeros(4 * n),
            past: zeros(Self::VECTORS * m),
            determinants: Determinants::new(),
            natural: zeros(2 * m),
            level: Eight::ZERO,
            known: 0,
            found: zeros(4 * n + m),
        }
    }

    /// Commits the step that was held back.
    pub fn take(&mut self) {
        let (sums, z) = self.found.split_at(4 * self.coordinates);
        self.sums.copy_from_slice(sums);
        push_past(&mut self.past, z, |size, z| size.zip(z, size_after));
        self.determinants.push();
    }

    /// Copies one lane to another.
    pub fn repeat(&mut self, from: usize, to: usize) {
        for numbers in [&mut self.sums, &mut self.past, &mut self.natural] {
            for x in numbers {
                x.0[to] = x.0[from];
            }
        }
        self.level.0[to] = self.level.0[from];
        self.known = self.known & !(1 << to) | (self.known >> from & 1) << to;
        let determinants = self.determinants.lane(from);
        self.determinants.set_lane(to, &determinants, self.unknowns);
    }

    /// Copies one lane into a run.
    pub fn put(&self, lane: usize, run_state: &mut RunState) {
        let RunState {
            vectors, predictor, ..
        } = run_state;
        for (one, sums) in vectors
            .leg_sums_mut()
            .zip(self.sums.chunks_exact(self.coordinates))
        {
            read(one, sums, lane);
        }
        for (place, vector) in self.past.chunks_exact(self.unknowns.max(1)).enumerate() {
            for (i, x) in vector.iter().enumerate() {
                predictor.set(place, i, x.0[lane]);
            }
        }
        predictor.determinants = self.determinants.lane(lane);
        let one = |from: &[Eight]| Vector::from_fn(from.len(), |i| from[i].0[lane]);
        let (part, inverse) = self.natural.split_at(self.unknowns);
        let natural = (self.known >> lane & 1 == 1).then(|| RetainedSizes {
            part: one(part),
            inverse: one(inverse),
            level: self.level.0[lane],
        });
        predictor.set_natural(natural);
    }

    /// Copies a run into one lane.
    pub fn set_lane(&mut self, lane: usize, run_state: &RunState) {
        let RunState {
            vectors, predictor, ..
        } = run_state;
        self.determinants
            .set_lane(lane, &predictor.determinants, self.unknowns);
        for (one, sums) in vectors
            .leg_sums()
            .zip(self.sums.chunks_exact_mut(self.coordinates))
        {
            write(sums, lane, one);
        }
        for (to, from) in self
            .past
            .chunks_exact_mut(self.unknowns.max(1))
            .zip(predictor.vectors())
        {
            write(to, lane, from);
        }
        self.known &= !(1 << lane);
        if let Some(natural) = predictor.natural() {
            self.known |= 1 << lane;
            let (part, inverse) = self.natural.split_at_mut(self.unknowns);
            write(part, lane, &natural.part);
            write(inverse, lane, &natural.inverse);
            self.level.0[lane] = natural.level;
        }
    }
}

/// Reads one lane.
fn read(to: &mut [f64], from: &[Eight], lane: usize) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = from.0[lane];
    }
}

/// Writes one lane.
fn write(to: &mut [Eight], lane: usize, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        to.0[lane] = *from;
    }
}
