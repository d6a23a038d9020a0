//! The steps of a system that was not compiled, in lanes: its programs are walked over registers.
//!
//! The operations are those of the compiled steps ([`super::engine`]), in the same order, so the bits are the same. What decides how the iteration goes
//! ([`super::newton`]) is the same code.

// see [`crate::number::instructions`]
#![allow(clippy::inline_always)]

use core::cell::Cell;
use core::marker::PhantomData;
use core::ops::Range;
use std::rc::Rc;

use wide::f64x8;

use super::determinants::Determinants;
use super::engine::{Alone, Common, Engine, LaneKernel, Made, Task, Told, foresees, short, times};
use super::kept::Kept;
use super::newton::{self, Components, Roots};
use super::state::{Natural, load, store};
use crate::kernel::Kernel as _;
use crate::number::compensated;
use crate::number::instructions::{Chosen, InLanes, Instructions, OTHERS};
use crate::number::lanes::{LANES, Lanes, Mask};
use crate::number::scalar::Scalar;
use crate::solve::elimination::slices;
use crate::solve::predictor::{extrapolate, push_past, size_after};
use crate::solve::sparse::Sparse;
use crate::solve::unknown::Unknown;
use crate::step::interpreted::Hot;
use crate::step::{NEARLY_THE_SAME, SECOND_DIFFERENCE, TapeKernel};
use crate::tape::{Eight, FIXED, Numbers, Shape, Source, Straight, TapeCall};

/// The steps of a tape.
pub(super) struct Walked<'k>(pub &'k TapeKernel);

impl LaneKernel for Walked<'_> {
    fn engine<'k>(
        &'k self,
        instructions: Instructions,
        common: &Common,
        values: &[&[f64]; LANES],
    ) -> Box<dyn Engine + 'k> {
        if self.0.hot().stretch.len() > FIXED {
            return Box::new(Alone);
        }
        if Source::shape(self.0).unknowns > 0 && self.0.sparse().is_some() {
            // as where steps are compiled
            return steps::<f64x8, Pooled<f64x8, true>>((), self.0, common, values);
        }
        #[cfg(target_arch = "x86_64")]
        if const { OTHERS } {
            use crate::number::lanes::x86::{Avx2, Avx512};
            if instructions >= Instructions::Avx512
                && let Some(token) = Avx512::token()
            {
                return engine::<Avx512>(token, self.0, common, values);
            }
            if instructions >= Instructions::Avx2
                && let Some(token) = Avx2::token()
            {
                return engine::<Avx2>(token, self.0, common, values);
            }
        }
        let _ = instructions;
        engine::<f64x8>((), self.0, common, values)
    }
}

/// The steps in registers of one kind.
fn engine<'k, R: Chosen>(
    token: R::Token,
    system: &'k TapeKernel,
    common: &Common,
    values: &[&[f64]; LANES],
) -> Box<dyn Engine + 'k> {
    let steps = match Source::shape(system).unknowns {
        1 => steps::<R, [Lanes<R>; 1]>,
        2 => steps::<R, [Lanes<R>; 2]>,
        _ => steps::<R, Pooled<R, false>>,
    };
    steps(token, system, common, values)
}

/// The same with unknowns of one kind.
fn steps<'k, R: Chosen, Z: Unknowns<R> + 'k>(
    token: R::Token,
    system: &'k TapeKernel,
    common: &Common,
    values: &[&[f64]; LANES],
) -> Box<dyn Engine + 'k> {
    Box::new(Steps::<R, Z>::new(token, system, common, values))
}

/// The numbers of a stretch in lanes.
struct Stretched(Vec<f64>);

/// All places of a stretch.
type Places = [[f64; LANES]; FIXED];

impl Stretched {
    /// Zeros. Where nothing is written, the system gives no memory.
    fn new() -> Self {
        Self(vec![0.0; (FIXED + 1) * LANES])
    }

    /// The numbers, from a place on where registers begin.
    fn places(&mut self) -> Option<&mut Places> {
        let first = self.0.as_ptr().align_offset(align_of::<Eight>());
        let (eights, _) = self.0.get_mut(first..)?.as_chunks_mut();
        eights.first_chunk_mut()
    }
}

