//! A kernel that was not compiled: it interprets a declaration's tape.

use core::cell::Cell;
use core::fmt;
use core::ops::Range;
use std::sync::{Arc, OnceLock};

#[cfg(feature = "jit")]
use dsocs_jit::JitError;
use thiserror::Error;

use super::arrays;
use super::slices::{self, PooledVector, SliceSystem, StepWorkspace, Workspace};
use crate::kernel::halt::Halt;
use crate::kernel::report::NodeMut;
use crate::kernel::run_state::RunState;
use crate::kernel::series::Series;
use crate::kernel::{At, Kernel};
use crate::number::dual::Dual;
use crate::number::point::{AnyLeg, copy};
use crate::number::tangent::Tangent;
use crate::solve::sparse::Sparse;
#[cfg(feature = "jit")]
use crate::tape::Tier;
use crate::tape::{
    CallData, Leaf, MemoryLayout, Part, Program, Ready, Segment, Shape, Source, Straight, Tape, TapeCall,
    TapeCalls,
};

/// A declared system as its tape and its shape alone, such as one that is read at run time.
///
/// It does the same operations in the same order as the code that the attribute writes for the declaration, and so gives the same bits. A
/// step takes several times as long.
#[derive(Clone, Debug)]
pub struct TapeKernel {
    tape: Arc<Tape>,
    shape: Shape,
    /// The values of the parameters, for runs that hold none of their own.
    values: Vec<f64>,
    sparse: Option<Sparse>,
    /// The functions that the tape calls, given as data.
    calls: TapeCalls,
    programs: Arc<StepPrograms>,
    series: Arc<Recurrences>,
}

/// The recurrences of Taylor series, made at the first request.
#[derive(Default)]
struct Recurrences {
    made: OnceLock<Option<Arc<Series>>>,
    make: Option<Box<Make>>,
}

/// Makes recurrences.
type Make = dyn Fn() -> Option<Series> + Send + Sync;

impl fmt::Debug for Recurrences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Recurrences").field(&self.made).finish()
    }
}

/// Errors of a tape and a shape that do not form a system.
#[derive(Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TapeError {
    /// The tape and the shape belong to different declarations, or the tape is malformed.
    #[error("the tape has {found} {what}, and the shape says {expected}")]
    Count {
        /// The counted items.
        what: &'static str,
        /// Their number in the tape.
        found: usize,
        /// Their number in the shape.
        expected: usize,
    },
    /// The declaration calls functions that only a compiled system has.
    #[error(
        "the tape calls functions of the user's, or reads parameters that are no numbers: only a compiled system has them"
    )]
    Functions,
}

crate::debug_is_message!(TapeError);

/// The programs that are evaluated often. Each reads its inputs, and the results of others, from the numbers
/// that it is handed.
#[derive(Debug)]
pub(crate) struct StepPrograms {
    pub places: Places,
    pub layout: MemoryLayout,
    pub constants: Straight,
    pub known: Straight,
    /// The rows, then their Jacobian row by row.
    pub residual: Straight,
    /// The rows, then the entries of a sparse Jacobian.
    pub entries: Straight,
    pub scales: Straight,
    pub unknown: Straight,
    pub second_difference: Straight,
    /// Position, velocity, acceleration, time and constraint force.
    pub node: Straight,
    pub energy: Straight,
    /// Decides when the programs of steps become machine code.
    #[cfg(feature = "jit")]
    tier: Tier,
}

/// The places of the programs' inputs in the memory that they compute in. The first number there belongs to
/// no input: it is NaN.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    pub h: usize,
    pub clock: usize,
    pub t: usize,
    pub parameters: Range<usize>,
    pub constants: Range<usize>,
    /// The last second difference of a run of third order, at the end of the constants.
    pub past: usize,
    pub known: Range<usize>,
    pub z: Range<usize>,
    pub multipliers: Range<usize>,
    pub n: Range<usize>,
    pub d: Range<usize>,
    pub e: Range<usize>,
    pub q: Range<usize>,
    pub v: Range<usize>,
    pub count: usize,
}

