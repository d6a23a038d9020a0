//! The steps of a system that was not compiled, in lanes: its programs are interpreted on registers.
//!
//! The operations are those of the compiled steps ([`super::engine`]), in the same order, so the bits are the
//! same. The decisions of the iteration ([`super::newton`]) are the same code.

// see [`crate::number::instructions`]
#![allow(clippy::inline_always)]

use core::cell::Cell;
use core::marker::PhantomData;
use core::ops::Range;

use wide::f64x8;

use super::determinants::Determinants;
use super::engine::{
    Common, Engine, LaneKernel, LaneNode, LastStep, ScalarSteps, Task, is_near_prediction, short, times,
};
use super::lane_registers::{Natural, load, store};
use super::lane_state::LaneState;
use super::newton::{self, Roots};
use crate::kernel::Kernel as _;
use crate::number::compensated;
use crate::number::instructions::{Chosen, InLanes, Instructions, OTHERS};
use crate::number::lanes::{LANES, Lanes, Mask};
use crate::number::scalar::Scalar;
use crate::solve::elimination::slices;
use crate::solve::predictor::{extrapolate_one, size_after};
use crate::solve::rotation;
use crate::solve::sparse::Sparse;
use crate::solve::unknown::Unknown;
use crate::step::interpreted::StepPrograms;
use crate::step::{NEARLY_THE_SAME, SECOND_DIFFERENCE, TapeKernel};
use crate::tape::{Eight, FIXED, Numbers, Shape, Source, Straight, TapeCall};

/// The steps of a tape.
pub(super) struct InterpretedLanes<'k>(pub &'k TapeKernel);

impl LaneKernel for InterpretedLanes<'_> {
    fn engine<'k>(
        &'k self,
        instructions: Instructions,
        common: &Common,
        values: &[&[f64]; LANES],
    ) -> Box<dyn Engine + 'k> {
        if self.0.programs().layout.len() > FIXED {
            return Box::new(ScalarSteps);
        }
        if self.0.sparse().is_some() && Source::shape(self.0).unknowns > 0 {
            // as for compiled steps, these use the registers for which the program was compiled
            return Box::new(Steps::<f64x8>::new(
                (),
                self.0,
                Some(sparse_update),
                common,
                values,
            ));
        }
        #[cfg(target_arch = "x86_64")]
        if const { OTHERS } {
            use crate::number::lanes::x86::Avx2;
            // AVX-512 would save a tenth of the time, and take one more compilation
            if instructions >= Instructions::Avx2
                && let Some(token) = Avx2::token()
            {
                return Box::new(Steps::<Avx2>::new(token, self.0, None, common, values));
            }
        }
        let _ = instructions;
        Box::new(Steps::<f64x8>::new((), self.0, None, common, values))
    }
}

/// The memory for the leaves, operations and results of the system's programs, a number for each lane.
struct LaneMemory(Vec<f64>);

/// All places of this memory.
type Places = [[f64; LANES]; FIXED];

impl LaneMemory {
    /// Zeros. Unwritten pages take no physical memory.
    fn new() -> Self {
        Self(vec![0.0; (FIXED + 1) * LANES])
    }

    /// The numbers, from the first place aligned for registers on.
    fn places(&mut self) -> Option<&mut Places> {
        let first = self.0.as_ptr().align_offset(align_of::<Eight>());
        let (eights, _) = self.0.get_mut(first..)?.as_chunks_mut();
        eights.first_chunk_mut()
    }
}

/// The numbers of several programs as registers of one kind.
struct InRegisters<'n, R> {
    places: &'n mut Places,
    registers: PhantomData<R>,
}

impl<R: Chosen> Numbers for InRegisters<'_, R> {
    type Number = Lanes<R>;

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // all places are small
    fn at(&self, place: u32) -> Lanes<R> {
        Lanes::from(self.places[usize::from(place as u16)])
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // all places are small
    fn set(&mut self, place: u32, value: Lanes<R>) {
        self.places[usize::from(place as u16)] = value.into();
    }
}

