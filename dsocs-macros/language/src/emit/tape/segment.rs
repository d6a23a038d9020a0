//! Operations of a [`Program`] as bytes of a tape, in the format of `dsocs_core`.

use super::calls::{Calls, TapeCall};
use crate::graph::{Comparison, Leaf, Param};
use crate::hash::HashMap;
use crate::program::schedule::Product;
use crate::program::{Given, Op, Program, Stored, Value};

/// The byte of the first function of one argument.
const FIRST_FUNCTION: u8 = 32;

/// A segment of a tape.
#[derive(Default)]
pub(crate) struct Segment {
    /// The operations as bytes; `count` is their number.
    operations: Vec<u8>,
    count: usize,
    /// The indices of the results; the first `head` of them are the head.
    results: Vec<usize>,
    head: usize,
}

/// The shortest run of equal results, such as zeros of a large Jacobian, that is written as one and its
/// length.
const SHORTEST_RUN: usize = 16;

impl Segment {
    /// The bytes of the segment.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        number(&mut bytes, self.count);
        bytes.extend(&self.operations);
        number(&mut bytes, self.results.len());
        number(&mut bytes, self.head);
        for run in self.results.chunk_by(|one, next| one == next) {
            if run.len() < SHORTEST_RUN {
                for &result in run {
                    number(&mut bytes, result);
                }
            } else {
                number(&mut bytes, run[0]);
                number(&mut bytes, self.count);
                number(&mut bytes, run.len() - 1);
            }
        }
        bytes
    }
}

/// A whole number in LEB128.
pub(crate) fn number(bytes: &mut Vec<u8>, mut number: usize) {
    loop {
        let part = u8::try_from(number & 0x7f).unwrap_or_default();
        number >>= 7;
        if number == 0 {
            bytes.push(part);
            return;
        }
        bytes.push(part | 0x80);
    }
}

/// The writer of a segment: its bytes, and the index of every operation written.
struct Writer<'p, 'g> {
    program: &'p Program<'g>,
    bytes: Vec<u8>,
    count: usize,
    places: HashMap<Value, usize>,
}

impl Writer<'_, '_> {
    /// Writes an operation with its operands.
    fn write(&mut self, value: Value, code: u8, operands: &[Value]) {
        let places: Vec<usize> = operands.iter().map(|operand| self.place(*operand)).collect();
        self.bytes.push(code);
        for place in places {
            number(&mut self.bytes, place);
        }
        self.places.insert(value, self.count);
        self.count += 1;
    }

    /// The index of a value written before, or of a number, which is written at its first use.
    fn place(&mut self, value: Value) -> usize {
        if let Some(&place) = self.places.get(&value) {
            return place;
        }
        if let Op::Constant(bits) = self.program.op(value) {
            self.bytes.push(0);
            self.bytes.extend(bits.get().to_le_bytes());
        }
        self.places.insert(value, self.count);
        self.count += 1;
        self.count - 1
    }

    /// Writes an operation without operands, with its index.
    fn load(&mut self, value: Value, code: &[u8], index: usize) {
        self.bytes.extend(code);
        number(&mut self.bytes, index);
        self.places.insert(value, self.count);
        self.count += 1;
    }
}

