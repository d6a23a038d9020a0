//! Reads the operations from the bytes of a tape.

use core::ops::Range;

use super::{Leaf, Part, SEGMENTS, Segment, VERSION};

/// An operation of a segment; operands are places of operations before it.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Op {
    Number(f64),
    Leaf(Leaf),
    /// A result of another segment.
    Stored(Segment, usize),
    Neg(usize),
    Recip(usize),
    Powi(usize, i32),
    Function(Function, usize),
    Binary(Binary, [usize; 2]),
    Select(Comparison, [usize; 4]),
    Call(usize, Vec<usize>),
}

/// Operations on two numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Powf,
    Atan2,
}

/// Comparisons.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Comparison {
    Less,
    LessOrEqual,
}

/// Functions of one number, in the order of their bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Function {
    Sqrt,
    Cbrt,
    Exp,
    ExpM1,
    Ln,
    Ln1p,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    Abs,
    Signum,
}

/// The byte of the first function.
const FIRST_FUNCTION: u8 = 32;

/// The functions, by their bytes.
const FUNCTIONS: [Function; 20] = [
    Function::Sqrt,
    Function::Cbrt,
    Function::Exp,
    Function::ExpM1,
    Function::Ln,
    Function::Ln1p,
    Function::Sin,
    Function::Cos,
    Function::Tan,
    Function::Asin,
    Function::Acos,
    Function::Atan,
    Function::Sinh,
    Function::Cosh,
    Function::Tanh,
    Function::Asinh,
    Function::Acosh,
    Function::Atanh,
    Function::Abs,
    Function::Signum,
];

/// The kinds of leaves, by their bytes.
const LEAVES: [fn(usize) -> Leaf; 15] = [
    Leaf::Q,
    Leaf::V,
    Leaf::A,
    Leaf::N,
    Leaf::D,
    Leaf::E,
    Leaf::Z,
    Leaf::Lambda,
    |_| Leaf::H,
    Leaf::Parameter,
    |_| Leaf::T,
    |_| Leaf::Clock,
    Leaf::P,
    Leaf::J,
    Leaf::Side,
];

impl Op {
    /// The operands, by their places.
    pub(super) fn parts(&self) -> &[usize] {
        match self {
            Self::Number(_) | Self::Leaf(_) | Self::Stored(..) => &[],
            Self::Neg(a) | Self::Recip(a) | Self::Powi(a, _) | Self::Function(_, a) => {
                core::slice::from_ref(a)
            }
            Self::Binary(_, parts) => parts,
            Self::Select(_, parts) => parts,
            Self::Call(_, parts) => parts,
        }
    }

    /// The operands, mutable.
    pub(super) fn parts_mut(&mut self) -> &mut [usize] {
        match self {
            Self::Number(_) | Self::Leaf(_) | Self::Stored(..) => &mut [],
            Self::Neg(a) | Self::Recip(a) | Self::Powi(a, _) | Self::Function(_, a) => {
                core::slice::from_mut(a)
            }
            Self::Binary(_, parts) => parts,
            Self::Select(_, parts) => parts,
            Self::Call(_, parts) => parts,
        }
    }
}

/// A segment.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Body {
    pub(super) ops: Vec<Op>,
    pub(super) results: Vec<usize>,
    /// The number of results in the head.
    head: usize,
}

impl Body {
    /// The results of a part.
    pub(super) fn part(&self, part: Part) -> &[usize] {
        let range: Range<usize> = match part {
            Part::All => 0..self.results.len(),
            Part::Head => 0..self.head,
            Part::Tail => self.head..self.results.len(),
        };
        self.results.get(range).unwrap_or_default()
    }
}

/// Largest number of results of a segment, so that malformed bytes cannot exhaust the memory.
const MOST_RESULTS: usize = 1 << 24;

/// The segments of a tape; `None` if it is malformed.
pub(super) fn read(bytes: &[u8]) -> Option<Vec<Body>> {
    let mut reader = Reader { rest: bytes };
    if reader.byte()? != VERSION {
        return None;
    }
    let mut bodies: Vec<Body> = Vec::with_capacity(SEGMENTS);
    for _ in 0..SEGMENTS {
        let length = reader.number()?;
        let (own, rest) = reader.rest.split_at_checked(length)?;
        reader.rest = rest;
        let body = body(&mut Reader { rest: own }, &bodies)?;
        bodies.push(body);
    }
    reader.rest.is_empty().then_some(bodies)
}