/// The first places: what steps give to programs. They depend on the numbers of coordinates and unknowns alone, so
/// code for given numbers of them knows the places.
pub(super) struct FirstPlaces {
    pub clock: usize,
    pub n: usize,
    pub d: usize,
    pub e: usize,
    pub z: usize,
    /// Of more than [`FEWER`] unknowns: the rows, then their Jacobian row by row.
    pub rows: usize,
    /// Where the rest begins.
    rest: usize,
}

/// The rows of more unknowns than these, and their Jacobian, stand one after the other. Fewer are left where they are computed, and read one by one: a
/// wide load of numbers that were just written one by one would stall the processor.
pub(super) const FEWER: usize = 4;

/// Up to this many unknowns have a place for their Jacobian among the first.
const FEW: usize = 8;

impl FirstPlaces {
    /// The places for `n` coordinates and `m` unknowns.
    pub const fn of(n: usize, m: usize) -> Self {
        let clock = 1;
        let first = clock + 1;
        Self {
            clock,
            n: first,
            d: first + n,
            e: first + 2 * n,
            z: first + 3 * n,
            rows: first + 3 * n + m,
            rest: first + 3 * n + m + if m <= FEW { m * (m + 1) } else { 0 },
        }
    }
}

impl Places {
    fn new(shape: &Shape, place_of_past: usize) -> Self {
        let (n, m) = (shape.dimension(), shape.unknowns);
        let first = FirstPlaces::of(n, m);
        let mut count = first.rest;
        let mut next = |length: usize| {
            count += length;
            count - length..count
        };
        let constants = next(shape.constants);
        Self {
            h: next(1).start,
            clock: first.clock,
            t: next(1).start,
            parameters: next(shape.parameters.len()),
            past: constants.start + place_of_past,
            constants,
            known: next(shape.known),
            z: first.z..first.z + m,
            multipliers: next(m.max(shape.forms)),
            n: first.n..first.n + n,
            d: first.d..first.d + n,
            e: first.e..first.e + n,
            q: next(n),
            v: next(n),
            count,
        }
    }

    /// The place of a leaf; 0, the place of NaN, if there is none of this number.
    fn of(&self, leaf: Leaf) -> usize {
        let (range, i) = match leaf {
            Leaf::H => return self.h,
            Leaf::Clock => return self.clock,
            Leaf::T => return self.t,
            Leaf::Parameter(i) => (&self.parameters, i),
            Leaf::Constant(i) => (&self.constants, i),
            Leaf::P(i) => (&(self.past..self.constants.end), i),
            Leaf::Known(i) => (&self.known, i),
            Leaf::Z(i) => (&self.z, i),
            Leaf::Lambda(i) => (&self.multipliers, i),
            Leaf::N(i) => (&self.n, i),
            Leaf::D(i) => (&self.d, i),
            Leaf::E(i) => (&self.e, i),
            Leaf::Q(i) => (&self.q, i),
            Leaf::V(i) => (&self.v, i),
            Leaf::A(_) | Leaf::J(_) | Leaf::Side(_) => return 0,
        };
        range.clone().nth(i).unwrap_or(0)
    }
}

/// A program, the leaves that it reads as inputs, and the place of its results if other programs read them.
type Reading = (Program, fn(Leaf) -> bool, Option<usize>);

/// The leaves that are known when a run begins.
fn is_of_run(leaf: Leaf) -> bool {
    matches!(leaf, Leaf::H | Leaf::Parameter(_))
}

/// The leaves that are known when a step begins.
fn is_of_leg(leaf: Leaf) -> bool {
    matches!(
        leaf,
        Leaf::Constant(_) | Leaf::Clock | Leaf::N(_) | Leaf::D(_) | Leaf::P(_)
    )
}

/// The leaves that are known in an iteration.
fn is_of_iteration(leaf: Leaf) -> bool {
    matches!(leaf, Leaf::Constant(_) | Leaf::Known(_) | Leaf::Z(_))
}