impl<'n, R: Chosen> InRegisters<'n, R> {
    fn new(places: &'n mut Places) -> Self {
        Self {
            places,
            registers: PhantomData,
        }
    }

    /// Copies numbers in.
    #[inline(always)]
    fn take(&mut self, places: &Range<usize>, values: impl IntoIterator<Item = Lanes<R>>) {
        let room = self.places.get_mut(places.clone()).unwrap_or_default();
        for (to, from) in room.iter_mut().zip(values) {
            *to = from.into();
        }
    }

    /// Copies one number in.
    #[inline(always)]
    fn take_one(&mut self, place: usize, value: Lanes<R>) {
        if let Some(room) = self.places.get_mut(place) {
            *room = value.into();
        }
    }

    /// The results of a program, one after the other.
    #[inline(always)]
    fn results<'r>(&'r self, program: &'r Straight) -> impl Iterator<Item = Lanes<R>> + 'r {
        program.places().iter().map(|&place| self.at(place))
    }
}

/// The evaluation of a program, as a function that is compiled for each kind of register.
struct ProgramWork<'a, R> {
    program: &'a Straight,
    calls: &'a [TapeCall],
    numbers: InRegisters<'a, R>,
}

impl<R: Chosen> InLanes for ProgramWork<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        self.program.run_on(self.calls, &mut self.numbers);
    }
}

/// Evaluates a program; [`InRegisters::results`] then gives the results.
#[inline(never)] // it is long, and called from several places
fn walk<R: Chosen>(
    token: R::Token,
    program: &Straight,
    system: &TapeKernel,
    numbers: &mut InRegisters<'_, R>,
) {
    if program.is_empty() {
        return;
    }
    let walk = ProgramWork::<R> {
        program,
        calls: system.calls(),
        numbers: InRegisters::new(&mut *numbers.places),
    };
    R::run(token, walk);
}

/// Largest number of vectors of unknowns in a step: the iteration makes no more than a dozen for each of its
/// evaluations.
const VECTORS: usize = 12 * newton::MAX_EVALUATIONS as usize + 8;

/// The unused part of the workspace for vectors.
type Left<'r, R> = Cell<&'r mut [Lanes<R>]>;

/// A vector of unknowns, in workspace that is reused in the next step.
struct Unknowns<'l, 'r, R: Chosen> {
    numbers: &'r mut [Lanes<R>],
    left: &'l Left<'r, R>,
}

impl<'l, 'r, R: Chosen> Unknowns<'l, 'r, R> {
    /// A vector with unset numbers; empty if the workspace is used up.
    #[inline(always)]
    fn new(left: &'l Left<'r, R>, count: usize) -> Self {
        let (numbers, rest) = left.take().split_at_mut_checked(count).unwrap_or_default();
        left.set(rest);
        Self { numbers, left }
    }
}

impl<R: Chosen> Clone for Unknowns<'_, '_, R> {
    #[inline(always)]
    fn clone(&self) -> Self {
        let copy = Self::new(self.left, self.numbers.len());
        for (to, from) in copy.numbers.iter_mut().zip(&*self.numbers) {
            *to = *from;
        }
        copy
    }
}

impl<R: Chosen> AsRef<[Lanes<R>]> for Unknowns<'_, '_, R> {
    #[inline(always)]
    fn as_ref(&self) -> &[Lanes<R>] {
        self.numbers
    }
}

impl<R: Chosen> AsMut<[Lanes<R>]> for Unknowns<'_, '_, R> {
    #[inline(always)]
    fn as_mut(&mut self) -> &mut [Lanes<R>] {
        self.numbers
    }
}

