//! Programs of steps as machine code.
//!
//! The operations of a [`Straight`] program are compiled one by one, so the bits are those of its
//! interpreter.

use std::collections::HashMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use dsocs_jit::{Calls, Compiler, JitError, Operand, Operation, Program};

use super::TapeCalls;
use super::evaluate::function;
use super::read::{Binary, Comparison, Function};
use super::straight::{Batch, First, OperationKind, Place, Second, Straight, place};

/// Number of steps that are interpreted before the programs are compiled. Compiling takes as long as two to
/// four thousand interpreted steps, for a pendulum as for a chain. So a short run does not wait for code that
/// it hardly uses, and a run takes at most about three times as long as if its length had been known.
const BEFORE: u64 = 2000;

/// Decides when the programs of a system become machine code.
#[derive(Debug, Default)]
pub(crate) struct Tier {
    /// Number of steps that were requested so far.
    steps: AtomicU64,
    /// The result of the compilation, once it was tried.
    made: OnceLock<Result<(), JitError>>,
    /// Whether the programs are never compiled.
    never: bool,
}

impl Tier {
    /// A tier that never compiles.
    pub fn never() -> Self {
        Self {
            never: true,
            ..Self::default()
        }
    }

    /// Number of steps to interpret before compiling, out of `count` more; `None` if nothing is to be
    /// compiled yet or any more.
    #[inline]
    pub fn steps_before(&self, count: u64) -> Option<u64> {
        if self.never || self.made.get().is_some() {
            return None;
        }
        let before = self.steps.fetch_add(count.min(BEFORE), Ordering::Relaxed);
        let left = BEFORE.saturating_sub(before);
        (left < count).then_some(left)
    }

    /// Compiles some programs, once. If it fails, they stay interpreted.
    pub fn compile(&self, programs: &[&Straight]) -> Result<(), JitError> {
        let made = self.made.get_or_init(|| {
            let translated = programs.iter().map(|program| translated(program));
            let translated = translated.collect::<Result<Vec<_>, _>>()?;
            let codes = Compiler::new()?.compile(&translated)?;
            for (program, code) in programs.iter().zip(codes) {
                // set here alone, once
                let _ = program.code.set(code);
            }
            Ok(())
        });
        made.clone()
    }
}

impl Calls for TapeCalls {
    fn call(&self, which: u32, argument: Option<f64>) -> f64 {
        let call = self.0.get(which as usize);
        call.map_or(f64::NAN, |call| call.value(argument))
    }
}

/// The operations of a program, each of which has a number of its own.
#[derive(Default)]
struct Translation {
    operations: Vec<Operation>,
    /// The operation whose result stands at a place; none for an input of the program.
    held: HashMap<Place, u32>,
}

impl Translation {
    /// The current content of a place.
    fn at(&self, place: Place) -> Operand {
        let held = self.held.get(&place);
        held.map_or(Operand::Place(place), |&of| Operand::Result(of))
    }

    /// Adds an operation.
    fn push(&mut self, operation: Operation) -> Operand {
        self.operations.push(operation);
        Operand::Result(place(self.operations.len() - 1))
    }

    /// Adds an operation of a batch.
    fn add(&mut self, kind: OperationKind, [to, a, b, c]: [Place; 4], more: &[[Place; 3]]) {
        let (first, second) = (self.at(a), self.at(b));
        let result = match kind {
            OperationKind::Neg => self.push(Operation::Neg(first)),
            OperationKind::Recip => self.push(Operation::Recip(first)),
            OperationKind::Square => self.push(Operation::Mul(first, first)),
            OperationKind::Powi(power) => self.push(Operation::Powi(first, power)),
            OperationKind::Function(name) => self.push(called(name, first)),
            OperationKind::Binary(binary) => self.push(match binary {
                Binary::Add => Operation::Add(first, second),
                Binary::Sub => Operation::Sub(first, second),
                Binary::Mul => Operation::Mul(first, second),
                Binary::Div => Operation::Div(first, second),
                Binary::Powf => Operation::Function2(powf, first, second),
                Binary::Atan2 => Operation::Function2(atan2, first, second),
            }),
            OperationKind::Pair(one, other) => {
                let third = self.at(c);
                let one = self.push(match one {
                    First::Add => Operation::Add(first, second),
                    First::Sub => Operation::Sub(first, second),
                    First::Mul => Operation::Mul(first, second),
                });
                self.push(match other {
                    Second::Add => Operation::Add(one, third),
                    Second::From => Operation::Sub(third, one),
                    Second::Sub => Operation::Sub(one, third),
                    Second::Mul => Operation::Mul(one, third),
                })
            }
            OperationKind::Select(comparison) => {
                let [b, c, d] = more.get(b as usize).copied().unwrap_or([0; 3]);
                let parts = [a, b, c, d].map(|place| self.at(place));
                self.push(match comparison {
                    Comparison::Less => Operation::Less(parts),
                    Comparison::LessOrEqual => Operation::LessOrEqual(parts),
                })
            }
            OperationKind::Call(which) => self.push(Operation::Call(which, first)),
            OperationKind::Datum(which) => self.push(Operation::Datum(which)),
        };
        if let Operand::Result(of) = result {
            self.held.insert(to, of);
        }
    }
}

/// A program as operations on results instead of places; only its final results have places.
fn translated(straight: &Straight) -> Result<Program, JitError> {
    let mut translation = Translation::default();
    let mut rest = straight.operations.iter();
    for Batch { kind, count } in &straight.batches {
        for operation in rest.by_ref().take(*count as usize) {
            translation.add(*kind, *operation, &straight.more);
        }
    }
    let moved = straight.moves.iter().map(|&[from, to]| (from, to));
    let wanted = straight.results.iter().map(|&place| (place, place));
    let mut results: Vec<(Operand, u32)> = moved
        .chain(wanted)
        .map(|(from, to)| (translation.at(from), to))
        .filter(|&(from, to)| from != Operand::Place(to))
        .collect();
    // each place once
    results.sort_by_key(|&(_, to)| to);
    results.dedup_by_key(|&mut (_, to)| to);
    Program::new(&translation.operations, &results)
}

macro_rules! functions {
    ($($name:ident: $function:ident),* $(,)?) => {
        $(
            extern "C" fn $function(a: f64) -> f64 {
                function(Function::$name, a)
            }
        )*

        /// The operation of a function. Those that the processor computes itself are exact or rounded as the
        /// function.
        fn called(name: Function, a: Operand) -> Operation {
            match name {
                Function::Sqrt => Operation::Sqrt(a),
                Function::Abs => Operation::Abs(a),
                Function::Signum => Operation::Signum(a),
                Function::Sin => Operation::Sin(a),
                Function::Cos => Operation::Cos(a),
                $(Function::$name => Operation::Function($function, a),)*
            }
        }
    };
}

functions!(
    Cbrt: cbrt,
    Exp: exp,
    ExpM1: exp_m1,
    Ln: ln,
    Ln1p: ln_1p,
    Tan: tan,
    Asin: asin,
    Acos: acos,
    Atan: atan,
    Sinh: sinh,
    Cosh: cosh,
    Tanh: tanh,
    Asinh: asinh,
    Acosh: acosh,
    Atanh: atanh,
);

extern "C" fn powf(a: f64, b: f64) -> f64 {
    a.powf(b)
}

extern "C" fn atan2(a: f64, b: f64) -> f64 {
    a.atan2(b)
}
