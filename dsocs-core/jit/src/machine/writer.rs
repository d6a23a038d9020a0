//! Translation of operations to Cranelift's instructions.

use std::collections::{HashMap, HashSet};
use std::ffi::c_void;

use cranelift_codegen::ir::condcodes::FloatCC;
use cranelift_codegen::ir::{
    AbiParam, InstBuilder, MemFlags, SigRef, Signature, StackSlotData, StackSlotKind, Type, Value, types,
};
use cranelift_codegen::isa::CallConv;
use cranelift_frontend::FunctionBuilder;

use super::code::{at_argument, without_argument};
use crate::{Operand, Operation, PIECE, Program};

/// The division of a program into pieces.
pub(super) struct Cut {
    /// The place among the stored values (the *home*) of each operation's result, if another piece reads it.
    homes: Vec<Option<u32>>,
    /// The number of homes.
    pub count: usize,
}

impl Cut {
    pub fn new(program: &Program) -> Self {
        let operations = &program.operations;
        // the last piece that reads each result
        let mut last: Vec<usize> = (0..operations.len()).map(|at| at / PIECE).collect();
        for (at, operation) in operations.iter().enumerate() {
            operation.each(|operand| {
                if let Operand::Result(of) = operand {
                    let last = &mut last[of as usize];
                    *last = (*last).max(at / PIECE);
                }
            });
        }
        let mut homes = vec![None; operations.len()];
        let (mut free, mut count): (Vec<u32>, u32) = (Vec::new(), 0);
        let mut ends: HashMap<usize, Vec<u32>> = HashMap::new();
        for (at, home) in homes.iter_mut().enumerate() {
            if at % PIECE == 0 {
                // a home is free after the last piece that reads it
                let before = (at / PIECE).checked_sub(1);
                free.extend(before.and_then(|before| ends.remove(&before)).unwrap_or_default());
            }
            if last[at] > at / PIECE {
                let own = free.pop().unwrap_or_else(|| {
                    count += 1;
                    count - 1
                });
                *home = Some(own);
                ends.entry(last[at]).or_default().push(own);
            }
        }
        Self {
            homes,
            count: count as usize,
        }
    }
}

/// Writes the instructions of a piece.
pub(super) struct Writer<'a> {
    pub builder: FunctionBuilder<'a>,
    program: &'a Program,
    cut: &'a Cut,
    pointer: Type,
    call_conv: CallConv,
    /// The first operation of the piece.
    begin: usize,
    /// The parameters of the function.
    numbers: Value,
    homes: Value,
    calls: Value,
    /// The results of this piece's operations so far.
    values: Vec<Value>,
    /// The signatures of called functions, by the types of their parameters.
    signatures: HashMap<Vec<Type>, SigRef>,
    /// The angles of which the piece asks for both the sine and the cosine: one call computes both.
    turned: HashSet<Operand>,
    /// The sine or, if `true`, the cosine of an angle, where a call for the other has computed it.
    other: HashMap<(Operand, bool), Value>,
}

extern "C" fn sine(angle: f64) -> f64 {
    angle.sin()
}

extern "C" fn cosine(angle: f64) -> f64 {
    angle.cos()
}

/// The sine; and the cosine, by the same call of the C library if it has one for both.
extern "C" fn sine_and_cosine(angle: f64, cosine: &mut f64) -> f64 {
    let (sine, other) = angle.sin_cos();
    *cosine = other;
    sine
}

impl<'a> Writer<'a> {
    pub fn new(
        mut builder: FunctionBuilder<'a>,
        program: &'a Program,
        cut: &'a Cut,
        (pointer, call_conv): (Type, CallConv),
        piece: usize,
    ) -> Self {
        let block = builder.create_block();
        builder.append_block_params_for_function_params(block);
        builder.switch_to_block(block);
        let parameter = |k: usize| builder.block_params(block)[k];
        let (numbers, homes, calls) = (parameter(0), parameter(1), parameter(2));
        Self {
            builder,
            program,
            cut,
            pointer,
            call_conv,
            begin: piece * PIECE,
            numbers,
            homes,
            calls,
            values: Vec::new(),
            signatures: HashMap::new(),
            turned: HashSet::new(),
            other: HashMap::new(),
        }
    }