/// Newton's update with a sparse Jacobian, in place of the rows, from the places of its entries; returns the
/// determinants, in given units.
type SparseUpdate<R> =
    fn(&Sparse, &mut Unknowns<'_, '_, R>, &[u32], &InRegisters<'_, R>, &[Lanes<R>; 2]) -> Lanes<R>;

/// The [`SparseUpdate`] for the registers for which the program was compiled.
fn sparse_update(
    sparse: &Sparse,
    rows: &mut Unknowns<'_, '_, f64x8>,
    places: &[u32],
    numbers: &InRegisters<'_, f64x8>,
    scales: &[Lanes; 2],
) -> Lanes {
    let mut determinants = Lanes::splat(if sparse.is_odd() { -1.0 } else { 1.0 });
    let mut scale = &scales[0];
    let found = sparse.update(
        |entries| {
            for (entry, &place) in entries.iter_mut().zip(places) {
                *entry = numbers.at(place);
            }
            rows.clone()
        },
        |pivot| {
            determinants = determinants * (pivot * *scale);
            scale = &scales[1];
        },
    );
    *rows = found.update;
    determinants
}

/// The steps in registers of one kind.
struct Steps<'k, R: Chosen> {
    /// Proof that the machine has them.
    token: R::Token,
    /// The system.
    system: &'k TapeKernel,
    /// The sparse elimination, if there is one.
    sparse: Option<SparseUpdate<R>>,
    /// The data that do not change.
    common: Common,
    /// The parameters.
    parameters: Vec<Eight>,
    /// The numbers of the programs.
    numbers: LaneMemory,
    /// The rest of the workspace.
    room: Workspace<R>,
}

/// The last node of a coordinate and the increment that led to it, as compensated sums: high part, low part
/// of each.
type Sums<R> = [Lanes<R>; 4];

/// The past of an unknown: its backward differences, then its recent size.
type Past<R> = [Lanes<R>; LaneState::VECTORS];

/// The state between steps.
struct LaneRegisters<R> {
    /// The last nodes.
    sums: Vec<Sums<R>>,
    /// The past solutions.
    past: Vec<Past<R>>,
    /// The natural sizes of the unknowns: [`PART_OF_NATURAL`](crate::solve::convergence) of them, then their
    /// inverse.
    natural: Vec<Lanes<R>>,
}

/// The workspace of steps, reused from step to step.
struct Workspace<R> {
    now: LaneRegisters<R>,
    /// The compensated sums after the step that is being made.
    next: Vec<Sums<R>>,
    /// Workspace for the vectors of a step.
    vectors: Vec<Lanes<R>>,
    /// Workspace for a matrix, and for two numbers a row.
    matrix: Vec<Lanes<R>>,
}

/// Loads vectors into registers, by components.
fn load_columns<R: Chosen, const K: usize>(to: &mut [[Lanes<R>; K]], from: &[Eight]) {
    let count = to.len().max(1);
    for (k, vector) in from.chunks_exact(count).take(K).enumerate() {
        for (to, from) in to.iter_mut().zip(vector) {
            to[k] = from.0.into();
        }
    }
}

/// Stores registers into vectors, by components.
fn store_columns<R: Chosen, const K: usize>(to: &mut [Eight], from: &[[Lanes<R>; K]]) {
    let count = from.len().max(1);
    for (k, vector) in to.chunks_exact_mut(count).take(K).enumerate() {
        for (to, from) in vector.iter_mut().zip(from) {
            to.0 = from[k].into();
        }
    }
}

