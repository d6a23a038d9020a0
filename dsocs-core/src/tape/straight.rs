//! Straight-line programs over one array of numbers, for the steps of systems that are not compiled.
//!
//! A number is a double, or several lanes for as many motions ([`Numbers`]); the programs are the same.
//!
//! Every number has a fixed place in the array: inputs, constants, intermediate results. An operation reads
//! its operands in place, so leaves and constants cost nothing. Two sums or products of which one is read by
//! the other alone are one operation ([`OperationKind::Pair`]). Independent operations of one kind stand together in a
//! batch, so that the kind is decoded once for all of them. Every number comes from the same operation on the
//! same numbers as in the [`Program`], so the bits are the same.

use std::cell::Cell;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use super::evaluate::function;
use super::link::{Kind, Program};
use super::read::{Binary, Comparison, Function};
use super::{Leaf, TapeCall, TapeCalls};
use crate::number::scalar::Scalar;

/// The place of a number.
pub(crate) type Place = u32;

/// Size of a fixed array: places below it need no bounds check.
pub(crate) const FIXED: usize = 1 << 16;

/// A program whose operands are places in the array.
#[derive(Clone, Debug, Default)]
pub(crate) struct Straight {
    pub(super) batches: Vec<Batch>,
    /// The place of each operation's result, and of its first two operands; padded to four numbers.
    pub(super) operations: Vec<[Place; 4]>,
    /// The other three operands of operations with four; the second place of such an operation is the index
    /// here.
    pub(super) more: Vec<[Place; 3]>,
    /// The places of the results.
    pub(super) results: Vec<Place>,
    /// Copies at the end, from and to, that bring the results to their places.
    pub(super) moves: Vec<[Place; 2]>,
    /// The program as machine code, once it was compiled.
    #[cfg(feature = "jit")]
    pub(super) code: std::sync::OnceLock<dsocs_jit::Code>,
}

/// Operations of one kind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch {
    pub(super) kind: OperationKind,
    pub(super) count: u32,
}

/// The kind of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OperationKind {
    Neg,
    Recip,
    /// The most frequent power.
    Square,
    Powi(i32),
    Function(Function),
    Binary(Binary),
    /// An operation on two numbers, then one on its rounded result and a third number.
    Pair(First, Second),
    /// A selection by a comparison; the last three of its four operands are stored apart.
    Select(Comparison),
    /// A function of one number.
    Call(u32),
    /// A function without arguments.
    Datum(u32),
}

/// The first operation of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum First {
    Add,
    Sub,
    Mul,
}

/// The second operation of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Second {
    Add,
    /// The third number minus the result.
    From,
    /// The result minus the third number.
    Sub,
    Mul,
}

/// An operand of an operation.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Operand {
    /// A number that the program does not compute.
    Place(Place),
    /// The result of another operation.
    Result(usize),
}

/// An operation before it has a place.
struct Node {
    kind: OperationKind,
    operands: Vec<Operand>,
}

/// The layout of the array that several programs share: inputs first, then constants, then intermediate
/// results.
#[derive(Debug, Default)]
pub(crate) struct MemoryLayout {
    /// The number of this layout, unique in the process.
    number: u64,
    /// The first place of the constants.
    first_constant: usize,
    constants: Vec<f64>,
    /// The place of each constant, by its bits.
    places: HashMap<u64, Place>,
    /// The number of places.
    length: usize,
}

/// The numbers of several programs, and the layout whose constants stand among them.
#[derive(Debug)]
pub(crate) struct ProgramMemory {
    numbers: Vec<f64>,
    /// The number of the layout; 0 if there is none.
    of: u64,
}

impl ProgramMemory {
    /// No numbers.
    pub const EMPTY: Self = Self {
        numbers: Vec::new(),
        of: 0,
    };
}