/// The numbers of a stretch as registers of one kind.
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

    /// Takes numbers in.
    #[inline(always)]
    fn take(&mut self, places: &Range<usize>, values: &[Lanes<R>]) {
        let room = self.places.get_mut(places.clone()).unwrap_or_default();
        for (to, &from) in room.iter_mut().zip(values) {
            *to = from.into();
        }
    }

    /// Takes one number in.
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

/// Work for the registers: a program.
struct Walk<'a, R> {
    program: &'a Straight,
    calls: &'a [TapeCall],
    numbers: InRegisters<'a, R>,
}

impl<R: Chosen> InLanes for Walk<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        self.program.run_on(self.calls, &mut self.numbers);
    }
}

/// Evaluates a program; its results are then where [`InRegisters::results`] finds them.
#[inline(never)] // it is long, and called from several places
fn walk<R: Chosen>(
    token: R::Token,
    program: &Straight,
    system: &TapeKernel,
    numbers: &mut InRegisters<'_, R>,
) {
    let walk = Walk::<R> {
        program,
        calls: system.calls(),
        numbers: InRegisters::new(&mut *numbers.places),
    };
    R::run(token, walk);
}

/// A vector of unknowns.
trait Unknowns<R: Chosen>: Components<Lanes<R>> {
    /// What vectors are made of.
    type Room: Default;

    /// A copy of numbers.
    fn of(room: &Self::Room, numbers: &[Lanes<R>]) -> Self;

    /// Newton's update, NaN in lanes where it is no good one, from what a program has left: `rows`, then the Jacobian.
    fn update(rows: Self, numbers: &InRegisters<'_, R>, equations: &Solved<'_, R>) -> (Self, Lanes<R>);
}

/// What equations are solved by.
struct Solved<'a, R> {
    /// Where the entries of the Jacobian are.
    entries: &'a [u32],
    /// Which these are, if not all.
    sparse: Option<&'a Sparse>,
    /// Whether the rows are affine.
    are_linear: bool,
    /// In which units determinants are wanted.
    scales: [Lanes<R>; 2],
    /// Room for a matrix.
    matrix: &'a Cell<Vec<Lanes<R>>>,
}

/// Few unknowns, whose number is known where steps are compiled.
impl<R: Chosen, const M: usize> Unknowns<R> for [Lanes<R>; M] {
    type Room = ();

    #[inline(always)]
    fn of((): &(), numbers: &[Lanes<R>]) -> Self {
        numbers
            .first_chunk()
            .copied()
            .unwrap_or([Lanes::splat(f64::NAN); M])
    }

    #[inline(always)]
    fn update(rows: Self, numbers: &InRegisters<'_, R>, equations: &Solved<'_, R>) -> (Self, Lanes<R>) {
        let mut jacobian = [[Lanes::splat(0.0); M]; M];
        for (entry, &place) in jacobian.as_flattened_mut().iter_mut().zip(equations.entries) {
            *entry = numbers.at(place);
        }
        let (mut solution, determinants) = if equations.are_linear {
            Self::solve_scaled(&jacobian, &rows, &equations.scales)
        } else {
            Self::solve_lanes(&jacobian, &rows, &equations.scales)
        };
        for x in &mut solution {
            *x = -*x;
        }
        (solution, determinants)
    }
}

/// Any number of unknowns, in room that is kept.
struct Pooled<R, const SPARSE: bool> {
    numbers: Vec<Lanes<R>>,
    free: Rc<Free<R>>,
}

/// Vectors that are not used at the time.
struct Free<R>(Cell<Vec<Vec<Lanes<R>>>>);

impl<R> Default for Free<R> {
    fn default() -> Self {
        Self(Cell::default())
    }
}

impl<R: Copy, const SPARSE: bool> Pooled<R, SPARSE> {
    fn copy(free: &Rc<Free<R>>, numbers: &[Lanes<R>]) -> Self {
        let mut vectors = free.0.take();
        let mut vector = vectors.pop().unwrap_or_default();
        free.0.set(vectors);
        vector.clear();
        vector.extend_from_slice(numbers);
        Self {
            numbers: vector,
            free: Rc::clone(free),
        }
    }
}

