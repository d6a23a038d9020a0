//! Links the operations of a segment to a program: with the results that it reads of other segments, without
//! unused operations, and with few registers.

use super::read::{Binary, Body, Comparison, Function, Op};
use super::{Leaf, Part, Segment};

/// The place of a number during the evaluation.
pub(super) type Register = u32;

/// One step of a program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instruction {
    /// The register of the result.
    pub(super) to: Register,
    pub(super) kind: Kind,
}

/// An operation; `L` identifies a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind<L = Leaf> {
    Number(f64),
    Leaf(L),
    Neg(Register),
    Recip(Register),
    Powi(Register, i32),
    Function(Function, Register),
    Binary(Binary, [Register; 2]),
    Select(Comparison, [Register; 4]),
    /// The number of the function, and the first place and the count of its arguments among those of all
    /// calls.
    Call {
        which: u32,
        first: u32,
        count: u32,
    },
}

/// A sequence of operations on registers without branches, and the registers of its results.
#[derive(Clone, Debug, Default)]
pub struct Program {
    pub(super) instructions: Vec<Instruction>,
    /// The arguments of all calls, one after another.
    pub(super) arguments: Vec<Register>,
    pub(super) results: Vec<Register>,
    /// The number of registers.
    pub(super) registers: usize,
}

impl Program {
    /// The number of operations, numbers and leaves among them.
    #[must_use]
    pub fn len(&self) -> usize {
        self.instructions.len()
    }

    /// Whether there are no operations.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.instructions.is_empty()
    }
}

/// The program of a part of a segment; empty if there is no such segment.
pub(super) fn link(bodies: &[Body], segment: Segment, part: Part) -> Program {
    let Some(own) = bodies.get(segment as usize) else {
        return Program::default();
    };
    let (ops, places) = gathered(bodies, segment, &[]);
    let results: Vec<usize> = own.part(part).iter().map(|&result| places[result]).collect();
    allocate(&ops, &results)
}

/// The program of some results of a segment, by their places, which reads the results of `given` segments as
/// leaves.
pub(super) fn later(bodies: &[Body], segment: Segment, results: &[usize], given: &[Segment]) -> Program {
    let Some(own) = bodies.get(segment as usize) else {
        return Program::default();
    };
    let (ops, places) = gathered(bodies, segment, given);
    let results = results.iter().filter_map(|&result| own.results.get(result));
    let results: Vec<usize> = results.map(|&result| places[result]).collect();
    allocate(&ops, &results)
}

/// The operations of the segments that one may read, except for the `given` ones, and its own; and the place
/// of each own operation.
pub(super) fn gathered(bodies: &[Body], segment: Segment, given: &[Segment]) -> (Vec<Op>, Vec<usize>) {
    let mut ops: Vec<Op> = Vec::new();
    // the places of the results of a segment
    let mut stored: Vec<Vec<usize>> = Vec::new();
    let mut places: Vec<usize> = Vec::new();
    let before = [Segment::Constants, Segment::Known].map(|before| before as usize);
    let before = before.into_iter().filter(|&before| before < segment as usize);
    for body in before.chain([segment as usize]).map(|place| &bodies[place]) {
        places.clear();
        for op in &body.ops {
            // a stored result is read as the operation itself
            let mut op = match *op {
                Op::Stored(of, result) if given.contains(&of) => Op::Leaf(match of {
                    Segment::Constants => Leaf::Constant(result),
                    _ => Leaf::Known(result),
                }),
                Op::Stored(of, result) => {
                    places.push(stored[of as usize][result]);
                    continue;
                }
                ref op => op.clone(),
            };
            for part in op.parts_mut() {
                *part = places[*part];
            }
            places.push(ops.len());
            ops.push(op);
        }
        stored.push(body.results.iter().map(|&result| places[result]).collect());
    }
    (ops, places)
}

/// The program of the operations that some results need. A register is reused after its number has been read
/// for the last time.
fn allocate(ops: &[Op], results: &[usize]) -> Program {
    let mut last_use: Vec<Option<usize>> = vec![None; ops.len()];
    for &result in results {
        last_use[result] = Some(usize::MAX);
    }
    for place in (0..ops.len()).rev() {
        if last_use[place].is_some() {
            for &part in ops[place].parts() {
                last_use[part] = last_use[part].max(Some(place));
            }
        }
    }
    let mut program = Program::default();
    let mut registers: Vec<Register> = vec![0; ops.len()];
    let mut free: Vec<Register> = Vec::new();
    let mut count: Register = 0;
    for (place, op) in ops.iter().enumerate() {
        if last_use[place].is_none() {
            continue;
        }
        let kind = kind(op, &registers, &mut program.arguments);
        // an operand that is read here for the last time leaves its register to the result
        for (k, &part) in op.parts().iter().enumerate() {
            if last_use[part] == Some(place) && !op.parts()[..k].contains(&part) {
                free.push(registers[part]);
            }
        }
        let to = free.pop().unwrap_or_else(|| {
            count += 1;
            count - 1
        });
        registers[place] = to;
        program.instructions.push(Instruction { to, kind });
    }
    program.results = results.iter().map(|&result| registers[result]).collect();
    program.registers = count as usize;
    program
}

/// An operation on registers.
fn kind(op: &Op, registers: &[Register], arguments: &mut Vec<Register>) -> Kind {
    let of = |part: &usize| registers[*part];
    match op {
        Op::Number(value) => Kind::Number(*value),
        Op::Leaf(leaf) => Kind::Leaf(*leaf),
        // not reached: replaced before
        Op::Stored(..) => Kind::Number(f64::NAN),
        Op::Neg(a) => Kind::Neg(of(a)),
        Op::Recip(a) => Kind::Recip(of(a)),
        Op::Powi(a, power) => Kind::Powi(of(a), *power),
        Op::Function(function, a) => Kind::Function(*function, of(a)),
        Op::Binary(binary, parts) => Kind::Binary(*binary, [of(&parts[0]), of(&parts[1])]),
        Op::Select(comparison, parts) => Kind::Select(*comparison, [0, 1, 2, 3].map(|k| of(&parts[k]))),
        Op::Call(which, parts) => {
            let first = arguments.len();
            arguments.extend(parts.iter().map(of));
            Kind::Call {
                which: saturated(*which),
                first: saturated(first),
                count: saturated(parts.len()),
            }
        }
    }
}

/// A count as `u32`; no tape is as large as this bound.
fn saturated(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