impl MemoryLayout {
    /// The layout of some programs with `given` inputs. The first place belongs to no input: it is NaN.
    pub fn new<'p>(given: usize, programs: impl IntoIterator<Item = &'p Program>) -> Self {
        // 0 stands for no layout
        static COUNT: AtomicU64 = AtomicU64::new(1);
        let (mut constants, mut places) = (Vec::new(), HashMap::new());
        for instruction in programs.into_iter().flat_map(|program| &program.instructions) {
            if let Kind::Number(value) = instruction.kind {
                places.entry(value.to_bits()).or_insert_with(|| {
                    constants.push(value);
                    place(given + constants.len() - 1)
                });
            }
        }
        Self {
            number: COUNT.fetch_add(1, Ordering::Relaxed),
            first_constant: given,
            length: given + constants.len(),
            constants,
            places,
        }
    }

    /// The number of places.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Allocates for all programs, and writes their constants unless they stand there already.
    #[inline]
    pub fn prepare<'n>(&self, memory: &'n mut ProgramMemory) -> &'n mut [f64] {
        let ProgramMemory { numbers, of } = memory;
        if *of != self.number {
            if numbers.len() < self.length.max(FIXED) {
                *numbers = vec![0.0; self.length.max(FIXED)];
            }
            self.each_constant(|place, value| numbers[place] = value);
            *of = self.number;
        }
        numbers
    }

    /// Calls `visit` with the place and the value of each number that programs never write: the first place,
    /// and the constants.
    pub fn each_constant(&self, mut visit: impl FnMut(usize, f64)) {
        visit(0, f64::NAN);
        for (index, &value) in self.constants.iter().enumerate() {
            visit(self.first_constant + index, value);
        }
    }

    /// Compiles a program to operations on places. `leaf` gives the place of a leaf, 0 for an unknown one. If
    /// `into` is given, the results stand one after the other from this place on; the program must not read
    /// there.
    pub fn straighten(
        &mut self,
        program: &Program,
        leaf: &dyn Fn(Leaf) -> usize,
        into: Option<usize>,
    ) -> Straight {
        let mut nodes: Vec<Node> = Vec::new();
        // the current content of each register
        let mut held: Vec<Operand> = vec![Operand::Place(0); program.registers];
        for instruction in &program.instructions {
            let at = |register: &u32| held[*register as usize];
            let operand = match &instruction.kind {
                Kind::Number(value) => {
                    let constant = self.places.get(&value.to_bits());
                    Operand::Place(constant.copied().unwrap_or(0))
                }
                Kind::Leaf(which) => Operand::Place(place(leaf(*which))),
                kind => {
                    nodes.push(node(kind, &program.arguments, &at));
                    Operand::Result(nodes.len() - 1)
                }
            };
            held[instruction.to as usize] = operand;
        }
        let results = program.results.iter();
        let mut results: Vec<Operand> = results.map(|&register| held[register as usize]).collect();
        let nodes = paired(nodes, &mut results);
        self.share_out(&nodes, &results, into)
    }

    /// Sorts operations into batches, and gives each number a place, which is reused after the number has
    /// been read for the last time.
    fn share_out(&mut self, nodes: &[Node], results: &[Operand], into: Option<usize>) -> Straight {
        let batches = batches(nodes);
        let order: Vec<usize> = batches
            .iter()
            .flat_map(|(_, batch)| batch.iter().copied())
            .collect();
        let mut last_use = vec![0; nodes.len()];
        for (time, &index) in order.iter().enumerate() {
            for operand in &nodes[index].operands {
                if let Operand::Result(of) = operand {
                    last_use[*of] = time;
                }
            }
        }
        for result in results {
            if let Operand::Result(of) = result {
                last_use[*of] = usize::MAX;
            }
        }
        let mut own: Vec<Option<Place>> = vec![None; nodes.len()];
        for (index, result) in results.iter().enumerate() {
            if let (Some(into), Operand::Result(of)) = (into, result) {
                own[*of].get_or_insert(place(into + index));
            }
        }
        let from = self.first_constant + self.constants.len();
        let mut straight = Straight::default();
        let (mut places, mut free, mut next): (Vec<Place>, Vec<Place>, _) =
            (vec![0; nodes.len()], vec![], from);
        for (time, &index) in order.iter().enumerate() {
            let at = |operand: &Operand| match operand {
                Operand::Place(place) => *place,
                Operand::Result(of) => places[*of],
            };
            let operands: Vec<Place> = nodes[index].operands.iter().map(at).collect();
            for (k, operand) in nodes[index].operands.iter().enumerate() {
                if let Operand::Result(of) = operand
                    && last_use[*of] == time
                    && !operands[..k].contains(&places[*of])
                {
                    free.push(places[*of]);
                }
            }
            let to = own[index].or_else(|| free.pop()).unwrap_or_else(|| {
                next += 1;
                place(next - 1)
            });
            places[index] = to;
            straight.operations.push(match operands[..] {
                [a] => [to, a, a, 0],
                [a, b] => [to, a, b, 0],
                [a, b, c] => [to, a, b, c],
                [a, b, c, d] => {
                    straight.more.push([b, c, d]);
                    [to, a, place(straight.more.len() - 1), 0]
                }
                _ => [to, 0, 0, 0],
            });
        }
        self.length = self.length.max(next);
        straight.batches = batches
            .iter()
            .map(|(kind, batch)| Batch {
                kind: *kind,
                count: place(batch.len()),
            })
            .collect();
        straight.results = results
            .iter()
            .map(|result| match result {
                Operand::Place(place) => *place,
                Operand::Result(of) => places[*of],
            })
            .collect();
        if let Some(into) = into {
            let results = straight.results.iter_mut().zip(into..);
            for (result, to) in results.map(|(result, to)| (result, place(to))) {
                if *result != to {
                    straight.moves.push([*result, to]);
                }
                *result = to;
            }
        }
        straight
    }
}