impl<'k, R: Chosen> Steps<'k, R> {
    /// Steps with the given parameters.
    fn new(
        token: R::Token,
        system: &'k TapeKernel,
        sparse: Option<SparseUpdate<R>>,
        common: &Common,
        values: &[&[f64]; LANES],
    ) -> Self {
        let shape = Source::shape(system);
        let (n, m) = (shape.increments, shape.unknowns);
        let zero = Lanes::splat(0.0);
        let mut numbers = LaneMemory::new();
        if let Some(places) = numbers.places() {
            let layout = &system.programs().layout;
            layout.each_constant(|place, value| places[place] = [value; LANES]);
        }
        let mut steps = Self {
            token,
            system,
            sparse,
            common: *common,
            parameters: vec![Eight::ZERO; shape.parameters.len()],
            numbers,
            room: Workspace {
                now: LaneRegisters {
                    sums: vec![[zero; 4]; n],
                    past: vec![[zero; LaneState::VECTORS]; m],
                    natural: vec![zero; 2 * m],
                },
                next: vec![[zero; 4]; n],
                vectors: vec![zero; VECTORS * m],
                matrix: vec![zero; if sparse.is_some() { 0 } else { m * (m + 2) }],
            },
        };
        for (lane, values) in values.iter().enumerate() {
            steps.set_lane(lane, values);
        }
        steps.decide();
        steps
    }

    /// Sets one lane of the parameters; those beyond the last value are NaN.
    fn set_lane(&mut self, lane: usize, values: &[f64]) {
        for (place, parameter) in self.parameters.iter_mut().enumerate() {
            parameter.0[lane] = values.get(place).copied().unwrap_or(f64::NAN);
        }
    }

    /// Evaluates the constants of the run for the current parameters.
    fn decide(&mut self) {
        let StepPrograms {
            places, constants, ..
        } = self.system.programs();
        if let Some(numbers) = self.numbers.places() {
            let mut numbers = InRegisters::<R>::new(numbers);
            numbers.take_one(places.h, Lanes::splat(self.common.h));
            for (place, value) in places.parameters.clone().zip(&self.parameters) {
                numbers.take_one(place, value.0.into());
            }
            walk(self.token, constants, self.system, &mut numbers);
        }
    }
}

/// The rows of a step, in lanes.
struct Rows<'a, 'n, 'l, 'r, R: Chosen> {
    token: R::Token,
    system: &'a TapeKernel,
    sparse: Option<(&'a Sparse, SparseUpdate<R>)>,
    shape: &'a Shape,
    numbers: &'a mut InRegisters<'n, R>,
    /// The rows, then their Jacobian or its entries.
    program: &'a Straight,
    /// The units of the determinants.
    scales: [Lanes<R>; 2],
    /// Workspace for a matrix.
    matrix: &'a mut [Lanes<R>],
    /// The lanes whose past is too short to tell two roots apart.
    past_is_short: u32,
    unknowns: PhantomData<Unknowns<'l, 'r, R>>,
}

impl<'l, 'r, R: Chosen> newton::Equations<R> for Rows<'_, '_, 'l, 'r, R> {
    type Z = Unknowns<'l, 'r, R>;

    const MAY_BE_LINEAR: bool = true;

    const MAY_BE_WATCHED: bool = true;

    const MAY_BE_SCALED: bool = true;

    #[inline(always)]
    fn are_linear(&self) -> bool {
        self.shape.linear && !self.shape.jumps
    }

    #[inline(always)]
    fn are_watched(&self) -> bool {
        self.shape.is_watched()
    }

    #[inline(always)]
    fn are_scaled(&self) -> bool {
        self.shape.scaled
    }

    #[inline(always)]
    fn past_is_short(&self) -> Mask<R> {
        Mask::from_bits(self.past_is_short)
    }