impl<R: Copy, const SPARSE: bool> Clone for Pooled<R, SPARSE> {
    fn clone(&self) -> Self {
        Self::copy(&self.free, &self.numbers)
    }
}

impl<R, const SPARSE: bool> Drop for Pooled<R, SPARSE> {
    fn drop(&mut self) {
        let mut vectors = self.free.0.take();
        vectors.push(core::mem::take(&mut self.numbers));
        self.free.0.set(vectors);
    }
}

impl<R, const SPARSE: bool> AsRef<[Lanes<R>]> for Pooled<R, SPARSE> {
    #[inline(always)]
    fn as_ref(&self) -> &[Lanes<R>] {
        &self.numbers
    }
}

impl<R, const SPARSE: bool> AsMut<[Lanes<R>]> for Pooled<R, SPARSE> {
    #[inline(always)]
    fn as_mut(&mut self) -> &mut [Lanes<R>] {
        &mut self.numbers
    }
}

impl<R: Chosen> Unknowns<R> for Pooled<R, false> {
    type Room = Rc<Free<R>>;

    #[inline(always)]
    fn of(room: &Rc<Free<R>>, numbers: &[Lanes<R>]) -> Self {
        Self::copy(room, numbers)
    }

    #[inline(always)]
    fn update(mut rows: Self, numbers: &InRegisters<'_, R>, equations: &Solved<'_, R>) -> (Self, Lanes<R>) {
        let m = rows.numbers.len();
        let mut room = equations.matrix.take();
        room.resize(m * (m + 2), Lanes::splat(0.0));
        let (jacobian, beside) = room.split_at_mut(m * m);
        for (entry, &place) in jacobian.iter_mut().zip(equations.entries) {
            *entry = numbers.at(place);
        }
        let (x, scales) = (&mut rows.numbers, &equations.scales);
        let determinants = if equations.are_linear {
            slices::solve_scaled_lanes(jacobian, x, beside, scales)
        } else {
            slices::solve_lanes(jacobian, x, beside, scales)
        };
        for x in x {
            *x = -*x;
        }
        equations.matrix.set(room);
        (rows, determinants)
    }
}

impl Unknowns<f64x8> for Pooled<f64x8, true> {
    type Room = Rc<Free<f64x8>>;

    fn of(room: &Rc<Free<f64x8>>, numbers: &[Lanes]) -> Self {
        Self::copy(room, numbers)
    }

    fn update(rows: Self, numbers: &InRegisters<'_, f64x8>, equations: &Solved<'_, f64x8>) -> (Self, Lanes) {
        let Some(sparse) = equations.sparse else {
            return (rows, Lanes::splat(f64::NAN));
        };
        let mut determinants = Lanes::splat(if sparse.is_odd() { -1.0 } else { 1.0 });
        let mut scale = &equations.scales[0];
        let found = sparse.update(
            |entries| {
                for (entry, &place) in entries.iter_mut().zip(equations.entries) {
                    *entry = numbers.at(place);
                }
                rows
            },
            |pivot| {
                determinants = determinants * (pivot * *scale);
                scale = &equations.scales[1];
            },
        );
        (found.update, determinants)
    }
}

/// The steps in registers of one kind.
struct Steps<'k, R: Chosen, Z: Unknowns<R>> {
    /// What tells that the machine has them.
    token: R::Token,
    /// The system.
    system: &'k TapeKernel,
    /// What does not change.
    common: Common,
    /// The parameters.
    parameters: Vec<Eight>,
    /// What the programs compute in.
    numbers: Stretched,
    /// What the steps compute in beside it.
    room: Room<R, Z>,
}

/// What steps compute in. Vectors lie one after the other.
struct Room<R: Chosen, Z: Unknowns<R>> {
    /// What vectors of unknowns are made of.
    unknowns: Z::Room,
    /// The last nodes and the increments that led to them, as sums: the numbers, then what rounding took away.
    sums: Vec<Lanes<R>>,
    /// The same after the step that is being made.
    next: Vec<Lanes<R>>,
    /// The past solutions: their backward differences, then their sizes.
    past: Vec<Lanes<R>>,
    /// The natural sizes of the unknowns: the part of them that counts, then their inverse.
    natural: Vec<Lanes<R>>,
    /// Room for a matrix.
    matrix: Cell<Vec<Lanes<R>>>,
}