/// The operation of an instruction.
fn node(kind: &Kind, arguments: &[u32], at: &dyn Fn(&u32) -> Operand) -> Node {
    let (kind, operands) = match kind {
        // not operations
        Kind::Number(_) | Kind::Leaf(_) => (OperationKind::Neg, vec![Operand::Place(0)]),
        Kind::Neg(a) => (OperationKind::Neg, vec![at(a)]),
        Kind::Recip(a) => (OperationKind::Recip, vec![at(a)]),
        Kind::Powi(a, 2) => (OperationKind::Square, vec![at(a)]),
        Kind::Powi(a, power) => (OperationKind::Powi(*power), vec![at(a)]),
        Kind::Function(name, a) => (OperationKind::Function(*name), vec![at(a)]),
        Kind::Binary(binary, parts) => (OperationKind::Binary(*binary), parts.iter().map(at).collect()),
        Kind::Select(comparison, parts) => {
            (OperationKind::Select(*comparison), parts.iter().map(at).collect())
        }
        Kind::Call { which, first, count } => {
            let arguments = arguments.get(*first as usize..).unwrap_or_default();
            match arguments.first().filter(|_| *count > 0) {
                Some(argument) => (OperationKind::Call(*which), vec![at(argument)]),
                None => (OperationKind::Datum(*which), vec![]),
            }
        }
    };
    Node { kind, operands }
}

/// Joins two sums or products of which one is read by the other alone to one operation.
fn paired(mut nodes: Vec<Node>, results: &mut [Operand]) -> Vec<Node> {
    let mut reads = vec![0_usize; nodes.len()];
    let operands = nodes.iter().flat_map(|node| &node.operands);
    for operand in operands.chain(&*results) {
        if let Operand::Result(of) = operand {
            reads[*of] += 1;
        }
    }
    let mut is_part = vec![false; nodes.len()];
    for index in 0..nodes.len() {
        // a square reads its operand twice
        let Some((second, [a, b])) = simple(&nodes[index]).filter(|(_, [a, b])| a != b) else {
            continue;
        };
        let parts = [(a, b, false), (b, a, true)].into_iter();
        let mut parts = parts.filter_map(|(part, third, is_last)| match part {
            Operand::Result(of) if reads[of] == 1 => Some((of, simple(&nodes[of])?, third, is_last)),
            _ => None,
        });
        let Some((of, (first, [a, b]), third, is_last)) = parts.next() else {
            continue;
        };
        let second = match second {
            First::Add => Second::Add,
            First::Sub if is_last => Second::From,
            First::Sub => Second::Sub,
            First::Mul => Second::Mul,
        };
        is_part[of] = true;
        nodes[index] = Node {
            kind: OperationKind::Pair(first, second),
            operands: vec![a, b, third],
        };
    }
    let mut count = 0;
    let numbers: Vec<usize> = is_part
        .iter()
        .map(|&is_part| {
            count += usize::from(!is_part);
            count.saturating_sub(1)
        })
        .collect();
    let operands = nodes.iter_mut().flat_map(|node| &mut node.operands);
    for operand in operands.chain(results) {
        if let Operand::Result(of) = operand {
            *of = numbers[*of];
        }
    }
    let nodes = nodes.into_iter().zip(is_part);
    nodes
        .filter_map(|(node, is_part)| (!is_part).then_some(node))
        .collect()
}