impl Program<'_> {
    /// The segment that computes `outputs`, the first `head` of which are its head. The operations are those
    /// of [`Program::code`], in the same order, after the operations and results of `before`.
    pub(crate) fn segment(
        &self,
        before: Segment,
        outputs: &[Value],
        head: usize,
        given: &Given,
        calls: &mut Calls,
    ) -> Segment {
        let schedule = self.schedule(outputs, given);
        let mut writer = Writer {
            program: self,
            bytes: before.operations,
            count: before.count,
            places: HashMap::default(),
        };
        for &value in &schedule.values {
            match given.get(&value) {
                Some(Stored::Constants(place)) => writer.load(value, &[2], *place),
                Some(Stored::Known(place)) => writer.load(value, &[3], *place),
                None => match self.op(value) {
                    Op::Mul(a, b) => match schedule.product(self, *a, *b) {
                        Product::Of(a, b) => writer.write(value, 7, &[a, b]),
                        Product::Quotient(a, b) => writer.write(value, 8, &[a, b]),
                    },
                    op => self.operation_bytes(value, op, &mut writer, calls),
                },
            }
        }
        let mut results = before.results;
        for &output in outputs {
            let place = writer.place(output);
            results.push(place);
        }
        Segment {
            operations: writer.bytes,
            count: writer.count,
            results,
            head,
        }
    }

    /// Writes an operation that is not a product.
    fn operation_bytes(&self, value: Value, op: &Op, writer: &mut Writer<'_, '_>, calls: &mut Calls) {
        match op {
            // written where it is read
            Op::Constant(_) => {}
            Op::Leaf(leaf) => {
                let (kind, index) = leaf_bytes(*leaf);
                writer.load(value, &[1, kind], index);
            }
            Op::Param(param) => match self.graph.read_param(*param) {
                Param::Number(place) => writer.load(value, &[1, 9], place),
                Param::Expression(_) => {
                    writer.load(value, &[15], calls.place(TapeCall::Expression(*param)));
                    // no arguments
                    writer.bytes.push(0);
                }
            },
            Op::Neg(a) => writer.write(value, 4, &[*a]),
            Op::Add(a, b) => writer.write(value, 5, &[*a, *b]),
            Op::Sub(a, b) => writer.write(value, 6, &[*a, *b]),
            Op::Mul(a, b) => writer.write(value, 7, &[*a, *b]),
            Op::Recip(a) => writer.write(value, 9, &[*a]),
            Op::Powi(a, n) => {
                writer.write(value, 10, &[*a]);
                writer.bytes.extend(n.to_le_bytes());
            }
            Op::Powf(a, b) => writer.write(value, 11, &[*a, *b]),
            Op::Atan2(a, b) => writer.write(value, 12, &[*a, *b]),
            Op::Select(Comparison::Lt, parts) => writer.write(value, 13, parts),
            Op::Select(Comparison::Le, parts) => writer.write(value, 14, parts),
            Op::Unary(function, a) => writer.write(value, FIRST_FUNCTION + *function as u8, &[*a]),
            Op::Call { callee, args, wrt } => {
                let which = calls.place(TapeCall::Function {
                    callee: *callee,
                    count: args.len(),
                    wrt: wrt.clone(),
                });
                let places: Vec<usize> = args.iter().map(|arg| writer.place(*arg)).collect();
                writer.load(value, &[15], which);
                number(&mut writer.bytes, places.len());
                for place in places {
                    number(&mut writer.bytes, place);
                }
            }
        }
    }
}

/// The kind and the index of a leaf.
fn leaf_bytes(leaf: Leaf) -> (u8, usize) {
    match leaf {
        Leaf::Q(i) => (0, i),
        Leaf::V(i) => (1, i),
        Leaf::A(i) => (2, i),
        Leaf::N(i) => (3, i),
        Leaf::D(i) => (4, i),
        Leaf::E(i) => (5, i),
        Leaf::Z(i) => (6, i),
        Leaf::Lambda(i) => (7, i),
        Leaf::H => (8, 0),
        Leaf::T => (10, 0),
        Leaf::Clock => (11, 0),
        Leaf::P(i) => (12, i),
        Leaf::J(i) => (13, i),
        Leaf::Side(i) => (14, i),
        // the nodes of a map and their times are replaced before code is written; the format has no such kind
        Leaf::T0 | Leaf::T1 | Leaf::T2 => (u8::MAX, 0),
        Leaf::X0(i) | Leaf::X1(i) | Leaf::X2(i) | Leaf::Chord(i) => (u8::MAX, i),
    }
}