    /// Writes the operations, and stores the results that are read elsewhere.
    pub fn write(&mut self) {
        let program = self.program;
        let end = (self.begin + PIECE).min(program.operations.len());
        let operations = &program.operations[self.begin..end];
        let sines = operations.iter().filter_map(|operation| match operation {
            Operation::Sin(a) => Some(*a),
            _ => None,
        });
        let sines: HashSet<Operand> = sines.collect();
        let cosines = operations.iter().filter_map(|operation| match operation {
            Operation::Cos(a) => Some(*a),
            _ => None,
        });
        self.turned = cosines.filter(|a| sines.contains(a)).collect();
        // the places to which the result of each operation is written
        let mut written: Vec<Vec<u32>> = vec![Vec::new(); operations.len()];
        for &(from, to) in &program.results {
            match from {
                Operand::Result(of) => {
                    let own = (of as usize).checked_sub(self.begin);
                    if let Some(written) = own.and_then(|own| written.get_mut(own)) {
                        written.push(to);
                    }
                }
                Operand::Place(_) if self.begin == 0 => {
                    let value = self.value(from);
                    self.store(self.numbers, to, value);
                }
                Operand::Place(_) => {}
            }
        }
        for ((at, operation), written) in (self.begin..).zip(operations).zip(written) {
            let value = self.operation(operation);
            self.values.push(value);
            for to in written {
                self.store(self.numbers, to, value);
            }
            if let Some(home) = self.cut.homes[at] {
                self.store(self.homes, home, value);
            }
        }
        self.builder.ins().return_(&[]);
    }

    /// Writes a number to a place.
    fn store(&mut self, to: Value, place: u32, value: Value) {
        let address = self.address(to, place);
        self.builder
            .ins()
            .store(MemFlags::trusted(), value, address.0, address.1);
    }

    /// Loads the number at a place. A number that is read twice is loaded twice: the load is part of the operation, and leaves a register
    /// free.
    fn load(&mut self, from: Value, place: u32) -> Value {
        let address = self.address(from, place);
        self.builder
            .ins()
            .load(types::F64, MemFlags::trusted(), address.0, address.1)
    }

    /// The address of a place: a pointer and an offset.
    fn address(&mut self, base: Value, place: u32) -> (Value, i32) {
        let offset = i64::from(place) * 8;
        match i32::try_from(offset) {
            Ok(offset) => (base, offset),
            Err(_) => (self.builder.ins().iadd_imm(base, offset), 0),
        }
    }

    /// The value of an operand.
    fn value(&mut self, operand: Operand) -> Value {
        match operand {
            Operand::Place(place) => self.load(self.numbers, place),
            Operand::Result(of) => match (of as usize).checked_sub(self.begin) {
                Some(own) => self.values[own],
                // every result that another piece reads has a home
                None => self.load(self.homes, self.cut.homes[of as usize].unwrap_or(0)),
            },
        }
    }

    /// Writes an operation, and returns its result.
    fn operation(&mut self, operation: &Operation) -> Value {
        match *operation {
            Operation::Neg(a) => {
                let a = self.value(a);
                self.builder.ins().fneg(a)
            }
            Operation::Recip(a) => {
                let (one, a) = (self.builder.ins().f64const(1.0), self.value(a));
                self.builder.ins().fdiv(one, a)
            }
            Operation::Sqrt(a) => {
                let a = self.value(a);
                self.builder.ins().sqrt(a)
            }
            Operation::Abs(a) => {
                let a = self.value(a);
                self.builder.ins().fabs(a)
            }
            Operation::Signum(a) => {
                let (one, a) = (self.builder.ins().f64const(1.0), self.value(a));
                let sign = self.builder.ins().fcopysign(one, a);
                let is_nan = self.builder.ins().fcmp(FloatCC::Unordered, a, a);
                self.builder.ins().select(is_nan, a, sign)
            }
            Operation::Sin(a) => self.turn(a, false),
            Operation::Cos(a) => self.turn(a, true),
            Operation::Powi(a, power) => {
                let a = self.value(a);
                self.power(a, power)
            }
            Operation::Add(a, b) => {
                let (a, b) = (self.value(a), self.value(b));
                self.builder.ins().fadd(a, b)
            }
            Operation::Sub(a, b) => {
                let (a, b) = (self.value(a), self.value(b));
                self.builder.ins().fsub(a, b)
            }
            Operation::Mul(a, b) => {
                let first = self.value(a);
                let second = if a == b { first } else { self.value(b) };
                self.builder.ins().fmul(first, second)
            }
            Operation::Div(a, b) => {
                let (a, b) = (self.value(a), self.value(b));
                self.builder.ins().fdiv(a, b)
            }
            Operation::Less(parts) => self.select(FloatCC::LessThan, parts),
            Operation::LessOrEqual(parts) => self.select(FloatCC::LessThanOrEqual, parts),
            Operation::Function(function, a) => {
                let a = self.value(a);
                self.call(function as *const c_void, &[a])
            }
            Operation::Function2(function, a, b) => {
                let arguments = [self.value(a), self.value(b)];
                self.call(function as *const c_void, &arguments)
            }
            Operation::Call(which, a) => {
                let which = self.builder.ins().iconst(types::I32, i64::from(which));
                let arguments = [self.calls, which, self.value(a)];
                self.call(at_argument as *const c_void, &arguments)
            }
            Operation::Datum(which) => {
                let which = self.builder.ins().iconst(types::I32, i64::from(which));
                self.call(without_argument as *const c_void, &[self.calls, which])
            }
        }
    }