/// The node as a sum, a difference or a product; `None` if it is another operation.
fn simple(node: &Node) -> Option<(First, [Operand; 2])> {
    let first = match node.kind {
        OperationKind::Binary(Binary::Add) => First::Add,
        OperationKind::Binary(Binary::Sub) => First::Sub,
        OperationKind::Binary(Binary::Mul) | OperationKind::Square => First::Mul,
        _ => return None,
    };
    match node.operands[..] {
        [a] => Some((first, [a, a])),
        [a, b] => Some((first, [a, b])),
        _ => None,
    }
}

/// Sorts operations into batches of one kind, each after those that it reads: always the largest batch that
/// is possible.
fn batches(nodes: &[Node]) -> Vec<(OperationKind, Vec<usize>)> {
    let mut readers: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    let mut waits_for = vec![0_usize; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        for operand in &node.operands {
            if let Operand::Result(of) = operand {
                readers[*of].push(index);
                waits_for[index] += 1;
            }
        }
    }
    let mut ready: Vec<(OperationKind, Vec<usize>)> = Vec::new();
    let enter = |ready: &mut Vec<(OperationKind, Vec<usize>)>, index: usize| {
        let kind = nodes[index].kind;
        match ready.iter_mut().find(|(of, _)| *of == kind) {
            Some((_, batch)) => batch.push(index),
            None => ready.push((kind, vec![index])),
        }
    };
    for index in (0..nodes.len()).filter(|&index| waits_for[index] == 0) {
        enter(&mut ready, index);
    }
    let mut batches = Vec::new();
    while let Some((largest, _)) = ready.iter().enumerate().max_by_key(|(_, (_, batch))| batch.len()) {
        let batch = ready.swap_remove(largest);
        for &index in &batch.1 {
            for &reader in &readers[index] {
                waits_for[reader] -= 1;
                if waits_for[reader] == 0 {
                    enter(&mut ready, reader);
                }
            }
        }
        batches.push(batch);
    }
    batches
}

/// An index as a place; no system has as many as this bound.
pub(super) fn place(index: usize) -> Place {
    Place::try_from(index).unwrap_or(0)
}

/// An array of numbers on which programs run.
pub(crate) trait Numbers {
    /// A double, or several lanes.
    type Number: Scalar;

    fn at(&self, place: Place) -> Self::Number;

    fn set(&mut self, place: Place, value: Self::Number);
}

impl Numbers for &[Cell<f64>; FIXED] {
    type Number = f64;

    #[inline(always)]
    #[allow(clippy::inline_always, clippy::cast_possible_truncation)] // part of every operation; all places are small
    fn at(&self, place: Place) -> f64 {
        self[usize::from(place as u16)].get()
    }

    #[inline(always)]
    #[allow(clippy::inline_always, clippy::cast_possible_truncation)] // as above
    fn set(&mut self, place: Place, value: f64) {
        self[usize::from(place as u16)].set(value);
    }
}

impl Numbers for &[Cell<f64>] {
    type Number = f64;

    fn at(&self, place: Place) -> f64 {
        self[place as usize].get()
    }

    fn set(&mut self, place: Place, value: f64) {
        self[place as usize].set(value);
    }
}