    #[inline(always)]
    fn update(&mut self, z: &Self::Z) -> (Self::Z, Lanes<R>) {
        let numbers = &mut *self.numbers;
        numbers.take(&self.system.programs().places.z, z.as_ref().iter().copied());
        walk(self.token, self.program, self.system, numbers);
        let mut rows = z.clone();
        let (of_rows, of_entries) = self
            .program
            .places()
            .split_at_checked(rows.as_ref().len())
            .unwrap_or_default();
        for (row, &place) in rows.as_mut().iter_mut().zip(of_rows) {
            *row = numbers.at(place);
        }
        if let Some((sparse, update)) = self.sparse {
            let determinants = update(sparse, &mut rows, of_entries, numbers, &self.scales);
            return (rows, determinants);
        }
        let are_linear = self.shape.linear && !self.shape.jumps;
        let determinants = match (rows.as_mut(), of_entries) {
            ([x], &[a]) => {
                let a = numbers.at(a);
                *x = *x / a;
                a
            }
            ([x, y], &[a, b, c, d]) => {
                let matrix = [[numbers.at(a), numbers.at(b)], [numbers.at(c), numbers.at(d)]];
                let (solution, determinants) = if are_linear {
                    Unknown::solve_scaled(&matrix, &[*x, *y], &self.scales)
                } else {
                    Unknown::solve_lanes(&matrix, &[*x, *y], &self.scales)
                };
                [*x, *y] = solution;
                determinants
            }
            (right, _) => {
                let (matrix, beside) = self.matrix.split_at_mut(of_entries.len());
                for (entry, &place) in matrix.iter_mut().zip(of_entries) {
                    *entry = numbers.at(place);
                }
                slices::solve_lanes(matrix, right, beside, &self.scales, are_linear)
            }
        };
        for x in rows.as_mut() {
            *x = -*x;
        }
        (rows, determinants)
    }

    #[inline(always)]
    fn declared(&mut self, z: &Self::Z, nearby: &Self::Z) -> Mask<R> {
        let StepPrograms { places, scales, .. } = self.system.programs();
        self.numbers.take(&places.z, z.as_ref().iter().copied());
        walk(self.token, scales, self.system, self.numbers);
        let mut here = z.clone();
        for (here, scale) in here.as_mut().iter_mut().zip(self.numbers.results(scales)) {
            *here = scale;
        }
        self.numbers.take(&places.z, nearby.as_ref().iter().copied());
        walk(self.token, scales, self.system, self.numbers);
        let mut declared = Mask::splat(true);
        for (&here, there) in here.as_ref().iter().zip(self.numbers.results(scales)) {
            let change = (here - there).abs();
            declared = declared & change.below(Lanes::splat(NEARLY_THE_SAME) * here.abs());
        }
        declared
    }
}

/// Several steps, as a function that is compiled for each kind of register.
struct StepWork<'a, 'k, R: Chosen> {
    /// The steps.
    steps: &'a mut Steps<'k, R>,
    /// Their state.
    lane_state: &'a mut LaneState,
    /// Receives the data of the last node.
    lane_node: &'a mut LaneNode,
    /// The steps that are to be made.
    task: &'a Task,
}

impl<R: Chosen> InLanes for StepWork<'_, '_, R> {
    type Output = LastStep;