/// Reads a segment; `before` are the segments before it.
fn body(reader: &mut Reader<'_>, before: &[Body]) -> Option<Body> {
    let count = reader.number()?;
    // an operation takes at least one byte
    let mut ops = Vec::with_capacity(count.min(reader.rest.len()));
    for place in 0..count {
        ops.push(reader.op(place, before)?);
    }
    let count = reader.number()?;
    let head = reader.number()?;
    if count > MOST_RESULTS {
        return None;
    }
    let mut results = Vec::with_capacity(count.min(reader.rest.len()));
    while results.len() < count {
        let place = reader.place(ops.len() + 1)?;
        if place < ops.len() {
            results.push(place);
            continue;
        }
        let (last, more) = (*results.last()?, reader.number()?);
        if more == 0 || more > count - results.len() {
            return None;
        }
        results.resize(results.len() + more, last);
    }
    let complete = reader.rest.is_empty() && head <= results.len();
    complete.then_some(Body { ops, results, head })
}

/// The bytes that are still to be read.
pub(crate) struct Reader<'b> {
    rest: &'b [u8],
}

impl<'b> Reader<'b> {
    /// A reader at the beginning of some bytes.
    pub(crate) fn new(bytes: &'b [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Whether all bytes have been read.
    pub(crate) fn is_at_end(&self) -> bool {
        self.rest.is_empty()
    }

    /// A text, preceded by its length.
    pub(crate) fn text(&mut self) -> Option<&'b str> {
        let length = self.number()?;
        let (text, rest) = self.rest.split_at_checked(length)?;
        self.rest = rest;
        core::str::from_utf8(text).ok()
    }

    pub(crate) fn byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.rest.split_first()?;
        self.rest = rest;
        Some(byte)
    }

    pub(crate) fn bytes<const K: usize>(&mut self) -> Option<[u8; K]> {
        let (&bytes, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(bytes)
    }

    /// A whole number.
    pub(crate) fn number(&mut self) -> Option<usize> {
        let mut number: u32 = 0;
        for shift in (0..32).step_by(7) {
            let byte = self.byte()?;
            let part = u32::from(byte & 0x7f);
            // no bit may be lost
            if part.leading_zeros() < shift {
                return None;
            }
            number |= part << shift;
            if byte & 0x80 == 0 {
                return usize::try_from(number).ok();
            }
        }
        None
    }

    /// The place of one of the first `count` operations.
    fn place(&mut self, count: usize) -> Option<usize> {
        self.number().filter(|&place| place < count)
    }

    /// The operation at a place.
    fn op(&mut self, place: usize, before: &[Body]) -> Option<Op> {
        let binary = |this: &mut Self, op: Binary| {
            let parts = [this.place(place)?, this.place(place)?];
            Some(Op::Binary(op, parts))
        };
        let op = match self.byte()? {
            0 => Op::Number(f64::from_le_bytes(self.bytes()?)),
            1 => {
                let kind = LEAVES.get(usize::from(self.byte()?))?;
                Op::Leaf(kind(self.number()?))
            }
            2 => self.stored(Segment::Constants, before)?,
            3 => self.stored(Segment::Known, before)?,
            4 => Op::Neg(self.place(place)?),
            5 => binary(self, Binary::Add)?,
            6 => binary(self, Binary::Sub)?,
            7 => binary(self, Binary::Mul)?,
            8 => binary(self, Binary::Div)?,
            9 => Op::Recip(self.place(place)?),
            10 => Op::Powi(self.place(place)?, i32::from_le_bytes(self.bytes()?)),
            11 => binary(self, Binary::Powf)?,
            12 => binary(self, Binary::Atan2)?,
            code @ (13 | 14) => {
                let mut parts = [0; 4];
                for part in &mut parts {
                    *part = self.place(place)?;
                }
                let comparison = if code == 13 {
                    Comparison::Less
                } else {
                    Comparison::LessOrEqual
                };
                Op::Select(comparison, parts)
            }
            15 => {
                let which = self.number()?;
                let count = self.number()?;
                let mut arguments = Vec::with_capacity(count.min(self.rest.len()));
                for _ in 0..count {
                    arguments.push(self.place(place)?);
                }
                Op::Call(which, arguments)
            }
            code => {
                let function = FUNCTIONS.get(usize::from(code.checked_sub(FIRST_FUNCTION)?))?;
                Op::Function(*function, self.place(place)?)
            }
        };
        Some(op)
    }

    /// A result of an earlier segment.
    fn stored(&mut self, segment: Segment, before: &[Body]) -> Option<Op> {
        let place = self.number()?;
        let body = before.get(segment as usize)?;
        (place < body.results.len()).then_some(Op::Stored(segment, place))
    }
}