impl Straight {
    /// The program with the numbers that it is evaluated on, and with what it calls.
    #[inline]
    pub fn on<'r>(
        &'r self,
        layout: &MemoryLayout,
        calls: &'r TapeCalls,
        numbers: &'r [Cell<f64>],
    ) -> Ready<'r> {
        let program = (!self.is_empty()).then_some(self);
        Ready {
            program,
            are_few: layout.length <= FIXED,
            calls,
            numbers,
            #[cfg(feature = "jit")]
            code: program.and_then(|program| program.code.get()?.on(numbers, calls).ok()),
        }
    }

    /// Evaluates the program on numbers of any kind. Inlined into its caller, which may be compiled for the
    /// machine's own instructions.
    #[inline(always)]
    #[allow(clippy::inline_always)] // compiled for the machine's own instructions
    pub fn run_on<N: Numbers>(&self, calls: &[TapeCall], numbers: &mut N) {
        let mut rest = &self.operations[..];
        for Batch { kind, count } in &self.batches {
            let Some((batch, later)) = rest.split_at_checked(*count as usize) else {
                return;
            };
            rest = later;
            match *kind {
                OperationKind::Binary(Binary::Add) => two(numbers, batch, |a, b| a + b),
                OperationKind::Binary(Binary::Sub) => two(numbers, batch, |a, b| a - b),
                OperationKind::Binary(Binary::Mul) => two(numbers, batch, |a, b| a * b),
                OperationKind::Binary(Binary::Div) => two(numbers, batch, |a, b| a / b),
                OperationKind::Binary(Binary::Powf) => two(numbers, batch, Scalar::powf),
                OperationKind::Binary(Binary::Atan2) => two(numbers, batch, Scalar::atan2),
                OperationKind::Pair(First::Add, second) => pair(numbers, batch, second, |a, b| a + b),
                OperationKind::Pair(First::Sub, second) => pair(numbers, batch, second, |a, b| a - b),
                OperationKind::Pair(First::Mul, second) => pair(numbers, batch, second, |a, b| a * b),
                OperationKind::Neg => one(numbers, batch, |a| -a),
                OperationKind::Recip => one(numbers, batch, Scalar::recip),
                OperationKind::Square => one(numbers, batch, |a| a * a),
                OperationKind::Powi(power) => one(numbers, batch, |a| a.powi(power)),
                OperationKind::Function(name) => of_function(numbers, batch, name),
                OperationKind::Select(comparison) => {
                    for &[to, a, more, _] in batch {
                        let [b, c, d] = self.more[more as usize].map(|place| numbers.at(place));
                        let a = numbers.at(a);
                        let chosen = match comparison {
                            Comparison::Less => Scalar::select_lt(a, b, c, d),
                            Comparison::LessOrEqual => Scalar::select_le(a, b, c, d),
                        };
                        numbers.set(to, chosen);
                    }
                }
                OperationKind::Call(which) => called(numbers, batch, calls.get(which as usize), true),
                OperationKind::Datum(which) => called(numbers, batch, calls.get(which as usize), false),
            }
        }
        for &[from, to] in &self.moves {
            numbers.set(to, numbers.at(from));
        }
    }

    /// The results, one after the other.
    #[inline]
    pub fn results<'a>(&'a self, numbers: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.results.iter().map(|&place| numbers[place as usize])
    }

    /// Whether there are no operations and no copies.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.batches.is_empty() && self.moves.is_empty()
    }

    /// The places of the results.
    #[inline]
    pub fn places(&self) -> &[Place] {
        &self.results
    }
}

/// A program that is ready to be evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ready<'r> {
    /// `None` if it is empty.
    program: Option<&'r Straight>,
    /// Whether all places are below [`FIXED`].
    are_few: bool,
    calls: &'r TapeCalls,
    numbers: &'r [Cell<f64>],
    /// Its machine code, if there is any.
    #[cfg(feature = "jit")]
    code: Option<dsocs_jit::Ready<'r>>,
}

