//! Programs over one stretch of doubles: what steps are made with where nothing was compiled.
//!
//! Every number has a place in it: what is handed to a program, constants, what is in between. An operation reads its operands where they are, so
//! leaves and constants cost nothing. Operations of one kind that do not need each other stand together, and which kind it is, is asked once for all
//! of them. Every number comes from the same operation on the same numbers as in the [`Program`], so the bits are the same.

use super::evaluate::function;
use super::link::{Kind, Program};
use super::read::{Binary, Comparison, Function};
use super::{Leaf, TapeCall};

/// Where a number is.
type Place = u32;

/// Places below this bound are those of a fixed array: that a place lies inside need not be asked then.
const FIXED: usize = 1 << 16;

/// A program whose operands are places.
#[derive(Clone, Debug, Default)]
pub(crate) struct Straight {
    batches: Vec<Batch>,
    /// Where the result of each operation goes, and its first two operands; the fourth place makes the size a power of two.
    operations: Vec<[Place; 4]>,
    /// The other operands of operations that have four: three each, at the index that stands in the place of the second.
    more: Vec<[Place; 3]>,
    /// Where the results are in the end.
    results: Vec<Place>,
}

/// Operations of one kind.
#[derive(Clone, Copy, Debug)]
struct Batch {
    what: What,
    count: u32,
}

/// What is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Neg,
    Recip,
    /// The power that is met most.
    Square,
    Powi(i32),
    Function(Function),
    Binary(Binary),
    /// With the three last of its operands apart.
    Select(Comparison),
    /// Of one number.
    Call(u32),
    /// Without arguments.
    Datum(u32),
}

/// An operand of an operation.
#[derive(Clone, Copy)]
enum Operand {
    /// A number that is there before.
    Place(Place),
    /// The result of another operation.
    Result(usize),
}

/// An operation before it has a place.
struct Node {
    what: What,
    operands: Vec<Operand>,
}

/// How the stretch is shared out among programs: what is handed to them comes first, then constants, then the numbers in between.
#[derive(Debug, Default)]
pub(crate) struct Stretch {
    /// Where constants begin.
    first_constant: usize,
    constants: Vec<f64>,
    /// How many numbers there are.
    length: usize,
}