    #[inline(always)]
    #[expect(clippy::too_many_lines, reason = "a step is read from top to bottom")]
    fn run(self) -> LastStep {
        let Self {
            steps,
            lane_state,
            lane_node,
            task,
        } = self;
        let Steps {
            token,
            system,
            common,
            numbers,
            room,
            sparse,
            ..
        } = steps;
        let (token, system) = (*token, *system);
        let Some(numbers) = numbers.places() else {
            return LastStep::alone(task);
        };
        let numbers = &mut InRegisters::<R>::new(numbers);
        let (shape, programs) = (Source::shape(system), system.programs());
        let places = &programs.places;
        let sparse = system.sparse().zip(*sparse);
        let program = match sparse {
            Some(_) => &programs.entries,
            None => &programs.residual,
        };
        let Workspace {
            now,
            next,
            vectors,
            matrix,
        } = room;
        load_columns(&mut now.sums, &lane_state.sums);
        load_columns(&mut now.past, &lane_state.past);
        load(&mut now.natural, &lane_state.natural);
        let mut determinants: Determinants<R> = lane_state.determinants.moved();
        let (mut index, mut elsewhere) = (task.index, task.elsewhere);
        let mut lately = u32::MAX;
        loop {
            if lately != 0 {
                lately = short(task, index);
            }
            if shape.depends_on_time {
                numbers.take_one(places.clock, times(&common.clocks, index).into());
            }
            let left = Cell::new(&mut vectors[..]);
            let [guess, expected] = begin(token, system, numbers, now, &left, lane_state);
            let mut rows = Rows::<R> {
                token,
                system,
                sparse,
                shape,
                numbers,
                program,
                scales: determinants.scales,
                matrix,
                past_is_short: lately,
                unknowns: PhantomData,
            };
            let roots: Roots<Unknowns<'_, '_, R>, R> = newton::solve(
                &mut rows,
                guess.clone(),
                &expected,
                common.max_iterations,
                task.active,
            );
            let z = roots.z.as_ref();
            numbers.take(&places.z, z.iter().copied());
            walk(token, &programs.second_difference, system, numbers);
            let finite = arrive(
                &shape.rotations,
                numbers.results(&programs.second_difference),
                &now.sums,
                next,
            );
            let mut alone = task.active & (roots.left | elsewhere | !finite.bits());
            if z.len() < now.past.len() {
                // the workspace for vectors was used up: every lane's own flow makes the step
                alone = task.active;
            }
            if shape.jumps && common.may_stick {
                // the lane's own flow decides about a possible rest
                alone |= task.active & !is_near_prediction(guess.as_ref(), z).bits();
            }
            if !z.is_empty() {
                alone |= task.active & determinants.ask(roots.determinants);
            }
            if shape.is_watched() {
                alone |= determinants.take(roots.determinants, task.active & !alone);
            }
            let is_written = index == task.last;
            if is_written {
                write_node(token, system, numbers, &now.sums, lane_node);
                lane_node.evaluations = roots.evaluations;
            }
            if alone == 0 {
                core::mem::swap(&mut now.sums, next);
                for (past, &z) in now.past.iter_mut().zip(z) {
                    let [differences @ .., size] = past;
                    let mut difference = z;
                    for entry in differences {
                        let last = core::mem::replace(entry, difference);
                        difference = difference - last;
                    }
                    *size = size_after(*size, z);
                }
                determinants.push();
            }
            if alone != 0 || is_written {
                store_columns(&mut lane_state.sums, &now.sums);
                store_columns(&mut lane_state.past, &now.past);
                lane_state.determinants = determinants.moved();
                if alone != 0 {
                    let (to, found) = lane_state.found.split_at_mut(4 * next.len());
                    store_columns(to, next);
                    store(found, z);
                }
                return LastStep {
                    index,
                    alone,
                    is_written,
                };
            }
            index += 1;
            elsewhere = 0;
        }
    }
}

/// Copies a leg into the programs' memory. Returns the initial guess of the step, and the expected sizes of the unknowns.
#[inline(always)]
fn begin<'l, 'r, R: Chosen>(
    token: R::Token,
    system: &TapeKernel,
    numbers: &mut InRegisters<'_, R>,
    now: &LaneRegisters<R>,
    left: &'l Left<'r, R>,
    lane_state: &LaneState,
) -> [Unknowns<'l, 'r, R>; 2] {
    let StepPrograms {
        places,
        known,
        unknown,
        ..
    } = system.programs();
    let LaneRegisters { sums, past, natural } = now;
    numbers.take(&places.n, sums.iter().map(|[q, ..]| *q));
    numbers.take(&places.d, sums.iter().map(|[_, _, d, _]| *d));
    walk(token, known, system, numbers);
    // multipliers are zero: their places are never written
    numbers.take(&places.e, sums.iter().map(|[_, _, d, _]| *d));
    walk(token, unknown, system, numbers);
    let (mut guess, mut expected) = (Unknowns::new(left, past.len()), Unknowns::new(left, past.len()));
    let both = guess.as_mut().iter_mut().zip(expected.as_mut());
    for (((guess, expected), increment), past) in both.zip(numbers.results(unknown)).zip(past) {
        let [last, differences @ .., size] = past;
        *guess = extrapolate_one(*last, differences);
        *expected = size.larger(Lanes::splat(SECOND_DIFFERENCE) * increment.abs());
    }
    let (part, inverse) = natural.split_at(past.len());
    let natural = Natural {
        known: lane_state.known,
        part,
        inverse,
        level: lane_state.level.0.into(),
    };
    let lately = past.iter().map(|[.., size]| *size);
    [guess, natural.raise(expected, lately)]
}

/// Adds a second difference to the sums; returns the lanes where all nodes are finite, and no rotation turns
/// too far.
#[inline(always)]
fn arrive<R: Chosen>(
    rotations: &[usize],
    e: impl Iterator<Item = Lanes<R>>,
    sums: &[Sums<R>],
    next: &mut [Sums<R>],
) -> Mask<R> {
    let mut finite = Mask::<R>::splat(true);
    for ((e, &[q, below_q, d, below_d]), next) in e.zip(sums).zip(&mut *next) {
        let d = compensated::add((d, below_d), e);
        let q = compensated::plus((q, below_q), d);
        finite = finite & q.0.finite();
        *next = [q.0, q.1, d.0, d.1];
    }
    for &first in rotations {
        let slots = first..first + rotation::SLOTS;
        let (Some(from), Some(to)) = (sums.get(slots.clone()), next.get_mut(slots)) else {
            continue;
        };
        let [q, q_low] = [0, 1].map(|part| [0, 1, 2, 3].map(|k| from[k][part]));
        let [d, d_low] = [2, 3].map(|part| [0, 1, 2, 3].map(|k| to[k][part]));
        let [q, q_low] = rotation::turned([q, q_low], [d, d_low]);
        let longest = rotation::longest_square(&[0], &d);
        finite = finite & longest.below(Lanes::splat(rotation::TOO_FAR));
        for (k, to) in to.iter_mut().enumerate() {
            (to[0], to[1]) = (q[k], q_low[k]);
            finite = finite & q[k].finite();
        }
    }
    finite
}

/// Writes the middle node of a step, whose second difference was computed last.
#[inline(always)]
fn write_node<R: Chosen>(
    token: R::Token,
    system: &TapeKernel,
    numbers: &mut InRegisters<'_, R>,
    sums: &[Sums<R>],
    lane_node: &mut LaneNode,
) {
    let StepPrograms {
        places,
        second_difference,
        node,
        energy,
        ..
    } = system.programs();
    for (place, &from) in places.e.clone().zip(second_difference.places()) {
        let value = numbers.at(from);
        numbers.take_one(place, value);
    }
    walk(token, node, system, numbers);
    let (motion, force) = lane_node.vectors.split_at_mut(3 * sums.len());
    let mut t = [Eight::ZERO];
    let mut results = numbers.results(node);
    for room in [&mut *motion, &mut t, force] {
        for (to, from) in room.iter_mut().zip(&mut results) {
            to.0 = from.into();
        }
    }
    drop(results);
    numbers.take_one(places.t, t[0].0.into());
    let at = motion[..2 * sums.len()].iter();
    for (place, value) in places.q.clone().chain(places.v.clone()).zip(at) {
        numbers.take_one(place, value.0.into());
    }
    walk(token, energy, system, numbers);
    let energy = numbers.results(energy).next();
    lane_node.energy.0 = energy.unwrap_or(Lanes::splat(f64::NAN)).into();
    // the reported position is the middle node `q1`, whatever the declared maps are
    for (to, [q, ..]) in motion.iter_mut().zip(sums) {
        to.0 = (*q).into();
    }
}

impl<R: Chosen> Engine for Steps<'_, R> {
    fn steps(&mut self, lane_state: &mut LaneState, lane_node: &mut LaneNode, task: &Task) -> LastStep {
        R::run(
            self.token,
            StepWork {
                steps: self,
                lane_state,
                lane_node,
                task,
            },
        )
    }

    fn set_parameters(&mut self, lane: usize, values: &[f64]) {
        self.set_lane(lane, values);
        self.decide();
    }
}