impl Ready<'_> {
    /// Evaluates the program; [`Straight::results`] then gives the results.
    #[inline(always)]
    #[allow(clippy::inline_always)] // part of every step
    pub fn run(&self) {
        #[cfg(feature = "jit")]
        if let Some(code) = &self.code {
            return code.run();
        }
        if let Some(program) = self.program {
            self.walk(program);
        }
    }

    /// Evaluates the program by the interpreter.
    #[inline(never)]
    fn walk(&self, program: &Straight) {
        let (TapeCalls(calls), mut numbers) = (self.calls, self.numbers);
        match numbers.first_chunk::<FIXED>() {
            Some(mut fixed) if self.are_few => program.run_on(calls, &mut fixed),
            _ => program.run_on(calls, &mut numbers),
        }
    }
}

/// A function of one number, for all operations of a batch.
#[inline(always)]
#[allow(clippy::inline_always)] // a loop for each function
fn one<N: Numbers>(numbers: &mut N, batch: &[[Place; 4]], function: impl Fn(N::Number) -> N::Number) {
    for &[to, a, ..] in batch {
        numbers.set(to, function(numbers.at(a)));
    }
}

/// A function of two numbers, for all operations of a batch.
#[inline(always)]
#[allow(clippy::inline_always)] // a loop for each function
fn two<N: Numbers>(
    numbers: &mut N,
    batch: &[[Place; 4]],
    function: impl Fn(N::Number, N::Number) -> N::Number,
) {
    for &[to, a, b, _] in batch {
        numbers.set(to, function(numbers.at(a), numbers.at(b)));
    }
}

/// A function of two numbers, and then another of its result and a third number, for all operations of a batch.
#[inline(always)]
#[allow(clippy::inline_always)] // a loop for each pair
fn pair<N: Numbers>(
    numbers: &mut N,
    batch: &[[Place; 4]],
    second: Second,
    first: impl Fn(N::Number, N::Number) -> N::Number,
) {
    match second {
        Second::Add => three(numbers, batch, |a, b, c| first(a, b) + c),
        Second::From => three(numbers, batch, |a, b, c| c - first(a, b)),
        Second::Sub => three(numbers, batch, |a, b, c| first(a, b) - c),
        Second::Mul => three(numbers, batch, |a, b, c| first(a, b) * c),
    }
}

/// A function of three numbers, for all operations of a batch.
#[inline(always)]
#[allow(clippy::inline_always)] // a loop for each function
fn three<N: Numbers>(
    numbers: &mut N,
    batch: &[[Place; 4]],
    function: impl Fn(N::Number, N::Number, N::Number) -> N::Number,
) {
    for &[to, a, b, c] in batch {
        numbers.set(to, function(numbers.at(a), numbers.at(b), numbers.at(c)));
    }
}

/// A function that has a name, for all operations of a batch.
#[inline(always)]
#[allow(clippy::inline_always)] // as above
fn of_function<N: Numbers>(numbers: &mut N, batch: &[[Place; 4]], name: Function) {
    match name {
        Function::Sqrt => one(numbers, batch, Scalar::sqrt),
        Function::Exp => one(numbers, batch, Scalar::exp),
        Function::ExpM1 => one(numbers, batch, Scalar::exp_m1),
        Function::Sin => one(numbers, batch, Scalar::sin),
        Function::Cos => one(numbers, batch, Scalar::cos),
        Function::Tanh => one(numbers, batch, Scalar::tanh),
        Function::Abs => one(numbers, batch, Scalar::abs),
        // no lanes have vector code for these functions: one loop calls them all
        _ => one(numbers, batch, |a| {
            let [value] = Scalar::from_lanes(|lane| [function(name, a.lane(lane))]);
            value
        }),
    }
}

/// A call, of one number or without arguments, for all operations of a batch.
#[inline(always)]
#[allow(clippy::inline_always)] // as above
fn called<N: Numbers>(numbers: &mut N, batch: &[[Place; 4]], call: Option<&TapeCall>, has_argument: bool) {
    for &[to, a, ..] in batch {
        let a = numbers.at(a);
        let [value] = Scalar::from_lanes(|lane| {
            let argument = has_argument.then(|| a.lane(lane));
            [call.map_or(f64::NAN, |call| call.value(argument))]
        });
        numbers.set(to, value);
    }
}
