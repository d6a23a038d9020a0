//! The smooth steps of an interpreted system with few coordinates and unknowns: those of
//! [`smooth`](super::smooth), compiled here for each number of them.

#![allow(clippy::inline_always)] // parts of every step

use core::cell::Cell;

use super::declared::{Smooth, evaluated};
use super::interpreted::{FEWER, FirstPlaces, TapeKernel};
use super::slices::SliceSystem;
use super::smooth;
use crate::kernel::halt::Halt;
use crate::kernel::run_state::RunState;
use crate::number::point::Leg;
use crate::solve::Numbers;
use crate::solve::newton::Evaluation;
use crate::solve::unknown::Linearization;
use crate::tape::{FIXED, Place, Ready, Shape, Straight};

/// A program, and where it leaves its results.
struct Computed<'k, const K: usize> {
    program: Ready<'k>,
    results: [Place; K],
}

impl<'k, const K: usize> Computed<'k, K> {
    fn new(kernel: &'k TapeKernel, program: &'k Straight, numbers: &'k [Cell<f64>]) -> Self {
        Self {
            program: kernel.on(program, numbers),
            results: first(program.places()),
        }
    }
}

/// An interpreted system with `N` coordinates and `M` unknowns, and the numbers that its programs compute in.
struct FewUnknowns<'k, const N: usize, const M: usize> {
    shape: &'k Shape,
    /// The place of the last second difference.
    past: usize,
    numbers: &'k [Cell<f64>; FIXED],
    known: Ready<'k>,
    rows: Computed<'k, M>,
    /// Where the program of the rows leaves their Jacobian.
    jacobian: [[Place; M]; M],
    scales: Computed<'k, M>,
    unknown: Computed<'k, M>,
    difference: Computed<'k, N>,
    /// Whether the unknowns begin with the second difference. It need not pass through the numbers then: the next
    /// step would wait for it.
    begin_with_e: bool,
}

/// The first of some places; those of NaN if there are fewer.
fn first<const K: usize>(places: &[Place]) -> [Place; K] {
    places.first_chunk().copied().unwrap_or([0; K])
}

impl<'k, const N: usize, const M: usize> FewUnknowns<'k, N, M> {
    /// Where the numbers that change from step to step stand.
    const FIRST: FirstPlaces = FirstPlaces::of(N, M);

    fn new(kernel: &'k TapeKernel, numbers: &'k [Cell<f64>; FIXED]) -> Self {
        let programs = kernel.programs();
        let (_, rest) = programs.residual.places().split_at_checked(M).unwrap_or_default();
        let mut jacobian = [[0; M]; M];
        for (row, places) in jacobian.iter_mut().zip(rest.chunks_exact(M.max(1))) {
            *row = first(places);
        }
        let (e, z) = (
            programs.second_difference.places().iter(),
            Self::FIRST.z..Self::FIRST.z + N,
        );
        Self {
            shape: kernel.shape(),
            past: programs.places.past,
            numbers,
            known: kernel.on(&programs.known, numbers),
            rows: Computed::new(kernel, &programs.residual, numbers),
            jacobian,
            scales: Computed::new(kernel, &programs.scales, numbers),
            unknown: Computed::new(kernel, &programs.unknown, numbers),
            difference: Computed::new(kernel, &programs.second_difference, numbers),
            begin_with_e: e.map(|&place| place as usize).eq(z),
        }
    }

    /// Copies values to the places that begin at `first`.
    #[inline(always)]
    fn give<const K: usize>(&self, first: usize, values: &[f64; K]) {
        for (k, value) in values.iter().enumerate() {
            self.numbers[first + k].set(*value);
        }
    }

    /// The numbers at the places that begin at `first`.
    #[inline(always)]
    fn taken<const K: usize>(&self, first: usize) -> [f64; K] {
        let mut values = [0.0; K];
        for (k, value) in values.iter_mut().enumerate() {
            *value = self.numbers[first + k].get();
        }
        values
    }

    /// The results of a program.
    #[inline(always)]
    fn compute<const K: usize>(&self, computed: &Computed<'_, K>) -> [f64; K] {
        computed.program.run();
        self.read(&computed.results)
    }

    /// The numbers at some places. They are read one by one: a wide load of numbers that were just written one by
    /// one would stall the processor.
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // all places are small
    fn read<const K: usize>(&self, places: &[Place; K]) -> [f64; K] {
        let mut values = [0.0; K];
        for (value, &place) in values.iter_mut().zip(places) {
            *value = self.numbers[usize::from(place as u16)].get();
        }
        values
    }
}