impl StepPrograms {
    fn new(tape: &Tape, shape: &Shape, sparse: Option<&Sparse>) -> Self {
        let program = |segment, given: &[Segment]| {
            let all: Vec<usize> = (0..tape.count(segment, Part::All)).collect();
            tape.later(segment, &all, given)
        };
        let both = [Segment::Constants, Segment::Known];
        let unknowns = shape.unknowns;
        let entries = sparse.map(|sparse| {
            let places = sparse.places().iter().map(|place| place.map(usize::from));
            let entries = places.map(|[row, column]| unknowns * (1 + row) + column);
            let wanted: Vec<usize> = (0..unknowns).chain(entries).collect();
            tape.later(Segment::Residual, &wanted, &both)
        });
        let places = Places::new(shape, tape.count(Segment::Constants, Part::All));
        let [of_run, of_step] = [&places.constants, &places.known].map(|range| Some(range.start));
        let first = FirstPlaces::of(shape.dimension(), unknowns);
        let of_rows = (FEWER + 1..=FEW).contains(&unknowns).then_some(first.rows);
        let programs: [Reading; 9] = [
            (program(Segment::Constants, &[]), is_of_run, of_run),
            (program(Segment::Known, &both[..1]), is_of_leg, of_step),
            (program(Segment::Residual, &both), is_of_iteration, of_rows),
            (entries.unwrap_or_default(), is_of_iteration, None),
            (program(Segment::Scales, &both), is_of_iteration, None),
            (
                program(Segment::Unknown, &[]),
                |leaf| matches!(leaf, Leaf::E(_) | Leaf::Lambda(_)),
                None,
            ),
            (program(Segment::SecondDifference, &both), is_of_iteration, None),
            (
                program(Segment::Node, &both[..1]),
                |leaf| is_of_leg(leaf) || matches!(leaf, Leaf::E(_)),
                None,
            ),
            (
                program(Segment::Energy, &both[..1]),
                |leaf| matches!(leaf, Leaf::Constant(_) | Leaf::T | Leaf::Q(_) | Leaf::V(_)),
                None,
            ),
        ];
        let mut layout = MemoryLayout::new(places.count, programs.iter().map(|(program, ..)| program));
        let [
            constants,
            known,
            residual,
            entries,
            scales,
            unknown,
            second_difference,
            node,
            energy,
        ] = programs.map(|(program, reads, into)| {
            let place = |leaf| if reads(leaf) { places.of(leaf) } else { 0 };
            layout.straighten(&program, &place, into)
        });
        Self {
            places,
            layout,
            constants,
            known,
            residual,
            entries,
            scales,
            unknown,
            second_difference,
            node,
            energy,
            #[cfg(feature = "jit")]
            tier: Tier::default(),
        }
    }
}

#[cfg(feature = "jit")]
impl StepPrograms {
    /// Compiles the programs of steps. Those of the constants, evaluated once a run, stay interpreted.
    fn compile(&self) -> Result<(), JitError> {
        self.tier.compile(&[
            &self.known,
            &self.residual,
            &self.entries,
            &self.scales,
            &self.unknown,
            &self.second_difference,
            &self.node,
            &self.energy,
        ])
    }
}

impl TapeKernel {
    /// Compiles the system to machine code at once, not only after some steps of a run.
    ///
    /// # Errors
    ///
    /// [`JitError`] if there is no machine code: on another processor than x86-64, or if the operating system
    /// grants no executable memory. Then the system is interpreted.
    #[cfg(feature = "jit")]
    pub fn compile(&self) -> Result<(), JitError> {
        self.programs.compile()
    }

    /// The system without compilation to machine code.
    #[cfg(feature = "jit")]
    #[must_use]
    pub fn interpreted(self) -> Self {
        let programs = StepPrograms {
            tier: Tier::never(),
            ..StepPrograms::new(&self.tape, &self.shape, self.sparse.as_ref())
        };
        Self {
            programs: Arc::new(programs),
            ..self
        }
    }