impl<'k, R: Chosen, Z: Unknowns<R>> Steps<'k, R, Z> {
    /// Steps with parameters.
    fn new(token: R::Token, system: &'k TapeKernel, common: &Common, values: &[&[f64]; LANES]) -> Self {
        let shape = Source::shape(system);
        let (n, m) = (shape.increments, shape.unknowns);
        let zeros = |count: usize| vec![Lanes::splat(0.0); count];
        let mut numbers = Stretched::new();
        if let Some(places) = numbers.places() {
            let stretch = &system.hot().stretch;
            stretch.each_constant(|place, value| places[place] = [value; LANES]);
        }
        let mut steps = Self {
            token,
            system,
            common: *common,
            parameters: vec![Eight::ZERO; shape.parameters.len()],
            numbers,
            room: Room {
                unknowns: Z::Room::default(),
                sums: zeros(4 * n),
                next: zeros(4 * n),
                past: zeros(Kept::VECTORS * m),
                natural: zeros(2 * m),
                matrix: Cell::default(),
            },
        };
        for (lane, values) in values.iter().enumerate() {
            steps.set_lane(lane, values);
        }
        steps.decide();
        steps
    }

    /// Gives one lane of the parameters values; those beyond the last are NaN.
    fn set_lane(&mut self, lane: usize, values: &[f64]) {
        for (place, parameter) in self.parameters.iter_mut().enumerate() {
            parameter.0[lane] = values.get(place).copied().unwrap_or(f64::NAN);
        }
    }