    /// The sine or the cosine of an angle.
    fn turn(&mut self, a: Operand, is_cosine: bool) -> Value {
        if let Some(value) = self.other.remove(&(a, is_cosine)) {
            return value;
        }
        let angle = self.value(a);
        if !self.turned.contains(&a) {
            let function: extern "C" fn(f64) -> f64 = if is_cosine { cosine } else { sine };
            return self.call(function as *const c_void, &[angle]);
        }
        let slot = StackSlotData::new(StackSlotKind::ExplicitSlot, 8, 3);
        let slot = self.builder.create_sized_stack_slot(slot);
        let room = self.builder.ins().stack_addr(self.pointer, slot, 0);
        let sine = self.call(sine_and_cosine as *const c_void, &[angle, room]);
        let cosine = self.builder.ins().stack_load(types::F64, slot, 0);
        let [own, other] = if is_cosine { [cosine, sine] } else { [sine, cosine] };
        self.other.insert((a, !is_cosine), other);
        own
    }

    /// The choice between two numbers; the last one if a compared number is NaN.
    fn select(&mut self, comparison: FloatCC, parts: [Operand; 4]) -> Value {
        let [a, b, c, d] = parts.map(|part| self.value(part));
        let holds = self.builder.ins().fcmp(comparison, a, b);
        self.builder.ins().select(holds, c, d)
    }

    /// A whole power, by the products of `f64::powi` in the same order. (The first product is by 1.)
    fn power(&mut self, a: Value, power: i32) -> Value {
        let (mut square, mut rest) = (a, power.unsigned_abs());
        let mut product = None;
        loop {
            if rest & 1 == 1 {
                product = Some(match product {
                    Some(product) => self.builder.ins().fmul(product, square),
                    None => square,
                });
            }
            rest >>= 1;
            if rest == 0 {
                break;
            }
            square = self.builder.ins().fmul(square, square);
        }
        let one = self.builder.ins().f64const(1.0);
        let product = product.unwrap_or(one);
        if power < 0 {
            self.builder.ins().fdiv(one, product)
        } else {
            product
        }
    }

    /// A call of a function that returns a number.
    fn call(&mut self, function: *const c_void, arguments: &[Value]) -> Value {
        let parameters = arguments.iter();
        let parameters = parameters.map(|&argument| self.builder.func.dfg.value_type(argument));
        let parameters: Vec<Type> = parameters.collect();
        let known = self.signatures.get(&parameters).copied();
        let signature = known.unwrap_or_else(|| {
            let mut signature = Signature::new(self.call_conv);
            let types = parameters.iter().map(|&of| AbiParam::new(of));
            signature.params.extend(types);
            signature.returns.push(AbiParam::new(types::F64));
            let signature = self.builder.import_signature(signature);
            self.signatures.insert(parameters, signature);
            signature
        });
        // an address is as wide as a pointer
        let address = (function.addr() as u64).cast_signed();
        let callee = self.builder.ins().iconst(self.pointer, address);
        let call = self.builder.ins().call_indirect(signature, callee, arguments);
        self.builder.inst_results(call)[0]
    }
}