    /// Sets a parameter, by its place among [`Shape::parameters`].
    pub fn parameter_mut(&mut self, index: usize) -> Option<&mut f64> {
        self.values.get_mut(index)
    }

    /// The system of a tape. `values` are those of the parameters; missing ones are NaN.
    ///
    /// # Errors
    ///
    /// [`TapeError`] if the tape and the shape do not fit together, or if the tape calls functions.
    pub fn new(tape: Tape, shape: Shape, values: Vec<f64>) -> Result<Self, TapeError> {
        Self::with_calls(tape, shape, values, Vec::new())
    }

    /// [`TapeKernel::new`] for a tape that calls numbers and tables of samples.
    ///
    /// # Errors
    ///
    /// [`TapeError`] as [`TapeKernel::new`], or if the tape calls more than `calls`.
    pub fn with_calls(
        tape: Tape,
        shape: Shape,
        values: Vec<f64>,
        calls: Vec<TapeCall>,
    ) -> Result<Self, TapeError> {
        if tape.calls() > calls.len() {
            return Err(TapeError::Functions);
        }
        let (n, m) = (shape.dimension(), shape.unknowns);
        let past = if shape.is_of_third_order() { n } else { 0 };
        let counts = [
            (
                "values that parameters decide",
                Segment::Constants,
                Part::All,
                shape.constants.saturating_sub(past),
            ),
            (
                "values that are known in a step",
                Segment::Known,
                Part::All,
                shape.known,
            ),
            ("rows of a step", Segment::Residual, Part::Head, m),
            (
                "entries of a Jacobian",
                Segment::Residual,
                Part::Tail,
                m.saturating_mul(m),
            ),
            ("unknowns", Segment::Unknown, Part::All, m),
            (
                "components of a second difference",
                Segment::SecondDifference,
                Part::All,
                n,
            ),
            ("components of a point", Segment::Node, Part::Head, 3 * n + 1),
            ("components of a force", Segment::Node, Part::Tail, n),
            ("energies", Segment::Energy, Part::All, 1),
            (
                "observed expressions",
                Segment::Observe,
                Part::All,
                shape.observables.len(),
            ),
        ];
        for (what, segment, part, expected) in counts {
            let found = tape.count(segment, part);
            if found != expected {
                return Err(TapeError::Count {
                    what,
                    found,
                    expected,
                });
            }
        }
        Ok(Self {
            programs: Arc::new(StepPrograms::new(&tape, &shape, None)),
            tape: Arc::new(tape),
            shape,
            values,
            calls: TapeCalls(calls),
            sparse: None,
            series: Arc::default(),
        })
    }

    /// The system with Taylor series, whose recurrences are made when a method first asks for them.
    #[cfg_attr(not(feature = "text"), allow(dead_code))] // only systems read from a text have series
    pub(crate) fn with_series(self, make: impl Fn() -> Option<Series> + Send + Sync + 'static) -> Self {
        let series = Recurrences {
            made: OnceLock::new(),
            make: Some(Box::new(make)),
        };
        Self {
            series: Arc::new(series),
            ..self
        }
    }

    /// The recurrences of its Taylor series, if it has any.
    pub(crate) fn series(&self) -> Option<Arc<Series>> {
        let Recurrences { made, make } = &*self.series;
        let made = made.get_or_init(|| make.as_ref().and_then(|make| make()).map(Arc::new));
        made.clone()
    }

    /// The system with a Jacobian that is eliminated as a sparse matrix.
    ///
    /// # Errors
    ///
    /// [`TapeError`] if the matrix has another size.
    pub fn sparse(self, sparse: Sparse) -> Result<Self, TapeError> {
        let (found, expected) = (sparse.size(), self.shape.unknowns);
        if found != expected {
            let what = "rows of a sparse matrix";
            return Err(TapeError::Count {
                what,
                found,
                expected,
            });
        }
        Ok(Self {
            programs: Arc::new(StepPrograms::new(&self.tape, &self.shape, Some(&sparse))),
            sparse: Some(sparse),
            ..self
        })
    }