impl Stretch {
    /// A stretch in which so many numbers are handed to some programs. The first is not handed: it is NaN.
    pub fn new<'p>(given: usize, programs: impl IntoIterator<Item = &'p Program>) -> Self {
        let mut constants: Vec<f64> = Vec::new();
        for instruction in programs.into_iter().flat_map(|program| &program.instructions) {
            if let Kind::Number(value) = instruction.kind
                && index_of(&constants, value).is_none()
            {
                constants.push(value);
            }
        }
        Self {
            first_constant: given,
            length: given + constants.len(),
            constants,
        }
    }

    /// Makes room for all programs, and writes their constants.
    #[inline]
    pub fn prepare(&self, numbers: &mut Vec<f64>) {
        if numbers.len() < self.length.max(FIXED) {
            *numbers = vec![0.0; self.length.max(FIXED)];
        }
        numbers[0] = f64::NAN;
        let from = self.first_constant;
        numbers[from..from + self.constants.len()].copy_from_slice(&self.constants);
    }

    /// A program, where `leaf` says where a leaf is: at the place 0 where it is not known.
    pub fn straighten(&mut self, program: &Program, leaf: &dyn Fn(Leaf) -> usize) -> Straight {
        let mut nodes: Vec<Node> = Vec::new();
        // what a register holds at the time
        let mut held: Vec<Operand> = vec![Operand::Place(0); program.registers];
        for instruction in &program.instructions {
            let at = |register: &u32| held[*register as usize];
            let operand = match &instruction.kind {
                Kind::Number(value) => {
                    let index = index_of(&self.constants, *value);
                    Operand::Place(index.map_or(0, |index| place(self.first_constant + index)))
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
        let results: Vec<Operand> = results.map(|&register| held[register as usize]).collect();
        self.share_out(&nodes, &results)
    }

    /// Puts operations in batches, and gives each number a place, which is used again after the number has been read for the last time.
    fn share_out(&mut self, nodes: &[Node], results: &[Operand]) -> Straight {
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
            let to = free.pop().unwrap_or_else(|| {
                next += 1;
                place(next - 1)
            });
            places[index] = to;
            straight.operations.push(match operands[..] {
                [a] => [to, a, a, 0],
                [a, b] => [to, a, b, 0],
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
            .map(|(what, batch)| Batch {
                what: *what,
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
        straight
    }
}

/// The operation of an instruction.
fn node(kind: &Kind, arguments: &[u32], at: &dyn Fn(&u32) -> Operand) -> Node {
    let (what, operands) = match kind {
        // these are no operations
        Kind::Number(_) | Kind::Leaf(_) => (What::Neg, vec![Operand::Place(0)]),
        Kind::Neg(a) => (What::Neg, vec![at(a)]),
        Kind::Recip(a) => (What::Recip, vec![at(a)]),
        Kind::Powi(a, 2) => (What::Square, vec![at(a)]),
        Kind::Powi(a, power) => (What::Powi(*power), vec![at(a)]),
        Kind::Function(name, a) => (What::Function(*name), vec![at(a)]),
        Kind::Binary(binary, parts) => (What::Binary(*binary), parts.iter().map(at).collect()),
        Kind::Select(comparison, parts) => (What::Select(*comparison), parts.iter().map(at).collect()),
        Kind::Call { which, first, count } => {
            let arguments = arguments.get(*first as usize..).unwrap_or_default();
            match arguments.first().filter(|_| *count > 0) {
                Some(argument) => (What::Call(*which), vec![at(argument)]),
                None => (What::Datum(*which), vec![]),
            }
        }
    };
    Node { what, operands }
}

/// Operations in batches of one kind, each after those that it reads: always the largest batch that can be made.
fn batches(nodes: &[Node]) -> Vec<(What, Vec<usize>)> {
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
    let mut ready: Vec<(What, Vec<usize>)> = Vec::new();
    let enter = |ready: &mut Vec<(What, Vec<usize>)>, index: usize| {
        let what = nodes[index].what;
        match ready.iter_mut().find(|(of, _)| *of == what) {
            Some((_, batch)) => batch.push(index),
            None => ready.push((what, vec![index])),
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

/// Where a constant is among others.
fn index_of(constants: &[f64], value: f64) -> Option<usize> {
    let same = |known: &f64| known.to_bits() == value.to_bits();
    constants.iter().position(same)
}

/// A place, of which no system has as many as this bound.
fn place(index: usize) -> Place {
    Place::try_from(index).unwrap_or(0)
}

/// What numbers stand in.
trait Numbers {
    fn at(&self, place: Place) -> f64;

    fn set(&mut self, place: Place, value: f64);
}

impl Numbers for [f64; FIXED] {
    #[inline(always)]
    #[allow(clippy::inline_always, clippy::cast_possible_truncation)] // part of every operation; all places are small
    fn at(&self, place: Place) -> f64 {
        self[usize::from(place as u16)]
    }

    #[inline(always)]
    #[allow(clippy::inline_always, clippy::cast_possible_truncation)] // as above
    fn set(&mut self, place: Place, value: f64) {
        self[usize::from(place as u16)] = value;
    }
}

impl Numbers for [f64] {
    fn at(&self, place: Place) -> f64 {
        self[place as usize]
    }

    fn set(&mut self, place: Place, value: f64) {
        self[place as usize] = value;
    }
}

impl Straight {
    /// Evaluates the program; its results are then where [`Straight::results`] finds them.
    pub fn run(&self, stretch: &Stretch, calls: &[TapeCall], numbers: &mut [f64]) {
        match numbers.first_chunk_mut::<FIXED>() {
            Some(fixed) if stretch.length <= FIXED => self.run_on(fixed, calls),
            _ => self.run_on(numbers, calls),
        }
    }

    fn run_on<N: Numbers + ?Sized>(&self, numbers: &mut N, calls: &[TapeCall]) {
        let mut rest = &self.operations[..];
        for Batch { what, count } in &self.batches {
            let Some((batch, later)) = rest.split_at_checked(*count as usize) else {
                return;
            };
            rest = later;
            match *what {
                What::Binary(Binary::Add) => two(numbers, batch, |a, b| a + b),
                What::Binary(Binary::Sub) => two(numbers, batch, |a, b| a - b),
                What::Binary(Binary::Mul) => two(numbers, batch, |a, b| a * b),
                What::Binary(Binary::Div) => two(numbers, batch, |a, b| a / b),
                What::Binary(Binary::Powf) => two(numbers, batch, f64::powf),
                What::Binary(Binary::Atan2) => two(numbers, batch, f64::atan2),
                What::Neg => one(numbers, batch, |a| -a),
                What::Recip => one(numbers, batch, f64::recip),
                What::Square => one(numbers, batch, |a| a * a),
                What::Powi(power) => one(numbers, batch, |a| a.powi(power)),
                What::Function(name) => one(numbers, batch, |a| function(name, a)),
                What::Select(comparison) => {
                    for &[to, a, more, _] in batch {
                        let [b, c, d] = self.more[more as usize];
                        let (a, b) = (numbers.at(a), numbers.at(b));
                        let chosen = match comparison {
                            Comparison::Less => a < b,
                            Comparison::LessOrEqual => a <= b,
                        };
                        numbers.set(to, numbers.at(if chosen { c } else { d }));
                    }
                }
                What::Call(which) => one(numbers, batch, |a| {
                    let call = calls.get(which as usize);
                    call.map_or(f64::NAN, |call| call.value(Some(a)))
                }),
                What::Datum(which) => one(numbers, batch, |_| {
                    let call = calls.get(which as usize);
                    call.map_or(f64::NAN, |call| call.value(None))
                }),
            }
        }
    }

    /// Puts the results one after the other from a place on, where none of them is before.
    #[inline]
    pub fn put(&self, numbers: &mut [f64], from: usize) {
        for (to, &result) in (from..).zip(&self.results) {
            numbers[to] = numbers[result as usize];
        }
    }

    /// The results, one after the other.
    #[inline]
    pub fn results<'a>(&'a self, numbers: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.results.iter().map(|&place| numbers[place as usize])
    }
}

/// A function of one number, for all operations of a batch.
#[inline(always)]
#[allow(clippy::inline_always)] // a loop for each function
fn one<N: Numbers + ?Sized>(numbers: &mut N, batch: &[[Place; 4]], function: impl Fn(f64) -> f64) {
    for &[to, a, ..] in batch {
        numbers.set(to, function(numbers.at(a)));
    }
}

/// A function of two numbers, for all operations of a batch.
#[inline(always)]
#[allow(clippy::inline_always)] // a loop for each function
fn two<N: Numbers + ?Sized>(numbers: &mut N, batch: &[[Place; 4]], function: impl Fn(f64, f64) -> f64) {
    for &[to, a, b, _] in batch {
        numbers.set(to, function(numbers.at(a), numbers.at(b)));
    }
}