impl<const N: usize, const M: usize> Smooth<N> for FewUnknowns<'_, N, M> {
    type Unknown = [f64; M];
    type Constants = [f64];
    /// Empty: the known values of a step are among the kernel's numbers.
    type Known = ();

    #[inline(always)]
    fn has_affine_rows(&self) -> bool {
        self.shape.linear
    }

    #[inline(always)]
    fn may_jump(&self) -> bool {
        self.shape.jumps
    }

    #[inline(always)]
    fn is_divided(&self) -> bool {
        self.shape.divided
    }

    #[inline(always)]
    fn is_scaled(&self) -> bool {
        self.shape.scaled
    }

    #[inline(always)]
    fn is_switching(&self) -> bool {
        self.shape.switches
    }

    #[inline(always)]
    fn asks_for_time(&self) -> bool {
        self.shape.depends_on_time
    }

    #[inline(always)]
    fn is_of_third_order(&self) -> bool {
        self.shape.is_of_third_order()
    }

    #[inline(always)]
    fn rotations(&self) -> &[usize] {
        &self.shape.rotations
    }

    #[inline(always)]
    fn is_forced(&self) -> bool {
        self.shape.external_forces
    }

    #[inline(always)]
    fn constants_of<'c>(&self, run: &'c mut Numbers) -> Option<&'c mut [f64]> {
        Some(run)
    }

    #[inline(always)]
    fn set_past(&self, constants: &mut [f64], past: &[f64; N]) {
        self.give(self.past, past);
        // they are the last of the constants
        if let Some(last) = constants.last_chunk_mut() {
            *last = *past;
        }
    }

    #[inline(always)]
    fn known_of(&self, _: &[f64], leg: &Leg<f64, N>) {
        self.give(Self::FIRST.clock, &[leg.t]);
        self.give(Self::FIRST.n, &leg.q);
        self.give(Self::FIRST.d, &leg.d);
        self.known.run();
    }

    #[inline(always)]
    fn evaluation(&self, _: &[f64], (): &(), z: [f64; M]) -> Evaluation<[f64; M]> {
        self.give(Self::FIRST.z, &z);
        self.rows.program.run();
        let mut jacobian = [[0.0; M]; M];
        let rows = if M > FEWER {
            let first = Self::FIRST.rows;
            for (i, row) in jacobian.iter_mut().enumerate() {
                *row = self.taken(first + M * (1 + i));
            }
            self.taken(first)
        } else {
            for (row, places) in jacobian.iter_mut().zip(&self.jacobian) {
                *row = self.read(places);
            }
            self.read(&self.rows.results)
        };
        let linearization = Linearization { rows, jacobian };
        if self.shape.linear && !self.shape.jumps {
            // of a copy, which is made here alone: the other stays in registers
            return evaluated(z, &mut linearization.clone(), true);
        }
        evaluated(z, &mut { linearization }, false)
    }

    #[inline(always)]
    fn row_scales(&self, _: &[f64], (): &(), z: &[f64; M]) -> [f64; M] {
        self.give(Self::FIRST.z, z);
        self.compute(&self.scales)
    }

    #[inline(always)]
    fn unknown_of(&self, e: &[f64; N]) -> [f64; M] {
        self.give(Self::FIRST.e, e);
        self.compute(&self.unknown)
    }

    #[inline(always)]
    fn difference(&self, _: &[f64], (): &(), z: &[f64; M]) -> [f64; N] {
        if let (true, Some(e)) = (self.begin_with_e, z.first_chunk()) {
            return *e;
        }
        self.give(Self::FIRST.z, z);
        self.compute(&self.difference)
    }
}

/// Steps of `N` coordinates and `M` unknowns.
#[inline(never)] // one copy for each pair of sizes
fn steps<const N: usize, const M: usize>(
    kernel: &TapeKernel,
    numbers: &[Cell<f64>; FIXED],
    run_state: &mut RunState,
    count: u64,
) -> Halt {
    smooth::steps::<_, N>(&FewUnknowns::<N, M>::new(kernel, numbers), run_state, count)
}

/// Makes up to `count` steps of a run; `None` if no instance has the system's numbers of coordinates and
/// unknowns.
pub(super) fn smooth(
    kernel: &TapeKernel,
    numbers: &mut [f64],
    run_state: &mut RunState,
    count: u64,
) -> Option<Halt> {
    let shape = kernel.shape();
    let programs = kernel.programs();
    if shape.increments != shape.dimension() || kernel.sparse().is_some() || programs.layout.len() > FIXED {
        return None;
    }
    kernel.take_constants(numbers, &run_state.constants);
    // a guess has no multipliers
    numbers.get_mut(programs.places.multipliers.clone())?.fill(0.0);
    let numbers = Cell::from_mut(numbers).as_slice_of_cells().first_chunk()?;
    macro_rules! of {
        ($($n:literal: $($m:literal),*);* $(;)?) => {
            match (shape.increments, shape.unknowns) {
                $($(($n, $m) => steps::<$n, $m>(kernel, numbers, run_state, count),)*)*
                _ => return None,
            }
        };
    }
    Some(of! {
        1: 0, 1, 2;
        2: 0, 1, 2, 3;
        3: 0, 1, 2, 3, 4;
        4: 0, 1, 2, 3, 4;
        5: 5;
        6: 6;
        7: 7;
        8: 8;
    })
}