    /// The programs that are evaluated often.
    pub(crate) fn programs(&self) -> &StepPrograms {
        &self.programs
    }

    /// The functions that the tape calls.
    pub(crate) fn calls(&self) -> &[TapeCall] {
        &self.calls.0
    }

    /// Calls `work` with the workspace of this thread.
    fn in_room<R>(&self, work: impl FnOnce(&mut [f64], &mut StepWorkspace) -> R) -> R {
        // an evaluation inside `work`, or at the end of the thread, finds an empty workspace
        let mut room = ROOM.try_with(Cell::take).unwrap_or_default();
        let Workspace { numbers, workspace } = &mut room;
        let result = work(self.programs.layout.prepare(numbers), workspace);
        // at the end of the thread there is no place to keep it
        let _ = ROOM.try_with(|kept| kept.set(room));
        result
    }

    /// A program that is ready to be evaluated on the numbers.
    #[inline]
    pub(super) fn on<'r>(&'r self, program: &'r Straight, numbers: &'r [Cell<f64>]) -> Ready<'r> {
        program.on(&self.programs.layout, &self.calls, numbers)
    }

    /// Evaluates a program.
    #[inline]
    fn run(&self, program: &Straight, numbers: &mut [f64]) {
        self.on(program, Cell::from_mut(numbers).as_slice_of_cells())
            .run();
    }

    /// Evaluates a program and writes as many results as `out` has room for.
    #[inline]
    fn write(&self, program: &Straight, numbers: &mut [f64], out: &mut [f64]) {
        self.run(program, numbers);
        for (out, result) in out.iter_mut().zip(program.results(numbers)) {
            *out = result;
        }
    }

    /// Evaluates a program and writes its results to one slice, then to another.
    fn write_both(&self, program: &Straight, numbers: &mut [f64], first: &mut [f64], second: &mut [f64]) {
        self.run(program, numbers);
        let mut results = program.results(numbers);
        for out in [first, second] {
            for (out, result) in out.iter_mut().zip(&mut results) {
                *out = result;
            }
        }
    }

    /// Makes up to `count` steps of a run.
    fn walk(&self, run_state: &mut RunState, count: u64) -> Halt {
        self.in_room(|numbers, workspace| {
            if let Some(halt) = arrays::smooth(self, numbers, run_state, count) {
                return halt;
            }
            match self.shape.unknowns {
                1 => slices::smooth::<_, [f64; 1]>(self, (numbers, workspace), run_state, count),
                2 => slices::smooth::<_, [f64; 2]>(self, (numbers, workspace), run_state, count),
                3 => slices::smooth::<_, [f64; 3]>(self, (numbers, workspace), run_state, count),
                4 => slices::smooth::<_, [f64; 4]>(self, (numbers, workspace), run_state, count),
                _ => slices::smooth::<_, PooledVector>(self, (numbers, workspace), run_state, count),
            }
        })
    }

    /// Copies the constants, the known values and the unknowns of an iteration into the numbers.
    fn take_at(&self, numbers: &mut [f64], at: At<'_>) {
        self.take_constants(numbers, at.constants);
        take(numbers, &self.programs.places.known, at.known);
        self.take_unknowns(numbers, at.z);
    }

    /// The place of the last second difference of third order among the constants.
    fn place_of_past(&self) -> usize {
        self.tape.count(Segment::Constants, Part::All)
    }
}

thread_local! {
    /// The workspace of kernels on this thread; kept, so that a step allocates nothing.
    static ROOM: Cell<Workspace> = const { Cell::new(Workspace::EMPTY) };
}

/// Copies values into the numbers; missing ones are NaN.
#[inline]
fn take(numbers: &mut [f64], places: &Range<usize>, values: &[f64]) {
    let room = numbers.get_mut(places.clone()).unwrap_or_default();
    if room.len() > values.len() {
        room.fill(f64::NAN);
    }
    copy(room, values);
}