    /// Computes what the parameters decide.
    fn decide(&mut self) {
        let Hot {
            places, constants, ..
        } = self.system.hot();
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
struct Rows<'a, 'n, R: Chosen, Z: Unknowns<R>> {
    token: R::Token,
    system: &'a TapeKernel,
    shape: &'a Shape,
    numbers: &'a mut InRegisters<'n, R>,
    room: &'a Z::Room,
    /// The rows, then their Jacobian or its entries.
    program: &'a Straight,
    solved: Solved<'a, R>,
    /// The lanes whose past is too short to tell two roots apart by it.
    past_is_short: u32,
}

impl<R: Chosen, Z: Unknowns<R>> newton::Equations<R> for Rows<'_, '_, R, Z> {
    type Z = Z;

    const MAY_BE_LINEAR: bool = true;

    const MAY_BE_WATCHED: bool = true;

    const MAY_BE_SCALED: bool = true;

    #[inline(always)]
    fn are_linear(&self) -> bool {
        self.solved.are_linear
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
    fn update(&mut self, z: &Z) -> (Z, Lanes<R>) {
        let places = &self.system.hot().places;
        self.numbers.take(&places.z, z.as_ref());
        walk(self.token, self.program, self.system, self.numbers);
        let mut rows = z.clone();
        for (row, &place) in rows.as_mut().iter_mut().zip(self.program.places()) {
            *row = self.numbers.at(place);
        }
        Z::update(rows, self.numbers, &self.solved)
    }

    #[inline(always)]
    fn declared(&mut self, z: &Z, nearby: &Z) -> Mask<R> {
        let Hot { places, scales, .. } = self.system.hot();
        self.numbers.take(&places.z, z.as_ref());
        walk(self.token, scales, self.system, self.numbers);
        let mut here = Z::of(self.room, z.as_ref());
        for (here, scale) in here.as_mut().iter_mut().zip(self.numbers.results(scales)) {
            *here = scale;
        }
        self.numbers.take(&places.z, nearby.as_ref());
        walk(self.token, scales, self.system, self.numbers);
        let mut declared = Mask::splat(true);
        for (&here, there) in here.as_ref().iter().zip(self.numbers.results(scales)) {
            let change = (here - there).abs();
            declared = declared & change.below(Lanes::splat(NEARLY_THE_SAME) * here.abs());
        }
        declared
    }
}

/// Work for the registers: steps.
struct Making<'a, 'k, R: Chosen, Z: Unknowns<R>> {
    /// The steps.
    steps: &'a mut Steps<'k, R, Z>,
    /// What they depend on.
    kept: &'a mut Kept,
    /// Where the last node is told.
    told: &'a mut Told,
    /// Which are to be made.
    task: &'a Task,
}

impl<R: Chosen, Z: Unknowns<R>> InLanes for Making<'_, '_, R, Z> {
    type Output = Made;

    #[inline(always)]
    #[expect(clippy::too_many_lines, reason = "a step is read from top to bottom")]
    fn run(self) -> Made {
        let Self {
            steps,
            kept,
            told,
            task,
        } = self;
        let Steps {
            token,
            system,
            common,
            numbers,
            room,
            ..
        } = steps;
        let (token, system) = (*token, *system);
        let Some(numbers) = numbers.places() else {
            return Made::alone(task);
        };
        let numbers = &mut InRegisters::<R>::new(numbers);
        let (shape, hot) = (Source::shape(system), system.hot());
        let places = &hot.places;
        let (n, m) = (shape.increments, shape.unknowns);
        let sparse = system.sparse();
        let program = match sparse {
            Some(_) => &hot.entries,
            None => &hot.residual,
        };
        load(&mut room.sums, &kept.sums);
        load(&mut room.past, &kept.past);
        load(&mut room.natural, &kept.natural);
        let mut determinants: Determinants<R> = kept.determinants.moved();
        let (mut index, mut elsewhere) = (task.index, task.elsewhere);
        let mut lately = u32::MAX;
        loop {
            if lately != 0 {
                lately = short(task, index);
            }
            let t = if shape.depends_on_time {
                times(&common.clocks, index).into()
            } else {
                Lanes::splat(0.0)
            };
            let [guess, expected] = begin(token, system, numbers, room, t, kept);
            let mut rows = Rows::<R, Z> {
                token,
                system,
                shape,
                numbers,
                room: &room.unknowns,
                program,
                solved: Solved {
                    entries: program.places().get(m..).unwrap_or_default(),
                    sparse,
                    are_linear: shape.linear && !shape.jumps,
                    scales: determinants.scales,
                    matrix: &room.matrix,
                },
                past_is_short: lately,
            };
            let roots: Roots<Z, R> = newton::solve(
                &mut rows,
                guess.clone(),
                &expected,
                common.max_iterations,
                task.active,
            );
            numbers.take(&places.z, roots.z.as_ref());
            walk(token, &hot.second_difference, system, numbers);
            let finite = arrive(numbers.results(&hot.second_difference), room);
            let mut alone = task.active & (roots.left | elsewhere | !finite.bits());
            if shape.jumps && common.may_stick {
                // a flow by itself looks at what may come to rest
                alone |= task.active & !foresees(guess.as_ref(), roots.z.as_ref()).bits();
            }
            if m > 0 {
                alone |= task.active & determinants.ask(roots.determinants);
            }
            if shape.is_watched() {
                alone |= determinants.take(roots.determinants, task.active & !alone);
            }
            let is_told = index == task.last;
            if is_told {
                tell(token, system, numbers, &room.sums[..n], told);
                told.evaluations = roots.evaluations;
            }
            if alone == 0 {
                core::mem::swap(&mut room.sums, &mut room.next);
                push_past(&mut room.past, roots.z.as_ref(), size_after);
                determinants.push();
            }
            if alone != 0 || is_told {
                store(&mut kept.sums, &room.sums);
                store(&mut kept.past, &room.past);
                kept.determinants = determinants.moved();
                if alone != 0 {
                    let (to, z) = kept.found.split_at_mut(4 * n);
                    store(to, &room.next);
                    store(z, roots.z.as_ref());
                }
                return Made {
                    index,
                    alone,
                    told: is_told,
                };
            }
            index += 1;
            elsewhere = 0;
        }
    }
}

/// Takes a leg in; returns where the iteration of its step begins, and how large the unknowns are expected to be.
#[inline(always)]
fn begin<R: Chosen, Z: Unknowns<R>>(
    token: R::Token,
    system: &TapeKernel,
    numbers: &mut InRegisters<'_, R>,
    room: &Room<R, Z>,
    t: Lanes<R>,
    kept: &Kept,
) -> [Z; 2] {
    let Hot {
        places,
        known,
        unknown,
        ..
    } = system.hot();
    let shape = Source::shape(system);
    let (n, m) = (shape.increments, shape.unknowns);
    let (q, d) = (&room.sums[..n], &room.sums[2 * n..3 * n]);
    numbers.take_one(places.clock, t);
    numbers.take(&places.n, q);
    numbers.take(&places.d, d);
    walk(token, known, system, numbers);
    // multipliers are zero: nothing is written in their places
    numbers.take(&places.e, d);
    walk(token, unknown, system, numbers);
    let vector = |place: usize| &room.past[place * m..(place + 1) * m];
    let sizes = vector(Kept::VECTORS - 1);
    let mut expected = Z::of(&room.unknowns, sizes);
    for (size, increment) in expected.as_mut().iter_mut().zip(numbers.results(unknown)) {
        *size = size.larger(Lanes::splat(SECOND_DIFFERENCE) * increment.abs());
    }
    let (part, inverse) = room.natural.split_at(m);
    let natural = Natural {
        known: kept.known,
        part,
        inverse,
        level: kept.level.0.into(),
    };
    let expected = natural.raise(expected, sizes);
    let last = Z::of(&room.unknowns, vector(0));
    [extrapolate(&last, [1, 2, 3, 4, 5].map(vector)), expected]
}

/// Adds a second difference to the sums; the lanes where all nodes are numbers.
#[inline(always)]
fn arrive<R: Chosen, Z: Unknowns<R>>(e: impl Iterator<Item = Lanes<R>>, room: &mut Room<R, Z>) -> Mask<R> {
    let n = room.sums.len() / 4;
    let mut finite = Mask::<R>::splat(true);
    for (i, e) in e.enumerate().take(n) {
        let (sums, next) = (&room.sums, &mut room.next);
        let d = compensated::add((sums[2 * n + i], sums[3 * n + i]), e);
        let q = compensated::plus((sums[i], sums[n + i]), d);
        finite = finite & q.0.finite();
        (next[i], next[n + i], next[2 * n + i], next[3 * n + i]) = (q.0, q.1, d.0, d.1);
    }
    finite
}

/// Tells the middle node of a step, whose second difference was computed last.
#[inline(always)]
fn tell<R: Chosen>(
    token: R::Token,
    system: &TapeKernel,
    numbers: &mut InRegisters<'_, R>,
    q: &[Lanes<R>],
    told: &mut Told,
) {
    let Hot {
        places,
        second_difference,
        node,
        energy,
        ..
    } = system.hot();
    for (place, &from) in places.e.clone().zip(second_difference.places()) {
        let value = numbers.at(from);
        numbers.take_one(place, value);
    }
    walk(token, node, system, numbers);
    let n = q.len();
    let (motion, force) = told.vectors.split_at_mut(3 * n);
    let mut t = [Eight::ZERO];
    let mut results = numbers.results(node);
    for room in [&mut *motion, &mut t, force] {
        for (to, from) in room.iter_mut().zip(&mut results) {
            to.0 = from.into();
        }
    }
    drop(results);
    numbers.take_one(places.t, t[0].0.into());
    let at = motion[..2 * n].iter();
    for (place, value) in places.q.clone().chain(places.v.clone()).zip(at) {
        numbers.take_one(place, value.0.into());
    }
    walk(token, energy, system, numbers);
    let energy = numbers.results(energy).next();
    told.energy.0 = energy.unwrap_or(Lanes::splat(f64::NAN)).into();
    // the node is the one between the legs, whatever the maps say
    store(motion, q);
}

impl<R: Chosen, Z: Unknowns<R>> Engine for Steps<'_, R, Z> {
    fn steps(&mut self, kept: &mut Kept, told: &mut Told, task: &Task) -> Made {
        R::run(
            self.token,
            Making {
                steps: self,
                kept,
                told,
                task,
            },
        )
    }

    fn set_parameters(&mut self, lane: usize, values: &[f64]) {
        self.set_lane(lane, values);
        self.decide();
    }
}