/// Copies one value.
#[inline]
fn take_one(numbers: &mut [f64], place: usize, value: f64) {
    if let Some(number) = numbers.get_mut(place) {
        *number = value;
    }
}

impl SliceSystem for TapeKernel {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn sparse(&self) -> Option<&Sparse> {
        self.sparse.as_ref()
    }

    fn take_constants(&self, numbers: &mut [f64], constants: &[f64]) {
        take(numbers, &self.programs.places.constants, constants);
    }

    fn take_past(&self, numbers: &mut [f64], constants: &mut [f64], past: &[f64]) {
        self.remember(constants, past);
        self.take_constants(numbers, constants);
    }

    fn take_leg(&self, numbers: &mut [f64], leg: AnyLeg<'_, f64>) {
        let StepPrograms { places, known, .. } = &*self.programs;
        take_one(numbers, places.clock, leg.t);
        take(numbers, &places.n, leg.q);
        take(numbers, &places.d, leg.d);
        self.run(known, numbers);
    }

    fn take_unknowns(&self, numbers: &mut [f64], z: &[f64]) {
        take(numbers, &self.programs.places.z, z);
    }

    fn rows(&self, numbers: &mut [f64], rows: &mut [f64], jacobian: &mut [f64]) {
        self.write_both(&self.programs.residual, numbers, rows, jacobian);
    }

    fn sparse_rows(&self, numbers: &mut [f64], rows: &mut [f64], entries: &mut [f64]) {
        self.write_both(&self.programs.entries, numbers, rows, entries);
    }

    fn row_scales(&self, numbers: &mut [f64], scales: &mut [f64]) {
        self.write(&self.programs.scales, numbers, scales);
    }

    fn difference(&self, numbers: &mut [f64], e: &mut [f64]) {
        self.write(&self.programs.second_difference, numbers, e);
    }

    fn unknowns_of(&self, numbers: &mut [f64], e: &[f64], z: &mut [f64]) {
        let places = &self.programs.places;
        take(numbers, &places.e, e);
        if let Some(multipliers) = numbers.get_mut(places.multipliers.clone()) {
            multipliers.fill(0.0);
        }
        self.write(&self.programs.unknown, numbers, z);
    }
}

impl Source for TapeKernel {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn tape(&self) -> &Tape {
        &self.tape
    }

    fn value(&self, parameter: usize) -> f64 {
        self.values.get(parameter).copied().unwrap_or(f64::NAN)
    }

    fn call(&self, which: usize, arguments: &[f64]) -> f64 {
        let call = self.calls.0.get(which);
        call.map_or(f64::NAN, |call| call.value(arguments.first().copied()))
    }

    fn call_dual(&self, which: usize, arguments: &[Dual<f64>]) -> Dual<f64> {
        let argument = arguments
            .first()
            .map(|argument| Tangent::new(argument.re, argument.eps));
        let value = self.calls.0.get(which).map(|call| call.value(argument));
        value.map_or(Dual::new(f64::NAN, f64::NAN), |value| {
            Dual::new(value.value(), value.derivative())
        })
    }

    fn data(&self, which: usize) -> Option<CallData<'_>> {
        self.calls.0.get(which).map(TapeCall::data)
    }
}

impl Kernel for TapeKernel {
    fn smooth(&self, run_state: &mut RunState, count: u64) -> Halt {
        #[cfg(feature = "jit")]
        if let Some(first) = self.programs.tier.steps_before(count) {
            match self.walk(run_state, first) {
                Halt::Done => {}
                halt @ Halt::NotSmooth(_) => return halt,
            }
            // if it fails, the programs stay interpreted
            let _ = self.programs.compile();
            return self.walk(run_state, count - first);
        }
        self.walk(run_state, count)
    }

    fn constants(&self, parameters: &[f64], h: f64, constants: &mut [f64]) {
        // the last second difference is not known yet
        if let Some(past) = constants.get_mut(self.place_of_past()..) {
            past.fill(0.0);
        }
        self.in_room(|numbers, _| {
            take_one(numbers, self.programs.places.h, h);
            take(numbers, &self.programs.places.parameters, parameters);
            self.write(&self.programs.constants, numbers, constants);
        });
    }

    fn remember(&self, constants: &mut [f64], past: &[f64]) {
        let places = constants.iter_mut().skip(self.place_of_past());
        for (out, &past) in places.zip(past) {
            *out = past;
        }
    }

    fn past(&self, constants: &[f64], past: &mut [f64]) {
        let known = constants.iter().skip(self.place_of_past());
        let known = known.copied().chain(core::iter::repeat(0.0));
        for (out, known) in past.iter_mut().zip(known) {
            *out = known;
        }
    }

    fn known(&self, constants: &[f64], leg: AnyLeg<'_, f64>, known: &mut [f64]) {
        self.in_room(|numbers, _| {
            self.take_constants(numbers, constants);
            self.take_leg(numbers, leg);
            copy(
                known,
                numbers
                    .get(self.programs.places.known.clone())
                    .unwrap_or_default(),
            );
        });
    }

    fn linearize(&self, at: At<'_>, rows: &mut [f64], jacobian: &mut [f64]) {
        self.in_room(|numbers, _| {
            self.take_at(numbers, at);
            self.rows(numbers, rows, jacobian);
        });
    }

    fn sparse(&self) -> Option<&Sparse> {
        self.sparse.as_ref()
    }

    fn entries(&self, at: At<'_>, rows: &mut [f64], entries: &mut [f64]) {
        if self.sparse.is_some() {
            self.in_room(|numbers, _| {
                self.take_at(numbers, at);
                self.sparse_rows(numbers, rows, entries);
            });
        }
    }

    fn scales(&self, at: At<'_>, scales: &mut [f64]) {
        scales.fill(1.0);
        if self.shape.scaled {
            self.in_room(|numbers, _| {
                self.take_at(numbers, at);
                self.row_scales(numbers, scales);
            });
        }
    }

    fn unknown(&self, e: &[f64], multipliers: &[f64], z: &mut [f64]) {
        self.in_room(|numbers, _| {
            let places = &self.programs.places;
            take(numbers, &places.e, e);
            if let Some(room) = numbers.get_mut(places.multipliers.clone()) {
                // missing ones are zero
                room.fill(0.0);
                copy(room, multipliers);
            }
            self.write(&self.programs.unknown, numbers, z);
        });
    }

    fn second_difference(&self, at: At<'_>, e: &mut [f64]) {
        self.in_room(|numbers, _| {
            self.take_at(numbers, at);
            self.difference(numbers, e);
        });
    }

    fn report(&self, run_state: &RunState, node: NodeMut<'_>) {
        let (leg, e) = (run_state.solved_leg(), run_state.vectors.e());
        let StepPrograms {
            places,
            node: point,
            energy,
            ..
        } = &*self.programs;
        let n = node.vectors.len() / 4;
        let (motion, force) = node.vectors.split_at_mut(3 * n);
        let energy = self.in_room(|numbers, _| {
            self.take_constants(numbers, &run_state.constants);
            // as before the step
            take(
                numbers,
                &(places.past..places.constants.end),
                run_state.vectors.before(),
            );
            take_one(numbers, places.clock, leg.t);
            take(numbers, &places.n, leg.q);
            take(numbers, &places.d, leg.d);
            take(numbers, &places.e, e);
            self.run(point, numbers);
            let mut t = [f64::NAN];
            let mut results = point.results(numbers);
            for out in [&mut *motion, &mut t, force] {
                for (out, result) in out.iter_mut().zip(&mut results) {
                    *out = result;
                }
            }
            drop(results);
            take_one(numbers, places.t, t[0]);
            take(numbers, &places.q, &motion[..n]);
            take(numbers, &places.v, &motion[n..2 * n]);
            let mut value = [f64::NAN];
            self.write(energy, numbers, &mut value);
            value[0]
        });
        // the reported position is the middle node `q1`, whatever the declared maps are
        copy(motion, leg.q);
        node.scalars.energy = energy;
    }
}
